"""Compiled parts of the gas: sums over the particles' shares, momentum on faces, slopes
of the pressure.

Kernels run over the tables of a `grid.Grid`; arrays are of cells (c,), faces (f,) or
particles (n,). Those over particles run in several threads; sums are taken in an order
that does not depend on how many there are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array
from contbed.cfd_dem.grid import OUTLET, Tables
from contbed.compiled import threads
from contbed.compiled.functions import entry

Indices = NDArray[np.int64]
Places = NDArray[np.int32]  # cells or faces around each particle


def gather(where: Places, weight: Array, values: Array) -> Array:
    """Sum the weighted values of what is around each particle: of cells (n, k) the
    value (n,), of faces (n, 3, 8) the vector (n, 3).
    """
    rows, out = where.reshape(-1, where.shape[-1]), np.empty(where.shape[:-1])
    arguments = rows, weight.reshape(rows.shape), values, out.reshape(-1)
    threads.parallel(_gather, len(rows), *arguments)
    return out


@entry(nogil=True, cache=True)
def _gather(
    begin: int, end: int, where: Places, weight: Array, values: Array, out: Array
) -> None:
    for i in range(begin, end):
        found = 0.0
        for k in range(where.shape[1]):
            found += weight[i, k] * values[where[i, k]]
        out[i] = found


def scatter(where: Places, weight: Array, values: Array, size: int) -> Array:
    """Sum `values` over the particles, shape (size,): (n,) on the cells (n, k) or on
    the faces (n, 3, 8) around each, or (n, 3) on the faces across each axis.
    """
    count, number = len(where), where.shape[-1]
    rows = where.reshape(count, where.size // (count * number), number)
    each = np.broadcast_to(values.reshape(count, -1), rows.shape[:2])
    arguments = rows, weight.reshape(rows.shape), np.ascontiguousarray(each)
    return np.asarray(threads.scattered(_scatter, count, (size,), *arguments))


@entry(nogil=True, cache=True)
def _scatter(
    begin: int, end: int, where: Places, weight: Array, values: Array, out: Array
) -> None:
    for i in range(begin, end):
        for a in range(where.shape[1]):
            for k in range(where.shape[2]):
                out[where[i, a, k]] += weight[i, a, k] * values[i, a]


@entry(cache=True)
def face_means(cell: Array, face_cell: Indices) -> Array:
    """Interpolate cell values to faces: the mean of both sides, at the rim the value
    of the only cell.
    """
    out = np.empty(len(face_cell))
    for f in range(len(face_cell)):
        low, high = face_cell[f]
        if low < 0:
            out[f] = cell[high]
        elif high < 0:
            out[f] = cell[low]
        else:
            out[f] = 0.5 * (cell[low] + cell[high])
    return out


@entry(cache=True)
def limited(T: Array, T_inlet: Array, flux: Array, tables: Tables) -> Array:
    """Reconstruct upwind temperatures on faces, second order (MUSCL) with the limiter
    of van Leer (1974).

    `T_inlet` (f,) [K] are those beyond the inlet, nan elsewhere; `flux` (f,) gives the
    direction.
    """
    cell_face = tables.cell_face
    face_cell = tables.face_cell
    face_axis = tables.face_axis
    out = T_inlet.copy()
    for f in range(len(face_cell)):
        up, down = (
            (face_cell[f, 0], face_cell[f, 1])
            if flux[f] >= 0.0
            else (face_cell[f, 1], face_cell[f, 0])
        )
        if up < 0:
            if down >= 0 and T_inlet[f] != T_inlet[f]:
                out[f] = T[down]
            continue
        out[f] = T[up]
        if down < 0:
            continue
        behind = cell_face[up, 2 * face_axis[f] + (0 if flux[f] >= 0.0 else 1)]
        far = face_cell[behind, 0 if flux[f] >= 0.0 else 1]
        if far >= 0:
            beyond = T[far]
        elif T_inlet[behind] == T_inlet[behind]:
            beyond = 2.0 * T_inlet[behind] - T[up]
        else:
            continue
        ahead, back = T[down] - T[up], T[up] - beyond
        if ahead * back > 0.0:
            out[f] += ahead * back / (ahead + back)
    return out


@entry(cache=True)
def divergence(flux: Array, cell_face: Indices) -> Array:
    """Sum what leaves each cell, of fluxes [./s] through faces."""
    out = np.empty(len(cell_face))
    for c in range(len(cell_face)):
        g = cell_face[c]
        out[c] = (
            flux[g[1]] - flux[g[0]] + flux[g[3]] - flux[g[2]] + flux[g[5]] - flux[g[4]]
        )
    return out


@entry(cache=True)
def momentum(
    u: Array,
    mass: Array,
    eps: Array,
    rho: Array,
    mu: Array,
    gravity: Array,
    tables: Tables,
    no_slip: bool,
) -> Array:
    """Sum convection (first-order upwind), viscous stress and weight on staggered
    faces [N/m3 of gas].

    Parameters
    ----------
    u : intrinsic velocity (f,) [m/s]
    mass : flux eps rho u (f,) [kg/m2/s]
    eps, rho, mu : porosity [-], density [kg/m3] and viscosity [Pa s] on faces (f,)
    gravity : (3,) [m/s2]
    tables : `grid.Tables`
    no_slip : whether the gas sticks to the sides
    """
    cell_face = tables.cell_face
    face_cell = tables.face_cell
    face_next = tables.face_next
    size = tables.size
    face_axis, active = tables.face_axis, tables.active
    out = np.zeros(len(u))
    for f in range(len(u)):
        if not active[f]:
            continue
        a = face_axis[f]
        low, high = face_cell[f]
        convected, stress = 0.0, 0.0
        for side in range(6):
            b = side // 2
            near = face_next[f, side]
            if b == a:
                through = mass[f] if near < 0 else 0.5 * (mass[f] + mass[near])
            elif high < 0:
                through = mass[cell_face[low, side]]
            else:
                through = 0.5 * (
                    mass[cell_face[low, side]] + mass[cell_face[high, side]]
                )
            inward = through if side % 2 == 0 else -through
            if near >= 0:
                other, distance = u[near], size[b]
            elif side == 4:  # below the inlet nothing moves sideways
                other, distance = 0.0, size[b]
            elif b != a and side != 5 and no_slip:
                other, distance = 0.0, 0.5 * size[b]
            else:
                continue
            if inward > 0.0:
                convected += inward * (other - u[f]) / size[b]
            stress += mu[f] * (other - u[f]) / (size[b] * distance)
        out[f] = convected / eps[f] + stress + rho[f] * gravity[a]
    return out


@entry(cache=True)
def slopes(p: Array, tables: Tables) -> Array:
    """Find the pressure gradient on the faces with unknown velocities [Pa/m]; p = 0
    at the outlet face.
    """
    size, face_cell, face_axis = tables.size, tables.face_cell, tables.face_axis
    face_kind, active = tables.face_kind, tables.active
    out = np.zeros(len(face_cell))
    for f in range(len(face_cell)):
        if not active[f]:
            continue
        if face_kind[f] == OUTLET:
            out[f] = -2.0 * p[face_cell[f, 0]] / size[face_axis[f]]
        else:
            out[f] = (p[face_cell[f, 1]] - p[face_cell[f, 0]]) / size[face_axis[f]]
    return out
