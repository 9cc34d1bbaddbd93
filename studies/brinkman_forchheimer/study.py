"""Developed Brinkman-Forchheimer flow around a bed that slides along a channel,
against the exact solution.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.packed_bed.recognition import velocities
from studies import _exact as exact
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
SCENES = {
    "slip_0.00_darcy": ("$u_s = 0$, $c_F = 0$", gallery.BLACK),
    "slip_0.00": ("$u_s = 0$", gallery.BLUE),
    "slip_0.50": (r"$u_s = 0.5\, u_D$", gallery.VERMILION),
    "slip_0.95": (r"$u_s = 0.95\, u_D$", gallery.GREEN),
    "slip_-0.25": (r"$u_s = -0.25\, u_D$", gallery.PURPLE),
}
# cells across the channel besides those of the scene
ACROSS = (16, 24, 32, 48, 64, 96, 128)
ERRORS = {
    "error of u_max [1]": "the largest velocity",
    "error of dp/dx [1]": "the pressure gradient",
}
NOT_COMPARED = tuple(ERRORS)


def reference(scene: cb.Scene, y: Any = 0.0) -> Any:
    """Exact developed flow at the distance y [m] from a wall, from the values in the
    scene.
    """
    closures = scene.closures
    (u, _), (u_solid, _) = velocities(scene)
    return exact.brinkman_forchheimer_channel(
        y,
        scene.mesh.height,
        float(u),
        float(u_solid),
        scene.gas.viscosity,
        scene.gas.density,
        closures.permeability,
        closures.forchheimer,
        scene.packed_bed.porosity,
    )


def errors(scene: cb.Scene, result: cb.Result) -> tuple[float, float]:
    """Relative errors of the largest velocity at the outlet and of the pressure
    gradient.
    """
    wanted = reference(scene)
    return (
        result.qoi["u_max_outlet"] / wanted.u_max - 1,
        scene.packed_bed.porosity
        * result.qoi["pressure_gradient_Pa_m"]
        / wanted.pressure_gradient
        - 1,
    )


def with_cells(scene: cb.Scene, across: int) -> cb.Scene:
    """The scene with another number of cells across the channel."""
    mesh = scene.mesh.model_copy(update={"cells": (scene.mesh.cells[0], across)})
    return scene.model_copy(update={"mesh": mesh})


def compute() -> Tables:
    """Every scene on coarser meshes and on its own."""
    rows = []
    for name in SCENES:
        scene = cb.load(HERE / f"{name}.toml")
        viscosity, height = scene.gas.viscosity, scene.mesh.height
        u, u_solid = (float(vector[0]) for vector in velocities(scene))
        for across in sorted(
            {*(n for n in ACROSS if n < scene.mesh.cells[1]), scene.mesh.cells[1]}
        ):
            result = cb.run(with_cells(scene, across))
            gradient = (
                scene.packed_bed.porosity
                * result.qoi["pressure_gradient_Pa_m"]
                * height**2
                / (viscosity * u)
            )
            case = name, u_solid / u, scene.closures.forchheimer, across
            rows.append(
                (
                    *case,
                    result.qoi["u_max_outlet"] / u,
                    gradient,
                    *errors(scene, result),
                )
            )
    columns = {"scene": "", "u_s/u_D [1]": "g", "c_F [1]": "g", "cells across": "d"}
    columns |= {
        "u_max/u_D [1]": ".11f",
        "P* [1]": ".8f",
        **dict.fromkeys(ERRORS, ".1e"),
    }
    return {"results": Table(columns, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """Exact profiles, and both errors over the number of cells."""
    figure, (left, *others) = gallery.figure(1, 3)
    for name, (text, colour) in SCENES.items():
        scene = cb.load(HERE / f"{name}.toml")
        eta = np.linspace(0, 0.5, 501) ** 2 * 2
        left.plot(
            eta,
            reference(scene, eta * scene.mesh.height).u
            / scene.boundary["left"].gas.velocity,
            color=colour,
            label=text,
        )
        found = tables["results"].where({"scene": name})
        for axes, error in zip(others, ERRORS, strict=True):
            axes.loglog(found["cells across"], np.abs(found[error]), "o-", color=colour)
    for axes, what, start in zip(others, ERRORS.values(), (1e-5, 1e-3), strict=True):
        gallery.order_line(axes, (40, 160), start, 4)
        axes.axhline(1e-8, color="grey", linewidth=0.8)
        axes.set(
            xlabel="cells across the channel",
            ylim=(1e-11, 1e-1),
            title=f"relative error of {what}",
        )
        gallery.ticks(axes, x=(16, 32, 64, 128, 256))
    left.set(
        xlabel="y/H",
        ylabel="$u/u_D$",
        xlim=(0, 0.5),
        ylim=(0, 1.2),
        title="exact profiles",
    )
    left.legend(loc="lower right")
    return {"convergence": figure}
