"""Pressure equation of the gas, sum over faces of conductance (p - p_beyond) = source,
with p = 0 beyond outlets.

Solved by conjugate gradients with multigrid by aggregation, which knows no axes: sides
may be periodic, and cells may hold no gas. It takes 3 to 8 % of a run.
"""

from __future__ import annotations

import numpy as np

from contbed.arrays import Array
from contbed.cfd_dem.grid import OUTLET, Grid
from contbed.solvers.aggregation import Multigrid


class Pressure:
    """The equation on one grid."""

    def __init__(self, grid: Grid):
        low, high = grid.face_cell.T
        between = np.flatnonzero((low >= 0) & (high >= 0))
        outlets = np.flatnonzero(grid.face_kind == OUTLET)
        self._faces = np.concatenate((between, outlets))
        cells = np.concatenate((low[between], np.maximum(low, high)[outlets]))
        self._multigrid = Multigrid(cells, high[between], grid.cells)

    def solve(
        self, guess: Array, conductance: Array, source: Array, tolerance: float
    ) -> tuple[Array, int]:
        """Solve for the pressure of the cells.

        Parameters
        ----------
        guess : of the pressure (c,) [Pa]
        conductance : of the faces (f,) [m3/s/Pa]; 0 where no velocity is solved for
        source : right-hand side (c,) [m3/s]
        tolerance : largest residual over the largest right-hand side

        Returns
        -------
        pressure (c,) [Pa], number of iterations, -1 without convergence
        """
        p = guess.copy()
        iterations = self._multigrid.solve(
            conductance[self._faces], False, source, p, tolerance
        )
        return p, iterations
