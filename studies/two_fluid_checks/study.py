"""Check cases of the two-fluid model: computed beside exact, with tolerance and
time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

import contbed as cb
from contbed import closures
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
COLUMNS = dict.fromkeys(
    ("case", "quantity", "computed", "exact", "deviation", "allowed", "passed"), ""
) | {"CPU s": ".2g"}
# `passed` says whether computed is what it must be
NOT_COMPARED = ("computed", "deviation", "CPU s")


def cooled(scene: cb.Scene) -> float:
    """Granular temperature after collisions and drag have acted, closed form."""
    solid, start, gas = scene.solid, scene.initial, scene.gas
    s, t, theta = (
        start.solid.volume_fraction,
        scene.time.end,
        start.solid.granular_temperature,
    )
    g0 = closures.g0_sinclair_jackson(s, solid.packing_limit)
    b = closures.granular_dissipation_lun(s, g0, solid.restitution) / (
        1.5 * s * solid.diameter
    )
    root = theta**0.5
    if scene.closures.drag == "none":
        return theta / (1 + b * root * t / 2) ** 2
    beta = closures.drag_wen_yu(0.0, 1 - s, solid.diameter, gas.viscosity)
    a = 2 * beta / (s * solid.density)
    fallen = math.exp(-a * t / 2)
    return (
        (root * fallen / (1 + b * root / a * (1 - fallen))) ** 2
        if b
        else (root * fallen) ** 2
    )


def slip(scene: cb.Scene) -> float:
    """Velocity of the gas past particles whose weight in the suspension it carries."""
    eps, gas, solid = 1 - scene.initial.solid.volume_fraction, scene.gas, scene.solid
    law = closures.get(str(scene.closures.drag), "drag")

    def missing(u: float) -> float:
        beta = law(
            eps * gas.density * u * solid.diameter / gas.viscosity,
            eps,
            solid.diameter,
            gas.viscosity,
        )
        return (
            beta * u
            - eps * (1 - eps) * (solid.density - gas.density) * scene.two_fluid.gravity
        )

    return float(brentq(missing, 1e-6, 10.0, xtol=1e-14))


def heated(scene: cb.Scene) -> float:
    """Temperature of the gas that hot particles have warmed in a closed suspension."""
    gas, solid, start = scene.gas, scene.solid, scene.initial
    s, T_gas = start.solid.volume_fraction, start.gas.temperature
    exchange = 6 * s * scene.closures.nusselt * gas.conductivity / solid.diameter**2
    warm, cool = (
        (1 - s) * gas.density * gas.heat_capacity,
        s * solid.density * solid.heat_capacity,
    )
    gap = math.exp(-exchange * (1 / warm + 1 / cool) * scene.time.end)
    return T_gas + (start.solid.temperature - T_gas) * cool / (warm + cool) * (1 - gap)


def upper(scene: cb.Scene) -> float:
    """Clear water above the particles."""
    return scene.mesh.length - 4.60966e-3 * scene.time.end


def lower(scene: cb.Scene) -> float:
    """Top of the sediment."""
    return 9.21932e-4 * scene.time.end


# quantity, exact value or function of the scene, allowed deviation, of the value unless
# "absolute"
CASES = {
    "cooling": [("theta_final", cooled, 1e-3)],
    "cooling_drag": [("theta_final", cooled, 1e-3)],
    "shear": [("theta_over_s2d2", 2.057972, 1e-3)],
    "uniform_wenyu": [("slip_velocity", slip, 1e-6), ("mass_drift_relative", 0.0, 1e-12)],
    "uniform_syamlal": [("slip_velocity", slip, 1e-6), ("mass_drift_relative", 0.0, 1e-12)],
    "uniform_gidaspow": [("slip_velocity", slip, 1e-6), ("mass_drift_relative", 0.0, 1e-12)],
    "slip": [("slip_velocity", slip, 1e-8)],
    "heating": [("T_gas_mean [K]", heated, 1e-11)],
    "fixed_bed": [("max_velocity", 0.0, 1e-10)],
    "rest": [("max_velocity", 0.0, 1e-10), ("mass_drift_relative", 0.0, 1e-12)],
    "settling": [("front_position_m", upper, 1e-2), ("lower_front_position_m", lower, 1e-2),
                 ("mass_drift_relative", 0.0, 1e-12)],
    "riemann": [("eps_star", 0.01412995, 1e-3), ("shock_speed", 1.18869463, 1e-2)],
    "crossing": [("mass_drift_relative", 0.0, 1e-12)],
    "closed_box_jj": [("mass_drift_relative", 0.0, 1e-12)],
    "developed": [("pressure_gradient_Pa_m", 894.51612, 1e-5), ("u_solid_centre", 1.1693291, 1e-5),
                  ("u_solid_wall", 1.4396601, 1e-5), ("theta_wall", 0.28117189, 1e-5),
                  ("eps_solid_centre", 0.057977764, 1e-5)],
}  # fmt: skip


def reference(name: str) -> dict[str, float]:
    """Exact values of a case by quantity."""
    scene = cb.load(HERE / f"{name}.toml")
    return {
        quantity: known(scene) if callable(known) else known
        for quantity, known, _ in CASES[name]
    }


def compute(cases: Sequence[str] = tuple(CASES)) -> Tables:
    """One row for each quantity of a case."""
    rows = []
    for name in cases:
        scene, exact = cb.load(HERE / f"{name}.toml"), reference(name)
        seconds, result = gallery.cpu(lambda scene=scene: cb.run(scene), samples=1)
        for quantity, _, allowed in CASES[name]:
            value, known = result.qoi[quantity], exact[quantity]
            deviation = abs(value - known) / (abs(known) or 1.0)
            rows.append(
                (
                    name,
                    quantity,
                    value,
                    known,
                    deviation,
                    allowed,
                    deviation <= allowed,
                    seconds,
                )
            )
            print(
                name,
                quantity,
                f"{value:.9g}, exact {known:.9g}, deviation {deviation:.2g}, allowed "
                f"{allowed:g}",
                flush=True,
            )
    table = Table(COLUMNS, rows)
    if len(cases) < len(CASES):
        table = Table.read(HERE / "results.csv").updated(table, ["case", "quantity"])
    return {"results": table}


def plot(tables: Tables) -> dict[str, Any]:
    """Deviation of every quantity over what is allowed."""
    table = tables["results"]
    share = np.maximum(table["deviation"] / table["allowed"], 1e-9)
    figure, axes = gallery.figure(size=(8, 6))
    places = np.arange(len(table))[::-1]
    axes.barh(places, share, left=1e-9, color=gallery.BLUE)
    axes.axvline(1.0, color=gallery.VERMILION)
    names = [f"{row['case']}, {row['quantity'].replace('_', ' ')}" for row in table]
    axes.set_yticks(places, names, fontsize=8)
    axes.set(xscale="log", xlim=(1e-9, 3), xlabel="deviation over what is allowed")
    return {"deviations": figure}
