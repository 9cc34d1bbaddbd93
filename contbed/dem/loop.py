"""The time loop: velocity Verlet, forces of pairs and walls, neighbours and blow-up detection in one compiled kernel.

Each step kicks by half a step, moves, and finds the forces at the new positions with velocities extrapolated by half a
step, so that dashpots are of second order too. The two half kicks between steps are rounded in the same way whether or
not an interval ends there: a run cut into intervals gives what the uncut run gives, bit for bit.
"""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np
from numba import njit

from contbed.dem import contact, neighbours, particles
from contbed.dem.contact import FAST, SINCE, contact_force, rolling_torque
from contbed.dem.neighbours import BITS, MASK, carry_over, half_list, shifts, wall_distance, wall_list, wrap
from contbed.dem.particles import ROLL

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


@njit(error_model="numpy", fastmath=set(FAST))
def _pair_forces(x, v, w, f, q, radius, mass, inertia, kind, uniform, table, image, start, mates, past, now, dt):
    """Add the forces and torques of all pairs to `f` and `q`."""
    pair = table[kind[0], kind[0]]
    ri = rj = radius[0]
    r_eff, m_eff, i_eff = 0.5 * radius[0], 0.5 * mass[0], 0.5 * inertia[0]
    for i in range(len(x)):
        xi, yi, zi = x[i, 0], x[i, 1], x[i, 2]
        ui, vi, wi = v[i, 0], v[i, 1], v[i, 2]
        ai, bi, ci = w[i, 0], w[i, 1], w[i, 2]
        fx, fy, fz, qx, qy, qz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if not uniform:
            ri = radius[i]
        for k in range(start[i], start[i + 1]):
            j = mates[k] & MASK
            dx, dy, dz = xi - x[j, 0], yi - x[j, 1], zi - x[j, 2]
            shift = mates[k] >> BITS
            if shift:
                dx, dy, dz = dx - image[shift, 0], dy - image[shift, 1], dz - image[shift, 2]
            if not uniform:
                rj = radius[j]
            far2 = dx * dx + dy * dy + dz * dz
            if far2 >= (ri + rj) * (ri + rj):
                if past[k, SINCE] >= 0.0:
                    past[k, :] = 0.0
                    past[k, SINCE] = -1.0
                continue
            if not uniform:
                pair = table[kind[i], kind[j]]
                r_eff = ri * rj / (ri + rj)
                m_eff = mass[i] * mass[j] / (mass[i] + mass[j])
                i_eff = inertia[i] * inertia[j] / (inertia[i] + inertia[j])
            far = np.sqrt(far2)
            nx, ny, nz = dx / far, dy / far, dz / far
            overlap = ri + rj - far
            arm_i, arm_j = ri - 0.5 * overlap, rj - 0.5 * overlap
            sx, sy, sz = arm_i * ai + arm_j * w[j, 0], arm_i * bi + arm_j * w[j, 1], arm_i * ci + arm_j * w[j, 2]
            cx, cy, cz, normal = contact_force(
                nx, ny, nz, overlap,
                ui - v[j, 0] - (sy * nz - sz * ny),
                vi - v[j, 1] - (sz * nx - sx * nz),
                wi - v[j, 2] - (sx * ny - sy * nx),
                r_eff, m_eff, pair, past[k], now, dt,
            )  # fmt: skip
            if pair[ROLL] > 0.0:
                wx, wy, wz = ai - w[j, 0], bi - w[j, 1], ci - w[j, 2]
                tx, ty, tz = rolling_torque(nx, ny, nz, wx, wy, wz, r_eff, i_eff, pair[ROLL], normal, dt)
                _add(q, i, tx, ty, tz)
                _add(q, j, -tx, -ty, -tz)
            mx, my, mz = ny * cz - nz * cy, nz * cx - nx * cz, nx * cy - ny * cx
            fx, fy, fz = fx + cx, fy + cy, fz + cz
            qx, qy, qz = qx - arm_i * mx, qy - arm_i * my, qz - arm_i * mz
            _add(f, j, -cx, -cy, -cz)
            _add(q, j, -arm_j * mx, -arm_j * my, -arm_j * mz)
        _add(f, i, fx, fy, fz)
        _add(q, i, qx, qy, qz)


@njit(forceinline=True)
def _add(total, i, x, y, z):
    total[i, 0] += x
    total[i, 1] += y
    total[i, 2] += z


@njit(error_model="numpy", fastmath=set(FAST))
def _wall_forces(x, v, w, f, q, radius, mass, inertia, kind, table, walls, wall_kind, near, past, now, dt):
    """Add the forces and torques of walls at rest; a wall counts as a plane of infinite mass."""
    for entry in range(len(near)):
        i, side = near[entry, 0], near[entry, 1]
        gap, nx, ny, nz = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls[side])
        history = past[side, i]
        overlap = radius[i] - gap
        if overlap <= 0.0:
            if history[SINCE] >= 0.0:
                history[:] = 0.0
                history[SINCE] = -1.0
            continue
        pair = table[kind[i], wall_kind[side]]
        cx, cy, cz, normal = contact_force(
            nx, ny, nz, overlap,
            v[i, 0] - gap * (w[i, 1] * nz - w[i, 2] * ny),
            v[i, 1] - gap * (w[i, 2] * nx - w[i, 0] * nz),
            v[i, 2] - gap * (w[i, 0] * ny - w[i, 1] * nx),
            radius[i], mass[i], pair, history, now, dt,
        )  # fmt: skip
        _add(f, i, cx, cy, cz)
        _add(q, i, -gap * (ny * cz - nz * cy), -gap * (nz * cx - nx * cz), -gap * (nx * cy - ny * cx))
        if pair[ROLL] > 0.0:
            tx, ty, tz = rolling_torque(
                nx, ny, nz, w[i, 0], w[i, 1], w[i, 2], radius[i], inertia[i], pair[ROLL], normal, dt
            )  # fmt: skip
            _add(q, i, tx, ty, tz)


@njit(error_model="numpy")
def _moved(x, x0):
    """Largest distance from the positions at which the list was made [m]."""
    top = 0.0
    for i in range(len(x)):
        top = max(top, (x[i, 0] - x0[i, 0]) ** 2 + (x[i, 1] - x0[i, 1]) ** 2 + (x[i, 2] - x0[i, 2]) ** 2)
    return np.sqrt(top)


@njit
def _steps(
    x, v, w, f, q, x0, start, mates, past, near, wall_past, radius, mass, inertia, kind, table, walls, wall_kind,
    lower, upper, periodic, gravity, force, uniform, dt, skin, limit, reach, first, steps, rebuild,
):  # fmt: skip
    vh, wh, per_mass, per_inertia = np.empty_like(v), np.empty_like(w), 1.0 / mass, 1.0 / inertia
    image = shifts(lower, upper, periodic)
    status, culprit, done = OK, -1, 0
    for step in range(steps):
        fastest2, culprit = _advance(
            x, v, w, vh, wh, f, q, per_mass, per_inertia, force, gravity, dt, step == 0, limit * limit
        )  # fmt: skip
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
        _pair_forces(x, v, w, f, q, radius, mass, inertia, kind, uniform, table, image, start, mates, past, now, dt)
        _wall_forces(
            x, v, w, f, q, radius, mass, inertia, kind, table, walls, wall_kind, near, wall_past, now, dt
        )  # fmt: skip
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
    files = (Path(str(module.__file__)) for module in (contact, neighbours, particles))
    return zlib.crc32(b"".join(file.read_bytes() for file in files))


run_steps = _compiled(_content())
