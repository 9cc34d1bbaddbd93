"""State of one particle in a run, and what it has passed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from contbed.course.history import History

Passed = tuple[float, float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class ParticleHistory(History):
    """State of a particle and what it has passed.

    sums : heat conducted in, carried out, released [J/kg], gas that left; exchanged :
        heat both ways
    passed : of all stages the time, mass, centre temperature, the temperature above
        start and surroundings, and the largest difference between neighbouring shells
    """

    sums: Any
    exchanged: float = 0.0
    passed: tuple[Passed, ...]
