"""Tables of a scene with [fully_developed]: gas and particles that rise or fall, uniform along the way, in SI.

See `developed_flow.equations`.

    [fully_developed]         section, the two flows, branch, closures by name
    [gas], [solid], [wall]    their properties
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from contbed.scene.quantities import (
    Density,
    Fraction,
    Length,
    Number,
    Order,
    Positive,
    Switch,
    Table,
    Whole,
    takes,
    unit,
)
from contbed.scene.tables import OfMaterial, SceneBase
from contbed.two_fluid.scene import Flux, Gas, Named


class FullyDeveloped(Table):
    """The section, what flows through it, and closures."""

    section: Literal["channel", "pipe"]
    radius: Length = Field(description="of the pipe, or half the width of the channel")
    velocity: Annotated[float, *unit("m/s"), Field(gt=0)] = Field(description="superficial, of the gas, upward")
    solid_flux: Flux = Field(description="mass flux of the particles, upward; 0: gas alone")
    theta_centre: Annotated[float, *unit("m**2/s**2"), Field(gt=0)] | None = Field(
        None, description="granular temperature at the centre of the solution that is meant, where there are several"
    )
    gravity: Annotated[float, *unit("m/s**2"), Field(ge=0)] = 9.81
    drag: Named = "drag_wen_yu"
    radial_distribution: str = "g0_sinclair_jackson"
    pressure: str = "granular_pressure_lun"
    viscosity: str = "granular_viscosity_gidaspow"
    conductivity: str = "granular_conductivity_syamlal"
    dissipation: str = "granular_dissipation_lun"
    production: str | None = Field(
        None,
        description="of fluctuations by the slip, for fine particles: granular_production_koch; absent: none",
        json_schema_extra=takes("granular_production"),
    )
    turbulence: str | None = Field(
        None,
        description="of the gas above Re 2300: eddy_viscosity_nikuradse; absent: the gas is laminar",
        json_schema_extra=takes("eddy_viscosity"),
    )


class Solid(OfMaterial):
    """Equal spheres."""

    particle_diameter: Length
    density: Density
    restitution: Annotated[Number, Field(gt=0, le=1)] = 0.9
    packing: Annotated[Number, Field(gt=0, lt=0.75)] = Field(0.63, description="densest fraction")


class Wall(Table):
    """Where the gas stands still and particles slip, after Johnson and Jackson."""

    specularity: Annotated[Number, Field(gt=0, le=1)]
    restitution: Annotated[Number, Field(gt=0, le=1)] = 0.9


class Output(Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: Switch = True
    fields: Switch = True


class Solver(Table):
    """Numerics."""

    cells: Whole = Field(60, ge=4, le=10000, description="between centre and wall, finer toward the wall")
    degree: Order = Field(3, description="polynomial degree of the fields")
    branches: Switch = Field(False, description="follow solutions over the velocity to find others of it")
    newton_tolerance: Fraction = 1e-10
    newton_iterations: Whole = Field(60, ge=1, le=1000)
    balance_tolerance: Positive = 1e-10
    strict: Switch = Field(False, description="a closure out of its range is an error")


class DevelopedScene(SceneBase):
    """Fully developed flow of gas and particles."""

    kind: ClassVar[str] = "fully_developed"
    renamed: ClassVar[Mapping[str, str]] = {"solid.diameter": "particle_diameter"}
    time: ClassVar[None] = None

    fully_developed: FullyDeveloped
    gas: Gas
    solid: Solid
    wall: Wall
    output: Output = Output()
    solver: Solver = Solver()
