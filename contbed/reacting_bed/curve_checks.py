"""Checks of properties that are curves over the temperature: above zero where
streams enter.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contbed.chemistry.mixture import dippr102
from contbed.chemistry.thermo import Shomate
from contbed.course.schedule import boundaries_in_time
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.schedule import entering
from contbed.scene.checking import Mistakes
from contbed.scene.toml_lines import KeyPath, Origin

MASS = 1.0  # [kg/mol], of which a heat capacity per mole does not depend
Boundaries = dict[str, s.Boundary]
UNITS = {"viscosity": "Pa s", "conductivity": "W/m/K"}


def curves_of_gases_are_positive(
    gas: s.Mixture, boundary: Boundaries, heat: s.Heat | None, origin: Origin
) -> Mistakes:
    """Check viscosity, conductivity and heat capacity of the gases at the
    temperatures that enter.
    """
    temperatures = _temperatures(boundary, origin)
    for name, table in gas.species.items():
        path = ("gas", "species", name)
        for key, unit in UNITS.items():
            if isinstance(given := getattr(table, key), tuple):
                yield from _not_positive(
                    (*path, key), dippr102(given), unit, temperatures
                )
        if heat is not None:
            yield from _shomate_not_positive(path, table, temperatures)


def curves_of_solids_are_positive(
    solids: dict[str, s.Solid],
    boundary: Boundaries,
    heat: s.Heat | None,
    origin: Origin,
) -> Mistakes:
    """Check heat capacities of constituents at the temperatures that enter."""
    if heat is None:
        return
    temperatures = _temperatures(boundary, origin)
    for phase, solid in solids.items():
        for name, table in solid.constituent.items():
            yield from _shomate_not_positive(
                ("solids", phase, "constituent", name), table, temperatures
            )


def _shomate_not_positive(
    path: KeyPath, table: s.Substance, temperatures: list[float]
) -> Mistakes:
    if table.shomate is not None:
        curve = Shomate("", {}, MASS, (*table.shomate, 0.0, 0.0)[:7]).heat_capacity
        yield from _not_positive((*path, "shomate"), curve, "J/mol/K", temperatures)


def _not_positive(
    path: KeyPath, curve: Callable[[Any], Any], unit: str, temperatures: list[float]
) -> Mistakes:
    for T in temperatures:
        value = float(curve(T))
        if not value > 0.0:
            yield (
                path,
                f"gives {value:.4g} {unit} at {T:g} K, which enters; allowed: above 0. "
                "Correct the coefficients",
            )


def _temperatures(boundary: Boundaries, origin: Origin) -> list[float]:
    """Return the temperatures of all streams that enter, at each time of their
    series [K].
    """
    given: list[Any] = []
    for now in boundaries_in_time(boundary, origin, entering):
        for table in now.values():
            if table.gas is not None:
                given += [table.gas.temperature, table.gas.fixed_temperature]
            given += [solid.temperature for solid in table.solids.values()]
    return sorted({constant(T) for T in given if T is not None})
