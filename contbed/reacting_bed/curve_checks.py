"""Checks of properties that are curves over the temperature: above zero where streams enter."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contbed.materials.mixture import dippr102
from contbed.materials.thermo import Shomate
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import constant
from contbed.scene.checking import Mistakes
from contbed.scene.toml_lines import KeyPath

MASS = 1.0  # [kg/mol], of which a heat capacity per mole does not depend
UNITS = {"viscosity": "Pa s", "conductivity": "W/m/K"}


def curves_of_gases_are_positive(fluid: s.Gas, boundary: dict[str, s.Boundary], heat: s.Heat | None) -> Mistakes:
    """Check viscosity, conductivity and heat capacity of the gases at the temperatures that enter."""
    for name, table in fluid.species.items():
        path = ("fluid", "species", name)
        for key, unit in UNITS.items():
            if isinstance(given := getattr(table, key), tuple):
                yield from _not_positive((*path, key), dippr102(given), unit, boundary)
        if heat is not None:
            yield from _shomate_not_positive(path, table, boundary)


def curves_of_solids_are_positive(
    solid: s.Solids | None, boundary: dict[str, s.Boundary], heat: s.Heat | None
) -> Mistakes:
    """Check heat capacities of constituents at the temperatures that enter."""
    if solid is not None and heat is not None:
        for name, table in solid.constituent.items():
            yield from _shomate_not_positive(("solid", "constituent", name), table, boundary)


def _shomate_not_positive(path: KeyPath, table: s.Substance, boundary: dict[str, s.Boundary]) -> Mistakes:
    if table.shomate is not None:
        curve = Shomate("", {}, MASS, (*table.shomate, 0.0, 0.0)[:7]).heat_capacity
        yield from _not_positive((*path, "shomate"), curve, "J/mol/K", boundary)


def _not_positive(path: KeyPath, curve: Callable[[Any], Any], unit: str, boundary: dict[str, s.Boundary]) -> Mistakes:
    for T in _temperatures(boundary):
        value = float(curve(T))
        if not value > 0.0:
            yield path, f"gives {value:.4g} {unit} at {T:g} K, which enters; allowed: above 0. Correct the coefficients"


def _temperatures(boundary: dict[str, s.Boundary]) -> list[float]:
    inlets = [inlet for end in boundary.values() for inlet in (end.fluid, end.solid) if inlet is not None]
    given = [inlet.inflow if inlet.fixed is None else inlet.fixed for inlet in inlets]
    return sorted({constant(T) for T in given if T is not None})
