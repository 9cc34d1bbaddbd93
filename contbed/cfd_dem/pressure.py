"""Pressure equation of the gas: conjugate gradients, preconditioned by multigrid over the columns of cells.

The system is sum over faces of conductance (p - p_beyond) = source, with p = 0 beyond outlets. A column is solved
exactly (line Gauss-Seidel), so that only what differs between columns is left to the coarser levels, each of which
joins columns two by two in x and in y. Vertical conductances of joined columns add up. So do the ones between them,
over twice the distance: half the sum. One V-cycle, with one sweep of the columns forwards before and one backwards
after the coarser level, is symmetric and positive, as conjugate gradients need.

Source: line relaxation with semi-coarsening, Trottenberg, Oosterlee and Schueller, Multigrid (2001), section 5.1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contbed.cfd_dem.grid import Tables

Array = NDArray[np.float64]

JOINED = 0.5  # conductance between joined columns over the sum of those that cross: they are twice as far apart


class Level(NamedTuple):
    """One system on columns; arrays of shape (nx, ny, nz), conductances to the next cell in x, y and z [m3/s/Pa].

    The next cell after the last one is the first; without periodic sides their conductance is 0. `inverse` and `down`
    are the factors of the columns: 1/pivot, and up/pivot.
    """

    east: Array
    north: Array
    up: Array
    rest: Array
    diagonal: Array
    inverse: Array
    down: Array


@njit(cache=True, error_model="numpy")
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
    levels = _levels(conductance, tables)
    finest = levels[0]
    shape = finest.rest.shape
    corrections = [np.zeros(level.rest.shape) for level in levels]
    sources = [np.zeros(level.rest.shape) for level in levels]
    p, q = p.copy().reshape(shape), np.empty(shape)
    norm = np.sqrt((source * source).sum())
    _residual(finest, source.copy().reshape(shape), p, q)
    r = q.copy()
    d = np.zeros(shape)
    rho, steps = 1.0, 0
    error = np.sqrt((r * r).sum())
    while error > tolerance * norm and steps < most:
        sources[0][:] = r
        _cycle(levels, sources, corrections)
        z = corrections[0]
        new = (r * z).sum()
        d = z + (new / rho if steps > 0 else 0.0) * d
        rho = new
        _residual(finest, np.zeros(shape), d, q)
        alpha = -rho / (d * q).sum()
        p += alpha * d
        r += alpha * q
        error = np.sqrt((r * r).sum())
        steps += 1
    return p.reshape(-1), steps, error / norm if norm > 0.0 else 0.0


@njit(cache=True, error_model="numpy")
def _levels(conductance: Array, tables: Tables) -> list[Level]:
    """Build the system of the grid and the coarser ones, down to a single column."""
    nx, ny, nz = tables.shape
    east, north, up, rest = [np.zeros((nx, ny, nz)) for _ in range(4)]
    cell_face, face_cell = tables.cell_face, tables.face_cell
    c = 0
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                for side in range(6):
                    f = cell_face[c, side]
                    if face_cell[f, side % 2] < 0:
                        rest[i, j, k] += conductance[f]
                if nx > 1 and face_cell[cell_face[c, 1], 1] >= 0:
                    east[i, j, k] = conductance[cell_face[c, 1]]
                if ny > 1 and face_cell[cell_face[c, 3], 1] >= 0:
                    north[i, j, k] = conductance[cell_face[c, 3]]
                if face_cell[cell_face[c, 5], 1] >= 0:
                    up[i, j, k] = conductance[cell_face[c, 5]]
                c += 1
    levels = [_factored(east, north, up, rest)]
    while nx > 1 or ny > 1:
        levels.append(_joined(levels[-1]))
        nx, ny, nz = levels[-1].rest.shape
    return levels


@njit(cache=True, error_model="numpy")
def _factored(east: Array, north: Array, up: Array, rest: Array) -> Level:
    """Add the diagonal and the factors of the columns; a cell without any conductance gets a diagonal of 1."""
    nx, ny, nz = rest.shape
    diagonal, inverse, down = rest + up, np.empty(rest.shape), np.empty(rest.shape)
    for i in range(nx):
        for j in range(ny):
            before_x, before_y = (i - 1) % nx, (j - 1) % ny
            for k in range(nz):
                value = diagonal[i, j, k] + east[i, j, k] + east[before_x, j, k]
                value += north[i, j, k] + north[i, before_y, k]
                if k > 0:
                    value += up[i, j, k - 1]
                if value == 0.0:
                    value = 1.0
                diagonal[i, j, k] = value
                pivot = value - (up[i, j, k - 1] * down[i, j, k - 1] if k > 0 else 0.0)
                inverse[i, j, k] = 1.0 / pivot
                down[i, j, k] = up[i, j, k] / pivot
    return Level(east, north, up, rest, diagonal, inverse, down)


@njit(cache=True, error_model="numpy")
def _joined(fine: Level) -> Level:
    """Join the columns two by two in x and in y; an odd one at the end stays alone."""
    nx, ny, nz = fine.rest.shape
    mx, my = (nx + 1) // 2, (ny + 1) // 2
    east, north, up, rest = [np.zeros((mx, my, nz)) for _ in range(4)]
    for i in range(nx):
        for j in range(ny):
            a, b = i // 2, j // 2
            crosses_x, crosses_y = (i + 1) % nx // 2 != a, (j + 1) % ny // 2 != b
            for k in range(nz):
                up[a, b, k] += fine.up[i, j, k]
                rest[a, b, k] += fine.rest[i, j, k]
                if crosses_x:
                    east[a, b, k] += JOINED * fine.east[i, j, k]
                if crosses_y:
                    north[a, b, k] += JOINED * fine.north[i, j, k]
    return _factored(east, north, up, rest)


@njit(cache=True, error_model="numpy")
def _cycle(levels: list[Level], sources: list[Array], corrections: list[Array]) -> None:
    """Take one V-cycle: corrections[0] approximates the solution for sources[0]."""
    last = len(levels) - 1
    for at in range(last):
        corrections[at][:] = 0.0
        _sweep(levels[at], sources[at], corrections[at], False)
        _restrict(levels[at], sources[at], corrections[at], sources[at + 1])
    corrections[last][:] = 0.0
    _sweep(levels[last], sources[last], corrections[last], False)
    for at in range(last - 1, -1, -1):
        fine, coarse = corrections[at], corrections[at + 1]
        for i in range(fine.shape[0]):
            for j in range(fine.shape[1]):
                for k in range(fine.shape[2]):
                    fine[i, j, k] += coarse[i // 2, j // 2, k]
        _sweep(levels[at], sources[at], fine, True)


@njit(cache=True, error_model="numpy")
def _sweep(level: Level, source: Array, p: Array, backwards: bool) -> None:
    """Solve the columns one after the other with the newest pressures beside (line Gauss-Seidel)."""
    east, north, inverse, down = level.east, level.north, level.inverse, level.down
    nx, ny, nz = p.shape
    column = np.empty(nz)
    for number in range(nx * ny):
        place = nx * ny - 1 - number if backwards else number
        i, j = place // ny, place % ny
        before_x, after_x, before_y, after_y = (i - 1) % nx, (i + 1) % nx, (j - 1) % ny, (j + 1) % ny
        for k in range(nz):
            column[k] = (
                source[i, j, k]
                + east[i, j, k] * p[after_x, j, k]
                + east[before_x, j, k] * p[before_x, j, k]
                + north[i, j, k] * p[i, after_y, k]
                + north[i, before_y, k] * p[i, before_y, k]
            )
        for k in range(1, nz):
            column[k] += down[i, j, k - 1] * column[k - 1]
        above = 0.0
        for k in range(nz - 1, -1, -1):
            above = column[k] * inverse[i, j, k] + down[i, j, k] * above
            p[i, j, k] = above


@njit(cache=True, error_model="numpy")
def _residual(level: Level, source: Array, p: Array, out: Array) -> None:
    """Find what the pressure leaves of the source."""
    east, north, up, diagonal = level.east, level.north, level.up, level.diagonal
    nx, ny, nz = p.shape
    for i in range(nx):
        for j in range(ny):
            before_x, after_x, before_y, after_y = (i - 1) % nx, (i + 1) % nx, (j - 1) % ny, (j + 1) % ny
            for k in range(nz):
                out[i, j, k] = (
                    source[i, j, k]
                    - diagonal[i, j, k] * p[i, j, k]
                    + east[i, j, k] * p[after_x, j, k]
                    + east[before_x, j, k] * p[before_x, j, k]
                    + north[i, j, k] * p[i, after_y, k]
                    + north[i, before_y, k] * p[i, before_y, k]
                )
            for k in range(nz - 1):
                out[i, j, k] += up[i, j, k] * p[i, j, k + 1]
                out[i, j, k + 1] += up[i, j, k] * p[i, j, k]


@njit(cache=True, error_model="numpy")
def _restrict(level: Level, source: Array, p: Array, coarse: Array) -> None:
    """Sum what the pressure leaves of the source over the columns that are joined."""
    left = np.empty(p.shape)
    _residual(level, source, p, left)
    coarse[:] = 0.0
    for i in range(p.shape[0]):
        for j in range(p.shape[1]):
            for k in range(p.shape[2]):
                coarse[i // 2, j // 2, k] += left[i, j, k]
