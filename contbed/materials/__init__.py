"""Materials: density, heat capacity, enthalpy, viscosity and conductivity as functions
    of temperature.

T [K] may be a number, an array or a dual number. Cantera, CoolProp and scipy are
imported only by the material that needs them.
"""

from __future__ import annotations

from typing import Any, Protocol

from .constant import ConstantFluid
from .coolprop import RealFluid, real_fluid
from .gas import GasMixture, gas_mixture
from .pointwise import pointwise
from .solid import Solid

__all__ = [
    "ConstantFluid",
    "Fluid",
    "GasMixture",
    "Material",
    "RealFluid",
    "Solid",
    "gas_mixture",
    "pointwise",
    "real_fluid",
]


class Material(Protocol):
    """The properties of any material, at its fixed pressure."""

    @property
    def constant(self) -> bool:
        """True when no property depends on T: then the heat problem is linear."""

    @property
    def name(self) -> str:
        """Name for messages and results."""
        ...

    @property
    def T_range(self) -> tuple[float, float]:
        """Range of temperature [K] in which the properties hold, ends included."""

    @property
    def source(self) -> str:
        """Source of the properties."""
        ...

    def density(self, T: Any) -> Any:
        """Return the density [kg/m3]."""

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/kg/K]."""

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy [J/kg], the exact integral of heat_capacity; the
        reference differs by material.
        """

    def conductivity(self, T: Any) -> Any:
        """Return the conductivity [W/m/K]."""

    def share_outside(self, T: Any) -> float:
        """Return the share of the points of T outside T_range; they are evaluated
        all the same.
        """


class Fluid(Material, Protocol):
    """A material that flows."""

    def viscosity(self, T: Any) -> Any:
        """Return the viscosity [Pa s]."""
