"""Forces, torques and heat of the contacts of a block of particles in one pass.

Closed contacts are found along the Verlet list and copied, by column, into a batch that
fits into the first cache. The laws then run over the batch in vector instructions, and
the results are added to the particles and to the histories. What belongs to a particle
of another block is left in `Crossing`, from where the thread that advances it takes it:
so no two threads add to one number, and all sums are taken in an order that does not
depend on the number of threads.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Integers
from contbed.compiled.functions import inner
from contbed.dem.contact import (
    FAST,
    ContactConstants,
    Vector,
    contact_law,
    rolling_torque,
)
from contbed.dem.contact_heat import impact_conductance
from contbed.dem.kernel_arrays import BLOCK, Array, Laws, Side, Spheres, Sums, Table
from contbed.dem.neighbours import BITS, CLOSED, IMAGE, MASK

# contacts: 28 columns of 64 numbers are 14 kB, less than half of the first cache
BATCH = 64
# where the columns of a batch start, all in one array, so that the compiler sees that
# they do not overlap
(
    DX, DY, DZ, DISTANCE2,  # vector from j to i and its square
    VX, VY, VZ,  # velocity of i against j at the contact
    SPRING_X, SPRING_Y, SPRING_Z, NORMAL_SPEED,
    FX, FY, FZ, NORMAL_FORCE,  # on i
    TX, TY, TZ,  # half the vector times the force
    CONTACT_RADIUS,
    MORE,  # by which the arm of i is longer than half the distance, over it
    TOUCH,  # sum of the radii
    RADIUS, MASS, YOUNGS, SHEAR, DAMPING_N, DAMPING_T, SLIDING,  # `ContactConstants`
) = (column * BATCH for column in range(28))  # fmt: skip


class Batch(NamedTuple):
    """Contacts that the law takes at a time: columns, and particle i, particle j and
    place in the list of each.

    `new` : numbers in the batch of contacts that have closed in this step
    """

    column: NDArray[np.float64]
    i: NDArray[np.uint64]
    j: NDArray[np.uint64]
    place: NDArray[np.uint64]
    new: Integers


class Now(NamedTuple):
    """Number of the step, its length [s], what a place exceeds that in `carried` by;
    -1 for pairs within a block.
    """

    step: float
    dt: float
    across: int


@inner(nogil=True)
def empty_batch() -> Batch:
    """Allocate room for BATCH contacts, and for one more that is being looked at."""
    whole = np.empty((3, BATCH + 1), np.uint64)
    return Batch(
        np.empty(28 * BATCH + 1),
        whole[0],
        whole[1],
        whole[2],
        np.empty(BATCH, np.int64),
    )


@inner(error_model="numpy", fastmath=set(FAST), nogil=True)
def pair_forces(
    block: int, side: Side, sums: Sums, laws: Laws, step: float, dt: float, batch: Batch
) -> None:
    """Find forces, torques and heat of the contacts of the rows of a block.

    Parameters
    ----------
    block : its number
    side : the particles in the present order of memory
    sums : `load` and `gained` of the block become those of its contacts; `crossing`
        takes what is for other blocks
    laws : constants of contacts
    step, dt : number of the step, its length [s]
    batch : room
    """
    x = side.bodies.position
    radius = side.spheres.radius
    equal = side.spheres.equal
    b = batch.column
    pairs, entry, image = side.pairs, side.pairs.entry, laws.image
    for i in range(block * BLOCK, min((block + 1) * BLOCK, len(x))):
        sums.load[i, 0], sums.load[i, 1], sums.load[i, 2] = 0.0, 0.0, 0.0
        sums.load[i, 3], sums.load[i, 4], sums.load[i, 5] = 0.0, 0.0, 0.0
        if len(side.heat.T):
            sums.gained[i] = 0.0
    if equal:
        for k in range(BATCH):
            _set_constants(b, k, np.uint64(0), np.uint64(0), side.spheres, laws.pairs)
    touch2 = 4.0 * radius[0] * radius[0]
    for zone in range(2):
        base = block * (pairs.room[0] + pairs.room[1]) + zone * pairs.room[0]
        now = Now(step, dt, base - block * pairs.room[1] if zone else -1)
        last, count, fresh = base + pairs.used[zone, block] - 1, 0, 0
        for k in range(base, last + 1):
            # no branch depends on the image, or on whether the pair touches: it would
            # often be mispredicted
            e, i = entry[k], pairs.row[k]
            j, shift = e & MASK, (e >> BITS) & IMAGE
            dx = x[i, 0] - x[j, 0] - image[shift, 0]
            dy = x[i, 1] - x[j, 1] - image[shift, 1]
            dz = x[i, 2] - x[j, 2] - image[shift, 2]
            if not equal:
                touch2 = (radius[i] + radius[j]) ** 2
            distance2 = dx * dx + dy * dy + dz * dz
            touches, touched = distance2 < touch2, e >= CLOSED
            b[DX + count] = dx
            b[DY + count] = dy
            b[DZ + count] = dz
            b[DISTANCE2 + count] = distance2
            batch.i[count], batch.j[count], batch.place[count] = i, j, k
            if touches != touched:
                entry[k] = e ^ CLOSED
                if touches:
                    pairs.spring[k, 0] = 0.0
                    pairs.spring[k, 1] = 0.0
                    pairs.spring[k, 2] = 0.0
                    batch.new[fresh] = count
                    fresh += 1
                elif zone:
                    for m in range(7):
                        sums.crossing.carried[k - now.across, m] = 0.0
            count += touches
            if count == BATCH or k == last:
                _close_batch(batch, count, fresh, side, sums, laws, now)
                count, fresh = 0, 0


@inner(error_model="numpy", fastmath=set(FAST), forceinline=True)
def _set_constants(
    b: Array,
    k: int,
    i: int | np.uint64,
    j: int | np.uint64,
    spheres: Spheres,
    pairs: Table,
) -> None:
    radius, mass = spheres.radius, spheres.mass
    pair = pairs[spheres.material[i], spheres.material[j]]
    b[TOUCH + k] = radius[i] + radius[j]
    b[RADIUS + k] = radius[i] * radius[j] / (radius[i] + radius[j])
    b[MASS + k] = mass[i] * mass[j] / (mass[i] + mass[j])
    b[YOUNGS + k], b[SHEAR + k] = pair.youngs_modulus, pair.shear_modulus
    b[DAMPING_N + k], b[DAMPING_T + k] = pair.damping_normal, pair.damping_tangential
    b[SLIDING + k] = pair.sliding_friction


@inner(error_model="numpy", fastmath=set(FAST), forceinline=True)
def _close_batch(
    batch: Batch, count: int, fresh: int, side: Side, sums: Sums, laws: Laws, now: Now
) -> None:
    """Gather velocities and springs, apply the laws, add. An arm is half the
    distance, MORE of it longer for i.
    """
    b = batch.column
    motion = side.bodies.motion
    pairs = side.pairs
    spheres = side.spheres
    unequal, more = not spheres.equal, 0.0
    if unequal:
        for k in range(count):
            i, j = batch.i[k], batch.j[k]
            _set_constants(b, k, i, j, spheres, laws.pairs)
            b[MORE + k] = (spheres.radius[i] - spheres.radius[j]) / np.sqrt(
                b[DISTANCE2 + k]
            )
    for k in range(count):
        i, j, m = batch.i[k], batch.j[k], batch.place[k]
        dx, dy, dz = b[DX + k], b[DY + k], b[DZ + k]
        if unequal:
            more = b[MORE + k]
        arm_i, arm_j = 0.5 + 0.5 * more, 0.5 - 0.5 * more
        wx = arm_i * motion[i, 3] + arm_j * motion[j, 3]
        wy = arm_i * motion[i, 4] + arm_j * motion[j, 4]
        wz = arm_i * motion[i, 5] + arm_j * motion[j, 5]
        b[VX + k] = motion[i, 0] - motion[j, 0] - (wy * dz - wz * dy)
        b[VY + k] = motion[i, 1] - motion[j, 1] - (wz * dx - wx * dz)
        b[VZ + k] = motion[i, 2] - motion[j, 2] - (wx * dy - wy * dx)
        b[SPRING_X + k], b[SPRING_Y + k] = pairs.spring[m, 0], pairs.spring[m, 1]
        b[SPRING_Z + k] = pairs.spring[m, 2]
    _apply_law(b, count, now.dt)
    for n in range(fresh):
        k = batch.new[n]
        m = batch.place[k]
        pairs.onset[m, 0], pairs.onset[m, 1] = now.step, abs(b[NORMAL_SPEED + k])
    _add_contacts(batch, count, unequal, pairs.spring, sums, now.across)
    if (
        unequal
        or laws.pairs[spheres.material[0], spheres.material[0]].rolling_friction > 0.0
    ):
        for k in range(count):
            _roll(batch, k, side, sums, laws.pairs, now)
    if len(side.heat.T):
        _exchange_heat(batch, count, side, sums, laws, now)


@inner(error_model="numpy", fastmath=set(FAST))
def _add_contacts(
    batch: Batch, count: int, unequal: bool, spring: Array, sums: Sums, across: int
) -> None:
    """Keep the springs; add forces and torques to particles i and j, or to what is
    carried to another block.
    """
    b, load, carried, more = batch.column, sums.load, sums.crossing.carried, 0.0
    for k in range(count):
        i, j, m = batch.i[k], batch.j[k], batch.place[k]
        if unequal:
            more = b[MORE + k]
        fx = b[FX + k]
        fy = b[FY + k]
        fz = b[FZ + k]
        tx = b[TX + k]
        ty = b[TY + k]
        tz = b[TZ + k]
        spring[m, 0] = b[SPRING_X + k]
        spring[m, 1] = b[SPRING_Y + k]
        spring[m, 2] = b[SPRING_Z + k]
        add(
            load,
            i,
            Vector(fx, fy, fz),
            Vector(tx + more * tx, ty + more * ty, tz + more * tz),
        )
        torque = Vector(tx - more * tx, ty - more * ty, tz - more * tz)
        if across < 0:
            add(load, j, Vector(-fx, -fy, -fz), torque)
        else:
            to = carried[m - across]
            to[0], to[1], to[2] = -fx, -fy, -fz
            to[3], to[4], to[5] = torque


@inner(error_model="numpy", fastmath=set(FAST), forceinline=True)
def _exchange_heat(
    batch: Batch, count: int, side: Side, sums: Sums, laws: Laws, now: Now
) -> None:
    """Add the heat [W] that flows through the contacts of a batch."""
    b = batch.column
    T = side.heat.T
    kind = side.spheres.material
    onset = side.pairs.onset
    for k in range(count):
        i, j, m = batch.i[k], batch.j[k], batch.place[k]
        pair = laws.heat[kind[i], kind[j]]
        conductance = pair.at_rest * b[CONTACT_RADIUS + k]
        speed, age = onset[m, 1], now.step - onset[m, 0]
        if speed > 0.0:
            contact = Vector(b[RADIUS + k], b[MASS + k], b[YOUNGS + k])
            conductance = impact_conductance(
                conductance, pair, contact, speed, age, now.dt
            )
        flow = conductance * (T[j] - T[i])
        sums.gained[i] += flow
        if now.across < 0:
            sums.gained[j] -= flow
        else:
            sums.crossing.carried[m - now.across, 6] = -flow


@inner(error_model="numpy", fastmath=set(FAST))
def _apply_law(b: Array, count: int, dt: float) -> None:
    """Find the columns of forces, torques and springs from those of vectors and
    velocities.
    """
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
        b[CONTACT_RADIUS + k] = np.sqrt(b[RADIUS + k] * (b[TOUCH + k] - distance))
        b[FX + k], b[FY + k], b[FZ + k] = fx, fy, fz
        b[TX + k] = 0.5 * (dz * fy - dy * fz)
        b[TY + k] = 0.5 * (dx * fz - dz * fx)
        b[TZ + k] = 0.5 * (dy * fx - dx * fy)


@inner(error_model="numpy", fastmath=set(FAST))
def _roll(batch: Batch, k: int, side: Side, sums: Sums, pairs: Table, now: Now) -> None:
    """Add the torque against rolling of a contact of a batch."""
    b = batch.column
    i = batch.i[k]
    j = batch.j[k]
    motion = side.bodies.motion
    spheres = side.spheres
    inertia, distance, load = spheres.inertia, np.sqrt(b[DISTANCE2 + k]), sums.load
    torque = rolling_torque(
        Vector(b[DX + k] / distance, b[DY + k] / distance, b[DZ + k] / distance),
        Vector(
            motion[i, 3] - motion[j, 3],
            motion[i, 4] - motion[j, 4],
            motion[i, 5] - motion[j, 5],
        ),
        b[RADIUS + k],
        inertia[i] * inertia[j] / (inertia[i] + inertia[j]),
        pairs[spheres.material[i], spheres.material[j]].rolling_friction,
        b[NORMAL_FORCE + k],
        now.dt,
    )
    for a in range(3):
        load[i, 3 + a] += torque[a]
        if now.across < 0:
            load[j, 3 + a] -= torque[a]
        else:
            sums.crossing.carried[batch.place[k] - now.across, 3 + a] -= torque[a]


@inner(error_model="numpy", fastmath=set(FAST), forceinline=True)
def add(load: Array, i: int, force: Vector, torque: Vector) -> None:
    """Add a force [N] and a torque [N m] to those of a particle."""
    load[i, 0] += force.x
    load[i, 1] += force.y
    load[i, 2] += force.z
    load[i, 3] += torque.x
    load[i, 4] += torque.y
    load[i, 5] += torque.z
