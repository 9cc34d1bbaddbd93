"""The vocabulary of a scene of particles in a gas: fixed, fluidized or stirred by a jet, in SI.

[particles]     spheres, settled at the start or from a file, and their material
[fluid]         constant properties, or a gas mixture of Cantera
[gas]           inlet, closures of drag and heat transfer, grid
[tubes.NAME]    horizontal tubes across the bed; absent: none
[heat]          energy equations of gas and particles; absent: all at one temperature, coefficients are still found
[time]          how long, and from when on averages are taken
[closure]       velocities for which a Nusselt number is fitted, written as closure.toml; absent: none
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Discriminator, Field

from contbed.dem.scene import Above
from contbed.scene.quantities import (
    Density,
    HeatCapacity,
    Instant,
    Length,
    NonNegative,
    Number,
    Position,
    Positive,
    Pressure,
    Seconds,
    Switch,
    Table,
    Temperature,
    Whole,
    form,
    takes,
    unit,
)
from contbed.scene.tables import FluidCantera, FluidConstant, Named, NamedOrFile, OfMaterial, SceneBase

Width = Annotated[tuple[Length, Length], Field(description="of the bed in x and y")]
Speed = Annotated[float, *unit("m/s"), Field(ge=0)]
Flux = Annotated[float, *unit("kg/m**2/s"), Field(gt=0)]


class GasParticles(OfMaterial):
    """Equal spheres in a box that is open above; those of a file keep their own radii and speeds if it has them."""

    of_material: ClassVar[dict[str, str]] = {name: name for name in ("density", "heat_capacity", "conductivity")}

    count: Annotated[Whole, Field(ge=1)] | None = Field(None, description="settled from a random start")
    file: str | None = Field(
        None, description="in place of count: x,y,z in metres with commas, a .vtu of contbed, or a dump"
    )
    radius: Length | None = Field(
        None, description="of equal spheres; a dump, a .vtu and a column radius bring their own"
    )
    width: Width
    periodic: Switch = Field(False, description="sides")
    seed: Annotated[Whole, Field(ge=0)] = Field(0, description="seed of the random start of the packing")
    fixed: Switch = Field(False, description="a packed bed that does not move")
    density: Density = Field(description="density of the particles")
    heat_capacity: HeatCapacity = Field(840.0, description="specific heat capacity of the particles")
    conductivity: Above = Field(description="thermal conductivity of the particles")
    emissivity: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.0, description="emissivity of the particles; 0: no radiation between neighbours"
    )
    modulus: Pressure = Field(1e7, description="Young's modulus of the simulation")
    modulus_real: Pressure | None = Field(None, description="of the material, for which contacts are corrected")
    exponents: tuple[Positive, Positive] = Field(
        (1 / 3, 1 / 5), description="of the correction of contacts at rest and of impacts; the paper: 1/5, 2/15"
    )
    # re-entrant foams reach -0.7: Lakes 1987, Science 235, 1038, doi:10.1126/science.235.4792.1038
    poisson_ratio: Annotated[Number, Field(ge=-0.7, le=0.5)] = Field(
        0.3, description="0.1 to 0.5 of solids; only foams made for it are negative, down to -0.7"
    )
    restitution: Annotated[Number, Field(gt=0, le=1)] = Field(0.9, description="coefficient of restitution of contacts")
    sliding_friction: NonNegative = Field(0.3, description="coefficient of sliding friction of contacts")
    rolling_friction: NonNegative = Field(0.0, description="arm over the effective radius")


class Jet(Table):
    """A slot in the floor across the whole depth."""

    slot: tuple[Position, Position] = Field(description="from x0 to x1")
    mass_flux: Flux = Field(description="mass flux of the jet")
    T: Temperature = Field(description="temperature of the jet")
    end: Instant | None = Field(None, description="when it stops; absent: never")


class GasFlow(Table):
    """Gas from below."""

    velocity: Speed = Field(description="superficial, at the inlet")
    T: Temperature = Field(300.0, description="temperature of the gas that enters")
    height: Length = Field(description="of the box, with room above the bed")
    drag: Annotated[Named, Discriminator(form)] = Field("di_felice", description="drag of the gas on a particle")
    nusselt: Annotated[NamedOrFile, Discriminator(form)] = Field(
        description="Nusselt number of the exchange between gas and particles"
    )
    cell: tuple[Positive, Positive] = Field(
        (3.0, 1.0), description="width and height of cells in diameters; high cells smear the surface, U_mf grows"
    )
    no_slip: Switch = Field(False, description="the gas sticks to the sides")
    step: Seconds = Field(2e-4, description="longest step of the gas")
    gravity: Switch = Field(True, description="whether gravity acts on the particles")
    jet: Jet | None = None


class GasTube(Table):
    """A horizontal tube along y, through the whole depth of the bed; h by angle and mechanism in tube_NAME.csv."""

    diameter: Length = Field(description="outer diameter of the tube")
    centre: tuple[Position, Position] = Field(description="of its axis, in x and z")
    nusselt: Annotated[Named, Discriminator(form)] = Field(
        "churchill_bernstein",
        description="of the gas beside it, on its diameter",
        json_schema_extra=takes("nusselt_cylinder"),
    )
    T: Temperature | None = Field(
        None, description="at which it heats or cools the bed, with [heat]; absent: coefficients alone"
    )


class GasHeat(Table):
    """Temperatures that change."""

    T: Temperature = Field(description="of the particles at the start")
    interval: Seconds = Field(5e-3, description="after which conductances between particles are found anew")


class GasTime(Table):
    """The run."""

    end: Seconds = Field(description="time at which the run ends")
    average_from: Instant = Field(0.0, description="time from which averages are taken")
    sample: Seconds = Field(0.02, description="interval of samples and rows of profiles.csv")
    fields: Seconds | None = Field(None, description="interval of particle files; absent: the end only")
    checkpoint_every: Seconds = Field(10.0, description="wall-clock time between checkpoints")


class NusseltClosure(Table):
    """Nu = 2 + a Re^b Pr^(1/3) fitted to bed averages of a bed at rest, written as closure.toml."""

    velocities: Annotated[tuple[Annotated[float, *unit("m/s"), Field(gt=0)], ...], Field(min_length=4)] = Field(
        description="superficial velocities at which the exchange is computed"
    )
    of: Literal["convection", "total"] = Field("convection", description="total: conduction to neighbours as well")


class GasOutput(Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: Switch = Field(True, description="draw plots (.png)")
    fields: Switch = Field(True, description="write fields for ParaView (.vtu)")
    probes: dict[str, tuple[Position, Position, Position]] = Field(
        default_factory=dict, description="points in x, y and z, for profiles.csv"
    )
    levels: tuple[Position, ...] = Field((), description="heights, for averages across the bed in levels.csv")


class GasSolver(Table):
    """Tolerances."""

    balance_tolerance: Positive = Field(1e-10, description="largest relative residual of a balance that a run accepts")
    pressure_tolerance: Annotated[Number, Field(gt=0, lt=1e-2)] = Field(
        1e-7, description="relative residual of the pressure equation"
    )
    strict: Switch = Field(False, description="a closure out of its range is an error")


class GasScene(SceneBase):
    """Particles in a gas."""

    kind: ClassVar[str] = "particles_gas"

    particles: GasParticles
    fluid: FluidConstant | FluidCantera = Field(discriminator="model")
    gas: GasFlow
    tubes: dict[str, GasTube] = Field(default_factory=dict, description="horizontal tubes by name")
    heat: GasHeat | None = None
    time: GasTime
    closure: NusseltClosure | None = None
    solver: GasSolver = GasSolver()
    output: GasOutput = GasOutput()
