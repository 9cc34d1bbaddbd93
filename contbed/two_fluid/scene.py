"""The vocabulary of a scene with a [two_fluid] table: gas and particles as two fluids, transient, in SI.

    [mesh]                    gravity points against its last axis, on a line against x
    [two_fluid]               gravity, closures by name, guards
    [gas], [solid]            their properties
    [initial]                 fields at the start, with [[initial.layer]] along the last axis
    [boundary.NAME]           wall, symmetry, periodic, inlet, outlet
    [heat]                    temperatures; absent: isothermal
    [time]                    how long, steps by the Courant number, averages

A closure that is "none" is absent and costs nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Discriminator, Field

from contbed.scene import tables
from contbed.scene.mesh import Mesh
from contbed.scene.quantities import (
    Density,
    Instant,
    Length,
    Number,
    Position,
    Positive,
    Seconds,
    Switch,
    Table,
    Viscosity,
    Whole,
    form,
    unit,
)
from contbed.scene.tables import OfMaterial, SceneBase
from contbed.two_fluid.heat.scene import Heat, HeatOfWall, Temperatures

Speed = Annotated[float, *unit("m/s")]
Share = Annotated[Number, Field(ge=0, lt=1)]
Theta = Annotated[float, *unit("m**2/s**2"), Field(ge=0)]
Angle = Annotated[float, *unit("rad"), Field(gt=0, lt=1.5)]
Flux = Annotated[float, *unit("kg/m**2/s"), Field(ge=0)]
Named = Annotated[tables.Named, Discriminator(form)]


class TwoFluid(Table):
    """The model and its closures."""

    gravity: Annotated[float, *unit("m/s**2"), Field(ge=0)] = 9.81
    granular_temperature: Literal["pde", "algebraic", "frozen"] = "pde"
    drag: Named = "drag_gidaspow"
    radial_distribution: str = "g0_sinclair_jackson"
    pressure: Named = Field("granular_pressure_lun", description='"granular_pressure_dilute": without collisions')
    viscosity: Named = Field("granular_viscosity_gidaspow", description='"none": particles without stress but pressure')
    bulk_viscosity: str = "granular_bulk_lun"
    conductivity: str = "granular_conductivity_syamlal"
    dissipation: str = "granular_dissipation_lun"
    effective_restitution: Named = Field(
        "none", description="friction of particles in the dissipation, from its coefficient"
    )
    friction: str = Field("friction_johnson_jackson", description='"none": no friction near packing')
    friction_viscosity: str = Field("friction_viscosity_newtonian", description='"none": friction pushes only')
    wall_drag: str = Field("none", description='"igci": factor of filtered drag near slip walls')
    wall_pressure: str = Field("none", description="the same of the filtered pressure of the particles")
    wall_viscosity: str = Field("none", description="the same of their filtered viscosity")
    guards: Switch = Field(True, description="limit the kinetic stress of dilute flow by drag and free path")
    free_path: Length = Field(0.01, description="largest mean free path that the guards allow")


class Gas(Table):
    """Incompressible gas or liquid."""

    density: Density
    viscosity: Viscosity


class Friction(Table):
    """Of particles near packing."""

    start: Annotated[Number, Field(gt=0, lt=1)] = Field(
        0.5, description="fraction above which particles rub; a bed fluidizes near the porosity 1 - start"
    )
    strength: Annotated[float, *unit("Pa"), Field(gt=0)] = 0.05
    angle: Angle = 0.49742


class Solid(OfMaterial):
    """Equal spheres."""

    particle_diameter: Length
    density: Density
    restitution: Annotated[Number, Field(gt=0, le=1)] = 0.9
    sliding_friction: Annotated[Number, Field(ge=0)] | None = Field(
        None, description="Coulomb's coefficient of two particles, for two_fluid.effective_restitution"
    )
    packing: Annotated[Number, Field(gt=0, lt=0.75)] = Field(0.63, description="densest fraction")
    friction: Friction = Friction()


class Layer(Temperatures):
    """Fields between two positions along the last axis; what is not given stays as it was."""

    start: Position = -1e30
    end: Position = 1e30
    eps_s: Share | None = None
    theta: Theta | None = None
    u_gas: Speed | None = Field(None, description="along the last axis")
    u_solid: Speed | None = None


class Initial(Temperatures):
    """Fields at the start."""

    eps_s: Share = 0.0
    theta: Theta = 1e-4
    u_gas: Speed = Field(0.0, description="intrinsic, along the last axis")
    u_solid: Speed = 0.0
    shear: Annotated[float, *unit("1/s")] = Field(0.0, description="of the particles: u_x grows with the last axis")
    noise: Annotated[Number, Field(ge=0, lt=1)] = Field(0.0, description="relative, of eps_s, to break symmetry")
    seed: Annotated[Whole, Field(ge=0)] = 0
    layer: tuple[Layer, ...] = ()


class Part(Table):
    """A boundary, or a piece of one along the last axis; along the first, of one that is level."""

    on: str | None = Field(None, description="boundary of the mesh that this is a piece of, from start to end")
    start: Position | None = None
    end: Position | None = None


class Wall(Part, HeatOfWall):
    """Nothing passes."""

    type: Literal["wall"]
    gas: Literal["no_slip", "slip"] = "no_slip"
    solid: Literal["no_slip", "slip", "johnson_jackson"] = "no_slip"
    specularity: Annotated[Number, Field(gt=0, le=1)] | None = None
    restitution: Annotated[Number, Field(gt=0, le=1)] | None = None
    friction: Annotated[Number, Field(ge=0, le=2)] = Field(
        0.0, description="Coulomb's coefficient of particles that rub along the wall under their frictional pressure"
    )
    velocity: tuple[Speed, ...] = Field((), description="of the wall in its own plane")


class Symmetry(Part):
    """A plane of symmetry, or the axis."""

    type: Literal["symmetry"]


class Periodic(Table):
    """One and the same as another boundary."""

    type: Literal["periodic"]
    partner: str = Field(description="the boundary opposite, which is not named again")


class Inlet(Part, Temperatures):
    """Gas, with or without particles."""

    type: Literal["inlet"]
    until: Seconds | None = Field(None, description="then it is as the inlet that it is a piece of")
    velocity: Annotated[Speed, Field(ge=0)] = Field(0.0, description="superficial, of the gas")
    eps_s: Share = 0.0
    solid_flux: Flux | None = Field(None, description="mass flux of the particles through this boundary")
    solid_velocity: Annotated[Speed, Field(gt=0)] | None = None
    theta: Theta = 0.0


class Outlet(Part):
    """Free outflow against a pressure; particles do not come back."""

    type: Literal["outlet"]
    pressure: Annotated[float, *unit("Pa")] = 0.0


Boundary = Annotated[Wall | Symmetry | Periodic | Inlet | Outlet, Field(discriminator="type")]


class Window(Table):
    """Where lateral profiles are averaged, along the last axis."""

    start: Position
    end: Position


class Time(Table):
    """The run and its averages."""

    end: Seconds
    courant: Annotated[Number, Field(gt=0, le=1)] = 0.5
    step: Seconds | None = Field(None, description="fixed, in place of the Courant number")
    longest: Seconds = 1e-2
    first: Seconds = 1e-5
    order: Literal[1, 2] = 1
    average_from: Instant | None = Field(None, description="absent: no averages")
    sample: Seconds | None = Field(None, description="interval of rows in profiles.csv; absent: 1/200 of the run")
    fields: Seconds | None = Field(None, description="interval of fields; absent: the end only")
    checkpoint_every: Seconds = Field(10.0, description="wall-clock time between checkpoints")


class Output(Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: Switch = True
    fields: Switch = True
    window: Window | None = Field(None, description="for lateral.csv; absent: the whole height")
    levels: tuple[Position, ...] = Field((), description="along the last axis, lateral profiles for levels.csv")
    probes: dict[str, tuple[Position, ...]] = Field(default_factory=dict, description="points, for profiles.csv")


class Solver(Table):
    """Tolerances."""

    balance_tolerance: Positive = 1e-10
    strict: Switch = Field(False, description="a closure out of its range is an error")


class TwoFluidScene(SceneBase):
    """Gas and particles as two fluids."""

    kind: ClassVar[str] = "two_fluid"
    renamed: ClassVar[Mapping[str, str]] = {"solid.diameter": "particle_diameter"}
    refused: ClassVar[Mapping[str, str]] = {
        "radiation": "two fluids exchange heat by convection and conduction alone, as radiation between particles that "
        "move would be solved anew in each time step; use [bubbling_bed] or a packed bed of the mean porosity with it"
    }

    mesh: Mesh
    two_fluid: TwoFluid
    gas: Gas
    solid: Solid
    initial: Initial = Initial()
    boundary: dict[str, Boundary] = Field(default_factory=dict)
    heat: Heat | None = None
    time: Time
    output: Output = Output()
    solver: Solver = Solver()
