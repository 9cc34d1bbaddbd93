"""Gas of local composition: ideal-gas density, viscosity, conductivity and diffusion
from those of its species.

Mole fractions enter with a floor of `TRACE`, so that a species that is used up, or
slightly negative within an iteration, divides nothing by zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from contbed.chemistry.thermo import R_GAS, Thermo, species_of
from contbed.errors import SceneError
from contbed.materials.common import polynomial
from contbed.materials.gas import T_FIT, cantera_gas, recentred, require_transport
from contbed.scene.mechanism import changed_at

TRACE = 1e-12  # mole fraction
# diffusion volumes of Fuller, Schettler, Giddings 1966, as revised 1969: Poling,
# Prausnitz, O'Connell 2001, table 11-1
FULLER_VOLUMES: dict[str, float] = {
    "H2": 6.12, "He": 2.67, "N2": 18.5, "O2": 16.3, "CO": 18.0, "CO2": 26.9, "H2O": 13.1, "NH3": 20.7, "Ar": 16.2,
    "SO2": 41.8, "Cl2": 38.4, "N2O": 35.9, "Ne": 5.98,
}  # fmt: skip
_FULLER_ATOMS = {"C": 15.9, "H": 2.31, "O": 6.11, "N": 4.54, "S": 22.9}

Property = Callable[[Any], Any]


@dataclass(frozen=True, eq=False)
class GasTransport:
    """Transport properties of a gas; each is a function of temperature for every
    species, or one number for the gas.

    Parameters
    ----------
    molar_masses : [kg/mol]
    viscosities : [Pa s] of each species, or one number
    conductivities : [W/m/K] of each species, or one number
    diffusivities : binary D p [m2/s Pa] by (k, j), k < j, or one D [m2/s] for all
    """

    molar_masses: tuple[float, ...]
    viscosities: float | tuple[Property, ...]
    conductivities: float | tuple[Property, ...]
    diffusivities: float | Mapping[tuple[int, int], Property]
    viscosity_rule: str = "wilke"
    conductivity_rule: str = "wassiljewa"

    def viscosity(self, T: Any, x: Sequence[Any]) -> Any:
        """Return the viscosity [Pa s] by the rule of Wilke or of Herning and Zipperer.

        Wilke 1950, J. Chem. Phys. 18, 517, doi:10.1063/1.1747673; Herning and Zipperer
        1936, Gas- und Wasserfach 79, 49: Wilke's with phi_kj = sqrt(M_j/M_k).
        """
        if isinstance(self.viscosities, float):
            return self.viscosities
        mu = [value(T) for value in self.viscosities]
        if len(mu) == 1:
            return mu[0]
        M = self.molar_masses
        if self.viscosity_rule == "herning_zipperer":
            root = [math.sqrt(m) for m in M]
            below = sum(x_j * r for x_j, r in zip(x, root, strict=True))
            return (
                sum(x_k * (mu_k * r) for x_k, mu_k, r in zip(x, mu, root, strict=True))
                / below
            )
        return _weighted(x, mu, mu, M)

    def conductivity(self, T: Any, x: Sequence[Any]) -> Any:
        """Return the conductivity [W/m/K] by the rule of Wassiljewa, or of Mathur,
        Tondon and Saxena.

        Wassiljewa's coefficients are those of Mason and Saxena 1958, Phys. Fluids 1,
        361, doi:10.1063/1.1724352, with the conductivities in place of the viscosities
        and without their factor 1.065; the other rule, Cantera's, is the mean of the
        arithmetic and harmonic averages, Mol. Phys. 12 (1967) 569.
        """
        if isinstance(self.conductivities, float):
            return self.conductivities
        k = [value(T) for value in self.conductivities]
        if len(k) == 1:
            return k[0]
        if self.conductivity_rule == "mathur":
            above = sum(x_i * k_i for x_i, k_i in zip(x, k, strict=True))
            return 0.5 * (
                above + 1.0 / sum(x_i / k_i for x_i, k_i in zip(x, k, strict=True))
            )
        M = self.molar_masses
        # of monatomic gases k M is in proportion to the viscosity
        return _weighted(x, k, [k_i * m for k_i, m in zip(k, M, strict=True)], M)

    def diffusivity(self, T: Any, p: Any, x: Sequence[Any]) -> list[Any]:
        """Return the diffusion coefficient of each species in the mixture of the
        others [m2/s].

        Blanc's rule, D_k = sum_j x_j/sum_j (x_j/D_kj), j other than k.
        """
        if isinstance(self.diffusivities, float):
            return [self.diffusivities] * len(self.molar_masses)
        pairs = {pair: value(T) for pair, value in self.diffusivities.items()}
        out = []
        for k in range(len(x)):
            others = [
                (x_j + TRACE, pairs[min(k, j), max(k, j)])
                for j, x_j in enumerate(x)
                if j != k
            ]
            above = sum(x_j for x_j, _ in others)
            out.append(above / (sum(x_j / D for x_j, D in others) * p))
        return out


def dippr102(coefficients: Sequence[float]) -> Property:
    """Return c1 T^c2/(1 + c3/T + c4/T^2), DIPPR's equation 102 for vapour viscosity
    and conductivity.
    """
    c1, c2, c3, c4 = (*coefficients, 0.0, 0.0, 0.0)[:4]

    def value(T: Any) -> Any:
        above = c1 * T**c2 if c2 else c1 + 0.0 * T
        return above / (1.0 + c3 / T + c4 / (T * T)) if c3 or c4 else above

    return value


def fuller_pair(first: Thermo, second: Thermo) -> Property:
    """Return D p [m2/s Pa] of a pair of gases by Fuller's equation.

    D = 1.43e-7 T^1.75/(p sqrt(M_12) (v_1^(1/3) + v_2^(1/3))^2), p in bar,
    M_12 = 2/(1/M_1 + 1/M_2) in g/mol.

    Raises
    ------
    SceneError : no diffusion volume of a species is known
    """
    M = 2e3 / (1.0 / first.molar_mass + 1.0 / second.molar_mass)
    width = fuller_volume(first) ** (1.0 / 3.0) + fuller_volume(second) ** (1.0 / 3.0)
    scale = 1.43e-7 * 1e5 / (math.sqrt(M) * width**2)
    return lambda T: scale * T**1.75


def fuller_volume(species: Thermo) -> float:
    """Return the diffusion volume of a species, from its atoms where it is not
    tabulated.
    """
    atoms = species.composition
    atom = next(iter(atoms)) if sum(atoms.values()) == 1 else ""  # a noble gas
    for name in (species.name, atom):
        if name in FULLER_VOLUMES:
            return FULLER_VOLUMES[name]
    unknown = [element for element in atoms if element not in _FULLER_ATOMS]
    if unknown or not atoms:
        raise SceneError(
            f"no diffusion volume of {species.name} is known for Fuller's equation; "
            "give gas.diffusivity as a number"
        )
    return sum(count * _FULLER_ATOMS[element] for element, count in atoms.items())


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Species and transport of a Cantera mechanism."""

    gas: Any
    names: tuple[str, ...]
    file: str

    @classmethod
    def read(cls, mechanism: str) -> Mechanism:
        """Read a mechanism; SceneError says why it cannot be."""
        return _read(mechanism, changed_at(mechanism))

    def atoms(self, name: str) -> dict[str, float]:
        """Return the atoms of a species of the mechanism."""
        return dict(self.gas.species(name).composition)

    @cached_property
    def transport(self) -> Any:
        """The gas of Cantera with its transport data.

        Raises
        ------
        SceneError : the mechanism has none
        """
        require_transport(self.gas, self.file)
        return self.gas

    def species(self, name: str) -> Thermo:
        """Return the thermodynamics of a species of the mechanism."""
        index = self.gas.species_index(name)
        mass = float(self.gas.molecular_weights[index]) / 1000.0
        return species_of(name, self.gas.species(index), mass, with_jumps=True)

    def viscosity(self, name: str) -> Property:
        """Return the viscosity of a pure species [Pa s]."""
        index = self.gas.species_index(name)
        # of sqrt(mu)/T^(1/4)
        fit = recentred(self.transport.get_viscosity_polynomial(index), 1.0)

        def value(T: Any) -> Any:
            root = polynomial(fit, np.log(T * (1.0 / T_FIT)))
            return np.sqrt(T) * (root * root)

        return value

    def conductivity(self, name: str) -> Property:
        """Return the conductivity of a pure species [W/m/K]."""
        fit = recentred(
            self.transport.get_thermal_conductivity_polynomial(
                self.gas.species_index(name)
            ),
            1.0,
        )
        return lambda T: np.sqrt(T) * polynomial(fit, np.log(T * (1.0 / T_FIT)))

    def pair(self, first: str, second: str) -> Property:
        """Return D p [m2/s Pa] of a pair of species."""
        i, j = self.gas.species_index(first), self.gas.species_index(second)
        fit = recentred(self.transport.get_binary_diff_coeffs_polynomial(i, j), 1.0)
        return lambda T: T * (np.sqrt(T) * polynomial(fit, np.log(T * (1.0 / T_FIT))))


@lru_cache(maxsize=4)
def _read(mechanism: str, changed: int) -> Mechanism:
    """Read a mechanism whose file was `changed` at a time; 0 of Cantera's own."""
    gas, _ = cantera_gas(mechanism, transport=False)
    return Mechanism(gas, tuple(gas.species_names), mechanism)


def density(p: Any, molar_mass: Any, T: Any) -> Any:
    """Return the density of an ideal gas [kg/m3]."""
    return p * molar_mass / (R_GAS * T)


def _weighted(
    x: Sequence[Any], values: Sequence[Any], mu: Sequence[Any], M: Sequence[float]
) -> Any:
    """Return sum_k x_k v_k/sum_j x_j phi_kj with the factors phi_kj of Wilke for
    `mu`, in proportion to viscosities.
    """
    root = [np.sqrt(mu_k) for mu_k in mu]
    total: Any = 0.0
    for k, x_k in enumerate(x):
        below = x_k + TRACE
        for j, x_j in enumerate(x):
            if j != k:
                both = 1.0 + root[k] / root[j] * (M[j] / M[k]) ** 0.25
                below = below + x_j * (both * both) * (
                    1.0 / math.sqrt(8.0 * (1.0 + M[k] / M[j]))
                )
        total = total + x_k * values[k] / below
    return total
