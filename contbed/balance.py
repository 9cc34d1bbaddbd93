"""Balance of a conserved quantity: what entered, left, was released inside and was
stored, and the residual.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

# share of what a bed holds, heat above 0 K in streams and solids or emission of medium
# and walls, below which rounding blurs a balance: rounding is 1e-13 of it
# (test_computed_flow_conserves_and_keeps_a_uniform_temperature) and the default
# tolerance 1e-10, which leaves a factor of three; where more crosses or is released,
# that is the measure
HELD_SHARE = 3e-3


@dataclass(frozen=True)
class Balance:
    """Amounts in `unit`: rates of a steady state, or totals of a run; each is positive
    in the direction of its name.

    scale : reference of the residual; the largest of the four parts if None
    floor : least scale, so that rounding of large stores does not count against small
        streams
    """

    entering: float
    leaving: float
    unit: str
    source: float = 0.0
    stored: float = 0.0
    scale: float | None = None
    floor: float = 1e-300

    @classmethod
    def of_fluxes(
        cls,
        fluxes: Iterable[float],
        unit: str,
        source: float = 0.0,
        stored: float = 0.0,
        floor: float = 1e-300,
        both_ways: float | None = None,
    ) -> Balance:
        """Return the balance of fluxes that are positive inwards.

        Of totals over time, `both_ways` is the sum of the integrals of their
        magnitudes: what enters is then not offset by what leaves there later.
        """
        parts = list(fluxes)
        entering = sum(value for value in parts if value > 0)
        leaving = -sum(value for value in parts if value < 0)
        if both_ways is not None:
            returned = max(0.5 * (both_ways - entering - leaving), 0.0)
            entering, leaving = entering + returned, leaving + returned
        return cls(entering, leaving, unit, source, stored, floor=max(floor, 1e-300))

    @property
    def relative_residual(self) -> float:
        """Entering and released less leaving and stored, over the scale."""
        largest = max(
            abs(self.entering), abs(self.leaving), abs(self.source), abs(self.stored)
        )
        scale = max(largest if self.scale is None else self.scale, self.floor)
        return (self.entering + self.source - self.leaving - self.stored) / scale

    def as_dict(self) -> dict[str, Any]:
        """Return the balance as written to summary.json."""
        return {
            "in": self.entering,
            "out": self.leaving,
            "source": self.source,
            "stored": self.stored,
            "relative_residual": self.relative_residual,
            "unit": self.unit,
        }
