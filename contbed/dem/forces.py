"""Forces and torques of all contacts of a step: pairs in blocks, walls one by one.

Closed contacts are found along the half list and copied, by column, into a block that fits into the first cache. The
law then runs over the block in vector instructions, and the results are added to the particles and to the histories.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from contbed.dem.contact import FAST, SINCE, SPEED, contact_law, rolling_torque
from contbed.dem.neighbours import BITS, MASK, wall_distance
from contbed.dem.particles import DAMP_N, DAMP_T, E_EFF, G_EFF, ROLL, SLIDE

BLOCK = 64  # contacts
# columns of a block: vector from j to i and its square; relative velocity, then force; spring; half the vector x force;
# normal force and speed; and of the pair: sum of the radii, effective radius and mass, columns of the pair table
(
    DX,
    DY,
    DZ,
    FAR,
    VX,
    VY,
    VZ,
    SX,
    SY,
    SZ,
    QX,
    QY,
    QZ,
    LOAD,
    SPEED_N,
    TOUCH,
    R_EFF,
    M_EFF,
    E,
    G,
    CN,
    CT,
    MU,
) = (column * BLOCK for column in range(23))


@njit
def workspace():
    """An empty block, and room for particle i, particle j and the row of the list of each of its contacts."""
    return np.empty(23 * BLOCK), np.empty((BLOCK, 3), np.int64)


@njit(error_model="numpy", fastmath=set(FAST))
def pair_forces(
    x, v, w, f, q, radius, mass, inertia, kind, uniform, table, image, start, mates, past, now, dt, b, rows
):
    """Add the forces and torques of all pairs to `f` and `q`."""
    if uniform:
        for k in range(BLOCK):
            _constants(b, k, 0, 0, radius, mass, table[kind[0], kind[0]])
    touch2, count = 4.0 * radius[0] * radius[0], 0
    for i in range(len(x)):
        xi, yi, zi = x[i, 0], x[i, 1], x[i, 2]
        for k in range(start[i], start[i + 1]):
            j = mates[k] & MASK
            dx, dy, dz = xi - x[j, 0], yi - x[j, 1], zi - x[j, 2]
            shift = mates[k] >> BITS
            if shift:
                dx, dy, dz = dx - image[shift, 0], dy - image[shift, 1], dz - image[shift, 2]
            if not uniform:
                touch2 = (radius[i] + radius[j]) ** 2
            far2 = dx * dx + dy * dy + dz * dz
            if far2 >= touch2:
                if past[k, SINCE] >= 0.0:
                    past[k, :] = 0.0
                    past[k, SINCE] = -1.0
                continue
            b[DX + count], b[DY + count], b[DZ + count], b[FAR + count] = dx, dy, dz, far2
            rows[count, 0], rows[count, 1], rows[count, 2] = i, j, k
            count += 1
            if count == BLOCK:
                _block(b, rows, count, v, w, f, q, radius, mass, inertia, kind, uniform, table, past, now, dt)
                count = 0
    _block(b, rows, count, v, w, f, q, radius, mass, inertia, kind, uniform, table, past, now, dt)


@njit(error_model="numpy", fastmath=set(FAST), forceinline=True)
def _constants(b, k, i, j, radius, mass, pair):
    b[TOUCH + k] = radius[i] + radius[j]
    b[R_EFF + k] = radius[i] * radius[j] / (radius[i] + radius[j])
    b[M_EFF + k] = mass[i] * mass[j] / (mass[i] + mass[j])
    b[E + k], b[G + k], b[CN + k], b[CT + k] = pair[E_EFF], pair[G_EFF], pair[DAMP_N], pair[DAMP_T]
    b[MU + k] = pair[SLIDE]


@njit(error_model="numpy", fastmath=set(FAST))
def _block(b, rows, count, v, w, f, q, radius, mass, inertia, kind, uniform, table, past, now, dt):
    """Gather, run the law, scatter. An arm is half the distance, longer by `more` for i and shorter for j."""
    more, rolls = 0.0, table[kind[0], kind[0], ROLL] > 0.0 or not uniform
    for k in range(count):
        i, j, p = rows[k, 0], rows[k, 1], rows[k, 2]
        dx, dy, dz = b[DX + k], b[DY + k], b[DZ + k]
        if not uniform:
            _constants(b, k, i, j, radius, mass, table[kind[i], kind[j]])
            more = (radius[i] - radius[j]) / np.sqrt(b[FAR + k])
        on_i, on_j = 0.5 + 0.5 * more, 0.5 - 0.5 * more
        wx = on_i * w[i, 0] + on_j * w[j, 0]
        wy = on_i * w[i, 1] + on_j * w[j, 1]
        wz = on_i * w[i, 2] + on_j * w[j, 2]
        b[VX + k] = v[i, 0] - v[j, 0] - (wy * dz - wz * dy)
        b[VY + k] = v[i, 1] - v[j, 1] - (wz * dx - wx * dz)
        b[VZ + k] = v[i, 2] - v[j, 2] - (wx * dy - wy * dx)
        b[SX + k], b[SY + k], b[SZ + k] = past[p, 0], past[p, 1], past[p, 2]
    _law(b, count, dt)
    for k in range(count):
        i, j, p = rows[k, 0], rows[k, 1], rows[k, 2]
        past[p, 0], past[p, 1], past[p, 2] = b[SX + k], b[SY + k], b[SZ + k]
        if past[p, SINCE] < 0.0:
            past[p, SINCE], past[p, SPEED] = now, abs(b[SPEED_N + k])
        if not uniform:
            more = (radius[i] - radius[j]) / np.sqrt(b[FAR + k])
        _add(f, i, b[VX + k], b[VY + k], b[VZ + k], 1.0)
        _add(f, j, b[VX + k], b[VY + k], b[VZ + k], -1.0)
        _add(q, i, b[QX + k], b[QY + k], b[QZ + k], 1.0 + more)
        _add(q, j, b[QX + k], b[QY + k], b[QZ + k], 1.0 - more)
        if rolls:
            _roll(q, i, j, w, inertia, b, k, table[kind[i], kind[j], ROLL], dt)


@njit(error_model="numpy", fastmath=set(FAST))
def _roll(q, i, j, w, inertia, b, k, friction, dt):
    far = np.sqrt(b[FAR + k])
    tx, ty, tz = rolling_torque(
        b[DX + k] / far,
        b[DY + k] / far,
        b[DZ + k] / far,
        w[i, 0] - w[j, 0],
        w[i, 1] - w[j, 1],
        w[i, 2] - w[j, 2],
        b[R_EFF + k],
        inertia[i] * inertia[j] / (inertia[i] + inertia[j]),
        friction,
        b[LOAD + k],
        dt,
    )
    _add(q, i, tx, ty, tz, 1.0)
    _add(q, j, tx, ty, tz, -1.0)


@njit(error_model="numpy", fastmath=set(FAST))
def _law(b, count, dt):
    """The columns that follow from the gathered ones."""
    for k in range(count):
        dx, dy, dz = b[DX + k], b[DY + k], b[DZ + k]
        far = np.sqrt(b[FAR + k])
        fx, fy, fz, b[LOAD + k], b[SX + k], b[SY + k], b[SZ + k], b[SPEED_N + k] = contact_law(
            dx / far,
            dy / far,
            dz / far,
            b[TOUCH + k] - far,
            b[VX + k],
            b[VY + k],
            b[VZ + k],
            b[SX + k],
            b[SY + k],
            b[SZ + k],
            b[R_EFF + k],
            b[M_EFF + k],
            b[E + k],
            b[G + k],
            b[CN + k],
            b[CT + k],
            b[MU + k],
            dt,
        )
        b[VX + k], b[VY + k], b[VZ + k] = fx, fy, fz
        b[QX + k], b[QY + k], b[QZ + k] = (
            0.5 * (dz * fy - dy * fz),
            0.5 * (dx * fz - dz * fx),
            0.5 * (dy * fx - dx * fy),
        )


@njit(error_model="numpy", fastmath=set(FAST), forceinline=True)
def _add(total, i, x, y, z, factor):
    total[i, 0] += factor * x
    total[i, 1] += factor * y
    total[i, 2] += factor * z


@njit(error_model="numpy", fastmath=set(FAST))
def wall_forces(x, v, w, f, q, radius, mass, inertia, kind, table, walls, wall_kind, near, past, now, dt):
    """Add the forces and torques of walls at rest; a wall counts as a plane of infinite mass."""
    for entry in range(len(near)):
        i, side = near[entry, 0], near[entry, 1]
        gap, nx, ny, nz = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls[side])
        overlap = radius[i] - gap
        if overlap <= 0.0:
            if past[side, i, SINCE] >= 0.0:
                past[side, i, :] = 0.0
                past[side, i, SINCE] = -1.0
            continue
        own, other = kind[i], wall_kind[side]
        cx, cy, cz, normal, sx, sy, sz, speed = contact_law(
            nx,
            ny,
            nz,
            overlap,
            v[i, 0] - gap * (w[i, 1] * nz - w[i, 2] * ny),
            v[i, 1] - gap * (w[i, 2] * nx - w[i, 0] * nz),
            v[i, 2] - gap * (w[i, 0] * ny - w[i, 1] * nx),
            past[side, i, 0],
            past[side, i, 1],
            past[side, i, 2],
            radius[i],
            mass[i],
            table[own, other, E_EFF],
            table[own, other, G_EFF],
            table[own, other, DAMP_N],
            table[own, other, DAMP_T],
            table[own, other, SLIDE],
            dt,
        )
        past[side, i, 0], past[side, i, 1], past[side, i, 2] = sx, sy, sz
        if past[side, i, SINCE] < 0.0:
            past[side, i, SINCE], past[side, i, SPEED] = now, abs(speed)
        _add(f, i, cx, cy, cz, 1.0)
        _add(q, i, nz * cy - ny * cz, nx * cz - nz * cx, ny * cx - nx * cy, gap)
        friction = table[own, other, ROLL]
        if friction > 0.0:
            tx, ty, tz = rolling_torque(
                nx, ny, nz, w[i, 0], w[i, 1], w[i, 2], radius[i], inertia[i], friction, normal, dt
            )
            _add(q, i, tx, ty, tz, 1.0)
