"""Heat conduction with radiation between two black walls: each level beside exact
transport.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.closures.optics import SIGMA
from studies import _gallery as gallery
from studies._exact.conduction_radiation import (
    conduction_diffusion,
    conduction_radiation,
)
from studies._exact.radiation import P1, TWO_FLUX
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
DIFFUSION = {"two_flux": TWO_FLUX, "p1": P1}
NUMBERS = ("0.01", "0.1", "1", "10")
THICKNESSES = ("0.1", "1", "10")
LEVELS = {"two-flux": ("two_flux", 1), "P1": ("p1", 1), "4 + 4 ordinates": ("ordinates", 4),
          "8 + 8 ordinates": ("ordinates", 8)}  # fmt: skip
COLOURS = dict(
    zip(
        LEVELS,
        (gallery.VERMILION, gallery.GREEN, gallery.SKY, gallery.BLUE),
        strict=True,
    )
)
# optical depths of the temperatures
DEPTHS = (1 - np.cos(np.linspace(0, np.pi, 61))) / 2
# of the temperatures
DRAWN = tuple(name for name in LEVELS if name != "8 + 8 ordinates")
AGAINST = ("two-flux against collocation", "P1 against collocation")
TRANSPORT: dict[str, Any] = {"color": "black", "linewidth": 3, "alpha": 0.25}
NOT_COMPARED = (*(f"error of {name}" for name in LEVELS), *AGAINST)


def load(
    N: str, tau: str, level: str = "p1", ordinates: int = 4, theta_L: float = 0.5
) -> cb.Scene:
    """The scene of one conduction-radiation parameter and thickness, by another
    level, with a colder cold wall.
    """
    changes = {"radiation.level": level, "radiation.ordinates": ordinates}
    cold = {"boundary.right.radiation.temperature": 1000.0 * theta_L}
    return cb.load(HERE / f"N_{N}_tau_{tau}.toml", changes | cold)


def parameters(scene: cb.Scene) -> tuple[float, float, float]:
    """tau, N and theta_L of a scene."""
    table, length = scene.radiation, scene.mesh.length
    hot, cold = (
        scene.boundary[name].radiation.temperature for name in ("left", "right")
    )
    N = table.conductivity * table.absorption / (4.0 * SIGMA * hot**3)
    return table.absorption * length, N, cold / hot


def reference(scene: cb.Scene) -> Any:
    """Total flux over sigma T1^4, and profiles, by transport."""
    return conduction_radiation(*parameters(scene))


def of_model(scene: cb.Scene) -> Any:
    """The solution of the two-flux or P1 equations by collocation."""
    return conduction_diffusion(*parameters(scene), DIFFUSION[scene.radiation.level])


def found(result: cb.Result) -> float:
    """Total flux over sigma T1^4."""
    return float(result.qoi["flux_over_emissive_power"])


def compute() -> Tables:
    """Fluxes by every level beside transport, and temperatures of three cases."""
    rows = []
    for theta_L in (0.5, 0.1):
        for tau in THICKNESSES:
            for N in NUMBERS:
                exact = reference(load(N, tau, theta_L=theta_L)).total
                row, against = [theta_L, N, tau, exact], []
                for level, ordinates in LEVELS.values():
                    scene = load(N, tau, level, ordinates, theta_L)
                    flux = found(cb.run(scene))
                    row += [flux, flux / exact - 1]
                    if level in DIFFUSION:
                        against.append(flux / of_model(scene).total - 1)
                rows.append([*row, *against])
    columns = {"theta_L [1]": "g", "N [1]": "", "tau [1]": "", "flux exact [1]": ".8f"}
    for name in LEVELS:
        columns |= {f"{name} [1]": ".8f", f"error of {name}": ".1e"}
    return {
        "results": Table(columns | dict.fromkeys(AGAINST, ".1e"), rows),
        "profiles": temperatures(),
    }


def temperatures() -> Table:
    """T/T1 over the depth at tau = 1 by every level and by transport."""
    rows = []
    for N in NUMBERS[:3]:
        exact = reference(load(N, "1"))
        curves = {"transport": (exact.depth, exact.theta)}
        for name in DRAWN:
            profiles = cb.run(load(N, "1", *LEVELS[name])).profiles
            curves[name] = profiles["x [m]"] / 0.1, profiles["T_solid [K]"] / 1000
        for name, (depth, theta) in curves.items():
            rows += [
                (N, name, *row)
                for row in zip(DEPTHS, np.interp(DEPTHS, depth, theta), strict=True)
            ]
    return Table(
        {"N [1]": "", "by": "", "optical depth [1]": ".5g", "T/T1 [1]": ".5g"}, rows
    )


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures at tau = 1 by every level, and the error of the flux of each
    level.
    """
    figure, (first, *others) = gallery.figure(
        1, 4, size=(14, 4), width_ratios=(1.5, 1, 1, 1)
    )
    for N in NUMBERS[:3]:
        for name in ("transport", *DRAWN):
            p = tables["profiles"].where({"N [1]": N, "by": name})
            how = (
                {"color": COLOURS[name], "linewidth": 1}
                if name in COLOURS
                else TRANSPORT
            )
            first.plot(p["optical depth [1]"], p["T/T1 [1]"], **how)
    for N, at, height in (("1", 0.36, 0.73), ("0.1", 0.75, 0.70), ("0.01", 0.80, 0.80)):
        first.text(at, height, f"N = {N}", fontsize=9)
    first.set(
        xlabel="optical depth",
        ylabel=r"$T/T_1$",
        title=r"$\tau$ = 1, $T_2/T_1$ = 0.5",
        xlim=(0, 1),
    )
    first.plot([], [], label="transport", **TRANSPORT)
    for name, colour in COLOURS.items():
        first.plot([], [], color=colour, label=name)
    first.legend(loc="lower left")
    for axes, tau in zip(others, THICKNESSES, strict=True):
        rows = tables["results"].where({"theta_L [1]": 0.5, "tau [1]": tau})
        for name, colour in COLOURS.items():
            axes.loglog(
                rows["N [1]"], np.abs(rows[f"error of {name}"]), "o-", color=colour
            )
        axes.set(title=rf"$\tau$ = {tau}", xlabel="N", ylim=(1e-11, 1))
    others[0].set_ylabel("relative error of the flux")
    return {"conduction_radiation": figure}
