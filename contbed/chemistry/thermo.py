"""Enthalpy, heat capacity and entropy of single species as functions of temperature,
heats of formation included.

NASA polynomials of 7 and 9 coefficients, the Shomate equation, and a constant heat
capacity. T [K] may be a number, an array or a dual number. Beyond the ends of its
data a species keeps its heat capacity constant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from contbed.materials.common import R_GAS as R_GAS
from contbed.materials.common import integrated, polynomial
from contbed.materials.forms import Ranges, forms_of, has_nasa7
from contbed.materials.pointwise import pointwise

T_STANDARD = 298.15  # reference of heats of formation [K]
# enthalpies at one temperature that are kept; a scene has some ten species and feeds
MAX_KNOWN = 1024
# temperatures [K] above the mid temperature over which the jump of two NASA polynomials
# is spread
BLEND = 2.0


class Thermo(Protocol):
    """Thermodynamics of one species."""

    @property
    def name(self) -> str:
        """Name for messages and results."""
        ...

    @property
    def composition(self) -> Mapping[str, float]:
        """Atoms of each element."""
        ...

    @property
    def molar_mass(self) -> float:
        """Molar mass [kg/mol]."""
        ...

    @property
    def T_range(self) -> tuple[float, float]:
        """Range of temperature [K] of the data."""
        ...

    @property
    def has_entropy(self) -> bool:
        """Whether the data give an entropy, which equilibrium needs."""
        ...

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/mol/K]."""

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy, heat of formation included [J/mol]."""

    def gibbs(self, T: Any) -> Any:
        """Return the Gibbs energy at standard pressure [J/mol]; T is a plain number
        or array.
        """


def _within(x: Any, low: float, high: float) -> Any:
    """Return x within bounds: a third of the time of numpy's clip for few points."""
    return np.minimum(np.maximum(x, low), high)


def _derivative(coefficients: tuple[float, ...]) -> list[float]:
    return [n * a for n, a in enumerate(coefficients)][1:]


@dataclass(frozen=True, eq=False)
class Species:
    """One species by two NASA polynomials, per mole and divided by R.

    The upper ones are continued from the lower ones over the mid temperature. `h_jump`
    and `s_jump` are what the published coefficients differ by there, some 10 J/kg: they
    are left out (zero), or added over the next `BLEND` K, so that the published values
    hold elsewhere and no function of T jumps.
    """

    name: str
    composition: Mapping[str, float]
    molar_mass: float  # [kg/mol]
    T_range: tuple[float, float]
    T_mid: float
    cp: tuple[tuple[float, ...], tuple[float, ...]]
    h: tuple[tuple[float, ...], tuple[float, ...]]
    s: tuple[float, float]  # constants of the entropy
    h_jump: float = 0.0
    s_jump: float = 0.0
    standard_pressure: float = 101325.0  # [Pa]
    has_entropy: bool = True

    def _of(self, polynomials: Any, T: Any) -> Any:
        t = _within(T, *self.T_range)
        return np.where(
            t > self.T_mid, polynomial(polynomials[1], t), polynomial(polynomials[0], t)
        )

    def _share(self, T: Any) -> Any:
        """Return the share of the jump that is added: a smooth step from 0 to 1
        above the mid temperature.
        """
        s = _within((T - self.T_mid) / BLEND, 0.0, 1.0)
        return s * s * (3.0 - 2.0 * s)

    def _share_slope(self, T: Any) -> Any:
        s = _within((T - self.T_mid) / BLEND, 0.0, 1.0)
        return 6.0 * s * (1.0 - s) / BLEND

    def _cp(self, T: Any) -> Any:
        return R_GAS * self._of(self.cp, T)

    def _cp_slope(self, T: Any) -> Any:
        inside = (self.T_range[0] <= T) & (self.T_range[1] >= T)
        return np.where(
            inside, R_GAS * self._of([_derivative(cp) for cp in self.cp], T), 0.0
        )

    def _h(self, T: Any) -> Any:
        h, beyond = R_GAS * self._of(self.h, T), T - _within(T, *self.T_range)
        if np.any(beyond):
            h = h + self._cp(T) * beyond
        return h + R_GAS * self.h_jump * self._share(T) if self.h_jump else h

    def _h_slope(self, T: Any) -> Any:
        return (
            self._cp(T) + R_GAS * self.h_jump * self._share_slope(T)
            if self.h_jump
            else self._cp(T)
        )

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/mol/K]."""
        return pointwise(self._cp, self._cp_slope, T)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy, heat of formation included [J/mol]."""
        return (
            _enthalpy(self, T)
            if isinstance(T, float)
            else pointwise(self._h, self._h_slope, T)
        )

    def entropy(self, T: Any) -> Any:
        """Return the entropy at standard pressure [J/mol/K]; T is a plain number or
        array.
        """
        t = _within(T, *self.T_range)
        parts = [
            cp[0] * np.log(t) + polynomial(integrated(cp[1:]), t) + constant
            for cp, constant in zip(self.cp, self.s, strict=True)
        ]
        s = R_GAS * np.where(t > self.T_mid, parts[1], parts[0]) + self._cp(T) * np.log(
            T / t
        )
        return s + R_GAS * self.s_jump * self._share(T) if self.s_jump else s

    def gibbs(self, T: Any) -> Any:
        """Return the Gibbs energy at standard pressure [J/mol]; T is a plain number
        or array.
        """
        return self._h(T) - T * self.entropy(T)


@lru_cache(maxsize=MAX_KNOWN)
def _enthalpy(species: Species, T: float) -> Any:
    """Return the enthalpy at one temperature: balances ask for that of each feed
    again and again.
    """
    return species._h(T)


def species_of(
    name: str, item: Any, molar_mass: float, with_jumps: bool = False
) -> Thermo:
    """Return a species of a Cantera file.

    Parameters
    ----------
    item : cantera.Species with NASA polynomials of 7 or 9 coefficients, the Shomate
        equation or a constant heat capacity
    molar_mass : [kg/mol]
    with_jumps : whether the values of the file are kept above the mid temperature,
        rather than continued

    Raises
    ------
    SceneError : the data have another form
    """
    data = item.thermo
    if not has_nasa7(data):
        return _other_form(name, item, molar_mass)
    c = data.coeffs
    T_mid, high, low = float(c[0]), c[1:8], c[8:15]
    cp = tuple(map(float, low[:5])), tuple(map(float, high[:5]))
    h_low = integrated(cp[0], float(low[5]))
    h_high = integrated(
        cp[1], float(polynomial(h_low, T_mid) - polynomial(integrated(cp[1]), T_mid))
    )

    def varying(k: int) -> float:
        return float(
            cp[k][0] * np.log(T_mid) + polynomial(integrated(cp[k][1:]), T_mid)
        )

    s_low = float(low[6])
    s_high = s_low + varying(0) - varying(1)
    return Species(
        name,
        dict(item.composition),
        molar_mass,
        (data.min_temp, data.max_temp),
        T_mid,
        cp,
        (h_low, h_high),
        (s_low, s_high),
        float(high[5]) - h_high[0] if with_jumps else 0.0,
        float(high[6]) - s_high if with_jumps else 0.0,
        float(data.reference_pressure),
    )


@dataclass(frozen=True, eq=False)
class Shomate:
    """One species by the Shomate equation, with t = T/1000 K.

        c_p = A + B t + C t^2 + D t^3 + E/t^2                               [J/mol/K]
        h = A t + B t^2/2 + C t^3/3 + D t^4/4 - E/t + F                     [kJ/mol]
        s = A ln t + B t + C t^2/2 + D t^3/3 - E/(2 t^2) + G                [J/mol/K]

    Source: Chase 1998, NIST-JANAF Thermochemical Tables, 4th ed., J. Phys. Chem. Ref.
        Data Monograph 9.
    """

    name: str
    composition: Mapping[str, float]
    molar_mass: float
    coefficients: tuple[float, ...]  # A to F, and G where the entropy is known
    T_range: tuple[float, float] = (200.0, 6000.0)
    standard_pressure: float = 1e5

    @property
    def has_entropy(self) -> bool:
        """Whether the data give an entropy."""
        return len(self.coefficients) > 6

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/mol/K]."""
        A, B, C, D, E = self.coefficients[:5]
        t = T * 1e-3
        return A + t * (B + t * (C + t * D)) + E / (t * t)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy, heat of formation included [J/mol]."""
        return pointwise(self._h, self.heat_capacity, T)

    def _h(self, T: Any) -> Any:
        A, B, C, D, E, F = self.coefficients[:6]
        t = T * 1e-3
        return 1e3 * (t * (A + t * (B / 2.0 + t * (C / 3.0 + t * D / 4.0))) - E / t + F)

    def gibbs(self, T: Any) -> Any:
        """Return the Gibbs energy at standard pressure [J/mol]; T is a plain number
        or array.
        """
        A, B, C, D, E, _, G = self.coefficients[:7]
        t = T * 1e-3
        s = (
            A * np.log(t)
            + t * (B + t * (C / 2.0 + t * D / 3.0))
            - E / (2.0 * t * t)
            + G
        )
        return self._h(T) - T * s


@dataclass(frozen=True, eq=False)
class ConstantHeatCapacity:
    """One species with c_p constant: h = h_298 + c_p (T - 298.15 K)."""

    name: str
    composition: Mapping[str, float]
    molar_mass: float
    cp: float  # [J/mol/K]
    formation: float = 0.0  # enthalpy at 298.15 K [J/mol]
    standard_entropy: float | None = None  # at 298.15 K [J/mol/K]
    T_range: tuple[float, float] = (0.0, np.inf)
    standard_pressure: float = 1e5

    @property
    def has_entropy(self) -> bool:
        """Whether the data give an entropy."""
        return self.standard_entropy is not None

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/mol/K]."""
        return self.cp

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy, heat of formation included [J/mol]."""
        return self.formation + self.cp * (T - T_STANDARD)

    def gibbs(self, T: Any) -> Any:
        """Return the Gibbs energy at standard pressure [J/mol]; T is a plain number
        or array.
        """
        return self.enthalpy(T) - T * (
            (self.standard_entropy or 0.0) + self.cp * np.log(T / T_STANDARD)
        )


def _other_form(name: str, item: Any, molar_mass: float) -> Ranges:
    """Return a species of a Cantera file whose data are not two NASA polynomials of 7
    coefficients.
    """
    ends, forms = forms_of(name, item.thermo)
    pressure = float(item.thermo.reference_pressure)
    return Ranges(name, dict(item.composition), molar_mass, forms, ends, pressure)


@dataclass(frozen=True)
class Equilibrium:
    """Equilibrium constant of a reaction from the thermodynamics of its species.

    `ln_K` refers to activities: gases p/p0 with p0 = 1 bar whatever the standard
    pressure of the data, solids pure.
    """

    stoichiometry: Mapping[str, float]
    species: Mapping[str, Thermo] = field(repr=False)
    gases: frozenset[str] = frozenset()
    factor: float = 1.0  # multiplies K

    def heat(self, T: Any) -> Any:
        """Return the heat of reaction [J/mol], negative where heat is released."""
        return sum(
            count * self.species[name].enthalpy(T)
            for name, count in self.stoichiometry.items()
        )

    def ln_K(self, T: Any) -> Any:
        """Return ln K at p0 = 1 bar; its slope is that of van 't Hoff."""
        shift = np.log(self.factor) + sum(
            count * np.log(self.species[name].standard_pressure / 1e5)  # type: ignore[attr-defined]
            for name, count in self.stoichiometry.items()
            if name in self.gases
        )

        def value(T: Any) -> Any:
            gibbs = sum(
                count * self.species[name].gibbs(T)
                for name, count in self.stoichiometry.items()
            )
            return shift - gibbs / (R_GAS * T)

        slope: Callable[[Any], Any] = lambda T: self.heat(T) / (R_GAS * T * T)  # noqa: E731
        return pointwise(value, slope, T)
