"""Sizes of spheres: random radii about a mean, and the Sauter mean that stands for
them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contbed.arrays import Array

CUT = 2.0  # standard deviations at which the normal distribution of radii is cut


def random_radii(mean: float, spread: float, count: int, seed: int) -> Array:
    """Draw radii [m], (count,), normal about a mean with a standard deviation over
    it, cut at two; the same by seed.
    """
    if spread == 0.0:
        return np.full(count, mean)
    from scipy.special import ndtr, ndtri

    drawn = np.random.default_rng(seed).uniform(ndtr(-CUT), ndtr(CUT), count)
    return np.asarray(mean * (1.0 + spread * ndtri(drawn)))


def sauter_mean(size: ArrayLike) -> float:
    """Return the size [m] of a sphere with the ratio of volume to surface of all
    particles together.
    """
    size = np.asarray(size, dtype=float)
    return float((size**3).sum() / (size**2).sum())
