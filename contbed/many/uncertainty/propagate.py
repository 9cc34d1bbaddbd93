"""Mean, standard deviation and band of results of uncertain parameters: from samples,
and to first order by gradients.

To first order a result is f(m) + sum f_k (x_k - m_k) with the means m of the
parameters, so that its mean is f(m) and its variance the sum of (f_k s_k)^2 with their
standard deviations s_k; exact where the result is linear. Its band is that of a normal
distribution.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from contbed.arrays import Array, Flags
from contbed.many.distributions import Distribution

COVERAGE = 0.90  # of the band
LEAST_VALUES = 2  # that have a standard deviation


@dataclass(frozen=True)
class Spread:
    """How a result is distributed, in SI.

    low, high : ends of the band; mean_error : standard error of the mean, 0 where it is
        none of sampling
    runs : that it took
    """

    estimator: str
    mean: float
    deviation: float
    low: float
    high: float
    mean_error: float
    runs: int


def of_sample(values: Array) -> Spread | None:
    """Return the spread of sampled values, shape (runs,); runs without a value are
    left out. None if too few have.
    """
    kept = values[np.isfinite(values)]
    if len(kept) < LEAST_VALUES:
        return None
    tail = 0.5 * (1.0 - COVERAGE)
    low, high = np.quantile(kept, (tail, 1.0 - tail))
    scaled, exponent = of_size_one(kept)
    deviation = math.ldexp(float(scaled.std(ddof=1)), exponent)
    error = deviation / math.sqrt(len(kept))
    return Spread(
        "samples",
        float(kept.mean()),
        deviation,
        float(low),
        float(high),
        error,
        len(kept),
    )


def of_size_one(values: Array) -> tuple[Array, int]:
    """Return values over a power of 2, the largest below 1 in size, and its exponent.

    Squares of values such as mole fractions of 1e-200 are no numbers of a computer.
    """
    exponent = math.frexp(float(np.abs(values).max(initial=0.0)))[1]
    return np.ldexp(values, -exponent), exponent


def first_order(
    value: float, slopes: Array, distributions: Mapping[str, Distribution], runs: int
) -> Spread:
    """Return the spread to first order.

    Parameters
    ----------
    value : of the result at the means of the parameters
    slopes : derivatives with respect to the parameters in SI, shape (parameters,)
    """
    from scipy.special import ndtri

    deviation = float(np.linalg.norm(contributions(slopes, distributions)))
    half = float(ndtri(0.5 * (1.0 + COVERAGE))) * deviation
    return Spread("gradients", value, deviation, value - half, value + half, 0.0, runs)


def contributions(slopes: Array, distributions: Mapping[str, Distribution]) -> Array:
    """Return the standard deviations of a result that each parameter causes, shape
    (parameters,).
    """
    return np.asarray(
        slopes * np.array([spread.deviation for spread in distributions.values()])
    )


def independent(method: str, points: Array) -> Flags:
    """Return which points of a design are a sample of the parameters, shape (runs,).

    Of the groups of Sobol indices these are the first and the last; a Morris design has
    ends and levels only.
    """
    rows = np.ones(len(points), dtype=bool)
    if method == "sobol_indices":
        place = np.arange(len(points)) % (points.shape[1] + 2)
        rows = (place == 0) | (place == points.shape[1] + 1)
    return rows if method != "morris" else np.zeros(len(points), dtype=bool)
