"""Tables of a reacting bubbling bed: [fuel], [limestone], [drain], [reactions.NAME]; they need gas.mass_flow.

Gas enters with gas.composition. A reaction whose table is absent does not run, and a gas that neither enters nor is
made by any reaction is no unknown.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from contbed.closures.reactions import LAWS
from contbed.closures.reactions_solid import CHAR_LAWS
from contbed.scene.quantities import Density, Length, Number, Position, Table, Temperature, unit

Mass = Annotated[float, *unit("kg/s"), Field(gt=0)]
MassFraction = Annotated[Number, Field(ge=0, le=1)]
HeatingValue = Annotated[float, *unit("J/kg"), Field(gt=0)]
Seconds = Annotated[float, *unit("s"), Field(gt=0)]
Factor = Annotated[Number, Field(gt=0)]


class SolidsFeed(Table):
    """Particles that enter around a height, Gaussian."""

    mass_flow: Mass = Field(description="as received")
    temperature: Temperature = Field(description="temperature of the solids that enter")
    height: Annotated[Position, Field(ge=0)] = Field(
        description="height above the distributor at which the solids enter"
    )
    width: Length = Field(description="standard deviation; what it puts beyond the ends enters inside")


class Ultimate(Table):
    """Mass fractions of the dry fuel; with ash they sum to one."""

    C: MassFraction = Field(description="mass fraction of carbon in the dry, ash-free fuel")
    H: MassFraction = Field(description="mass fraction of hydrogen in the dry, ash-free fuel")
    O: MassFraction = Field(description="mass fraction of oxygen in the dry, ash-free fuel")  # noqa: E741
    N: MassFraction = Field(0.0, description="mass fraction of nitrogen in the dry, ash-free fuel")
    S: MassFraction = Field(0.0, description="mass fraction of sulphur in the dry, ash-free fuel")


class Fuel(Table):
    """A solid fuel that becomes one of the species of particles."""

    species: str = Field(description="the [species.NAME] that it is")
    feed: SolidsFeed
    moisture: Annotated[Number, Field(ge=0, lt=1)] = Field(0.0, description="mass fraction as received")
    ash: Annotated[Number, Field(ge=0, lt=1)] = Field(0.0, description="mass fraction of the dry fuel")
    volatile_matter: Annotated[Number, Field(ge=0, lt=1)] = Field(
        description="mass fraction of the dry, ash-free fuel; the rest is fixed carbon"
    )
    ultimate: Ultimate
    heating_value: HeatingValue | None = Field(
        None, description="higher, of the dry fuel; absent: by Channiwala and Parikh from the analysis"
    )
    char_density: Density = Field(800.0, description="of unburnt char")
    char_diameter: Length | None = Field(None, description="of unburnt char; absent: that of the species")
    char_model: Literal["shrinking", "density"] = Field("shrinking", description="what burning does to a particle")
    sherwood: Annotated[Number, Field(gt=0)] = Field(1.5, description="of char in the emulsion")


class Limestone(Table):
    """Limestone that becomes one of the species of particles."""

    species: str = Field(description="the [species.NAME] that it is")
    feed: SolidsFeed
    purity: Annotated[Number, Field(gt=0, le=1)] = Field(1.0, description="mass fraction of CaCO3; the rest is inert")


class Drain(Table):
    """Bed material that leaves at one end with what char and limestone it holds."""

    time: Seconds = Field(description="residence time of the bed, its solids over what is drained")
    end: Literal["top", "bottom"] = Field("top", description="end of the bed where the solids leave")


class Timed(Table):
    """A release of first order."""

    time: Seconds = Field(description="mean time in a particle")


class Reaction(Table):
    """A reaction with a rate law."""

    law: str | None = Field(None, description="rate law by name; absent: the first of the list")
    factor: Factor = Field(1.0, description="multiplies the rate")


class CharCombustion(Reaction):
    """Char with O2."""

    products: Literal["arthur", "CO2", "CO"] = Field(
        "CO2", description="at the particle; CO2 where CO burns in its film, particles of 1 mm and more"
    )


class Calcination(Table):
    """CaCO3 to CaO and back."""

    factor: Factor = Field(1.0, description="factor on the rate")


class Sulphation(Table):
    """CaO with SO2 and O2 to CaSO4."""

    factor: Factor = Field(1.0, description="factor on the rate")
    maximum_conversion: Annotated[Number, Field(gt=0, le=1)] = Field(0.4, description="of CaO, when its pores are full")


class SulphateReduction(Table):
    """CaSO4 with CO to CaO, SO2 and CO2, up to equilibrium; measured constants differ, so there is no default."""

    rate_constant: Annotated[float, *unit("1/Pa/s"), Field(gt=0)] = Field(
        description="of sulphate at 850 degC, per pressure of CO; measured, or fitted to a boiler"
    )


class Reactions(Table):
    """Reactions that run."""

    mixing_time: Annotated[float, *unit("s"), Field(ge=0)] = Field(
        1e-3, description="of gases, which burn no faster than they mix"
    )
    drying: Timed | None = None
    devolatilisation: Timed | None = None
    char_combustion: CharCombustion | None = None
    char_steam: Reaction | None = None
    char_CO2: Reaction | None = None
    char_H2: Reaction | None = None
    CO_oxidation: Reaction | None = None
    H2_oxidation: Reaction | None = None
    CH4_oxidation: Reaction | None = None
    tar_oxidation: Reaction | None = None
    H2S_oxidation: Reaction | None = None
    water_gas_shift: Reaction | None = None
    reforming: Reaction | None = None
    calcination: Calcination | None = None
    sulphation: Sulphation | None = None
    sulphate_reduction: SulphateReduction | None = None

    @property
    def homogeneous(self) -> dict[str, Reaction]:
        """Those within the gas."""
        return {name: item for name in LAWS if (item := getattr(self, name)) is not None}

    @property
    def of_char(self) -> dict[str, Reaction]:
        """Those of char."""
        return {name: item for name in CHAR_LAWS if (item := getattr(self, name)) is not None}
