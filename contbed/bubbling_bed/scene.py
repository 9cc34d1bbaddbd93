"""Tables of a scene with [bubbling_bed]: a fluidized bed along its height, in SI.

    [bubbling_bed]            height, section and packing of the emulsion
    [bubbles]                 absent: all gas flows through the emulsion
    [gas]                     what enters; its properties, or the capacity flow of the emulsion alone
    [species.NAME]            one kind of particle, with its feed, heat release and exchange with other kinds
    [tubes], [walls]          immersed surfaces        [distributor], [freeboard]    what bounds the bed
    [radiation]               level by name; absent: none
    [continuation]            steady states over one value of the scene
    [fuel], [limestone], [drain], [reactions]     see `chemistry.scene`; they need gas.mass_flow

Physics whose table is absent is left out. There are two ways to write a scene. With gas.capacity_flow every coefficient
is a number, frozen, and flows of streams are capacity flows, mass flow times heat capacity. With gas.mass_flow and
gas.composition a coefficient may be a closure by name, a file, or a number, and flows are mass flows.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from contbed.bubbling_bed.chemistry import scene as chemistry
from contbed.scene import quantities as q
from contbed.scene.quantities import (
    Cells,
    Conductivity,
    Density,
    Emissivity,
    Extinction,
    Fraction,
    HeatSource,
    Irradiance,
    Length,
    NonNegative,
    Number,
    Order,
    Position,
    Positive,
    Pressure,
    Switch,
    Table,
    Temperature,
    WallCoefficient,
    Whole,
    form,
    takes,
    unit,
)
from contbed.scene.tables import (
    ConductivityOrClosure,
    NamedOrFile,
    OfMaterial,
    Output,
    Polynomial,
    SceneBase,
    WallCoefficientOrClosure,
)

Area = Annotated[float, *unit("m**2"), Field(gt=0)]
CapacityFlow = Annotated[float, *unit("W/K"), Field(ge=0)]
Exchange = Annotated[float, *unit("W/m**3/K"), Field(ge=0)]
GasCoefficient = Annotated[float, *unit("W/m**2/K"), Field(gt=0)]
Kelvin = Annotated[float, *unit("K")]
HeatCapacity = Annotated[Annotated[q.HeatCapacity, Tag("number")] | Polynomial, Discriminator(form)]
Share = Annotated[Number, Field(ge=0, le=1)]
MassFlow = Annotated[float, *unit("kg/s"), Field(gt=0)]
Frequency = Annotated[float, *unit("1/s"), Field(ge=0)]
Speed = Annotated[float, *unit("m/s"), Field(gt=0)]

BubbleFraction = Annotated[Annotated[Number, Field(ge=0, lt=1), Tag("number")] | NamedOrFile, Discriminator(form)]
ExchangeOrClosure = Annotated[Annotated[Exchange, Tag("number")] | NamedOrFile, Discriminator(form)]
RateOrClosure = Annotated[Annotated[Frequency, Tag("number")] | NamedOrFile, Discriminator(form)]
NamedExpansion = Annotated[NamedOrFile, Discriminator(form)]
EjectionOrClosure = Annotated[
    Annotated[float, *unit("kg/m**2/s"), Field(ge=0), Tag("number")] | NamedOrFile, Discriminator(form)
]
RateOfDecayOrClosure = Annotated[Annotated[Extinction, Tag("number")] | NamedOrFile, Discriminator(form)]
SpeedOrClosure = Annotated[Annotated[Speed, Tag("number")] | NamedOrFile, Discriminator(form)]
LengthOrClosure = Annotated[Annotated[Length, Tag("number")] | NamedOrFile, Discriminator(form)]
GasCoefficientOrClosure = Annotated[Annotated[GasCoefficient, Tag("number")] | NamedOrFile, Discriminator(form)]


class BubblingBed(Table):
    """The bed between distributor and freeboard; z is the height above the distributor."""

    height: Length = Field(description="of the bubbling bed; or settled_height")
    settled_height: Length | None = Field(None, description="at minimum fluidization, from which the height follows")
    expansion: NamedExpansion | None = Field(
        None, description="ratio of both heights by a closure; absent: by the volume of the bubbles"
    )
    section: Area = Field(description="cross-section of the bed")
    solids_fraction: Fraction = Field(description="share of the emulsion's volume, one minus its voidage")
    minimum_fluidization: SpeedOrClosure = Field("minimum_fluidization_grace", description="superficial velocity")
    conductivity: ConductivityOrClosure | None = Field(
        None,
        description="of the resting emulsion, added to the mixing and split by volume; absent: none",
        json_schema_extra=takes("conductivity"),
    )

    @model_validator(mode="before")
    @classmethod
    def _guess(cls, values: Any) -> Any:
        """Return the table with an initial height where it follows from that of the settled bed."""
        given = values.get("settled_height") if isinstance(values, dict) else None
        if given is None or "height" in values:
            return values
        from contbed.scene.units import to_si

        number = to_si(given, "m") if isinstance(given, str) else given
        return values | {"height": 1.3 * number if isinstance(number, float | int) else given}


class Bubbles(Table):
    """Gas that passes as bubbles free of particles."""

    fraction: BubbleFraction = Field("bubble_fraction_kunii_levenspiel", description="share of the bed's volume")
    capacity_flow: CapacityFlow | None = Field(None, description="with gas.capacity_flow only")
    exchange: ExchangeOrClosure = Field(
        "bubble_heat_kunii_levenspiel", description="with the gas of the emulsion, per volume of bubbles"
    )
    gas_exchange: RateOrClosure = Field(
        "gas_exchange_sit_grace", description="of gas with the emulsion, where it reacts"
    )
    size: LengthOrClosure = Field("bubble_growth_mori_wen", description="diameter, or how it grows")
    start: LengthOrClosure = Field("bubble_start_porous_plate", description="diameter at the distributor")
    rise: SpeedOrClosure = Field("bubble_rise_davidson_harrison", description="velocity of the bubbles")
    emulsion_gas: SpeedOrClosure = Field(
        "emulsion_gas_two_phase", description="gas through the emulsion per its section; the rest is bubbles"
    )


class Release(Table):
    """Heat released per volume of bed, rate exp(-z/length) exp(-activation (1/T - 1/reference)); T of what releases."""

    rate: HeatSource = Field(description="negative where heat is consumed")
    length: Length | None = Field(None, description="decay along the height; absent: uniform")
    activation: Annotated[Kelvin, Field(ge=0)] | None = Field(None, description="E/R; absent: none")
    reference: Temperature | None = Field(None, description="temperature at which the rate holds")

    @model_validator(mode="after")
    def _both(self) -> Release:
        if (self.activation is None) != (self.reference is None):
            raise ValueError("activation and reference belong together")
        return self


class Gas(Table):
    """What enters below the distributor, all at one temperature."""

    capacity_flow: CapacityFlow | None = Field(None, description="of the emulsion's gas; coefficients are numbers")
    mass_flow: MassFlow | None = Field(None, description="of all gas; coefficients may be closures")
    composition: str | None = Field(None, description='with mass_flow: mole fractions, "N2:0.79, O2:0.21"')
    pressure: Pressure = Field(101325.0, description="absolute pressure of the gas")
    mechanism: str = Field("gri30.yaml", description="a Cantera file with the species of the gas")
    temperature: Temperature = Field(description="below the distributor")
    release: Release | None = Field(None, description="heat released in the gas of the emulsion")

    @model_validator(mode="after")
    def _one(self) -> Gas:
        if (self.capacity_flow is None) == (self.mass_flow is None):
            raise ValueError("give one of capacity_flow, mass_flow")
        if (self.mass_flow is None) != (self.composition is None):
            raise ValueError("mass_flow and composition belong together")
        return self


class Feed(Table):
    """Particles that enter around a height, Gaussian, and leave the bed at one end."""

    capacity_flow: CapacityFlow | None = Field(None, description="with gas.capacity_flow")
    mass_flow: Annotated[float, *unit("kg/s"), Field(ge=0)] | None = Field(None, description="with gas.mass_flow")
    temperature: Temperature = Field(description="temperature of the solids that enter")
    height: Annotated[Position, Field(ge=0)] = Field(
        description="height above the distributor at which the solids enter"
    )
    width: Length = Field(description="standard deviation; what it puts beyond the ends enters inside")
    drain: Literal["top", "bottom"] = Field("top", description="end of the bed where the solids leave")


class Sizes(Table):
    """Sizes of one kind of particle: those fed, or those in the bed. The first need [freeboard] with a height."""

    diameters: Annotated[tuple[Length, ...], Field(min_length=2)] = Field(
        description="diameters of the particles, ascending"
    )
    feed: tuple[NonNegative, ...] | None = Field(None, description="mass fractions, which sum to one")
    bed: tuple[NonNegative, ...] | None = Field(None, description="instead of `feed`")

    @model_validator(mode="after")
    def _sums(self) -> Sizes:
        given = [shares for shares in (self.feed, self.bed) if shares is not None]
        if not given:
            raise ValueError("give one of feed, bed")
        for shares in given:
            if len(shares) != len(self.diameters) or abs(sum(shares) - 1.0) > 1e-6:
                raise ValueError(f"{len(self.diameters)} mass fractions that sum to 1; found {sum(shares):.8g}")
        return self


class Species(OfMaterial):
    """One kind of particle."""

    of_material: ClassVar[dict[str, str]] = {
        "density": "density",
        "heat_capacity": "heat_capacity",
        "conductivity": "thermal_conductivity",
    }

    volume_fraction: Share = Field(description="share of the solids; 0: this kind is left out")
    diameter: Length = Field(description="Sauter mean, of spheres of the particles' volumes; or sizes")
    sizes: Sizes | None = None
    sphericity: Annotated[Number, Field(gt=0, le=1)] = Field(1.0, description="surface of such spheres over the true")
    density: Density | None = Field(None, description="needed with gas.mass_flow")
    heat_capacity: HeatCapacity | None = Field(None, description="needed with gas.mass_flow")
    thermal_conductivity: Conductivity = Field(1.0, description="of the material")
    emissivity: Emissivity | None = Field(None, description="needed with [radiation]")
    gas_coefficient: GasCoefficientOrClosure = Field(
        description="particle to emulsion gas, or a nusselt closure", json_schema_extra=takes("nusselt")
    )
    conductivity: ConductivityOrClosure = Field(
        description="of axial mixing, on the whole section, or a closure of the solids' dispersion",
        json_schema_extra=takes("solids_mixing"),
    )
    exchange: dict[str, ExchangeOrClosure] = Field(
        default_factory=dict,
        description="with other species by name, per emulsion volume; each pair once",
        json_schema_extra=takes("solid_exchange"),
    )
    feed: Feed | None = None
    release: Release | None = None

    @model_validator(mode="before")
    @classmethod
    def _mean(cls, values: Any) -> Any:
        """Return the table with the mean diameter of its sizes."""
        sizes = values.get("sizes") if isinstance(values, dict) else None
        if sizes is None or "diameter" in values:
            return values
        table = Sizes.model_validate(sizes)
        shares = table.bed or table.feed or ()
        return values | {"diameter": 1.0 / sum(x / d for x, d in zip(shares, table.diameters, strict=True))}


class Steam(Table):
    """Water, boiling water or steam inside of a surface."""

    pressure: Pressure = Field(description="pressure of water or steam in the tubes")
    temperature: Temperature = Field(description="of what enters; it does not boil there")
    mass_flow: MassFlow = Field(description="mass flow of water or steam in the tubes")
    coefficient: Annotated[WallCoefficient, Field(gt=0)] = Field(description="inside, on the outer surface")
    direction: Literal["up", "down"] = Field("up", description="direction of the water or steam in the tubes")


class Surface(Table):
    """Tubes or walls along the whole height, at a temperature or with water inside."""

    perimeter: Length = Field(description="surface per height of bed")
    coefficient: WallCoefficientOrClosure = Field(
        description="convective, split over the species by their surface", json_schema_extra=takes("bed_tube")
    )
    temperature: Temperature | None = Field(None, description="surface temperature; absent: by `steam`")
    emissivity: Emissivity | None = Field(None, description="absent: a mirror")
    steam: Steam | None = Field(None, description="instead of `temperature`")

    @model_validator(mode="after")
    def _one(self) -> Surface:
        if (self.temperature is None) == (self.steam is None):
            raise ValueError("give one of temperature, steam")
        return self


class Distributor(Table):
    """A plate of one temperature that the gas cools and the bed heats; absent: the bed ends at a mirror."""

    coefficient: WallCoefficient = Field(description="to the particles, split over the species by their surface")
    preheat_NTU: NonNegative = Field(description="transfer units of the gas inside of the plate")
    emissivity: Emissivity | None = Field(None, description="absent: a mirror")


class FreeboardSurface(Table):
    """Tubes or walls along the whole freeboard."""

    perimeter: Length = Field(description="surface per height")
    coefficient: WallCoefficient = Field(description="to the gas")
    temperature: Temperature = Field(description="surface temperature")
    emissivity: Emissivity | None = Field(None, description="absent: a mirror")


class Freeboard(Table):
    """What is above the bed: a radiosity, a black space at a temperature, or a freeboard with a height.

    Gas, particles and radiation of a freeboard with a height are solved for, which needs gas.mass_flow.
    """

    radiosity: Irradiance | None = Field(None, description="radiosity of the surroundings above the bed")
    temperature: Temperature | None = Field(None, description="temperature of the surroundings above the bed")
    height: Length | None = Field(None, description="height of the freeboard above the bed")
    temperature_above: Temperature | None = Field(None, description="black, above `height`; absent: a mirror")
    tubes: FreeboardSurface | None = None
    walls: FreeboardSurface | None = None
    ejection: EjectionOrClosure = Field("ejection_pemberton_davidson", description="flow of particles thrown up")
    decay: RateOfDecayOrClosure = Field("decay_kunii_levenspiel", description="of that flow over the height")
    terminal_velocity: SpeedOrClosure = Field("terminal_velocity_haider_levenspiel", description="of each species")
    elutriation: EjectionOrClosure = Field("elutriation_geldart", description="rate constant of each species")
    gas_coefficient: GasCoefficientOrClosure = Field("nusselt_ranz_marshall", description="particles to gas")

    @model_validator(mode="after")
    def _one(self) -> Freeboard:
        given = [name for name in ("radiosity", "temperature", "height") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError("give one of radiosity, temperature, height")
        if self.height is None and (idle := sorted(self.model_fields_set - set(given))):
            raise ValueError(f"{', '.join(idle)}: has no use without height")
        return self


class Radiation(Table):
    """Radiation between the particles of a bubbling bed."""

    level: Literal["none", "pairwise", "paper", "two_flux", "p1"] = Field(
        "p1",
        description="pairwise, paper: among the species at one height only, eqs. 2-11 and 34 of Rabi & de Souza-Santos",
    )
    correction: Literal["close_packed", "independent"] | None = Field(
        None,
        description="extinction over the voidage, the default, or the limit of points far apart; pairwise, paper: that",
    )
    anisotropy: Annotated[Number, Field(ge=-1, le=1)] = Field(0.0, description="mean cosine of scattering")


class Continuation(Table):
    """The branch of steady states from the value in this scene to another, through the folds between them."""

    parameter: str = Field(description='key of a number in this scene, "gas.temperature" or "walls.coefficient"')
    to: Number = Field(description="in SI")
    back_to: Number | None = Field(None, description="end of the other side; absent: the value in this scene")
    points: Annotated[Whole, Field(ge=3, le=10_000)] = Field(200, description="at most")
    first_fold: Switch = Field(False, description="end at the first fold, where only its distance is wanted")


class Mesh(Table):
    """Cells along the height, graded to the layers at both ends."""

    cells: Cells | None = Field(None, description="absent: by solver.tolerance")
    refine: Whole = Field(0, ge=0, le=12, description="uniform refinements after construction")


class Solver(Table):
    """Numerics; the defaults suit nearly all scenes."""

    degree: Order = Field(3, description="polynomial degree of all fields")
    tolerance: Fraction = Field(1e-6, description="target error of automatic meshes, relative to the temperatures")
    guess: Temperature = Field(1100.0, ge=200, description="uniform temperature that Newton's method starts from")
    newton_tolerance: Fraction = Field(
        1e-10,
        description="residual norm, relative to the scale of the equations, at which Newton's method has converged",
    )
    newton_iterations: Whole = Field(60, ge=1, le=1000, description="most iterations of Newton's method")
    balance_tolerance: Positive = Field(1e-10, description="largest relative residual of a balance that a run accepts")
    strict: Switch = Field(False, description="a closure out of its range is an error")
    memory_GB: Positive | None = Field(None, description="refuse a factorisation predicted above this")


class BubblingScene(SceneBase):
    """One run of a bubbling bed."""

    kind: ClassVar[str] = "bubbling_bed"
    time: ClassVar[None] = None

    bubbling_bed: BubblingBed
    gas: Gas
    bubbles: Bubbles | None = None
    species: dict[str, Species] = Field(description="solid phases by name")
    tubes: Surface | None = None
    walls: Surface | None = None
    distributor: Distributor | None = None
    freeboard: Freeboard | None = Field(None, description="absent: no radiation leaves upward")
    radiation: Radiation = Radiation(level="none")
    fuel: chemistry.Fuel | None = None
    limestone: chemistry.Limestone | None = None
    drain: chemistry.Drain | None = Field(None, description="absent: char and limestone leave by reaction alone")
    reactions: chemistry.Reactions | None = Field(None, description="absent: an inert gas")
    continuation: Continuation | None = None
    mesh: Mesh = Mesh()
    solver: Solver = Solver()
    output: Output = Output()

    @property
    def computed(self) -> bool:
        """Whether coefficients follow from the properties of gas and particles."""
        return self.gas.mass_flow is not None

    @property
    def present(self) -> dict[str, Species]:
        """The species with a volume fraction above zero."""
        return {name: item for name, item in self.species.items() if item.volume_fraction > 0}
