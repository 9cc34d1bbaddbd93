"""Which combinations of keys the data see: singular values of the scaled derivatives,
and profiles of the likelihood.

The derivatives of the predictions over their standard errors, with keys scaled by their
priors, have a singular value for each of as many combinations of keys: the standard
deviation of its prior over that which the data leave by themselves. Below 1 the data
determine the combination less well than the prior does.

The profile of a key is the sum of squares with the key held and all others fitted
again. The interval holds the values at which it is above its minimum by less than the
quantile of chi-square with one degree of freedom (Raue et al. 2009,
doi:10.1093/bioinformatics/btp358). Unlike the covariance it follows curved dependences,
and shows where a key has no upper or lower end but that of its prior.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contbed.arrays import Array
from contbed.errors import ConvergenceError
from contbed.many.calibrate.fit import TOLERANCE, Fit, Problem, Solution, least_squares

SEEN = 1.0  # singular value above which the data determine more than the prior
NAMED = 0.2  # component of a combination below which a key is not named
# relative difference from the quantile at which an end of an interval is found
CLOSE = 0.02
MOST_STEPS = 8  # of the search for an end
MOST_RATIO = 3.0  # of one step of the search to the one before


@dataclass(frozen=True)
class Combination:
    """A combination of scaled keys, shape (keys,) with length 1, and its singular
    value.
    """

    weights: Array
    singular: float

    @property
    def seen(self) -> bool:
        """Whether the data determine the combination better than its prior."""
        return self.singular > SEEN

    def named(self, names: Sequence[str]) -> str:
        """Return the combination in words, largest part first."""
        order = [
            int(k)
            for k in np.argsort(-np.abs(self.weights))
            if abs(self.weights[k]) >= NAMED
        ]
        sign = math.copysign(1.0, self.weights[order[0]])
        parts = [f"{sign * self.weights[k]:+.2f} {names[k]}" for k in order]
        return " ".join(parts).removeprefix("+")


@dataclass(frozen=True)
class Interval:
    """Ends of an interval of a scaled key; `open_low`, `open_high`: the end is that of
    the prior, or of the search.

    curve : points of the profile, (points, 2): scaled key, and rise of the sum of
        squares over its minimum
    """

    low: float
    high: float
    open_low: bool
    open_high: bool
    curve: Array


def combinations(problem: Problem, found: Fit) -> list[Combination]:
    """Return the combinations of keys from the best to the least seen."""
    scaled = problem.scaled(found.slopes, found.factor)
    _, singular, weights = np.linalg.svd(scaled, full_matrices=False)
    return [
        Combination(weight, float(value))
        for weight, value in zip(weights, singular, strict=True)
    ]


def profile(problem: Problem, found: Fit, key: int) -> Interval:
    """Return the interval of a key by its profile; runs that fail end the search
    with an open end.
    """
    rows: list[tuple[float, float]] = [(float(found.z[key]), 0.0)]
    residuals = problem.residuals(found.predicted, found.factor)
    own = found.z[problem.normal]
    base = float(residuals @ residuals + own @ own)
    (low, open_low), (high, open_high) = (
        _end(problem, found, key, side, base, rows) for side in (-1.0, 1.0)
    )
    return Interval(low, high, open_low, open_high, np.array(sorted(rows)))


def _end(
    problem: Problem,
    found: Fit,
    key: int,
    side: float,
    base: float,
    rows: list[tuple[float, float]],
) -> tuple[float, bool]:
    """Return one end of the interval, and whether it is open.

    The root of the rise is close to straight in the key, so that the secant through the
    fitted point finds the end.
    """
    bound = problem.ends[int(side > 0.0), key]
    room = abs(bound - found.z[key])
    step = min(found.quantile * math.sqrt(found.covariance[key, key]), room)
    path = found.covariance[:, key] / found.covariance[key, key]
    low_step, solution = 0.0, None
    for _ in range(MOST_STEPS):
        if room < TOLERANCE:
            return float(bound), True
        solution = _refit(problem, found, key, side * step * path)
        if solution is None:
            return float(found.z[key] + side * low_step), True
        rise = max(2.0 * solution.cost - base, 0.0)
        rows.append((float(solution.z[key]), rise))
        ratio = math.sqrt(rise) / found.quantile
        if abs(ratio - 1.0) < CLOSE or (step == room and ratio < 1.0):
            return float(solution.z[key]), ratio < 1.0 - CLOSE
        if ratio < 1.0:
            low_step = max(low_step, step)
        step = min(step * min(MOST_RATIO, 1.0 / max(ratio, 1.0 / MOST_RATIO)), room)
    assert solution is not None, "there is at least one step"
    return float(solution.z[key]), True


def _refit(problem: Problem, found: Fit, key: int, move: Array) -> Solution | None:
    """Fit the other keys with all moved and one held; None if the runs fail there."""
    z = np.clip(found.z + move, *problem.ends)
    try:
        return least_squares(problem, z, found.factor, held=(key,))
    except (ConvergenceError, ValueError):  # scipy refuses to begin where a run failed
        return None
