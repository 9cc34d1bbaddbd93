"""The conjugate gradients of cg.py on a grid that ranks share: the same iterations, so
the same result to rounding.

All components iterate together, so that an iteration costs one exchange of ghost cells
and two sums over the ranks, whatever the number of components. A component that has
converged stays as it is. Only cells that are solved for are exchanged: they have
numbers of their own, first those that the rank owns, then ghost cells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.two_fluid.compiled import Array, Flags, Indices, kernel, summing
from contbed.two_fluid.fv.grid import Geometry, Grid
from contbed.two_fluid.linear.cg import System, add_links

Places = NDArray[np.uint32]


class Rows(NamedTuple):
    """Links between the cells that are solved for.

    start (no + 1,) : of the links of each own cell; beside, faces (nl,) : its
    neighbours, and the faces between them
    """

    start: Indices
    beside: Places
    faces: Places


@kernel
def _solved_cells(g: Geometry, stiff: Flags, solved: Flags) -> None:
    """Mark stiff cells and their neighbours."""
    for c in range(len(stiff)):
        solved[c] = stiff[c]
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        if stiff[left]:
            solved[right] = True
        if stiff[right]:
            solved[left] = True


@kernel
def _linked(g: Geometry, number: Indices, own: int) -> Rows:
    """Find the links of the own cells by their `number` (nc,), -1 for cells that are
    not solved for.
    """
    start = np.zeros(own + 1, dtype=np.int64)
    for f in range(len(g.right)):
        left, right = number[g.left[f]], number[g.right[f]]
        if left >= 0 and right >= 0 and left != right:
            for here in (left, right):
                if here < own:
                    start[here + 1] += 1
    for i in range(own):
        start[i + 1] += start[i]
    beside, faces, filled = (
        np.empty(start[own], np.uint32),
        np.empty(start[own], np.uint32),
        start[:own].copy(),
    )
    for f in range(len(g.right)):
        left, right = number[g.left[f]], number[g.right[f]]
        if left >= 0 and right >= 0 and left != right:
            for here, there in ((left, right), (right, left)):
                if here < own:
                    beside[filled[here]] = there
                    faces[filled[here]] = f
                    filled[here] += 1
    return Rows(start, beside, faces)


@kernel
def _diagonal(g: Geometry, system: System, number: Indices, diagonal: Array) -> None:
    """Set the diagonal (n, m) of the cells with a number; a link to a cell without
    one is not solved for.
    """
    for c in range(len(number)):
        if number[c] >= 0:
            for k in range(diagonal.shape[1]):
                diagonal[number[c], k] = system.content[c, k] + system.links[c, k]
    for f in range(len(g.right)):
        left, right = number[g.left[f]], number[g.right[f]]
        if (left >= 0) != (right >= 0):
            for k in range(diagonal.shape[1]):
                diagonal[max(left, right), k] -= system.coef[f, k]


@kernel
def _scaled(rows: Rows, coef: Array, scale: Array, values: Array) -> None:
    """Set the `values` (nl, m) of the links in the matrix with a diagonal of ones."""
    for k in range(coef.shape[1]):
        for i in range(len(rows.start) - 1):
            for j in range(rows.start[i], rows.start[i + 1]):
                values[j, k] = (
                    coef[rows.faces[j], k] * scale[i, k] * scale[rows.beside[j], k]
                )


@summing
def _product(rows: Rows, values: Array, p: Array, q: Array, dots: Array) -> None:
    """Set q (no, m) to the matrix times p (n, m), and dots (m,) to p . q."""
    for k in range(values.shape[1]):
        total = 0.0
        for i in range(len(q)):
            row = p[i, k]
            for j in range(rows.start[i], rows.start[i + 1]):
                row -= values[j, k] * p[rows.beside[j], k]
            q[i, k] = row
            total += row * p[i, k]
        dots[k] = total


@summing
def _advance(alpha: Array, p: Array, q: Array, y: Array, r: Array, dots: Array) -> None:
    """Set y + alpha p and r - alpha q (no, m) in place, and dots (m,) to r . r."""
    for k in range(len(alpha)):
        total = 0.0
        for i in range(len(q)):
            y[i, k] += alpha[k] * p[i, k]
            r[i, k] -= alpha[k] * q[i, k]
            total += r[i, k] * r[i, k]
        dots[k] = total


@kernel
def _turn(beta: Array, going: Flags, r: Array, p: Array) -> None:
    """Set p to r + beta p in own cells, in components that are `going` (m,) on."""
    for k in range(len(beta)):
        if going[k]:
            for i in range(len(r)):
                p[i, k] = r[i, k] + beta[k] * p[i, k]


def solve_on_ranks(
    grid: Grid, system: System, explicit: float, tolerance: float, most: int, x: Array
) -> int:
    """Solve for `x` (nc, m), ghost cells included; return the number of iterations, -1
    if too many.

    explicit : links of a cell over its content above which it is stiff
    tolerance : of the residual, relative in the norm of the inverse diagonal
    """
    g, halo = grid.geometry, grid.halo
    content, rhs = system.content, system.rhs
    add_links(g, system)
    x[:] = rhs / content
    stiff: Flags = np.asarray((system.links > explicit * content).any(axis=1))
    if not halo.any(bool(stiff[halo.cells].any())):
        halo.exchange(x)
        return 0
    halo.exchange(stiff)
    solved = np.empty_like(stiff)
    _solved_cells(g, stiff, solved)
    halo.exchange(solved)
    cells = np.flatnonzero(solved)
    number = np.full(len(solved), -1)
    number[cells] = np.arange(len(cells))
    own, ghosts = int(np.count_nonzero(solved[halo.cells])), halo.of_numbered(number)
    size = (len(cells), x.shape[1])
    # one component after the other, as kernels go through them
    scale, target, p = (np.empty(size, order="F") for _ in range(3))
    _diagonal(g, system, number, scale)
    np.power(scale, -0.5, out=scale)
    ghosts.exchange(scale)
    rows = _linked(g, number, own)
    values = np.empty((len(rows.faces), size[1]), order="F")
    _scaled(rows, system.coef, scale, values)

    np.multiply(scale, rhs[cells], out=target)
    ghosts.exchange(target)
    y, q, dots = (
        target[:own].copy(order="F"),
        np.empty((own, size[1]), order="F"),
        np.empty(size[1]),
    )
    _product(rows, values, target, q, dots)
    r = y - q
    p[:own] = r
    sums = np.array(
        halo.sum(*np.einsum("ck,ck->k", y, y), *np.einsum("ck,ck->k", r, r))
    )
    first, rho = sums[: size[1]], sums[size[1] :]
    iterations = 0
    while (going := rho > tolerance**2 * first).any():
        if iterations == most:
            return -1
        iterations += 1
        ghosts.exchange(p)
        _product(rows, values, p, q, dots)
        curvature = np.array(halo.sum(*dots))
        alpha = np.where(going, rho / np.where(going, curvature, 1.0), 0.0)
        _advance(alpha, p, q, y, r, dots)
        before, rho = rho, np.where(going, halo.sum(*dots), rho)
        _turn(np.where(going, rho / np.where(going, before, 1.0), 0.0), going, r, p)
    x[cells[:own]] = scale[:own] * y
    halo.exchange(x)
    return iterations
