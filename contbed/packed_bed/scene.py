"""The vocabulary of a scene: every table and key, with unit, bounds and meaning, as frozen pydantic models in SI.

A plain number is SI; a string may carry a unit ("3 mm", "100 degC") and is converted here, at the door, so that
nothing behind it ever sees a unit. A table that is absent means that its physics is absent. Defaults live here only.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    ConfigDict,
    Discriminator,
    Field,
    PrivateAttr,
    Tag,
    model_validator,
)

from contbed.scene.mesh import REGION as REGION
from contbed.scene.mesh import Mesh as Mesh
from contbed.scene.mesh import MeshAxisymmetric as MeshAxisymmetric
from contbed.scene.mesh import MeshBox as MeshBox
from contbed.scene.mesh import MeshFile as MeshFile
from contbed.scene.mesh import MeshLine as MeshLine
from contbed.scene.mesh import MeshRectangle as MeshRectangle
from contbed.scene.quantities import (
    ClosureFile,
    Conductivity,
    Density,
    Emissivity,
    Extinction,
    FiniteFloat,
    Fraction,
    HeatCapacity,
    HeatFlux,
    HeatSource,
    Instant,
    Irradiance,
    Length,
    NonNegative,
    Number,
    Order,
    Permeability,
    Position,
    Positive,
    Pressure,
    Seconds,
    Switch,
    Table,
    Temperature,
    Velocity,
    Viscosity,
    WallCoefficient,
    Whole,
    form,
)
from contbed.scene.toml_lines import Origin


def dispersion_form(value: Any) -> str:
    """`form`, where a table without a name holds the two conductivities themselves."""
    nameless = isinstance(value, Dispersion) or (isinstance(value, dict) and "name" not in value)
    return "table" if nameless else form(value)


class FluidConstant(Table):
    """A fluid with constant properties."""

    model: Literal["constant"]
    density: Density
    viscosity: Viscosity
    heat_capacity: HeatCapacity | None = Field(None, description="needed with a [heat] table")
    conductivity: Conductivity | None = Field(None, description="needed with a [heat] table")


class FluidCantera(Table):
    """An ideal-gas mixture with the polynomials of a Cantera mechanism."""

    model: Literal["cantera"]
    composition: str = Field(description='mole fractions, "N2:0.79, O2:0.21"')
    pressure: Pressure = 101325.0
    mechanism: str = "gri30.yaml"


class FluidCoolProp(Table):
    """A real fluid at constant pressure from CoolProp."""

    model: Literal["coolprop"]
    name: str
    pressure: Pressure = 101325.0
    T_range: tuple[Temperature, Temperature] = Field(description="temperatures to tabulate, one phase only")


Fluid = Annotated[FluidConstant | FluidCantera | FluidCoolProp, Field(discriminator="model")]

Polynomial = Annotated[tuple[FiniteFloat, ...], Tag("list"), Field(min_length=1, max_length=12)]


class Solid(Table):
    """The particles' material: numbers, or polynomials a0 + a1 T + a2 T^2 ... with T in K."""

    density: Density
    heat_capacity: Annotated[Annotated[HeatCapacity, Tag("number")] | Polynomial, Discriminator(form)]
    conductivity: Annotated[Annotated[Conductivity, Tag("number")] | Polynomial, Discriminator(form)]


class Closure(Table):
    """A closure by name; further keys are the closure's own parameters."""

    model_config = ConfigDict(extra="allow", frozen=True)
    name: str


Named = Annotated[str, Tag("name")] | Annotated[Closure, Tag("parameters")]
NamedOrFile = Named | Annotated[ClosureFile, Tag("file")]
PermeabilityOrClosure = Annotated[Annotated[Permeability, Tag("number")] | NamedOrFile, Discriminator(form)]
NonNegativeOrClosure = Annotated[Annotated[NonNegative, Tag("number")] | NamedOrFile, Discriminator(form)]
ConductivityOrClosure = Annotated[Annotated[Conductivity, Tag("number")] | NamedOrFile, Discriminator(form)]
NumberOrClosure = Annotated[Annotated[Number, Tag("number")] | NamedOrFile, Discriminator(form)]
WallCoefficientOrClosure = Annotated[Annotated[WallCoefficient, Tag("number")] | NamedOrFile, Discriminator(form)]


class Bed(Table):
    """The packing."""

    porosity: Fraction
    particle_diameter: Length
    shape: Literal["spheres", "rods"] = Field(
        "spheres", description="specific surface 6 (1-eps)/d for spheres, 4 (1-eps)/d for rods"
    )
    permeability: PermeabilityOrClosure = "permeability_ergun"
    forchheimer: NonNegativeOrClosure = Field("forchheimer_ergun", description="inertial drag coefficient c_F")


class Flow(Table):
    """Superficial velocities; a number is along the bed axis (x, or z when axisymmetric), a list is a vector."""

    velocity: Velocity = Field(description="fluid, mean over the inlet")
    velocity_solid: Velocity = 0.0


class Dispersion(Table):
    """Constant dispersion conductivities, along and across the flow."""

    axial: Conductivity
    transverse: Conductivity = 0.0


DispersionOrClosure = Annotated[Annotated[Dispersion, Tag("table")] | Named, Discriminator(dispersion_form)]


class Heat(Table):
    """Two energy equations, one for each phase."""

    nusselt: NonNegativeOrClosure
    reynolds: NonNegative | None = Field(
        None, description="fixed Reynolds number for the closures instead of the one from velocities and properties"
    )
    conductivity_fluid: ConductivityOrClosure = Field(
        "conductivity_phase", description="effective, without dispersion; conductivity_phase is eps k_fluid"
    )
    conductivity_solid: ConductivityOrClosure = Field(
        "conductivity_phase", description="effective; conductivity_phase is (1-eps) k_solid"
    )
    tortuosity: NumberOrClosure | None = Field(
        None, description="tortuosity parameter G of the cross conduction between the phases; absent means none"
    )
    dispersion: DispersionOrClosure | None = None


class Sieves(Table):
    """A sieve analysis: apertures from fine to coarse and the mass between neighbours."""

    apertures: Annotated[tuple[Length, ...], Field(min_length=2)]
    mass_fractions: Annotated[tuple[NonNegative, ...], Field(min_length=1)]


class RadiatingSpecies(Table):
    """Particles of one material and their share in the optics of the bed."""

    volume_fraction: Fraction
    diameter: Length | None = Field(None, description="Sauter mean, or of equal spheres")
    sieves: Sieves | None = Field(None, description="instead of `diameter`")
    emissivity: Emissivity
    temperature: Temperature | None = Field(None, description="prescribed; absent: the temperature that is solved for")

    @model_validator(mode="after")
    def _one_size(self) -> RadiatingSpecies:
        if (self.diameter is None) == (self.sieves is None):
            raise ValueError("give one of diameter, sieves")
        return self


class Radiation(Table):
    """Gray radiation between the particles. With [heat] its particles are those of the [bed]; alone it is a medium that
    conducts, is held at a temperature, or is in radiative equilibrium.
    """

    level: Literal["p1", "two_flux", "rosseland", "ordinates"] = Field(
        "p1", description="rosseland: thick beds, as a conductivity; ordinates: one dimension, nearly exact"
    )
    allow_rosseland: Switch = Field(
        False, description="with conduction: rosseland instead of p1 or two_flux where its error is estimated below 1 %"
    )
    emissivity: Emissivity | None = Field(None, description="of the particles of the [bed]")
    species: dict[str, RadiatingSpecies] = Field(default_factory=dict, description="instead of `emissivity`")
    absorption: Extinction | None = Field(None, description="given directly instead of by particles")
    scattering: Extinction | None = None
    correction: Literal["close_packed", "independent"] = Field(
        "close_packed", description="extinction over the voidage, or the limit of points far apart"
    )
    anisotropy: Annotated[Number, Field(ge=-1, le=1)] = Field(0.0, description="mean cosine of scattering")
    ordinates: Annotated[Whole, Field(ge=1, le=64)] = Field(4, description="directions in each hemisphere")
    conductivity: Conductivity | None = Field(None, description="of the medium, without [heat]")
    temperature: Temperature | None = Field(None, description="of the medium, without [heat]")


class RadiationCondition(Table):
    """A gray wall at a temperature, or an opening through which a radiosity enters."""

    emissivity: Emissivity = 1.0
    temperature: Temperature | None = None
    radiosity: Irradiance | None = None

    @model_validator(mode="after")
    def _one(self) -> RadiationCondition:
        if (self.temperature is None) == (self.radiosity is None):
            raise ValueError("give one of temperature, radiosity")
        return self


class PhaseCondition(Table):
    """Thermal condition of one phase on one boundary: exactly one of the four."""

    fixed: Temperature | None = Field(None, description="prescribed temperature")
    inflow: Temperature | None = Field(None, description="Danckwerts: temperature of the entering stream")
    flux: HeatFlux | None = Field(None, description="heat into the bed")
    coefficient: WallCoefficientOrClosure | None = Field(None, description="Robin: wall coefficient to `ambient`")
    ambient: Temperature | None = None

    @model_validator(mode="after")
    def _exactly_one(self) -> PhaseCondition:
        given = [name for name in ("fixed", "inflow", "flux", "coefficient") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"give one of fixed, inflow, flux, coefficient; found {', '.join(given) or 'none'}")
        if (self.coefficient is None) != (self.ambient is None):
            raise ValueError("coefficient and ambient belong together")
        return self


class Boundary(Table):
    """Conditions on one named boundary; what is absent is adiabatic, and a frictionless wall for the flow."""

    flow: Literal["inlet", "outlet", "no_slip", "slip"] | None = Field(
        None, description="absent: inlet or outlet by the sign of the velocity, slip on walls"
    )
    fluid: PhaseCondition | None = None
    solid: PhaseCondition | None = None
    radiation: RadiationCondition | None = Field(None, description="absent: a mirror")


class Tubes(Table):
    """Tubes immersed in a region, as the radiation sees them."""

    area: Extinction = Field(description="tube surface per bed volume")
    emissivity: Emissivity
    temperature: Temperature


class Region(Table):
    """Heat sources in one named region of the mesh, per bed volume, and tubes."""

    source_fluid: HeatSource = 0.0
    source_solid: HeatSource = 0.0
    tubes: Tubes | None = Field(None, description="absorb and emit radiation; with [heat] and [radiation]")


class Time(Table):
    """A transient run; absent means steady."""

    end: Seconds
    initial_fluid: Temperature
    initial_solid: Temperature
    times: tuple[Instant, ...] = Field((), description="output times; the end is always one")
    step: Seconds | None = Field(None, description="fixed step; error-controlled if absent")
    tolerance: Fraction = Field(1e-4, description="local error over the span of temperatures")
    checkpoint_every: Seconds = Field(10.0, description="wall-clock time between checkpoints")


class Solver(Table):
    """Numerics; the defaults suit nearly all scenes."""

    degree: Order = Field(2, description="polynomial degree of the temperatures")
    stabilisation: Switch = Field(True, description="residual-based SUPG")
    tolerance: Fraction = Field(1e-5, description="target error of theta for automatic meshes")
    adapt: Annotated[Whole, Field(ge=0, le=10)] | None = Field(
        None, description="refinements where the error estimate of a steady run exceeds `tolerance`; absent: automatic"
    )
    reduce: Switch = Field(True, description="solve a plug-flow scene with adiabatic walls in one dimension")
    newton_tolerance: Fraction = 1e-10
    newton_iterations: Whole = Field(30, ge=1, le=1000)
    balance_tolerance: Positive = 1e-10
    strict: Switch = Field(False, description="a closure out of its range is an error")
    memory_GB: Positive | None = Field(
        None, description="refuse a factorisation predicted above this; 60 % of the free memory if absent"
    )


class Output(Table):
    """What a run writes besides summary.json."""

    positions: tuple[Position, ...] = Field((), description="profile positions along the axis; automatic if empty")
    fields: Switch = True
    plots: Switch = True


def _absent() -> Any:
    return None


class SceneBase(Table):
    """What scenes of all kinds have in common."""

    kind: ClassVar[str]

    title: str = ""

    _origin: Origin = PrivateAttr(default_factory=Origin)

    @property
    def origin(self) -> Origin:
        """Where the values come from: a name for messages, the lines of the keys, the folder of the file."""
        return self._origin


class Scene(SceneBase):
    """One run of a packed or moving bed."""

    kind: ClassVar[str] = "packed_bed"

    mesh: Mesh
    # fluid, bed and flow are None only in a medium that merely radiates; `checks` sees to it
    fluid: Fluid = Field(default_factory=_absent)
    solid: Solid | None = None
    bed: Bed = Field(default_factory=_absent)
    flow: Flow = Field(default_factory=_absent)
    heat: Heat | None = None
    radiation: Radiation | None = None
    boundary: dict[str, Boundary] = Field(default_factory=dict)
    region: dict[str, Region] = Field(default_factory=dict)
    time: Time | None = None
    solver: Solver = Solver()
    output: Output = Output()

    @property
    def mesh_path(self) -> Path | None:
        """The mesh file of this scene, found from any working directory; None for a built-in mesh."""
        return self._origin.base / self.mesh.file if isinstance(self.mesh, MeshFile) else None
