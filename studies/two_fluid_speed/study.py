"""CPU of a simulated second of a riser and of a bubbling bed, contbed beside OpenFOAM's
twoPhaseEulerFoam.

Same mesh, closures, walls, initial state and largest Courant number; one process with
one thread each. Compilation and the peer's meshing are left out.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.two_fluid import results as findings
from studies import _gallery as gallery
from studies._gallery import Table, Tables, openfoam

HERE = Path(__file__).parent
STUDIES = HERE.parent
EMPTY = {
    "initial.solids.beads.volume_fraction": 0.0,
    "initial.gas.velocity": 0.0,
    "initial.solids.beads.velocity": 0.0,
    "initial.noise": 0.0,
}
COURANT = 0.5
OWN = "contbed"
NOT_COMPARED = ("cpu_s", "steps", "ms_per_step", "cpu_per_s", "mass_drift")
COLUMNS = dict.fromkeys(
    ("case", "program", "courant", "simulated_s", *NOT_COMPARED), ".5g"
) | {"steps": "d"}
CASES: dict[str, tuple[openfoam.Case, Path, dict[str, Any]]] = {
    "riser 15x350": (
        openfoam.Case("riser", 15, 350, 3.0, 3.2, solids=26.6, walls="jj"),
        STUDIES / "vaishali_2007" / "ff_wenyu.toml",
        EMPTY,
    ),
    "bed 56x200": (
        openfoam.Case("bed", 56, 200, 3.0, 0.46, drag="SyamlalOBrien", walls="noslip"),
        STUDIES / "taghipour_bed" / "bed_0.46_fine.toml",
        {
            "initial.noise": 0.0,
            "initial.layer": [
                {
                    "end": 0.4,
                    "solids": {"beads": {"volume_fraction": 0.6}},
                    "gas": {"velocity": 1.15},
                }
            ],
        },
    ),
}


def own(scene: Path, changes: dict[str, Any], end: float) -> dict[str, float]:
    """CPU of contbed's steps; a few before, so that everything is compiled."""
    for until in (1e-4, end):
        chosen = {
            **changes,
            "time.courant": COURANT,
            "time.end": until,
            "time.average_from": 0.0,
        }
        bed, _ = cb.plan(cb.load(scene, chosen)).bed()
        held = findings.held(bed)
        start = gallery.user_time()
        bed.advance(until)
        cpu = gallery.user_time() - start
    drift = findings.balances(bed, {"solids": held})["solids"]["relative_residual"]
    return {"cpu_s": cpu, "steps": bed.state.steps, "mass_drift": drift}


def reference(case: openfoam.Case) -> dict[str, float]:
    """The same of the peer."""
    with tempfile.TemporaryDirectory() as folder:
        found = openfoam.run(case, Path(folder))
    # a riser that fills has nothing to compare its inventory with
    return {
        **found,
        "mass_drift": math.nan if case.riser else found["mass_drift_relative"],
    }


def compute() -> Tables:
    """Both programs; the committed rows of the peer are kept where it is not
    installed.
    """
    rows = []
    for name, (case, scene, changes) in CASES.items():
        done = {OWN: own(scene, changes, case.end)}
        if openfoam.available():
            done[openfoam.SOLVER] = reference(case)
        for program, r in done.items():
            cpu, steps = r["cpu_s"], int(r["steps"])
            rows.append(
                (
                    name,
                    program,
                    COURANT,
                    case.end,
                    cpu,
                    steps,
                    1e3 * cpu / steps,
                    cpu / case.end,
                    r["mass_drift"],
                )
            )
    return {
        "results": Table.read(HERE / "results.csv").updated(
            Table(COLUMNS, rows), ["case", "program"]
        )
    }


def plot(tables: Tables) -> dict[str, Any]:
    """CPU of a simulated second, and of a step."""
    figure, panels = gallery.figure(1, 2)
    table, places = tables["results"], np.arange(len(CASES))
    for program, colour, shift in (
        (OWN, gallery.BLUE, -0.2),
        (openfoam.SOLVER, gallery.VERMILION, 0.2),
    ):
        found = table.where({"program": program})
        for axes, column in zip(panels, ("cpu_per_s", "ms_per_step"), strict=True):
            axes.bar(places + shift, found[column], 0.4, color=colour, label=program)
            axes.set_xticks(places, list(CASES))
    panels[0].set_ylabel("CPU of a simulated second [s]")
    panels[1].set_ylabel("CPU of a step [ms]")
    panels[0].legend()
    return {"speed": figure}
