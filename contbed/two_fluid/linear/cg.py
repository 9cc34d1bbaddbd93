"""Symmetric systems content x + sum over faces of coef (x - x_neighbour) = rhs, with m
unknowns in each cell.

Most cells exchange little in a step: there the exchange, already in rhs as it is at the
start of the step, need not be solved for. Only stiff cells and their neighbours are, as
one smaller system; a link between two cells is solved for in both or in none, so that
what one cell loses the other one gets. The method is conjugate gradients with the
inverse diagonal as preconditioner (Hestenes and Stiefel 1952, J. Res. Natl. Bur. Stand.
49, 409-436).
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np

from contbed.two_fluid.compiled import Array, Indices, inner, kernel, summing
from contbed.two_fluid.fv.grid import Geometry

# cells that are not solved for, that lie beside a stiff one, that are
QUIET, BESIDE, STIFF = 0, 1, 2
# exchange of a cell in a step over its content up to which it is not solved for
EXPLICIT_SHARE = 0.1


class System(NamedTuple):
    """One system for m unknowns in each cell.

    coef (nf, m) : links of faces; those of boundary faces couple with given values
    links (nc, m) : further links of cells to given values; `solve` adds those of their
        faces
    content (nc, m) : diagonal
    rhs (nc, m) : right-hand side
    """

    coef: Array
    links: Array
    content: Array
    rhs: Array

    @property
    def T(self) -> System:
        """The system by component, for kernels over rows."""
        return System(*(part.T for part in self))


def empty_system(
    g: Geometry, components: int, order: Literal["C", "F"] = "C"
) -> System:
    """Make a system without links of cells, in the memory `order` of the grid; the
    rest is not set.
    """
    size = (len(g.volume), components)
    coef = np.empty((len(g.left), components), order=order)
    return System(
        coef,
        np.zeros(size, order=order),
        np.empty(size, order=order),
        np.empty(size, order=order),
    )


@kernel
def add_links(g: Geometry, system: System) -> None:
    """Add the links of faces to those of their cells."""
    coef, links, ni = system.coef, system.links, len(g.right)
    for f in range(len(g.left)):
        for k in range(coef.shape[1]):
            links[g.left[f], k] += coef[f, k]
            if f < ni:
                links[g.right[f], k] += coef[f, k]


@kernel
def solve(
    g: Geometry, system: System, explicit: float, tolerance: float, most: int, x: Array
) -> int:
    """Solve for `x` (nc, m); return the most iterations that a component took, -1 if
    too many.

    explicit : links of a cell over its content above which it is stiff
    tolerance : of the residual, relative in the norm of the inverse diagonal
    """
    coef, links, content, rhs = system.coef, system.links, system.content, system.rhs
    count = len(content)
    add_links(g, system)
    state, found = np.zeros(count, dtype=np.int8), False
    for c in range(count):
        for k in range(coef.shape[1]):
            x[c, k] = rhs[c, k] / content[c, k]
            if links[c, k] > explicit * content[c, k]:
                state[c] = STIFF
                found = True
    if not found:
        return 0
    mark_neighbours(g, state)
    rows = rows_of(g, state)
    longest = 0
    for k in range(coef.shape[1]):
        scale, target = scale_of(g, system, k, rows), np.empty(len(rows.cells))
        for i in range(len(target)):
            target[i] = scale[i] * rhs[rows.cells[i], k]
        values = values_of(coef, k, rows, scale)
        iterations = _conjugate_gradients(
            g.axes, rows.column, values, target, tolerance, most
        )
        if iterations < 0:
            return -1
        longest = max(longest, iterations)
        for i in range(len(target)):
            x[rows.cells[i], k] = scale[i] * target[i]
    return longest


class Rows(NamedTuple):
    """The system of n cells that are solved for.

    rank (nc,) : number of each cell in it, -1 where it has none
    cells (n,) : the cell of each number
    column, face (n, m) : numbers of the neighbours of each row and the faces to them,
        its own number in place of a missing neighbour
    """

    rank: Any
    cells: Indices
    column: Any
    face: Any


@kernel
def mark_neighbours(g: Geometry, state: Any) -> None:
    """Mark the quiet neighbours of stiff cells in `state` (nc,)."""
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        if state[left] == STIFF and state[right] == QUIET:
            state[right] = BESIDE
        elif state[right] == STIFF and state[left] == QUIET:
            state[left] = BESIDE


@kernel
def rows_of(g: Geometry, state: Any) -> Rows:
    """Set up the system of the cells that are not quiet."""
    ni, most = len(g.right), 2 * len(g.axes)
    rank, cells = np.full(len(state), -1, dtype=np.int32), np.flatnonzero(state)
    column, face = (
        np.empty((len(cells), most), dtype=np.uint32),
        np.empty((len(cells), most), dtype=np.uint32),
    )
    filled = np.zeros(len(cells), dtype=np.uint32)
    for i in range(len(cells)):
        rank[cells[i]] = i
        column[i] = i
    for f in range(ni):
        left, right = rank[g.left[f]], rank[g.right[f]]
        if left >= 0 and right >= 0:
            for here, there in ((left, right), (right, left)):
                column[here, filled[here]] = there
                face[here, filled[here]] = f
                filled[here] += 1
    return Rows(rank, cells, column, face)


@kernel
def scale_of(g: Geometry, system: System, k: int, rows: Rows) -> Array:
    """Return one over the root of the diagonal of component k; a link to a cell that is
    not solved for counts as none.
    """
    rank, cells, coef = rows.rank, rows.cells, system.coef
    scale = np.empty(len(cells))
    for i in range(len(cells)):
        scale[i] = system.content[cells[i], k] + system.links[cells[i], k]
    for f in range(len(g.right)):
        left, right = rank[g.left[f]], rank[g.right[f]]
        if left >= 0 and right < 0:
            scale[left] -= coef[f, k]
        elif right >= 0 and left < 0:
            scale[right] -= coef[f, k]
    for i in range(len(cells)):
        scale[i] = 1.0 / np.sqrt(scale[i])
    return scale


@kernel
def values_of(coef: Array, k: int, rows: Rows, scale: Array) -> Array:
    """Return the links (n, m) of component k in the matrix with a diagonal of ones."""
    column, face = rows.column, rows.face
    values = np.zeros(column.shape)
    for i in range(len(scale)):
        for j in range(column.shape[1]):
            if column[i, j] != i:
                values[i, j] = coef[face[i, j], k] * scale[i] * scale[column[i, j]]
    return values


@summing
def product(
    axes: tuple[int, ...], column: Any, values: Array, p: Array, q: Array
) -> float:
    """Set q = p - values times the neighbours; return p . q."""
    total = 0.0
    for i in range(len(q)):
        row = p[i]
        for j in range(2 * len(axes)):
            row -= values[i, j] * p[column[i, j]]
        q[i] = row
        total += row * p[i]
    return total


@summing
def advance(alpha: float, p: Array, q: Array, x: Array, r: Array) -> float:
    """Set x + alpha p and r - alpha q in place; return r . r."""
    total = 0.0
    for i in range(len(q)):
        x[i] += alpha * p[i]
        r[i] -= alpha * q[i]
        total += r[i] * r[i]
    return total


@inner
def _conjugate_gradients(
    axes: tuple[int, ...],
    column: Any,
    values: Array,
    x: Array,
    tolerance: float,
    most: int,
) -> int:
    """Solve with a matrix that has a diagonal of ones; `x` holds the right-hand side,
    and gets the solution.

    Return the number of iterations, -1 if too many.
    """
    r, p, q = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    product(axes, column, values, x, q)
    first = rho = 0.0
    for i in range(len(x)):
        r[i] = p[i] = x[i] - q[i]
        first += x[i] * x[i]
        rho += r[i] * r[i]
    for iteration in range(most):
        if rho <= tolerance**2 * first:
            return iteration
        before = rho
        rho = advance(rho / product(axes, column, values, p, q), p, q, x, r)
        for i in range(len(p)):
            p[i] = r[i] + rho / before * p[i]
    return -1 if rho > tolerance**2 * first else most
