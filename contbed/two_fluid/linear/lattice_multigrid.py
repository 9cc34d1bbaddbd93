"""Conjugate gradients on the lattice of a rectangular grid, with geometric multigrid
where links are stiff.

A cycle smooths each lattice by two steps of Jacobi with the weights of Chebyshev's
polynomial, before and after the correction from the next coarser one, down to one
place; corrections are constant on what becomes one place. All loops run over contiguous
memory and sum in a fixed order. Brandt 1977, Math. Comput. 31, 333-390; Braess 1995,
Computing 55, 379-393 (coarse links); Adams, Brezina, Hu and Tuminaro 2003, J. Comput.
Phys. 188, 593-610 (smoothing).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contbed.compiled import barrier, threads
from contbed.compiled.barrier import Crew, wait
from contbed.two_fluid.compiled import Array, Indices, inner, inner_summing, kernel
from contbed.two_fluid.fv.grid import Geometry, Grid, over_rows
from contbed.two_fluid.fv.rows import Rows
from contbed.two_fluid.linear.cg import System
from contbed.two_fluid.linear.lattice import (
    BLOCK,
    FINEST,
    Exchange,
    Index,
    Levels,
    Stencil,
    add_neighbours,
    block,
    blocks,
    empty_stencil,
    set_up_exchange,
    set_up_pressure,
    share,
    shared,
    span,
)

# inverse zeros of Chebyshev's polynomial on the upper part of the spectrum of D^-1 A,
# 0.5 to 2
WEIGHTS = (1.0 / (1.25 - 0.75 * 0.5**0.5), 1.0 / (1.25 + 0.75 * 0.5**0.5))
# links of a cell over its content above which iterations use multigrid: with less,
# Jacobi takes few (measured)
MIN_STIFFNESS = 20.0
# as in multigrid.py
PRESSURE_TOLERANCE, PRESSURE_ROUNDING, PRESSURE_ITERATIONS = 1e-11, 1e-16, 100

Part = tuple[int, int]  # first block of a thread, and the one after the last


@inner_summing
def _row(axes: tuple[int, ...], a: Stencil, x: Array, p: Any, s1: Any, s2: Any) -> Any:
    """Matrix times x at the place p."""
    one = np.uint64(1)
    found = a.diagonal[p] * x[p] - a.fast[p] * x[p + one] - a.fast[p - one] * x[p - one]
    found -= a.middle[p] * x[p + s1] + a.middle[p - s1] * x[p - s1]
    if len(axes) > 2:
        found -= a.slow[p] * x[p + s2] + a.slow[p - s2] * x[p - s2]
    return found


@inner_summing
def _smooth(
    levels: Levels,
    level: Index,
    part: Part,
    a: Stencil,
    weight: float,
    b: Array,
    x: Array,
    out: Array,
) -> None:
    """Set out to x after one step of Jacobi."""
    _, _, s1, s2 = span(levels, level)
    inverse = a.inverse
    for number in range(part[0], part[1]):
        begin, end = block(levels, level, number)
        for p in range(begin, end):
            out[p] = x[p] + weight * inverse[p] * (
                b[p] - _row(levels.axes, a, x, p, s1, s2)
            )


@inner_summing
def _residual(
    levels: Levels, level: Index, part: Part, a: Stencil, b: Array, x: Array, out: Array
) -> None:
    """Set out to what x leaves of b."""
    _, _, s1, s2 = span(levels, level)
    for number in range(part[0], part[1]):
        begin, end = block(levels, level, number)
        for p in range(begin, end):
            out[p] = b[p] - _row(levels.axes, a, x, p, s1, s2)


@inner
def _restrict(crew: Crew, levels: Levels, level: Index, r: Array, b: Array) -> None:
    """Set b on the next lattice to the sums of r."""
    nx, ny, nz = levels.size[level]
    bx, by, bz = levels.by[level]
    cx, cy, cz = levels.size[level + 1]
    first, last = share(crew, levels, level, cy * cz)
    for coarse in range(first, last):
        to = levels.first[level + 1] + cx * coarse
        b[to : to + cx] = 0.0
        for k in range(coarse // cy * bz, min(nz, (coarse // cy + 1) * bz)):
            for j in range(coarse % cy * by, min(ny, (coarse % cy + 1) * by)):
                row = levels.first[level] + nx * (j + ny * k)
                if bx == 2:
                    for i in range(nx // 2):
                        b[to + i] += r[row + 2 * i] + r[row + 2 * i + 1]
                    if nx % 2 == 1:
                        b[to + nx // 2] += r[row + nx - 1]
                else:
                    for i in range(nx):
                        b[to + i] += r[row + i]


@inner
def _correct(crew: Crew, levels: Levels, level: Index, x: Array) -> None:
    """Add x of the next lattice to x of this one."""
    nx, ny, nz = levels.size[level]
    bx, by, bz = levels.by[level]
    cx, cy, _ = levels.size[level + 1]
    first, last = share(crew, levels, level, ny * nz)
    for number in range(first, last):
        row = levels.first[level] + nx * number
        at = levels.first[level + 1] + cx * (
            number % ny // by + cy * (number // ny // bz)
        )
        if bx == 2:
            for i in range(nx // 2):
                x[row + 2 * i] += x[at + i]
                x[row + 2 * i + 1] += x[at + i]
            if nx % 2 == 1:
                x[row + nx - 1] += x[at + nx // 2]
        else:
            for i in range(nx):
                x[row + i] += x[at + i]


@inner
def _scale(
    levels: Levels,
    level: Index,
    part: Part,
    weight: float,
    a: Stencil,
    b: Array,
    x: Array,
) -> None:
    """Set x to `weight` times b over the diagonal."""
    for number in range(part[0], part[1]):
        begin, end = block(levels, level, number)
        for p in range(begin, end):
            x[p] = weight * a.inverse[p] * b[p]


@inner
def _cycle(
    crew: Crew, levels: Levels, a: Stencil, b: Array, x: Array, other: Array
) -> None:
    """Approximate solution x on the first lattice for the right-hand side b there;
    `other` is a workspace.

    Each thread has set its part of x where it returns.
    """
    last = len(levels.first) - 1
    for level in range(last):
        part = share(crew, levels, level, blocks(levels, level))
        _scale(levels, level, part, WEIGHTS[0], a, b, other)
        _meet(crew, levels, level)
        _smooth(levels, level, part, a, WEIGHTS[1], b, other, x)
        _meet(crew, levels, level)
        _residual(levels, level, part, a, b, x, other)
        _meet(crew, levels, level)
        _restrict(crew, levels, level, other, b)
        _meet(crew, levels, level)
    _scale(levels, last, share(crew, levels, last, 1), 1.0, a, b, x)
    for level in range(last - 1, -1, -1):
        part = share(crew, levels, level, blocks(levels, level))
        # where the next lattice was left to the first thread, the others wait for it
        _meet(crew, levels, level)
        _correct(crew, levels, level, x)
        _meet(crew, levels, level)
        _smooth(levels, level, part, a, WEIGHTS[1], b, x, other)
        _meet(crew, levels, level)
        _smooth(levels, level, part, a, WEIGHTS[0], b, other, x)


@inner
def _meet(crew: Crew, levels: Levels, level: Index) -> None:
    """Wait for the other threads if they share a lattice."""
    if shared(levels, level):
        wait(crew)


class Vectors(NamedTuple):
    """What iterations need on the lattices: right-hand side b and solution x, which
    holds a guess, each (total,).

    r, z, direction, other (total,) : residual, preconditioned residual, direction of
        the last step, workspace
    parts (3, blocks) : sums and largest values of the blocks of the first lattice
    """

    b: Array
    x: Array
    r: Array
    z: Array
    direction: Array
    other: Array
    parts: Array


class End(NamedTuple):
    """Iterations end where the largest residual, or the square in the norm of the
    inverse diagonal, is not above least.

    by_largest : whether it is the largest one; most : iterations
    """

    least: float
    by_largest: bool
    most: int


@inner_summing
def _measure(
    levels: Levels, part: Part, by_largest: bool, inverse: Array, r: Array, out: Array
) -> None:
    """Set `out` (blocks,) to the largest value of r in each block, or to its square
    in the norm of `inverse`.
    """
    for number in range(part[0], part[1]):
        begin, end = block(levels, FINEST, number)
        found = total = 0.0
        if by_largest:
            for i in range(begin, end):
                found = max(found, abs(r[i]))
                total += r[i]
            out[number] = found if np.isfinite(total) else np.nan
        else:
            for i in range(begin, end):
                total += inverse[i] * r[i] * r[i]
            out[number] = total


@inner_summing
def _products(levels: Levels, part: Part, x: Array, y: Array, out: Array) -> None:
    """Set `out` (blocks,) to x . y in each block."""
    for number in range(part[0], part[1]):
        begin, end = block(levels, FINEST, number)
        found = 0.0
        for i in range(begin, end):
            found += x[i] * y[i]
        out[number] = found


@inner
def _turn(
    levels: Levels, part: Part, share_of_last: float, z: Array, direction: Array
) -> None:
    """Set the direction to z plus a share of the last one."""
    for number in range(part[0], part[1]):
        begin, end = block(levels, FINEST, number)
        for i in range(begin, end):
            direction[i] = z[i] + share_of_last * direction[i]


@inner_summing
def _apply(
    levels: Levels, part: Part, a: Stencil, x: Array, y: Array, out: Array
) -> None:
    """Set y to the matrix times x, and `out` (blocks,) to x . y in each block."""
    _, _, s1, s2 = span(levels, FINEST)
    for number in range(part[0], part[1]):
        begin, end = block(levels, FINEST, number)
        found = 0.0
        for i in range(begin, end):
            row = _row(levels.axes, a, x, i, s1, s2)
            y[i] = row
            found += row * x[i]
        out[number] = found


@inner_summing
def _step(
    levels: Levels,
    part: Part,
    alpha: float,
    direction: Array,
    change: Array,
    x: Array,
    r: Array,
) -> None:
    """Add alpha times the direction to x, and take alpha times its `change` of the
    residual from r.
    """
    for number in range(part[0], part[1]):
        begin, end = block(levels, FINEST, number)
        for i in range(begin, end):
            x[i] += alpha * direction[i]
            r[i] -= alpha * change[i]


@inner
def _together(parts: Array, by_largest: bool) -> float:
    """Sum, or largest value, of the `parts` (blocks,) in their order; not a number
    where one of them is none.
    """
    found = total = 0.0
    for part in parts:
        found, total = max(found, part), total + part
    return found if by_largest and np.isfinite(total) else total


@kernel
def iterate(
    crew: Crew, levels: Levels, a: Stencil, v: Vectors, multigrid: bool, end: End
) -> int:
    """Solve on the first lattice; return the number of iterations, -1 if too many or
    where a number is not finite.
    """
    part, parts = share(crew, levels, FINEST, blocks(levels, FINEST)), v.parts
    _residual(levels, FINEST, part, a, v.b, v.x, v.r)
    _measure(levels, part, end.by_largest, a.inverse, v.r, parts[0])
    wait(crew)
    before = 1.0
    for iteration in range(end.most + 1):
        if _together(parts[0], end.by_largest) <= end.least:
            return iteration
        if multigrid:
            _cycle(crew, levels, a, v.r, v.z, v.other)
        else:
            _scale(levels, FINEST, part, 1.0, a, v.r, v.z)
        _products(levels, part, v.z, v.r, parts[1])
        wait(crew)
        slope = _together(parts[1], False)
        _turn(levels, part, slope / before if iteration > 0 else 0.0, v.z, v.direction)
        wait(crew)
        _apply(levels, part, a, v.direction, v.z, parts[2])
        wait(crew)
        _step(
            levels, part, slope / _together(parts[2], False), v.direction, v.z, v.x, v.r
        )
        _measure(levels, part, end.by_largest, a.inverse, v.r, parts[0])
        wait(crew)
        before = slope
    return -1


@kernel
def boundary_links(g: Geometry, coef: Array, rest: Array) -> None:
    """Add the links of boundary faces to given values to those of their cells,
    `rest` (nc,).
    """
    for f in range(g.edge_from, g.edge_to):
        rest[g.left[f]] += coef[f]


@kernel
def _sum_links(
    g: Geometry, rows: Rows, system: System, explicit: float, rest: Array, x: Array
) -> bool:
    """Add the links of faces to those of their cells; `rest` (m, nc) are those to given
    values; x = rhs/content.

    Return whether those of any cell are above `explicit` times its content.
    """
    found = False
    coef, links, content, rhs = system.coef, system.links, system.content, system.rhs
    for k in range(len(coef)):
        boundary_links(g, coef[k], links[k])
        for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
            rest[k, c] = links[k, c]
            x[k, c] = rhs[k, c] / content[k, c]
        for r in range(len(rows.length)):
            face, left, right = rows.face[r], rows.left[r], rows.right[r]
            for i in range(rows.left_from[r], rows.left_to[r]):
                links[k, left + i] += coef[k, face + i]
            for i in range(rows.right_from[r], rows.right_to[r]):
                links[k, right + i] += coef[k, face + i]
        for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
            found |= links[k, c] > explicit * content[k, c]
    return found


def solve_exchange(
    lattice: LatticeMultigrid,
    system: System,
    explicit: float,
    tolerance: float,
    most: int,
    x: Array,
) -> int:
    """Solve for `x` (m, nc), the `system` by component, as linear/cg.py.

    Return the most iterations that a component took, -1 if too many.
    """
    levels, a, at, v = lattice.levels, lattice.stencil, lattice.at, lattice.vectors
    rest, total, longest = np.empty_like(x), levels.joined.shape[1], 0
    if not any(over_rows(lattice.grid, _sum_links, system, explicit, rest, x)):
        return 0
    over = system.links > explicit * system.content
    stiff, solved = np.zeros(total), np.zeros(total)
    stiff[at] = over.any(axis=0)
    add_neighbours(levels, stiff, solved)
    inside = solved[at] > 0.0
    for k, content in enumerate(system.content):
        multigrid = bool((system.links[k] > MIN_STIFFNESS * content).any())
        lattice.run(
            set_up_exchange,
            Exchange(system.coef[k], content, rest[k], solved, multigrid),
            a,
            v.other,
        )
        v.b[at] = system.rhs[k]
        v.x[at] = a.inverse[at] * system.rhs[k]
        least = tolerance**2 * float((v.x[at] * system.rhs[k])[inside].sum())
        iterations = lattice.iterate(multigrid, End(least, False, most))
        if iterations < 0:
            return -1
        longest = max(longest, iterations)
        # where nothing is solved for, iterations change the last digits
        np.copyto(x[k], v.x[at], where=inside)
    return longest


class LatticeMultigrid:
    """Multigrid for the pressure equation of one grid."""

    def __init__(self, grid: Grid, levels: Levels):
        self.grid, self.levels, self.stencil = grid, levels, empty_stencil(levels)
        total, count = levels.joined.shape[1], int(np.prod(levels.size[0]))
        sums = np.zeros((3, -(-count // BLOCK)))
        self.vectors = Vectors._make(
            [*(np.zeros(total) for _ in Vectors._fields[:-1]), sums]
        )
        first, cells = int(levels.of_cell[0]), len(levels.of_cell)
        without_holes = np.array_equal(levels.of_cell, first + np.arange(cells))
        # of the cells on the first lattice
        self.at: slice | Indices = (
            slice(first, first + cells) if without_holes else levels.of_cell
        )

    def run(self, kernel: Any, *arguments: Any) -> Any:
        """Run a kernel in the threads that the grid is worth, and return what the
        first one returns.
        """
        return barrier.run(
            kernel, threads.count(len(self.grid.cells)), self.levels, *arguments
        )

    def iterate(self, multigrid: bool, end: End) -> int:
        """Iterate from `vectors`, see `iterate`."""
        found: int = self.run(iterate, self.stencil, self.vectors, multigrid, end)
        if found < 0:
            # places without a cell must stay finite, as their links of 0 times what is
            # there have to be 0
            for vector in self.vectors:
                vector[:] = 0.0
        return found

    def solve(self, coef: Array, floating: bool, rhs: Array, x: Array) -> int:
        """Put the solution in `x`, which holds a guess; return the number of
        iterations, -1 without convergence.

        The diagonal of the first cell counts twice where the system is `floating`.
        """
        if not np.isfinite(coef.sum() + rhs.sum()):
            return -1
        a, v, rest = self.stencil, self.vectors, np.zeros(len(x))
        boundary_links(self.grid.geometry, coef, rest)
        self.run(set_up_pressure, coef, rest, floating, a, v.other)
        v.b[self.at], v.x[self.at] = rhs, x
        least = (
            PRESSURE_TOLERANCE * np.abs(rhs).max()
            + PRESSURE_ROUNDING * np.abs(a.diagonal[self.at] * x).max()
        )
        found = self.iterate(True, End(float(least), True, PRESSURE_ITERATIONS))
        x[:] = v.x[self.at]
        return found
