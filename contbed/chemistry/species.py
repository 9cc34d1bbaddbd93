"""Species with their data: from the tables of a scene, a mechanism of Cantera, or
Cantera's tables of solids.

A species is a name. Its atoms are those that the scene states, else those of the
species of the mechanism with this name; only a name that the mechanism does not have is
read as a formula.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from contbed.chemistry.elements import ATOMIC_WEIGHTS, elements_of, molar_mass_of
from contbed.chemistry.mixture import Mechanism
from contbed.chemistry.thermo import (
    T_STANDARD,
    ConstantHeatCapacity,
    Shomate,
    Thermo,
    species_of,
)
from contbed.errors import SceneError
from contbed.scene.reactions import Substance

# [J/mol/K] of a species without data in an isothermal bed, where it has no meaning
INERT_CAPACITY = 1.0
# coefficients after which F, the constant of the enthalpy, follows
FORMATION_SHOMATE = 5

MELTED = 400.0  # [K]; what melts below reacts in beds that are hotter

# two capitals that may be one element, as in NIO
PAIR = re.compile("[A-Z][IU]")


@dataclass(frozen=True)
class Species:
    """Gases, and the constituents of the solids of one place, by name."""

    gases: dict[str, Thermo]
    solids: dict[str, Thermo]

    @property
    def all(self) -> dict[str, Thermo]:
        """Gases and solids by name."""
        return self.gases | self.solids

    @property
    def enthalpies(self) -> dict[str, Any]:
        """Enthalpies of gases and solids by name, functions of T [K]."""
        return {name: item.enthalpy for name, item in self.all.items()}


def condensed_names() -> tuple[str, ...]:
    """Return names of solids that Cantera's tables hold and that do not melt below
    MELTED: H2O, Hg or S is a solid of a bed only where the scene says so.
    """
    try:
        return tuple(_condensed(MELTED))
    except ImportError:
        return ()


@lru_cache(maxsize=2)
def _condensed(melted: float = 0.0) -> dict[str, Any]:
    """Return the solids of Cantera's tables by formula, those left out that melt below
    a temperature [K]; the form that is stable at the lowest temperature.
    """
    import cantera

    out: dict[str, Any] = {}
    last: dict[str, float] = {}
    for item in cantera.Species.list_from_file("nasa_condensed.yaml"):
        name = (
            item.name.rsplit("(", 1)[0]
            if item.name.endswith(")") and not item.name.endswith("(L)")
            else item.name
        )
        if name not in out or item.thermo.min_temp < out[name].thermo.min_temp:
            out[name] = item
        last[name] = max(last.get(name, 0.0), item.thermo.max_temp)
    return {name: item for name, item in out.items() if last[name] > melted}


def in_other_case(name: str, known: Iterable[str]) -> str:
    """Return the known name that differs from a name in capital letters alone; empty
    where there is none.
    """
    return next((each for each in known if each.lower() == name.lower()), "")


def atoms_of(
    name: str, table: Substance | None, mechanism: Mechanism | None
) -> Mapping[str, float]:
    """Return the atoms of a species, see the module.

    Raises
    ------
    SceneError : nothing states them, and the name is no formula
    """
    if table is not None and table.elements:
        return table.elements
    names = () if mechanism is None else mechanism.names
    if mechanism is not None and name in names:
        return mechanism.atoms(name)
    try:
        found = elements_of(name)
    except SceneError:
        if other := in_other_case(name, names):
            raise SceneError(f"there is no {name}; write {other}") from None
        raise
    if name.isupper() and {"I", "U"} & found.keys():
        other = PAIR.sub(
            lambda pair: (
                pair[0].title() if pair[0].title() in ATOMIC_WEIGHTS else pair[0]
            ),
            name,
        )
        if other != name:
            raise SceneError(
                f"{name} reads as {', '.join(found)}; write {other}, or give its "
                "elements"
            )
    return found


def _from_table(
    name: str, table: Substance, elements: dict[str, float], needs_heat: bool
) -> Thermo | None:
    """Return a species from the data of its table, None where they give no
    thermodynamics.
    """
    mass = table.molar_mass or molar_mass_of(elements)
    if table.shomate is not None:
        given = list(table.shomate)
        if table.enthalpy is not None or len(given) == FORMATION_SHOMATE:
            if table.enthalpy is None:
                raise SceneError(
                    f"{name}: shomate has no F; give F, or the enthalpy of formation "
                    "as `enthalpy`"
                )
            zero = Shomate(name, elements, mass, (*given[:FORMATION_SHOMATE], 0.0))
            F = (table.enthalpy - float(zero.enthalpy(T_STANDARD))) * 1e-3
            given[FORMATION_SHOMATE : FORMATION_SHOMATE + 1] = [F]
        if table.entropy is not None:
            zero = Shomate(name, elements, mass, (*given[: FORMATION_SHOMATE + 1], 0.0))
            T = T_STANDARD
            s = float(zero.enthalpy(T) - zero.gibbs(T)) / T
            given[FORMATION_SHOMATE + 1 :] = [table.entropy - s]
        return Shomate(name, elements, mass, tuple(given[:7]))
    if table.heat_capacity is not None or (not needs_heat and table.enthalpy is None):
        cp = table.heat_capacity or INERT_CAPACITY
        return ConstantHeatCapacity(
            name, elements, mass, cp, table.enthalpy or 0.0, table.entropy
        )
    return None


def gas_species(
    name: str, table: Substance | None, mechanism: Mechanism | None, needs_heat: bool
) -> Thermo:
    """Return a gas with the data of its table, else those of the mechanism.

    Raises
    ------
    SceneError : there are none
    """
    if table is not None and (
        mechanism is None
        or table.shomate is not None
        or table.heat_capacity is not None
    ):
        atoms = dict(atoms_of(name, table, mechanism))
        found = _from_table(name, table, atoms, needs_heat)
        if found is not None:
            return found
    if mechanism is not None and name in mechanism.names:
        return mechanism.species(name)
    raise SceneError(
        f"{name} has no thermodynamics: give shomate, or heat_capacity and enthalpy, "
        f"in [gas.species.{name}]"
    )


def _of_these_atoms(
    name: str, table: Substance | None, tables: Mapping[str, Any]
) -> str:
    """Return the one solid of tables whose formula is written in another way, as
    CaO2H2 for Ca(OH)2; empty if there is none, or several.
    """
    if table is not None and table.elements:
        return ""
    atoms = dict(atoms_of(name, table, None))
    alike = [
        key
        for key, item in tables.items()
        if not key.endswith("(L)") and item.composition == atoms
    ]
    return alike[0] if len(alike) == 1 else ""


def solid_species(name: str, table: Substance | None, needs_heat: bool) -> Thermo:
    """Return a constituent of solids with the data of its table, else those of
    Cantera's tables, else with a constant heat capacity where no heat is solved for.

    Raises
    ------
    SceneError : there are none
    """
    if table is not None:
        atoms = dict(atoms_of(name, table, None))
        found = _from_table(name, table, atoms, needs_heat)
        if found is not None:
            return found
    tables = _condensed()
    own = name if name in tables else _of_these_atoms(name, table, tables)
    if own:
        stated = None if table is None else table.molar_mass
        mass = stated or molar_mass_of(atoms_of(name, table, None))
        return species_of(name, tables[own], mass, with_jumps=True)
    if table is None and not needs_heat:
        return solid_species(name, Substance(), needs_heat)
    raise SceneError(
        f"{name} has no thermodynamics: give shomate, or heat_capacity and enthalpy, "
        f"in [solids.NAME.constituent.{name}]"
    )
