"""Heating of a packed bed (Patil, Peters & Kuipers, Fig. 1): Schumann's solution,
two readings, dispersion.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mpmath
import numpy as np

import contbed as cb
from studies import _exact as exact
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
SCENES = {
    "schumann": "bed A, no conduction",
    "schumann_bed_b": "bed B, no conduction",
    "dispersion": "bed A with axial dispersion",
}
# of the positions in errors.csv [m]
SPACING = {"schumann": 0.1, "schumann_bed_b": 0.1, "dispersion": 0.05}
THETA = ("theta_fluid [1]", "theta_solid [1]")
NOT_COMPARED = ("error_fluid [1]", "error_solid [1]")


def gunn(Re: float, Pr: float, eps: float) -> float:
    """Nusselt number of Eq. 5 as printed."""
    return (7 - 10 * eps + 5 * eps**2) * (1 + 0.7 * Re**0.2 * Pr**0.33) + (
        1.33 - 2.4 * eps + 1.2 * eps**2
    ) * Re**0.7 * Pr**0.33


def rates(scene: cb.Scene) -> tuple[float, float, float]:
    """Interstitial velocity [m/s] and the exchange rates h a/(eps rho c_p)_f and h
    a/((1 - eps) rho c_p)_s [1/s].
    """
    fluid, solid, eps, d = (
        scene.gas,
        scene.solid,
        scene.packed_bed.porosity,
        scene.diameter,
    )
    Re = fluid.density * scene.boundary["bottom"].gas.velocity * d / fluid.viscosity
    Pr = fluid.viscosity * fluid.heat_capacity / fluid.conductivity
    ha = gunn(Re, Pr, eps) * fluid.conductivity / d * 6 * (1 - eps) / d
    capacity = fluid.density * fluid.heat_capacity, solid.density * solid.heat_capacity
    return (
        scene.boundary["bottom"].gas.velocity / eps,
        ha / (eps * capacity[0]),
        ha / ((1 - eps) * capacity[1]),
    )


def with_dispersion(z: float, t: float, scene: cb.Scene) -> tuple[float, float]:
    """Fluid and solid theta at one point: numerical inversion (Talbot's contour) of the
    exact Laplace transform.

    f_t + u f_z = alpha f_zz + A (s - f), s_t = B (f - s); u f - alpha f_z = u at z = 0
    (Danckwerts), f_z = 0 at z = L.
    """
    u, A, B = (mpmath.mpf(float(value)) for value in rates(scene))
    fluid, length = scene.gas, mpmath.mpf(scene.mesh.length)
    capacity = scene.packed_bed.porosity * fluid.density * fluid.heat_capacity
    alpha = mpmath.mpf(
        (scene.closures.conductivity_gas + scene.closures.dispersion.axial) / capacity
    )

    def transform(p: Any) -> Any:
        root = mpmath.sqrt(u**2 + 4 * alpha * (p + A * p / (p + B)))
        falling, rising = (u - root) / (2 * alpha), (u + root) / (2 * alpha)
        back = -falling / rising * mpmath.exp((falling - rising) * length)
        shape = mpmath.exp(falling * z) + back * mpmath.exp(rising * z)
        return u / p * shape / (u - alpha * falling + back * (u - alpha * rising))

    with mpmath.workdps(30):
        f = mpmath.invertlaplace(transform, t, method="talbot", degree=40)
        s = mpmath.invertlaplace(
            lambda p: transform(p) * B / (p + B), t, method="talbot", degree=40
        )
    return float(f), float(s)


def reference(scene: cb.Scene, z: Any, t: Any) -> Any:
    """Exact theta of fluid and solid at z [m] and t [s], from the values in the
    scene.
    """
    if scene.closures.dispersion is None:
        return exact.schumann(z, t, *rates(scene))
    return np.array([with_dispersion(a, b, scene) for a, b in zip(z, t, strict=True)]).T


def points(name: str, result: cb.Result) -> Any:
    """The output points that are compared: multiples of the spacing."""
    z = result.profiles["z [m]"]
    return np.isclose(z / SPACING[name], np.round(z / SPACING[name]))


def errors(
    scene: cb.Scene, result: cb.Result, chosen: Any = slice(None)
) -> tuple[Any, Any]:
    """Differences of theta from the reference at the chosen output points; fluid and
    solid.
    """
    columns = {name: values[chosen] for name, values in result.profiles.items()}
    f, s = reference(scene, columns["z [m]"], columns["t [s]"])
    return columns["theta_fluid [1]"] - f, columns["theta_solid [1]"] - s


def compute() -> Tables:
    """Errors at points of all scenes, and their profiles."""
    compared, profiles = [], []
    for name in SCENES:
        scene = cb.load(HERE / f"{name}.toml")
        result = cb.run(scene)
        columns = [result.profiles[key] for key in ("t [s]", "z [m]", *THETA)]
        chosen = points(name, result)
        some = (column[chosen] for column in columns)
        compared += [
            (name, *row)
            for row in zip(*some, *errors(scene, result, chosen), strict=True)
        ]
        profiles += [(name, *row) for row in zip(*columns, strict=True)]
    places = {"scene": "", "t [s]": ".8g", "z [m]": ".8g"}
    return {
        "errors": Table(
            places | dict.fromkeys(THETA, ".8g") | dict.fromkeys(NOT_COMPARED, ".1e"),
            compared,
        ),
        "profiles": Table(places | dict.fromkeys(THETA, ".5g"), profiles),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Profiles of all scenes at all times beside the exact temperatures of the
    fluid.
    """
    from matplotlib.lines import Line2D

    dashes: Any = (0, (4, 2))
    figure, panels = gallery.figure(1, 3, sharey=True)
    for axes, (name, title) in zip(panels, SCENES.items(), strict=True):
        scene, found, compared = (
            cb.load(HERE / f"{name}.toml"),
            *(tables[key].where({"scene": name}) for key in ("profiles", "errors")),
        )
        times = found.values("t [s]")
        for time, colour in zip(times, gallery.shades(len(times)), strict=True):
            p, marks = (
                found.where({"t [s]": float(time)}),
                compared.where({"t [s]": float(time)}),
            )
            axes.plot(
                p["z [m]"],
                1 - p["theta_fluid [1]"],
                color=colour,
                label=f"{float(time):.3g} s",
            )
            axes.plot(
                p["z [m]"],
                1 - p["theta_solid [1]"],
                color=colour,
                linestyle=dashes,
                linewidth=1,
            )
            exact_fluid = marks["theta_fluid [1]"] - marks["error_fluid [1]"]
            axes.plot(
                marks["z [m]"],
                1 - exact_fluid,
                "o",
                color=colour,
                mfc="white",
                clip_on=False,
                zorder=3,
            )
        axes.set(
            title=title,
            xlabel=gallery.label("z"),
            xlim=(0, scene.mesh.length),
            ylim=(-0.02, 1.02),
        )
    panels[0].set_ylabel(r"$(T_{in}-T)/(T_{in}-T_0)$")
    shapes = [
        Line2D([], [], color="black", label="fluid"),
        Line2D([], [], color="black", linestyle=dashes, linewidth=1, label="solid"),
        Line2D(
            [],
            [],
            color="black",
            linestyle="",
            marker="o",
            markerfacecolor="white",
            label="fluid, exact",
        ),
    ]
    panels[1].legend(handles=[*panels[0].lines[::3], *shapes], loc="lower right")
    return {"profiles": figure}
