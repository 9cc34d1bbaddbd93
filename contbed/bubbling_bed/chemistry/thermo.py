"""Enthalpy, entropy and equilibrium of the gases and solids of a reacting bed, from
Cantera's NASA polynomials.

Both functions of T are continued from the lower range of each species over its mid
temperature, where the published coefficients leave jumps of some 10 J/kg, and beyond
the ends of the data with constant heat capacity.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from contbed.chemistry.elements import molar_mass_of
from contbed.chemistry.mixture import Mechanism
from contbed.chemistry.thermo import Equilibrium, Thermo, species_of
from contbed.errors import SceneError
from contbed.materials.common import nearest

GASES = ("O2", "N2", "CO2", "CO", "H2O", "H2", "CH4", "C6H6", "H2S", "SO2")
SOLIDS = {
    "C": "C(gr)",
    "CaCO3": "CaCO3(caL)",
    "CaO": "CaO(s)",
    "CaSO4": "CaSO4(s)",
    "H2O(l)": "H2O(L)",
}


def _file(name: str) -> dict[str, Any]:
    """Return the species of a file of Cantera by name."""
    try:
        import cantera
    except ImportError as error:
        raise SceneError(
            "reactions: the package cantera is needed for thermodynamics and cannot "
            f"be imported ({error}); "
            "install it (pip install cantera)"
        ) from error
    return {item.name: item for item in cantera.Species.list_from_file(name)}


def _species(name: str, item: Any) -> Thermo:
    return species_of(name, item, molar_mass_of(item.composition))


@lru_cache(maxsize=1)
def table() -> dict[str, Thermo]:
    """Return all species by name; solids by their formula, liquid water as H2O(l)."""
    gases, solids = _file("nasa_gas.yaml"), _file("nasa_condensed.yaml")
    found = {name: gases[name] for name in GASES}
    found |= {name: solids[other] for name, other in SOLIDS.items()}
    return {name: _species(name, item) for name, item in found.items()}


def equilibrium(stoichiometry: Mapping[str, float]) -> Equilibrium:
    """Return the equilibrium of a reaction of species of the table."""
    return Equilibrium(stoichiometry, table(), frozenset(GASES))


def gas(name: str, mechanism: str) -> Thermo:
    """Return a gas of the table, else of the mechanism, else of Cantera's data.

    Raises
    ------
    SceneError : there is none of this name
    """
    if name in GASES:
        return table()[name]
    found = Mechanism.read(mechanism)
    if name in found.names:
        return found.species(name)
    data = _file("nasa_gas.yaml")
    if name in data:
        return _species(name, data[name])
    raise SceneError(
        f"{name} is neither a gas of {mechanism} nor of nasa_gas.yaml"
        f"{nearest(name, [*GASES, *found.names])}"
    )
