"""Functions that all materials share: polynomials that work on dual numbers, and
checks of ranges.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from contbed.errors import SceneError

Range = tuple[float, float]

R_GAS = 8.31446261815324  # [J/mol/K]
FAR = 100.0  # [K] from its data a polynomial may take any value
ROUNDING = 1e-9  # relative excess of a temperature that is no more than rounding


def polynomial(coefficients: Sequence[float], x: Any) -> Any:
    """Evaluate a0 + a1 x + a2 x^2 + ... by Horner's rule; the float a0 when there is
    nothing else.
    """
    result: Any = coefficients[-1]
    for a in coefficients[-2::-1]:
        result = result * x + a
    return result


def integrated(
    coefficients: Sequence[float], constant: float = 0.0
) -> tuple[float, ...]:
    """Return the coefficients of the integral of a polynomial, `constant` at x = 0."""
    return (constant, *(a / (n + 1) for n, a in enumerate(coefficients)))


def share_outside(T: Any, T_range: Range) -> float:
    """Return the share of the points of T outside the inclusive range by more than
    rounding.

    nan counts as outside.
    """
    lo, hi = T_range
    inside = np.asarray((lo * (1 - ROUNDING) <= T) & (hi * (1 + ROUNDING) >= T))
    return 1.0 - float(np.count_nonzero(inside)) / inside.size if inside.size else 0.0


def extrapolation(
    name: str, heat_capacity: Callable[[float], Any], T_range: Range, T: Any
) -> str:
    """Return a warning on temperatures [K] outside of the data of a material, with the
    change of its heat capacity there; empty where all lie inside.
    """
    low, high = T_range
    coldest, hottest = float(np.min(T)), float(np.max(T))
    end, edge = (coldest, low) if low - coldest > hottest - high else (hottest, high)
    if abs(end - edge) <= ROUNDING * edge or low <= end <= high:
        return ""
    change = float(heat_capacity(end)) / float(heat_capacity(edge)) - 1.0
    text = (
        f"{name}: data from {low:g} to {high:g} K are extrapolated to {end:.6g} K, where "
        f"the heat capacity differs by {abs(change):.2%} from that at {edge:g} K"
    )
    if change == 0.0:
        text = (
            f"{name}: data from {low:g} to {high:g} K are used at {end:.6g} K with the "
            f"values at {edge:g} K"
        )
    far = abs(end - edge) > FAR
    return text + (f"; more than {FAR:g} K away they are not reliable" if far else "")


def checked_range(T_range: Sequence[float], what: str) -> Range:
    """Return the range as two floats; raise SceneError if it is none."""
    lo, hi = (float(T) for T in T_range)
    if not 0.0 <= lo < hi:
        raise SceneError(
            f"{what}: T_range ({lo:g}, {hi:g}) K must rise and not start below 0 K; "
            "correct the ends"
        )
    return lo, hi


def checked_positive(value: float, what: str, unit: str) -> float:
    """Return the value as a float; raise SceneError if it is not positive."""
    number = float(value)
    if not (number > 0.0 and math.isfinite(number)):
        raise SceneError(f"{what} is {number:g} {unit}; it must be positive and finite")
    return number


def nearest(name: str, known: Iterable[str]) -> str:
    """Return ' (nearest: a, b)' for an error message; nothing when no known name is
    close.
    """
    by_lower = {k.lower(): k for k in known}
    close = difflib.get_close_matches(name.lower(), by_lower, n=3, cutoff=0.5)
    return f" (nearest: {', '.join(by_lower[c] for c in close)})" if close else ""
