"""Tables [solids.NAME] of a bubbling bed, with fuel and limestone, in SI."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Field, model_validator

from contbed.bubbling_bed.tables import (
    CapacityFlow,
    ExchangeOrClosure,
    GasCoefficient,
    Release,
)
from contbed.scene.property_table import ConductivityOfSolid, HeatCapacityOfSolid
from contbed.scene.quantities import (
    Density,
    Emissivity,
    HeatCapacity,
    Length,
    NonNegative,
    Position,
    Positive,
    PositiveShare,
    Share,
    ShareBelowOne,
    Table,
    Temperature,
    form,
    given_one,
    takes,
    unit,
)
from contbed.scene.solids import SolidPhase
from contbed.scene.tables import ConductivityOrClosure, NamedOrFile

HeatingValue = Annotated[float, *unit("J/kg"), Field(gt=0)]
MassFraction = Share
MinorFraction = ShareBelowOne
MassFlow = Annotated[float, *unit("kg/s"), Field(ge=0)]
Nusselt = Annotated[NamedOrFile, Discriminator(form)]
Along = Callable[[Any], Any]  # function of height


class Feed(Table):
    """Particles that enter around a height, Gaussian, and leave the bed at one end."""

    capacity_flow: CapacityFlow | None = None
    """with boundary.bottom.gas.capacity_flow"""
    mass_flow: MassFlow | None = None
    """with boundary.bottom.gas.mass_flow; of fuel and limestone as received"""
    temperature: Temperature
    """of the particles that enter"""
    height: Annotated[Position, Field(ge=0)]
    """above the distributor, around which they enter"""
    width: Length
    """standard deviation; what it puts beyond the ends enters inside"""
    drain: Literal["top", "bottom"] = "top"
    """end where particles leave that are neither fuel nor limestone"""

    def shares(self, height: float) -> tuple[Along, Along]:
        """Return the share of the feed per height [1/m] and that below a height, as
        functions of the height in a bed of a `height` [m], which all of it enters.
        """
        from scipy.special import ndtr

        below = float(ndtr(-self.height / self.width))
        inside = float(ndtr((height - self.height) / self.width)) - below
        scale = 1.0 / (inside * self.width * np.sqrt(2.0 * np.pi))
        return (
            lambda z: scale * np.exp(-0.5 * ((z - self.height) / self.width) ** 2),
            lambda z: (ndtr((z - self.height) / self.width) - below) / inside,
        )


class Sizes(Table):
    """Sizes of one solid phase: those fed, or those in the bed.

    The first need [bubbling_bed.freeboard] with a height.
    """

    diameters: Annotated[tuple[Length, ...], Field(min_length=2)]
    """of the sizes"""
    feed: tuple[NonNegative, ...] | None = None
    """mass fractions, which sum to one"""
    bed: tuple[NonNegative, ...] | None = None
    """instead of `feed`"""

    @model_validator(mode="after")
    def _sums(self) -> Sizes:
        given = [shares for shares in (self.feed, self.bed) if shares is not None]
        if not given:
            raise ValueError("give one of feed, bed")
        for shares in given:
            if len(shares) != len(self.diameters) or abs(sum(shares) - 1.0) > 1e-6:
                raise ValueError(
                    f"{len(self.diameters)} mass fractions that sum to 1; found "
                    f"{sum(shares):.8g}"
                )
        return self


class Ultimate(Table):
    """Mass fractions of the dry fuel; with ash they sum to one."""

    C: MassFraction
    """of carbon"""
    H: MassFraction
    """of hydrogen"""
    O: MassFraction  # noqa: E741
    """of oxygen"""
    N: MassFraction = 0.0
    """of nitrogen"""
    S: MassFraction = 0.0
    """of sulphur"""


class Fuel(Table):
    """A solid fuel, fed by solids.NAME.feed."""

    moisture: MinorFraction = 0.0
    """mass fraction as received"""
    ash: MinorFraction = 0.0
    """mass fraction of the dry fuel"""
    ash_heat_capacity: HeatCapacity = 1000.0
    """of the ash that is fed and leaves; volatile matter has 1500 J/kg/K, char and
    moisture those of graphite and water, so that solids.NAME.heat_capacity counts for
    the mixing of heat alone"""
    volatile_matter: MinorFraction
    """mass fraction of the dry, ash-free fuel; the rest is fixed carbon"""
    ultimate: Ultimate
    heating_value: HeatingValue | None = None
    """higher, of the dry fuel; absent: by Channiwala and Parikh from the analysis"""
    char_density: Density = 800.0
    """of unburnt char"""
    char_diameter: Length | None = None
    """of unburnt char; absent: that of the solid phase"""
    char_model: Literal["shrinking", "density"] = "shrinking"
    """what burning does to a particle"""
    sherwood: Positive = 1.5
    """of char in the emulsion"""


class Limestone(Table):
    """Limestone, fed by solids.NAME.feed."""

    purity: PositiveShare = 1.0
    """mass fraction of CaCO3; the rest is inert"""


class Solid(SolidPhase):
    """One solid phase: particles with one temperature at a height."""

    varies: ClassVar[frozenset[str]] = frozenset({"heat_capacity", "conductivity"})

    volume_share: Share = 1.0
    """of the volume of all particles; 0: this phase is left out"""
    diameter: Length
    """Sauter mean, of spheres of the particles' volumes; or sizes"""
    sizes: Sizes | None = None
    sphericity: PositiveShare = 1.0
    """surface of such spheres over the true"""
    density: Density | None = None
    """needed with boundary.bottom.gas.mass_flow"""
    heat_capacity: HeatCapacityOfSolid | None = None
    """needed with boundary.bottom.gas.mass_flow"""
    conductivity: ConductivityOfSolid = 1.0
    """of the material"""
    emissivity: Emissivity | None = None
    """needed with [radiation]"""
    nusselt: Nusselt | None = None
    """of a particle in the gas of the emulsion; or gas_coefficient"""
    gas_coefficient: GasCoefficient | None = None
    """particle to the gas of the emulsion; or nusselt"""
    mixing_conductivity: ConductivityOrClosure = Field(
        json_schema_extra=takes("solids_mixing")
    )
    """of axial mixing, on the whole section, or a closure of the dispersion of the
    particles"""
    exchange: dict[str, ExchangeOrClosure] = Field(
        default_factory=dict, json_schema_extra=takes("solid_exchange")
    )
    """with other solid phases by name, per emulsion volume; each pair once"""
    feed: Feed | None = None
    release: Release | None = None
    fuel: Fuel | None = None
    """absent: it does not burn"""
    limestone: Limestone | None = None

    @model_validator(mode="before")
    @classmethod
    def _mean(cls, values: Any) -> Any:
        """Return the table with the mean diameter of its sizes."""
        sizes = values.get("sizes") if isinstance(values, dict) else None
        if sizes is None or "diameter" in values:
            return values
        table = Sizes.model_validate(sizes)
        shares = table.bed or table.feed or ()
        pairs = zip(shares, table.diameters, strict=True)
        return values | {"diameter": 1.0 / sum(x / d for x, d in pairs)}

    @model_validator(mode="after")
    def _one(self) -> Solid:
        if self.nusselt is not None and self.gas_coefficient is not None:
            given_one(self, "nusselt", "gas_coefficient")
        return self

    @property
    def fed_solids(self) -> float:
        """What its feed brings of particles that stay in the bed until they are carried
        away or drained: all of it, of a fuel its ash [kg/s].
        """
        fed = 0.0 if self.feed is None else self.feed.mass_flow or 0.0
        if self.fuel is None:
            return fed
        return fed * (1.0 - self.fuel.moisture) * self.fuel.ash

    @property
    def inert_feed(self) -> Feed | None:
        """The feed of particles that stay what they are."""
        reacts = self.fuel is not None or self.limestone is not None
        return None if reacts else self.feed
