"""Hot fluid through a cold stationary bed with tortuosity and dispersion: the exact
solution of Nakayama (2001).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from studies import _exact as exact
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
SCENE = HERE / "hot_fluid.toml"
PRINTED = {"G": -0.013219, "alpha": 0.625}  # Table 1 of Pivem & de Lemos (2012)
COLOURS = {"fluid": gallery.BLUE, "solid": gallery.VERMILION}
NOT_COMPARED = ("difference",)


def groups(scene: cb.Scene) -> dict[str, float]:
    """Dimensionless numbers of a scene (Eqs. 30-34) and the length sqrt(k_f/(a h))
    of X [m], Wakao's coefficient.
    """
    fluid, eps, d = scene.gas, scene.packed_bed.porosity, scene.diameter
    Pr = fluid.viscosity * fluid.heat_capacity / fluid.conductivity
    Pe_d = (
        fluid.density
        * fluid.heat_capacity
        * scene.boundary["left"].gas.velocity
        * d
        / fluid.conductivity
    )
    ratio = scene.solid.conductivity / fluid.conductivity
    Nu = 2 + 1.1 * (Pe_d / Pr) ** 0.6 * Pr ** (1 / 3)
    return {
        "Pe": exact.nakayama_peclet(Pe_d, Pr, eps),
        "ratio": ratio,
        "dispersion": scene.closures.dispersion.axial / fluid.conductivity,
        "G": exact.tortuosity_parameter(eps, ratio),
        "length": d / np.sqrt(6 * (1 - eps) * Nu),
    }


def coefficients(scene: cb.Scene) -> dict[str, float]:
    """Arguments of the exact solutions, from the values in the scene."""
    g = groups(scene)
    return exact.nakayama_coefficients(
        g["Pe"], scene.packed_bed.porosity, g["ratio"], g["dispersion"], g["G"]
    )


def reference(scene: cb.Scene, x: Any) -> tuple[Any, Any]:
    """Exact theta of fluid and solid at x [m], hot fluid over a cold bed: Eqs. 28
    and 29.
    """
    f, s = exact.semi_infinite(x / groups(scene)["length"], **coefficients(scene))
    return 1 - f, 1 - s


def exact_parameters(scene: cb.Scene) -> dict[str, float]:
    """alpha and theta far downstream."""
    alpha, direction = exact.decay_rate(**coefficients(scene))
    return {"alpha": alpha, "theta_inf": 1 - 1 / (1 - direction)}


def found_parameters(scene: cb.Scene, result: cb.Result) -> dict[str, float]:
    """alpha fitted to the logarithm of theta_fluid - theta_solid between 1 and 0.01,
    and theta at the outlet.
    """
    p = result.profiles
    gap = p["theta_fluid [1]"] - p["theta_solid [1]"]
    X = p["x [m]"] / groups(scene)["length"]
    used = (gap > 0.01) & (gap < 1)
    return {
        "alpha": -np.polyfit(X[used], np.log(gap[used]), 1)[0],
        "theta_inf": p["theta_solid [1]"][-1],
    }


def errors(scene: cb.Scene, result: cb.Result) -> tuple[Any, Any]:
    """Differences of theta from the exact solution; fluid and solid."""
    f, s = reference(scene, result.profiles["x [m]"])
    return result.profiles["theta_fluid [1]"] - f, result.profiles[
        "theta_solid [1]"
    ] - s


def compute() -> Tables:
    """Decay rate, temperature far downstream and profiles."""
    scene = cb.load(SCENE)
    result = cb.run(scene)
    found, wanted = found_parameters(scene, result), exact_parameters(scene)
    rows: list[tuple[Any, ...]] = [
        (name, found[name], wanted[name], found[name] - wanted[name]) for name in found
    ]
    for phase, difference in zip(
        ("fluid", "solid"), errors(scene, result), strict=True
    ):
        rows.append((f"theta_{phase}", "profile", "profile", np.abs(difference).max()))
    X = np.linspace(0, 10, 101)
    at = result.profiles["x [m]"] / groups(scene)["length"]
    profiles = {
        name: np.interp(X, at, result.profiles[name])
        for name in ("theta_fluid [1]", "theta_solid [1]")
    }
    return {
        "results": Table(
            {
                "quantity [1]": "",
                "contbed": ".12f",
                "exact": ".12f",
                "difference": ".1e",
            },
            rows,
        ),
        "profiles": Table.from_columns({"X [1]": X, **profiles}),
    }


def printed_profiles(scene: cb.Scene, X: Any) -> dict[str, Any]:
    """theta of Eqs. 28 and 29 with the decay rate that is printed."""
    g, eps, alpha = groups(scene), scene.packed_bed.porosity, PRINTED["alpha"]
    weight = alpha * g["ratio"] * (1 - eps + (g["ratio"] - 1) * g["G"])
    stagnant = eps + g["G"] * (1 - g["ratio"]) ** 2 + (1 - eps) * g["ratio"]
    weight /= g["Pe"] + alpha * (stagnant + g["dispersion"])
    fluid = 1 + weight * np.expm1(-alpha * X)
    return {"fluid": fluid, "solid": fluid - np.exp(-alpha * X)}


def plot(tables: Tables) -> dict[str, Any]:
    """Profiles beside the exact ones, and what the printed decay rate changes."""
    scene, profiles, marks = cb.load(SCENE), tables["profiles"], np.linspace(0, 10, 21)
    printed = printed_profiles(scene, marks)
    figure, (left, right) = gallery.figure(1, 2)
    lines = reference(scene, marks * groups(scene)["length"])
    for (phase, colour), line in zip(COLOURS.items(), lines, strict=True):
        left.plot(
            profiles["X [1]"],
            profiles[f"theta_{phase} [1]"],
            color=colour,
            label=f"{phase}, contbed",
        )
        left.plot(
            marks,
            line,
            "o",
            color=colour,
            markerfacecolor="white",
            label=f"{phase}, exact",
        )
        right.plot(marks, printed[phase] - line, "o-", color=colour, label=phase)
    left.set(xlabel="X", ylabel=r"$\theta_f,\ \theta_s$", xlim=(0, 10), ylim=(0, 1.02))
    left.legend(loc="lower right")
    right.set(
        xlabel="X",
        ylabel=r"$\theta$ with printed $\alpha = 0.625$, minus exact",
        xlim=(0, 10),
    )
    right.axhline(0, color="black", linewidth=0.6)
    right.legend()
    return {"profiles": figure}
