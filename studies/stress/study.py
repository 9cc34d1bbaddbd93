"""The hard corners of the steady two-energy equations: 50 graded cells against the exact solution of a finite bed.

Writes stress.csv and stress.png beside this file, or into the folder given as argument.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from dataclasses import asdict, astuple, dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.loading import from_dict
from contbed.verify.exact import finite_length

CELLS = 50
TOLERANCE = 1e-3  # of theta, error and overshoot
PECLET = (1e-3, 1e-1, 1e1, 1e3, 1e6)
NTU = (1e-2, 1.0, 1e2, 1e4, 1e6)
RATIO = (1.0, 1e2, 1e4)
SLIP = (-2.0, -1.0, -0.25, 0.0, 0.5, 0.95)
INSULATING = ("none", "fluid", "solid", "both")


@dataclass(frozen=True)
class Case:
    """One bed: Peclet number of a uniform cell, ha L/C_fluid, K_solid/K_fluid, C_solid/C_fluid, which phases do not
    conduct.
    """

    peclet: float
    ntu: float
    ratio: float
    slip: float
    insulating: str


def cases() -> Iterator[Case]:
    """The whole table; a number that has no meaning where a phase does not conduct takes its first value only."""
    for insulating in INSULATING:
        peclets = PECLET[:1] if insulating == "both" else PECLET
        ratios = RATIO[:1] if insulating in ("solid", "both") else RATIO
        for values in product(peclets, NTU, ratios, SLIP):
            yield Case(*values, insulating)


def coefficients(case: Case) -> dict[str, float]:
    """Arguments of `finite_length` for a bed of length 1 and a fluid of flux 1."""
    d_fluid = 1.0 / CELLS / case.peclet
    return {
        "flux_fluid": 1.0,
        "flux_solid": case.slip,
        "d_fluid": 0.0 if case.insulating in ("fluid", "both") else d_fluid,
        "d_solid": 0.0 if case.insulating in ("solid", "both") else d_fluid * case.ratio,
        "ha": case.ntu,
    }


def scene(case: Case) -> dict[str, Any]:
    """The scene of a case: fluid enters at 300 K, solid at 400 K."""
    c, diameter = coefficients(case), 0.1
    area = 6.0 * 0.5 / diameter
    solid_inlet = "right" if case.slip < 0 else "left"
    boundary: dict[str, Any] = {"left": {"fluid": {"fixed": 300.0}}}
    boundary.setdefault(solid_inlet, {})["solid"] = {"fixed": 400.0}
    return {
        "mesh": {"type": "line", "length": 1.0, "cells": CELLS, "graded": True},
        "fluid": {"density": 1.0, "heat_capacity": 1.0, "conductivity": 1.0, "viscosity": 1.0},
        "solid": {"density": 1.0, "heat_capacity": 1.0, "conductivity": 1.0},
        "bed": {"porosity": 0.5, "particle_diameter": diameter},
        "flow": {"velocity": 1.0, "velocity_solid": case.slip},
        "heat": {
            "nusselt": case.ntu * diameter / area,
            "conductivity_fluid": c["d_fluid"],
            "conductivity_solid": c["d_solid"],
        },
        "boundary": boundary,
    }


def measure(case: Case) -> tuple[float, float]:
    """Largest error of theta in both phases and largest overshoot."""
    result = cb.run(from_dict(scene(case)))
    profiles = result.profiles
    exact = finite_length(profiles["x [m]"], 1.0, **coefficients(case))
    found = profiles["theta_fluid [1]"], profiles["theta_solid [1]"]
    error = max(float(np.abs(a - b).max()) for a, b in zip(found, exact, strict=True))
    return error, result.qoi["theta_overshoot"]


def plot(rows: list[tuple[Case, float, float]], path: Path) -> None:
    """Worst error over conductivity ratio and insulation, by Peclet number and NTU, one panel for each slip."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(2, 3, figsize=(9.5, 6.0), sharex=True, sharey=True, layout="constrained")
    for panel, slip in zip(panels.flat, SLIP, strict=True):
        worst = np.array(
            [
                [max(e for c, e, _ in rows if (c.peclet, c.ntu, c.slip) == (peclet, ntu, slip)) for peclet in PECLET]
                for ntu in NTU
            ]
        )
        image = panel.imshow(np.log10(worst), origin="lower", cmap="viridis", vmin=-8, vmax=-3, aspect="auto")
        for (i, j), value in np.ndenumerate(worst):
            panel.text(
                j, i, f"{value:.0e}", ha="center", va="center", fontsize=7, color="black" if value > 1e-5 else "white"
            )
        panel.set_title(rf"$C_\mathrm{{s}}/C_\mathrm{{f}}$ = {slip:g}", fontsize=10)
        panel.set_xticks(range(len(PECLET)), [f"{v:g}" for v in PECLET])
        panel.set_yticks(range(len(NTU)), [f"{v:g}" for v in NTU])
    figure.supxlabel("Peclet number of a uniform cell")
    figure.supylabel("NTU")
    figure.colorbar(image, ax=panels, label=r"$\log_{10}$ of the largest error of $\theta$")
    figure.savefig(path, dpi=150)
    plt.close(figure)


def main(out: Path) -> int:
    """Run the table; 1 if a case misses the tolerance."""
    rows = [(case, *measure(case)) for case in cases()]
    out.mkdir(parents=True, exist_ok=True)
    with open(out / "stress.csv", "w", newline="", encoding="ascii") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*asdict(rows[0][0]), "error", "overshoot"])
        table.writerows([*astuple(case), f"{error:.2e}", f"{overshoot:.2e}"] for case, error, overshoot in rows)
    plot(rows, out / "stress.png")
    missed = [row for row in rows if not max(row[1:]) <= TOLERANCE]
    for case, error, overshoot in missed:
        print(f"{case}: error {error:.2e}, overshoot {overshoot:.2e}")
    errors, overshoots = [row[1] for row in rows], [row[2] for row in rows]
    print(f"{len(rows)} cases, largest error {max(errors):.2e}, largest overshoot {max(overshoots):.2e}")
    return bool(missed)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent))
