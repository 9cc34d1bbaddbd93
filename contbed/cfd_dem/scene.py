"""Tables of a scene of particles in a gas: fixed, fluidized or stirred by a jet, in SI.

[particles]              spheres, settled at the start or from a file, and their box
[particles.tubes.NAME]   horizontal tubes across the bed; absent: none
[particles.closure]      velocities for which a Nusselt number is fitted, written as
                         closure.toml; absent: none
[solids.NAME]            the particles and their material
[gas]                    its properties
[closures]               drag and heat transfer
[boundary.bottom]        what enters through the floor
[boundary.jet]           through a slot in the floor; absent: none
[boundary.sides]         whether the gas sticks to them
[heat]                   energy equations of gas and particles; absent: all at one
                         temperature, coefficients are found with closures.nusselt
[initial]                temperature of the particles, with [heat]
[time]                   how long, and from when on averages are taken
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Discriminator, Field

from contbed.dem.scene import SOFT, Spheres
from contbed.scene.gas import Gas
from contbed.scene.quantities import (
    Conductivity,
    Density,
    HeatCapacity,
    Instant,
    Length,
    Natural,
    Number,
    Position,
    Positive,
    Pressure,
    Seconds,
    Share,
    Switch,
    Table,
    Temperature,
    Whole,
    form,
    takes,
    unit,
)
from contbed.scene.solids import one_solid
from contbed.scene.tables import BalancedRun, Named, NamedOrFile, SceneBase

Width = Annotated[tuple[Length, Length], Field(description="of the bed in x and y")]
Speed = Annotated[float, *unit("m/s"), Field(ge=0)]
Flux = Annotated[float, *unit("kg/m**2/s"), Field(gt=0)]


class GasTube(Table):
    """A horizontal tube along y, through the whole depth of the bed.

    tube_NAME.csv has its coefficients by angle and mechanism.
    """

    diameter: Length
    """outside"""
    centre: tuple[Position, Position]
    """of its axis, in x and z"""
    nusselt: Annotated[Named, Discriminator(form)] = Field(
        "churchill_bernstein", json_schema_extra=takes("nusselt_cylinder")
    )
    """of the gas beside it, on its diameter"""
    temperature: Temperature | None = None
    """at which it heats or cools the bed, with [heat]; absent: coefficients alone"""


class NusseltClosure(Table):
    """Nu = 2 + a Re^b Pr^(1/3) fitted to bed averages of a bed at rest, written as
    closure.toml.
    """

    velocities: Annotated[
        tuple[Annotated[float, *unit("m/s"), Field(gt=0)], ...], Field(min_length=4)
    ]
    """superficial, at which the exchange is computed"""
    of: Literal["convection", "total"] = "convection"
    """total: conduction to neighbours as well"""


class GasParticles(Table):
    """Spheres in a box that is open above; those of a file keep their own radii and
    speeds.
    """

    count: Annotated[Whole, Field(ge=1)] | None = None
    """settled from a random start"""
    file: str | None = None
    """in place of count: x,y,z in metres with commas, a .vtu of contbed, or a dump"""
    width: Width
    height: Length
    """of the box, with room above the bed"""
    periodic: Switch = False
    """sides"""
    seed: Natural = 0
    """of the random start of the packing"""
    fixed: Switch = False
    """a packed bed that does not move"""
    gravity: Switch = True
    """whether it acts on the particles"""
    modulus: Pressure = SOFT
    """Young's modulus of the simulation"""
    exponents: tuple[Positive, Positive] = (1 / 3, 1 / 5)
    """of the correction to solids.NAME.youngs_modulus, of contacts at rest and of
    impacts; the paper: 1/5, 2/15"""
    cell: tuple[Positive, Positive] = (3.0, 1.0)
    """width and height of cells in diameters; high cells smear the surface, U_mf grows
    """
    tubes: dict[str, GasTube] = Field(default_factory=dict)
    """horizontal tubes by name"""
    closure: NusseltClosure | None = None


class GasSolid(Spheres):
    """The particles and their material."""

    diameter: Length | None = None
    """of equal spheres; a dump, a .vtu and a column radius bring their own"""
    density: Density
    """of the particles"""
    conductivity: Conductivity = 0.0
    """thermal, of the material; needed with closures.nusselt"""
    heat_capacity: HeatCapacity = 840.0
    """of the particles"""
    emissivity: Share = 0.0
    """of the particles; 0: no radiation between neighbours"""


class Closures(Table):
    """Exchange of particles and gas."""

    drag: Annotated[Named, Discriminator(form)] = "di_felice"
    """of the gas on a particle"""
    nusselt: Annotated[NamedOrFile, Discriminator(form)] | None = None
    """Nusselt number of the exchange between gas and particles; absent: no heat is
    exchanged, and no coefficients are found"""


class EnteringGas(Table):
    """Gas from below."""

    velocity: Speed
    """superficial, into the bed"""
    temperature: Temperature = 300.0
    """of the gas that enters"""


class Bottom(Table):
    """The floor."""

    gas: EnteringGas


class JetGas(Table):
    """Gas of a jet."""

    velocity: Annotated[float, *unit("m/s"), Field(gt=0)] | None = None
    """in the slot; or mass_flux"""
    mass_flux: Flux | None = None
    """in the slot; or velocity"""
    temperature: Temperature | None = None
    """of the jet; absent: that of boundary.bottom.gas"""


class Jet(Table):
    """A slot in the floor across the whole depth."""

    on: Literal["bottom"] = "bottom"
    """boundary that it is a piece of"""
    start: Position
    """of the slot in x"""
    end: Position
    """of the slot in x"""
    until: Instant | None = None
    """when it stops; absent: never"""
    gas: JetGas


class SidesGas(Table):
    """Gas at the sides."""

    wall: Literal["slip", "no_slip"] = "slip"
    """whether the gas sticks to the sides"""


class Sides(Table):
    """The sides of the box."""

    gas: SidesGas = SidesGas()


class Boundary(Table):
    """Boundaries of the gas; the top is open."""

    bottom: Bottom
    jet: Jet | None = None
    sides: Sides = Sides()


class GasHeat(Table):
    """Temperatures that change."""

    interval: Seconds = 5e-3
    """after which conductances between particles are found anew"""


class SolidAtStart(Table):
    """The particles at the start."""

    temperature: Temperature
    """of the particles"""


class Initial(Table):
    """The bed at the start; the gas has the temperature of the particles."""

    solids: dict[str, SolidAtStart] = Field(default_factory=dict)
    """solid phases by name"""


class GasTime(Table):
    """The run."""

    end: Seconds
    """time at which the run ends"""
    average_from: Instant = 0.0
    """time from which averages are taken"""
    step: Seconds = 2e-4
    """longest step of the gas"""
    sample: Seconds = 0.02
    """interval of samples and rows of profiles.csv; the last is at `end`"""
    fields: Seconds | None = None
    """interval of particle files, which are written at samples; absent: the end only"""
    checkpoint_every: Seconds = 10.0
    """wall-clock time between checkpoints"""


class GasOutput(Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: Switch = True
    """draw plots (.png)"""
    fields: Switch = True
    """write fields for ParaView (.vtu)"""
    probes: dict[str, tuple[Position, Position, Position]] = Field(default_factory=dict)
    """points in x, y and z, for profiles.csv"""
    levels: tuple[Position, ...] = ()
    """heights, for averages across the bed in levels.csv"""


class GasSolver(BalancedRun):
    """Tolerances."""

    pressure_tolerance: Annotated[Number, Field(gt=0, lt=1e-2)] = 1e-7
    """relative residual of the pressure equation"""


class GasScene(SceneBase):
    """Particles in a gas."""

    kind: ClassVar[str] = "particles_gas"

    particles: GasParticles
    solids: Annotated[dict[str, GasSolid], AfterValidator(one_solid)]
    """the particles, by name"""
    gas: Gas
    closures: Closures = Closures()
    boundary: Boundary
    heat: GasHeat | None = None
    initial: Initial = Initial()
    time: GasTime
    solver: GasSolver = GasSolver()
    output: GasOutput = GasOutput()

    @property
    def solid(self) -> GasSolid:
        """The only solid phase."""
        return next(iter(self.solids.values()))

    @property
    def inlet(self) -> EnteringGas:
        """The gas that enters from below."""
        return self.boundary.bottom.gas

    @property
    def T_jet(self) -> float:
        """Temperature of the jet, without one that of the gas from below [K]."""
        jet, T = self.boundary.jet, None
        if jet is not None:
            T = jet.gas.temperature
        return self.inlet.temperature if T is None else T

    @property
    def T_start(self) -> float | None:
        """Temperature of the particles at the start [K]; None without [heat]."""
        if self.heat is None:
            return None
        return self.initial.solids[next(iter(self.solids))].temperature
