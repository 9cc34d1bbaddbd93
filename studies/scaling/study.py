"""Time, memory and iterations against unknowns and ranks: `python study.py [--skfem PYTHON] [--largest N]`.

Run with the Python of the DOLFINx environment; `--skfem` is that of the default engine if another. Each run is a
process of its own with one thread a rank. Results go to scaling.csv, which is continued: finished runs are kept.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).parent
PLANE = [(42, 14), (73, 24), (133, 44), (232, 76), (420, 140)]
SPACE = [(8,) * 3, (12,) * 3, (16,) * 3, (24,) * 3, (32,) * 3, (40,) * 3]
RUNS = (
    [("plane", n, engine, ranks) for n in PLANE for engine, ranks in (("skfem", 1), ("dolfinx", 1), ("dolfinx", 2))]
    + [("space", n, "dolfinx", ranks) for n in SPACE for ranks in (1, 2)]
    + [("space", n, "skfem", 1) for n in SPACE[:3]]
    + [("flow_space", (n,) * 3, "dolfinx", ranks) for n in (8, 12, 16) for ranks in (1, 2)]
    + [("flow_space", (20,) * 3, "dolfinx", 1)]
)
COLUMNS = ("scene", "cells", "engine", "ranks", "unknowns", "cpu_s", "cpu_largest_s", "wall_s", "setup_s", "solve_s",
           "memory_GB", "memory_leader_GB", "iterations")  # fmt: skip
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
}


def measured(scene: str, cells: tuple[int, ...], engine: str, ranks: int, python: str) -> dict[str, object]:
    """One run as a row of the table."""
    with tempfile.TemporaryDirectory() as out:
        command = [
            python,
            "-m",
            "contbed",
            "run",
            HERE / f"{scene}.toml",
            "--quiet",
            "--out",
            out,
            "--engine",
            engine,
            "--set",
            f"mesh.cells={list(cells)}",
        ]
        if ranks > 1:
            command = ["mpirun", "-n", str(ranks), *command]
        start = time.perf_counter()
        child = subprocess.Popen([str(part) for part in command], env=os.environ | ENVIRONMENT)
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.perf_counter() - start
        if status:
            raise RuntimeError(f"{scene} {cells} {engine} {ranks}: exit {os.waitstatus_to_exitcode(status)}")
        summary = json.loads((Path(out) / "summary.json").read_text())
    taken = summary.get("engine") or {
        "cpu_s": [usage.ru_utime + usage.ru_stime],
        "iterations": [],
        "memory_GB": [1.024e-6 * usage.ru_maxrss],
    }
    timings = summary["timings"]
    many = [k for k in taken["iterations"] if k > 1]
    return dict(
        zip(
            COLUMNS,
            (
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
                max(many, default=""),
            ),
            strict=True,
        )
    )


def plot(rows: list[dict[str, str]]) -> None:
    """Processor time and memory over unknowns, one panel for each scene."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    styles = {
        ("skfem", "1"): ("k", "o", "scikit-fem"),
        ("dolfinx", "1"): ("tab:blue", "s", "DOLFINx, 1 rank"),
        ("dolfinx", "2"): ("tab:orange", "^", "DOLFINx, 2 ranks"),
    }
    titles = {"plane": "2-D: flow and heat, direct", "space": "3-D: heat, multigrid above 60 000"}
    figure, axes = plt.subplots(2, 2, figsize=(9, 7), sharex="col", layout="constrained")
    for k, (scene, title) in enumerate(titles.items()):
        for (engine, ranks), (colour, marker, label) in styles.items():
            found = sorted(
                (int(row["unknowns"]), float(row["cpu_s"]), float(row["memory_GB"]))
                for row in rows
                if (row["scene"], row["engine"], row["ranks"]) == (scene, engine, ranks)
            )
            if found:
                n, time, memory = zip(*found, strict=True)
                axes[0, k].loglog(n, time, color=colour, marker=marker, label=label)
                axes[1, k].loglog(n, memory, color=colour, marker=marker)
        axes[0, k].set_title(title)
        axes[1, k].set_xlabel("unknowns")
    axes[0, 0].set_ylabel("processor time of all ranks [s]")
    axes[1, 0].set_ylabel("memory of all ranks [GB]")
    axes[0, 0].legend(frameon=False)
    for axis in axes.ravel():
        axis.grid(alpha=0.3)
    figure.savefig(HERE / "scaling.png", dpi=120)


def main() -> None:
    """All runs that are not in the table yet, small ones first."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--skfem", default=sys.executable)
    parser.add_argument("--largest", type=int, default=10**6, help="cells")
    options = parser.parse_args()
    table = HERE / "scaling.csv"
    rows = list(csv.DictReader(table.open())) if table.is_file() else []
    done = {(row["scene"], row["cells"], row["engine"], int(row["ranks"])) for row in rows}
    for scene, cells, engine, ranks in sorted(RUNS, key=lambda run: run[1][0] * run[1][-1] ** (len(run[1]) - 1)):
        count = 1
        for n in cells:
            count *= n
        if (scene, "x".join(map(str, cells)), engine, ranks) in done or count > options.largest:
            continue
        python = options.skfem if engine == "skfem" else sys.executable
        rows.append({k: str(v) for k, v in measured(scene, cells, engine, ranks, python).items()})
        with table.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
        print(*rows[-1].values(), flush=True)
    plot(rows)


if __name__ == "__main__":
    main()
