"""Direct solution of symmetric systems on the links of a grid, sum of coef (x - x_neighbour) = rhs.

Cells that are no neighbours of each other are eliminated first, each in a few operations, by which their neighbours
become linked. On quadrilaterals that is every other cell, and the rest is a band as wide as before, half as long.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.linalg import lapack
from scipy.sparse.csgraph import reverse_cuthill_mckee

from contbed.errors import SceneError
from contbed.two_fluid.compiled import kernel
from contbed.two_fluid.fv.grid import Geometry, Grid, neighbours
from contbed.two_fluid.linear import band as kb


class Elimination:
    """Elimination on one grid; a SceneError where neighbours are too far from each other in any order.

    gone (ne,) : cells that go first; start (ne + 1,), beside, faces : their neighbours and the faces between them
    kept (nb,) : the other cells in the order of the band; place (nc,) : of a cell in the band; width : of the band
    """

    def __init__(self, grid: Grid):
        count = len(grid.cells)
        start, beside, faces = neighbours(grid)
        first = _independent(start, beside)
        self.gone, rest = np.flatnonzero(first), np.flatnonzero(~first)
        mine = np.repeat(first, np.diff(start))
        self.start = np.concatenate(([0], np.cumsum(np.diff(start)[first])))
        self.beside, self.faces = beside[mine], faces[mine]

        links = sp.csr_matrix((np.ones(len(beside)), beside, start), (count, count))
        graph = links[rest][:, rest] + links[rest][:, self.gone] @ links[self.gone][:, rest]
        self.kept = rest[reverse_cuthill_mckee(graph.tocsr(), symmetric_mode=True)]
        self.place = np.zeros(count, dtype=np.int64)
        self.place[self.kept] = np.arange(len(self.kept))
        rows, columns = graph.nonzero()
        self.width = int(np.abs(self.place[rest[rows]] - self.place[rest[columns]]).max(initial=0))
        if self.width > kb.WIDEST:
            raise SceneError(f"mesh: a band of {self.width} cells, too wide for direct elimination; use fewer cells")
        rows = -(-len(self.kept) // kb.COLUMNS) * kb.COLUMNS
        self.band, self.diagonal = np.empty((rows, self.width + 1 + kb.MARGIN)), np.empty(count)
        self.panel = np.zeros(kb.COLUMNS * kb.STRIDE)

    def solve(self, g: Geometry, coef: np.ndarray, floating: bool, x: np.ndarray) -> bool:
        """Puts the solution in `x`, which holds the right-hand side; the diagonal of the first cell counts twice where
        the system is `floating`. False if the system is singular.
        """
        _eliminate(
            g, coef, floating, self.gone, self.start, self.beside, self.faces, self.place, self.diagonal, self.band, x
        )
        if not kb.factor(self.band, self.width, self.panel):
            return False
        x[self.kept] = lapack.dpbtrs(self.band[: len(self.kept)].T, x[self.kept], lower=1)[0]
        _substitute(coef, self.gone, self.start, self.beside, self.faces, self.diagonal, x)
        return True


@kernel
def _independent(start, beside):
    """Marks cells none of which is a neighbour of another, as many as come first; the last cell is left."""
    count = len(start) - 1
    chosen, taken = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    for c in range(count - 1):
        if not taken[c]:
            chosen[c] = True
            for j in range(start[c], start[c + 1]):
                taken[beside[j]] = True
    return chosen


@kernel
def _eliminate(g, coef, floating, gone, start, beside, faces, place, diagonal, band, x):
    """The band that is left without the cells `gone`, with ones to fill its last block, and its right-hand side."""
    ni = len(g.right)
    diagonal[:] = 0.0
    band[:] = 0.0
    for row in range(len(diagonal) - len(gone), len(band)):
        band[row, 0] = 1.0
    first = np.zeros(len(diagonal), dtype=np.bool_)
    for e in range(len(gone)):
        first[gone[e]] = True
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
                band[min(a, b), abs(a - b)] -= coef[f]
    if floating:
        diagonal[0] *= 2.0
    for c in range(len(diagonal)):
        if not first[c]:
            band[place[c], 0] += diagonal[c]
    for e in range(len(gone)):
        c = gone[e]
        for j in range(start[e], start[e + 1]):
            share = coef[faces[j]] / diagonal[c]
            x[beside[j]] += share * x[c]
            for k in range(j, start[e + 1]):
                a, b = place[beside[j]], place[beside[k]]
                band[min(a, b), abs(a - b)] -= share * coef[faces[k]] * (2.0 if a == b and j != k else 1.0)


@kernel
def _substitute(coef, gone, start, beside, faces, diagonal, x):
    """The values of the cells `gone` from those of their neighbours."""
    for e in range(len(gone)):
        for j in range(start[e], start[e + 1]):
            x[gone[e]] += coef[faces[j]] * x[beside[j]]
        x[gone[e]] /= diagonal[gone[e]]
