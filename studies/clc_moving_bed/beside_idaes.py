"""The moving bed beside IDAES: user CPU against error, each beside shooting of its
own equations.
"""

from __future__ import annotations

import json
import math
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.loading import load
from contbed.many.bench import time_at
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies.clc_moving_bed.shooting import AS_CODED, Bed
from studies.clc_moving_bed.study import HERE, RESULTS

SCENE = HERE / "iron_oxide.toml"
PARTS = ("build_s", "initialize_s", "solve_s", "ipopt_s")  # user CPU of IDAES
DIAMETER = 6.5  # of the vessel [m]; no result depends on it
OWN = "contbed"
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8)
SAMPLES, OWN_SAMPLES = 3, 7
WANTED = (1e-2, 1e-3, 1e-4, 1e-6)  # errors at which the times are compared
# Radau points in an element, 0 for backward differences, and ends of elements
Runs = list[tuple[int, list[float]]]


def even(points: int, *counts: int) -> Runs:
    """Runs of equal elements."""
    return [(points, np.linspace(0.0, 1.0, count + 1).tolist()) for count in counts]


def graded(points: int, length: float, *sizes: tuple[float, float, float]) -> Runs:
    """Runs of elements that grow from the gas inlet: the first, how much longer the
    next is, the longest [m, 1, m].
    """
    runs = []
    for first, growth, longest in sizes:
        elements = [first]
        while sum(elements) < length:
            elements.append(min(growth * elements[-1], longest))
        ends = np.cumsum([0.0, *elements])
        runs.append((points, [*(ends[:-1] / ends[-1]).tolist(), 1.0]))
    return runs


def curves(length: float) -> dict[str, Runs]:
    """Discretizations of IDAES; the graded ones were sought by hand."""
    return {
        "IDAES, backward differences": even(0, 5, 10, 20, 40, 80),
        "IDAES, 3 Radau points": even(3, 6, 10, 20, 40, 80),
        "IDAES, 3 Radau points, graded": graded(
            3,
            length,
            (5e-3, 5.0, 1.5),
            (1e-2, 3.0, 1.0),
            (1e-3, 2.0, 0.5),
            (1e-4, 1.5, 0.15),
        ),
        "IDAES, 5 Radau points, graded": graded(
            5,
            length,
            (1e-3, 10.0, 4.0),
            (1e-3, 3.0, 1.5),
            (1e-3, 2.5, 1.0),
            (5e-4, 2.0, 0.5),
        ),
    }


def reference(bed: Bed) -> dict[str, float]:
    """Results by shooting."""
    return bed.solve()


def error_of(found: Any, exact: dict[str, float]) -> float:
    """Largest relative error of the results."""
    return max(abs(found[key] / exact[key] - 1.0) for key in RESULTS)


def own(exact: dict[str, float]) -> list[dict[str, Any]]:
    """The scene with several tolerances, read and run."""
    levels = {
        f"tolerance {tolerance:.0e}": {"solver.tolerance": tolerance}
        for tolerance in TOLERANCES
    }
    calls = {
        level: lambda changes=changes: cb.run(load(SCENE, changes))
        for level, changes in levels.items()
    }
    rows = []
    for level, (seconds, result) in gallery.in_turn(calls, OWN_SAMPLES).items():
        found = {key: result.qoi[key] for key in RESULTS}
        rows.append(
            {
                "code": OWN,
                "level": level,
                **found,
                "error": error_of(found, exact),
                "cpu_s": seconds,
            }
        )
    return rows


def peer(bed: Bed, chosen: dict[str, Runs]) -> list[dict[str, Any]]:
    """Runs of IDAES, which solves the equations that `AS_CODED` names."""
    exact, area = reference(bed.changed(**AS_CODED)), math.pi * DIAMETER**2 / 4.0
    solids = bed.solids(0.0)
    inputs = {
        "length": bed.length,
        "diameter": DIAMETER,
        "gas": {name: area * flux for name, flux in bed.gas.items()},
        "pressure": bed.pressure,
        "T_gas": bed.T_gas,
        "T_solid": bed.T_solid,
        "solids": area * sum(flux * bed.masses[name] for name, flux in solids.items()),
        "fractions": dict(bed.fractions),
        "porosity": bed.particle_porosity,
        "samples": SAMPLES,
    }
    rows = []
    for code, runs in chosen.items():
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "inputs.json").write_text(
                json.dumps(inputs | {"runs": runs}), encoding="utf-8"
            )
            gallery.cpu_of(
                [sys.executable, str(HERE / "moving_bed_idaes.py"), "inputs.json"],
                folder,
            )
            lines = (folder / "printed").read_text(encoding="utf-8").splitlines()
        printed = [json.loads(line) for line in lines if line.startswith("{")]
        for (_, ends), found in zip(runs, printed, strict=True):
            total = sum(found[part] for part in PARTS[:3])
            level = f"{len(ends) - 1} elements"
            rows.append(
                {
                    "code": code,
                    "level": level,
                    **found,
                    "error": error_of(found, exact),
                    "cpu_s": total,
                }
            )
    return rows


COLUMNS = {
    "code": "", "level": "", "unknowns": "d", "conversion_CH4": ".10g", "conversion_Fe2O3": ".10g",
    "pressure_drop_Pa": ".10g", "T_solid_out_K": ".10g", "error": ".2e", "cpu_s": ".3g", **dict.fromkeys(PARTS, ".3g"),
}  # fmt: skip
NOT_COMPARED = ("error", "cpu_s", *PARTS, "times_contbed", "solve_s_times_contbed")


def equal_errors(runs: Table) -> Table:
    """User CPU at the same error, where a code reaches it; and that of the last
    solution of IDAES by itself.
    """
    rows: list[tuple[Any, ...]] = []
    codes = {name: runs.where({"code": name}) for name in runs.values("code")}
    for wanted in WANTED:
        first = time_at(wanted, list(codes[OWN]["cpu_s"]), list(codes[OWN]["error"]))[0]
        rows.append((wanted, OWN, first, 1.0, None))
        for name, points in codes.items():
            if name == OWN or points["error"].min() > wanted:
                continue
            whole, last = (
                time_at(wanted, list(points[key]), list(points["error"]))[0]
                for key in ("cpu_s", "solve_s")
            )
            rows.append((wanted, name, whole, whole / first, last / first))
    return Table(
        {
            "error": ".0e",
            "code": "",
            "cpu_s": ".3g",
            "times_contbed": ".3g",
            "solve_s_times_contbed": ".2g",
        },
        rows,
    )


def compute() -> Tables:
    """Both codes; the committed rows of IDAES are kept where it is not installed."""
    bed = Bed.of(load(SCENE))
    found = own(reference(bed))
    if find_spec("idaes") is not None:
        found += peer(bed, curves(bed.length))
    rows = [[row.get(name) for name in COLUMNS] for row in found]
    runs = gallery.updated(HERE, {"idaes": Table(COLUMNS, rows)}, {"idaes": ("code",)})[
        "idaes"
    ]
    return {"idaes": runs, "idaes_equal_error": equal_errors(runs)}


def plot(tables: Tables) -> dict[str, Any]:
    """User CPU over the largest relative error."""
    figure, axes = gallery.figure(size=(7.5, 4.5))
    runs = tables["idaes"]
    for name, colour, marker in zip(
        runs.values("code"), gallery.PALETTE, "osD^v", strict=False
    ):
        points = runs.where({"code": name})
        axes.loglog(
            points["error"],
            points["cpu_s"],
            "-",
            marker=marker,
            color=colour,
            label=name,
        )
        if name != OWN:
            axes.loglog(
                points["error"],
                points["solve_s"],
                ":",
                marker=marker,
                mfc="none",
                color=colour,
                lw=1.0,
            )
    axes.loglog(
        [], [], ":", color=gallery.GREY, label="IDAES, solution of an initialized model"
    )
    axes.set(xlabel="largest relative error of four results", ylabel="user CPU [s]")
    figure.legend(loc="outside right upper")
    return {"idaes": figure}
