"""Table [reactions] of a bubbling bed, which needs boundary.bottom.gas.mass_flow.

Gas enters with gas.composition. Drying, release of volatiles, char and limestone have
tables of their own; all other names are reactions of gases, by a rate law or an
equation as in every model. A reaction whose table is absent does not run, and a gas
that neither enters nor is made by any reaction is no unknown.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from contbed.chemistry.char_and_lime import CHAR_LAWS
from contbed.scene.quantities import (
    Positive,
    PositiveShare,
    Seconds,
    Table,
    unit,
)
from contbed.scene.reactions import Reaction

Factor = Positive


class Timed(Table):
    """A release of first order."""

    time: Seconds
    """mean time in a particle"""


class CharReaction(Table):
    """A reaction of char."""

    law: str | None = None
    """rate law by name; absent: the first of the list"""
    factor: Factor = 1.0
    """multiplies the rate"""


class CharCombustion(CharReaction):
    """Char with O2."""

    products: Literal["arthur", "CO2", "CO"] = "CO2"
    """at the particle; CO2 where CO burns in its film, particles of 1 mm and more"""


class Calcination(Table):
    """CaCO3 to CaO and back."""

    factor: Factor = 1.0
    """factor on the rate"""


class Sulphation(Table):
    """CaO with SO2 and O2 to CaSO4."""

    factor: Factor = 1.0
    """factor on the rate"""
    maximum_conversion: PositiveShare = 0.4
    """of CaO, when its pores are full"""


class SulphateReduction(Table):
    """CaSO4 with CO to CaO, SO2 and CO2, up to equilibrium; measured constants
    differ, so there is no default.
    """

    rate_constant: Annotated[float, *unit("1/Pa/s"), Field(gt=0)]
    """of sulphate at 850 degC, per pressure of CO; measured, or fitted to a boiler"""


class Reactions(Table):
    """Reactions that run."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Reaction] = Field(init=False)

    drying: Timed | None = None
    devolatilisation: Timed | None = None
    char_combustion: CharCombustion | None = None
    char_steam: CharReaction | None = None
    char_CO2: CharReaction | None = None
    char_H2: CharReaction | None = None
    calcination: Calcination | None = None
    sulphation: Sulphation | None = None
    sulphate_reduction: SulphateReduction | None = None

    @property
    def of_gases(self) -> dict[str, Reaction]:
        """Those of gases, by name."""
        return dict(self.__pydantic_extra__ or {})

    @property
    def of_char(self) -> dict[str, Reaction]:
        """Those of char."""
        return {
            name: item
            for name in CHAR_LAWS
            if (item := getattr(self, name)) is not None
        }
