"""State of one particle in a run, and what it has passed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from contbed.course.history import History


@dataclass(frozen=True, kw_only=True)
class ParticleHistory(History):
    """State of a particle and what it has passed.

    sums : heat conducted in, carried out, released [J/kg], gas that left; exchanged :
        heat both ways
    passed : time, mass and centre temperature of all stages
    """

    sums: Any
    exchanged: float = 0.0
    passed: tuple[tuple[float, float, float], ...]
