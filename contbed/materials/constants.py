"""The gas of a scene: properties as functions of temperature, or as constants, those
given or those at one temperature.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from contbed.errors import SceneError
from contbed.materials.common import FAR, extrapolation
from contbed.materials.constant import ConstantFluid
from contbed.scene.gas import GasCantera, GasConstant, GasCoolProp
from contbed.scene.toml_lines import Origin


class Constants(NamedTuple):
    """Density [kg/m3], viscosity [Pa s], heat capacity [J/kg/K] and
    conductivity [W/m/K], None where not given; a warning where they are extrapolated.
    """

    density: float
    viscosity: float
    heat_capacity: float | None
    conductivity: float | None
    extrapolated: str = ""


def constants_of(
    gas: GasConstant | GasCantera | GasCoolProp, T: float | None, base: Path
) -> Constants:
    """Return the properties of the gas of a scene in the folder `base` at the
    temperature T [K].

    Raises
    ------
    SceneError : the properties vary, and T is not given or out of their range
    """
    if isinstance(gas, GasConstant):
        return Constants(
            gas.density, gas.viscosity, gas.heat_capacity, gas.conductivity
        )
    if T is None:
        raise SceneError(
            "properties are taken at one temperature: give gas.reference_temperature"
        )
    return _at(gas, T, base)


@lru_cache(maxsize=16)
def _at(gas: GasCantera | GasCoolProp, T: float, base: Path) -> Constants:
    """Return the properties of a gas that varies with temperature."""
    fluid = _varying(gas, base)
    low, high = fluid.T_range
    reach = FAR if isinstance(gas, GasCantera) else 0.0
    if not low - reach <= T <= high + reach:
        raise SceneError(
            f"properties of {fluid.name} are known from {low:g} to {high:g} K, not at "
            f"{T:g} K"
        )
    return Constants(
        float(fluid.density(T)),
        float(fluid.viscosity(T)),
        float(fluid.heat_capacity(T)),
        float(fluid.conductivity(T)),
        extrapolation(fluid.name, fluid.heat_capacity, fluid.T_range, T),
    )


def fluid_of(gas: GasConstant | GasCantera | GasCoolProp, origin: Origin) -> Any:
    """Return the properties of the gas of a scene as functions of temperature; Cantera
    and CoolProp are imported only when named.

    Raises
    ------
    SceneError : with the line of the key, a fluid, mechanism or range that is not known
    """
    if isinstance(gas, GasConstant):
        conductivity = 1.0 if gas.conductivity is None else gas.conductivity
        return ConstantFluid(
            gas.density, gas.heat_capacity or 1.0, gas.viscosity, conductivity
        )
    key = "name" if isinstance(gas, GasCoolProp) else "composition"
    with origin.blamed("gas", key):
        return _varying(gas, origin.base)


def _varying(gas: GasCantera | GasCoolProp, base: Path) -> Any:
    if isinstance(gas, GasCoolProp):
        from contbed.materials.coolprop import real_fluid

        return real_fluid(gas.name, gas.pressure, gas.T_range)
    return mixture_of(gas, base)


def mixture_of(gas: GasCantera, base: Path) -> Any:
    """Return the mixture of a [gas] table, with the constants that it gives in place of
    transport data; `base` is the folder of the scene.
    """
    from contbed.scene.mechanism import changed_at, find_mechanism

    mechanism = find_mechanism(gas.mechanism, base)
    return _mixture(
        gas.composition,
        gas.pressure,
        mechanism,
        gas.viscosity,
        gas.conductivity,
        changed_at(mechanism),
    )


@lru_cache(maxsize=16)
def _mixture(
    composition: str,
    pressure: float,
    mechanism: str,
    viscosity: float | None,
    conductivity: float | None,
    changed: int,
) -> Any:
    """Return a mixture, whose mechanism, `changed` at a time, takes long to read."""
    from contbed.materials.gas import gas_mixture

    return gas_mixture(composition, pressure, mechanism, viscosity, conductivity)
