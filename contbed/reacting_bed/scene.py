"""The vocabulary of a reacting bed: the tables of a packed bed, and species, constituents of solids, reactions.

A plain number is SI, amounts in mol; a string may carry a unit. A table that is absent means that its physics is
absent: without [heat] the bed is isothermal, without [mass] gas is neither dispersed nor held back by films.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from contbed.reacting_bed.inlet_series import (
    CompositionOrSeries,
    MassFluxOrSeries,
    MolarFluxOrSeries,
    SpeedOrSeries,
)
from contbed.reacting_bed.solids_scene import Adsorption as Adsorption
from contbed.reacting_bed.solids_scene import Curve as Curve
from contbed.reacting_bed.solids_scene import MolarEnergy as MolarEnergy
from contbed.reacting_bed.solids_scene import PositiveDiffusivity as PositiveDiffusivity
from contbed.reacting_bed.solids_scene import SolidKind as SolidKind
from contbed.reacting_bed.solids_scene import Solids as Solids
from contbed.reacting_bed.solids_scene import Substance as Substance
from contbed.scene.mesh import MeshLine
from contbed.scene.quantities import (
    Conductivity,
    FiniteFloat,
    Fraction,
    Instant,
    Length,
    Number,
    Positive,
    Pressure,
    Seconds,
    Switch,
    Table,
    Temperature,
    Viscosity,
    Whole,
    form,
    given_one,
    takes,
    unit,
)
from contbed.scene.series import HeatFluxOrSeries, TemperatureOrSeries
from contbed.scene.tables import (
    ConductivityOrClosure,
    CycleSettings,
    NamedOrFile,
    NonNegativeOrClosure,
    Output,
    Packing,
    PermeabilityOrClosure,
    SceneBase,
    WallCoefficientOrClosure,
)

ONLY = "particles"  # name of the only solid phase

ActivationEnergy = Annotated[MolarEnergy, Field(ge=0)]
Diffusivity = Annotated[float, *unit("m**2/s"), Field(ge=0)]
DiffusivityOrName = Annotated[
    Annotated[PositiveDiffusivity, Tag("number")] | Annotated[Literal["cantera", "fuller"], Tag("name")],
    Discriminator(form),
]
DispersionOfMass = Annotated[Annotated[Diffusivity, Tag("number")] | NamedOrFile, Discriminator(form)]


class Gas(Table):
    """The gas that enters, an ideal gas, and properties of its species."""

    composition: CompositionOrSeries = Field(description='mole fractions that enter, "CH4:0.975, CO2:0.025"')
    pressure: Pressure = Field(101325.0, description="where the gas enters")
    viscosity: Viscosity | None = Field(None, description="of the mixture, constant")
    conductivity: Conductivity | None = Field(None, description="of the mixture, constant")
    diffusivity: DiffusivityOrName | None = Field(
        None, description='of every species; "fuller" by its equation, "cantera" by the mechanism'
    )
    viscosity_rule: Literal["wilke", "herning_zipperer"] = Field(
        "wilke", description="mixing rule for the viscosity of the gas"
    )
    species: dict[str, Substance] = Field(default_factory=dict, description="data of species by name")


class GasCantera(Gas):
    """Species with the thermodynamics and transport data of a Cantera mechanism."""

    model: Literal["cantera"] = Field(description="ideal gas mixture with properties by Cantera")
    mechanism: str = Field("gri30.yaml", description="Cantera mechanism with the species: a name or a YAML file")


class GasIdeal(Gas):
    """Species whose data stand in [fluid.species.NAME]."""

    model: Literal["ideal_gas"] = Field(description="ideal gas whose species have the data of the scene")


Fluid = Annotated[GasCantera | GasIdeal, Field(discriminator="model")]


class Bed(Packing):
    """The packing and its resistance to flow."""

    particle_diameter: Length | None = Field(  # type: ignore[assignment]
        None,
        description="of one kind; absent with [solids.NAME], which have theirs: their Sauter mean resists the flow",
    )
    permeability: PermeabilityOrClosure = Field("permeability_ergun", description="permeability of the bed")
    forchheimer: NonNegativeOrClosure = Field("forchheimer_ergun", description="Forchheimer coefficient of the bed")

    @property
    def diameter(self) -> float:
        """Diameter of the particles, of several kinds the Sauter mean [m]."""
        assert self.particle_diameter is not None  # `checks` and `kinds` see to it
        return self.particle_diameter


class Flow(Table):
    """Streams along x per area of the bed, negative from right to left; give one of the three for the gas."""

    mass_flux: MassFluxOrSeries | None = Field(None, description="of the gas that enters")
    molar_flux: MolarFluxOrSeries | None = Field(None, description="of the gas that enters")
    velocity: SpeedOrSeries | None = Field(None, description="superficial, of the gas that enters, at its temperature")
    velocity_solid: SpeedOrSeries = Field(0.0, description="superficial: volume of particles per area and time")
    pressure_drop: Literal["auto", "ergun", "none"] = Field(
        "auto", description="by bed.permeability and bed.forchheimer; auto leaves it out where it is below 0.1 %"
    )

    @model_validator(mode="after")
    def _exactly_one(self) -> Flow:
        given_one(self, "mass_flux", "molar_flux", "velocity")
        return self


class Heat(Table):
    """Energy of the bed: two temperatures with exchange, or one where `nusselt` is absent."""

    nusselt: NonNegativeOrClosure | None = Field(None, description="absent: gas and particles at one temperature")
    conductivity_fluid: ConductivityOrClosure | None = Field(
        None, description="effective, axial; absent: none", json_schema_extra=takes("conductivity")
    )
    conductivity_solid: ConductivityOrClosure | None = Field(
        None,
        description="effective, axial, of the particles or of the whole bed at one temperature; absent: none",
        json_schema_extra=takes("conductivity"),
    )
    dispersion: ConductivityOrClosure | None = Field(None, description="axial closure, or W/m/K; absent: none")


class Mass(Table):
    """Film and dispersion of species."""

    sherwood: NonNegativeOrClosure | None = Field(None, description="of the film around particles; absent: no film")
    dispersion: DispersionOfMass | None = Field(
        None,
        description="axial, by name or in m2/s on the velocity between the particles; absent: none",
        json_schema_extra=takes("mass_dispersion"),
    )


class Wall(Table):
    """Heat through the wall of a tube, into the gas (two temperatures) or the bed (one)."""

    diameter: Length = Field(description="inner diameter of the tube")
    coefficient: WallCoefficientOrClosure | None = Field(
        None, description="on the inner area, to `ambient`; by name with [section]", json_schema_extra=takes("wall")
    )
    ambient: TemperatureOrSeries | None = Field(None, description="temperature of the surroundings")
    flux: HeatFluxOrSeries | None = Field(None, description="into the bed, on the inner area")

    @model_validator(mode="after")
    def _one_way(self) -> Wall:
        if (self.coefficient is None) == (self.flux is None):
            raise ValueError("give coefficient and ambient, or flux")
        if (self.coefficient is None) != (self.ambient is None):
            raise ValueError("coefficient and ambient belong together")
        return self


class Section(Table):
    """The bed resolved across the flow, from the axis to the wall at half of wall.diameter; absent: one dimension."""

    shape: Literal["tube", "plane", "duct"] = Field(
        "tube", description="round, between two plane walls at the distance wall.diameter, or square with it as side"
    )
    rings: Annotated[Whole, Field(ge=2, le=40)] = Field(
        8,
        description="of equal width, of a duct columns along each half of the side; the error across the flow is of "
        "second order",
    )
    conductivity_fluid: ConductivityOrClosure | None = Field(
        None, description="effective, radial; absent: none", json_schema_extra=takes("conductivity")
    )
    conductivity_solid: ConductivityOrClosure | None = Field(
        None,
        description="effective, radial, of the particles or of the whole bed at one temperature; absent: none",
        json_schema_extra=takes("conductivity"),
    )
    dispersion: ConductivityOrClosure | None = Field(None, description="transverse closure, or W/m/K; absent: none")
    mass_dispersion: DispersionOfMass | None = Field(
        None,
        description="of species across the flow, by name or in m2/s on the velocity between the particles; "
        '{ name = "mass_dispersion_peclet", Pe_p = 10 } is usual across beds of spheres; absent: none',
    )


class Inlet(Table):
    """Temperature of a stream that enters."""

    inflow: TemperatureOrSeries | None = Field(
        None, description="Danckwerts: what enters is known, not the state inside"
    )
    fixed: TemperatureOrSeries | None = Field(None, description="state inside of the inlet, composition included")

    @model_validator(mode="after")
    def _one(self) -> Inlet:
        if (self.inflow is None) == (self.fixed is None):
            raise ValueError("give inflow or fixed")
        return self


class Boundary(Table):
    """What enters at one end of the bed."""

    fluid: Inlet | None = Field(None, description="what the gas enters with")
    solid: Inlet | None = Field(None, description="what the solids enter with")


def text_or_number(value: Any) -> str:
    """Return the `form` of a value in any unit, which is a text, or in SI."""
    return "name" if isinstance(value, str) else form(value)


Parameter = Annotated[
    Annotated[FiniteFloat, Tag("number")] | Annotated[str, Tag("name")], Discriminator(text_or_number)
]


KindOrKinds = Annotated[Annotated[str, Tag("name")] | Annotated[tuple[str, ...], Tag("list")], Discriminator(form)]


class Reaction(Table):
    """One reaction: a rate law by name with its constants, or a formula."""

    equation: str | None = Field(None, description='"CH4 + 12 Fe2O3 -> 8 Fe3O4 + CO2 + 2 H2O"; <-> if reversible')
    law: str | None = Field(None, description="power, grain, grain_remaining, shrinking_core, or a law with a name")
    rate: str | None = Field(None, description="formula instead, of T, p_X, c_X, x_X, n_X, X, R and parameters")
    unit: str | None = Field(None, description="of the formula, such as kmol/kg/h; absent: SI of the basis")
    parameters: dict[str, Parameter] = Field(default_factory=dict, description='of the formula, {E = "49 kJ/mol"}')
    A: Annotated[Number, Field(ge=0)] | None = Field(None, description="of k = A T^b exp(-E/(R T)), in mol, m and s")
    b: Number = Field(0.0, description="exponent of the temperature in k = A T^b exp(-E/(R T))")
    E: ActivationEnergy | None = Field(None, description="activation energy")
    orders: dict[str, Number] | None = Field(None, description="in concentrations; absent: 1 for each reactant gas")
    solid: KindOrKinds | None = Field(
        None, description="kind, or list of kinds, of [solids] in which it runs; absent: those that hold what reacts"
    )
    basis: Literal["gas", "catalyst", "particle", "bed"] | None = Field(
        None, description="rate per m3 of gas, kg of catalyst, m3 of particles or of bed; absent: gas, or particle"
    )
    factor: Positive = Field(1.0, description="multiplies the rate, such as an effectiveness")
    equilibrium_factor: Positive = Field(
        1.0, description="multiplies K of a reversible reaction, which comes from the thermodynamics of its species"
    )
    grain_radius: Length | None = Field(None, description="radius of the grains in the particles")
    molar_density: Positive | None = Field(None, description="of the reacting solid in a grain [mol/m3]")
    active_share: Positive = Field(1.0, description="share of the surface of grains that reacts")
    diffusivity: PositiveDiffusivity | None = Field(None, description="effective, in the product layer or particle")


class Particle(Table):
    """What happens inside of a particle."""

    mass: Literal["auto", "none", "effectiveness", "interior"] = Field(
        "auto",
        description="effectiveness of a sphere by the Thiele modulus of each reaction with a diffusivity; interior: "
        "diffusion and reaction of all gases resolved in the particles, with particle.diffusivity; auto: "
        "resolved where that changes what reacts by more than solver.accuracy",
    )
    diffusivity: dict[str, PositiveDiffusivity] = Field(
        default_factory=dict,
        description='effective, of each gas that reacts in particles, { CH4 = "2e-6 m**2/s" }; of several kinds each '
        "has its own",
    )
    adsorption: Literal["auto", "film", "linear_driving_force", "interior"] = Field(
        "auto",
        description="resistance to the uptake of gas: external film only; in series with it diffusion inside, by one "
        "concentration per particle; diffusion between points inside. auto: the cheapest whose error in what "
        "leaves is within solver.accuracy",
    )
    points: Annotated[Whole, Field(ge=2, le=20)] = Field(3, description="inside of a particle, beside its surface")


class Guess(Table):
    """First guess of a steady state, where several exist or none is found from the streams that enter."""

    temperature: Temperature | None = Field(None, description="of gas and particles; absent: of the stronger stream")


class Continuation(Table):
    """The branch of steady states from the value in this scene to another, through the folds between them."""

    parameter: str = Field(description='key of a number in this scene, "reactions.NAME.factor" or "flow.mass_flux"')
    to: Number = Field(description="in SI")
    back_to: Number | None = Field(None, description="end of the other side; absent: the value in this scene")
    at: Number | None = Field(None, description="value at which all steady states of the branch are listed")
    points: Annotated[Whole, Field(ge=3, le=10_000)] = Field(400, description="at most")


class InitialState(Table):
    """The state at the start from a CSV file, such as the profiles.csv of an earlier run."""

    file: str = Field(
        description="CSV file with positions, x [m], and any of T_fluid, T_solid [K], x_GAS [1], n_SOLID [mol/m3] or "
        "w_SOLID [1], q_GAS [mol/kg], relative to the scene; the rest is uniform"
    )
    time: Instant | None = Field(None, description="of the rows, where the file has several; absent: the last")


class Time(Table):
    """A transient run; absent means steady."""

    end: Seconds = Field(description="time at which the run ends")
    times: tuple[Instant, ...] = Field((), description="output times; the end is always one")
    initial: InitialState | None = Field(
        None, description="profiles at the start; absent, and what they do not say: one state along the bed"
    )
    initial_temperature: Temperature | None = Field(
        None, description="of gas and particles at the start; absent: that of the gas that enters"
    )
    initial_composition: str | None = Field(
        None, description="of the gas in the bed at the start, where it is stored; absent: of the gas that enters"
    )
    gas: Literal["auto", "quasi_steady", "stored"] = Field(
        "auto",
        description="storage in the gas between particles; auto leaves it out where its residence time is below 1 % of "
        "the times in which streams change and of the run; changes within 1 % of that time count as one",
    )
    tolerance: Fraction = Field(1e-4, description="local error over typical sizes of the fields, of an order below")
    cycle: CycleSettings | None = Field(
        None, description="the run is one period of a cyclic steady state; the state at the start is a guess"
    )
    checkpoint_every: Seconds = Field(10.0, description="wall-clock time between checkpoints")


class Solver(Table):
    """Numerics; the defaults suit nearly all scenes."""

    degree: Annotated[Whole, Field(ge=1, le=5)] = Field(3, description="degree of the polynomials in a cell")
    tolerance: Fraction = Field(
        1e-6, description="target error of all fields for automatic cells, over their spans, in time over typical sizes"
    )
    accuracy: Fraction = Field(
        5e-3, description="largest predicted error, over the step of what leaves, of a level that the plan takes"
    )
    adapt: Annotated[Whole, Field(ge=0, le=20)] | None = Field(
        None,
        description="rounds of new cells, absent: 10; in time of each step, so that cells follow its fronts, absent: "
        "cells stay as they are",
    )
    newton_tolerance: Annotated[Fraction, Field(le=1e-3)] = Field(
        1e-10,
        description="residual norm, relative to the scale of the equations, at which Newton's method has converged",
    )
    newton_iterations: Whole = Field(40, ge=1, le=1000, description="most iterations of Newton's method")
    balance_tolerance: Positive = Field(1e-10, description="largest relative residual of a balance that a run accepts")
    strict: Switch = Field(False, description="a closure out of its range is an error")


class ReactingScene(SceneBase):
    """One run of a reacting packed or moving bed."""

    kind: ClassVar[str] = "reacting_bed"
    renamed: ClassVar[Mapping[str, str]] = {}

    mesh: MeshLine
    fluid: Fluid
    solid: Solids | None = Field(None, description="where one solid phase fills the bed")
    solids: dict[str, SolidKind] = Field(default_factory=dict, description="where several do: each kind by name")
    bed: Bed
    flow: Flow
    heat: Heat | None = None
    mass: Mass | None = None
    wall: Wall | None = None
    section: Section | None = None
    particle: Particle = Particle()
    adsorption: dict[str, Adsorption] = Field(
        default_factory=dict, description="of gases by name; of several solid phases each has its own"
    )
    reactions: dict[str, Reaction] = Field(default_factory=dict, description="reactions by name")
    boundary: dict[str, Boundary] = Field(default_factory=dict, description="inlets by name of the boundary")
    guess: Guess = Guess()
    continuation: Continuation | None = None
    time: Time | None = None
    solver: Solver = Solver()
    output: Output = Output()

    @property
    def phases(self) -> dict[str, SolidKind]:
        """Solid phases by name, also where there is one."""
        if self.solids:
            return self.solids
        solid = Solids() if self.solid is None else self.solid
        only = SolidKind.model_construct(
            **{name: getattr(solid, name) for name in Solids.model_fields},
            volume_share=1.0,
            particle_diameter=self.bed.diameter,
            adsorption=self.adsorption,
            diffusivity=self.particle.diffusivity,
        )
        return {ONLY: only}

    @property
    def adsorbs(self) -> bool:
        """Whether particles take up gas."""
        return any(table.adsorption for table in self.phases.values())
