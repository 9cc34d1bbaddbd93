"""Tables [solids.NAME] of a bubbling bed, with fuel and limestone, in SI."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

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
    Length,
    NonNegative,
    Number,
    Position,
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
MassFraction = Annotated[Number, Field(ge=0, le=1)]
MinorFraction = Annotated[Number, Field(ge=0, lt=1)]
MassFlow = Annotated[float, *unit("kg/s"), Field(ge=0)]
Nusselt = Annotated[NamedOrFile, Discriminator(form)]


class Feed(Table):
    """Particles that enter around a height, Gaussian, and leave the bed at one end."""

    capacity_flow: CapacityFlow | None = Field(
        None, description="with boundary.bottom.gas.capacity_flow"
    )
    mass_flow: MassFlow | None = Field(
        None,
        description="with boundary.bottom.gas.mass_flow; of fuel and limestone as "
        "received",
    )
    temperature: Temperature = Field(description="of the particles that enter")
    height: Annotated[Position, Field(ge=0)] = Field(
        description="above the distributor, around which they enter"
    )
    width: Length = Field(
        description="standard deviation; what it puts beyond the ends enters inside"
    )
    drain: Literal["top", "bottom"] = Field(
        "top",
        description="end where particles leave that are neither fuel nor limestone",
    )


class Sizes(Table):
    """Sizes of one solid phase: those fed, or those in the bed.

    The first need [bubbling_bed.freeboard] with a height.
    """

    diameters: Annotated[tuple[Length, ...], Field(min_length=2)] = Field(
        description="of the sizes"
    )
    feed: tuple[NonNegative, ...] | None = Field(
        None, description="mass fractions, which sum to one"
    )
    bed: tuple[NonNegative, ...] | None = Field(None, description="instead of `feed`")

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

    C: MassFraction = Field(description="of carbon")
    H: MassFraction = Field(description="of hydrogen")
    O: MassFraction = Field(description="of oxygen")  # noqa: E741
    N: MassFraction = Field(0.0, description="of nitrogen")
    S: MassFraction = Field(0.0, description="of sulphur")


class Fuel(Table):
    """A solid fuel, fed by solids.NAME.feed."""

    moisture: MinorFraction = Field(0.0, description="mass fraction as received")
    ash: MinorFraction = Field(0.0, description="mass fraction of the dry fuel")
    volatile_matter: MinorFraction = Field(
        description="mass fraction of the dry, ash-free fuel; the rest is fixed carbon"
    )
    ultimate: Ultimate
    heating_value: HeatingValue | None = Field(
        None,
        description="higher, of the dry fuel; absent: by Channiwala and Parikh from "
        "the analysis",
    )
    char_density: Density = Field(800.0, description="of unburnt char")
    char_diameter: Length | None = Field(
        None, description="of unburnt char; absent: that of the solid phase"
    )
    char_model: Literal["shrinking", "density"] = Field(
        "shrinking", description="what burning does to a particle"
    )
    sherwood: Annotated[Number, Field(gt=0)] = Field(
        1.5, description="of char in the emulsion"
    )


class Limestone(Table):
    """Limestone, fed by solids.NAME.feed."""

    purity: Annotated[Number, Field(gt=0, le=1)] = Field(
        1.0, description="mass fraction of CaCO3; the rest is inert"
    )


class Solid(SolidPhase):
    """One solid phase: particles with one temperature at a height."""

    varies: ClassVar[frozenset[str]] = frozenset({"heat_capacity", "conductivity"})

    volume_share: Annotated[Number, Field(ge=0, le=1)] = Field(
        1.0, description="of the volume of all particles; 0: this phase is left out"
    )
    diameter: Length = Field(
        description="Sauter mean, of spheres of the particles' volumes; or sizes"
    )
    sizes: Sizes | None = None
    sphericity: Annotated[Number, Field(gt=0, le=1)] = Field(
        1.0, description="surface of such spheres over the true"
    )
    density: Density | None = Field(
        None, description="needed with boundary.bottom.gas.mass_flow"
    )
    heat_capacity: HeatCapacityOfSolid | None = Field(
        None, description="needed with boundary.bottom.gas.mass_flow"
    )
    conductivity: ConductivityOfSolid = Field(1.0, description="of the material")
    emissivity: Emissivity | None = Field(None, description="needed with [radiation]")
    nusselt: Nusselt | None = Field(
        None, description="of a particle in the gas of the emulsion; or gas_coefficient"
    )
    gas_coefficient: GasCoefficient | None = Field(
        None, description="particle to the gas of the emulsion; or nusselt"
    )
    mixing_conductivity: ConductivityOrClosure = Field(
        description="of axial mixing, on the whole section, or a closure of the "
        "dispersion of the particles",
        json_schema_extra=takes("solids_mixing"),
    )
    exchange: dict[str, ExchangeOrClosure] = Field(
        default_factory=dict,
        description="with other solid phases by name, per emulsion volume; each pair "
        "once",
        json_schema_extra=takes("solid_exchange"),
    )
    feed: Feed | None = None
    release: Release | None = None
    fuel: Fuel | None = Field(None, description="absent: it does not burn")
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
    def inert_feed(self) -> Feed | None:
        """The feed of particles that stay what they are."""
        reacts = self.fuel is not None or self.limestone is not None
        return None if reacts else self.feed
