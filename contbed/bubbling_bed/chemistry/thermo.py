"""Enthalpy, entropy and equilibrium of the gases and solids of a reacting bed, from Cantera's NASA polynomials.

Both functions of T are continued from the lower range of each species over its mid temperature, where the published
coefficients leave jumps of some 10 J/kg, and beyond the ends of the data with constant heat capacity.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from contbed.closures.devolatilisation import molar_mass
from contbed.closures.reactions import R_GAS
from contbed.errors import SceneError
from contbed.materials.common import integrated, polynomial
from contbed.materials.pointwise import pointwise

P_STANDARD = 101325.0  # of Cantera's data for these species [Pa]
T_STANDARD = 298.15
GASES = ("O2", "N2", "CO2", "CO", "H2O", "H2", "CH4", "C6H6", "H2S", "SO2")
SOLIDS = {"C": "C(gr)", "CaCO3": "CaCO3(caL)", "CaO": "CaO(s)", "CaSO4": "CaSO4(s)", "H2O(l)": "H2O(L)"}


@dataclass(frozen=True, eq=False)
class Species:
    """One species; its polynomials are per mole and divided by R."""

    name: str
    composition: Mapping[str, float]
    molar_mass: float  # [kg/mol]
    T_range: tuple[float, float]
    T_mid: float
    cp: tuple[tuple[float, ...], tuple[float, ...]]
    h: tuple[tuple[float, ...], tuple[float, ...]]
    s: tuple[float, float]  # constants of the entropy

    def _of(self, polynomials: Any, T: Any) -> Any:
        t = np.clip(T, *self.T_range)
        return np.where(t > self.T_mid, polynomial(polynomials[1], t), polynomial(polynomials[0], t))

    def _cp(self, T: Any) -> Any:
        return R_GAS * self._of(self.cp, T)

    def _cp_slope(self, T: Any) -> Any:
        inside = (self.T_range[0] <= T) & (self.T_range[1] >= T)
        return np.where(inside, R_GAS * self._of([_derivative(cp) for cp in self.cp], T), 0.0)

    def _h(self, T: Any) -> Any:
        return R_GAS * self._of(self.h, T) + self._cp(T) * (T - np.clip(T, *self.T_range))

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/mol/K]."""
        return pointwise(self._cp, self._cp_slope, T)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy, heat of formation included [J/mol]."""
        return pointwise(self._h, self._cp, T)

    def entropy(self, T: Any) -> Any:
        """Return the entropy at standard pressure [J/mol/K]; T is a plain number or array."""
        t = np.clip(T, *self.T_range)
        parts = [
            cp[0] * np.log(t) + polynomial(integrated(cp[1:]), t) + constant
            for cp, constant in zip(self.cp, self.s, strict=True)
        ]
        return R_GAS * np.where(t > self.T_mid, parts[1], parts[0]) + self._cp(T) * np.log(T / t)

    def gibbs(self, T: Any) -> Any:
        """Return the Gibbs energy at standard pressure [J/mol]; T is a plain number or array."""
        return self._h(T) - T * self.entropy(T)


def _derivative(coefficients: tuple[float, ...]) -> list[float]:
    return [n * a for n, a in enumerate(coefficients)][1:]


@lru_cache(maxsize=1)
def table() -> dict[str, Species]:
    """Return all species by name; solids by their formula, liquid water as H2O(l)."""
    try:
        import cantera
    except ImportError as error:
        raise SceneError(
            f"reactions: the package cantera is needed for thermodynamics and cannot be imported ({error}); "
            "install it (pip install cantera)"
        ) from error
    gas = {item.name: item for item in cantera.Species.list_from_file("nasa_gas.yaml")}
    solid = {item.name: item for item in cantera.Species.list_from_file("nasa_condensed.yaml")}
    out = {name: _species(name, gas[name]) for name in GASES}
    return out | {name: _species(name, solid[other]) for name, other in SOLIDS.items()}


def _species(name: str, item: Any) -> Species:
    data = item.thermo
    c = data.coeffs
    T_mid, high, low = float(c[0]), c[1:8], c[8:15]
    cp = tuple(map(float, low[:5])), tuple(map(float, high[:5]))
    h_low = integrated(cp[0], float(low[5]))
    h_high = integrated(cp[1], float(polynomial(h_low, T_mid) - polynomial(integrated(cp[1]), T_mid)))

    def varying(k: int) -> float:
        return float(cp[k][0] * np.log(T_mid) + polynomial(integrated(cp[k][1:]), T_mid))

    s_low = float(low[6])
    return Species(
        name,
        dict(item.composition),
        molar_mass(item.composition),
        (data.min_temp, data.max_temp),
        T_mid,
        cp,
        (h_low, h_high),
        (s_low, s_low + varying(0) - varying(1)),
    )


def ln_equilibrium(stoichiometry: Mapping[str, float], T: Any) -> Any:
    """Return ln K of activities, gases at p/1 atm, solids pure; its slope is that of van 't Hoff."""
    species = table()

    def value(T: Any) -> Any:
        return -sum(count * species[name].gibbs(T) for name, count in stoichiometry.items()) / (R_GAS * T)

    return pointwise(value, lambda T: heat_of_reaction(stoichiometry, T) / (R_GAS * T * T), T)


def heat_of_reaction(stoichiometry: Mapping[str, float], T: Any) -> Any:
    """Return the heat of reaction [J/mol], negative where heat is released."""
    species = table()
    return sum(count * species[name].enthalpy(T) for name, count in stoichiometry.items())
