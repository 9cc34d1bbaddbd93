"""Tables of species and reactions, the same in every model: [gas.species.NAME],
[solids.NAME.constituent.NAME], [reactions.NAME].
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, PrivateAttr, Tag

from contbed.scene.mechanism import find_mechanism
from contbed.scene.quantities import (
    Conductivity,
    Density,
    FiniteFloat,
    Length,
    NonNegative,
    Number,
    Positive,
    Table,
    Viscosity,
    form,
    unit,
)

MolarMass = Annotated[float, *unit("kg/mol"), Field(gt=0)]
MolarEnergy = Annotated[float, *unit("J/mol")]
MolarEntropy = Annotated[float, *unit("J/mol/K")]
MolarHeatCapacity = Annotated[float, *unit("J/mol/K"), Field(gt=0)]
Curve = Annotated[
    tuple[FiniteFloat, ...], Tag("list"), Field(min_length=1, max_length=4)
]
PositiveDiffusivity = Annotated[float, *unit("m**2/s"), Field(gt=0)]
MolarDensity = Annotated[float, *unit("mol/m**3"), Field(gt=0)]
SpecificArea = Annotated[float, *unit("1/m"), Field(gt=0)]


class Substance(Table):
    """Data of one species; what is absent comes from its formula, the mechanism or
    the thermodynamic tables.
    """

    elements: dict[str, Positive] | None = None
    """atoms, {C = 1, H = 4}; absent: from the name"""
    molar_mass: MolarMass | None = None
    """absent: from the elements"""
    shomate: tuple[FiniteFloat, ...] | None = Field(None, min_length=5, max_length=8)
    """A to H of the Shomate equation, T/1000 K, J/mol/K and kJ/mol; F and G may be left
    out"""
    heat_capacity: MolarHeatCapacity | None = None
    """constant, instead of shomate"""
    enthalpy: MolarEnergy | None = None
    """of formation at 298.15 K, with heat_capacity or A to E"""
    entropy: MolarEntropy | None = None
    """standard, at 298.15 K, with heat_capacity or A to E"""
    density: Density | None = None
    """of a solid without pores"""
    viscosity: (
        Annotated[Annotated[Viscosity, Tag("number")] | Curve, Discriminator(form)]
        | None
    ) = None
    """of a gas; a list is c1 to c4 of c1 T^c2/(1 + c3/T + c4/T^2)"""
    conductivity: (
        Annotated[Annotated[Conductivity, Tag("number")] | Curve, Discriminator(form)]
        | None
    ) = None
    """of a gas, as viscosity"""


def text_or_number(value: Any) -> str:
    """Return the `form` of a value in any unit, which is a text, or in SI."""
    return "name" if isinstance(value, str) else form(value)


Parameter = Annotated[
    Annotated[FiniteFloat, Tag("number")] | Annotated[str, Tag("name")],
    Discriminator(text_or_number),
]


PhaseOrPhases = Annotated[
    Annotated[str, Tag("name")] | Annotated[tuple[str, ...], Tag("list")],
    Discriminator(form),
]


class Reaction(Table):
    """One reaction: a rate law by name with its constants, or a formula; or all
    reactions at a catalyst by a surface mechanism.
    """

    equation: str | None = None
    """"CH4 + 12 Fe2O3 -> 8 Fe3O4 + CO2 + 2 H2O"; <-> if reversible; a power
    law that runs backward stops where the solids that it consumes are used up"""
    law: str | None = None
    """rate law by name, which `contbed explain law` lists; absent: power, or the first law
    of a reaction of this name"""
    rate: str | None = None
    """formula instead, of T, p, R, eps, parameters, p_A, c_A, x_A of a gas A, n_B of a
    solid B in moles per volume of the bed, X, the conversion of a solid to another, and
    Q_over_K of a reversible reaction of gases, as in k*p_CO*(1 - Q_over_K)"""
    unit: str | None = None
    """of the formula, such as kmol/kg/h; absent: SI of the basis"""
    parameters: dict[str, Parameter] = Field(default_factory=dict)
    """of the formula, {E = "49 kJ/mol"}"""
    A: (
        Annotated[
            Annotated[NonNegative, Tag("number")] | Annotated[str, Tag("name")],
            Discriminator(text_or_number),
        ]
        | None
    ) = None
    """of k = A T^b exp(-E/(R T)): in mol, m, s and K, or with its unit, "0.2 L/mol/min" """
    b: Number = 0.0
    """exponent of the temperature in k = A T^b exp(-E/(R T))"""
    E: MolarEnergy | None = None
    """activation energy; below zero where the rate falls with the temperature"""
    orders: dict[str, Number] | None = None
    """in concentrations, of solids in moles per volume of the particles, or of the bed
    where basis = "bed"; absent: the coefficients of the gases on the left"""
    solid: PhaseOrPhases | None = None
    """phase, or list of phases, of [solids] in which it runs; absent: those that hold
    what reacts"""
    basis: Literal["gas", "catalyst", "particle", "bed"] | None = None
    """rate per m3 of gas, kg of catalyst, m3 of particles or of bed (packed_bed
    alone); absent: gas, or particle"""
    factor: Positive = 1.0
    """multiplies the rate, such as an effectiveness"""
    equilibrium_factor: Positive = 1.0
    """multiplies K of a reversible reaction, which comes from the thermodynamics of its
    species"""
    grain_radius: Length | None = None
    """radius of the grains in the particles"""
    molar_density: MolarDensity | None = None
    """of the reacting solid in a grain"""
    active_share: Positive = 1.0
    """share of the surface of grains that reacts"""
    diffusivity: PositiveDiffusivity | None = None
    """effective, in the product layer or particle"""
    surface: str | None = None
    """phase of `mechanism`, such as Pt_surf, in place of an equation and a rate; its
    coverages are in steady state with the gas at each point, also in time; in
    packed_bed alone, as mechanism and area"""
    mechanism: str | None = None
    """Cantera mechanism with the phase `surface`: a name or a YAML file"""
    area: SpecificArea | None = None
    """of the catalyst of `surface`, over the volume of the particles; with basis
    = "bed" over that of the bed"""

    _folder: Path = PrivateAttr(Path())

    def model_post_init(self, context: Any) -> None:
        """Keep the folder of the scene, in which `mechanism` may be a file."""
        if self.surface is not None and context:
            self._folder = context["folder"]

    @property
    def mechanism_path(self) -> str:
        """Path of `mechanism` for Cantera, or its name where no such file is found."""
        return find_mechanism(str(self.mechanism), self._folder)
