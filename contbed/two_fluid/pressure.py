"""The symmetric equation of pressure, sum of coef (p - p_neighbour) = rhs, solved by policy.

In the order of the grid the matrix of a slender bed is a narrow band, which direct elimination solves faster than any
iteration converges. Where no boundary fixes the pressure, it is 0 in the first cell.
"""

from __future__ import annotations

import numpy as np

from contbed.errors import ConvergenceError
from contbed.two_fluid.elimination import Elimination
from contbed.two_fluid.grid import Grid


class Pressure:
    """Solver for one grid; `floating` where no outlet fixes the pressure."""

    def __init__(self, grid: Grid, floating: bool):
        self.geometry, self.floating = grid.geometry, floating
        self.direct = Elimination(grid)

    def solve(self, coef: np.ndarray, rhs: np.ndarray) -> np.ndarray:
        """Pressure (nc,) [Pa]."""
        p = rhs.copy()
        if not self.direct.solve(self.geometry, coef, self.floating, p):
            raise ConvergenceError("the equation of pressure is singular: a fluid region without inlet or outlet?")
        return p
