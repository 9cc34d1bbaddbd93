"""Tables of a reacting bed on its solids: data of species and constituents, one kind of particles, or several.

A bed is filled with one kind, [solid] with `bed.particle_diameter`, or with several, a table [solids.NAME] for each.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Discriminator, Field, Tag

from contbed.scene.quantities import (
    Conductivity,
    Density,
    FiniteFloat,
    Length,
    Number,
    Positive,
    Table,
    Viscosity,
    form,
    unit,
)
from contbed.scene.tables import NonNegativeOrClosure

MolarMass = Annotated[float, *unit("kg/mol"), Field(gt=0)]
MolarEnergy = Annotated[float, *unit("J/mol")]
MolarEntropy = Annotated[float, *unit("J/mol/K")]
MolarHeatCapacity = Annotated[float, *unit("J/mol/K"), Field(gt=0)]
HeatCapacityOfSolid = Annotated[float, *unit("J/kg/K"), Field(gt=0)]
Curve = Annotated[tuple[FiniteFloat, ...], Tag("list"), Field(min_length=1, max_length=4)]
Speed = Annotated[float, *unit("m/s")]


class Substance(Table):
    """Data of one species; what is absent comes from its formula, the mechanism or the thermodynamic tables."""

    elements: dict[str, Positive] | None = Field(None, description="atoms, {C = 1, H = 4}; absent: from the name")
    molar_mass: MolarMass | None = Field(None, description="absent: from the elements")
    shomate: tuple[FiniteFloat, ...] | None = Field(
        None,
        min_length=5,
        max_length=8,
        description="A to H of the Shomate equation, T/1000 K, J/mol/K and kJ/mol; F and G may be left out",
    )
    heat_capacity: MolarHeatCapacity | None = Field(None, description="constant, instead of shomate")
    enthalpy: MolarEnergy | None = Field(None, description="of formation at 298.15 K, with heat_capacity or A to E")
    entropy: MolarEntropy | None = Field(None, description="standard, at 298.15 K")
    density: Density | None = Field(None, description="of a solid without pores")
    viscosity: Annotated[Annotated[Viscosity, Tag("number")] | Curve, Discriminator(form)] | None = Field(
        None, description="of a gas; a list is c1 to c4 of c1 T^c2/(1 + c3/T + c4/T^2)"
    )
    conductivity: Annotated[Annotated[Conductivity, Tag("number")] | Curve, Discriminator(form)] | None = Field(
        None, description="of a gas, as viscosity"
    )


class Solids(Table):
    """The particles: their constituents where they react, porosity, and what is not known from constituents."""

    composition: str | None = Field(None, description='mass fractions that enter, "Fe2O3:0.45, Al2O3:0.55"')
    porosity: Annotated[Number, Field(ge=0, lt=1)] = Field(0.0, description="of the particles that enter")
    density: Density | None = Field(None, description="of particles that enter; absent: from constituents and porosity")
    heat_capacity: HeatCapacityOfSolid | None = Field(None, description="of particles without constituents")
    conductivity: Conductivity | None = Field(None, description="of the particles")
    constituent: dict[str, Substance] = Field(default_factory=dict, description="data of constituents by name")


class SolidKind(Solids):
    """One of several kinds of particles that fill the bed together, mixed evenly where they enter."""

    volume_share: Annotated[Number, Field(gt=0, le=1)] = Field(
        description="of the volume of all particles where they enter, or at rest; those of all kinds sum to 1"
    )
    particle_diameter: Length
    velocity_solid: Speed | None = Field(
        None, description="superficial, as if the kind filled the bed; absent: flow.velocity_solid"
    )
    nusselt: NonNegativeOrClosure | None = Field(None, description="of this kind; absent: heat.nusselt")
    sherwood: NonNegativeOrClosure | None = Field(None, description="of this kind; absent: mass.sherwood")
