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

from contbed.chemistry.devolatilisation import molar_mass
from contbed.chemistry.thermo import R_GAS, T_STANDARD, Species, species_of
from contbed.errors import SceneError
from contbed.materials.pointwise import pointwise

__all__ = [
    "GASES",
    "P_STANDARD",
    "SOLIDS",
    "T_STANDARD",
    "heat_of_reaction",
    "ln_equilibrium",
    "table",
]

P_STANDARD = 101325.0  # of Cantera's data for these species [Pa]
GASES = ("O2", "N2", "CO2", "CO", "H2O", "H2", "CH4", "C6H6", "H2S", "SO2")
SOLIDS = {
    "C": "C(gr)",
    "CaCO3": "CaCO3(caL)",
    "CaO": "CaO(s)",
    "CaSO4": "CaSO4(s)",
    "H2O(l)": "H2O(L)",
}


@lru_cache(maxsize=1)
def table() -> dict[str, Species]:
    """Return all species by name; solids by their formula, liquid water as H2O(l)."""
    try:
        import cantera
    except ImportError as error:
        raise SceneError(
            "reactions: the package cantera is needed for thermodynamics and cannot "
            f"be imported ({error}); "
            "install it (pip install cantera)"
        ) from error
    gas = {item.name: item for item in cantera.Species.list_from_file("nasa_gas.yaml")}
    solid = {
        item.name: item
        for item in cantera.Species.list_from_file("nasa_condensed.yaml")
    }
    found = {name: gas[name] for name in GASES} | {
        name: solid[other] for name, other in SOLIDS.items()
    }
    return {
        name: species_of(name, item, molar_mass(item.composition))
        for name, item in found.items()
    }


def ln_equilibrium(stoichiometry: Mapping[str, float], T: Any) -> Any:
    """Return ln K of activities, gases at p/1 atm, solids pure; its slope is that of
    van 't Hoff.
    """
    species = table()

    def value(T: Any) -> Any:
        return -sum(
            count * species[name].gibbs(T) for name, count in stoichiometry.items()
        ) / (R_GAS * T)

    return pointwise(
        value, lambda T: heat_of_reaction(stoichiometry, T) / (R_GAS * T * T), T
    )


def heat_of_reaction(stoichiometry: Mapping[str, float], T: Any) -> Any:
    """Return the heat of reaction [J/mol], negative where heat is released."""
    species = table()
    return sum(
        count * species[name].enthalpy(T) for name, count in stoichiometry.items()
    )
