"""Iterative solution of symmetric systems on the links of cells of any shape, sum of
coef (x - x_neighbour) = rhs.

Conjugate gradients, preconditioned by aggregation: cells are joined twice in pairs
along their strongest links, so that no aggregate reaches across a jump of the
coefficients, and a coarse system has the sums of the links between aggregates and so
the same form. Two steps of conjugate gradients on each coarse level (K-cycle: Notay,
Electron. Trans. Numer. Anal. 37 (2010) 123) make the number of iterations all but
independent of the number of cells. The aggregates follow from the coefficients alone:
nothing is kept from step to step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array
from contbed.compiled.functions import entry, inner

Indices = NDArray[np.int64]

OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "nogil": True}
COARSEST = 60  # cells of a level that is solved directly
# share of the strongest link of a cell from which on it is joined along a link (Notay
# 2010)
STRONG_CONNECTION = 0.25
# residual after one step on a coarse level above which there is a second one (Notay
# 2010)
SECOND_STEP = 0.25
# residual over the largest right-hand side; what is left of the divergence of the flux
TOLERANCE = 1e-11
ROUNDING = 1e-16  # residual over the largest term, where the right-hand side is zero
MAX_ITERATIONS = 100  # of one system


class Level(NamedTuple):
    """One system.

    Neighbours `beside` and links `value` of a cell from start[c] to start[c + 1], its
    diagonal, and its number on the next level.
    """

    start: Indices
    beside: Indices
    value: Array
    diagonal: Array
    group: Indices


class Multigrid:
    """Iterations on one grid.

    Parameters
    ----------
    left (nf,), right (ni,) : cells of the faces; the first ni faces lie between two cells, the others at a boundary
    count : cells
    """

    def __init__(self, left: Indices, right: Indices, count: int):
        interior = len(right)
        self.start, self.beside, self.faces = neighbours_by_cell(
            left[:interior], right, count
        )
        self.boundary_cells = left[interior:]

    def solve(
        self,
        coef: Array,
        floating: bool,
        rhs: Array,
        x: Array,
        tolerance: float = TOLERANCE,
    ) -> int:
        """Put the solution in `x`, which holds a guess; return the number of
        iterations, -1 without convergence.

        The diagonal of the first cell counts twice where the system is `floating`. A
        cell without links gets its right-hand side. `tolerance` is the largest residual
        over the largest right-hand side.
        """
        value, rest = coef[self.faces], np.zeros(len(x))
        np.add.at(
            rest, self.boundary_cells, coef[len(coef) - len(self.boundary_cells) :]
        )
        if floating:
            rest[0] += rest[0] + value[self.start[0] : self.start[1]].sum()
        if not np.isfinite(coef.sum() + rhs.sum()):
            return -1
        found: int = _solve(self.start, self.beside, value, rest, rhs, x, tolerance)
        return found


def neighbours_by_cell(
    left: Indices, right: Indices, count: int
) -> tuple[Indices, Indices, Indices]:
    """Start (count + 1,), cells, faces : neighbours of cell c from start[c] to
    start[c + 1], and the faces between.
    """
    # a periodic row of one cell links with itself
    other = np.flatnonzero(left != right)
    ends = (
        np.concatenate((left[other], right[other])),
        np.concatenate((right[other], left[other])),
    )
    order = np.argsort(ends[0], kind="stable")
    start = np.searchsorted(ends[0][order], np.arange(count + 1))
    return start, ends[1][order], np.concatenate((other, other))[order]


@inner(**OPTIONS)
def _pairs(start: Indices, beside: Indices, value: Array) -> tuple[Indices, int]:
    """Return the number of the pair of each cell, and of pairs; without a strong
    link to a free cell it is alone, and all cells without any link are one group.
    """
    count = len(start) - 1
    group, found, apart = np.full(count, -1), 0, -1
    for c in range(count):
        if group[c] >= 0:
            continue
        strongest, best, partner = 0.0, 0.0, -1
        for j in range(start[c], start[c + 1]):
            strongest = max(strongest, value[j])
            if group[beside[j]] < 0 and value[j] > best:
                best, partner = value[j], beside[j]
        if strongest == 0.0:
            # smoothing solves them exactly; apart they would never become few
            if apart < 0:
                apart, found = found, found + 1
            group[c] = apart
            continue
        group[c] = found
        if best >= STRONG_CONNECTION * strongest and partner >= 0:
            group[partner] = found
        found += 1
    return group, found


@inner(**OPTIONS)
def _joined(
    start: Indices,
    beside: Indices,
    value: Array,
    rest: Array,
    group: Indices,
    found: int,
) -> tuple[Indices, Indices, Array, Array]:
    """Return the coarse system of groups."""
    count = len(group)
    members, first = (
        np.empty(count, dtype=np.int64),
        np.zeros(found + 1, dtype=np.int64),
    )
    for c in range(count):
        first[group[c] + 1] += 1
    first = np.cumsum(first)
    filled = first[:-1].copy()
    for c in range(count):
        members[filled[group[c]]] = c
        filled[group[c]] += 1
    new_start, new_rest = np.zeros(found + 1, dtype=np.int64), np.zeros(found)
    new_beside, new_value = np.empty(len(beside), dtype=np.int64), np.empty(len(beside))
    seen, end = np.full(found, -1), 0
    for i in range(found):
        begin = end
        for m in range(first[i], first[i + 1]):
            c = members[m]
            new_rest[i] += rest[c]
            for j in range(start[c], start[c + 1]):
                other = group[beside[j]]
                if other == i:
                    continue
                if seen[other] < begin:
                    seen[other] = end
                    new_beside[end], new_value[end] = other, 0.0
                    end += 1
                new_value[seen[other]] += value[j]
        new_start[i + 1] = end
    return new_start, new_beside[:end].copy(), new_value[:end].copy(), new_rest


@inner(**OPTIONS)
def _product(level: Level, x: Array, out: Array) -> None:
    """Matrix of a level times x."""
    start, beside, value, diagonal = (
        level.start,
        level.beside,
        level.value,
        level.diagonal,
    )
    for c in range(len(x)):
        total = diagonal[c] * x[c]
        for j in range(start[c], start[c + 1]):
            total -= value[j] * x[beside[j]]
        out[c] = total


@inner(**OPTIONS)
def _sweep(level: Level, b: Array, x: Array, backwards: bool) -> None:
    """Gauss-Seidel over all cells."""
    start, beside, value, diagonal = (
        level.start,
        level.beside,
        level.value,
        level.diagonal,
    )
    for i in range(len(x)):
        c = len(x) - 1 - i if backwards else i
        total = b[c]
        for j in range(start[c], start[c + 1]):
            total += value[j] * x[beside[j]]
        x[c] = total / diagonal[c]


@inner(**OPTIONS)
def _cycle(
    levels: list[Level],
    inverse: NDArray[np.floating[Any]],
    b: list[Array],
    x: list[Array],
    first: list[Array],
    along: list[Array],
    q: list[Array],
) -> None:
    """One K-cycle (Notay 2010): approximate solution x[0] for the right-hand side b[0].

    Each list holds one vector for each level. A level is smoothed by Gauss-Seidel,
    corrected from the next coarser one and smoothed again. On coarse levels the result
    is the direction of one step of conjugate gradients, or of two where the residual is
    above SECOND_STEP. `first` and `along` keep the first direction and the matrix times
    it, `q` is a workspace, `down` is true on the way to the coarsest level.
    """
    last, at, down = len(levels) - 1, 0, True
    again, rho, alpha = (
        np.zeros(last + 1, dtype=np.bool_),
        np.zeros(last + 1),
        np.zeros(last + 1),
    )
    while True:
        if down and at < last:
            x[at][:] = 0.0
            _sweep(levels[at], b[at], x[at], False)
            _product(levels[at], x[at], q[at])
            group, at = levels[at].group, at + 1
            b[at][:] = 0.0
            for c in range(len(group)):
                b[at][group[c]] += b[at - 1][c] - q[at - 1][c]
            again[at] = False
            continue
        if down:
            x[at][:] = inverse @ b[at]
        elif at > 0:
            _product(levels[at], x[at], q[at])
            slope = np.dot(x[at], b[at])
            if again[at]:
                both = np.dot(x[at], along[at])
                part = slope / (np.dot(x[at], q[at]) - both * both / rho[at])
                x[at][:] = (
                    part * x[at] + (alpha[at] - both * part) / rho[at] * first[at]
                )
            else:
                rho[at], alpha[at], size = (
                    np.dot(x[at], q[at]),
                    slope,
                    np.dot(b[at], b[at]),
                )
                if rho[at] > 0.0:
                    first[at][:], along[at][:] = x[at], q[at]
                    b[at][:] -= slope / rho[at] * q[at]
                    if np.dot(b[at], b[at]) > SECOND_STEP**2 * size:
                        again[at] = down = True
                        continue
                    x[at][:] *= slope / rho[at]
        if at == 0:
            return
        group, at, down = levels[at - 1].group, at - 1, False
        for c in range(len(group)):
            x[at][c] += x[at + 1][group[c]]
        _sweep(levels[at], b[at], x[at], True)


@inner(**OPTIONS)
def _levels(start: Indices, beside: Indices, value: Array, rest: Array) -> list[Level]:
    """All levels, each with half or a quarter of the cells of the one before; the
    cells of the last are not joined.
    """
    levels = []
    while True:
        diagonal = rest.copy()
        for c in range(len(rest)):
            for j in range(start[c], start[c + 1]):
                diagonal[c] += value[j]
            if diagonal[c] == 0.0:
                diagonal[c] = 1.0
        if len(rest) <= COARSEST:
            levels.append(
                Level(start, beside, value, diagonal, np.zeros(0, dtype=np.int64))
            )
            return levels
        group, found = _pairs(start, beside, value)
        middle = _joined(start, beside, value, rest, group, found)
        pair, found = _pairs(middle[0], middle[1], middle[2])
        levels.append(Level(start, beside, value, diagonal, pair[group]))
        start, beside, value, rest = _joined(
            middle[0], middle[1], middle[2], middle[3], pair, found
        )


@entry(**OPTIONS)
def _solve(
    start: Indices,
    beside: Indices,
    value: Array,
    rest: Array,
    rhs: Array,
    x: Array,
    tolerance: float,
) -> int:
    """Solution in `x`; the number of iterations, -1 if too many."""
    levels = _levels(start, beside, value, rest)
    start, beside, value, diagonal = (
        levels[-1].start,
        levels[-1].beside,
        levels[-1].value,
        levels[-1].diagonal,
    )
    matrix = np.diag(diagonal)
    for c in range(len(diagonal)):
        for j in range(start[c], start[c + 1]):
            matrix[c, beside[j]] -= value[j]
    inverse = np.linalg.inv(matrix)
    b, z, first, along, q = [
        [np.empty(len(level.diagonal)) for level in levels] for _ in range(5)
    ]

    least = tolerance * np.max(np.abs(rhs)) + ROUNDING * np.max(
        np.abs(levels[0].diagonal * x)
    )
    p, product, before, rho = np.zeros(len(x)), np.empty(len(x)), np.empty(len(x)), 1.0
    _product(levels[0], x, product)
    r = rhs - product
    for iteration in range(MAX_ITERATIONS):
        if np.max(np.abs(r)) <= least:
            return iteration
        b[0][:] = r
        _cycle(levels, inverse, b, z, first, along, q)
        slope = np.dot(z[0], r)
        p = z[0] + ((slope - np.dot(z[0], before)) / rho if iteration > 0 else 0.0) * p
        _product(levels[0], p, product)
        alpha, rho = slope / np.dot(p, product), slope
        before[:] = r
        x += alpha * p
        r -= alpha * product
    return -1
