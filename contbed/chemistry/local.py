"""The state at points of the bed as a reaction sees it, and how sharp its powers are
where nothing is left.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from contbed.chemistry.thermo import R_GAS

# share of a solid that is left, below which powers of it are straight lines
FINEST = 1e-7


class Smoothing(NamedTuple):
    """Shares below which powers between 0 and 1 are straight lines.

    solids : of a solid that is left, in laws with a name; amounts : of all gases or
        solids, in orders and formulas
    """

    solids: float = FINEST
    amounts: float = 0.0


SHARPEST = Smoothing()


@dataclass(frozen=True)
class Local:
    """State at points of the bed, as a reaction sees it."""

    T: Any  # of the phase that reacts [K]
    p: Any  # [Pa]
    c: Mapping[str, Any]  # of gases [mol/m3]
    x: Mapping[str, Any]  # mole fractions
    n: Mapping[str, Any]  # of solids [mol/m3 bed]
    eps: float
    solids: float  # volume of the particles that react per volume of bed
    radius: float  # of a particle [m]
    catalyst: float  # mass of particles per volume of bed [kg/m3]
    films: Mapping[str, Any]  # coefficient of each gas [m/s]; empty without films
    small: Smoothing = SHARPEST

    @property
    def all_gases(self) -> Any:
        """Concentration of all gases [mol/m3]."""
        return self.p / (R_GAS * self.T)

    @property
    def all_solids(self) -> Any:
        """Moles of all solids [mol/m3 bed]."""
        return sum(self.n.values())


Rate = Callable[[Local], Any]
