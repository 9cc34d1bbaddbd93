"""The [gas] table, which may also be a liquid: constants, a material, a Cantera
mixture or a CoolProp fluid.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from contbed.scene.humid_air import AIR, HUMID_AIR, HumidAir
from contbed.scene.quantities import (
    Composition,
    Conductivity,
    Density,
    HeatCapacity,
    Pressure,
    Table,
    Temperature,
    Viscosity,
)
from contbed.scene.tables import from_library, names_material


class GasConstant(Table):
    """A gas or liquid with constant properties, given or those of a material at a
    temperature.
    """

    model: Literal["constant"] = "constant"
    """gas or liquid with constant properties"""
    material: str | None = None
    """liquid of the library; keys that are given replace its properties"""
    material_temperature: Temperature | None = None
    """at which the properties of the material are taken"""
    density: Density
    """density of the fluid"""
    viscosity: Viscosity
    """dynamic viscosity of the fluid"""
    heat_capacity: HeatCapacity | None = None
    """needed with a [heat] table"""
    conductivity: Conductivity | None = None
    """needed with a [heat] table"""

    @model_validator(mode="before")
    @classmethod
    def _material(cls, values: Any) -> Any:
        if isinstance(values, dict) and ("material" in values) != (
            "material_temperature" in values
        ):
            raise ValueError("material and material_temperature belong together")
        if not names_material(values):
            return values
        return from_library("fluid", values) | values


class GasCantera(HumidAir):
    """An ideal-gas mixture with the polynomials of a Cantera mechanism."""

    model: Literal["cantera"] = "cantera"
    """ideal gas mixture with properties by Cantera"""
    composition: Composition
    """mole fractions, "N2:0.79, O2:0.21"
    """
    pressure: Pressure = 101325.0
    """absolute pressure of the gas, at which its properties are taken everywhere"""
    mechanism: str = "gri30.yaml"
    """Cantera mechanism with the species: a name or a YAML file"""
    viscosity: Viscosity | None = None
    """constant; absent: of the transport data of the mechanism"""
    conductivity: Conductivity | None = None
    """constant; absent: of the transport data of the mechanism"""


class GasCoolProp(Table):
    """A real fluid at constant pressure from CoolProp."""

    model: Literal["coolprop"]
    """real fluid with properties by CoolProp"""
    name: str
    """of the fluid in CoolProp: Water, steam, INCOMP::TVP1 (oil), INCOMP::MEG-30%
    (brine), Nitrogen[0.79]&Oxygen[0.21]"""
    pressure: Pressure = 101325.0
    """absolute pressure of the fluid"""
    T_range: tuple[Temperature, Temperature]
    """temperatures to tabulate, one phase only"""


def with_its_model(values: Any) -> Any:
    """Return a [gas] table with its model: "cantera" with a composition or air,
    else "constant".
    """
    if isinstance(values, dict) and (
        "composition" in values or values.get("material") in (AIR, HUMID_AIR)
    ):
        return _of_composition(values)
    return {"model": "constant"} | values if isinstance(values, dict) else values


def _of_composition(values: Any) -> Any:
    """Return a [gas] table of a model that takes mixtures only."""
    return {"model": "cantera"} | values if isinstance(values, dict) else values


GasOfComposition = Annotated[GasCantera, BeforeValidator(_of_composition)]

Gas = Annotated[
    GasConstant | GasCantera | GasCoolProp,
    Field(discriminator="model"),
    BeforeValidator(with_its_model),
]
