"""The hard corners of the steady two-energy equations: 50 graded cells against the
exact solution of a finite bed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple, dataclass, fields
from itertools import product
from typing import Any

import numpy as np

import contbed as cb
from contbed.loading import from_dict
from studies import _gallery as gallery
from studies._exact.finite_length import finite_length
from studies._gallery import Table, Tables

CELLS = 50
TOLERANCE = 1e-3  # of theta, error and overshoot
PECLET = (1e-3, 1e-1, 1e1, 1e3, 1e6)
NTU = (1e-2, 1.0, 1e2, 1e4, 1e6)
RATIO = (1.0, 1e2, 1e4)
SLIP = (-2.0, -1.0, -0.25, 0.0, 0.5, 0.95)
NOT_COMPARED = ("error", "overshoot")
INSULATING = ("none", "fluid", "solid", "both")


@dataclass(frozen=True)
class Case:
    """One bed: Peclet number of a uniform cell, ha L/C_fluid, K_solid/K_fluid,
    C_solid/C_fluid, which phases do not conduct.
    """

    peclet: float
    ntu: float
    ratio: float
    slip: float
    insulating: str


def cases() -> Iterator[Case]:
    """The whole table; a number that has no meaning where a phase does not conduct
    takes its first value only.
    """
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
        "d_solid": 0.0
        if case.insulating in ("solid", "both")
        else d_fluid * case.ratio,
        "ha": case.ntu,
    }


def scene(case: Case) -> dict[str, Any]:
    """The scene of a case: fluid enters at 300 K, solid at 400 K."""
    c, diameter = coefficients(case), 0.1
    area = 6.0 * 0.5 / diameter
    solid_inlet = "right" if case.slip < 0 else "left"
    boundary: dict[str, Any] = {
        "left": {"gas": {"velocity": 1.0, "fixed_temperature": 300.0}}
    }
    solids = {"velocity": abs(case.slip), "fixed_temperature": 400.0}
    boundary.setdefault(solid_inlet, {})["solids"] = {"particles": solids}
    return {
        "mesh": {"type": "line", "length": 1.0, "cells": CELLS, "graded": True},
        "gas": {
            "density": 1.0,
            "heat_capacity": 1.0,
            "conductivity": 1.0,
            "viscosity": 1.0,
        },
        "solids": {
            "particles": {
                "density": 1.0,
                "heat_capacity": 1.0,
                "conductivity": 1.0,
                "diameter": diameter,
            }
        },
        "packed_bed": {"porosity": 0.5},
        "closures": {
            "nusselt": case.ntu * diameter / area,
            "conductivity_gas": c["d_fluid"],
            "conductivity_solids": c["d_solid"],
        },
        "heat": {},
        "boundary": boundary,
    }


def reference(case: Case, x: Any) -> tuple[Any, Any]:
    """Exact theta of fluid and solid of a finite bed at x."""
    fluid, solid = finite_length(x, 1.0, **coefficients(case))
    return fluid, solid


def measure(case: Case) -> tuple[float, float]:
    """Largest error of theta in both phases and largest overshoot."""
    result = cb.run(from_dict(scene(case)))
    profiles = result.profiles
    found = profiles["theta_fluid [1]"], profiles["theta_solid [1]"]
    exact = reference(case, profiles["x [m]"])
    error = max(float(np.abs(a - b).max()) for a, b in zip(found, exact, strict=True))
    return error, result.qoi["theta_overshoot"]


def missed(table: Table) -> list[str]:
    """Cases that are beyond the tolerance."""
    worst = np.maximum(table["error"], table["overshoot"])
    return [
        ",".join(row)
        for row, value in zip(table.rows, worst, strict=True)
        if not value <= TOLERANCE
    ]


def compute() -> Tables:
    """Error and overshoot of all cases; those that miss the tolerance are printed."""
    columns = dict.fromkeys((field.name for field in fields(Case)), "") | {
        "error": ".2e",
        "overshoot": ".2e",
    }
    table = Table(columns, [(*astuple(case), *measure(case)) for case in cases()])
    print(
        *missed(table),
        f"largest error {table['error'].max():.2e}, overshoot "
        f"{table['overshoot'].max():.2e}",
        sep="\n",
    )
    return {"stress": table}


def plot(tables: Tables) -> dict[str, Any]:
    """Worst error over conductivity ratio and insulation, by Peclet number and NTU,
    one panel for each slip.
    """
    table = tables["stress"]
    peclet, ntu, slip, error = (
        table[name] for name in ("peclet", "ntu", "slip", "error")
    )
    figure, panels = gallery.figure(2, 3, size=(9.5, 6.0), sharex=True, sharey=True)
    for panel, value in zip(panels.flat, SLIP, strict=True):
        worst = np.array(
            [
                [
                    error[(peclet == p) & (ntu == n) & (slip == value)].max()
                    for p in PECLET
                ]
                for n in NTU
            ]
        )
        image = panel.imshow(
            np.log10(worst), origin="lower", vmin=-8, vmax=-3, aspect="auto"
        )
        for (i, j), number in np.ndenumerate(worst):
            how = {
                "ha": "center",
                "va": "center",
                "fontsize": 7,
                "color": "black" if number > 1e-5 else "white",
            }
            panel.text(j, i, f"{number:.0e}", **how)
        panel.set_title(rf"$C_\mathrm{{s}}/C_\mathrm{{f}}$ = {value:g}")
        panel.set_xticks(range(len(PECLET)), [f"{v:g}" for v in PECLET])
        panel.set_yticks(range(len(NTU)), [f"{v:g}" for v in NTU])
    figure.supxlabel("Peclet number of a uniform cell")
    figure.supylabel("NTU")
    figure.colorbar(
        image, ax=panels, label=r"$\log_{10}$ of the largest error of $\theta$"
    )
    return {"stress": figure}
