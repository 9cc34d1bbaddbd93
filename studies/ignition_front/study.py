"""Ignition and extinction of an adiabatic bed: folds and all states, against
collocation with a fold system.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
# collocation with 72 points: ignition and extinction, conversions of the three states
# at their geometric mean
EXACT = (
    0.0737658708554,
    0.0420980604225,
    0.092833914028,
    0.583344276573,
    0.999970492403,
)
NAMES = (
    "Da of ignition",
    "Da of extinction",
    "X extinguished",
    "X between",
    "X ignited",
)
KEY = "reactions.burning.factor [1]"


def reference() -> tuple[float, ...]:
    """Folds and states by collocation."""
    return EXACT


def compute() -> Tables:
    """Folds and states beside the reference, and the branch."""
    run = cb.run(cb.load(HERE / "adiabatic_bed.toml"))
    left = sorted(run.tables["states"]["x_A_out [1]"], reverse=True)
    found = (run.qoi["fold_1"], run.qoi["fold_2"], *(1.0 - x for x in left))
    rows = [
        (name, ours, exact)
        for name, ours, exact in zip(NAMES, found, reference(), strict=True)
    ]
    branch = run.tables["continuation"]
    points = zip(
        branch[KEY],
        branch["turns [1]"],
        1.0 - branch["x_A_out [1]"],
        branch["T_fluid_out [K]"],
        strict=True,
    )
    headers = {"Da [1]": ".10g", "turns [1]": ".0f", "X [1]": ".8g", "T_out [K]": ".8g"}
    return {
        "results": Table(
            {"quantity": "", "contbed": ".10g", "collocation": ".10g"}, rows
        ),
        "branch": Table(headers, points),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Conversion over the Damkoehler number; the branch between both folds is
    dashed.
    """
    figure, axes = gallery.figure(size=(6, 4))
    branch = tables["branch"]
    Da, turns, X = branch["Da [1]"], branch["turns [1]"], branch["X [1]"]
    for turn in np.unique(turns):
        part = np.flatnonzero(turns == turn)
        part = np.append(max(part[0] - 1, 0), part)
        axes.plot(Da[part], X[part], "--" if turn % 2 else "-", color=gallery.BLUE)
    for Da_fold, name in zip(EXACT[:2], ("ignition", "extinction"), strict=True):
        axes.axvline(Da_fold, color=gallery.GREY, lw=0.8)
        axes.annotate(
            name, (Da_fold, 0.5), rotation=90, va="center", ha="right", fontsize=9
        )
    axes.set(xlabel="Da", ylabel="conversion")
    return {"branch": figure}
