"""The symmetric equation of pressure, sum of coef (p - p_neighbour) = rhs, solved by policy.

In the order of the grid the matrix of a slender bed is a narrow band, which LAPACK factors faster than any iteration
converges. Where no boundary fixes the pressure, it is 0 in the first cell.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from contbed.errors import ConvergenceError
from contbed.two_fluid.compiled import kernel
from contbed.two_fluid.grid import Grid


@kernel
def _band(g, coef, floating, out):
    out[:] = 0.0
    for f in range(len(coef)):
        left = g.left[f]
        out[0, left] += coef[f]
        if f < len(g.right):
            right = g.right[f]
            out[0, right] += coef[f]
            out[right - left, left] -= coef[f] if right != left else 2.0 * coef[f]
    if floating:
        out[0, 0] *= 2.0


class Pressure:
    """Solver for one grid; `floating` where no outlet fixes the pressure."""

    def __init__(self, grid: Grid, floating: bool):
        self.geometry, self.floating = grid.geometry, floating
        self.band = np.zeros((grid.bandwidth + 1, len(grid.geometry.volume)), order="F")

    def solve(self, coef: np.ndarray, rhs: np.ndarray) -> np.ndarray:
        """Pressure (nc,) [Pa]."""
        _band(self.geometry, coef, self.floating, self.band)
        factor, failed = lapack.dpbtrf(self.band, lower=1, overwrite_ab=1)
        if failed:
            raise ConvergenceError("the equation of pressure is singular: a fluid region without inlet or outlet?")
        p, _ = lapack.dpbtrs(factor, rhs, lower=1)
        return p
