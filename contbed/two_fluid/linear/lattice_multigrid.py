"""Conjugate gradients on the lattice of a rectangular grid, with geometric multigrid where links are stiff.

A cycle smooths each lattice by two steps of Jacobi with the weights of Chebyshev's polynomial, before and after the
correction from the next coarser one, down to one place; corrections are constant on what becomes one place. All loops
run over contiguous memory and sum in a fixed order. Brandt 1977, Math. Comput. 31, 333-390; Braess 1995, Computing 55,
379-393 (coarse links); Adams, Brezina, Hu and Tuminaro 2003, J. Comput. Phys. 188, 593-610 (smoothing).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.two_fluid.compiled import ZERO, Array, Indices, kernel, summing
from contbed.two_fluid.fv.grid import Geometry, Grid
from contbed.two_fluid.fv.rows import Rows
from contbed.two_fluid.linear.cg import System
from contbed.two_fluid.linear.lattice import (
    Levels,
    Stencil,
    add_neighbours,
    coarsen,
    empty_stencil,
    load_diagonal,
    load_links,
    load_solved,
    span,
)

# inverse zeros of Chebyshev's polynomial on the upper part of the spectrum of D^-1 A, 0.5 to 2
WEIGHTS = (1.0 / (1.25 - 0.75 * 0.5**0.5), 1.0 / (1.25 + 0.75 * 0.5**0.5))
# links of a cell over its content above which iterations use multigrid: with less, Jacobi takes few (measured)
MIN_STIFFNESS = 20.0
# as in multigrid.py
PRESSURE_TOLERANCE, PRESSURE_ROUNDING, PRESSURE_ITERATIONS = 1e-11, 1e-16, 100


@summing
def _row(axes: tuple[int, ...], a: Stencil, x: Array, p: Any, s1: Any, s2: Any) -> Any:
    """Matrix times x at the place p."""
    one = np.uint64(1)
    found = a.diagonal[p] * x[p] - a.fast[p] * x[p + one] - a.fast[p - one] * x[p - one]
    found -= a.middle[p] * x[p + s1] + a.middle[p - s1] * x[p - s1]
    if len(axes) > 2:
        found -= a.slow[p] * x[p + s2] + a.slow[p - s2] * x[p - s2]
    return found


@summing
def _smooth(levels: Levels, level: int, a: Stencil, weight: float, b: Array, x: Array, out: Array) -> None:
    """Set out to x after one step of Jacobi."""
    begin, end, s1, s2 = span(levels, level)
    inverse = a.inverse
    for p in range(begin, end):
        out[p] = x[p] + weight * inverse[p] * (b[p] - _row(levels.axes, a, x, p, s1, s2))


@summing
def _residual(levels: Levels, level: int, a: Stencil, b: Array, x: Array, out: Array) -> None:
    """Set out to what x leaves of b."""
    begin, end, s1, s2 = span(levels, level)
    for p in range(begin, end):
        out[p] = b[p] - _row(levels.axes, a, x, p, s1, s2)


@kernel
def _restrict(levels: Levels, level: int, r: Array, b: Array) -> None:
    """Set b on the next lattice to the sums of r."""
    nx, ny, nz = levels.size[level]
    bx, by, bz = levels.by[level]
    cx, cy, cz = levels.size[level + 1]
    begin, coarse = levels.first[level], levels.first[level + 1]
    b[coarse : coarse + cx * cy * cz] = 0.0
    for k in range(nz):
        for j in range(ny):
            row, to = begin + nx * (j + ny * k), coarse + cx * (j // by + cy * (k // bz))
            if bx == 2:
                for i in range(nx // 2):
                    b[to + i] += r[row + 2 * i] + r[row + 2 * i + 1]
                if nx % 2 == 1:
                    b[to + nx // 2] += r[row + nx - 1]
            else:
                for i in range(nx):
                    b[to + i] += r[row + i]


@kernel
def _correct(levels: Levels, level: int, x: Array) -> None:
    """Add x of the next lattice to x of this one."""
    nx, ny, nz = levels.size[level]
    bx, by, bz = levels.by[level]
    cx, cy, _ = levels.size[level + 1]
    begin, coarse = levels.first[level], levels.first[level + 1]
    for k in range(nz):
        for j in range(ny):
            row, at = begin + nx * (j + ny * k), coarse + cx * (j // by + cy * (k // bz))
            if bx == 2:
                for i in range(nx // 2):
                    x[row + 2 * i] += x[at + i]
                    x[row + 2 * i + 1] += x[at + i]
                if nx % 2 == 1:
                    x[row + nx - 1] += x[at + nx // 2]
            else:
                for i in range(nx):
                    x[row + i] += x[at + i]


@kernel
def _cycle(levels: Levels, a: Stencil, b: Array, x: Array, other: Array) -> None:
    """Approximate solution x on the first lattice for the right-hand side b there; `other` is a workspace."""
    last = len(levels.first) - 1
    for level in range(last):
        begin, end, _, _ = span(levels, level)
        for p in range(begin, end):
            other[p] = WEIGHTS[0] * a.inverse[p] * b[p]
        _smooth(levels, level, a, WEIGHTS[1], b, other, x)
        _residual(levels, level, a, b, x, other)
        _restrict(levels, level, other, b)
    begin, end, _, _ = span(levels, last)
    for p in range(begin, end):
        x[p] = a.inverse[p] * b[p]
    for level in range(last - 1, -1, -1):
        _correct(levels, level, x)
        _smooth(levels, level, a, WEIGHTS[1], b, x, other)
        _smooth(levels, level, a, WEIGHTS[0], b, other, x)


@summing
def _square(begin: Any, end: Any, inverse: Array, r: Array) -> float:
    """Return r . r in the norm of the inverse diagonal."""
    square = 0.0
    for i in range(begin, end):
        square += inverse[i] * r[i] * r[i]
    return square


@kernel
def _start(levels: Levels, a: Stencil, b: Array, x: Array, r: Array) -> float:
    """Set r to what x leaves of b; return its square in the norm of the inverse diagonal."""
    begin, end, _, _ = span(levels, 0)
    _residual(levels, 0, a, b, x, r)
    return _square(begin, end, a.inverse, r)


@summing
def _advance(levels: Levels, a: Stencil, slope: float, part: float, p: Array, q: Array, x: Array, r: Array) -> float:
    """One step along p, which holds the preconditioned residual: plus `part` times q, the direction before.

    `slope` is r times the preconditioned residual. Return the square of the new residual. q becomes the direction.
    """
    begin, end, s1, s2 = span(levels, 0)
    for i in range(begin, end):
        q[i] = p[i] + part * q[i]
    total = 0.0
    for i in range(begin, end):
        row = _row(levels.axes, a, q, i, s1, s2)
        p[i] = row
        total += row * q[i]
    alpha = slope / total
    for i in range(begin, end):
        x[i] += alpha * q[i]
        r[i] -= alpha * p[i]
    return _square(begin, end, a.inverse, r)


@summing
def _precondition(levels: Levels, a: Stencil, multigrid: bool, r: Array, z: Array, other: Array) -> float:
    """Set z to the approximate solution for r by a cycle of multigrid, or r over the diagonal; return z . r."""
    begin, end, _, _ = span(levels, 0)
    if multigrid:
        _cycle(levels, a, r, z, other)
    else:
        for i in range(begin, end):
            z[i] = a.inverse[i] * r[i]
    total = 0.0
    for i in range(begin, end):
        total += z[i] * r[i]
    return total


def iterate(
    levels: Levels, a: Stencil, b: Array, x: Array, multigrid: bool, least: float, by_largest: bool, most: int
) -> int:
    """Solve from the guess `x` on the first lattice; return the number of iterations, -1 if too many.

    It ends where the largest residual, or the square in the norm of the inverse diagonal, is not above `least`.
    """
    r, z, direction, other = (np.zeros_like(x) for _ in range(4))
    first, places = levels.first[0], int(np.prod(levels.size[0]))
    inside = r[first : first + places]
    square, before = _start(levels, a, b, x, r), 1.0
    for iteration in range(most + 1):
        if (max(inside.max(), -inside.min()) if by_largest else square) <= least:
            return iteration
        slope = _precondition(levels, a, multigrid, r, z, other)
        part = slope / before if iteration > 0 else 0.0
        square = _advance(levels, a, slope, part, z, direction, x, r)
        before = slope
    return -1


@kernel
def boundary_links(g: Geometry, coef: Array, rest: Array) -> None:
    """Add the links of boundary faces to given values to those of their cells, `rest` (nc,)."""
    for f in range(g.edge_from, g.edge_to):
        rest[g.left[f]] += coef[f]


@kernel
def _sum_links(g: Geometry, rows: Rows, system: System, explicit: float, rest: Array, x: Array) -> bool:
    """Add the links of faces to those of their cells; `rest` (m, nc) are those to given values; x = rhs/content.

    Return whether those of any cell are above `explicit` times its content.
    """
    found = False
    coef, links, content, rhs = system.coef, system.links, system.content, system.rhs
    for k in range(len(coef)):
        boundary_links(g, coef[k], links[k])
        for c in range(rows.begin, rows.end):
            rest[k, c] = links[k, c]
            x[k, c] = rhs[k, c] / content[k, c]
        for r in range(len(rows.length)):
            face, left, right = rows.face[r], rows.left[r], rows.right[r]
            for i in range(rows.left_from[r], rows.left_to[r]):
                links[k, left + i] += coef[k, face + i]
            for i in range(rows.right_from[r], rows.right_to[r]):
                links[k, right + i] += coef[k, face + i]
        for c in range(rows.begin, rows.end):
            found |= links[k, c] > explicit * content[k, c]
    return found


def solve_exchange(
    lattice: LatticeMultigrid, rows: Rows, system: System, explicit: float, tolerance: float, most: int, x: Array
) -> int:
    """Solve for `x` (m, nc), the `system` by component, as linear/cg.py.

    Return the most iterations that a component took, -1 if too many.
    """
    levels, a, at = lattice.levels, lattice.stencil, lattice.at
    rest, total, longest = np.empty_like(x), levels.joined.shape[1], 0
    if not _sum_links(lattice.geometry, rows, system, explicit, rest, x):
        return 0
    over = system.links > explicit * system.content
    stiff, solved = np.zeros(total), np.zeros(total)
    stiff[at] = over.any(axis=0)
    add_neighbours(levels, stiff, solved)
    inside = solved[at] > 0.0
    for k, content in enumerate(system.content):
        load_links(levels, system.coef[k], a)
        load_solved(levels, content, rest[k], solved, a)
        multigrid = bool((system.links[k] > MIN_STIFFNESS * content).any())
        if multigrid:
            coarsen(levels, a)
        b, y = np.zeros(total), np.zeros(total)
        b[at] = system.rhs[k]
        y[at] = a.inverse[at] * system.rhs[k]
        least = tolerance**2 * float((y[at] * system.rhs[k])[inside].sum())
        iterations = iterate(levels, a, b, y, multigrid, least, False, most)
        if iterations < 0:
            return -1
        longest = max(longest, iterations)
        # where nothing is solved for, iterations change the last digits
        np.copyto(x[k], y[at], where=inside)
    return longest


class LatticeMultigrid:
    """Multigrid for the pressure equation of one grid."""

    def __init__(self, grid: Grid, levels: Levels):
        self.levels, self.stencil, self.geometry = levels, empty_stencil(levels), grid.geometry
        first, cells = int(levels.of_cell[0]), len(levels.of_cell)
        without_holes = np.array_equal(levels.of_cell, first + np.arange(cells))
        # of the cells on the first lattice
        self.at: slice | Indices = slice(first, first + cells) if without_holes else levels.of_cell

    def solve(self, coef: Array, floating: bool, rhs: Array, x: Array) -> int:
        """Put the solution in `x`, which holds a guess; return the number of iterations, -1 without convergence.

        The diagonal of the first cell counts twice where the system is `floating`.
        """
        if not np.isfinite(coef.sum() + rhs.sum()):
            return -1
        levels, a, rest = self.levels, self.stencil, np.zeros(len(x))
        boundary_links(self.geometry, coef, rest)
        load_links(levels, coef, a)
        load_diagonal(levels, rest, a)
        if floating:
            rest[0] += a.diagonal[levels.of_cell[0]]
            load_diagonal(levels, rest, a)
        coarsen(levels, a)
        b, y = np.zeros(len(a.fast)), np.zeros(len(a.fast))
        b[self.at], y[self.at] = rhs, x
        least = PRESSURE_TOLERANCE * np.abs(rhs).max() + PRESSURE_ROUNDING * np.abs(a.diagonal[self.at] * x).max()
        found = iterate(levels, a, b, y, True, float(least), True, PRESSURE_ITERATIONS)
        x[:] = y[self.at]
        return found
