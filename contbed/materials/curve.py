"""Properties over temperature: numbers, polynomials, tables, and the latent heat of a
material that melts. Each has its exact integral, so that balances of heat close.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.scene.property_table import Melting, PropertyTable

from .common import integrated, polynomial
from .pointwise import pointwise

Function = Callable[[Any], Any]


Property = float | Sequence[float] | PropertyTable


@dataclass(frozen=True, init=False, eq=False)
class Curve:
    """A table of a property: linear between its temperatures, constant beyond.

    `integral` is its exact integral from 0 K.
    """

    T: Array
    values: Array
    _slopes: Array = field(repr=False)
    _sums: Array = field(repr=False)

    def __init__(self, temperatures: Sequence[float], values: Sequence[float]):
        T, y = np.array(temperatures, float), np.array(values, float)
        pieces = 0.5 * (y[1:] + y[:-1]) * np.diff(T)
        slopes = np.concatenate([[0.0], np.diff(y) / np.diff(T), [0.0]])
        sums = y[0] * T[0] + np.concatenate([[0.0], np.cumsum(pieces)])
        made = {"T": T, "values": y, "_slopes": slopes, "_sums": sums}
        for key, value in made.items():
            object.__setattr__(self, key, value)

    def __call__(self, T: Any) -> Any:
        """Return the property at temperatures [K]."""
        return pointwise(self._value, self._slope, T)

    def integral(self, T: Any) -> Any:
        """Return the integral of the property from 0 K to temperatures [K]."""
        return pointwise(self._integral, self._value, T)

    def _value(self, T: Any) -> Any:
        return np.interp(T, self.T, self.values)

    def _slope(self, T: Any) -> Any:
        return self._slopes[np.searchsorted(self.T, T, side="right")]

    def _integral(self, T: Any) -> Any:
        after = np.searchsorted(self.T, T, side="right")
        k = np.maximum(after - 1, 0)
        distance = T - self.T[k]
        slope = self._slopes[after]
        return self._sums[k] + distance * (self.values[k] + 0.5 * slope * distance)


@dataclass(eq=False)
class LatentHeat:
    """Heat of melting as an effective heat capacity, spread over a range of
    temperature.

        c = L/w 30 s^2 (1 - s)^2,    h = L s^3 (10 - 15 s + 6 s^2),    s = (T - T_start)/w

    within the range of width w: h rises from 0 to exactly L, twice continuously
    differentiable. h/L is the share that has melted.
    """

    heat: float  # L [J/kg]
    start: float  # [K], all solid below
    end: float  # [K], all liquid above
    # [K] in place of both while a steady state is followed to them
    spread: tuple[float, float] | None = None

    def heat_capacity(self, T: Any) -> Any:
        """Return the part of the heat capacity [J/kg/K]."""
        return pointwise(self._capacity, self._slope, T)

    def enthalpy(self, T: Any) -> Any:
        """Return the heat taken up by melting [J/kg]."""
        return pointwise(self._enthalpy, self._capacity, T)

    @property
    def _range(self) -> tuple[float, float]:
        return self.spread or (self.start, self.end)

    @property
    def _width(self) -> float:
        low, high = self._range
        return high - low

    def _share(self, T: Any) -> Any:
        share = (T - self._range[0]) / self._width
        return np.minimum(np.maximum(share, 0.0), 1.0)

    def _enthalpy(self, T: Any) -> Any:
        s = self._share(T)
        return self.heat * s * s * s * (10.0 + s * (6.0 * s - 15.0))

    def _capacity(self, T: Any) -> Any:
        s = self._share(T)
        rest = s * (1.0 - s)
        return 30.0 * self.heat / self._width * rest * rest

    def _slope(self, T: Any) -> Any:
        s = self._share(T)
        scale = 60.0 * self.heat / self._width**2
        return scale * s * (1.0 - s) * (1.0 - 2.0 * s)


def latent_heat_of(melting: Melting | None) -> LatentHeat | None:
    """Return the latent heat of a table of a scene, None without one."""
    if melting is None:
        return None
    return LatentHeat(melting.latent_heat, melting.start, melting.end)


def function_of(given: Property, latent: LatentHeat | None = None) -> Function:
    """Return a property as a function of temperature [K], a heat capacity with
    latent heat.
    """
    own = _own(given)[0]
    return own if latent is None else lambda T: own(T) + latent.heat_capacity(T)


def integral_of(
    given: Property, latent: LatentHeat | None = None, start: float = 0.0
) -> Function:
    """Return the exact integral of a property from a temperature `start` [K] as a
    function of temperature, that of a heat capacity with latent heat.
    """
    if isinstance(given, float) and latent is None and start:
        return lambda T: given * (T - start)
    own = _own(given)[1]
    whole = own if latent is None else lambda T: own(T) + latent.enthalpy(T)
    below = whole(start)
    return (lambda T: whole(T) - below) if start else whole


def _own(given: Property) -> tuple[Function, Function]:
    """Return a property and its integral."""
    if isinstance(given, int | float):
        given = (float(given),)
    if isinstance(given, Sequence):
        coefficients = tuple(given)
        whole = integrated(coefficients)
        return partial(polynomial, coefficients), partial(polynomial, whole)
    curve = Curve(given.temperatures, given.values)
    return curve, curve.integral
