"""Effective conductivity of a packed bed from 75 to 1475 degC with radiation, beside
Zehner, Bauer & Schluender.

The bed of `bed.toml`, 0.5 m thick, between plates 10 K apart: P1 in the two-energy
model, the same without radiation, and the closure with its radiation term in place of
P1. The run time with and without radiation is measured beside it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import contbed as cb
from contbed.closures import (
    conductivity_zehner_bauer_schluender,
    conductivity_zehner_schluender,
)
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
LENGTH = 0.5
APART = 10.0
CELSIUS = (75, 275, 475, 675, 875, 1075, 1275, 1475)
EMISSIVITY = 0.8


def scene(T: float, radiates: bool) -> cb.Scene:
    """The bed around a mean temperature [K]."""
    overrides: dict[str, object] = {}
    for side, plate in (("left", T + APART / 2), ("right", T - APART / 2)):
        overrides[f"boundary.{side}.gas.fixed_temperature"] = plate
        overrides[f"boundary.{side}.solids.particles.fixed_temperature"] = plate
        overrides[f"boundary.{side}.radiation.temperature"] = plate
    loaded = cb.load(HERE / "bed.toml", overrides)
    if radiates:
        return loaded
    sides = {
        name: table.model_copy(update={"radiation": None})
        for name, table in loaded.boundary.items()
    }
    return loaded.model_copy(update={"radiation": None, "boundary": sides})


def conductivity(loaded: cb.Scene) -> float:
    """Heat flux times thickness over the difference of the plates [W/m/K]."""
    return float(cb.run(loaded).qoi["heat_left_W"] * LENGTH / APART)


def reference(T: float) -> float:
    """Rise of the conductivity [W/m/K] by the radiation term of the closure at a
    mean temperature [K].
    """
    loaded = scene(T, True)
    gas, solid = loaded.gas, loaded.solid
    phases = {
        "k_fluid": gas.conductivity,
        "k_solid": solid.conductivity,
        "eps": loaded.packed_bed.porosity,
    }
    radiating = conductivity_zehner_bauer_schluender(
        **phases, T=T, d_p=loaded.diameter, emissivity=EMISSIVITY
    )
    return float(radiating - conductivity_zehner_schluender(**phases))


def compute() -> Tables:
    """Rise of the conductivity over the mean temperature; prints the cost of
    radiation.
    """
    rows = []
    for celsius in CELSIUS:
        T = celsius + 273.15
        without, predicted = conductivity(scene(T, False)), reference(T)
        rise = conductivity(scene(T, True)) - without
        rows.append((celsius, without, rise, predicted, rise / predicted))
    times = gallery.in_turn(
        {
            str(radiates): lambda r=radiates: cb.run(scene(1748.15, r))
            for radiates in (True, False)
        },
        9,
    )
    print(
        "run time with radiation over without: "
        f"{times['True'].seconds / times['False'].seconds:.2f}"
    )
    names = [
        "mean temperature [degC]",
        "k without radiation [W/m/K]",
        "rise by P1 [W/m/K]",
        "rise by ZBS [W/m/K]",
    ]
    return {
        "conductivity": Table(dict.fromkeys([*names, "P1 over ZBS [1]"], ".5g"), rows)
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Nothing: the README has the table."""
    return {}
