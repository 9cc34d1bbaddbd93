"""Matrices of a line, with few diagonals beside the main one: products by BLAS and
factors by LAPACK.

Products and solutions of some hundred unknowns cost microseconds, a tenth of what
general sparse matrices take.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg.blas import dgbmv
from scipy.linalg.lapack import dgbtrf, dgbtrs
from scipy.sparse.csgraph import reverse_cuthill_mckee

from contbed.arrays import Array, Integers
from contbed.errors import ConvergenceError

# diagonals on each side up to which a band is cheaper than general factors; two fields
# of degree 3 have 13
WIDEST = 24


@dataclass(frozen=True)
class Band:
    """A square matrix with `width` diagonals on each side: data (2 width + 1, n),
    the main diagonal in row `width`.
    """

    width: int
    data: Array

    def __matmul__(self, x: Array) -> Array:
        size = self.data.shape[1]
        product: Array = dgbmv(size, size, self.width, self.width, 1.0, self.data, x)
        return product

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.data[0])

    def plus(self, other: Band, factor: float) -> Band:
        """Return this matrix plus `factor` times the other."""
        return Band(self.width, self.data + factor * other.data)

    def solver(self, fixed: Integers) -> Callable[[Array], Array]:
        """Return the solution for a right-hand side; rows and columns of `fixed`
        unknowns are those of the identity.

        Raises
        ------
        ConvergenceError : the matrix is singular or holds values that are not finite
        """
        width, size = self.width, self.data.shape[1]
        wide = np.zeros((3 * width + 1, size), order="F")
        wide[width:] = self.data
        # entry (i, j) stands in row width + (i - j)
        for offset in range(-width, width + 1):
            rows = fixed + offset
            inside = (rows >= 0) & (rows < size)
            # row i: columns j = i + offset
            wide[2 * width - offset, rows[inside]] = 0.0
            wide[2 * width + offset, fixed[inside]] = 0.0  # column j
        wide[2 * width, fixed] = 1.0
        if not np.isfinite(wide).all():
            raise ConvergenceError(
                "the matrix holds values that are not finite: check closures and "
                "initial values"
            )
        factors, pivots, info = dgbtrf(wide, width, width)
        if info:
            raise ConvergenceError(
                "the linear system is singular: is a temperature or the pressure fixed "
                "anywhere?"
            )
        return partial(_solve, factors, pivots, width)


def _solve(factors: Array, pivots: Any, width: int, rhs: Array) -> Array:
    solution: Array = dgbtrs(factors, width, width, rhs, pivots)[0]
    return solution


@dataclass(frozen=True)
class Ordering:
    """An order of the unknowns, `order[new] = old`, in which a matrix has `width`
    diagonals on each side.
    """

    order: Integers
    back: Integers
    width: int

    @classmethod
    def of(cls, matrix: sp.csc_matrix) -> Ordering | None:
        """Return the order by reverse Cuthill and McKee, or None if it leaves a wide
        band or nothing outside of it.
        """
        pattern = (abs(matrix) + abs(matrix).T).tocsr()
        order = reverse_cuthill_mckee(pattern, symmetric_mode=True).astype(np.int64)
        back = np.empty_like(order)
        back[order] = np.arange(len(order))
        entries = pattern.tocoo()
        width = int(np.abs(back[entries.row] - back[entries.col]).max(initial=0))
        return (
            cls(order, back, width)
            if width <= WIDEST and 2 * width + 1 <= len(order)
            else None
        )

    def followed_by(self, count: int) -> Ordering:
        """Return the order of these unknowns and of as many more behind them."""
        more = len(self.order) + np.arange(count)
        return Ordering(
            np.concatenate([self.order, more]),
            np.concatenate([self.back, more]),
            self.width,
        )

    def band(self, matrix: sp.csc_matrix) -> Band:
        """Return a matrix of the same pattern in this order."""
        entries = matrix.tocoo()
        filled = entries.data != 0.0  # what cancelled to 0 may lie outside
        row, column = self.back[entries.row[filled]], self.back[entries.col[filled]]
        data = np.zeros((2 * self.width + 1, matrix.shape[0]), order="F")
        np.add.at(data, (self.width + row - column, column), entries.data[filled])
        return Band(self.width, data)
