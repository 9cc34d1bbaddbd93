"""The vocabulary of a scene: every table and key, with unit, bounds and meaning, as frozen pydantic models in SI.

A plain number is SI; a string may carry a unit ("3 mm", "100 degC") and is converted here, at the door, so that
nothing behind it ever sees a unit. A table that is absent means that its physics is absent. Defaults live here only.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PrivateAttr,
    Strict,
    Tag,
    model_validator,
)

from contbed.toml_lines import Origin


def in_unit(name: str) -> BeforeValidator:
    """Validator that turns "3 mm" into 0.003 for `name` "m", also inside lists; other values pass."""

    def convert(value: Any) -> Any:
        if isinstance(value, (list, tuple)):
            return tuple(convert(item) for item in value)
        if isinstance(value, str):
            from contbed.units import to_si

            return to_si(value, name)
        if isinstance(value, bool):
            raise ValueError(f"expected a number, found {str(value).lower()}")
        return value

    return BeforeValidator(convert)


def form(value: Any) -> str:
    """Which way of writing a value was chosen where there are several; a union's members carry these as tags."""
    if isinstance(value, ClosureFile) or (isinstance(value, dict) and "file" in value and "name" not in value):
        return "file"
    if isinstance(value, (dict, Table)):
        return "parameters"
    if isinstance(value, (list, tuple)):
        return "list"
    if isinstance(value, str) and not value.strip()[:1].isdigit() and value.strip()[:1] not in {"-", "+", "."}:
        return "name"
    return "number"


def dispersion_form(value: Any) -> str:
    """`form`, where a table without a name holds the two conductivities themselves."""
    nameless = isinstance(value, Dispersion) or (isinstance(value, dict) and "name" not in value)
    return "table" if nameless else form(value)


def no_switch(value: Any) -> Any:
    """Python takes true for 1; a scene does not."""
    if isinstance(value, bool):
        raise ValueError(f"expected a whole number, found {str(value).lower()}")
    return value


def unit(name: str) -> tuple[Any, ...]:
    """Annotations of a finite number in the SI unit `name`."""
    return Field(allow_inf_nan=False, json_schema_extra={"unit": name}), in_unit(name)


Number = Annotated[float, *unit("1")]
Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Fraction = Annotated[Number, Field(gt=0, lt=1)]
Position = Annotated[float, *unit("m")]
Length = Annotated[Position, Field(gt=0)]
Permeability = Annotated[float, *unit("m**2"), Field(gt=0)]
Temperature = Annotated[float, *unit("K"), Field(gt=0)]
Conductivity = Annotated[float, *unit("W/m/K"), Field(ge=0)]
Emissivity = Annotated[Number, Field(gt=0, le=1)]
Extinction = Annotated[float, *unit("1/m"), Field(ge=0)]
Irradiance = Annotated[float, *unit("W/m**2"), Field(ge=0)]
WallCoefficient = Annotated[float, *unit("W/m**2/K"), Field(ge=0)]
HeatFlux = Annotated[float, *unit("W/m**2")]
HeatSource = Annotated[float, *unit("W/m**3")]
Density = Annotated[float, *unit("kg/m**3"), Field(gt=0)]
HeatCapacity = Annotated[float, *unit("J/kg/K"), Field(gt=0)]
Viscosity = Annotated[float, *unit("Pa*s"), Field(gt=0)]
Pressure = Annotated[float, *unit("Pa"), Field(gt=0)]
Seconds = Annotated[float, *unit("s"), Field(gt=0)]
Instant = Annotated[float, *unit("s"), Field(ge=0)]
FiniteFloat = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Velocity = Annotated[
    Annotated[FiniteFloat, Tag("number")] | Annotated[tuple[FiniteFloat, ...], Tag("list")],
    Field(json_schema_extra={"unit": "m/s"}),
    Discriminator(form),
    in_unit("m/s"),
]
Order = Annotated[Literal[1, 2, 3], BeforeValidator(no_switch)]
Cells = Annotated[int, Strict(), Field(ge=1, le=10_000_000)]
Whole = Annotated[int, Strict()]
Switch = Annotated[bool, Strict()]


REGION = "bed"  # the only region of a built-in mesh
GRADED = "grade the given number of cells to the layer widths; uniform otherwise"


class Table(BaseModel):
    """A TOML table: unknown keys are errors and values do not change after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class MeshLine(Table):
    """A bed along x from 0 to `length`; boundaries `left`, `right`."""

    dimension: ClassVar[int] = 1
    sides: ClassVar = (("left", "right"),)
    type: Literal["line"]
    length: Length
    cells: Cells | None = Field(None, description="number of cells; automatic grading to the layer widths if absent")
    graded: Switch = Field(False, description=GRADED)
    refine: Whole = Field(0, ge=0, le=12, description="uniform refinements after construction")


class MeshRectangle(Table):
    """A planar channel, x along `length`, y along `height`; boundaries `left`, `right`, `bottom`, `top`."""

    dimension: ClassVar[int] = 2
    sides: ClassVar = (("left", "right"), ("bottom", "top"))
    type: Literal["rectangle"]
    length: Length
    height: Length
    cells: tuple[Cells, Cells] | None = None
    graded: Switch = Field(False, description=GRADED)
    shape: Literal["triangle", "quadrilateral"] = "quadrilateral"
    refine: Whole = Field(0, ge=0, le=8)


class MeshAxisymmetric(Table):
    """A cylinder in (r, z), z along `length`; boundaries `axis`, `wall`, `bottom`, `top`."""

    dimension: ClassVar[int] = 2
    sides: ClassVar = (("axis", "wall"), ("bottom", "top"))
    type: Literal["axisymmetric"]
    length: Length
    radius: Length
    cells: tuple[Cells, Cells] | None = Field(None, description="cells along r and along z")
    graded: Switch = Field(False, description=GRADED)
    shape: Literal["triangle", "quadrilateral"] = "quadrilateral"
    refine: Whole = Field(0, ge=0, le=8)


class MeshBox(Table):
    """A box, x along `length`, y `width`, z `height`; boundaries `left right front back bottom top`."""

    dimension: ClassVar[int] = 3
    sides: ClassVar = (("left", "right"), ("front", "back"), ("bottom", "top"))
    type: Literal["box"]
    length: Length
    width: Length
    height: Length
    cells: tuple[Cells, Cells, Cells] | None = None
    graded: Switch = Field(False, description=GRADED)
    shape: Literal["tetrahedron", "hexahedron"] = "hexahedron"
    refine: Whole = Field(0, ge=0, le=6)


class MeshFile(Table):
    """A gmsh geometry (.geo, meshed by gmsh) or a mesh (.msh); physical groups name regions and boundaries."""

    type: Literal["file"]
    file: str = Field(description="path relative to the scene")
    dimension: Order = 2
    axisymmetric: Switch = Field(False, description="coordinates are (r, z)")
    scale: Positive = Field(1.0, description="factor from the file's length unit to metres")
    size: Length | None = Field(None, description="target cell size for a .geo; its own sizes if absent")
    refine: Whole = Field(0, ge=0, le=8)


Mesh = Annotated[MeshLine | MeshRectangle | MeshAxisymmetric | MeshBox | MeshFile, Field(discriminator="type")]


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


class ClosureFile(Table):
    """A closure that was fitted from particles."""

    file: str = Field(description="closure file, path relative to the scene")


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
    forchheimer: NonNegativeOrClosure = Field(
        "forchheimer_ergun", description="inertial drag coefficient c_F"
    )


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
    coefficient: WallCoefficientOrClosure | None = Field(
        None, description="Robin: wall coefficient to `ambient`"
    )
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


class Region(Table):
    """Heat sources in one named region of the mesh, per bed volume."""

    source_fluid: HeatSource = 0.0
    source_solid: HeatSource = 0.0


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
    tolerance: Fraction = Field(
        1e-5, description="target error of theta for automatic meshes"
    )
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
    # fluid, bed and flow are None only in a medium that merely radiates; scene_checks sees to it
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
