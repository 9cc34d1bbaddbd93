"""The tables of a scene of two fluids: gas and particles as two continua, transient, in
SI.

    [mesh]                    gravity points against its last axis, on a line against x
    [gas], [solids.NAME]      their properties; two fluids have one solid phase
    [closures]                by name
    [heat]                    temperatures are solved; absent: isothermal
    [radiation]               between the particles
    [boundary.NAME]           wall, symmetry, periodic, inlet, outlet
    [initial]                 fields at the start, with [[initial.layer]] along the last axis
    [time]                    how long, steps by the Courant number, averages
    [two_fluid]               gravity, granular temperature, guards

A closure that is "none" is absent and costs nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    model_validator,
)

from contbed.errors import SceneError
from contbed.scene import gas as gases
from contbed.scene import tables
from contbed.scene.mesh import Mesh
from contbed.scene.quantities import (
    Conductivity,
    Density,
    Emissivity,
    Fraction,
    HeatCapacity,
    Instant,
    Length,
    NonNegative,
    Number,
    Position,
    PositiveShare,
    Pressure,
    Seconds,
    Switch,
    Table,
    Temperature,
    form,
    takes,
    unit,
)
from contbed.scene.solids import SolidPhase, one_solid
from contbed.scene.tables import BalancedRun, NonNegativeOrClosure, SceneBase
from contbed.scene.units import to_si
from contbed.two_fluid.conditions import Boundary, Initial, Inlet, of_kind

if TYPE_CHECKING:
    from contbed.materials.constants import Constants

# [K] around the reference temperature of a real fluid that are tabulated
AROUND = 1.0
ROWS = 200  # in profiles.csv unless the scene says how often
Angle = Annotated[float, *unit("rad"), Field(gt=0, lt=1.5)]
Named = Annotated[tables.Named, Discriminator(form)]
NamedOrFile = Annotated[tables.NamedOrFile, Discriminator(form)]


class TwoFluid(Table):
    """What only two fluids have."""

    gravity: Annotated[float, *unit("m/s**2"), Field(ge=0)] = 9.81
    """gravitational acceleration"""
    granular_temperature: Literal["pde", "algebraic", "frozen"] = "pde"
    """transport equation, local balance, or the initial value kept"""
    guards: Switch = True
    """limit the kinetic stress of dilute flow by drag and free path"""
    free_path: Length = 0.01
    """largest mean free path that the guards allow"""
    conductivity_gas: Conductivity = 0.0
    """of the gas phase; its volume fraction of it conducts"""
    conductivity_solids: Conductivity = 0.0
    """of the solid phase; its volume fraction of it conducts"""


class Closures(Table):
    """Closures by name; "none": absent."""

    drag: Named = "drag_gidaspow"
    """drag of the gas on the particles"""
    radial_distribution: str = "g0_sinclair_jackson"
    """radial distribution function at contact"""
    granular_pressure: Named = "granular_pressure_lun"
    """"granular_pressure_dilute": without collisions"""
    granular_viscosity: Named = "granular_viscosity_gidaspow"
    """"none": particles without stress but pressure"""
    granular_bulk_viscosity: str = "granular_bulk_lun"
    """granular bulk viscosity"""
    granular_conductivity: str = "granular_conductivity_syamlal"
    """granular conductivity, of fluctuation energy"""
    granular_dissipation: str = "granular_dissipation_lun"
    """dissipation of fluctuation energy by collisions"""
    effective_restitution: Named = "none"
    """friction of particles in the dissipation, from its coefficient"""
    friction_pressure: str = "friction_johnson_jackson"
    """"none": no friction near packing"""
    friction_viscosity: str = "friction_viscosity_newtonian"
    """"none": friction pushes only"""
    wall_drag: str = "none"
    """"igci": factor of filtered drag near slip walls"""
    wall_pressure: str = "none"
    """the same of the filtered pressure of the particles"""
    wall_viscosity: str = "none"
    """the same of their filtered viscosity"""
    nusselt: NonNegativeOrClosure = "nusselt_gunn"
    """exchange, Nu = h diameter/gas.conductivity"""
    conductivity_bed: NamedOrFile | None = Field(
        None, json_schema_extra=takes("conductivity")
    )
    """of the bed at rest; the gas has (1 - sqrt(eps_s)) of gas.conductivity of it,
    particles the rest"""
    wall_heat: tables.WallCoefficientOrClosure = Field(
        "penetration", json_schema_extra=takes("bed_tube")
    )
    """between walls of a given temperature and the bed: a number in W/m2/K, a closure
    of it, or "penetration", conduction into the bed from the time of contact on any
    mesh; its parameter gap is the gas before the first particles over their diameter"""


class ConstantsAt(Table):
    """Temperature at which the properties of a gas that vary are taken as constants."""

    reference_temperature: Temperature | None = None
    """of the properties of the gas; absent: that at the start, or at the inlet"""


class GasLaw(ConstantsAt):
    """Density of a gas that is heated."""

    density_law: Literal["constant", "ideal_gas"] = "constant"
    """"ideal_gas": density is that at reference_temperature and pressure"""


class GasConstant(GasLaw, gases.GasConstant):
    """A gas or liquid with constant properties, given or those of a material at a
    temperature.
    """

    pressure: Pressure = 101325.0
    """outside of the outlet, or in a closed bed at the start"""


class GasCantera(GasLaw, gases.GasCantera):
    """An ideal-gas mixture of a Cantera mechanism; its properties at one
    temperature.
    """


class GasCoolProp(GasLaw, gases.GasCoolProp):
    """A real fluid from CoolProp; its properties at one temperature."""

    @model_validator(mode="before")
    @classmethod
    def _around_the_reference(cls, values: Any) -> Any:
        """Tabulate around the one temperature where no range is given."""
        given = (
            values.get("reference_temperature") if isinstance(values, dict) else None
        )
        if given is None or "T_range" in values:
            return values
        T = to_si(given, "K") if isinstance(given, str) else given
        return values | {"T_range": (T - AROUND, T + AROUND)}


Gas = Annotated[
    GasConstant | GasCantera | GasCoolProp,
    Field(discriminator="model"),
    BeforeValidator(gases.with_its_model),
]


class Friction(Table):
    """Of particles near packing."""

    start: Fraction = 0.5
    """fraction above which particles rub; a bed fluidizes near the porosity 1 - start
    """
    strength: Annotated[float, *unit("Pa"), Field(gt=0)] = 0.05
    """scale of the frictional pressure"""
    angle: Angle = 0.49742
    """angle of internal friction"""


class Solid(SolidPhase):
    """Equal spheres."""

    diameter: Length
    """diameter of the particles"""
    density: Density
    """density of the solid material"""
    heat_capacity: HeatCapacity | None = None
    """needed with a [heat] table"""
    conductivity: Conductivity | None = None
    """of a particle; for closures.conductivity_bed"""
    emissivity: Emissivity | None = None
    """of a particle; for [radiation], and for radiation to walls that have one"""
    restitution: PositiveShare = 0.9
    """coefficient of restitution between particles"""
    sliding_friction: NonNegative | None = None
    """Coulomb's coefficient of two particles, for closures.effective_restitution"""
    packing_limit: Annotated[Number, Field(gt=0, lt=0.75)] = 0.63
    """densest fraction"""
    friction: Friction = Friction()
    """frictional stress near packing"""


class Heat(Table):
    """Temperatures of gas and particles are solved; without this table they stay and
    nothing is computed.
    """


class Radiation(Table):
    """Gray radiation between the particles, a conductivity: P1 where the bed is many mean
    free paths thick.
    """

    correction: Literal["close_packed", "independent"] = "close_packed"
    """extinction over the voidage, or the limit of points far apart"""
    anisotropy: Annotated[Number, Field(ge=-1, le=1)] = 0.0
    """mean cosine of scattering"""


class Window(Table):
    """Where lateral profiles are averaged, along the last axis."""

    start: Position
    """lower end of the window"""
    end: Position
    """upper end of the window"""


class Time(Table):
    """The run and its averages."""

    end: Seconds
    """time at which the run ends"""
    courant: PositiveShare = 0.5
    """largest solids Courant number of a step"""
    step: Seconds | None = None
    """fixed, in place of the Courant number"""
    longest: Seconds = 1e-2
    """longest time step"""
    first: Seconds = 1e-5
    """first time step"""
    average_from: Instant | None = None
    """absent: no averages"""
    sample: Seconds | None = None
    """interval of rows in profiles.csv; absent: 1/200 of the run, or that of the run
    which a restart continues"""
    fields: Seconds | None = None
    """interval of fields, which are written at rows; absent: the end only"""
    checkpoint_every: Seconds = 10.0
    """wall-clock time between checkpoints"""

    @property
    def interval(self) -> float:
        """Interval of rows in profiles.csv [s]."""
        return self.sample or self.end / ROWS


class Output(Table):
    """What a run writes besides summary.json and profiles.csv."""

    plots: Switch = True
    """draw plots (.png)"""
    fields: Switch = True
    """write fields for ParaView (.vtu)"""
    window: Window | None = None
    """for lateral.csv; absent: the whole height"""
    levels: tuple[Position, ...] = ()
    """along the last axis, lateral profiles for levels.csv"""
    probes: dict[str, tuple[Position, ...]] = Field(default_factory=dict)
    """points, for profiles.csv"""


class TwoFluidScene(SceneBase):
    """Gas and particles as two fluids."""

    kind: ClassVar[str] = "two_fluid"

    mesh: Mesh
    two_fluid: TwoFluid = TwoFluid()
    gas: Gas
    solids: Annotated[dict[str, Solid], AfterValidator(one_solid)]
    """the solid phase, by its name"""
    closures: Closures = Closures()
    initial: Initial = Initial()
    boundary: dict[str, Boundary] = Field(default_factory=dict)
    """conditions by name of the boundary"""
    heat: Heat | None = None
    radiation: Radiation | None = None
    time: Time
    output: Output = Output()
    solver: BalancedRun = BalancedRun()

    @property
    def solid(self) -> Solid:
        """The only solid phase."""
        return next(iter(self.solids.values()))

    @property
    def fluid(self) -> Constants:
        """Constant properties of the gas."""
        return fluid_of(self.gas, self.initial, self.boundary, self.origin.base)


def fluid_of(
    gas: Gas, initial: Initial, boundary: Mapping[str, Boundary], base: Path
) -> Constants:
    """Return the constant properties of the gas.

    Those that vary are taken at gas.reference_temperature, else at the temperature at
    the start, else at that of the first inlet. `base` is the folder of the scene.

    Raises
    ------
    SceneError : no temperature is given, or it is out of the range of the properties
    """
    from contbed.materials.constants import constants_of

    inlets = of_kind(boundary, Inlet).values()
    entering = [part.gas.temperature for part in inlets]
    given = (gas.reference_temperature, initial.gas.temperature, *entering)
    T = next((T for T in given if T is not None), None)
    return constants_of(gas, T, base)


def known_fluid(
    gas: Gas, initial: Initial, boundary: Mapping[str, Boundary], base: Path
) -> Constants | None:
    """Return what `fluid_of` does; None where the properties are not known, which a
    check reports.
    """
    try:
        return fluid_of(gas, initial, boundary, base)
    except SceneError:
        return None
