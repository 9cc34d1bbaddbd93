"""The vocabulary of a packed or moving bed with species along one line: every table and
key.

    [mesh]             along the bed; diameter of a tube
    [gas]              the mixture that enters: a mechanism of Cantera, or species with data; closures need properties
    [solids.NAME]      each solid phase: size, constituents where it reacts, adsorption, the inside of its particles
    [reactions.NAME]   a rate law by name with its constants, or a formula
    [packed_bed]       porosity, pressure drop, storage of gas in time, the section across the flow
    [closures]         exchange, films, conductivities, dispersion, resistance to flow
    [heat]             temperatures are solved; absent: the bed is isothermal
    [boundary.NAME]    left and right: streams that enter; wall: heat through it
    [initial], [time]  a transient run; absent: a steady state, whose first guess `initial` may give
    [continuation]     steady states along a branch

A plain number is SI, amounts in mol; a string may carry a unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from contbed.reacting_bed.boundary_scene import FLOWS as FLOWS
from contbed.reacting_bed.boundary_scene import Boundary as Boundary
from contbed.reacting_bed.boundary_scene import GasCondition as GasCondition
from contbed.reacting_bed.boundary_scene import SolidCondition as SolidCondition
from contbed.reacting_bed.solids_scene import Adsorption as Adsorption
from contbed.reacting_bed.solids_scene import Inside as Inside
from contbed.reacting_bed.solids_scene import Solid as Solid
from contbed.scene import continuation
from contbed.scene.humid_air import HumidAir
from contbed.scene.mesh import MeshLine
from contbed.scene.quantities import (
    Composition,
    Conductivity,
    Fraction,
    Instant,
    Number,
    Pressure,
    Table,
    Temperature,
    Viscosity,
    Whole,
    form,
    takes,
    unit,
)
from contbed.scene.reactions import PositiveDiffusivity as PositiveDiffusivity
from contbed.scene.reactions import Reaction as Reaction
from contbed.scene.reactions import Substance as Substance
from contbed.scene.tables import (
    ConductivityOrClosure,
    NewtonSolver,
    NonNegativeOrClosure,
    OrClosure,
    Output,
    PermeabilityOrClosure,
    RunInTime,
    SceneBase,
)

Diffusivity = Annotated[float, *unit("m**2/s"), Field(ge=0)]
DiffusivityOrName = Annotated[
    Annotated[PositiveDiffusivity, Tag("number")]
    | Annotated[Literal["cantera", "fuller"], Tag("name")],
    Discriminator(form),
]
DispersionOfMass = OrClosure[Diffusivity]

MASS_DISPERSION = takes("mass_dispersion")
CONDUCTIVITY = takes("conductivity")


class Mixture(HumidAir):
    """The gas, an ideal mixture, and properties of its species."""

    composition: Composition | None = None
    """mole fractions that enter, "CH4:0.975, CO2:0.025", where a boundary gives no
    others"""
    pressure: Pressure = 101325.0
    """where the gas enters"""
    viscosity: Viscosity | None = None
    """of the mixture, constant"""
    conductivity: Conductivity | None = None
    """of the mixture, constant"""
    diffusivity: DiffusivityOrName | None = None
    """of every species; "fuller" by its equation, "cantera" by the mechanism"""
    viscosity_rule: Literal["wilke", "herning_zipperer"] = "wilke"
    """mixing rule for the viscosity of the gas"""
    species: dict[str, Substance] = Field(default_factory=dict)
    """data of species by name"""


class GasCantera(Mixture):
    """Species with the thermodynamics and transport data of a Cantera mechanism."""

    model: Literal["cantera"]
    """ideal gas mixture with properties by Cantera"""
    mechanism: str = "gri30.yaml"
    """Cantera mechanism with the species: a name or a YAML file"""


class GasIdeal(Mixture):
    """Species whose data stand in [gas.species.NAME]."""

    model: Literal["ideal_gas"]
    """ideal gas whose species have the data of the scene"""


Gas = Annotated[GasCantera | GasIdeal, Field(discriminator="model")]


class Section(Table):
    """The bed resolved across the flow, from the axis to the wall at half of
    mesh.diameter; absent: one dimension.
    """

    shape: Literal["tube", "plane", "duct"] = "tube"
    """round, between two plane walls at the distance mesh.diameter, or square with it
    as side"""
    rings: Annotated[Whole, Field(ge=2, le=40)] = 8
    """of equal width, of a duct columns along each half of the side; the error across
    the flow is of second order, `estimated_error_section` in steady runs"""
    conductivity_gas: ConductivityOrClosure | None = Field(
        None, json_schema_extra=CONDUCTIVITY
    )
    """effective, radial; absent: none"""
    conductivity_solids: ConductivityOrClosure | None = Field(
        None, json_schema_extra=CONDUCTIVITY
    )
    """effective, radial, of the particles or of the whole bed at one temperature;
    absent: none"""
    dispersion: ConductivityOrClosure | None = None
    """transverse closure, or W/m/K; absent: none"""
    dispersion_mass: DispersionOfMass | None = Field(
        None, json_schema_extra=MASS_DISPERSION
    )
    """of species across the flow, by name or in m2/s on the velocity between the
    particles; { name = "mass_dispersion_peclet", Pe_p = 10 } is usual across beds of
    spheres; absent: none"""


class PackedBed(Table):
    """What only a packed bed has."""

    porosity: Fraction
    """of the bed: share of the volume between the particles"""
    pressure_drop: Literal["auto", "ergun", "none"] = "auto"
    """by closures.permeability and closures.forchheimer; auto leaves it out below 0.1 %
    """
    gas_storage: Literal["auto", "quasi_steady", "stored"] = "auto"
    """in time, in the gas between particles; auto leaves it out where its residence
    time is below 1 % of the times in which streams change and of the run; changes
    within 1 % of that time count as one"""
    section: Section | None = None
    """the bed resolved across the flow"""


class Closures(Table):
    """Closures of the bed: a name, a name with parameters, a number, or a file."""

    permeability: PermeabilityOrClosure = "permeability_ergun"
    """permeability of the bed"""
    forchheimer: NonNegativeOrClosure = "forchheimer_ergun"
    """Forchheimer coefficient of the bed"""
    nusselt: NonNegativeOrClosure | None = None
    """exchange of heat between particles and gas; absent: both at one temperature"""
    sherwood: NonNegativeOrClosure | None = None
    """of the film around particles; absent: no film, which adsorption needs"""
    conductivity_gas: ConductivityOrClosure | None = Field(
        None, json_schema_extra=CONDUCTIVITY
    )
    """effective, axial; absent: none"""
    conductivity_solids: ConductivityOrClosure | None = Field(
        None, json_schema_extra=CONDUCTIVITY
    )
    """effective, axial, of the particles or of the whole bed at one temperature;
    absent: none"""
    dispersion: ConductivityOrClosure | None = None
    """of heat, axial closure, or W/m/K; absent: none"""
    dispersion_mass: DispersionOfMass | None = Field(
        None, json_schema_extra=MASS_DISPERSION
    )
    """of species, axial, by name or in m2/s on the velocity between the particles;
    absent: none"""


def film_of(
    closures: Closures, solid: Solid, key: Literal["nusselt", "sherwood"]
) -> Any:
    """Return the closure of the film around the particles of a phase: its own, or that
    of all phases; None if it has no film.
    """
    own = getattr(solid, key)
    return getattr(closures, key) if own is None else own


def films_of_heat(closures: Closures, solids: Mapping[str, Solid]) -> bool:
    """Whether the particles of all phases exchange heat with the gas."""
    return all(
        film_of(closures, each, "nusselt") is not None for each in solids.values()
    )


class Heat(Table):
    """With this table temperatures are solved: two with closures.nusselt or those of
    all solids, else one of gas and particles.
    """


class InitialSolid(Table):
    """A solid phase at the start."""

    temperature: Temperature
    """in place of initial.temperature, where phases have their own"""


class InitialGas(Table):
    """The gas in the bed at the start."""

    temperature: Temperature | None = None
    """in place of initial.temperature, where phases have their own"""
    composition: Composition | None = None
    """where it is stored; absent: of the gas that enters"""


class Initial(Table):
    """The state at the start of a transient run, one along the bed or from a file;
    the first guess of a steady one.
    """

    temperature: Temperature | None = None
    """of gas and particles; absent: of the gas that enters, as a guess that of mixed
    streams"""
    gas: InitialGas = InitialGas()
    """the gas in the bed at the start"""
    solids: dict[str, InitialSolid] = Field(default_factory=dict)
    """solid phases at the start, by name"""
    file: str | None = None
    """CSV file with positions, x [m], and any of T_fluid, T_solid [K], x_GAS [1],
    n_SOLID [mol/m3] or w_SOLID [1], q_GAS [mol/kg], relative to the scene; the rest is
    uniform"""
    time: Instant | None = None
    """of the rows of the file, where it has several; absent: the last"""

    @property
    def gas_temperature(self) -> float | None:
        """Temperature of the gas [K]; None where the scene gives none."""
        return (
            self.temperature if self.gas.temperature is None else self.gas.temperature
        )

    @property
    def temperatures(self) -> dict[tuple[str, ...], float]:
        """All temperatures [K] by key."""
        given = {
            ("initial", "temperature"): self.temperature,
            ("initial", "gas", "temperature"): self.gas.temperature,
        }
        for name, table in self.solids.items():
            given["initial", "solids", name, "temperature"] = table.temperature
        return {key: T for key, T in given.items() if T is not None}


class Continuation(continuation.Continuation):
    """The branch of steady states from the value in this scene to another, through
    the folds between them.
    """

    at: Number | None = None
    """value at which all steady states of the branch are listed"""


class Time(RunInTime):
    """A transient run; absent means steady."""

    tolerance: Fraction = 1e-4
    """local error over typical sizes of the fields, of an order below; that of a trace
    gas is ten times its largest fraction"""


class Solver(NewtonSolver):
    """Numerics; the defaults suit nearly all scenes."""

    degree: Annotated[Whole | None, Field(ge=0, le=5)] = None
    """degree of the polynomials in a cell; absent: 3, and 0, one value a cell, where
    nearly all that enters is adsorbed and fills the pores, and where a run in time
    would take far too many steps, as its fronts are shorter than a cell"""
    tolerance: Fraction = 1e-6
    """target error of all fields for automatic cells, over their spans, in time over
    typical sizes"""
    accuracy: Fraction = 5e-3
    """largest predicted error, over the step of what leaves, of a level that the plan
    takes"""
    adapt: Annotated[Whole, Field(ge=0, le=20)] | None = None
    """rounds of new cells, absent: 10; in time of each step, so that cells follow its
    fronts, absent: cells stay as they are"""
    newton_iterations: Whole = Field(40, ge=1, le=1000)
    """most iterations of Newton's method"""


class ReactingScene(SceneBase):
    """One run of a packed or moving bed with species."""

    kind: ClassVar[str] = "reacting_bed"
    refused: ClassVar[Mapping[str, str]] = {
        "gas.model": "species, reactions, adsorption and several solids take an ideal "
        "gas; liquids and constant properties are for a bed of one solid without them",
        "radiation": "a bed with species takes radiation by its conductivity, such as "
        'closures.conductivity_solids = { name = "zehner_bauer_schluender", '
        "emissivity = 0.8 }",
    }

    mesh: MeshLine
    gas: Gas
    solids: dict[str, Solid] = Field(min_length=1)
    """solid phases that fill the bed, by name"""
    packed_bed: PackedBed
    closures: Closures = Closures()
    heat: Heat | None = None
    reactions: dict[str, Reaction] = Field(default_factory=dict)
    """reactions by name"""
    boundary: dict[str, Boundary] = Field(default_factory=dict)
    """`left`, `right` and `wall`"""
    initial: Initial = Initial()
    continuation: Continuation | None = None
    time: Time | None = None
    solver: Solver = Solver()
    output: Output = Output()

    @property
    def wall(self) -> Boundary | None:
        """The wall of a tube; None where nothing passes it."""
        return self.boundary.get("wall")

    @property
    def section(self) -> Section | None:
        """The section across the flow; None in one dimension."""
        return self.packed_bed.section

    @property
    def two_temperatures(self) -> bool:
        """Whether gas and particles have temperatures of their own."""
        return self.heat is not None and films_of_heat(self.closures, self.solids)

    @property
    def adsorbs(self) -> bool:
        """Whether particles take up gas."""
        return any(table.adsorption for table in self.solids.values())

    def with_table(self, name: str, **update: Any) -> ReactingScene:
        """Return the scene with keys of a table replaced."""
        return self.model_copy(
            update={name: getattr(self, name).model_copy(update=update)}
        )
