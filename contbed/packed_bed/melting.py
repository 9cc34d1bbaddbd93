"""Steady states of solids that melt while they move, from a wide range of melting to the
given one.

The enthalpy of a solid that moves rises steeply where it melts, and Newton's method
finds the place only from a state near by. Melting over all temperatures of the scene is
mild; its range is made narrower, by equal factors as long as Newton's method follows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contbed.errors import ConvergenceError
from contbed.materials.curve import LatentHeat

# of the way, by the logarithm of the width
FIRST_STEP = 0.25
SHORTEST_STEP = 2.0**-8
GROWTH = 1.5


def narrowed(
    latent: LatentHeat,
    span: tuple[float, float],
    solve: Callable[[Any], Any],
    start: Any,
) -> Any:
    """Return the state for the range of melting that a scene gives.

    Parameters
    ----------
    span : lowest and highest temperature of the scene [K], between which it melts at
        first
    solve : finds the steady state from one near by, for the present range
    start : where to begin

    Raises
    ------
    ConvergenceError : the state cannot be followed
    """
    given = latent.start, latent.end
    left, step = 1.0, FIRST_STEP
    try:
        latent.spread = span
        state = solve(start)
        while left > 0.0:
            wanted = max(left - step, 0.0)
            latent.spread = _between(given, span, wanted)
            try:
                state = solve(state)
            except ConvergenceError:
                step /= 2.0
                if step < SHORTEST_STEP:
                    raise
                continue
            left, step = wanted, GROWTH * step
        return state
    finally:
        latent.spread = None


def _between(
    narrow: tuple[float, float], wide: tuple[float, float], share: float
) -> tuple[float, float]:
    """Return the range that is a share of the way from a narrow to a wide one."""
    least, most = narrow[1] - narrow[0], wide[1] - wide[0]
    width = least * (most / least) ** share
    moved = (width - least) / (most - least)
    low, high = (
        (1.0 - moved) * a + moved * b for a, b in zip(narrow, wide, strict=True)
    )
    return low, high
