"""Forms of thermodynamic data in Cantera's files other than two NASA polynomials of 7
coefficients: NASA polynomials of 9, the Shomate equation and constant heat capacities.
All are one expression, on one or several ranges of temperature.

Sources: McBride, Zehe and Gordon 2002, NASA/TP-2002-211556; Chase 1998, NIST-JANAF
Thermochemical Tables, 4th edition.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.materials.common import R_GAS, integrated, polynomial
from contbed.materials.pointwise import pointwise


@dataclass(frozen=True)
class Form:
    """Data of one species on one range of temperature, per mole.

    c_p = b/T^2 + c/T + a_0 + a_1 T + ... + a_4 T^4                     [J/mol/K]
    h = -b/T + c ln T + a_0 T + a_1 T^2/2 + ... + h_0                     [J/mol]
    s = -b/(2 T^2) - c/T + a_0 ln T + a_1 T + ... + s_0                 [J/mol/K]
    """

    a: tuple[float, ...]
    h_0: float
    s_0: float
    b: float = 0.0
    c: float = 0.0

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/mol/K]."""
        return (self.b / T + self.c) / T + polynomial(self.a, T)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy, heat of formation included [J/mol]."""
        rest = polynomial(integrated(self.a, self.h_0), T)
        return self.c * np.log(T) - self.b / T + rest

    def entropy(self, T: Any) -> Any:
        """Return the entropy at standard pressure [J/mol/K]."""
        rest = self.a[0] * np.log(T) + polynomial(integrated(self.a[1:], self.s_0), T)
        return rest - (self.b / (2.0 * T) + self.c) / T


def has_nasa7(data: Any) -> bool:
    """Return whether data of Cantera are two NASA polynomials of 7 coefficients."""
    return type(data).__name__ == "NasaPoly2"


def forms_of(name: str, data: Any) -> tuple[tuple[float, ...], tuple[Form, ...]]:
    """Return the ends of the ranges [K] of data of Cantera, and the form on each.

    Raises
    ------
    SceneError : data of another kind
    """
    kind, values = type(data).__name__, [float(each) for each in data.coeffs]
    ends: tuple[float, ...] = (data.min_temp, data.max_temp)
    if kind == "ConstantCp":
        T, h, s, cp = values[0], *(1e-3 * each for each in values[1:])  # per kmol
        return ends, (Form((cp, 0.0), h - cp * T, s - cp * math.log(T)),)
    if kind == "ShomatePoly2":
        parts = values[1:8], values[8:15]
        return (ends[0], values[0], ends[1]), tuple(_shomate(part) for part in parts)
    if kind == "Nasa9PolyMultiTempRegion":
        zones = [values[1 + 11 * k : 12 + 11 * k] for k in range(int(values[0]))]
        ends = (zones[0][0], *(zone[1] for zone in zones))
        return ends, tuple(_nasa9(zone[2:]) for zone in zones)
    raise SceneError(
        f"{name}: thermodynamics of the form {kind} are not read; NASA polynomials of "
        "7 or 9 coefficients, the Shomate equation and a constant heat capacity are"
    )


def _shomate(values: Sequence[float]) -> Form:
    """Return the Shomate equation, which is in T/1000 K, as a form."""
    A, B, C, D, E, F, G = values
    a = (A, 1e-3 * B, 1e-6 * C, 1e-9 * D)
    return Form(a, 1e3 * F, G - A * math.log(1e3), b=1e6 * E)


def _nasa9(values: Sequence[float]) -> Form:
    """Return a NASA polynomial of 9 coefficients, divided by R, as a form."""
    b, c, *a, h_0, s_0 = (R_GAS * value for value in values)
    return Form(tuple(a), h_0, s_0, b, c)


@dataclass(frozen=True, eq=False)
class Ranges:
    """One species by a form for each range of temperature.

    Enthalpy and entropy of the lowest range are continued upwards, as published data
    differ a little where ranges meet. Beyond the ends the heat capacity is constant.
    """

    name: str
    composition: Mapping[str, float]
    molar_mass: float  # [kg/mol]
    forms: tuple[Form, ...]
    ends: tuple[float, ...]  # [K], one more than forms
    standard_pressure: float
    has_entropy: bool = True

    @property
    def T_range(self) -> tuple[float, float]:
        """Range of temperature [K] of the data."""
        return self.ends[0], self.ends[-1]

    def _within(self, T: Any) -> Any:
        return np.minimum(np.maximum(T, self.ends[0]), self.ends[-1])

    def _chosen(self, values: Sequence[Any], T: Any) -> Any:
        """Return the value of the range that T lies in."""
        chosen = values[0]
        for end, value in zip(self.ends[1:-1], values[1:], strict=True):
            chosen = np.where(end < T, value, chosen)
        return chosen

    def _continued(self, of: Callable[[Form], Callable[[Any], Any]], T: Any) -> Any:
        """Return a property that rises continuously from one range to the next."""
        values, shift = [of(self.forms[0])(T)], 0.0
        for k, end in enumerate(self.ends[1:-1]):
            below, above = of(self.forms[k]), of(self.forms[k + 1])
            shift += float(below(end)) - float(above(end))
            values.append(above(T) + shift)
        return self._chosen(values, T)

    def _cp(self, T: Any) -> Any:
        t = self._within(T)
        return self._chosen([form.heat_capacity(t) for form in self.forms], t)

    def _cp_slope(self, T: Any) -> Any:
        step = 1e-5 * T
        return (self._cp(T + step) - self._cp(T - step)) / (2.0 * step)

    def _h(self, T: Any) -> Any:
        t = self._within(T)
        return self._continued(lambda form: form.enthalpy, t) + self._cp(t) * (T - t)

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/mol/K]."""
        return pointwise(self._cp, self._cp_slope, T)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy, heat of formation included [J/mol]."""
        return pointwise(self._h, self._cp, T)

    def gibbs(self, T: Any) -> Any:
        """Return the Gibbs energy at standard pressure [J/mol]; T is a plain number
        or array.
        """
        t = self._within(T)
        s = self._continued(lambda form: form.entropy, t)
        return self._h(T) - T * (s + self._cp(t) * np.log(T / t))
