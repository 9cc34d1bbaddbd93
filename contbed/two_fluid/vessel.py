"""Volume of a vessel by height, for results per cross-section where that may vary.

Between straight walls the volume rises linearly. Elsewhere each cell spreads its volume
evenly over the heights of its faces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.compiled import Array
from contbed.two_fluid.fv.grid import Grid

# cosine between a wall and the vertical, and share of the height, that count as 0
LEVEL = 1e-6


class Vessel(NamedTuple):
    """Heights (n,) above the floor [m], and the volumes (n,) below them; in a plane per
    metre of depth, on a line per square metre.
    """

    heights: Array
    volumes: Array

    @classmethod
    def of(cls, grid: Grid) -> Vessel:
        """Return the vessel that a grid fills."""
        if is_straight(grid):
            height = float(np.ptp(grid.spans))
            total = float(grid.geometry.volume.sum())
            return cls(np.array([0.0, height]), np.array([0.0, total]))
        heights, areas = _sections(grid, grid.geometry.volume)
        volumes = np.cumsum(areas * np.diff(heights))
        return cls(heights - heights[0], np.append(0.0, volumes))

    def below(self, height: Array) -> Array:
        """Return the volumes (n,) below heights (n,) above the floor [m]."""
        return np.interp(height, self.heights, self.volumes)

    def height_of(self, volume: float) -> float:
        """Return the height above the floor [m] below which there is a volume."""
        return float(np.interp(volume, self.volumes, self.heights))

    def section(self, height: float | None = None) -> float:
        """Return the mean cross-section below a height above the floor [m], or of the
        whole.
        """
        if height is None:
            return float(self.volumes[-1] / self.heights[-1])
        return float(self.below(np.array(height)) / height)


def is_straight(grid: Grid) -> bool:
    """Whether every wall between the ends is vertical."""
    edge = slice(grid.interior, None)
    height, margin = grid.middles[edge, -1], LEVEL * np.ptp(grid.spans)
    between = (height > grid.spans.min() + margin) & (
        height < grid.spans.max() - margin
    )
    upright = np.abs(grid.geometry.normal[edge, -1]) < LEVEL
    return bool(upright[between].all())


def depth(grid: Grid, eps_s: Array) -> float:
    """Return the integral of the mean solids fraction of each height over the
    heights [m]: the volume of the particles over the section of a straight vessel.
    """
    solids = eps_s * grid.geometry.volume
    if is_straight(grid):
        return float(solids.sum()) / Vessel.of(grid).section()
    heights, areas = _sections(grid, grid.geometry.volume)
    share = _sections(grid, solids)[1] / areas
    return float(share @ np.diff(heights))


def _sections(grid: Grid, amounts: Array) -> tuple[Array, Array]:
    """Return heights (n,) [m] at which cells begin or end, and how much of the amounts
    (nc,) of the cells there is per height between them (n - 1,).
    """
    low, high = grid.spans.T
    rate = amounts / (high - low)
    heights, place = np.unique(np.concatenate((low, high)), return_inverse=True)
    jumps = np.bincount(place, np.concatenate((rate, -rate))).astype(np.float64)
    areas: Array = np.cumsum(jumps)[:-1]
    return np.asarray(heights), areas
