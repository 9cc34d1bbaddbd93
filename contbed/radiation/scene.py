"""Tables of a scene that radiates: optics by particles or given, walls, tubes; and a
medium that merely radiates.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Protocol

from pydantic import Field, model_validator

from contbed.scene.mesh import Mesh
from contbed.scene.quantities import (
    Conductivity,
    Emissivity,
    Extinction,
    Fraction,
    Irradiance,
    Length,
    Number,
    Positive,
    Table,
    Temperature,
    Whole,
)
from contbed.scene.solids import SolidPhase
from contbed.scene.tables import FieldOutput, FieldSolver, SceneBase

FEWEST, MOST = 4, 64  # ordinates in a hemisphere that are tried where none are given
# in a medium that conducts, where each point answers to all others and the cost grows
# as points^3
MOST_CONDUCTING = 16


class RadiatingSolid(SolidPhase):
    """Particles of one kind and their share in the optics of the bed."""

    varies: ClassVar[frozenset[str]] = frozenset({"heat_capacity", "conductivity"})

    diameter: Length
    """of equal spheres, or the Sauter mean 1/sum(x/d) of mass fractions x"""
    volume_share: Annotated[Positive, Field(le=1)] = 1.0
    """of the volume of all particles; those of all kinds sum to 1"""
    emissivity: Emissivity | None = None
    """needed with [radiation] unless absorption is given"""
    temperature: Temperature | None = None
    """prescribed; absent: that of the medium, given or solved for"""


class Voidage(Table):
    """The table [packed_bed], of which a medium that merely radiates takes the
    porosity.
    """

    porosity: Fraction
    """share of the gas between particles in the volume of the bed"""


class Radiation(Table):
    """Gray radiation between the particles.

    With [heat] the particles of the bed radiate; alone it is a medium that conducts,
    has a prescribed temperature, or is in radiative equilibrium.
    """

    level: Literal["p1", "two_flux", "rosseland", "ordinates"] = "p1"
    """rosseland: thick beds, as a conductivity; ordinates: one dimension, nearly exact
    """
    absorption: Extinction | None = None
    """given directly instead of by solids.NAME.emissivity"""
    scattering: Extinction | None = None
    """scattering coefficient of the medium"""
    correction: Literal["close_packed", "independent"] = "close_packed"
    """extinction over the voidage, or the limit of points far apart"""
    anisotropy: Annotated[Number, Field(ge=-1, le=1)] = 0.0
    """mean cosine of scattering"""
    ordinates: Annotated[Whole, Field(ge=1, le=64)] | None = None
    """directions in each hemisphere; absent: 4, doubled until the error is within
    solver.tolerance"""
    conductivity: Conductivity | None = None
    """of the medium, without [heat]"""
    temperature: Temperature | None = None
    """of the medium, without [heat]"""

    @property
    def directions(self) -> int:
        """Ordinates in each hemisphere that are tried first."""
        return self.ordinates or FEWEST


class RadiationCondition(Table):
    """A gray wall at a temperature, or an opening through which a radiosity enters."""

    emissivity: Emissivity = 1.0
    """emissivity of the wall"""
    temperature: Temperature | None = None
    """temperature of the wall"""
    radiosity: Irradiance | None = None
    """radiation that enters through an opening"""

    @model_validator(mode="after")
    def _one(self) -> RadiationCondition:
        if (self.temperature is None) == (self.radiosity is None):
            raise ValueError("give one of temperature, radiosity")
        if self.radiosity is not None and self.emissivity != 1.0:
            raise ValueError(
                "emissivity is that of a wall at a temperature; all of a radiosity "
                "enters: leave one out"
            )
        return self


class Tubes(Table):
    """Tubes immersed in a region, as the radiation sees them."""

    area: Extinction
    """tube surface per bed volume"""
    emissivity: Emissivity
    """emissivity of the tubes; combined with that of the particles that face them"""
    temperature: Temperature
    """surface temperature of the tubes"""


class Radiating(Protocol):
    """A scene as the radiation sees it: a packed bed with [radiation], or a medium
    that merely radiates.
    """

    @property
    def mesh(self) -> Any:
        """The [mesh] table."""

    @property
    def radiation(self) -> Any:
        """The [radiation] table."""

    @property
    def solids(self) -> Any:
        """The [solids.NAME] tables by name."""

    @property
    def packed_bed(self) -> Any:
        """The [packed_bed] table, or None."""

    @property
    def heat(self) -> Any:
        """The [heat] table, or None for a stand-alone medium."""

    @property
    def boundary(self) -> Any:
        """The boundary tables by name."""

    @property
    def region(self) -> Any:
        """The region tables by name."""

    @property
    def solver(self) -> Any:
        """The [solver] table."""


class RadiatingBoundary(Table):
    """Condition on one named boundary of a medium that merely radiates."""

    radiation: RadiationCondition | None = None
    """absent: a mirror"""


class RadiationScene(SceneBase):
    """A stand-alone radiating medium, without flow and without phases."""

    kind: ClassVar[str] = "radiation"
    # what only a bed with two phases has
    heat: ClassVar[None] = None
    time: ClassVar[None] = None
    region: ClassVar[Mapping[str, Any]] = {}

    mesh: Mesh
    radiation: Radiation
    solids: dict[str, RadiatingSolid] = Field(default_factory=dict)
    """of which the optics follow"""
    packed_bed: Voidage | None = None
    """needed where the optics follow from particles"""
    boundary: dict[str, RadiatingBoundary] = Field(default_factory=dict)
    """radiative conditions by name of the boundary"""
    solver: FieldSolver = FieldSolver()
    output: FieldOutput = FieldOutput()
