"""Gas properties: accuracy against Cantera and time per point, for all four
properties of several mixtures.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cantera
import numpy as np

from contbed.materials import gas_mixture
from studies import _gallery as gallery
from studies._gallery import Table, Tables

MIXTURES = {
    "nitrogen": "N2:1",
    "steam": "H2O:1",
    "air": "N2:0.79, O2:0.21",
    "syngas": "CO:0.2, CO2:0.1, H2:0.2, H2O:0.1, CH4:0.05, N2:0.35",
}
PROPERTIES: dict[str, Callable[[Any], float]] = {
    "density": lambda gas: gas.density_mass,
    "heat_capacity": lambda gas: gas.cp_mass,
    "viscosity": lambda gas: gas.viscosity,
    "conductivity": lambda gas: gas.thermal_conductivity,
}
POINTS = 100_000
TIMES = ("time [ns/point]", "time of Cantera [ns/point]")
DIFFERENCE = "largest relative difference [1]"
NOT_COMPARED = (DIFFERENCE, *TIMES)


def reference(composition: str, quantity: str, T: Any) -> Any:
    """A property at temperatures [K] by Cantera, one state after the other."""
    peer, get, out = (
        cantera.Solution("gri30.yaml"),
        PROPERTIES[quantity],
        np.empty(len(T)),
    )
    for i, each in enumerate(T):
        peer.TPX = each, cantera.one_atm, composition
        out[i] = get(peer)
    return out


def compute() -> Tables:
    """Compare on 301 temperatures, time on 1e5."""
    many = np.random.default_rng(0).uniform(300.0, 3000.0, POINTS)
    few = np.linspace(300.0, 3000.0, 301)
    rows = []
    for name, composition in MIXTURES.items():
        gas = gas_mixture(composition, cantera.one_atm)
        for quantity in PROPERTIES:
            ours = getattr(gas, quantity)
            theirs = gallery.cpu(lambda c=composition, q=quantity: reference(c, q, few))
            mine = gallery.cpu(lambda f=ours: f(many), samples=7)
            difference = np.max(np.abs(ours(few) / theirs.result - 1.0))
            rows.append(
                (
                    name,
                    quantity,
                    difference,
                    1e9 * mine.seconds / POINTS,
                    1e9 * theirs.seconds / len(few),
                )
            )
    columns = {
        "mixture": "",
        "property": "",
        DIFFERENCE: ".1e",
        TIMES[0]: ".1f",
        TIMES[1]: ".0f",
    }
    return {"gas_properties": Table(columns, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """Time of a point for each property and mixture."""
    figure, axes = gallery.figure(size=(8, 4))
    table = tables["gas_properties"]
    places = np.arange(len(table))
    for header, text, colour, shift in zip(
        TIMES, ("contbed", "Cantera"), gallery.PALETTE, (-0.2, 0.2), strict=False
    ):
        axes.bar(places + shift, table[header], 0.4, color=colour, label=text)
    names = [f"{row['mixture']}, {row['property'].replace('_', ' ')}" for row in table]
    axes.set(yscale="log", ylabel="CPU of a point [ns]", ylim=(0.1, 1e5))
    axes.set_xticks(places, names, rotation=60, ha="right", fontsize=8)
    axes.legend(loc="upper left", ncols=2)
    return {"gas_properties": figure}
