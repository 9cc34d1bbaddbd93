"""Time, memory and iterations against unknowns and ranks.

Runs of DOLFINx take the environment of `make dolfinx`; runs that are in the table
already are kept. Each run is a process of its own with one thread a rank. `cases` names
scenes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.timing import ONE_THREAD

HERE = Path(__file__).parent
PLANE = [(42, 14), (73, 24), (133, 44), (232, 76), (420, 140)]
SPACE = [(8,) * 3, (12,) * 3, (16,) * 3, (24,) * 3, (32,) * 3, (40,) * 3]
RUNS = (
    [
        ("plane", n, engine, ranks)
        for n in PLANE
        for engine, ranks in (("skfem", 1), ("dolfinx", 1), ("dolfinx", 2))
    ]
    + [("space", n, "dolfinx", ranks) for n in SPACE for ranks in (1, 2)]
    + [("space", n, "skfem", 1) for n in SPACE[:5]]
    + [
        ("flow_space", (n,) * 3, "dolfinx", ranks)
        for n in (8, 12, 16)
        for ranks in (1, 2)
    ]
    + [("flow_space", (20,) * 3, "dolfinx", 1)]
)
COLUMNS = ("scene", "cells", "engine", "ranks", "unknowns", "cpu_s", "cpu_largest_s", "wall_s", "setup_s", "solve_s",
           "memory_GB", "memory_leader_GB", "iterations")  # fmt: skip
RUN = COLUMNS[:4]
NOT_COMPARED = COLUMNS[5:]
DOLFINX = HERE.parents[1] / ".venv-dolfinx" / "bin" / "python"
STYLES = {
    ("skfem", "1"): (gallery.BLACK, "o", "scikit-fem"),
    ("dolfinx", "1"): (gallery.BLUE, "s", "DOLFINx, 1 rank"),
    ("dolfinx", "2"): (gallery.VERMILION, "^", "DOLFINx, 2 ranks"),
}
TITLES = {"plane": "2-D: flow and heat, direct", "space": "3-D: heat, multigrid"}
ENVIRONMENT = ONE_THREAD | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
}


def reference() -> Table:
    """The committed runs of scikit-fem, the default engine, with which DOLFINx is
    compared.
    """
    return Table.read(HERE / "scaling.csv").where({"engine": "skfem"})


def measured(
    scene: str, cells: tuple[int, ...], engine: str, ranks: int
) -> tuple[Any, ...]:
    """One run as a row of the table."""
    size = f"mesh.cells={list(cells)}"
    python = sys.executable if engine == "skfem" else str(DOLFINX)
    with tempfile.TemporaryDirectory() as out:
        command = [
            python,
            "-m",
            "contbed",
            "run",
            str(HERE / f"{scene}.toml"),
            "--quiet",
            "--out",
            out,
        ]
        command += ["--engine", engine, "--set", size]
        if ranks > 1:
            command = ["mpirun", "-n", str(ranks), *command]
        start = time.perf_counter()
        child = subprocess.Popen(command, env=os.environ | ENVIRONMENT)
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.perf_counter() - start
        if status:
            raise RuntimeError(
                f"{scene} {cells} {engine} {ranks}: exit "
                f"{os.waitstatus_to_exitcode(status)}"
            )
        summary = json.loads((Path(out) / "summary.json").read_text())
    taken = summary.get("engine") or {
        "cpu_s": [usage.ru_utime + usage.ru_stime],
        "iterations": [],
        "memory_GB": [1.024e-6 * usage.ru_maxrss],
    }
    timings = summary["timings"]
    many = [k for k in taken["iterations"] if k > 1]
    return (
        scene,
        "x".join(map(str, cells)),
        engine,
        ranks,
        sum(summary["dofs"].values()),
        round(sum(taken["cpu_s"]), 2),
        round(max(taken["cpu_s"]), 2),
        round(wall, 1),
        round(timings["plan"] + timings.get("heat setup", 0.0), 2),
        round(timings.get("flow", 0.0) + timings.get("heat", 0.0), 2),
        round(sum(taken["memory_GB"]), 3),
        round(taken["memory_GB"][0], 3),
        max(many, default=None),
    )


def compute(cases: Sequence[str] = ("plane", "space", "flow_space")) -> Tables:
    """All runs that are not in the table yet, small ones first."""
    table = Table.read(HERE / "scaling.csv")
    done = {row[:4] for row in table.rows}
    for scene, cells, engine, ranks in sorted(
        RUNS, key=lambda run: run[1][0] * run[1][-1] ** (len(run[1]) - 1)
    ):
        name = scene, "x".join(map(str, cells)), engine, str(ranks)
        if (
            scene in cases
            and name not in done
            and (engine == "skfem" or DOLFINX.exists())
        ):
            row = measured(scene, cells, engine, ranks)
            table = table.updated(Table(dict.fromkeys(COLUMNS, ""), [row]), RUN)
            print(*row, flush=True)
    return {"scaling": table}


def plot(tables: Tables) -> dict[str, Any]:
    """Processor time and memory over unknowns, one panel for each scene."""
    figure, axes = gallery.figure(2, 2, size=(9, 7), sharex="col")
    for column, (scene, title) in zip(axes.T, TITLES.items(), strict=True):
        for (engine, ranks), (colour, marker, text) in STYLES.items():
            found = tables["scaling"].where(
                {"scene": scene, "engine": engine, "ranks": ranks}
            )
            order = found["unknowns"].argsort()
            n = found["unknowns"][order]
            column[0].loglog(
                n, found["cpu_s"][order], color=colour, marker=marker, label=text
            )
            column[1].loglog(n, found["memory_GB"][order], color=colour, marker=marker)
        column[0].set_title(title)
        column[1].set_xlabel("unknowns")
    axes[0, 0].set_ylabel("processor time of all ranks [s]")
    axes[1, 0].set_ylabel("memory of all ranks [GB]")
    axes[0, 0].legend()
    for axis in axes.ravel():
        axis.grid(alpha=0.3)
    return {"scaling": figure}
