"""A solid with constant or polynomial properties."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.errors import SceneError

from .common import (
    Range,
    checked_positive,
    checked_range,
    integrated,
    polynomial,
    share_outside,
)

Property = float | Sequence[float]


@dataclass(frozen=True, init=False)
class Solid:
    """Each property a number, or the coefficients (a0, a1, ...) of a0 + a1 T + a2
    T^2 + ... with T in K.

    Parameters
    ----------
    density : [kg/m3]
    heat_capacity : [J/kg/K]
    conductivity : [W/m/K]
    T_range : [K], where the polynomials hold; they must be positive there
    """

    constant: bool
    T_range: Range
    name: str
    source: str
    _density: tuple[float, ...]
    _heat_capacity: tuple[float, ...]
    _conductivity: tuple[float, ...]
    _enthalpy: tuple[float, ...]

    def __init__(
        self,
        density: Property,
        heat_capacity: Property,
        conductivity: Property,
        T_range: Sequence[float] = (0.0, math.inf),
        name: str = "solid",
        source: str = "given in the scene",
    ):
        limits = checked_range(T_range, name)
        rho = _coefficients(density, limits, f"{name}: density", "kg/m3")
        cp = _coefficients(heat_capacity, limits, f"{name}: heat_capacity", "J/kg/K")
        k = _coefficients(conductivity, limits, f"{name}: conductivity", "W/m/K")
        values = {
            "constant": all(len(a) == 1 for a in (rho, cp, k)),
            "T_range": limits,
            "name": name,
            "source": source,
            "_density": rho,
            "_heat_capacity": cp,
            "_conductivity": k,
            "_enthalpy": integrated(cp),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    def density(self, T: Any) -> Any:
        """Return the density [kg/m3]."""
        return polynomial(self._density, T)

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/kg/K]."""
        return polynomial(self._heat_capacity, T)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy [J/kg], 0 at 0 K; the exact integral of heat_capacity."""
        return polynomial(self._enthalpy, T)

    def conductivity(self, T: Any) -> Any:
        """Return the conductivity [W/m/K]."""
        return polynomial(self._conductivity, T)

    def share_outside(self, T: Any) -> float:
        """Return the share of the points of T outside T_range."""
        return share_outside(T, self.T_range)


def _coefficients(
    given: Property, T_range: Range, what: str, unit: str
) -> tuple[float, ...]:
    """Return the coefficients without trailing zeros, checked to be positive over a
    bounded range.
    """
    if isinstance(given, (int, float)):
        return (checked_positive(given, what, unit),)
    a = tuple(float(c) for c in given)
    while len(a) > 1 and a[-1] == 0.0:
        a = a[:-1]
    if not a or not all(math.isfinite(c) for c in a):
        raise SceneError(
            f"{what} is {list(given)}; give one or more finite coefficients a0, a1, "
            f"... in {unit} and K"
        )
    if len(a) == 1:
        return (checked_positive(a[0], what, unit),)
    if math.isfinite(T_range[1]):
        T = np.linspace(*T_range, 401)
        values = polynomial(a, T)
        worst = int(np.argmin(values))
        if values[worst] <= 0.0:
            raise SceneError(
                f"{what} falls to {values[worst]:.4g} {unit} at {T[worst]:.4g} K, "
                "inside T_range "
                f"({T_range[0]:g}, {T_range[1]:g}) K; correct the coefficients (T in "
                "K) or narrow T_range"
            )
    return a
