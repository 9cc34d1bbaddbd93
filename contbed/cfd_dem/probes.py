"""Probes: pressure and solids volume fraction at points of the bed, row by row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from contbed.arrays import Array, Integers
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid

FIELDS = ("p [Pa]", "eps_s [1]")


class Probes(NamedTuple):
    """Named points with the eight cells around each of them, (n, 8), and the weights of
    trilinear interpolation.

    Between a wall and the centres of the cells beside it the values are those of the
    centres.
    """

    names: tuple[str, ...]
    cells: Integers
    weight: Array

    @property
    def columns(self) -> list[str]:
        """Headers: the name of the probe before that of the field."""
        return [f"{name} {field}" for name in self.names for field in FIELDS]

    def row(self, gas: Gas) -> list[float]:
        """Values under the `columns`."""
        fields = np.stack([gas.p, 1.0 - gas.eps], axis=1)
        return [
            float(v)
            for v in np.einsum("pk,pkf->pf", self.weight, fields[self.cells]).ravel()
        ]


def probes_of(grid: Grid, points: Mapping[str, Sequence[float]]) -> Probes:
    """Find the cells around points [m] and the weights on them."""
    count = np.array(grid.count)
    cells = np.zeros((len(points), 8), np.int64)
    weight = np.ones((len(points), 8))
    for n, point in enumerate(points.values()):
        place = np.clip(
            (np.asarray(point) - grid.lower) / grid.size - 0.5, 0.0, count - 1.0
        )
        low = np.minimum(place.astype(np.int64), np.maximum(count - 2, 0))
        for corner in range(8):
            upper = np.array([corner // 4, corner // 2 % 2, corner % 2])
            share = place - low
            weight[n, corner] = np.prod(np.where(upper == 1, share, 1.0 - share))
            cells[n, corner] = np.ravel_multi_index(
                tuple(np.minimum(low + upper, count - 1)), grid.count
            )
    return Probes(tuple(points), cells, weight)
