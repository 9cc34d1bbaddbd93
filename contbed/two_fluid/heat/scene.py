"""The vocabulary of heat in a two-fluid scene: the [heat] table, and what other tables say with it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from contbed.scene.quantities import Conductivity, HeatCapacity, HeatFlux, Pressure, Table, Temperature, takes, unit
from contbed.scene.tables import Named, NonNegativeOrClosure


class Heat(Table):
    """Temperatures of gas and particles; without this table they stay and nothing is computed."""

    heat_capacity_gas: HeatCapacity
    heat_capacity_solid: HeatCapacity
    conductivity_gas: Annotated[float, *unit("W/m/K"), Field(gt=0)] = Field(description="of the gas itself")
    conductivity_solid: Conductivity | None = Field(None, description="of a particle; for conductivity_bed")
    nusselt: NonNegativeOrClosure = Field("nusselt_gunn", description="exchange, Nu = h diameter/conductivity_gas")
    conductivity_bed: Named | None = Field(
        None,
        description="of the bed at rest; the gas has (1 - sqrt(eps_s)) conductivity_gas of it, particles the rest",
        json_schema_extra=takes("conductivity"),
    )
    effective_gas: Conductivity = Field(0.0, description="conductivity of the gas; its fraction of it conducts")
    effective_solid: Conductivity = Field(0.0, description="conductivity of the particles; their fraction conducts")
    density: Literal["constant", "ideal_gas"] = Field(
        "constant", description='"ideal_gas": gas.density is that at T_reference and pressure'
    )
    T_reference: Temperature | None = Field(None, description="absent: initial.T_gas")
    pressure: Pressure = Field(101325.0, description="outside of the outlet, or in a closed bed at the start")


def conducts(heat: Heat) -> bool:
    """Whether any heat is conducted."""
    return heat.conductivity_bed is not None or heat.effective_gas + heat.effective_solid > 0


class Temperatures(Table):
    """Of both phases, where there is [heat]."""

    T_gas: Temperature | None = None
    T_solid: Temperature | None = Field(None, description="absent: as the gas")


class HeatOfWall(Table):
    """What a wall does, where there is [heat]; adiabatic otherwise."""

    T: Temperature | None = Field(None, description="heat is conducted to the wall at this temperature")
    heat_flux: HeatFlux | None = Field(None, description="into the bed; the phases share it by their fractions")
