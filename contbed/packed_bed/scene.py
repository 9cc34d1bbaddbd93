"""The vocabulary of a packed bed: every table and key, with unit, bounds and meaning,
as frozen pydantic models in SI.

    [mesh]             along the bed, or a plane, a volume, a file
    [gas]              constants, a material, a mixture of Cantera, a fluid of CoolProp; also a liquid
    [solids.NAME]      the particles; further ones with an emissivity only radiate
    [packed_bed]       porosity
    [closures]         resistance to flow, exchange, conductivities, dispersion
    [heat]             two energy equations, one for each phase; absent: the flow alone
    [boundary.NAME]    gas.KEY, solids.NAME.KEY, radiation; of the wall beside a line coefficient, ambient
    [initial], [time]  a transient run; absent: a steady state

A plain number is SI; a string may carry a unit ("3 mm", "100 degC") and is converted
here, at the door, so that nothing behind it ever sees a unit. A table that is absent
means that its physics is absent. Defaults live here only.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from contbed.radiation.scene import RadiatingSolid, Radiation, RadiationCondition, Tubes
from contbed.scene.boundary import ThermalCondition, WallHeat
from contbed.scene.gas import Gas
from contbed.scene.mesh import Mesh
from contbed.scene.property_table import (
    ConductivityOfSolid,
    HeatCapacityOfSolid,
    Melting,
)
from contbed.scene.quantities import (
    Conductivity,
    Fraction,
    HeatSource,
    NonNegative,
    Seconds,
    Switch,
    Table,
    Temperature,
    Whole,
    form,
    takes,
)
from contbed.scene.series import (
    TemperatureOrProfile,
    TemperatureOrSeries,
    VelocityOrSeries,
)
from contbed.scene.tables import (
    ConductivityOrClosure,
    FieldOutput,
    FieldSolver,
    Named,
    NonNegativeOrClosure,
    NumberOrClosure,
    PermeabilityOrClosure,
    RunInTime,
    SceneBase,
)


def dispersion_form(value: Any) -> str:
    """Return the `form` of a value; a table without a name holds the two
    conductivities themselves.
    """
    nameless = isinstance(value, Dispersion) or (
        isinstance(value, dict) and "name" not in value
    )
    return "table" if nameless else form(value)


class Dispersion(Table):
    """Constant dispersion conductivities, along and across the flow."""

    axial: Conductivity
    """thermal dispersion along the flow"""
    transverse: Conductivity = 0.0
    """thermal dispersion across the flow"""


DispersionOrClosure = Annotated[
    Annotated[Dispersion, Tag("table")] | Named, Discriminator(dispersion_form)
]


class Closures(Table):
    """Closures of the bed: a name, a name with parameters, a number, or a file."""

    permeability: PermeabilityOrClosure = "permeability_ergun"
    """permeability of the bed"""
    forchheimer: NonNegativeOrClosure = "forchheimer_ergun"
    """inertial drag coefficient c_F"""
    nusselt: NonNegativeOrClosure | None = None
    """exchange of heat between particles and gas; needed with a [heat] table"""
    conductivity_gas: ConductivityOrClosure = Field(
        "conductivity_phase", json_schema_extra=takes("conductivity")
    )
    """effective, without dispersion; conductivity_phase is eps k_gas; 0 where that of
    the solids is a closure of the whole bed"""
    conductivity_solids: ConductivityOrClosure = Field(
        "conductivity_phase", json_schema_extra=takes("conductivity")
    )
    """effective; conductivity_phase is (1-eps) k_solid"""
    tortuosity: NumberOrClosure | None = None
    """tortuosity parameter G of the cross conduction between the phases; absent means
    none"""
    dispersion: DispersionOrClosure | None = None
    """of heat in the gas; absent means none"""


class Heat(Table):
    """With this table temperatures are solved: two energy equations, one for each
    phase.
    """


class PackedBed(Table):
    """What only a packed bed has."""

    porosity: Fraction
    """share of the gas between particles in the volume of the bed"""
    reynolds: NonNegative | None = None
    """fixed Reynolds number for the closures instead of the one from velocities and
    properties"""
    relative_velocity: Literal["interstitial", "superficial"] = "interstitial"
    """velocity of the gas relative to particles that move, for drag and closures:
    interstitial: u - porosity u_s/(1 - porosity), 0 where both move together;
    superficial: u - u_s, after Pivem and de Lemos (2012)"""
    dead_state: Temperature = 298.15
    """temperature of the surroundings, at which a stream has no exergy"""


class Inside(Table):
    """Intraparticle conduction; absent: lumped particles, external film only."""

    heat: Literal["auto", "lumped", "effective", "interior"] = "auto"
    """one temperature per particle; one with the corrected film coefficient;
    temperatures inside; auto: the cheapest within solver.accuracy"""
    points: Annotated[Whole, Field(ge=2, le=20)] | None = None
    """temperatures inside, beside the surface; absent: 3, with auto the fewest within
    solver.accuracy"""


class Solid(RadiatingSolid):
    """A solid phase. One fills the bed; where there are several it is the one with a
    density.
    """

    heat_capacity: HeatCapacityOfSolid | None = None
    """needed with a [heat] table"""
    conductivity: ConductivityOfSolid | None = None
    """of the particles' material; needed with a [heat] table"""
    melting: Melting | None = None
    """absent: it does not melt"""
    shape: Literal["spheres", "rods"] = "spheres"
    """specific surface 6 (1-eps)/d for spheres, 4 (1-eps)/d for rods, whose pressure drop
    is that of six volumes over surface, 1.5 d"""
    inside: Inside | None = None
    """intraparticle conduction; absent: lumped particles"""


class PhaseCondition(ThermalCondition):
    """What one phase does at one boundary; without a thermal condition it is
    adiabatic.
    """

    velocity: VelocityOrSeries | None = None
    """superficial, mean over the boundary, into the bed; a list is a vector; one
    boundary gives it for the whole bed, absent: at rest; of one of several solids: its
    speed times 1 - porosity, so that its flow is volume_share times this"""

    @property
    def ties(self) -> bool:
        """Whether a steady temperature is determined by this condition; a heat flux
        alone leaves it open.
        """
        temperatures = (self.temperature, self.fixed_temperature)
        return self.meets_surroundings or any(T is not None for T in temperatures)

    @property
    def linear(self) -> bool:
        """Whether the heat that crosses the boundary is linear in the temperature,
        closures left aside.
        """
        return self.emissivity is None


def _slip(kind: str) -> str:
    """Return "slip" for a wall, which is frictionless unless it is said to be "no_slip",
    and for a plane of symmetry.
    """
    return "slip" if kind in ("wall", "symmetry") else kind


Side = Annotated[
    Literal["inlet", "outlet", "wall", "no_slip", "slip", "symmetry"],
    AfterValidator(_slip),
]


class Boundary(WallHeat):
    """Conditions on one named boundary; what is absent is adiabatic, and a
    frictionless wall for the flow. `coefficient`, `ambient` and `heat_flux` are those
    of the whole bed, whose phases share the heat in proportion to their conductivities;
    beside a line those of the gas.
    """

    type: Side | None = None
    """absent: inlet or outlet by the sign of the velocity, slip on walls"""
    temperature: TemperatureOrSeries | None = None
    """of a wall, which both phases take"""
    gas: PhaseCondition | None = None
    """conditions of the gas"""
    solids: dict[str, PhaseCondition] = Field(default_factory=dict)
    """of the solid that fills the bed"""
    radiation: RadiationCondition | None = None
    """absent: a mirror"""

    @model_validator(mode="before")
    @classmethod
    def _symmetry_is_adiabatic(cls, given: Any) -> Any:
        is_symmetry = isinstance(given, dict) and given.get("type") == "symmetry"
        if is_symmetry and {"temperature", "coefficient", "heat_flux"} & given.keys():
            raise ValueError('no heat passes a plane of symmetry; give type = "wall"')
        return given

    @model_validator(mode="after")
    def _heat_once(self) -> Boundary:
        if self.temperature is not None and self.passes_heat:
            raise ValueError("give temperature, coefficient or heat_flux")
        if self.whole and (self.gas is not None or self.solids):
            raise ValueError(
                "give heat through the wall here, for the whole bed, or in gas and "
                "solids.NAME, not in both"
            )
        return self

    @property
    def whole(self) -> bool:
        """Whether the thermal condition is that of the whole bed."""
        return self.passes_heat or self.temperature is not None

    def condition(self, phase: str) -> PhaseCondition | None:
        """Return the table of a phase, "fluid" or "solid"; None if there is none."""
        if self.whole:
            keys = ("coefficient", "ambient", "heat_flux")
            given = {key: getattr(self, key) for key in keys}
            return PhaseCondition.model_construct(
                fixed_temperature=self.temperature, **given
            )
        if phase == "fluid":
            return self.gas
        return next(iter(self.solids.values()), None)

    def thermal(self, phase: str) -> PhaseCondition | None:
        """Return the thermal condition of a phase, "fluid" or "solid"; None if it is
        adiabatic.
        """
        found = self.condition(phase)
        return found if found is not None and found.exchanges_heat else None

    @property
    def heated(self) -> bool:
        """Whether one of the phases has a thermal condition here."""
        return self.thermal("fluid") is not None or self.thermal("solid") is not None

    def key(self, phase: str) -> tuple[str, ...]:
        """Return the key of the table of a phase, "fluid" or "solid", below that of
        the boundary.
        """
        if self.whole:
            return ()
        return ("gas",) if phase == "fluid" else ("solids", *list(self.solids)[:1])


class Release(Table):
    """Heat that one phase releases."""

    heat_source: HeatSource = 0.0
    """per volume of the bed"""


class Region(Table):
    """Heat sources in one named region of the mesh, and tubes."""

    gas: Release = Release()
    """heat that the gas releases"""
    solids: Release = Release()
    """heat that the solids release"""
    tubes: Tubes | None = None
    """absorb and emit radiation; with [heat] and [radiation]"""

    def heat_source(self, phase: str) -> float:
        """Return the heat source of a phase, "fluid" or "solid", per volume of the
        bed [W/m3].
        """
        return (self.gas if phase == "fluid" else self.solids).heat_source


class InitialState(Table):
    """State of one phase at the start."""

    temperature: TemperatureOrProfile
    """a number, or a profile from a file"""


class Initial(Table):
    """The state at the start of a transient run."""

    temperature: Temperature | None = None
    """of everything; each phase may have its own"""
    gas: InitialState | None = None
    """initial state of the gas"""
    solids: dict[str, InitialState] = Field(default_factory=dict)
    """initial state of the solid by name"""

    def given(self, phase: str) -> Any:
        """Return the temperature of a phase, "fluid" or "solid", at the start: a
        number, a profile, or None.
        """
        table = self.gas if phase == "fluid" else next(iter(self.solids.values()), None)
        return self.temperature if table is None else table.temperature

    def key(self, phase: str) -> tuple[str, ...]:
        """Return the key of the temperature of a phase, "fluid" or "solid"."""
        if phase == "fluid":
            return (
                ("initial", "gas", "temperature")
                if self.gas is not None
                else ("initial", "temperature")
            )
        name = next(iter(self.solids), None)
        return (
            ("initial", "temperature")
            if name is None
            else ("initial", "solids", name, "temperature")
        )


class Time(RunInTime):
    """A transient run; absent means steady."""

    step: Seconds | None = None
    """fixed step; error-controlled if absent"""
    tolerance: Fraction = 1e-4
    """local error over the span of temperatures"""


class Solver(FieldSolver):
    """Numerics; the defaults suit nearly all scenes."""

    stabilisation: Switch = True
    """residual-based SUPG"""
    accuracy: Fraction = 5e-3
    """largest predicted error of the level of intraparticle conduction that the plan
    takes, over the temperature span"""
    adapt: Annotated[Whole, Field(ge=0, le=10)] | None = None
    """refinements where the error estimate of a steady run exceeds `tolerance`; absent:
    automatic"""
    reduce: Switch = True
    """solve a plug-flow scene with adiabatic walls in one dimension"""


def that_fill_the_bed(solids: Mapping[str, Solid]) -> dict[str, Solid]:
    """Return the solids that may fill a bed: the only one, of several those with a
    density.
    """
    return (
        dict(solids)
        if len(solids) < 2
        else {name: each for name, each in solids.items() if each.density}
    )


def _absent() -> Any:
    return None


class Scene(SceneBase):
    """One run of a packed or moving bed."""

    kind: ClassVar[str] = "packed_bed"

    mesh: Mesh
    # gas and packed_bed are None only in a medium that merely radiates; `checks` sees
    # to it
    gas: Gas = Field(default_factory=_absent)
    solids: dict[str, Solid] = Field(default_factory=dict)
    """solid phases by name"""
    packed_bed: PackedBed = Field(default_factory=_absent)
    closures: Closures = Closures()
    heat: Heat | None = None
    radiation: Radiation | None = None
    boundary: dict[str, Boundary] = Field(default_factory=dict)
    """conditions by name of the boundary; an absent boundary is adiabatic and without
    friction"""
    region: dict[str, Region] = Field(default_factory=dict)
    """heat sources and tubes by name of the region of the mesh"""
    initial: Initial = Initial()
    time: Time | None = None
    solver: Solver = Solver()
    output: FieldOutput = FieldOutput()

    @property
    def solid(self) -> Solid:
        """The particles that fill the bed."""
        return next(iter(that_fill_the_bed(self.solids).values()))

    @property
    def diameter(self) -> float:
        """Diameter of the particles that fill the bed [m]."""
        return self.solid.diameter

    def with_inside(self, inside: Inside | None) -> Scene:
        """Return the scene with other intraparticle conduction in the solid that
        fills the bed.
        """
        name = next(iter(that_fill_the_bed(self.solids)))
        solid = self.solids[name].model_copy(update={"inside": inside})
        return self.model_copy(update={"solids": {**self.solids, name: solid}})
