"""Tables of a scene of particles without flow: conduction through a lattice or a
packing, in SI.

[particles]           a file with a table of positions or a dump of LIGGGHTS or LAMMPS,
                      and how heat passes
[particles.lattice]   touching spheres in a periodic cell, in place of a file
[particles.packing]   spheres that settle in a box or a cylinder, in place of a file
[particles.layers]    which particles are held at temperatures; absent: a periodic cell,
                      in a packing those at both ends
[particles.closure]   ratios of conductivity for which a closure file is fitted
[solids.NAME]         the particles and their material, with the roughness of contacts
[gas]                 between the particles; absent: a vacuum
[radiation]           between the particles; absent: none
"""

from __future__ import annotations

from math import pi
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field

from contbed.scene.quantities import (
    Density,
    Emissivity,
    Fraction,
    Length,
    Natural,
    NonNegative,
    Number,
    Position,
    Positive,
    PositiveShare,
    Pressure,
    Switch,
    Table,
    Temperature,
    Whole,
    unit,
)
from contbed.scene.solids import SolidPhase, one_solid
from contbed.scene.tables import BalancedRun, SceneBase

Area = Annotated[float, *unit("m**2"), Field(gt=0)]
Above = Annotated[float, *unit("W/m/K"), Field(gt=0)]
Ratio = Positive

SOLID_SHARE = 0.59  # of a settled bed, which turns a height into a number of spheres
SOFT = 1e7  # Young's modulus of a simulation of spheres where the scene gives none [Pa]


class Spheres(SolidPhase):
    """Spheres with the contacts of a material, as all scenes of particles have them."""

    conductivity: Above
    """thermal, of the material"""
    youngs_modulus: Pressure | None = None
    """of the material, for which contacts of a softer simulation are corrected"""
    # re-entrant foams reach -0.7: Lakes 1987, Science 235, 1038,
    # doi:10.1126/science.235.4792.1038
    poisson_ratio: Annotated[Number, Field(ge=-0.7, le=0.5)] = 0.3
    """0.1 to 0.5 of solids; only foams made for it are negative, down to -0.7"""
    restitution: PositiveShare = 0.9
    """of contacts"""
    sliding_friction: NonNegative = 0.3
    """coefficient, of contacts"""
    rolling_friction: NonNegative = 0.0
    """arm over the effective radius"""

    @property
    def radius(self) -> float | None:
        """Half of the diameter [m]; None where a file brings radii."""
        return None if self.diameter is None else 0.5 * self.diameter


class Solid(Spheres):
    """The particles: roughness and slope are those of one particle."""

    diameter: Length | None = None
    """of equal spheres, or the mean one; a dump brings its own"""
    size_spread: Annotated[Number, Field(ge=0, le=0.3)] = 0.0
    """of a packing: standard deviation of the diameters over their mean; normal, cut at
    two deviations"""
    density: Density = 2500.0
    """of the particles"""
    emissivity: Emissivity | None = None
    """needed with [radiation]"""
    roughness: Length | None = None
    """root mean square; absent: smooth, no temperature jump"""
    asperity_slope: Positive | None = None
    """mean slope of the asperities, with roughness"""
    microhardness: Pressure | None = None
    """with roughness"""


class Gas(Table):
    """Gas or liquid between the particles."""

    conductivity: Above
    """thermal"""
    mean_free_path: Length | None = None
    """needed with a roughness of the particles"""
    accommodation: PositiveShare = 0.9
    """thermal, of the gas on the surface"""
    heat_capacity_ratio: Annotated[Number, Field(gt=1, lt=2)] = 1.4
    """at constant pressure and volume"""
    prandtl: Positive = 0.71
    """Prandtl number"""


class Lattice(Table):
    """Equal spheres that touch, with contacts of a given size, in a periodic cell."""

    type: Literal["sc", "bcc", "fcc"]
    """simple, body-centred or face-centred cubic lattice"""
    contact_radius: Length
    """of the contact circle of neighbours"""
    cells: Annotated[Whole, Field(ge=1, le=20)] = 1
    """unit cells along each axis"""


class Packing(Table):
    """Spheres placed at random that settle on a floor, in a box or a cylinder."""

    count: Annotated[Whole, Field(ge=1)] | None = None
    """of spheres; or height"""
    height: Length | None = None
    """in place of count: about as many as fill the bed to there"""
    width: tuple[Length, Length] | None = None
    """of the bed in x and y"""
    cylinder: Length | None = None
    """in place of width: radius of a round bed"""
    periodic: Switch = False
    """sides of a box"""
    seed: Natural = 0
    """of the random start"""

    @property
    def area(self) -> float:
        """Cross-section of the bed [m2]; 0 without width and cylinder."""
        if self.cylinder is not None:
            return pi * self.cylinder**2
        return self.width[0] * self.width[1] if self.width is not None else 0.0

    def number(self, solid: Solid) -> int:
        """Return the number of spheres: `count`, or what fills the bed to `height`."""
        if self.count is not None or self.height is None:
            return self.count or 0
        return round(SOLID_SHARE * self.area * self.height / _mean_volume(solid))

    def expected_height(self, solid: Solid) -> float:
        """Return the height of the settled bed [m], about."""
        return self.number(solid) * _mean_volume(solid) / (SOLID_SHARE * self.area)


def _mean_volume(solid: Solid) -> float:
    """Return the mean volume of spheres of spread sizes [m3]."""
    radius = solid.radius or 0.0
    return 4.0 / 3.0 * pi * radius**3 * (1.0 + 3.0 * solid.size_spread**2)


class Layers(Table):
    """Particles below and above two heights are held at temperatures."""

    bottom: Position
    """particles with a lower centre are hot"""
    top: Position
    """particles with a higher centre are cold"""
    area: Area | None = None
    """cross-section of the bed; that of a packing is known"""
    T_hot: Temperature = 398.15
    """of the hot layer"""
    T_cold: Temperature = 298.15
    """of the cold layer"""


class Closure(Table):
    """Effective conductivity fitted over the ratio of conductivities, written as
    closure.toml.
    """

    ratios: Annotated[tuple[Ratio, ...], Field(min_length=3)]
    """of particles to gas"""
    degree: Annotated[Whole, Field(ge=1, le=6)] = 3
    """of the polynomial of logarithms"""


class Particles(Table):
    """Spheres of a file, a lattice or a packing, and steady conduction between them.

    A file has x,y,z in metres with commas, or is a .vtu of contbed, or a dump
    (`ITEM: TIMESTEP` first), of which the last step counts.
    """

    file: str | None = None
    """path relative to the scene"""
    lattice: Lattice | None = None
    packing: Packing | None = None
    modulus: Pressure | None = None
    """Young's modulus of the simulation that the contacts are of; absent: 1e7 Pa in a
    packing, else that of the material"""
    exponents: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=2)] = (
        1 / 3,
    )
    """of the correction of contacts from modulus to solids.NAME.youngs_modulus: 1/3 at
    a given load; the second, of impacts, is that of beds with gas"""
    paths: Literal["cones", "columns", "spreading"] = "cones"
    """of heat: the paper's; exact at equal conductivities; that and Batchelor-O'Brien
    at large"""
    porosity: Fraction | None = None
    """around all pairs; absent: counted"""
    layers: Layers | None = None
    closure: Closure | None = None

    @property
    def simulated_modulus(self) -> float | None:
        """Young's modulus of the simulation [Pa]; None where it is not known."""
        return (
            SOFT if self.modulus is None and self.packing is not None else self.modulus
        )


class Radiation(Table):
    """Exchange with the neighbours within 1.5 diameters, linear about a temperature."""

    temperature: Temperature
    """mean temperature, about which radiation is linearised"""


class Output(Table):
    """What a run writes besides summary.json."""

    fields: ClassVar[bool] = False

    plots: Switch = True
    """draw plots (.png)"""


class ParticleScene(SceneBase):
    """Heat in an assembly of particles."""

    kind: ClassVar[str] = "particles"
    time: ClassVar[None] = None

    particles: Particles
    solids: Annotated[dict[str, Solid], AfterValidator(one_solid)]
    """the particles, by name"""
    gas: Gas | None = None
    """absent: a vacuum"""
    radiation: Radiation | None = None
    solver: BalancedRun = BalancedRun()
    output: Output = Output()

    @property
    def solid(self) -> Solid:
        """The only solid phase."""
        return next(iter(self.solids.values()))

    @property
    def k_gas(self) -> float | None:
        """Conductivity between the particles [W/m/K]; None in a vacuum."""
        return None if self.gas is None else self.gas.conductivity
