"""A solid whose properties are constant, polynomials or tables over temperature."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.scene.property_table import PropertyTable

from .common import (
    Range,
    checked_positive,
    checked_range,
    polynomial,
    share_outside,
)
from .curve import (
    Function,
    LatentHeat,
    Property,
    function_of,
    integral_of,
)


@dataclass(frozen=True, init=False)
class Solid:
    """Each property a number, the coefficients (a0, a1, ...) of a0 + a1 T + a2 T^2 + ...
    with T in K, or a table over temperature.

    Parameters
    ----------
    density : [kg/m3]
    heat_capacity : [J/kg/K]
    conductivity : [W/m/K]
    T_range : [K], where polynomials and tables hold; polynomials must be positive there
    latent_heat : of melting, beside the heat capacity
    """

    constant: bool
    T_range: Range
    name: str
    source: str
    latent_heat: LatentHeat | None
    _given: tuple[tuple[float, ...] | PropertyTable, ...]
    _density: Function = field(compare=False, repr=False)
    _heat_capacity: Function = field(compare=False, repr=False)
    _conductivity: Function = field(compare=False, repr=False)
    _enthalpy: Function = field(compare=False, repr=False)

    def __init__(
        self,
        density: Property,
        heat_capacity: Property,
        conductivity: Property,
        T_range: Sequence[float] = (0.0, math.inf),
        name: str = "solid",
        source: str = "given in the scene",
        latent_heat: LatentHeat | None = None,
    ):
        limits = checked_range(T_range, name)
        rho = _checked(density, limits, f"{name}: density", "kg/m3")
        cp = _checked(heat_capacity, limits, f"{name}: heat_capacity", "J/kg/K")
        k = _checked(conductivity, limits, f"{name}: conductivity", "W/m/K")
        numbers = all(isinstance(a, tuple) and len(a) == 1 for a in (rho, cp, k))
        values = {
            "constant": numbers and latent_heat is None,
            "T_range": limits,
            "name": name,
            "source": source,
            "latent_heat": latent_heat,
            "_given": (rho, cp, k),
            "_density": function_of(rho),
            "_heat_capacity": function_of(cp, latent_heat),
            "_conductivity": function_of(k),
            "_enthalpy": integral_of(cp, latent_heat),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    def density(self, T: Any) -> Any:
        """Return the density [kg/m3]."""
        return self._density(T)

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/kg/K], with the latent heat."""
        return self._heat_capacity(T)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy [J/kg], 0 at 0 K; the exact integral of heat_capacity."""
        return self._enthalpy(T)

    def conductivity(self, T: Any) -> Any:
        """Return the conductivity [W/m/K]."""
        return self._conductivity(T)

    def share_outside(self, T: Any) -> float:
        """Return the share of the points of T outside T_range."""
        return share_outside(T, self.T_range)


def _checked(
    given: Property, T_range: Range, what: str, unit: str
) -> tuple[float, ...] | PropertyTable:
    """Return a table as it is, or the coefficients of a polynomial without trailing
    zeros, checked to be positive over a bounded range.
    """
    if isinstance(given, (int, float)):
        return (checked_positive(given, what, unit),)
    if not isinstance(given, Sequence):
        return given
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
