"""Tables of a scene with [surroundings]: one sphere that is heated, dries, decomposes or burns out, in SI.

See `single_particle.equations`.

    [particle]             size, density, conductivity, heat capacity of the gas that leaves
    [constituent.NAME]     what it consists of
    [reactions.NAME]       what turns into what, how fast, with which heat
    [surroundings]         a measured surface temperature, or convection and radiation
    [time]                 end and output times
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from contbed.scene.quantities import (
    Conductivity,
    Density,
    Emissivity,
    Fraction,
    HeatCapacity,
    Instant,
    Length,
    NonNegative,
    Positive,
    Seconds,
    Switch,
    Table,
    Temperature,
    WallCoefficient,
    Whole,
    unit,
)
from contbed.scene.series import TemperatureOrSeries
from contbed.scene.tables import SceneBase


class Particle(Table):
    """A sphere of constant size."""

    diameter: Length = Field(description="diameter of the particle")
    density: Density = Field(description="fresh")
    temperature: Temperature = Field(description="at the start")
    conductivity: Conductivity = Field(description="fresh")
    conductivity_product: Conductivity | None = Field(
        None, description="where nothing fresh is left, linear between by mass; absent: as fresh"
    )
    gas_heat_capacity: Annotated[float, *unit("J/kg/K"), Field(ge=0)] = Field(
        0.0, description="of the gas that is made and leaves through the surface; 0: it carries no heat"
    )
    cells: Annotated[Whole, Field(ge=4, le=1000)] = Field(30, description="shells of equal thickness")


class Constituent(Table):
    """A solid constituent of the particle, initial or formed by reactions."""

    mass_fraction: Annotated[NonNegative, Field(le=1)] = Field(0.0, description="of the fresh particle")
    heat_capacity: HeatCapacity = Field(description="specific heat capacity of the constituent")


class Reaction(Table):
    """A first-order reaction of a constituent; what does not become a constituent leaves as gas."""

    of: str = Field(description="constituent that decomposes")
    A: Annotated[float, *unit("1/s"), Field(gt=0)] = Field(description="rate is A exp(-E/T) per mass")
    activation_temperature: Temperature = Field(description="E over the gas constant")
    heat: Annotated[float, *unit("J/kg")] = Field(0.0, description="taken up per mass that reacts, at its temperature")
    yields: dict[str, Annotated[NonNegative, Field(le=1)]] = Field(
        default_factory=dict, description="mass of each constituent made per mass that reacts"
    )


class Surroundings(Table):
    """What is around the particle: the temperature of its surface, or of a furnace."""

    surface: TemperatureOrSeries | None = Field(None, description="measured temperature of the surface")
    temperature: TemperatureOrSeries | None = Field(None, description="of the furnace and its gas")
    coefficient: WallCoefficient = Field(0.0, description="of convection, with `temperature`")
    emissivity: Emissivity | None = Field(None, description="of the particle in a large furnace, with `temperature`")

    @model_validator(mode="after")
    def _one(self) -> Surroundings:
        if (self.surface is None) == (self.temperature is None):
            raise ValueError("give one of surface, temperature")
        if self.surface is not None and (self.coefficient or self.emissivity):
            raise ValueError("coefficient and emissivity belong to temperature; the surface has the one given")
        if self.temperature is not None and not self.coefficient and self.emissivity is None:
            raise ValueError("temperature heats nothing without coefficient or emissivity")
        return self


class Time(Table):
    """End and output times."""

    end: Seconds = Field(description="time at which the run ends")
    times: tuple[Instant, ...] = Field((), description="output times; absent: 100 equal steps; the end is always one")
    tolerance: Fraction = Field(1e-4, description="local error of temperatures over their span, and of masses")


class Output(Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: Switch = Field(True, description="draw plots (.png)")
    fields: ClassVar[bool] = False


class Solver(Table):
    """Numerics."""

    newton_tolerance: Fraction = Field(
        1e-10,
        description="residual norm, relative to the scale of the equations, at which Newton's method has converged",
    )
    newton_iterations: Whole = Field(30, ge=1, le=1000, description="most iterations of Newton's method")
    balance_tolerance: Positive = Field(1e-9, description="largest relative residual of a balance that a run accepts")
    strict: Switch = Field(False, description="a closure out of its range is an error")


class SingleParticleScene(SceneBase):
    """One sphere in hot surroundings that conducts and reacts."""

    kind: ClassVar[str] = "single_particle"

    particle: Particle
    constituent: dict[str, Constituent] = Field(min_length=1, description="constituents of the particle by name")
    reactions: dict[str, Reaction] = Field(default_factory=dict, description="reactions of constituents by name")
    surroundings: Surroundings
    time: Time
    output: Output = Output()
    solver: Solver = Solver()
