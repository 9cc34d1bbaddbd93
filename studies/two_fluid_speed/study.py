"""CPU of a simulated second of a riser and of a bubbling bed, contbed beside OpenFOAM's twoPhaseEulerFoam.

    python study.py            both programs; the peer needs the Debian package `openfoam`

Same mesh, closures, walls, initial state and largest Courant number; one process with one thread each. Compilation and
the peer's meshing are left out. Writes results.csv.
"""

from __future__ import annotations

import csv
import sys
import tempfile
import time
from pathlib import Path

import openfoam

import contbed as cb
from contbed.two_fluid import results as findings

HERE = Path(__file__).parent
STUDIES = HERE.parent
EMPTY = {"initial.eps_s": 0.0, "initial.u_gas": 0.0, "initial.u_solid": 0.0, "initial.noise": 0.0}
COURANT = 0.5
COLUMNS = ("case", "program", "courant", "simulated_s", "cpu_s", "steps", "ms_per_step", "cpu_per_s", "mass_drift")

CASES = {
    "riser 15x350": (
        openfoam.Case("riser", 15, 350, 3.0, 3.2, solids=26.6, walls="jj"),
        STUDIES / "vaishali_2007" / "ff_wenyu.toml",
        EMPTY,
    ),
    "bed 56x200": (
        openfoam.Case("bed", 56, 200, 3.0, 0.46, drag="SyamlalOBrien", walls="noslip"),
        STUDIES / "taghipour_bed" / "bed_0.46_fine.toml",
        {"initial.noise": 0.0, "initial.layer": [{"end": 0.4, "eps_s": 0.6, "u_gas": 1.15}]},
    ),
}


def own(scene: Path, changes: dict, end: float) -> dict[str, float]:
    """CPU of contbed's steps; a few before, so that everything is compiled."""
    for until in (1e-4, end):
        chosen = {**changes, "time.courant": COURANT, "time.end": until, "time.average_from": 0.0}
        bed, _ = cb.plan(cb.load(scene, chosen)).bed()
        held = findings.held(bed)
        start = time.process_time()
        bed.advance(until)
        cpu = time.process_time() - start
    drift = findings.balances(bed, {"solids": held})["solids"]["relative_residual"]
    return {"cpu_s": cpu, "steps": bed.state.steps, "mass_drift": drift}


def main() -> None:
    rows = []
    for name, (case, scene, changes) in CASES.items():
        done = {"contbed": own(scene, changes, case.end)}
        if openfoam.available():
            with tempfile.TemporaryDirectory() as folder:
                peer = openfoam.run(case, Path(folder))
            # a riser that fills has nothing to compare its inventory with
            drift = float("nan") if case.riser else peer["mass_drift_relative"]
            done["twoPhaseEulerFoam"] = {**peer, "mass_drift": drift}
        for program, r in done.items():
            rows.append(
                [
                    name,
                    program,
                    COURANT,
                    case.end,
                    r["cpu_s"],
                    int(r["steps"]),
                    1e3 * r["cpu_s"] / r["steps"],
                    r["cpu_s"] / case.end,
                    r["mass_drift"],
                ]
            )
            print(*(f"{value:.4g}" if isinstance(value, float) else value for value in rows[-1]), flush=True)
    with open(HERE / "results.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([f"{value:.5g}" if isinstance(value, float) else value for value in row] for row in rows)


if __name__ == "__main__":
    sys.exit(main())
