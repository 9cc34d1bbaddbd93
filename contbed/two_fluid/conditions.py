"""Tables of a scene of two fluids that say what is given: [initial] and
[boundary.NAME].
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field

from contbed.scene.quantities import (
    Emissivity,
    HeatFlux,
    Natural,
    Number,
    Position,
    PositiveShare,
    Seconds,
    ShareBelowOne,
    Table,
    Temperature,
    takes,
    unit,
)
from contbed.scene.tables import WallCoefficientOrClosure
from contbed.scene.toml_lines import KeyPath

Speed = Annotated[float, *unit("m/s")]
Share = ShareBelowOne
Theta = Annotated[float, *unit("m**2/s**2"), Field(ge=0)]
Flux = Annotated[float, *unit("kg/m**2/s"), Field(ge=0)]


class GasInLayer(Table):
    """Gas at the start."""

    velocity: Speed | None = None
    """intrinsic, along the last axis"""
    temperature: Temperature | None = None
    """initial temperature of the gas in the layer"""


class SolidInLayer(Table):
    """Particles at the start."""

    volume_fraction: Share | None = None
    """initial volume fraction of the solids in the layer"""
    granular_temperature: Theta | None = None
    """initial granular temperature in the layer"""
    velocity: Speed | None = None
    """along the last axis"""
    temperature: Temperature | None = None
    """absent: as the gas"""


class GasAtStart(GasInLayer):
    """Gas at the start."""

    velocity: Speed = 0.0
    """intrinsic, along the last axis"""


class SolidAtStart(SolidInLayer):
    """Particles at the start."""

    volume_fraction: Share = 0.0
    """initial volume fraction of the solids, outside of the layers"""
    granular_temperature: Theta = 1e-4
    """initial granular temperature"""
    velocity: Speed = 0.0
    """along the last axis"""


class Layer(Table):
    """Fields between two positions along the last axis; what is not given stays as
    it was.
    """

    start: Position = -1e30
    """lower end of the layer"""
    end: Position = 1e30
    """upper end of the layer"""
    gas: GasInLayer = GasInLayer()
    solids: dict[str, SolidInLayer] = Field(default_factory=dict)
    """data of the solid phases by name"""

    @property
    def solid(self) -> SolidInLayer:
        """The particles."""
        return next(iter(self.solids.values()), SolidInLayer())


class Initial(Table):
    """Fields at the start."""

    gas: GasAtStart = GasAtStart()
    solids: dict[str, SolidAtStart] = Field(default_factory=dict)
    """data of the solid phases by name"""
    shear: Annotated[float, *unit("1/s")] = 0.0
    """of the particles: u_x grows with the last axis"""
    noise: ShareBelowOne = 0.0
    """relative, of the volume fraction, to break symmetry"""
    seed: Natural = 0
    """seed of the random disturbance"""
    layer: tuple[Layer, ...] = ()
    """layers with initial values of their own"""

    @property
    def parts(self) -> tuple[Initial | Layer, ...]:
        """The whole bed, then its layers, which replace what they give."""
        return (self, *self.layer)

    @property
    def solid(self) -> SolidAtStart:
        """The particles."""
        return next(iter(self.solids.values()), SolidAtStart())


class Part(Table):
    """A boundary, or a piece of one along the last axis; along the first, of one
    that is level.
    """

    on: str | None = None
    """boundary of the mesh that this is a piece of, from start to end"""
    start: Position | None = None
    """lower end of the part of the side; absent: the whole side"""
    end: Position | None = None
    """upper end of the part of the side; absent: the whole side"""


class GasAtWall(Table):
    """Gas at a wall."""

    wall: Literal["no_slip", "slip"] = "no_slip"
    """condition of the gas at the wall"""


class SolidAtWall(Table):
    """Particles at a wall."""

    wall: Literal["no_slip", "slip", "johnson_jackson"] = "no_slip"
    """condition of the solids at the wall; johnson_jackson: partial slip"""
    specularity: PositiveShare | None = None
    """specularity coefficient of collisions with the wall"""
    restitution: PositiveShare | None = None
    """coefficient of restitution between particles and wall"""
    friction: Annotated[Number, Field(ge=0, le=2)] = 0.0
    """Coulomb's coefficient of particles that rub along the wall under their frictional
    pressure"""


class Wall(Part):
    """Nothing passes."""

    type: Literal["wall"]
    """wall"""
    gas: GasAtWall = GasAtWall()
    """condition of the gas at the wall"""
    solids: dict[str, SolidAtWall] = Field(default_factory=dict)
    """data of the solid phases by name"""
    velocity: tuple[Speed, ...] = ()
    """of the wall in its own plane"""
    temperature: Temperature | None = None
    """with [heat]: heat is conducted to the wall at this temperature; absent: adiabatic
    """
    heat_flux: HeatFlux | None = None
    """into the bed; the phases share it by their fractions"""

    coefficient: WallCoefficientOrClosure | None = Field(
        None, json_schema_extra=takes("bed_tube")
    )
    """of this wall, to `ambient`, in place of closures.wall_heat"""
    ambient: Temperature | None = None
    """temperature of the surroundings of the wall"""
    emissivity: Emissivity | None = None
    """of the wall; absent: no radiation between it and particles"""

    @property
    def outside(self) -> float | None:
        """Temperature that the wall exchanges heat with [K]."""
        return self.ambient if self.temperature is None else self.temperature

    @property
    def solid(self) -> SolidAtWall:
        """The particles."""
        return next(iter(self.solids.values()), SolidAtWall())


class Symmetry(Part):
    """A plane of symmetry, or the axis."""

    type: Literal["symmetry"]
    """plane or axis of symmetry"""


class Periodic(Table):
    """One and the same as another boundary."""

    type: Literal["periodic"]
    """side that is joined to its partner"""
    partner: str
    """the boundary opposite, which is not named again"""


class GasAtInlet(Table):
    """Gas that enters."""

    velocity: Annotated[Speed, Field(ge=0)] = 0.0
    """superficial"""
    temperature: Temperature | None = None
    """temperature of the gas that enters"""


class SolidAtInlet(Table):
    """Particles that enter."""

    volume_fraction: Share = 0.0
    """volume fraction of the solids that enter"""
    mass_flux: Flux | None = None
    """through this boundary"""
    velocity: Annotated[Speed, Field(gt=0)] | None = None
    """velocity of the solids that enter"""
    granular_temperature: Theta = 0.0
    """granular temperature of the solids that enter"""
    temperature: Temperature | None = None
    """absent: as the gas"""


class Inlet(Part):
    """Gas, with or without particles."""

    type: Literal["inlet"]
    """inlet of gas and solids"""
    until: Seconds | None = None
    """then it is as the inlet that it is a piece of"""
    gas: GasAtInlet = GasAtInlet()
    solids: dict[str, SolidAtInlet] = Field(default_factory=dict)
    """data of the solid phases by name"""

    @property
    def solid(self) -> SolidAtInlet:
        """The particles."""
        return next(iter(self.solids.values()), SolidAtInlet())


class GasOutside(Table):
    """Gas beyond an outlet."""

    pressure: Annotated[float, *unit("Pa")] = 0.0
    """gauge pressure at the outlet"""


class Outlet(Part):
    """Free outflow against a pressure; particles do not come back."""

    type: Literal["outlet"]
    """outlet of given pressure"""
    gas: GasOutside = GasOutside()


Boundary = Annotated[
    Wall | Symmetry | Periodic | Inlet | Outlet, Field(discriminator="type")
]


Kind = TypeVar("Kind", bound=Table)


def of_kind(boundary: Mapping[str, Any], kind: type[Kind]) -> dict[str, Kind]:
    """Return the boundaries of one type by their names."""
    return {name: part for name, part in boundary.items() if isinstance(part, kind)}


def places(
    initial: Initial, boundary: Mapping[str, Boundary]
) -> list[tuple[KeyPath, Any]]:
    """Return the tables of the start and of boundaries with their paths."""
    layers = [(("initial", "layer", k), layer) for k, layer in enumerate(initial.layer)]
    sides = [(("boundary", name), part) for name, part in boundary.items()]
    return [(("initial",), initial), *layers, *sides]
