"""Steady states of solids that melt while they move, from a wide range of melting to the
given one.

The enthalpy of a solid that moves rises steeply where it melts, and Newton's method
finds the place only from a nearby state. Melting over all temperatures of the scene is
mild; its range is then narrowed in steps that Newton's method follows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contbed.materials.curve import LatentHeat
from contbed.solvers.continuation import from_easier


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
    solve : finds the steady state from a nearby one, for the present range
    start : where to begin

    Raises
    ------
    ConvergenceError : the state cannot be followed
    """
    given = latent.start, latent.end

    def at(left: float, state: Any) -> Any:
        latent.spread = _between(given, span, left)
        return solve(state)

    try:
        return from_easier(at, start)
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
