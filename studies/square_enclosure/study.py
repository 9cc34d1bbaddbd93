"""Isothermal absorbing medium in a square with cold black walls: P1 on a mesh, P1 by
a spectral method, transport.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.fem.probe import Probe
from studies import _gallery as gallery
from studies._exact.radiation import square_p1, square_transport
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
THICKNESSES = ("0.1", "1", "10")
PLACES = np.array([0.1, 0.3, 0.5])  # along a wall, over its length
COLOURS = dict(
    zip(THICKNESSES, (gallery.GREEN, gallery.BLUE, gallery.VERMILION), strict=True)
)
SIDE = np.linspace(0.0, 1.0, 41)  # of the map of G, over the length
NOT_COMPARED = ("difference",)


def thickness(scene: cb.Scene) -> float:
    """kappa L of a scene."""
    return float(scene.radiation.absorption * scene.mesh.length)


def reference(x: Any, kappa_L: float) -> tuple[Any, Any]:
    """Flux to a wall over sigma T^4 at places x along it: P1 by a spectral method,
    and transport.
    """
    return square_p1(x, kappa_L), square_transport(x, kappa_L)


def wall_flux(result: cb.Result, at: Any, wall: str = "bottom") -> Any:
    """Flux to a wall over sigma T^4 at places `at` along it, over its length: G/2 on
    a cold black wall.
    """
    scene = result.plan.scene
    sizes = scene.mesh.length, scene.mesh.height
    along = 1 if wall in ("left", "right") else 0
    points = np.empty((2, len(at)))
    points[along] = sizes[along] * np.asarray(at)
    points[1 - along] = sizes[1 - along] if wall in ("right", "top") else 0.0
    space, G = result.nodal["G"]
    return (
        0.5
        * Probe(result.plan.mesh, points)(space, G)
        / (SIGMA * scene.radiation.temperature**4)
    )


def compute() -> Tables:
    """Flux along a wall at three thicknesses, and G in the square of kappa L = 1."""
    rows, profiles, x = [], [], np.linspace(0.005, 0.995, 67)
    for tau in THICKNESSES:
        result = cb.run(cb.load(HERE / f"tau_{tau}.toml"))
        for at, p1, spectral, transport in zip(
            PLACES,
            wall_flux(result, PLACES),
            *reference(PLACES, float(tau)),
            strict=True,
        ):
            rows.append(
                (
                    tau,
                    at,
                    p1,
                    spectral,
                    p1 / spectral - 1,
                    transport,
                    p1 / transport - 1,
                )
            )
        both = wall_flux(result, x), square_transport(x, float(tau))
        profiles += [(tau, *row) for row in zip(x, *both, strict=True)]
        if tau == "1":
            G = incident(result)
    columns = {
        "kappa L [1]": "",
        "x/L [1]": "g",
        "P1 [1]": ".10f",
        "P1 spectral [1]": ".10f",
        "difference": ".1e",
    }
    columns |= {"transport [1]": ".8f", "P1 minus transport": ".3f"}
    return {
        "wall_flux": Table(columns, rows),
        "profiles": Table(
            {
                "kappa L [1]": "",
                "x/L [1]": ".4g",
                "P1 [1]": ".5g",
                "transport [1]": ".5g",
            },
            profiles,
        ),
        "incident": G,
    }


def incident(result: cb.Result) -> Table:
    """G/(4 sigma T^4) on a grid of the square."""
    scene = result.plan.scene
    points = np.array(np.meshgrid(SIDE, SIDE)).reshape(2, -1)
    space, G = result.nodal["G"]
    values = Probe(result.plan.mesh, scene.mesh.length * points)(space, G) / (
        4 * SIGMA * scene.radiation.temperature**4
    )
    return Table.from_columns(
        {"x/L [1]": points[0], "y/L [1]": points[1], "G/4sigmaT4 [1]": values}, ".5g"
    )


def plot(tables: Tables) -> dict[str, Any]:
    """Flux along a wall by P1 and by transport, and G in the square at kappa L = 1."""
    figure, (left, right) = gallery.figure(1, 2, size=(10.5, 4.2))
    for tau, colour in COLOURS.items():
        p = tables["profiles"].where({"kappa L [1]": tau})
        left.plot(p["x/L [1]"], p["P1 [1]"], color=colour)
        left.plot(p["x/L [1]"], p["transport [1]"], "--", color=colour)
        gallery.label_line(
            left,
            rf"$\kappa L$ = {tau}",
            p["x/L [1]"][-1],
            p["P1 [1]"][len(p) // 2],
            colour,
            (8, 0),
        )
    left.plot([], [], "k", label="P1")
    left.plot([], [], "k--", label="transport")
    left.legend(loc="center", bbox_to_anchor=(0.5, 0.42))
    left.set(
        xlabel="x/L along the wall",
        ylabel=r"$q/\sigma T^4$",
        xlim=(0, 1),
        ylim=(0, 1.15),
    )
    field = tables["incident"]["G/4sigmaT4 [1]"].reshape(len(SIDE), len(SIDE))
    picture = right.contourf(SIDE, SIDE, field, levels=20, cmap="inferno")
    right.set(aspect="equal", xlabel="x/L", ylabel="y/L", title=r"$\kappa L$ = 1")
    figure.colorbar(picture, ax=right, label=r"$G/4\sigma T^4$")
    return {"square": figure}
