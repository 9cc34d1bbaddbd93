"""Tables of a scene of developed flow: gas and particles that rise or fall, uniform
along the way, in SI.

See `developed_flow.equations`.

    [gas], [solids.NAME]      their properties; there is one solid phase
    [closures]                by name
    [boundary.wall]           slip of the particles
    [developed_flow]          section, the two flows, branch
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from contbed.scene import gas as gases
from contbed.scene.quantities import (
    Density,
    Length,
    Number,
    Order,
    PositiveShare,
    Switch,
    Table,
    Whole,
    takes,
    unit,
)
from contbed.scene.solids import SolidPhase, one_solid
from contbed.scene.tables import NewtonSolver, SceneBase
from contbed.two_fluid.conditions import Flux
from contbed.two_fluid.scene import ConstantsAt, Named

if TYPE_CHECKING:
    from contbed.materials.constants import Constants


class DevelopedFlow(Table):
    """The section, and what flows through it."""

    section: Literal["channel", "pipe"]
    """plane channel or round pipe"""
    radius: Length
    """of the pipe, or half the width of the channel"""
    gas_velocity: Annotated[float, *unit("m/s"), Field(gt=0)]
    """superficial, upward"""
    solids_mass_flux: Flux
    """of the particles, upward; 0: gas alone"""
    granular_temperature_centre: (
        Annotated[float, *unit("m**2/s**2"), Field(gt=0)] | None
    ) = None
    """granular temperature at the centre of the solution that is meant, where there are
    several"""
    gravity: Annotated[float, *unit("m/s**2"), Field(ge=0)] = 9.81
    """gravitational acceleration"""


class Closures(Table):
    """Closures by name."""

    drag: Named = "drag_wen_yu"
    """drag of the gas on the particles"""
    radial_distribution: str = "g0_sinclair_jackson"
    """radial distribution function at contact"""
    granular_pressure: str = "granular_pressure_lun"
    """granular pressure"""
    granular_viscosity: str = "granular_viscosity_gidaspow"
    """granular shear viscosity"""
    granular_conductivity: str = "granular_conductivity_syamlal"
    """granular conductivity, of fluctuation energy"""
    granular_dissipation: str = "granular_dissipation_lun"
    """dissipation of fluctuation energy by collisions"""
    granular_production: str | None = Field(
        None, json_schema_extra=takes("granular_production")
    )
    """of fluctuations by the slip, for fine particles: granular_production_koch;
    absent: none"""
    turbulence: str | None = Field(None, json_schema_extra=takes("eddy_viscosity"))
    """of the gas above Re 2300: eddy_viscosity_nikuradse; absent: the gas is laminar"""


class GasConstant(ConstantsAt, gases.GasConstant):
    """A gas or liquid with constant properties, given or those of a material at a
    temperature.
    """


class GasCantera(ConstantsAt, gases.GasCantera):
    """An ideal-gas mixture of a Cantera mechanism; its properties at one
    temperature.
    """


class GasCoolProp(ConstantsAt, gases.GasCoolProp):
    """A real fluid from CoolProp; its properties at one temperature."""


Gas = Annotated[
    GasConstant | GasCantera | GasCoolProp,
    Field(discriminator="model"),
    BeforeValidator(gases.with_its_model),
]


class Solid(SolidPhase):
    """Equal spheres."""

    diameter: Length
    """diameter of the particles"""
    density: Density
    """density of the solid material"""
    restitution: PositiveShare = 0.9
    """coefficient of restitution between particles"""
    packing_limit: Annotated[Number, Field(gt=0, lt=0.75)] = 0.63
    """densest fraction"""


class SolidAtWall(Table):
    """Particles that slip along the wall, after Johnson and Jackson."""

    wall: Literal["johnson_jackson"] = "johnson_jackson"
    """condition of the solids at the wall; johnson_jackson: partial slip"""
    specularity: PositiveShare
    """specularity coefficient of collisions with the wall"""
    restitution: PositiveShare = 0.9
    """coefficient of restitution between particles and wall"""


class Wall(Table):
    """Where the gas stands still and particles slip."""

    type: Literal["wall"] = "wall"
    """wall"""
    solids: Annotated[dict[str, SolidAtWall], AfterValidator(one_solid)]
    """data of the solid phases by name"""

    @property
    def solid(self) -> SolidAtWall:
        """The particles."""
        return next(iter(self.solids.values()))


class Boundary(Table):
    """The only boundary, the wall of the section."""

    wall: Wall


class Output(Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: Switch = True
    """draw plots (.png)"""
    fields: Switch = True
    """write fields for ParaView (.vtu)"""


class Solver(NewtonSolver):
    """Numerics."""

    cells: Whole = Field(60, ge=4, le=10000)
    """between centre and wall, finer toward the wall"""
    degree: Order = 3
    """polynomial degree of the fields"""
    newton_iterations: Whole = Field(60, ge=1, le=1000)
    """most iterations of Newton's method"""


class DevelopedScene(SceneBase):
    """Fully developed flow of gas and particles."""

    kind: ClassVar[str] = "developed_flow"
    time: ClassVar[None] = None

    developed_flow: DevelopedFlow
    gas: Gas
    solids: Annotated[dict[str, Solid], AfterValidator(one_solid)]
    """the solid phase, by its name"""
    closures: Closures = Closures()
    boundary: Boundary
    output: Output = Output()
    solver: Solver = Solver()

    @property
    def solid(self) -> Solid:
        """The only solid phase."""
        return next(iter(self.solids.values()))

    @property
    def fluid(self) -> Constants:
        """Constant properties of the gas."""
        return fluid_of(self.gas, self.origin.base)


def fluid_of(gas: Gas, base: Path) -> Constants:
    """Return the properties of the gas of a scene in the folder `base`, at its
    reference temperature if they vary.

    Raises
    ------
    SceneError : they vary, and no temperature is given
    """
    from contbed.materials.constants import constants_of

    return constants_of(gas, gas.reference_temperature, base)
