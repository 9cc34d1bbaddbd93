"""A fluid whose properties do not depend on temperature: the heat problem stays
linear.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from .common import Range, checked_positive, share_outside


@dataclass(frozen=True, init=False)
class ConstantFluid:
    """Constant properties; every method but `enthalpy` returns a Python float, whatever
    T is.

    Parameters
    ----------
    density : [kg/m3]
    heat_capacity : [J/kg/K]
    viscosity : [Pa s]
    conductivity : [W/m/K]
    """

    constant: ClassVar[bool] = True
    T_range: ClassVar[Range] = (0.0, math.inf)
    name: str
    source: str
    _density: float
    _heat_capacity: float
    _viscosity: float
    _conductivity: float

    def __init__(
        self,
        density: float,
        heat_capacity: float,
        viscosity: float,
        conductivity: float,
        name: str = "constant fluid",
        source: str = "given in the scene",
    ):
        values = {
            "name": name,
            "source": source,
            "_density": checked_positive(density, f"{name}: density", "kg/m3"),
            "_heat_capacity": checked_positive(
                heat_capacity, f"{name}: heat_capacity", "J/kg/K"
            ),
            "_viscosity": checked_positive(viscosity, f"{name}: viscosity", "Pa s"),
            "_conductivity": checked_positive(
                conductivity, f"{name}: conductivity", "W/m/K"
            ),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    def density(self, T: Any) -> float:
        """Return the density [kg/m3]."""
        return self._density

    def heat_capacity(self, T: Any) -> float:
        """Return the heat capacity [J/kg/K]."""
        return self._heat_capacity

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy [J/kg], 0 at 0 K."""
        return self._heat_capacity * T

    def viscosity(self, T: Any) -> float:
        """Return the viscosity [Pa s]."""
        return self._viscosity

    def conductivity(self, T: Any) -> float:
        """Return the conductivity [W/m/K]."""
        return self._conductivity

    def share_outside(self, T: Any) -> float:
        """Return the share of the points of T outside T_range."""
        return share_outside(T, self.T_range)
