"""The vocabulary of a scene of particles: conduction through a lattice or a packing from a file, in SI.

[lattice]       touching spheres in a periodic cell, or
[particles]     a table of positions or a dump of LIGGGHTS or LAMMPS
[conduction]    materials and mechanisms
[surface]       roughness and rarefied gas at the contacts; absent: smooth spheres, no temperature jump
[layers]        which particles of a file are held at temperatures; absent: a periodic cell
[radiation]     between the particles; absent: none
[closure]       ratios of conductivity for which a closure file is fitted; absent: none
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from contbed.scene.quantities import (
    Emissivity,
    Fraction,
    Length,
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


class Lattice(Table):
    """Equal spheres that touch, with contacts of a given size, in a periodic cell."""

    type: Literal["sc", "bcc", "fcc"]
    radius: Length
    contact_radius: Length
    cells: Annotated[Whole, Field(ge=1, le=20)] = Field(1, description="unit cells along each axis")


class Particles(Table):
    """Spheres from a file: x,y,z in metres with commas, a .vtu of contbed, or a dump (`ITEM: TIMESTEP` first)."""

    file: str = Field(description="path relative to the scene")
    radius: Length | None = Field(None, description="of equal spheres; a dump brings its own")
    step: Annotated[Whole, Field(ge=0)] | None = Field(None, description="of a dump; the last one if absent")


class Correction(Table):
    """Contacts of a softer simulation reduced to those of the material: radius times (simulated/real)^exponent."""

    simulated: Pressure = Field(description="modulus of the simulation")
    real: Pressure
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
    microhardness: Pressure
    youngs_modulus: Pressure = Field(description="of the material, not of a softer simulation")
    poisson_ratio: Annotated[Number, Field(gt=-1, le=0.5)] = 0.3
    mean_free_path: Length = Field(description="of the gas")
    accommodation: Annotated[Number, Field(gt=0, le=1)] = Field(0.9, description="thermal, of the gas on the surface")
    heat_capacity_ratio: Annotated[Number, Field(gt=1, lt=2)] = Field(1.4, description="of the gas")
    prandtl: Positive = Field(0.71, description="of the gas")


class Layers(Table):
    """Particles below and above two heights are held at temperatures."""

    bottom: Position = Field(description="particles with a lower centre are hot")
    top: Position = Field(description="particles with a higher centre are cold")
    area: Area = Field(description="cross-section of the bed")
    T_hot: Temperature = 398.15
    T_cold: Temperature = 298.15


class Radiation(Table):
    """Exchange with the neighbours within 1.5 diameters, linear about a temperature."""

    emissivity: Emissivity
    temperature: Temperature


class Closure(Table):
    """Effective conductivity fitted over the ratio of conductivities, written as closure.toml."""

    ratios: Annotated[tuple[Ratio, ...], Field(min_length=3)] = Field(description="of particles to fluid")
    degree: Annotated[Whole, Field(ge=1, le=6)] = Field(3, description="of the polynomial of logarithms")


class Solver(Table):
    """Tolerances."""

    balance_tolerance: Positive = 1e-10
    strict: Switch = Field(False, description="a closure out of its range is an error")


class Output(Table):
    """What a run writes besides summary.json."""

    fields: ClassVar[bool] = False

    plots: Switch = True


class ParticleScene(SceneBase):
    """Heat in an assembly of particles."""

    kind: ClassVar[str] = "particles"
    time: ClassVar[None] = None

    lattice: Lattice | None = None
    particles: Particles | None = None
    conduction: Conduction
    surface: Surface | None = None
    layers: Layers | None = None
    radiation: Radiation | None = None
    closure: Closure | None = None
    solver: Solver = Solver()
    output: Output = Output()
