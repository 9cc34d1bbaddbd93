"""The vocabulary of a scene of particles: conduction through a lattice or a packing from a file, in SI.

[lattice]       touching spheres in a periodic cell, or
[particles]     a table of positions or a dump of LIGGGHTS or LAMMPS, or
[packing]       spheres that settle in a box or a cylinder
[conduction]    materials and mechanisms
[surface]       roughness and rarefied gas at the contacts; absent: smooth spheres, no temperature jump
[layers]        which particles are held at temperatures; absent: a periodic cell, in a packing those at both ends
[radiation]     between the particles; absent: none
[closure]       ratios of conductivity for which a closure file is fitted; absent: none
"""

from __future__ import annotations

from math import pi
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from contbed.scene.quantities import (
    Density,
    Emissivity,
    Fraction,
    Length,
    NonNegative,
    Number,
    Position,
    Positive,
    Pressure,
    Switch,
    Table,
    Temperature,
    Whole,
    unit,
)
from contbed.scene.tables import SceneBase

Area = Annotated[float, *unit("m**2"), Field(gt=0)]
Above = Annotated[float, *unit("W/m/K"), Field(gt=0)]
Ratio = Annotated[Number, Field(gt=0)]

SOLID_SHARE = 0.59  # of a settled bed, which turns a height into a number of spheres


class Lattice(Table):
    """Equal spheres that touch, with contacts of a given size, in a periodic cell."""

    type: Literal["sc", "bcc", "fcc"] = Field(description="simple, body-centred or face-centred cubic lattice")
    radius: Length = Field(description="radius of the spheres")
    contact_radius: Length = Field(description="radius of the contact circle of neighbours")
    cells: Annotated[Whole, Field(ge=1, le=20)] = Field(1, description="unit cells along each axis")


class Particles(Table):
    """Spheres from a file: x,y,z in metres with commas, a .vtu of contbed, or a dump (`ITEM: TIMESTEP` first)."""

    file: str = Field(description="path relative to the scene")
    radius: Length | None = Field(None, description="of equal spheres; a dump brings its own")
    step: Annotated[Whole, Field(ge=0)] | None = Field(None, description="of a dump; the last one if absent")


class Packing(Table):
    """Spheres placed at random that settle under gravity on a floor, in a box or a cylinder, and conduct then."""

    count: Annotated[Whole, Field(ge=1)] | None = Field(None, description="of spheres; or height")
    height: Length | None = Field(None, description="in place of count: about as many as fill the bed to there")
    radius: Length = Field(description="of equal spheres, or the mean one")
    spread: Annotated[Number, Field(ge=0, le=0.3)] = Field(
        0.0, description="standard deviation of the radii over their mean; normal, cut at two deviations"
    )
    width: tuple[Length, Length] | None = Field(None, description="of the bed in x and y")
    cylinder: Length | None = Field(None, description="in place of width: radius of a round bed")
    periodic: Switch = Field(False, description="sides of a box")
    seed: Annotated[Whole, Field(ge=0)] = Field(0, description="seed of the random start")
    density: Density = Field(2500.0, description="density of the spheres")
    modulus: Pressure = Field(1e7, description="Young's modulus of the simulation")
    poisson_ratio: Annotated[Number, Field(ge=-0.7, le=0.5)] = Field(0.3, description="Poisson's ratio of the spheres")
    restitution: Annotated[Number, Field(gt=0, le=1)] = Field(0.9, description="coefficient of restitution of contacts")
    sliding_friction: NonNegative = Field(0.3, description="coefficient of sliding friction of contacts")
    rolling_friction: NonNegative = Field(0.0, description="arm over the effective radius")

    @property
    def area(self) -> float:
        """Cross-section of the bed [m2]; 0 as long as neither width nor cylinder is given."""
        if self.cylinder is not None:
            return pi * self.cylinder**2
        return self.width[0] * self.width[1] if self.width is not None else 0.0

    @property
    def number(self) -> int:
        """Number of spheres: `count`, or what fills the bed to `height`."""
        if self.count is not None or self.height is None:
            return self.count or 0
        return round(SOLID_SHARE * self.area * self.height / self._mean_volume)

    @property
    def expected_height(self) -> float:
        """Height of the settled bed [m], about."""
        return self.number * self._mean_volume / (SOLID_SHARE * self.area)

    @property
    def _mean_volume(self) -> float:
        return 4.0 / 3.0 * pi * self.radius**3 * (1.0 + 3.0 * self.spread**2)


class Correction(Table):
    """Contacts of a softer simulation reduced to those of the material: radius times (simulated/real)^exponent."""

    simulated: Pressure = Field(description="modulus of the simulation")
    real: Pressure = Field(description="Young's modulus of the real material")
    exponent: Positive = Field(1 / 3, description="1/3 at a given load; the paper takes 1/5, an impact's")


class Conduction(Table):
    """Steady conduction from particle to particle."""

    particles: Above = Field(description="conductivity of the particles")
    fluid: Above | None = Field(None, description="conductivity of the fluid between them; absent: a vacuum")
    paths: Literal["cones", "columns", "spreading"] = Field(
        "cones", description="of heat: the paper's; exact at equal conductivities; that and Batchelor-O'Brien at large"
    )
    porosity: Fraction | None = Field(None, description="around all pairs; absent: counted")
    correction: Correction | None = None


class Surface(Table):
    """Rough particles with a gas between, for spreading paths; roughness and slope are those of one particle."""

    roughness: Length = Field(description="root mean square")
    slope: Positive = Field(description="mean slope of the asperities")
    microhardness: Pressure = Field(description="microhardness of the softer surface")
    youngs_modulus: Pressure = Field(description="of the material, not of a softer simulation")
    poisson_ratio: Annotated[Number, Field(gt=-1, le=0.5)] = Field(0.3, description="Poisson's ratio of the spheres")
    mean_free_path: Length = Field(description="of the gas")
    accommodation: Annotated[Number, Field(gt=0, le=1)] = Field(0.9, description="thermal, of the gas on the surface")
    heat_capacity_ratio: Annotated[Number, Field(gt=1, lt=2)] = Field(1.4, description="of the gas")
    prandtl: Positive = Field(0.71, description="of the gas")


class Layers(Table):
    """Particles below and above two heights are held at temperatures."""

    bottom: Position = Field(description="particles with a lower centre are hot")
    top: Position = Field(description="particles with a higher centre are cold")
    area: Area | None = Field(None, description="cross-section of the bed; that of a packing is known")
    T_hot: Temperature = Field(398.15, description="temperature of the hot layer")
    T_cold: Temperature = Field(298.15, description="temperature of the cold layer")


class Radiation(Table):
    """Exchange with the neighbours within 1.5 diameters, linear about a temperature."""

    emissivity: Emissivity = Field(description="emissivity of the particles")
    temperature: Temperature = Field(description="mean temperature, about which radiation is linearised")


class Closure(Table):
    """Effective conductivity fitted over the ratio of conductivities, written as closure.toml."""

    ratios: Annotated[tuple[Ratio, ...], Field(min_length=3)] = Field(description="of particles to fluid")
    degree: Annotated[Whole, Field(ge=1, le=6)] = Field(3, description="of the polynomial of logarithms")


class Solver(Table):
    """Tolerances."""

    balance_tolerance: Positive = Field(1e-10, description="largest relative residual of a balance that a run accepts")
    strict: Switch = Field(False, description="a closure out of its range is an error")


class Output(Table):
    """What a run writes besides summary.json."""

    fields: ClassVar[bool] = False

    plots: Switch = Field(True, description="draw plots (.png)")


class ParticleScene(SceneBase):
    """Heat in an assembly of particles."""

    kind: ClassVar[str] = "particles"
    time: ClassVar[None] = None

    lattice: Lattice | None = None
    particles: Particles | None = None
    packing: Packing | None = None
    conduction: Conduction
    surface: Surface | None = None
    layers: Layers | None = None
    radiation: Radiation | None = None
    closure: Closure | None = None
    solver: Solver = Solver()
    output: Output = Output()
