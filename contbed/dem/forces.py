"""Forces and torques of all contacts of a step: pairs in blocks, walls one by one.

Closed contacts are found along the Verlet list and copied, by column, into a block that fits into the first cache. The
law then runs over the block in vector instructions, and the results are added to the particles and to the histories.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contbed.dem.contact import FAST, ContactConstants, Vector, contact_law, rolling_torque
from contbed.dem.kernel_arrays import Array, Neighbours, Spheres, State, Table, Walls
from contbed.dem.neighbours import BITS, MASK, open_contact, wall_distance

BLOCK = 64  # contacts: 26 columns of 64 numbers are 13 kB, less than half of the first cache
# where the columns of a block start, all in one array, so that the compiler sees that they do not overlap
(
    DX, DY, DZ, DISTANCE2,  # vector from j to i and its square
    VX, VY, VZ,  # velocity of i against j at the contact
    SPRING_X, SPRING_Y, SPRING_Z, NORMAL_SPEED,
    FX, FY, FZ, NORMAL_FORCE,  # on i
    TX, TY, TZ,  # half the vector times the force
    TOUCH,  # sum of the radii
    RADIUS, MASS, YOUNGS, SHEAR, DAMPING_N, DAMPING_T, SLIDING,  # `ContactConstants`
) = (column * BLOCK for column in range(26))  # fmt: skip


class Block(NamedTuple):
    """Contacts that the law takes at a time: columns, and particle i, particle j and entry of the list of each."""

    column: NDArray[np.float64]
    i: NDArray[np.int64]
    j: NDArray[np.int64]
    entry: NDArray[np.int64]


@njit()
def empty_block() -> Block:
    """Allocate room for BLOCK contacts."""
    return Block(np.empty(26 * BLOCK), np.empty(BLOCK, np.int64), np.empty(BLOCK, np.int64), np.empty(BLOCK, np.int64))


@njit(error_model="numpy", fastmath=set(FAST))
def pair_forces(
    state: State,
    spheres: Spheres,
    pairs: Table,
    neighbours: Neighbours,
    image: Array,
    now: float,
    dt: float,
    block: Block,
) -> None:
    """Add the forces and torques of all pairs of particles; `now` is the number of the step, `dt` its length [s]."""
    x, radius, b = state.position, spheres.radius, block.column
    start, entry, history = neighbours.start, neighbours.entry, neighbours.history
    if spheres.equal:
        for k in range(BLOCK):
            _set_constants(b, k, 0, 0, spheres, pairs)
    # not the literal 0, for which numba would compile `_close_block` once more
    touch2, count = 4.0 * radius[0] * radius[0], np.int64(0)
    for i in range(len(x)):
        xi, yi, zi = x[i, 0], x[i, 1], x[i, 2]
        for k in range(start[i], start[i + 1]):
            j = entry[k] & MASK
            dx, dy, dz = xi - x[j, 0], yi - x[j, 1], zi - x[j, 2]
            shift = entry[k] >> BITS
            if shift:
                dx, dy, dz = dx - image[shift, 0], dy - image[shift, 1], dz - image[shift, 2]
            if not spheres.equal:
                touch2 = (radius[i] + radius[j]) ** 2
            distance2 = dx * dx + dy * dy + dz * dz
            if distance2 >= touch2:
                if history[k].first_step >= 0.0:
                    open_contact(history[k])
                continue
            b[DX + count], b[DY + count], b[DZ + count], b[DISTANCE2 + count] = dx, dy, dz, distance2
            block.i[count], block.j[count], block.entry[count] = i, j, k
            count += 1
            if count == BLOCK:
                _close_block(block, count, state, spheres, pairs, history, now, dt)
                count = np.int64(0)
    _close_block(block, count, state, spheres, pairs, history, now, dt)


@njit(error_model="numpy", fastmath=set(FAST), forceinline=True)
def _set_constants(b: Array, k: int, i: int, j: int, spheres: Spheres, pairs: Table) -> None:
    radius, mass = spheres.radius, spheres.mass
    pair = pairs[spheres.material[i], spheres.material[j]]
    b[TOUCH + k] = radius[i] + radius[j]
    b[RADIUS + k] = radius[i] * radius[j] / (radius[i] + radius[j])
    b[MASS + k] = mass[i] * mass[j] / (mass[i] + mass[j])
    b[YOUNGS + k], b[SHEAR + k] = pair.youngs_modulus, pair.shear_modulus
    b[DAMPING_N + k], b[DAMPING_T + k] = pair.damping_normal, pair.damping_tangential
    b[SLIDING + k] = pair.sliding_friction


@njit(error_model="numpy", fastmath=set(FAST), forceinline=True)
def _close_block(
    block: Block,
    count: np.int64,
    state: State,
    spheres: Spheres,
    pairs: Table,
    history: Table,
    now: float,
    dt: float,
) -> None:
    """Gather velocities and springs, apply the law, scatter. An arm is half the distance, `more` of it longer for i."""
    b, v, w, f, q = block.column, state.velocity, state.spin, state.force, state.torque
    radius, kind, unequal = spheres.radius, spheres.material, not spheres.equal
    more, rolls = 0.0, pairs[kind[0], kind[0]].rolling_friction > 0.0 or unequal
    for k in range(count):
        i, j = block.i[k], block.j[k]
        dx, dy, dz = b[DX + k], b[DY + k], b[DZ + k]
        if unequal:
            _set_constants(b, k, i, j, spheres, pairs)
            more = (radius[i] - radius[j]) / np.sqrt(b[DISTANCE2 + k])
        on_i, on_j = 0.5 + 0.5 * more, 0.5 - 0.5 * more
        wx = on_i * w[i, 0] + on_j * w[j, 0]
        wy = on_i * w[i, 1] + on_j * w[j, 1]
        wz = on_i * w[i, 2] + on_j * w[j, 2]
        b[VX + k] = v[i, 0] - v[j, 0] - (wy * dz - wz * dy)
        b[VY + k] = v[i, 1] - v[j, 1] - (wz * dx - wx * dz)
        b[VZ + k] = v[i, 2] - v[j, 2] - (wx * dy - wy * dx)
        past = history[block.entry[k]]
        b[SPRING_X + k], b[SPRING_Y + k], b[SPRING_Z + k] = past.spring_x, past.spring_y, past.spring_z
    _apply_law(b, count, dt)
    for k in range(count):
        i, j = block.i[k], block.j[k]
        past = history[block.entry[k]]
        past.spring_x, past.spring_y, past.spring_z = b[SPRING_X + k], b[SPRING_Y + k], b[SPRING_Z + k]
        if past.first_step < 0.0:
            past.first_step, past.impact_speed = now, abs(b[NORMAL_SPEED + k])
        if unequal:
            more = (radius[i] - radius[j]) / np.sqrt(b[DISTANCE2 + k])
        force, torque = Vector(b[FX + k], b[FY + k], b[FZ + k]), Vector(b[TX + k], b[TY + k], b[TZ + k])
        _add(f, i, force, 1.0)
        _add(f, j, force, -1.0)
        _add(q, i, torque, 1.0 + more)
        _add(q, j, torque, 1.0 - more)
        if rolls:
            _roll(b, k, i, j, state, spheres, pairs[kind[i], kind[j]].rolling_friction, dt)


@njit(error_model="numpy", fastmath=set(FAST))
def _apply_law(b: Array, count: np.int64, dt: float) -> None:
    """Find the columns of forces, torques and springs from those of vectors and velocities."""
    for k in range(count):
        dx, dy, dz = b[DX + k], b[DY + k], b[DZ + k]
        distance = np.sqrt(b[DISTANCE2 + k])
        found = contact_law(
            Vector(dx / distance, dy / distance, dz / distance),
            b[TOUCH + k] - distance,
            Vector(b[VX + k], b[VY + k], b[VZ + k]),
            Vector(b[SPRING_X + k], b[SPRING_Y + k], b[SPRING_Z + k]),
            ContactConstants(
                b[RADIUS + k],
                b[MASS + k],
                b[YOUNGS + k],
                b[SHEAR + k],
                b[DAMPING_N + k],
                b[DAMPING_T + k],
                b[SLIDING + k],
            ),
            dt,
        )
        (fx, fy, fz), b[NORMAL_FORCE + k], spring, b[NORMAL_SPEED + k] = found
        b[SPRING_X + k], b[SPRING_Y + k], b[SPRING_Z + k] = spring
        b[FX + k], b[FY + k], b[FZ + k] = fx, fy, fz
        b[TX + k], b[TY + k], b[TZ + k] = (
            0.5 * (dz * fy - dy * fz),
            0.5 * (dx * fz - dz * fx),
            0.5 * (dy * fx - dx * fy),
        )


@njit(error_model="numpy", fastmath=set(FAST))
def _roll(b: Array, k: int, i: int, j: int, state: State, spheres: Spheres, friction: float, dt: float) -> None:
    w, inertia = state.spin, spheres.inertia
    distance = np.sqrt(b[DISTANCE2 + k])
    torque = rolling_torque(
        Vector(b[DX + k] / distance, b[DY + k] / distance, b[DZ + k] / distance),
        Vector(w[i, 0] - w[j, 0], w[i, 1] - w[j, 1], w[i, 2] - w[j, 2]),
        b[RADIUS + k],
        inertia[i] * inertia[j] / (inertia[i] + inertia[j]),
        friction,
        b[NORMAL_FORCE + k],
        dt,
    )
    _add(state.torque, i, torque, 1.0)
    _add(state.torque, j, torque, -1.0)


@njit(error_model="numpy", fastmath=set(FAST), forceinline=True)
def _add(total: Array, i: int, vector: Vector, factor: float) -> None:
    total[i, 0] += factor * vector.x
    total[i, 1] += factor * vector.y
    total[i, 2] += factor * vector.z


@njit(error_model="numpy", fastmath=set(FAST))
def wall_forces(state: State, spheres: Spheres, pairs: Table, walls: Walls, now: float, dt: float) -> None:
    """Add the forces and torques of walls at rest; a wall counts as a plane of infinite mass."""
    x, v, w = state.position, state.velocity, state.spin
    for entry in range(len(walls.near)):
        i, side = walls.near[entry].particle, walls.near[entry].wall
        gap, nx, ny, nz = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls.surface[side])
        overlap, past = spheres.radius[i] - gap, walls.history[side, i]
        if overlap <= 0.0:
            if past.first_step >= 0.0:
                open_contact(past)
            continue
        pair, normal = pairs[spheres.material[i], walls.surface[side].material], Vector(nx, ny, nz)
        found = contact_law(
            normal,
            overlap,
            Vector(
                v[i, 0] - gap * (w[i, 1] * nz - w[i, 2] * ny),
                v[i, 1] - gap * (w[i, 2] * nx - w[i, 0] * nz),
                v[i, 2] - gap * (w[i, 0] * ny - w[i, 1] * nx),
            ),
            Vector(past.spring_x, past.spring_y, past.spring_z),
            ContactConstants(
                spheres.radius[i],
                spheres.mass[i],
                pair.youngs_modulus,
                pair.shear_modulus,
                pair.damping_normal,
                pair.damping_tangential,
                pair.sliding_friction,
            ),
            dt,
        )
        c = found.force
        past.spring_x, past.spring_y, past.spring_z = found.spring.x, found.spring.y, found.spring.z
        if past.first_step < 0.0:
            past.first_step, past.impact_speed = now, abs(found.normal_speed)
        _add(state.force, i, c, 1.0)
        _add(state.torque, i, Vector(nz * c.y - ny * c.z, nx * c.z - nz * c.x, ny * c.x - nx * c.y), gap)
        if pair.rolling_friction > 0.0:
            torque = rolling_torque(
                normal,
                Vector(w[i, 0], w[i, 1], w[i, 2]),
                spheres.radius[i],
                spheres.inertia[i],
                pair.rolling_friction,
                found.normal_force,
                dt,
            )
            _add(state.torque, i, torque, 1.0)
