"""Velocities of particles across the bed at several heights, averaged over the samples
of a run.

Particles count whose centres are within one cell of the gas above or below the height,
in the column of cells along x that they are in. Averages are those over particles: the
speed of the particles, not that of their mean motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from contbed.arrays import Array
from contbed.cfd_dem.grid import Grid
from contbed.dem.simulation import Simulation


class Levels:
    """Sums over particles at heights [m], `sums` (heights, columns, 3): their
    number, speeds and upward velocities.
    """

    def __init__(self, grid: Grid, heights: Sequence[float]):
        self.grid, self.heights = grid, tuple(heights)
        self.sums: Array = np.zeros((len(self.heights), grid.count[0], 3))

    def __call__(self, simulation: Simulation) -> None:
        """Take the particles as they are now into the averages."""
        x, velocity, grid = simulation.position, simulation.velocity, self.grid
        count = grid.count[0]
        for sums, height in zip(self.sums, self.heights, strict=True):
            near = np.abs(x[:, 2] - height) <= grid.size[2]
            column = np.clip(
                (x[near, 0] - grid.lower[0]) / grid.size[0], 0, count - 1
            ).astype(np.int64)
            speed, up = np.linalg.norm(velocity[near], axis=1), velocity[near, 2]
            for k, weight in enumerate((np.ones(len(column)), speed, up)):
                sums[:, k] += np.bincount(column, weight, count)

    def table(self) -> dict[str, Array]:
        """Return the columns of levels.csv; a column of cells that no particle
        passed has no row.
        """
        level, column = np.nonzero(self.sums[..., 0])
        number, speed, up = self.sums[level, column].T
        return {
            "height [m]": np.array(self.heights)[level],
            "x [m]": self.grid.lower[0] + (column + 0.5) * self.grid.size[0],
            "speed_solid [m/s]": speed / number,
            "u_solid [m/s]": up / number,
        }

    def state(self) -> dict[str, Array]:
        """Return the sums for a checkpoint."""
        return {"levels": self.sums}

    def restore(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays of `state`."""
        self.sums = state["levels"].copy()
