"""The vocabulary of a scene of particles in a gas: fixed, fluidized or stirred by a jet, in SI.

[particles]     spheres, settled at the start or from a file, and their material
[fluid]         constant properties, or a gas mixture of Cantera
[gas]           inlet, closures of drag and heat transfer, grid
[heat]          energy equations of gas and particles; absent: all at one temperature, coefficients are still found
[time]          how long, and from when on averages are taken
[closure]       velocities for which a Nusselt number is fitted, written as closure.toml; absent: none
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Discriminator, Field

from contbed.dem.scene import Above
from contbed.packed_bed import scene as s
from contbed.scene.quantities import unit

Width = Annotated[tuple[s.Length, s.Length], Field(description="of the bed in x and y")]
Speed = Annotated[float, *unit("m/s"), Field(ge=0)]
Flux = Annotated[float, *unit("kg/m**2/s"), Field(gt=0)]


class GasParticles(s.Table):
    """Equal spheres in a box that is open above; those of a file keep their own radii and speeds if it has them."""

    count: Annotated[s.Whole, Field(ge=1)] | None = Field(None, description="settled from a random start")
    file: str | None = Field(None, description="in place of count: text with x,y,z in metres, or a dump")
    radius: s.Length | None = Field(None, description="of equal spheres; a dump brings its own")
    width: Width
    periodic: s.Switch = Field(False, description="sides")
    seed: Annotated[s.Whole, Field(ge=0)] = 0
    fixed: s.Switch = Field(False, description="a packed bed that does not move")
    density: s.Density
    heat_capacity: s.HeatCapacity = 840.0
    conductivity: Above
    emissivity: Annotated[s.Number, Field(ge=0, le=1)] = 0.0
    modulus: s.Pressure = Field(1e7, description="Young's modulus of the simulation")
    modulus_real: s.Pressure | None = Field(None, description="of the material, for which contacts are corrected")
    exponents: tuple[s.Positive, s.Positive] = Field(
        (1 / 3, 1 / 5), description="of the correction of contacts at rest and of impacts; the paper: 1/5, 2/15"
    )
    poisson_ratio: Annotated[s.Number, Field(gt=-1, le=0.5)] = 0.3
    restitution: Annotated[s.Number, Field(gt=0, le=1)] = 0.9
    sliding_friction: s.NonNegative = 0.3
    rolling_friction: s.NonNegative = Field(0.0, description="arm over the effective radius")


class Jet(s.Table):
    """A slot in the floor across the whole depth."""

    slot: tuple[s.Position, s.Position] = Field(description="from x0 to x1")
    mass_flux: Flux
    T: s.Temperature
    end: s.Instant | None = Field(None, description="when it stops; absent: never")


class GasFlow(s.Table):
    """Gas from below."""

    velocity: Speed = Field(description="superficial, at the inlet")
    T: s.Temperature = 300.0
    height: s.Length = Field(description="of the box, with room above the bed")
    drag: Annotated[s.Named, Discriminator(s.form)] = "di_felice"
    nusselt: Annotated[s.NamedOrFile, Discriminator(s.form)]
    cell: tuple[s.Positive, s.Positive] = Field(
        (3.0, 1.0), description="width and height of cells in diameters; high cells smear the surface, U_mf grows"
    )
    no_slip: s.Switch = Field(False, description="the gas sticks to the sides")
    step: s.Seconds = Field(2e-4, description="longest step of the gas")
    gravity: s.Switch = True
    jet: Jet | None = None


class GasHeat(s.Table):
    """Temperatures that change."""

    T: s.Temperature = Field(description="of the particles at the start")
    interval: s.Seconds = Field(5e-3, description="after which conductances between particles are found anew")


class GasTime(s.Table):
    """The run."""

    end: s.Seconds
    average_from: s.Instant = 0.0
    sample: s.Seconds = Field(0.02, description="interval of samples and rows of profiles.csv")
    fields: s.Seconds | None = Field(None, description="interval of particle files; absent: the end only")


class NusseltClosure(s.Table):
    """Nu = 2 + a Re^b Pr^(1/3) fitted to bed averages of a bed at rest, written as closure.toml."""

    velocities: Annotated[tuple[Annotated[float, *unit("m/s"), Field(gt=0)], ...], Field(min_length=4)]
    of: Literal["convection", "total"] = Field("convection", description="total: conduction to neighbours as well")


class GasOutput(s.Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: s.Switch = True
    fields: s.Switch = True


class GasSolver(s.Table):
    """Tolerances."""

    balance_tolerance: s.Positive = 1e-10
    pressure_tolerance: Annotated[s.Number, Field(gt=0, lt=1e-2)] = 1e-7
    strict: s.Switch = Field(False, description="a closure out of its range is an error")


class GasScene(s.SceneBase):
    """Particles in a gas."""

    kind: ClassVar[str] = "particles_gas"

    particles: GasParticles
    fluid: s.FluidConstant | s.FluidCantera = Field(discriminator="model")
    gas: GasFlow
    heat: GasHeat | None = None
    time: GasTime
    closure: NusseltClosure | None = None
    solver: GasSolver = GasSolver()
    output: GasOutput = GasOutput()
