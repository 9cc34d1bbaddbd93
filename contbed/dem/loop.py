"""The time loop: velocity Verlet, forces, heat of contacts, neighbours and blow-up detection in one compiled kernel.

Each step kicks by half a step, moves, and finds the forces at the new positions with velocities extrapolated by half a
step, so that dashpots are of second order too. The two half kicks between steps are rounded in the same way whether or
not an interval ends there: a run cut into intervals gives what the uncut run gives, bit for bit.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contbed.dem import contact, forces, heat_impact, kernel_arrays, neighbours
from contbed.dem import contact_heat as conduction
from contbed.dem.contact_heat import contact_heat
from contbed.dem.forces import empty_block, pair_forces, wall_forces
from contbed.dem.kernel_arrays import Array, Box, Heat, Interval, Neighbours, Spheres, State, Table, Walls
from contbed.dem.neighbours import carry_over, half_list, image_shifts, wall_list, wrap

OK, TOO_FAST, LOST, BEYOND_WALL = range(4)  # how an interval ends


class HalfStep(NamedTuple):
    """Velocities between two steps, and what turns forces and torques into accelerations: 1/m (n,) and 1/I (n,)."""

    velocity: NDArray[np.float64]
    spin: NDArray[np.float64]
    inverse_mass: NDArray[np.float64]
    inverse_inertia: NDArray[np.float64]


class Outcome(NamedTuple):
    """How an interval ended: status, the particle to blame or -1, steps completed, and what has changed."""

    status: int
    particle: int
    done: int
    moved: float
    neighbours: Neighbours
    walls: Walls


@njit(error_model="numpy")
def _advance(
    state: State, half: HalfStep, force: Array, gravity: Array, dt: float, fresh: bool, limit2: float
) -> tuple[float, int]:
    """Finish the last step of velocity Verlet, unless `fresh`, and begin the next one.

    Returns the largest speed squared and a particle above the limit or -1. `force` [N] is the external one, which is
    what the next sum of forces starts from.
    """
    x, v, w, f, q = state
    vh, wh = half.velocity, half.spin
    h, worst, top = 0.5 * dt, -1, 0.0
    for i in range(len(x)):
        speed2 = 0.0
        for a in range(3):
            rate, turn = f[i, a] * half.inverse_mass[i] + gravity[a], q[i, a] * half.inverse_inertia[i]
            vi = v[i, a] if fresh else vh[i, a] + h * rate
            wi = w[i, a] if fresh else wh[i, a] + h * turn
            u, s = vi + h * rate, wi + h * turn
            vh[i, a], wh[i, a] = u, s
            v[i, a], w[i, a] = u + h * rate, s + h * turn
            x[i, a] += dt * u
            speed2 += u * u
            f[i, a], q[i, a] = force[i, a], 0.0
        if not speed2 <= limit2:  # a NaN is never below
            worst = i
        top = max(top, speed2)
    return top, worst


@njit(error_model="numpy")
def _finish(state: State, half: HalfStep, gravity: Array, dt: float) -> None:
    """Apply the second half kick of the last step, in strict arithmetic as in `_advance`."""
    _, v, w, f, q = state
    for i in range(len(v)):
        for a in range(3):
            v[i, a] = half.velocity[i, a] + 0.5 * dt * (f[i, a] * half.inverse_mass[i] + gravity[a])
            w[i, a] = half.spin[i, a] + 0.5 * dt * (q[i, a] * half.inverse_inertia[i])


@njit(error_model="numpy")
def _largest_move(x: Array, x0: Array) -> float:
    """Find the largest distance from the positions at which the list was made [m]."""
    top = 0.0
    for i in range(len(x)):
        top = max(top, (x[i, 0] - x0[i, 0]) ** 2 + (x[i, 1] - x0[i, 1]) ** 2 + (x[i, 2] - x0[i, 2]) ** 2)
    return float(np.sqrt(top))


@njit()
def _steps(
    state: State,
    spheres: Spheres,
    pairs: Table,
    walls: Walls,
    box: Box,
    neighbours: Neighbours,
    heat: Heat,
    interval: Interval,
) -> Outcome:
    half = HalfStep(np.empty_like(state.velocity), np.empty_like(state.spin), 1.0 / spheres.mass, 1.0 / spheres.inertia)
    image, block, x = image_shifts(box), empty_block(), state.position
    dt, skin, limit2 = interval.time_step, interval.skin, interval.speed_limit * interval.speed_limit
    status, culprit, done, moved, stale = OK, -1, 0, interval.moved, interval.stale
    for step in range(interval.steps):
        fastest2, culprit = _advance(state, half, interval.force, interval.gravity, dt, step == 0, limit2)
        if culprit >= 0:
            status = TOO_FAST
            break
        moved += np.sqrt(fastest2) * dt
        if moved > 0.5 * skin:
            moved = _largest_move(x, neighbours.listed)
        if stale or moved > 0.5 * skin:
            culprit = wrap(x, box)
            if culprit >= 0:
                status = LOST
                break
            near, culprit = wall_list(x, spheres.radius, walls.surface, skin)
            walls = Walls(walls.surface, near, walls.history)
            if culprit >= 0:
                status = BEYOND_WALL
                break
            start, entry = half_list(x, spheres.radius, box, skin)
            for i in range(len(x)):
                for a in range(3):
                    neighbours.listed[i, a] = x[i, a]
            neighbours = Neighbours(start, entry, carry_over(neighbours, start, entry), neighbours.listed)
            moved, stale = 0.0, False
        now = float(interval.first + step + 1)
        pair_forces(state, spheres, pairs, neighbours, image, now, dt, block)
        wall_forces(state, spheres, pairs, walls, now, dt)
        if len(heat.T):
            contact_heat(x, heat, spheres, pairs, neighbours, image, now, dt)
        done += 1
    if status == OK and interval.steps > 0:
        _finish(state, half, interval.gravity, dt)
    return Outcome(status, culprit, done, moved, neighbours, walls)


def _compiled(stamp: int) -> Callable[..., Outcome]:
    """Compile the kernel, cached on disk for this content of its files: numba itself watches one of them."""

    @njit(cache=True)
    def kernel(*state: Any) -> Any:
        return (_steps(*state), stamp)[0]

    return cast("Callable[..., Outcome]", kernel)


def _content() -> int:
    files = (
        Path(str(module.__file__)) for module in (contact, conduction, forces, heat_impact, kernel_arrays, neighbours)
    )
    return zlib.crc32(b"".join(file.read_bytes() for file in files))


run_steps = _compiled(_content())
