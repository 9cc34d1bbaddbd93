"""The vocabulary of a scene with a [bubbling_bed] table: a fluidized bed along its height, in SI.

    [bubbling_bed]            height, section and packing of the emulsion
    [bubbles]                 absent: all gas flows through the emulsion
    [gas]                     of the emulsion, and the temperature at which all gas enters
    [species.NAME]            one kind of particle, with its feed, heat release and exchange with other kinds
    [tubes], [walls]          immersed surfaces        [distributor], [freeboard]    what bounds the bed
    [radiation]               level by name; absent: none

A table that is absent means that its physics is absent. Flows of streams are capacity flows, mass flow times heat
capacity.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from contbed.scene import settings as s
from contbed.scene.quantities import Cells, unit

Area = Annotated[float, *unit("m**2"), Field(gt=0)]
CapacityFlow = Annotated[float, *unit("W/K"), Field(ge=0)]
Exchange = Annotated[float, *unit("W/m**3/K"), Field(ge=0)]
GasCoefficient = Annotated[float, *unit("W/m**2/K"), Field(gt=0)]
Kelvin = Annotated[float, *unit("K")]
Share = Annotated[s.Number, Field(ge=0, le=1)]
BubbleFraction = Annotated[s.Number, Field(ge=0, lt=1)]


class BubblingBed(s.Table):
    """The bed between distributor and freeboard; z is the height above the distributor."""

    height: s.Length
    section: Area = Field(description="cross-section of the bed")
    solids_fraction: s.Fraction = Field(description="share of the emulsion's volume, one minus its voidage")


class Bubbles(s.Table):
    """Gas that passes as bubbles free of particles."""

    fraction: BubbleFraction = Field(description="share of the bed's volume")
    capacity_flow: CapacityFlow
    exchange: Exchange = Field(description="with the gas of the emulsion, per volume of bubbles")


class Release(s.Table):
    """Heat released per volume of bed, rate exp(-z/length) exp(-activation (1/T - 1/reference)); T of what releases."""

    rate: s.HeatSource = Field(description="negative where heat is consumed")
    length: s.Length | None = Field(None, description="decay along the height; absent: uniform")
    activation: Annotated[Kelvin, Field(ge=0)] | None = Field(None, description="E/R; absent: none")
    reference: s.Temperature | None = Field(None, description="temperature at which the rate holds")

    @model_validator(mode="after")
    def _both(self) -> Release:
        if (self.activation is None) != (self.reference is None):
            raise ValueError("activation and reference belong together")
        return self


class Gas(s.Table):
    """Gas of the emulsion; bubbles enter at the same temperature."""

    capacity_flow: CapacityFlow
    temperature: s.Temperature = Field(description="below the distributor")
    release: Release | None = None


class Feed(s.Table):
    """Particles that enter around a height, Gaussian, and leave the bed at one end."""

    capacity_flow: CapacityFlow
    temperature: s.Temperature
    height: Annotated[s.Position, Field(ge=0)]
    width: s.Length = Field(description="standard deviation; what it puts beyond the ends enters inside")
    drain: Literal["top", "bottom"] = "top"


class Species(s.Table):
    """One kind of particle."""

    volume_fraction: Share = Field(description="share of the solids; 0: this kind is left out")
    diameter: s.Length = Field(description="Sauter mean")
    emissivity: s.Emissivity | None = Field(None, description="needed with [radiation]")
    gas_coefficient: GasCoefficient = Field(description="particle surface to emulsion gas")
    conductivity: s.Conductivity = Field(description="of axial mixing, on the whole section")
    exchange: dict[str, Exchange] = Field(
        default_factory=dict, description="with other species by name, per emulsion volume; each pair once"
    )
    feed: Feed | None = None
    release: Release | None = None


class Surface(s.Table):
    """Tubes or walls along the whole height."""

    perimeter: s.Length = Field(description="surface per height of bed")
    coefficient: s.WallCoefficient = Field(description="convective, split over the species by their surface")
    temperature: s.Temperature
    emissivity: s.Emissivity | None = Field(None, description="absent: a mirror")


class Distributor(s.Table):
    """A plate of one temperature that the gas cools and the bed heats; absent: the bed ends at a mirror."""

    coefficient: s.WallCoefficient = Field(description="to the particles, split over the species by their surface")
    preheat_NTU: s.NonNegative = Field(description="transfer units of the gas inside of the plate")
    emissivity: s.Emissivity | None = Field(None, description="absent: a mirror")


class Freeboard(s.Table):
    """Radiation from above: a radiosity, or a black space at a temperature."""

    radiosity: s.Irradiance | None = None
    temperature: s.Temperature | None = None

    @model_validator(mode="after")
    def _one(self) -> Freeboard:
        if (self.radiosity is None) == (self.temperature is None):
            raise ValueError("give one of radiosity, temperature")
        return self


class Radiation(s.Table):
    """Radiation between the particles of a bubbling bed."""

    level: Literal["none", "paper", "two_flux", "p1"] = Field(
        "p1", description="paper: among the species at one height only, eq. 34 of Rabi & de Souza-Santos"
    )
    correction: Literal["close_packed", "independent"] | None = Field(
        None,
        description="extinction over the voidage, the default, or the limit of points far apart; paper: independent",
    )
    anisotropy: Annotated[s.Number, Field(ge=-1, le=1)] = Field(0.0, description="mean cosine of scattering")


class Mesh(s.Table):
    """Cells along the height, graded to the layers at both ends."""

    cells: Cells | None = Field(None, description="absent: by solver.tolerance")
    refine: s.Whole = Field(0, ge=0, le=12, description="uniform refinements after construction")


class Solver(s.Table):
    """Numerics; the defaults suit nearly all scenes."""

    degree: s.Order = Field(3, description="polynomial degree of all fields")
    tolerance: s.Fraction = Field(1e-6, description="target error of automatic meshes, relative to the temperatures")
    guess: s.Temperature = Field(1100.0, ge=200, description="uniform temperature that Newton's method starts from")
    newton_tolerance: s.Fraction = 1e-10
    newton_iterations: s.Whole = Field(60, ge=1, le=1000)
    balance_tolerance: s.Positive = 1e-10
    strict: s.Switch = Field(False, description="a closure out of its range is an error")
    memory_GB: s.Positive | None = Field(None, description="refuse a factorisation predicted above this")


class BubblingScene(s.SceneBase):
    """One run of a bubbling bed."""

    kind: ClassVar[str] = "bubbling_bed"
    time: ClassVar[None] = None

    bubbling_bed: BubblingBed
    gas: Gas
    bubbles: Bubbles | None = None
    species: dict[str, Species]
    tubes: Surface | None = None
    walls: Surface | None = None
    distributor: Distributor | None = None
    freeboard: Freeboard | None = Field(None, description="absent: no radiation leaves upward")
    radiation: Radiation = Radiation(level="none")
    mesh: Mesh = Mesh()
    solver: Solver = Solver()
    output: s.Output = s.Output()

    @property
    def present(self) -> dict[str, Species]:
        """The species that are there."""
        return {name: item for name, item in self.species.items() if item.volume_fraction > 0}
