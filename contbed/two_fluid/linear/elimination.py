"""Direct solution of symmetric systems on the links of a grid, sum of coef
(x - x_neighbour) = rhs.

Cells that are no neighbours of each other are eliminated first, each in a few
operations, by which their neighbours become linked. On quadrilaterals that is every
other cell, and the rest is a band as wide as before, half as long.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.linalg import lapack
from scipy.sparse.csgraph import reverse_cuthill_mckee

from contbed.errors import SceneError
from contbed.two_fluid.compiled import Array, Flags, Indices, kernel
from contbed.two_fluid.fv.grid import Geometry, Grid, neighbours

WIDEST = 8184  # band [cells] of some 100,000 cells: a factor of 6 GB


class Order(NamedTuple):
    """In which order cells are eliminated.

    first (ne,) : cells that go first;
    start (ne + 1,), beside, faces : their neighbours and the faces between them
    place (nc,) : of the other cells in the band
    """

    first: Indices
    start: Indices
    beside: Indices
    faces: Indices
    place: Indices


class Elimination:
    """Elimination on one grid, with its workspace.

    order : of the cells; rest (nb,) : the cells of the band in its order; width : of
        the band
    factor (nb, width + 1), diagonal (nc,) : workspace; row j of the factor holds column
    j of the
        band from the diagonal downwards

    Raises
    ------
    SceneError : neighbours are too far from each other in any order
    """

    def __init__(self, grid: Grid):
        count = len(grid.cells)
        start, beside, faces = neighbours(grid)
        independent = _independent(start, beside)
        first, rest = np.flatnonzero(independent), np.flatnonzero(~independent)
        mine = np.repeat(independent, np.diff(start))
        starts = np.concatenate(([0], np.cumsum(np.diff(start)[independent])))

        links = sp.csr_matrix((np.ones(len(beside)), beside, start), (count, count))
        graph = links[rest][:, rest] + links[rest][:, first] @ links[first][:, rest]
        self.rest = rest[reverse_cuthill_mckee(graph.tocsr(), symmetric_mode=True)]
        place = np.zeros(count, dtype=np.int64)
        place[self.rest] = np.arange(len(self.rest))
        self.order = Order(first, starts, beside[mine], faces[mine], place)
        rows, columns = graph.nonzero()
        self.width = int(
            np.abs(place[rest[rows]] - place[rest[columns]]).max(initial=0)
        )
        if self.width > WIDEST:
            raise SceneError(
                f"mesh: a band of {self.width} cells, too wide for direct elimination; "
                "use fewer cells"
            )
        self.factor = np.empty((len(self.rest), self.width + 1))
        self.diagonal = np.empty(count)

    def solve(self, g: Geometry, coef: Array, floating: bool, x: Array) -> bool:
        """Put the solution in `x`, which holds the right-hand side; False if the system
        is singular.

        The diagonal of the first cell counts twice where the system is `floating`.
        """
        _eliminate(g, coef, floating, self.order, self.diagonal, self.factor, x)
        cholesky, failed = lapack.dpbtrf(self.factor.T, lower=1, overwrite_ab=1)
        if failed:
            return False
        x[self.rest] = lapack.dpbtrs(cholesky, x[self.rest], lower=1)[0]
        _substitute(coef, self.order, self.diagonal, x)
        return True


@kernel
def _independent(start: Indices, beside: Indices) -> Flags:
    """Mark cells none of which is a neighbour of another, as many as come first; the
    last cell is left.
    """
    count = len(start) - 1
    chosen, taken = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    for c in range(count - 1):
        if not taken[c]:
            chosen[c] = True
            for j in range(start[c], start[c + 1]):
                taken[beside[j]] = True
    return chosen


@kernel
def _eliminate(
    g: Geometry,
    coef: Array,
    floating: bool,
    order: Order,
    diagonal: Array,
    matrix: Array,
    x: Array,
) -> None:
    """Eliminate the first cells (Gauss): set the band `matrix` that is left, and its
    right-hand side `x`.
    """
    ni, place, beside, faces = len(g.right), order.place, order.beside, order.faces
    diagonal[:] = 0.0
    matrix[:] = 0.0
    first = np.zeros(len(diagonal), dtype=np.bool_)
    for e in range(len(order.first)):
        first[order.first[e]] = True
    for f in range(len(g.left)):
        left = g.left[f]
        if f >= ni:
            diagonal[left] += coef[f]
        elif g.right[f] != left:
            right = g.right[f]
            diagonal[left] += coef[f]
            diagonal[right] += coef[f]
            if not (first[left] or first[right]):
                a, b = place[left], place[right]
                matrix[min(a, b), abs(a - b)] -= coef[f]
    if floating:
        diagonal[0] *= 2.0
    for c in range(len(diagonal)):
        if not first[c]:
            matrix[place[c], 0] += diagonal[c]
    for e in range(len(order.first)):
        c = order.first[e]
        for j in range(order.start[e], order.start[e + 1]):
            share = coef[faces[j]] / diagonal[c]
            x[beside[j]] += share * x[c]
            for k in range(j, order.start[e + 1]):
                a, b = place[beside[j]], place[beside[k]]
                matrix[min(a, b), abs(a - b)] -= (
                    share * coef[faces[k]] * (2.0 if a == b and j != k else 1.0)
                )


@kernel
def _substitute(coef: Array, order: Order, diagonal: Array, x: Array) -> None:
    """Set the values of the first cells from those of their neighbours."""
    for e in range(len(order.first)):
        c = order.first[e]
        for j in range(order.start[e], order.start[e + 1]):
            x[c] += coef[order.faces[j]] * x[order.beside[j]]
        x[c] /= diagonal[c]
