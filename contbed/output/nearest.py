"""Values in a plane through a cloud of points, from the nearest of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contbed.arrays import Array, Integers

NEAR = 4  # points from which a value is taken
# distance over the extent of the points below which a place counts as one of them
COINCIDENT = 1e-12


@dataclass(frozen=True)
class Nearest:
    """The `NEAR` nearest points of each place, with the inverse of their distance as
    weight: arrays (places, NEAR).
    """

    numbers: Integers
    weight: Array
    distance: Array

    @classmethod
    def of(cls, points: Array, places: Array) -> Nearest:
        """Look for the points (n, 3) next to places (m, 3) [m]."""
        from scipy.spatial import cKDTree

        distance, numbers = cKDTree(points).query(places, k=NEAR)
        return cls(
            numbers, 1.0 / np.maximum(distance, COINCIDENT * np.ptp(points)), distance
        )

    def __call__(self, values: Array) -> Array:
        """Return the weighted mean (m,) of values at the points (n,)."""
        found: Array = (self.weight * values[self.numbers]).sum(
            axis=1
        ) / self.weight.sum(axis=1)
        return found
