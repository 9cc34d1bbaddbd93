"""The pressure equation on ranks by PETSc: conjugate gradients with algebraic multigrid
(GAMG).

The matrix has the own cells of a rank as rows. Its places are found once; a step puts
its numbers there.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.errors import ConvergenceError
from contbed.ranks.two_fluid.cg import solve_on_ranks
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.linear.cg import System

# residual over the right-hand side [-]; what is left of the divergence of the flux, and
# the most by which results on different numbers of ranks differ (test_ranks_agree)
TOLERANCE = 1e-13
# residual over the terms of the equations [-] that rounding leaves; where the fluxes
# balance without a pressure, or on a long line, it is more than TOLERANCE of the
# right-hand side (check case "crossing")
ROUNDING = 1e-15
MAX_ITERATIONS, ATTEMPTS = 150, 2
OPTIONS: dict[str, Any] = {
    "ksp_type": "cg",
    "ksp_rtol": TOLERANCE,
    "ksp_max_it": MAX_ITERATIONS,
    # the residual of a guess may be any multiple of the right-hand side, which is next
    # to nothing where fluxes balance
    "ksp_divtol": 1e30,
    "ksp_norm_type": "unpreconditioned",
    "pc_type": "gamg",
    # symmetric, as conjugate gradients need
    "mg_levels_ksp_type": "chebyshev",
    "mg_levels_pc_type": "jacobi",
}


class PetscPressure:
    """Solver for one rank's part; `floating` where no outlet fixes the pressure, which
    is then 0 in the first cell.

    Attributes
    ----------
    iterations : of the last solution
    """

    def __init__(self, grid: Grid, floating: bool, has_first_cell: bool, comm: Any):
        from petsc4py import PETSc

        g, halo = grid.geometry, grid.halo
        self.grid, self.floating, self.pinned, self.iterations = (
            grid,
            floating,
            floating and has_first_cell,
            0,
        )
        owned: int = halo.cells.stop
        first = comm.exscan(owned) or 0
        numbers = np.zeros(len(grid.cells))
        numbers[halo.cells] = first + np.arange(owned)
        halo.exchange(numbers)
        left, right = g.left[: grid.interior], g.right
        there = np.flatnonzero(left != right)
        links = [there[left[there] < owned], there[right[there] < owned]]
        self.faces = np.concatenate(links)
        self.rows = np.concatenate((left[links[0]], right[links[1]]))
        beside = np.concatenate((right[links[0]], left[links[1]]))
        # entries: links, then the diagonal; two faces between the same cells share a
        # place
        rows = np.concatenate((self.rows, np.arange(owned)))
        columns = numbers[np.concatenate((beside, np.arange(owned)))].astype(np.int32)
        width = int(numbers.max()) + 1
        keys, self.place = np.unique(rows * width + columns, return_inverse=True)
        self.own_edges = np.flatnonzero(g.left[grid.interior :] < owned)
        self.edge_cells = g.left[grid.interior :][self.own_edges]
        starts = np.searchsorted(keys // width, np.arange(owned + 1))
        self.pattern = starts.astype(np.int32), (keys % width).astype(np.int32)
        local = (owned, PETSc.DECIDE)
        self.matrix = PETSc.Mat().createAIJ(
            (local, local), csr=(*self.pattern, np.ones(len(keys))), comm=comm
        )
        self.matrix.setOption(PETSc.Mat.Option.SPD, True)
        self.ksp, self.owned = PETSc.KSP().create(comm), owned
        self.ksp.setOptionsPrefix("contbed_pressure_")
        options = PETSc.Options("contbed_pressure_")
        for name, value in OPTIONS.items():
            options[name] = value
        self.ksp.setOperators(self.matrix)
        self.ksp.setFromOptions()
        self.ksp.setInitialGuessNonzero(True)
        self.x, self.b = self.matrix.createVecs()

    def solve(self, coef: Array, rhs: Array, guess: Array) -> Array:
        """Pressure (nc,) [Pa], in ghost cells too; `guess` is where iterations start.

        Raises
        ------
        ConvergenceError : too many iterations
        """
        owned, interior = self.owned, self.grid.interior
        values = coef[self.faces]
        diagonal = np.bincount(self.rows, values, owned)
        diagonal += np.bincount(self.edge_cells, coef[interior:][self.own_edges], owned)
        if self.pinned:
            diagonal[0] *= 2.0
        entries = np.bincount(self.place, np.concatenate((-values, diagonal)))
        self.matrix.setValuesCSR(*self.pattern, entries)
        self.matrix.assemble()
        self.ksp.setOperators(self.matrix)
        self.b.array[:], self.x.array[:] = rhs[:owned], guess[:owned]
        self.iterations = 0
        for _ in range(ATTEMPTS):
            # the largest terms are known with the pressure, which the first guess may
            # be far from
            (square,) = self.grid.halo.sum(
                float(np.sum((diagonal * self.x.array) ** 2))
            )
            self.ksp.setTolerances(atol=ROUNDING * np.sqrt(square))
            self.ksp.solve(self.b, self.x)
            self.iterations += self.ksp.getIterationNumber()
            if self.ksp.getConvergedReason() > 0:
                break
        else:
            raise ConvergenceError(
                "the pressure equation did not converge; is a region without inlet and "
                "outlet?"
            )
        p = np.empty_like(guess)
        p[:owned] = self.x.array
        self.grid.halo.exchange(p)
        return p

    def solve_diffusion(
        self, system: System, explicit: float, tolerance: float, most: int, x: Array
    ) -> int:
        """Solve another symmetric system for `x` (nc, m), see cg.py; return the
        iterations, -1 if too many.
        """
        return solve_on_ranks(self.grid, system, explicit, tolerance, most, x)
