"""A step of the particles on a GPU: contacts, walls, heat, both half kicks and the
move, one thread for a particle.

Equations and order are those of `loop`. Rows are read from one array and written to
another, so that all threads see the particles as they were. Many steps are one call of
a kernel, whose threads meet after each: to send a call takes 0.3 ms, the step of 16,000
particles less. So all blocks must be on the GPU at once, and each thread goes through
particles. A step that moves a particle farther than half the skin from where its list
was made, or finds it too fast, ends the call.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from numba import int64

from contbed.dem.contact import ContactConstants, Vector, contact_law, rolling_torque
from contbed.dem.contact_heat import impact_conductance
from contbed.dem.gpu.arrays import (
    CULPRIT,
    MASS,
    RADIUS,
    STOP,
    TEMPERATURE,
    VX,
    VY,
    VZ,
    WX,
    WY,
    WZ,
    Around,
    Bodies,
    DeviceArray,
    Lists,
    X,
    Y,
    Z,
    cuda,
)
from contbed.dem.neighbours import BITS, CLOSED, IMAGE, MASK, wall_distance
from contbed.dem.wall_forces import Ball, wall_force

THREADS = 128  # of a block
# of a thread, of 65,536; with 96, and 5 blocks for 3, a step takes 1.1 to 1.4 times as
# long
REGISTERS = 168
RESIDENT = 65_536 // (REGISTERS * THREADS)  # blocks on a multiprocessor


class Steps(NamedTuple):
    """Steps of an interval: those from `first` to before `end`, of `total`; all counted
    from the start of a call.

    number : of step 0 since the start of the simulation
    dt : length [s]; begins : whether the first half of step `first` is still to be
        taken
    enough2 : square of the distance [m2] after which the list is too old; speed2 : of
        the largest speed [m2/s2]
    gravity : [m/s2], three numbers
    is_pushed, is_warm, rolls : whether there are external forces, temperatures, rolling
        friction
    """

    first: int
    end: int
    total: int
    number: int
    dt: float
    begins: bool
    enough2: float
    speed2: float
    gravity: tuple[float, float, float]
    is_pushed: bool
    is_warm: bool
    rolls: bool


def resident_blocks() -> int:
    """Return how many blocks of `take_steps` the GPU holds at once."""
    return RESIDENT * int(cuda.get_current_device().MULTIPROCESSOR_COUNT)


@cuda.jit(max_registers=REGISTERS)
def take_steps(
    row: DeviceArray,
    new: DeviceArray,
    bodies: Bodies,
    lists: Lists,
    around: Around,
    steps: Steps,
) -> None:
    """Take steps; all threads meet after each, and end early where a list is too old or
    a particle too fast.

    The last step of an interval ends with velocities at the time of the positions; all
    others with the first half of the next one. `new` is where the first step writes to,
    and each further one where the one before has read.
    """
    grid, first, stride = cuda.cg.this_grid(), cuda.grid(1), cuda.gridsize(1)
    load = around.load
    if steps.begins:
        for i in range(first, row.shape[0], stride):
            rates = _rates(
                row,
                i,
                steps.gravity,
                (load[i, 0], load[i, 1], load[i, 2]),
                (load[i, 3], load[i, 4], load[i, 5]),
            )
            for a in range(6):
                _kick_and_move(
                    row, row, bodies.half, i, a, row[i, VX + a], rates[a], steps.dt
                )
            _look(row, bodies.half, lists.listed, around.control, i, steps, steps.first)
        grid.sync()
    for k in range(steps.first, steps.end):
        # what a step finds stops those after it, so that all threads see the same
        if around.control[STOP] <= k:
            return
        for i in range(first, row.shape[0], stride):
            _advance(i, k, row, new, bodies, lists, around, steps)
        row, new = new, row
        grid.sync()


@cuda.jit(device=True)
def _advance(i, k, row, new, bodies, lists, around, steps):
    """Take step k of particle i, up to the first half of the next one unless it is
    the last.
    """
    number, load = float(steps.number + k), around.load
    force, torque, gained = _contacts(
        i, number, row, bodies.material, lists, around, steps
    )
    fx, fy, fz, tx, ty, tz = force.x, force.y, force.z, torque.x, torque.y, torque.z
    for w in range(len(around.walls)):
        push, turn = _at_wall(
            i, w, number, row, bodies.material, lists, around, steps.dt
        )
        fx += push.x
        fy += push.y
        fz += push.z
        tx += turn.x
        ty += turn.y
        tz += turn.z
    if steps.is_pushed:
        fx += bodies.pushed[i, 0]
        fy += bodies.pushed[i, 1]
        fz += bodies.pushed[i, 2]
    new[i, RADIUS] = row[i, RADIUS]
    new[i, MASS] = row[i, MASS]
    new[i, TEMPERATURE] = row[i, TEMPERATURE]
    if steps.is_warm:
        new[i, TEMPERATURE] += (
            steps.dt * (gained + bodies.heat[i, 0]) * bodies.heat[i, 1]
        )
    half, rates = bodies.half, _rates(row, i, steps.gravity, (fx, fy, fz), (tx, ty, tz))
    for a in range(6):
        v = cuda.fma(0.5 * steps.dt, rates[a], half[i, a])
        if k == steps.total - 1:
            new[i, VX + a] = v
        else:
            _kick_and_move(row, new, half, i, a, v, rates[a], steps.dt)
    if k == steps.total - 1:
        new[i, X], new[i, Y], new[i, Z] = row[i, X], row[i, Y], row[i, Z]
        load[i, 0] = fx
        load[i, 1] = fy
        load[i, 2] = fz
        load[i, 3] = tx
        load[i, 4] = ty
        load[i, 5] = tz
    else:
        _look(new, half, lists.listed, around.control, i, steps, k + 1)


# Products and sums that a compiler may or may not round at once are written as one
# operation: so an interval that is cut gives the bits of one that is not.


@cuda.jit(device=True)
def _rates(row, i, gravity, force, torque):
    """Find the acceleration [m/s2] and the rate of the spin [rad/s2]."""
    per_mass = 1.0 / row[i, MASS]
    per_inertia = per_mass / (0.4 * row[i, RADIUS] * row[i, RADIUS])
    return (
        cuda.fma(force[0], per_mass, gravity[0]),
        cuda.fma(force[1], per_mass, gravity[1]),
        cuda.fma(force[2], per_mass, gravity[2]),
        torque[0] * per_inertia,
        torque[1] * per_inertia,
        torque[2] * per_inertia,
    )


@cuda.jit(device=True)
def _kick_and_move(row, new, half, i, a, v, rate, dt):
    """From the velocity or spin at the time of the position to that half a step
    later, and the move between.
    """
    u = cuda.fma(0.5 * dt, rate, v)
    half[i, a], new[i, VX + a] = u, cuda.fma(0.5 * dt, rate, u)
    if a < 3:
        new[i, X + a] = cuda.fma(dt, u, row[i, X + a])


@cuda.jit(device=True)
def _look(row, half, listed, control, i, steps, done):
    """Stop later steps if a particle is too fast, or too far from where its list was
    made.
    """
    speed2 = half[i, 0] ** 2 + half[i, 1] ** 2 + half[i, 2] ** 2
    moved2 = (
        (row[i, X] - listed[i, 0]) ** 2
        + (row[i, Y] - listed[i, 1]) ** 2
        + (row[i, Z] - listed[i, 2]) ** 2
    )
    if not speed2 <= steps.speed2:  # a NaN is never below
        cuda.atomic.min(control, CULPRIT, i)
        cuda.atomic.min(control, STOP, done)
    elif moved2 > steps.enough2:
        cuda.atomic.min(control, STOP, done)


@cuda.jit(device=True)
def _contacts(i, number, row, material, lists, around, steps):
    """Sum force [N], torque [N m] and heat [W] of the contacts of particle i with
    others, and keep their histories.
    """
    fx, fy, fz, tx, ty, tz, gained = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z, radius = row[i, X], row[i, Y], row[i, Z], row[i, RADIUS]
    entry, spring, onset = lists.entry, lists.spring, lists.onset
    image = around.image
    for k in range(lists.neighbours[i]):
        e = entry[k, i]
        j, shift = int64(e & MASK), int64((e >> BITS) & IMAGE)
        dx = x - row[j, X] - image[shift, 0]
        dy = y - row[j, Y] - image[shift, 1]
        dz = z - row[j, Z] - image[shift, 2]
        touch, distance2 = radius + row[j, RADIUS], dx * dx + dy * dy + dz * dz
        if distance2 >= touch * touch:
            if e >= CLOSED:
                entry[k, i] = e ^ CLOSED
            continue
        # both particles compute the force on the one of lower index, in the same order:
        # their bits agree
        a, b, sign = i, j, 1.0
        if j < i:
            a, b, sign = j, i, -1.0
        dx, dy, dz = sign * dx, sign * dy, sign * dz
        distance = sqrt(distance2)
        more = (row[a, RADIUS] - row[b, RADIUS]) / distance
        arm_a, arm_b = 0.5 + 0.5 * more, 0.5 - 0.5 * more
        wx = arm_a * row[a, WX] + arm_b * row[b, WX]
        wy = arm_a * row[a, WY] + arm_b * row[b, WY]
        wz = arm_a * row[a, WZ] + arm_b * row[b, WZ]
        velocity = Vector(
            row[a, VX] - row[b, VX] - (wy * dz - wz * dy),
            row[a, VY] - row[b, VY] - (wz * dx - wx * dz),
            row[a, VZ] - row[b, VZ] - (wx * dy - wy * dx),
        )
        before = Vector(0.0, 0.0, 0.0)
        if e >= CLOSED:
            before = Vector(spring[k, 0, i], spring[k, 1, i], spring[k, 2, i])
        pair = around.pairs[material[a], material[b]]
        r_eff = row[a, RADIUS] * row[b, RADIUS] / touch
        m_eff = row[a, MASS] * row[b, MASS] / (row[a, MASS] + row[b, MASS])
        normal = Vector(dx / distance, dy / distance, dz / distance)
        found = contact_law(
            normal,
            touch - distance,
            velocity,
            before,
            ContactConstants(
                r_eff,
                m_eff,
                pair.youngs_modulus,
                pair.shear_modulus,
                pair.damping_normal,
                pair.damping_tangential,
                pair.sliding_friction,
            ),
            steps.dt,
        )
        spring[k, 0, i] = found.spring.x
        spring[k, 1, i] = found.spring.y
        spring[k, 2, i] = found.spring.z
        if e < CLOSED:
            entry[k, i] = e | CLOSED
            onset[k, 0, i], onset[k, 1, i] = number, abs(found.normal_speed)
        c, arm = found.force, arm_a if a == i else arm_b
        fx, fy, fz = fx + sign * c.x, fy + sign * c.y, fz + sign * c.z
        tx += arm * (dz * c.y - dy * c.z)
        ty += arm * (dx * c.z - dz * c.x)
        tz += arm * (dy * c.x - dx * c.y)
        if steps.rolls:
            inertia_a = 0.4 * row[a, MASS] * row[a, RADIUS] * row[a, RADIUS]
            inertia_b = 0.4 * row[b, MASS] * row[b, RADIUS] * row[b, RADIUS]
            roll = rolling_torque(
                normal,
                Vector(
                    row[a, WX] - row[b, WX],
                    row[a, WY] - row[b, WY],
                    row[a, WZ] - row[b, WZ],
                ),
                r_eff,
                inertia_a * inertia_b / (inertia_a + inertia_b),
                pair.rolling_friction,
                found.normal_force,
                steps.dt,
            )
            tx, ty, tz = tx + sign * roll.x, ty + sign * roll.y, tz + sign * roll.z
        if steps.is_warm:
            thermal = around.heat[material[a], material[b]]
            conductance = thermal.at_rest * sqrt(r_eff * (touch - distance))
            speed = onset[k, 1, i]
            if speed > 0.0:
                contact = Vector(r_eff, m_eff, pair.youngs_modulus)
                age = number - onset[k, 0, i]
                conductance = impact_conductance(
                    conductance, thermal, contact, speed, age, steps.dt
                )
            gained += sign * (conductance * (row[b, TEMPERATURE] - row[a, TEMPERATURE]))
    return Vector(fx, fy, fz), Vector(tx, ty, tz), gained


@cuda.jit(device=True)
def _at_wall(i, w, number, row, material, lists, around, dt):
    """Find force [N] and torque [N m] of a wall at rest, and keep the history of the
    contact.
    """
    spring, onset, nothing = lists.wall_spring, lists.wall_onset, Vector(0.0, 0.0, 0.0)
    wall = around.walls[w]
    gap, nx, ny, nz = wall_distance(row[i, X], row[i, Y], row[i, Z], wall)
    is_open = onset[w, 0, i] < 0.0
    if row[i, RADIUS] <= gap:
        if not is_open:
            onset[w, 0, i], onset[w, 1, i] = -1.0, 0.0
            for a in range(3):
                spring[w, a, i] = 0.0
        return nothing, nothing
    mass, radius = row[i, MASS], row[i, RADIUS]
    ball = Ball(
        Vector(row[i, VX], row[i, VY], row[i, VZ]),
        Vector(row[i, WX], row[i, WY], row[i, WZ]),
        radius,
        mass,
        0.4 * mass * radius * radius,
    )
    before = Vector(spring[w, 0, i], spring[w, 1, i], spring[w, 2, i])
    found = wall_force(
        ball,
        gap,
        Vector(nx, ny, nz),
        before,
        around.pairs[material[i], wall.material],
        dt,
    )
    spring[w, 0, i] = found.spring.x
    spring[w, 1, i] = found.spring.y
    spring[w, 2, i] = found.spring.z
    if is_open:
        onset[w, 0, i], onset[w, 1, i] = number, abs(found.normal_speed)
    return found.force, found.torque
