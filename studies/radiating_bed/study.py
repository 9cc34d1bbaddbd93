"""Heat through a packed bed between two plates by P1, two-flux and the Rosseland
conductivity, over its thickness.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.radiation.thickness import estimate
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
LENGTHS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
LEVELS = {
    "p1": ("P1", "-", gallery.BLACK),
    "rosseland": ("Rosseland", "--", gallery.BLUE),
    "two_flux": ("two-flux", ":", gallery.VERMILION),
}
THIN = 0.02  # length of the bed whose temperatures are drawn [m]


def heat(length: float, level: str) -> tuple[float, cb.Scene]:
    """Heat from the hot plate [W/m2] and the scene."""
    scene = cb.load(
        HERE / "bed.toml", {"mesh.length": length, "radiation.level": level}
    )
    return cb.run(scene).qoi["heat_left_W"], scene


def reference(scene: cb.Scene) -> float:
    """Error of Rosseland that `contbed check` warns of [1]."""
    return float(estimate(scene, scene.mesh))


def compute() -> Tables:
    """Heat by every level."""
    rows = []
    for length in LENGTHS:
        found = {level: heat(length, level) for level in LEVELS}
        q, scene = found["p1"]
        tau = (
            1.5
            * (1 - scene.packed_bed.porosity)
            / scene.packed_bed.porosity
            * length
            / scene.diameter
        )
        ratios = (found[level][0] / q for level in ("two_flux", "rosseland"))
        rows.append((length, tau, q, *ratios, reference(scene)))
    columns = {
        "length [m]": "g",
        "tau [1]": ".1f",
        "P1 [W/m2]": ".2f",
        "two-flux over P1": ".4f",
    }
    columns |= {
        "Rosseland over P1": ".4f",
        "stated error of Rosseland": ".4f",
    }
    profiles, x = [], THIN * (1 - np.cos(np.linspace(0, np.pi, 61))) / 2
    for level in LEVELS:
        found = cb.run(
            cb.load(HERE / "bed.toml", {"mesh.length": THIN, "radiation.level": level})
        ).profiles
        profiles += [
            (level, *row)
            for row in zip(
                x, np.interp(x, found["x [m]"], found["T_solid [K]"]), strict=True
            )
        ]
    return {
        "levels": Table(columns, rows),
        "profiles": Table(
            {"level": "", "x [m]": ".5g", "T_solid [K]": ".6g"}, profiles
        ),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures of a thin bed by each level, and how far the levels are from P1
    over the thickness.
    """
    figure, (left, right) = gallery.figure(1, 2, size=(10.5, 4.2))
    for level, (text, dashes, colour) in LEVELS.items():
        p = tables["profiles"].where({"level": level})
        left.plot(1e3 * p["x [m]"], p["T_solid [K]"], dashes, color=colour, label=text)
    left.set(
        xlabel="x [mm]",
        ylabel=gallery.label("T_solid"),
        title="four particles thick",
        xlim=(0, 1e3 * THIN),
    )
    left.legend()
    found = tables["levels"]
    tau = found["tau [1]"]
    right.loglog(
        tau,
        found["Rosseland over P1"] - 1,
        "o-",
        color=gallery.BLUE,
        label="Rosseland minus P1",
    )
    right.loglog(
        tau, found["stated error of Rosseland"], "k--", label="error that plan states"
    )
    right.loglog(
        tau,
        1 - found["two-flux over P1"],
        "s-",
        color=gallery.VERMILION,
        label="P1 minus two-flux",
    )
    right.axhline(0.01, color="0.6", linewidth=0.8)
    right.set(xlabel=r"optical thickness $\tau$", ylabel="heat, relative to P1")
    right.legend(loc="lower left")
    return {"levels": figure}
