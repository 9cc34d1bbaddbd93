"""Pressure equation of the gas: conjugate gradients, preconditioned by multigrid over the columns of cells.

The system is sum over faces of conductance (p - p_beyond) = source, with p = 0 beyond outlets. A column is solved
exactly (line Gauss-Seidel), so that only what differs between columns is left to the coarser levels, each of which
joins columns two by two in x and in y. Vertical conductances of joined columns add up. So do the ones between them,
over twice the distance: half the sum. One V-cycle, with one sweep of the columns forwards before and one backwards
after the coarser level, is symmetric and positive, as conjugate gradients need.

Source: line relaxation with semi-coarsening, Trottenberg, Oosterlee and Schueller, Multigrid (2001), section 5.1.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.cfd_dem.grid import Tables
from contbed.compiled.functions import entry, inner

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Index = int | np.int64

JOINED = 0.5  # conductance between joined columns over the sum of those that cross: they are twice as far apart
# numba would compile functions again for a Python 0
FINEST = np.int64(0)  # level
FIRST = np.int64(0)  # column of a level


class Levels(NamedTuple):
    """The systems of all levels, the finest first: arrays (columns of all levels, nz).

    `size` (levels, 2): numbers of columns in x and y. Column (i, j) of a level is first + i ny + j with its entry of
    `first` (levels + 1,). Conductances to the next cell in x, y and z, and to outlets [m3/s/Pa]; the next cell after
    the last one is the first, and without periodic sides their conductance is 0. `inverse` and `down` are the factors
    of the columns: 1/pivot, and up/pivot.
    """

    size: Integers
    first: Integers
    east: Array
    north: Array
    up: Array
    rest: Array
    diagonal: Array
    inverse: Array
    down: Array


def solve(
    p: Array, conductance: Array, source: Array, tables: Tables, tolerance: float, most: int
) -> tuple[Array, int, float]:
    """Solve for the pressure of the cells from a guess.

    Parameters
    ----------
    p : guess (c,) [Pa]
    conductance : of the faces (f,) [m3/s/Pa]; 0 where no velocity is solved for
    source : right-hand side (c,) [m3/s]
    tables : of the grid
    tolerance : residual over the right-hand side, in the root of the sum of squares
    most : iterations

    Returns
    -------
    pressure (c,) [Pa], iterations, residual over the right-hand side
    """
    nx, ny, nz = tables.shape
    size, first = _sizes(nx, ny)
    levels = Levels(size, first, *np.zeros((7, first[-1], nz)))
    _assemble(conductance, tables.cell_face, tables.face_cell, levels)
    p = p.reshape(-1, nz).copy()
    steps, error = _conjugate_gradients(p, source.reshape(-1, nz), levels, tolerance, most)
    return p.reshape(-1), steps, error


@lru_cache(maxsize=16)
def _sizes(nx: int, ny: int) -> tuple[Integers, Integers]:
    """Numbers of columns of each level, down to a single one, and its first column."""
    size = [(nx, ny)]
    while size[-1] != (1, 1):
        size.append(((size[-1][0] + 1) // 2, (size[-1][1] + 1) // 2))
    return np.array(size), np.concatenate([[0], np.cumsum(np.prod(size, axis=1))])


@entry(cache=True, error_model="numpy")
def _conjugate_gradients(p: Array, source: Array, levels: Levels, tolerance: float, most: int) -> tuple[int, float]:
    """Improve the pressure (columns, nz); returns iterations, residual over the right-hand side."""
    columns, nz = p.shape
    corrections, sources = np.zeros_like(levels.rest), np.zeros_like(levels.rest)
    nothing, d, q, r = np.zeros_like(p), np.zeros_like(p), np.zeros_like(p), np.zeros_like(p)
    norm = np.sqrt(_dot(source, source, columns))
    _residual(levels, FINEST, source, p, r)
    rho, steps = 1.0, 0
    error = np.sqrt(_dot(r, r, columns))
    while error > tolerance * norm and steps < most:
        for c in range(columns):
            for k in range(nz):
                sources[c, k] = r[c, k]
        _cycle(levels, sources, corrections)
        new = _dot(r, corrections, columns)
        share = new / rho if steps > 0 else 0.0
        for c in range(columns):
            for k in range(nz):
                d[c, k] = corrections[c, k] + share * d[c, k]
        rho = new
        _residual(levels, FINEST, nothing, d, q)
        alpha = -rho / _dot(d, q, columns)
        for c in range(columns):
            for k in range(nz):
                p[c, k] += alpha * d[c, k]
                r[c, k] += alpha * q[c, k]
        error = np.sqrt(_dot(r, r, columns))
        steps += 1
    return steps, error / norm if norm > 0.0 else 0.0


@inner(cache=True, error_model="numpy")
def _dot(a: Array, b: Array, columns: int) -> float:
    total = 0.0
    for c in range(columns):
        for k in range(a.shape[1]):
            total += a[c, k] * b[c, k]
    return total


@entry(cache=True, error_model="numpy")
def _assemble(conductance: Array, cell_face: Integers, face_cell: Integers, levels: Levels) -> None:
    """Fill in the system of the grid and the coarser ones, down to a single column."""
    nx, ny = levels.size[0]
    nz = levels.rest.shape[1]
    cell = 0
    for c in range(nx * ny):
        for k in range(nz):
            for side in range(6):
                f = cell_face[cell, side]
                if face_cell[f, side % 2] < 0:
                    levels.rest[c, k] += conductance[f]
            east, north, up = cell_face[cell, 1], cell_face[cell, 3], cell_face[cell, 5]
            if nx > 1 and face_cell[east, 1] >= 0:
                levels.east[c, k] = conductance[east]
            if ny > 1 and face_cell[north, 1] >= 0:
                levels.north[c, k] = conductance[north]
            if face_cell[up, 1] >= 0:
                levels.up[c, k] = conductance[up]
            cell += 1
    for at in range(len(levels.size)):
        if at > 0:
            _join(levels, at)
        _factor(levels, at)


@inner(cache=True, error_model="numpy")
def _factor(levels: Levels, at: Index) -> None:
    """Add the diagonal and the factors of the columns; a cell without any conductance gets a diagonal of 1."""
    east, north, up, down = levels.east, levels.north, levels.up, levels.down
    first = levels.first[at]
    nx, ny = levels.size[at]
    for i in range(nx):
        for j in range(ny):
            c, before_x, before_y = first + i * ny + j, first + (i - 1) % nx * ny + j, first + i * ny + (j - 1) % ny
            for k in range(up.shape[1]):
                value = levels.rest[c, k] + up[c, k] + east[c, k] + east[before_x, k]
                value += north[c, k] + north[before_y, k]
                if k > 0:
                    value += up[c, k - 1]
                if value == 0.0:
                    value = 1.0
                levels.diagonal[c, k] = value
                pivot = value - (up[c, k - 1] * down[c, k - 1] if k > 0 else 0.0)
                levels.inverse[c, k] = 1.0 / pivot
                down[c, k] = up[c, k] / pivot


@inner(cache=True, error_model="numpy")
def _join(levels: Levels, at: Index) -> None:
    """Fill in a level: the columns of the one before two by two in x and in y; an odd one at the end stays alone."""
    east, north, up, rest = levels.east, levels.north, levels.up, levels.rest
    nx, ny = levels.size[at - 1]
    for i in range(nx):
        for j in range(ny):
            a, b = i // 2, j // 2
            crosses_x, crosses_y = (i + 1) % nx // 2 != a, (j + 1) % ny // 2 != b
            fine, coarse = levels.first[at - 1] + i * ny + j, levels.first[at] + a * levels.size[at, 1] + b
            for k in range(up.shape[1]):
                up[coarse, k] += up[fine, k]
                rest[coarse, k] += rest[fine, k]
                if crosses_x:
                    east[coarse, k] += JOINED * east[fine, k]
                if crosses_y:
                    north[coarse, k] += JOINED * north[fine, k]


@inner(cache=True, error_model="numpy")
def _cycle(levels: Levels, sources: Array, corrections: Array) -> None:
    """Take one V-cycle: the finest part of `corrections` approximates the solution for that of `sources`."""
    nz = sources.shape[1]
    left = np.zeros((levels.first[1], nz))
    for c in range(len(corrections)):
        for k in range(nz):
            corrections[c, k] = 0.0
    last = len(levels.size) - 1
    for at in range(last + 1):
        _sweep(levels, at, sources, corrections, FIRST)
        if at < last:
            _residual(levels, at, sources, corrections, left)
            _restrict(levels, at, left, sources)
    for at in range(last - 1, -1, -1):
        nx, ny = levels.size[at]
        for i in range(nx):
            for j in range(ny):
                fine = levels.first[at] + i * ny + j
                coarse = levels.first[at + 1] + i // 2 * levels.size[at + 1, 1] + j // 2
                for k in range(nz):
                    corrections[fine, k] += corrections[coarse, k]
        _sweep(levels, at, sources, corrections, nx * ny - 1)


@inner(cache=True, error_model="numpy")
def _sweep(levels: Levels, at: Index, source: Array, p: Array, begin: Index) -> None:
    """Solve the columns one after the other with the newest pressures beside (line Gauss-Seidel).

    `begin`: the column to begin with, the first one or the last, from which the sweep goes backwards.
    """
    east, north, inverse, down = levels.east, levels.north, levels.inverse, levels.down
    first, nz = levels.first[at], p.shape[1]
    nx, ny = levels.size[at]
    column = np.empty(nz)
    for number in range(nx * ny):
        place = abs(begin - number)
        i, j = place // ny, place % ny
        c = first + place
        before_x, after_x = first + (i - 1) % nx * ny + j, first + (i + 1) % nx * ny + j
        before_y, after_y = first + i * ny + (j - 1) % ny, first + i * ny + (j + 1) % ny
        for k in range(nz):
            column[k] = (
                source[c, k]
                + east[c, k] * p[after_x, k]
                + east[before_x, k] * p[before_x, k]
                + north[c, k] * p[after_y, k]
                + north[before_y, k] * p[before_y, k]
            )
        for k in range(1, nz):
            column[k] += down[c, k - 1] * column[k - 1]
        above = 0.0
        for k in range(nz - 1, -1, -1):
            above = column[k] * inverse[c, k] + down[c, k] * above
            p[c, k] = above


@inner(cache=True, error_model="numpy")
def _residual(levels: Levels, at: Index, source: Array, p: Array, out: Array) -> None:
    """Find what the pressure leaves of the source in the columns of a level, in the first ones of `out`."""
    east, north, up, diagonal = levels.east, levels.north, levels.up, levels.diagonal
    first, nz = levels.first[at], p.shape[1]
    nx, ny = levels.size[at]
    for i in range(nx):
        for j in range(ny):
            left, c = i * ny + j, first + i * ny + j
            before_x, after_x = first + (i - 1) % nx * ny + j, first + (i + 1) % nx * ny + j
            before_y, after_y = first + i * ny + (j - 1) % ny, first + i * ny + (j + 1) % ny
            for k in range(nz):
                out[left, k] = (
                    source[c, k]
                    - diagonal[c, k] * p[c, k]
                    + east[c, k] * p[after_x, k]
                    + east[before_x, k] * p[before_x, k]
                    + north[c, k] * p[after_y, k]
                    + north[before_y, k] * p[before_y, k]
                )
            for k in range(nz - 1):
                out[left, k] += up[c, k] * p[c, k + 1]
                out[left, k + 1] += up[c, k] * p[c, k]


@inner(cache=True, error_model="numpy")
def _restrict(levels: Levels, at: Index, left: Array, sources: Array) -> None:
    """Sum what the pressure leaves of the source over the columns that are joined: the source of the next level."""
    nx, ny = levels.size[at]
    for c in range(levels.first[at + 1], levels.first[at + 2]):
        for k in range(left.shape[1]):
            sources[c, k] = 0.0
    for i in range(nx):
        for j in range(ny):
            coarse = levels.first[at + 1] + i // 2 * levels.size[at + 1, 1] + j // 2
            for k in range(left.shape[1]):
                sources[coarse, k] += left[i * ny + j, k]
