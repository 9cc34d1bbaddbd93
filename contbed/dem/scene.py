"""The vocabulary of a scene of particles: conduction through a lattice or a packing from a file, in SI.

[lattice]       touching spheres in a periodic cell, or
[particles]     a table of positions or a dump of LIGGGHTS or LAMMPS
[conduction]    materials and mechanisms
[layers]        which particles of a file are held at temperatures; absent: a periodic cell
[radiation]     between the particles; absent: none
[closure]       ratios of conductivity for which a closure file is fitted; absent: none
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from contbed.packed_bed import scene as s
from contbed.scene.quantities import unit

Area = Annotated[float, *unit("m**2"), Field(gt=0)]
Above = Annotated[float, *unit("W/m/K"), Field(gt=0)]
Ratio = Annotated[s.Number, Field(gt=0)]


class Lattice(s.Table):
    """Equal spheres that touch, with contacts of a given size, in a periodic cell."""

    type: Literal["sc", "bcc", "fcc"]
    radius: s.Length
    contact_radius: s.Length
    cells: Annotated[s.Whole, Field(ge=1, le=20)] = Field(1, description="unit cells along each axis")


class Particles(s.Table):
    """Spheres from a file: text with x,y,z in metres, or a dump (`ITEM: TIMESTEP` first); .gz is unpacked."""

    file: str = Field(description="path relative to the scene")
    radius: s.Length | None = Field(None, description="of equal spheres; a dump brings its own")
    step: Annotated[s.Whole, Field(ge=0)] | None = Field(None, description="of a dump; the last one if absent")


class Correction(s.Table):
    """Contacts of a softer simulation reduced to those of the material: radius times (simulated/real)^exponent."""

    simulated: s.Pressure = Field(description="modulus of the simulation")
    real: s.Pressure
    exponent: s.Positive = Field(1 / 3, description="1/3 at a given load; the paper takes 1/5, an impact's")


class Conduction(s.Table):
    """Steady conduction from particle to particle."""

    particles: Above = Field(description="conductivity of the particles")
    fluid: Above | None = Field(None, description="conductivity of the fluid between them; absent: a vacuum")
    paths: Literal["cones", "columns"] = Field(
        "cones", description="of heat through the fluid: the paper's, or exact at equal conductivities"
    )
    porosity: s.Fraction | None = Field(None, description="around all pairs; absent: counted")
    correction: Correction | None = None


class Layers(s.Table):
    """Particles below and above two heights are held at temperatures."""

    bottom: s.Position = Field(description="particles with a lower centre are hot")
    top: s.Position = Field(description="particles with a higher centre are cold")
    area: Area = Field(description="cross-section of the bed")
    T_hot: s.Temperature = 398.15
    T_cold: s.Temperature = 298.15


class Radiation(s.Table):
    """Exchange with the neighbours within 1.5 diameters, linear about a temperature."""

    emissivity: s.Emissivity
    temperature: s.Temperature


class Closure(s.Table):
    """Effective conductivity fitted over the ratio of conductivities, written as closure.toml."""

    ratios: Annotated[tuple[Ratio, ...], Field(min_length=3)] = Field(description="of particles to fluid")
    degree: Annotated[s.Whole, Field(ge=1, le=6)] = Field(3, description="of the polynomial of logarithms")


class Solver(s.Table):
    """Tolerances."""

    balance_tolerance: s.Positive = 1e-10
    strict: s.Switch = Field(False, description="a closure out of its range is an error")


class Output(s.Table):
    """What a run writes besides summary.json."""

    fields: ClassVar[bool] = False

    plots: s.Switch = True


class ParticleScene(s.SceneBase):
    """Heat in an assembly of particles."""

    kind: ClassVar[str] = "particles"
    time: ClassVar[None] = None

    lattice: Lattice | None = None
    particles: Particles | None = None
    conduction: Conduction
    layers: Layers | None = None
    radiation: Radiation | None = None
    closure: Closure | None = None
    solver: Solver = Solver()
    output: Output = Output()
