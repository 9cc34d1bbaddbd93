"""The symmetric pressure equation, sum of coef (p - p_neighbour) = rhs, by elimination
or by multigrid.

In the order of the grid the matrix of a slender bed is a band, which elimination solves
faster than any iteration converges while it is narrow: its cost for each cell grows
with the square of the band, that of multigrid does not grow. Where no boundary fixes
the pressure, it is 0 in the first cell.

CPU of a whole step, chosen solver against the next best one: elimination 2.9 against
3.5 ms (lattice, riser of 15 x 350 cells) and 34 against 54 ms (aggregation, 21,600
triangles); lattice 11.2 against 12.8 ms (elimination, bed of 56 x 200 cells).
"""

from __future__ import annotations

from functools import cached_property
from typing import Protocol

from contbed.compiled import threads
from contbed.errors import ConvergenceError
from contbed.solvers.aggregation import Multigrid
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.linear.cg import System, solve
from contbed.two_fluid.linear.elimination import Elimination
from contbed.two_fluid.linear.lattice import build_levels
from contbed.two_fluid.linear.lattice_multigrid import LatticeMultigrid, solve_exchange

# cells, up to which elimination is faster than multigrid on the lattice, measured
WIDEST_BAND_OF_LATTICE = 40
# cells, up to which elimination is faster, measured in 2-D and 3-D:
# studies/two_fluid_scaling
WIDEST_BAND = 250
# cells from which exchange is solved for on the lattice, which several threads share:
# with one thread plain iterations take as long (56 x 200 cells, 11.4 ms of a step and
# 11.7 ms) or less (15 x 350 cells, 3.4 and 3.1 ms)
FEWEST_ON_LATTICE = 2 * threads.LEAST


def uses_elimination(grid: Grid) -> bool:
    """Whether the equation is solved by elimination."""
    return grid.bandwidth <= (
        WIDEST_BAND if grid.places is None else WIDEST_BAND_OF_LATTICE
    )


def multigrid_on(grid: Grid) -> Multigrid:
    """Multigrid by aggregation on any grid."""
    return Multigrid(grid.geometry.left, grid.geometry.right, len(grid.cells))


class SolvesPressure(Protocol):
    """What a step needs of a solver: of one rank or of several."""

    floating: bool
    iterations: int

    def solve(self, coef: Array, rhs: Array, guess: Array) -> Array:
        """Pressure (nc,) [Pa]; `guess` is where iterations start."""

    def solve_diffusion(
        self, system: System, explicit: float, tolerance: float, most: int, x: Array
    ) -> int:
        """Solve another symmetric system for `x` (nc, m), see linear/cg.py; return
        the iterations, -1 if too many.
        """


class PressureSolver:
    """Solver for one grid; `floating` where no outlet fixes the pressure.
    `iterations` of the last solution.
    """

    def __init__(self, grid: Grid, floating: bool):
        self.grid, self.floating, self.iterations = grid, floating, 0

    @cached_property
    def lattice(self) -> LatticeMultigrid | None:
        """Multigrid on the lattice of a rectangular grid."""
        levels = build_levels(self.grid)
        return None if levels is None else LatticeMultigrid(self.grid, levels)

    @cached_property
    def method(self) -> Elimination | Multigrid | LatticeMultigrid:
        """Elimination or multigrid; built for the first equation, as the root of
        several ranks solves none.
        """
        if uses_elimination(self.grid):
            return Elimination(self.grid)
        return multigrid_on(self.grid) if self.lattice is None else self.lattice

    def solve(self, coef: Array, rhs: Array, guess: Array) -> Array:
        """Pressure (nc,) [Pa]; `guess` is where iterations start."""
        if isinstance(self.method, Elimination):
            p = rhs.copy()
            if not self.method.solve(self.grid.geometry, coef, self.floating, p):
                raise ConvergenceError(
                    "the equation of pressure is singular: a fluid region without "
                    "inlet or outlet?"
                )
            return p
        p = guess.copy()
        self.iterations = self.method.solve(coef, self.floating, rhs, p)
        if self.iterations < 0:
            raise ConvergenceError(
                "the pressure equation did not converge; is a region without inlet and "
                "outlet?"
            )
        return p

    def solve_diffusion(
        self, system: System, explicit: float, tolerance: float, most: int, x: Array
    ) -> int:
        """Solve another symmetric system for `x` (nc, m), see linear/cg.py; return
        the iterations, -1 if too many.
        """
        if len(self.grid.cells) < FEWEST_ON_LATTICE or self.lattice is None:
            return solve(self.grid.geometry, system, explicit, tolerance, most, x)
        return solve_exchange(self.lattice, system.T, explicit, tolerance, most, x.T)
