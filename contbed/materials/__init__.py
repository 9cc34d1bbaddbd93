"""Materials: density, heat capacity, enthalpy, viscosity and conductivity as functions
    of temperature.

Each has these methods of T [K], a number, an array or a dual number: density [kg/m3],
heat_capacity [J/kg/K], enthalpy [J/kg], its exact integral whose reference differs by
material, conductivity [W/m/K], of fluids viscosity [Pa s], and share_outside, the share
of the points of T outside of T_range [K], which are evaluated all the same. `constant`
is True when no property depends on T: then the heat problem is linear. Cantera, CoolProp
and scipy are imported only by the material that needs them.
"""

from __future__ import annotations

from .constant import ConstantFluid
from .coolprop import RealFluid, real_fluid
from .gas import GasMixture, gas_mixture
from .pointwise import pointwise
from .solid import Solid

__all__ = [
    "ConstantFluid",
    "GasMixture",
    "RealFluid",
    "Solid",
    "gas_mixture",
    "pointwise",
    "real_fluid",
]
