"""Measured conductivity of a bed that radiates: lithium zirconate in helium, 600 to
1500 K, beside ZBS and P1.

The measurement is known by the fit that its authors give, k = 0.69 + 2.2e-10 T^3 W/m/K
at 100 kPa. Conductivity of the solid, emissivity and porosity are not stated with it:
they are assumed, with a spread that makes the band.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.closures import conductivity_zehner_bauer_schluender
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
# K, the range of the measurement
TEMPERATURES = (600.0, 750.0, 900.0, 1050.0, 1200.0, 1350.0, 1500.0)
PRESSURE = 1e5  # Pa
DIAMETER = 1.2e-3  # m
# assumed value and standard uncertainty of what is not stated; helium as a factor
INPUTS = {
    "k_solid": (1.5, 0.5),
    "emissivity": (0.8, 0.1),
    "eps": (0.37, 0.02),
    "helium": (1.0, 0.03),
}
APART = 10.0  # K, between the plates


def reference(T: Any) -> Any:
    """Measured conductivity at T [K] (Earnshaw, Londry & Gierszewski 1998, Fusion
    Technology 33, 31) [W/m/K].
    """
    return 0.69 + 2.2e-10 * np.asarray(T) ** 3


def helium(T: float) -> float:
    """Conductivity of helium [W/m/K]."""
    from CoolProp.CoolProp import PropsSI

    return float(PropsSI("L", "T", T, "P", PRESSURE, "Helium"))


def zbs(
    T: float, k_solid: float, emissivity: float, eps: float, helium: float
) -> float:
    """Conductivity by Zehner, Bauer & Schluender [W/m/K]; `helium` [W/m/K]."""
    return float(
        conductivity_zehner_bauer_schluender(
            helium, k_solid, eps, T=T, d_p=DIAMETER, emissivity=emissivity
        )
    )


def p1(T: float, k_solid: float, emissivity: float, eps: float, helium: float) -> float:
    """Conductivity of a bed with P1 between plates APART around T [K] [W/m/K];
    `helium` [W/m/K].
    """
    changes: dict[str, object] = {
        "gas.conductivity": helium,
        "solids.particles.conductivity": k_solid,
        "packed_bed.porosity": eps,
        "solids.particles.diameter": DIAMETER,
        "solids.particles.emissivity": emissivity,
    }
    for side, plate in (("left", T + APART / 2), ("right", T - APART / 2)):
        changes |= {
            f"boundary.{side}.gas.fixed_temperature": plate,
            f"boundary.{side}.solids.particles.fixed_temperature": plate,
            f"boundary.{side}.radiation.temperature": plate,
            f"boundary.{side}.radiation.emissivity": emissivity,
        }
    scene = cb.load(HERE / "bed.toml", changes)
    return float(cb.run(scene).qoi["heat_left_W"]) * scene.mesh.length / APART


def banded(model: Any, T: float) -> tuple[float, float]:
    """Prediction and its standard uncertainty from those of the inputs, each moved
    to both sides [W/m/K].
    """
    gas = helium(T)

    def at(**moved: float) -> float:
        values = {name: value for name, (value, _) in INPUTS.items()} | moved
        return float(model(T, **(values | {"helium": values["helium"] * gas})))

    changes = [
        0.5 * (at(**{name: value + spread}) - at(**{name: value - spread}))
        for name, (value, spread) in INPUTS.items()
    ]
    return at(), float(np.linalg.norm(changes))


def compute() -> Tables:
    """Measured and predicted conductivities over the temperature."""
    rows = []
    for T in TEMPERATURES:
        rows.append((T, float(reference(T)), *banded(zbs, T), *banded(p1, T)))
    names = [
        "T [K]",
        "measured [W/m/K]",
        "ZBS [W/m/K]",
        "band of ZBS [W/m/K]",
        "P1 [W/m/K]",
        "band of P1 [W/m/K]",
    ]
    return {"measured": Table(dict.fromkeys(names, ".4g"), rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """Measured and predicted conductivities with the bands."""
    table = tables["measured"]
    figure, axes = gallery.figure(1, 1)
    T = np.asarray(table["T [K]"], dtype=float)
    for name, colour in (("ZBS", gallery.BLUE), ("P1", gallery.VERMILION)):
        value, band = (
            np.asarray(table[key], float)
            for key in (f"{name} [W/m/K]", f"band of {name} [W/m/K]")
        )
        axes.plot(T, value, color=colour, label=name)
        axes.fill_between(
            T, value - 2.0 * band, value + 2.0 * band, color=colour, alpha=0.15, lw=0
        )
    axes.plot(
        T,
        np.asarray(table["measured [W/m/K]"], float),
        color=gallery.BLACK,
        label="measured",
    )
    axes.set(xlabel="$T$ [K]", ylabel="conductivity of the bed [W/m/K]")
    axes.legend()
    return {"measured": figure}
