"""Tables of a scene of one sphere that is heated, dries, decomposes or burns out, in
SI.

See `single_particle.equations`.

    [solids.NAME]          size, density, conductivity, constituents: the only solid
    [gas]                  what reactions make and what leaves
    [reactions.NAME]       what turns into what, how fast, with which heat
    [boundary.surface]     a measured temperature of the surface, or convection and radiation
    [initial]              temperature at the start
    [time]                 end and output times
    [single_particle]      numerics of this model alone
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from contbed.scene.property_table import ConductivityOfSolid, HeatCapacityOfSolid
from contbed.scene.quantities import (
    Composition,
    Density,
    Emissivity,
    Fraction,
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
from contbed.scene.solids import SolidPhase
from contbed.scene.tables import NewtonSolver, SceneBase

SURFACE = "surface"  # the only boundary


class Constituent(Table):
    """A solid constituent of the particle, initial or formed by reactions."""

    heat_capacity: HeatCapacityOfSolid
    """specific heat capacity of the constituent"""


class Solid(SolidPhase):
    """A sphere of constant size."""

    varies: ClassVar[frozenset[str]] = frozenset({"conductivity"})

    diameter: Length
    """diameter of the particle"""
    density: Density
    """fresh"""
    conductivity: ConductivityOfSolid
    """fresh"""
    conductivity_product: ConductivityOfSolid | None = None
    """where nothing fresh is left, linear between by mass; absent: as fresh"""
    composition: Composition
    """mass fractions of the fresh particle, "wood:0.93, water:0.07"
    """
    constituent: dict[str, Constituent] = Field(min_length=1)
    """constituents of the particle by name"""


class Gas(Table):
    """The gas that reactions make, which leaves through the surface at once."""

    heat_capacity: Annotated[float, *unit("J/kg/K"), Field(ge=0)] = 0.0
    """specific heat capacity of the gas; 0: it carries no heat"""


class Reaction(Table):
    """A first-order reaction of a constituent; what does not become a constituent
    leaves as gas.
    """

    of: str
    """constituent that decomposes"""
    A: Annotated[float, *unit("1/s"), Field(gt=0)]
    """rate is A exp(-E/(R T)) per mass"""
    E: Annotated[float, *unit("J/mol"), Field(ge=0)]
    """activation energy"""
    heat: Annotated[float, *unit("J/kg")] = 0.0
    """taken up per mass that reacts, at its temperature"""
    yields: dict[str, Annotated[NonNegative, Field(le=1)]] = Field(default_factory=dict)
    """mass of each constituent made per mass that reacts"""


class Boundary(Table):
    """What is around the particle: the temperature of its surface, or a furnace and
    its gas.
    """

    fixed_temperature: TemperatureOrSeries | None = None
    """measured temperature of the surface"""
    ambient: TemperatureOrSeries | None = None
    """temperature of the furnace and its gas"""
    coefficient: WallCoefficient = 0.0
    """of convection, to `ambient`"""
    emissivity: Emissivity | None = None
    """of the particle in a large furnace at `ambient`"""

    @model_validator(mode="after")
    def _one(self) -> Boundary:
        if (self.fixed_temperature is None) == (self.ambient is None):
            raise ValueError("give one of fixed_temperature, ambient")
        if self.fixed_temperature is not None and (self.coefficient or self.emissivity):
            raise ValueError(
                "coefficient and emissivity belong to ambient; the surface has the "
                "temperature given"
            )
        if (
            self.ambient is not None
            and not self.coefficient
            and self.emissivity is None
        ):
            raise ValueError("ambient heats nothing without coefficient or emissivity")
        return self


class Initial(Table):
    """The state at the start."""

    temperature: Temperature
    """of the whole particle"""


class Time(Table):
    """End and output times."""

    end: Seconds
    """time at which the run ends"""
    times: tuple[Instant, ...] = ()
    """output times; absent: 100 equal steps; the end is always one"""
    tolerance: Fraction = 1e-4
    """local error of temperatures over their span, and of masses"""


class SingleParticle(Table):
    """What only this model has."""

    cells: Annotated[Whole, Field(ge=4, le=1000)] = 30
    """shells of equal thickness"""


class Output(Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: Switch = True
    """draw plots (.png)"""
    fields: ClassVar[bool] = False


class Solver(NewtonSolver):
    """Numerics."""

    balance_tolerance: Positive = 1e-9
    """largest relative residual of a balance that a run accepts"""


class SingleParticleScene(SceneBase):
    """One sphere in hot surroundings that conducts and reacts."""

    kind: ClassVar[str] = "single_particle"

    solids: dict[str, Solid] = Field(min_length=1, max_length=1)
    """the particle, by name"""
    gas: Gas = Gas()
    reactions: dict[str, Reaction] = Field(default_factory=dict)
    """reactions of constituents by name"""
    boundary: dict[str, Boundary] = Field(min_length=1)
    """`surface` alone"""
    initial: Initial
    time: Time
    single_particle: SingleParticle = SingleParticle()
    output: Output = Output()
    solver: Solver = Solver()

    @property
    def solid(self) -> Solid:
        """The particle."""
        return next(iter(self.solids.values()))

    @property
    def surface(self) -> Boundary:
        """The condition at its surface."""
        return self.boundary[SURFACE]
