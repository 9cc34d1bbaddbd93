"""Tables of a reacting bed on its solid phases: data of constituents, adsorption,
intraparticle diffusion.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from contbed.scene.property_table import (
    ConductivityOfSolid,
    HeatCapacityOfSolid,
    Melting,
)
from contbed.scene.quantities import (
    Density,
    Length,
    PositiveShare,
    ShareBelowOne,
    Table,
    Temperature,
    Whole,
    unit,
)
from contbed.scene.reactions import MolarEnergy, PositiveDiffusivity, Substance
from contbed.scene.solids import SolidPhase
from contbed.scene.tables import NonNegativeOrClosure


class Adsorption(Table):
    """Isotherm of a gas and its diffusion in the pores; give henry, or capacity and
    affinity (Langmuir).
    """

    henry: Annotated[float, *unit("mol/kg/Pa"), Field(gt=0)] | None = None
    """moles adsorbed per mass of particles over the partial pressure"""
    capacity: Annotated[float, *unit("mol/kg"), Field(gt=0)] | None = None
    """moles adsorbed per mass of particles when all sites are taken"""
    affinity: Annotated[float, *unit("1/Pa"), Field(gt=0)] | None = None
    """b of q = q_s b p/(1 + sum b p)"""
    temperature: Temperature = 298.15
    """at which henry or affinity holds"""
    enthalpy: MolarEnergy = 0.0
    """of adsorption, negative where heat is released"""
    diffusivity: PositiveDiffusivity
    """effective, in the pores of the particles"""

    @model_validator(mode="after")
    def _one_isotherm(self) -> Adsorption:
        if (self.capacity is None) != (self.affinity is None):
            raise ValueError("capacity and affinity belong together")
        if (self.henry is None) == (self.capacity is None):
            raise ValueError("give henry, or capacity and affinity")
        return self


class Inside(Table):
    """What happens within the particles of a solid phase."""

    mass: Literal["auto", "none", "effectiveness", "interior"] = "auto"
    """effectiveness of a sphere by the Thiele modulus of each reaction with a
    diffusivity; interior: diffusion and reaction of all gases resolved in the
    particles, with `diffusivity`; auto: resolved where that changes what reacts by more
    than solver.accuracy"""
    diffusivity: dict[str, PositiveDiffusivity] = Field(default_factory=dict)
    """effective, of each gas that reacts in the particles, { CH4 = "2e-6 m**2/s" }"""
    adsorption: Literal["auto", "film", "linear_driving_force", "interior"] = "auto"
    """resistance to the uptake of gas: external film only; in series with it diffusion
    inside, by one concentration per particle; diffusion between points inside. auto:
    the cheapest whose error in what leaves is within solver.accuracy"""
    points: Annotated[Whole, Field(ge=2, le=20)] = 3
    """inside of a particle, beside its surface"""


class Solid(SolidPhase):
    """One solid phase of the bed; several are mixed evenly where they enter."""

    varies: ClassVar[frozenset[str]] = frozenset({"heat_capacity", "conductivity"})

    diameter: Length
    """diameter of the particles of this solid phase"""
    shape: Literal["spheres", "rods"] = "spheres"
    """specific surface 6 (1-eps)/d for spheres, 4 (1-eps)/d for rods, whose pressure drop
    is that of six volumes over surface, 1.5 d"""
    volume_share: PositiveShare = 1.0
    """of the volume of all particles where they enter, or at rest; those of all phases
    sum to 1"""
    density: Density | None = None
    """of particles that enter; absent: from constituents and porosity"""
    heat_capacity: HeatCapacityOfSolid | None = None
    """of particles without constituents"""
    conductivity: ConductivityOfSolid | None = None
    """of the particles"""
    melting: Melting | None = None
    """of particles without constituents; absent: they do not melt"""
    composition: str | None = None
    """mass fractions that enter, "Fe2O3:0.45, Al2O3:0.55"
    """
    porosity: ShareBelowOne = 0.0
    """of the particles that enter"""
    constituent: dict[str, Substance] = Field(default_factory=dict)
    """data of constituents by name, which hold in all phases"""
    nusselt: NonNegativeOrClosure | None = None
    """of this phase; absent: closures.nusselt"""
    sherwood: NonNegativeOrClosure | None = None
    """of this phase; absent: closures.sherwood, if any"""
    adsorption: dict[str, Adsorption] = Field(default_factory=dict)
    """of gases by name"""
    inside: Inside = Inside()
    """what happens in the particles"""
