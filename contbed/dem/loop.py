"""The time loop: velocity Verlet, forces, heat of contacts, neighbours and blow-up detection in one compiled kernel.

Each step kicks by half a step, moves, and finds the forces at the new positions with velocities extrapolated by half a
step, so that dashpots are of second order too. The two half kicks between steps are rounded in the same way whether or
not an interval ends there: a run cut into intervals gives what the uncut run gives, bit for bit.
"""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np
from numba import njit

from contbed.dem import contact, forces, heat_impact, neighbours, particles
from contbed.dem import contact_heat as conduction
from contbed.dem.contact_heat import contact_heat
from contbed.dem.forces import pair_forces, wall_forces, workspace
from contbed.dem.neighbours import carry_over, half_list, shifts, wall_list, wrap

OK, TOO_FAST, LOST, BEYOND_WALL = range(4)  # how an interval ends


@njit(error_model="numpy")
def _advance(x, v, w, vh, wh, f, q, per_mass, per_inertia, force, gravity, dt, fresh, limit2):
    """Finish the last step, unless `fresh`, and begin the next; largest speed squared, a particle above it or -1."""
    half, worst, top = 0.5 * dt, -1, 0.0
    for i in range(len(x)):
        speed2 = 0.0
        for a in range(3):
            rate, spin = f[i, a] * per_mass[i] + gravity[a], q[i, a] * per_inertia[i]
            vi = v[i, a] if fresh else vh[i, a] + half * rate
            wi = w[i, a] if fresh else wh[i, a] + half * spin
            u, s = vi + half * rate, wi + half * spin
            vh[i, a], wh[i, a] = u, s
            v[i, a], w[i, a] = u + half * rate, s + half * spin
            x[i, a] += dt * u
            speed2 += u * u
            f[i, a], q[i, a] = force[i, a], 0.0
        if not speed2 <= limit2:  # a NaN is never below
            worst = i
        top = max(top, speed2)
    return top, worst


@njit(error_model="numpy")
def _finish(v, w, vh, wh, f, q, per_mass, per_inertia, gravity, dt):
    """The second half kick of the last step, in strict arithmetic as in `_advance`."""
    for i in range(len(v)):
        for a in range(3):
            v[i, a] = vh[i, a] + 0.5 * dt * (f[i, a] * per_mass[i] + gravity[a])
            w[i, a] = wh[i, a] + 0.5 * dt * (q[i, a] * per_inertia[i])


@njit(error_model="numpy")
def _moved(x, x0):
    """Largest distance from the positions at which the list was made [m]."""
    top = 0.0
    for i in range(len(x)):
        top = max(top, (x[i, 0] - x0[i, 0]) ** 2 + (x[i, 1] - x0[i, 1]) ** 2 + (x[i, 2] - x0[i, 2]) ** 2)
    return np.sqrt(top)


@njit
def _steps(
    x,
    v,
    w,
    f,
    q,
    x0,
    start,
    mates,
    past,
    near,
    wall_past,
    radius,
    mass,
    inertia,
    kind,
    table,
    walls,
    wall_kind,
    lower,
    upper,
    periodic,
    gravity,
    force,
    uniform,
    dt,
    skin,
    limit,
    reach,
    first,
    steps,
    rebuild,
    T,
    source,
    per_capacity,
    heat_table,
):
    vh, wh, per_mass, per_inertia = np.empty_like(v), np.empty_like(w), 1.0 / mass, 1.0 / inertia
    image = shifts(lower, upper, periodic)
    block, rows = workspace()
    gained = np.empty_like(T)
    status, culprit, done = OK, -1, 0
    for step in range(steps):
        fastest2, culprit = _advance(
            x, v, w, vh, wh, f, q, per_mass, per_inertia, force, gravity, dt, step == 0, limit * limit
        )
        if culprit >= 0:
            status = TOO_FAST
            break
        reach += np.sqrt(fastest2) * dt
        if reach > 0.5 * skin:
            reach = _moved(x, x0)
        if rebuild or reach > 0.5 * skin:
            culprit = wrap(x, lower, upper, periodic)
            if culprit >= 0:
                status = LOST
                break
            near, culprit = wall_list(x, radius, walls, skin)
            if culprit >= 0:
                status = BEYOND_WALL
                break
            new_start, new_mates = half_list(x, radius, lower, upper, periodic, skin)
            past = carry_over(start, mates, past, new_start, new_mates)
            start, mates = new_start, new_mates
            x0[:] = x
            reach, rebuild = 0.0, False
        now = float(first + step + 1)
        pair_forces(
            x, v, w, f, q, radius, mass, inertia, kind, uniform, table, image, start, mates, past, now, dt, block, rows
        )
        wall_forces(x, v, w, f, q, radius, mass, inertia, kind, table, walls, wall_kind, near, wall_past, now, dt)
        if len(T):
            contact_heat(
                x,
                T,
                source,
                per_capacity,
                radius,
                mass,
                kind,
                table,
                heat_table,
                image,
                start,
                mates,
                past,
                now,
                dt,
                gained,
            )
        done += 1
    if status == OK and steps > 0:
        _finish(v, w, vh, wh, f, q, per_mass, per_inertia, gravity, dt)
    return status, culprit, done, reach, start, mates, past, near


def _compiled(stamp: int):
    """The kernel, cached on disk for this content of its files: numba itself watches one of them."""

    @njit(cache=True)
    def kernel(*state):
        return (_steps(*state), stamp)[0]

    return kernel


def _content() -> int:
    files = (Path(str(module.__file__)) for module in (contact, conduction, forces, heat_impact, neighbours, particles))
    return zlib.crc32(b"".join(file.read_bytes() for file in files))


run_steps = _compiled(_content())
