"""Tables [bubbling_bed] and [bubbling_bed.NAME] of a scene, in SI: what only a
bubbling bed has.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from contbed.scene.quantities import (
    Emissivity,
    Extinction,
    Fraction,
    HeatSource,
    Irradiance,
    Length,
    NonNegative,
    Pressure,
    Seconds,
    ShareBelowOne,
    Table,
    Temperature,
    WallCoefficient,
    takes,
    unit,
)
from contbed.scene.tables import (
    ConductivityOrClosure,
    OrClosure,
    WallCoefficientOrClosure,
)

Area = Annotated[float, *unit("m**2"), Field(gt=0)]
CapacityFlow = Annotated[float, *unit("W/K"), Field(ge=0)]
Exchange = Annotated[float, *unit("W/m**3/K"), Field(ge=0)]
GasCoefficient = Annotated[float, *unit("W/m**2/K"), Field(gt=0)]
Kelvin = Annotated[float, *unit("K")]
MassFlow = Annotated[float, *unit("kg/s"), Field(gt=0)]
Frequency = Annotated[float, *unit("1/s"), Field(ge=0)]
Speed = Annotated[float, *unit("m/s"), Field(gt=0)]
MassFluxOfSolids = Annotated[float, *unit("kg/m**2/s"), Field(ge=0)]

BubbleFraction = OrClosure[ShareBelowOne]
ExchangeOrClosure = OrClosure[Exchange]
RateOrClosure = OrClosure[Frequency]
EjectionOrClosure = OrClosure[MassFluxOfSolids]
RateOfDecayOrClosure = OrClosure[Extinction]
SpeedOrClosure = OrClosure[Speed]
LengthOrClosure = OrClosure[Length]
GasCoefficientOrClosure = OrClosure[GasCoefficient]


class Release(Table):
    """Heat released per volume of bed.

    rate exp(-z/length) exp(-activation (1/T - 1/reference)); T of what releases it.
    """

    rate: HeatSource
    """negative where heat is consumed"""
    length: Length | None = None
    """decay along the height; absent: uniform"""
    activation: Annotated[Kelvin, Field(ge=0)] | None = None
    """E/R; absent: none"""
    reference: Temperature | None = None
    """temperature at which the rate holds"""

    @model_validator(mode="after")
    def _both(self) -> Release:
        if (self.activation is None) != (self.reference is None):
            raise ValueError("activation and reference belong together")
        return self


class Bubbles(Table):
    """Gas that passes as bubbles free of particles."""

    fraction: BubbleFraction = "bubble_fraction_kunii_levenspiel"
    """share of the bed's volume"""
    capacity_flow: CapacityFlow | None = None
    """with boundary.bottom.gas.capacity_flow only"""
    exchange: ExchangeOrClosure = "bubble_heat_kunii_levenspiel"
    """with the gas of the emulsion, per volume of bubbles"""
    gas_exchange: RateOrClosure = "gas_exchange_sit_grace"
    """of all gases with the emulsion, where they react, with the diffusivity of oxygen in
    nitrogen"""
    size: LengthOrClosure = "bubble_growth_mori_wen"
    """diameter, or how it grows"""
    start: LengthOrClosure = "bubble_start_porous_plate"
    """diameter at the distributor"""
    rise: SpeedOrClosure = "bubble_rise_davidson_harrison"
    """velocity of the bubbles"""
    emulsion_gas: SpeedOrClosure = "emulsion_gas_two_phase"
    """gas through the emulsion per its section; the rest is bubbles"""


class Steam(Table):
    """Water, boiling water or steam inside of a surface."""

    pressure: Pressure
    """of the water or steam"""
    temperature: Temperature
    """of what enters; it does not boil there"""
    mass_flow: MassFlow
    """of the water or steam"""
    coefficient: Annotated[WallCoefficient, Field(gt=0)]
    """inside, on the outer surface"""
    direction: Literal["up", "down"] = "up"
    """in which the water or steam flows"""


class Surface(Table):
    """Tubes or walls along the whole height, at a temperature or with water inside."""

    perimeter: Length
    """surface per height of bed"""
    coefficient: WallCoefficientOrClosure = Field(json_schema_extra=takes("bed_tube"))
    """convective, split over the solid phases by their surface"""
    temperature: Temperature | None = None
    """of the surface; or steam"""
    emissivity: Emissivity | None = None
    """absent: a mirror"""
    steam: Steam | None = None
    """instead of `temperature`"""

    @model_validator(mode="after")
    def _one(self) -> Surface:
        if (self.temperature is None) == (self.steam is None):
            raise ValueError("give one of temperature, steam")
        return self


class Distributor(Table):
    """A plate of one temperature that the gas cools and the bed heats.

    Absent: the bed ends at a mirror.
    """

    coefficient: WallCoefficient
    """to the particles, split over the solid phases by their surface"""
    preheat_NTU: NonNegative
    """transfer units of the gas inside of the plate"""
    emissivity: Emissivity | None = None
    """absent: a mirror"""


class FreeboardSurface(Table):
    """Tubes or walls along the whole freeboard."""

    perimeter: Length
    """surface per height"""
    coefficient: WallCoefficient
    """to the gas"""
    temperature: Temperature
    """of the surface"""
    emissivity: Emissivity | None = None
    """absent: a mirror"""


class Freeboard(Table):
    """What is above the bed: a radiosity, a black space, or a freeboard with a height.

    Gas, particles and radiation of a freeboard with a height are solved for, which
    needs boundary.bottom.gas.mass_flow. Gases react in it, as a mixture of
    both gases of the bed; particles do not react there.
    """

    radiosity: Irradiance | None = None
    """of what is above the bed"""
    temperature: Temperature | None = None
    """of a black space above the bed"""
    height: Length | None = None
    """of the freeboard above the bed, which is solved for"""
    temperature_above: Temperature | None = None
    """black, above `height`; absent: a mirror"""
    tubes: FreeboardSurface | None = None
    """absent: none"""
    walls: FreeboardSurface | None = None
    """absent: adiabatic"""
    ejection: EjectionOrClosure = "ejection_pemberton_davidson"
    """flow of particles thrown up"""
    decay: RateOfDecayOrClosure = "decay_kunii_levenspiel"
    """of that flow over the height"""
    terminal_velocity: SpeedOrClosure = "terminal_velocity_haider_levenspiel"
    """of each solid phase"""
    elutriation: EjectionOrClosure = "elutriation_geldart"
    """rate constant of each solid phase"""
    gas_coefficient: GasCoefficientOrClosure = "nusselt_ranz_marshall"
    """particles to gas"""

    @model_validator(mode="after")
    def _one(self) -> Freeboard:
        names = ("radiosity", "temperature", "height")
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError("give one of radiosity, temperature, height")
        unused = sorted(self.model_fields_set - set(given))
        if self.height is None and unused:
            raise ValueError(f"{', '.join(unused)}: has no use without height")
        return self


class Drain(Table):
    """Bed material that leaves at one end with what char and limestone it holds."""

    time: Seconds
    """residence time of the bed, its solids over what is drained"""
    end: Literal["top", "bottom"] = "top"
    """of the bed where it leaves"""


class BubblingBed(Table):
    """The bed between distributor and freeboard; z is the height above the
    distributor.
    """

    height: Length
    """of the bubbling bed; or settled_height"""
    settled_height: Length | None = None
    """at minimum fluidization, from which the height follows"""
    section: Area
    """cross-section of the bed"""
    solids_fraction: Fraction
    """share of the emulsion's volume, one minus its voidage"""
    conductivity: ConductivityOrClosure | None = Field(
        None, json_schema_extra=takes("conductivity")
    )
    """of the resting emulsion, added to the mixing and split by volume; absent: none"""
    mixing_time: Annotated[float, *unit("s"), Field(ge=0)] = 1e-3
    """of gases, which react no faster than they mix"""
    release: Release | None = None
    """heat released in the gas of the emulsion"""
    bubbles: Bubbles | None = None
    """absent: all gas flows through the emulsion"""
    tubes: Surface | None = None
    """immersed; absent: none"""
    walls: Surface | None = None
    """absent: adiabatic"""
    distributor: Distributor | None = None
    """absent: the bed ends at a mirror"""
    freeboard: Freeboard | None = None
    """absent: no radiation leaves upward"""
    drain: Drain | None = None
    """absent: char and limestone leave by reaction alone"""

    @model_validator(mode="before")
    @classmethod
    def _initial_height(cls, values: Any) -> Any:
        """Return the table with an initial height where it follows from the settled
        bed.
        """
        given = values.get("settled_height") if isinstance(values, dict) else None
        if given is None or "height" in values:
            return values
        from contbed.scene.units import to_si

        number = to_si(given, "m") if isinstance(given, str) else given
        return values | {
            "height": 1.3 * number if isinstance(number, float | int) else given
        }

    @property
    def surfaces(self) -> dict[str, Surface]:
        """The surfaces in the bed by name."""
        found = {"tubes": self.tubes, "walls": self.walls}
        return {name: item for name, item in found.items() if item is not None}

    @property
    def bubbling(self) -> bool:
        """Whether gas passes as bubbles."""
        return self.bubbles is not None and self.bubbles.fraction != 0
