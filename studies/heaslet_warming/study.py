"""Radiative equilibrium between plates: error of each level of radiation and what it
costs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from studies import _gallery as gallery
from studies._exact.radiation import P1, TWO_FLUX, equilibrium_flux, equilibrium_profile
from studies._exact.transport import Equilibrium
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
DIFFUSION = {"two_flux": TWO_FLUX, "p1": P1}
THICKNESSES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
LEVELS = (
    ("two_flux", 1),
    ("p1", 1),
    ("ordinates", 2),
    ("ordinates", 4),
    ("ordinates", 8),
    ("ordinates", 16),
)
COLOURS = {
    "two_flux": gallery.VERMILION,
    "p1": gallery.GREEN,
    "ordinates": gallery.BLUE,
}
WIDTHS = {2: 0.8, 4: 1.3, 8: 1.8, 16: 2.3}  # of the lines of ordinates
MARKS = {0.1: "v", 1.0: "o", 10.0: "s", 100.0: "^"}
NOT_COMPARED = ("error of flux [1]", "error of slip [1]", "time [s]")


def parameters(scene: cb.Scene) -> tuple[float, tuple[float, ...]]:
    """Optical thickness and emissivities of a scene."""
    table, ends = scene.radiation, (scene.boundary["left"], scene.boundary["right"])
    return (table.absorption + table.scattering) * scene.mesh.length, tuple(
        end.radiation.emissivity for end in ends
    )


def closed_form(scene: cb.Scene) -> Any:
    """flux_dimensionless and temperature_slip that the level of a scene has: P1 and
    two-flux.
    """
    tau, emissivity = parameters(scene)
    D = DIFFUSION[scene.radiation.level]
    return np.array(
        [
            equilibrium_flux(tau, D, emissivity),
            1 - equilibrium_profile(0.0, tau, D, emissivity),
        ]
    )


def reference(scene: cb.Scene) -> Any:
    """The same two numbers by transport theory."""
    found = Equilibrium(*parameters(scene))
    return np.array([found.flux, found.slip])


def found(result: cb.Result) -> Any:
    """The two numbers of a run."""
    return np.array([result.qoi["flux_dimensionless"], result.qoi["temperature_slip"]])


def variant(tau: float, level: str, ordinates: int) -> cb.Scene:
    """The scene of tau = 1 with another thickness and level."""
    share = {"absorption": 0.7, "scattering": 0.3}
    changes = {f"radiation.{key}": part * tau / 0.1 for key, part in share.items()}
    return cb.load(
        HERE / "tau_1.toml",
        changes | {"radiation.level": level, "radiation.ordinates": ordinates},
    )


def name_of(level: str, ordinates: int) -> str:
    return {"p1": "P1", "two_flux": "two-flux"}.get(
        level, f"{ordinates} + {ordinates} ordinates"
    )


def compute() -> Tables:
    """Flux, slip and run time of all levels over the thickness."""
    rows = []
    for level, ordinates in LEVELS:
        for tau in THICKNESSES:
            scene = variant(tau, level, ordinates)
            seconds, result = gallery.cpu(lambda scene=scene: cb.run(scene), samples=5)
            (flux, slip), (psi, exact_slip) = found(result), reference(scene)
            cells = result.plan.mesh.skfem.nelements
            row = (
                tau,
                name_of(level, ordinates),
                psi,
                flux,
                flux / psi - 1,
                exact_slip,
                slip / exact_slip - 1,
            )
            rows.append((*row, cells, seconds))
    columns = {
        "tau [1]": "g",
        "level": "",
        "flux exact [1]": ".10f",
        "flux [1]": ".10f",
        "error of flux [1]": ".1e",
    }
    columns |= {
        "slip exact [1]": ".10f",
        "error of slip [1]": ".1e",
        "cells": "d",
        "time [s]": ".4f",
    }
    return {"levels": Table(columns, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """Error over thickness, and over run time at four thicknesses."""
    figure, (left, right) = gallery.figure(1, 2, size=(11.5, 4.6), sharey=True)
    for level, ordinates in LEVELS:
        name, colour = name_of(level, ordinates), COLOURS[level]
        rows = tables["levels"].where({"level": name})
        errors = np.abs(rows["error of flux [1]"])
        left.loglog(
            rows["tau [1]"], errors, color=colour, linewidth=WIDTHS.get(ordinates, 1.8)
        )
        gallery.label_line(left, name, THICKNESSES[-1], errors[-1], colour, (5, 0))
        for tau, mark in MARKS.items():
            row = rows.where({"tau [1]": tau})
            size = 4 + 2 * np.log2(ordinates)
            x, y = 1e3 * row["time [s]"], np.abs(row["error of flux [1]"])
            right.semilogy(x, y, mark, color=colour, markersize=size)
    for tau, mark in MARKS.items():
        right.semilogy([], [], mark, color="0.3", label=rf"$\tau$ = {tau:g}")
    for level, _ in LEVELS[:3]:
        right.semilogy(
            [],
            [],
            "o",
            color=COLOURS[level],
            label=name_of(level, 2).replace("2 + 2 ", ""),
        )
    right.legend(loc="upper right")
    left.set(
        xlabel=r"optical thickness $\tau$",
        ylabel="relative error of the flux",
        xlim=(0.01, 100),
    )
    right.set(xlabel="run time [ms]; larger marks: more ordinates", xlim=(0, None))
    return {"levels": figure}
