"""Forces and torques of walls at rest on the particles of a block, one contact after the other."""

from __future__ import annotations

from contbed.compiling import inner
from contbed.dem.contact import FAST, ContactConstants, Vector, contact_law, rolling_torque
from contbed.dem.forces import add
from contbed.dem.kernel_arrays import Laws, Side, Sums
from contbed.dem.neighbours import wall_distance


@inner(error_model="numpy", fastmath=set(FAST), nogil=True)
def wall_forces(block: int, side: Side, sums: Sums, laws: Laws, now: float, dt: float) -> None:
    """Add the forces and torques of walls at rest; a wall counts as a plane of infinite mass.

    `now` is the number of the step, `dt` its length [s].
    """
    x, motion, near, spheres = side.bodies.position, side.bodies.motion, side.near, side.spheres
    base = block * (len(near.wall) // len(near.used))
    for k in range(base, base + near.used[block]):
        i, surface = near.particle[k], laws.walls[near.wall[k]]
        gap, nx, ny, nz = wall_distance(x[i, 0], x[i, 1], x[i, 2], surface)
        overlap, spring, is_open = spheres.radius[i] - gap, near.spring, near.onset[k, 0] < 0.0
        if overlap <= 0.0:
            if not is_open:
                near.onset[k, 0], near.onset[k, 1] = -1.0, 0.0
                spring[k, 0], spring[k, 1], spring[k, 2] = 0.0, 0.0, 0.0
            continue
        wx, wy, wz = motion[i, 3], motion[i, 4], motion[i, 5]
        pair, normal = laws.pairs[spheres.material[i], surface.material], Vector(nx, ny, nz)
        found = contact_law(
            normal,
            overlap,
            Vector(
                motion[i, 0] - gap * (wy * nz - wz * ny),
                motion[i, 1] - gap * (wz * nx - wx * nz),
                motion[i, 2] - gap * (wx * ny - wy * nx),
            ),
            Vector(spring[k, 0], spring[k, 1], spring[k, 2]),
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
        spring[k, 0], spring[k, 1], spring[k, 2] = found.spring.x, found.spring.y, found.spring.z
        if is_open:
            near.onset[k, 0], near.onset[k, 1] = now, abs(found.normal_speed)
        tx, ty, tz = gap * (nz * c.y - ny * c.z), gap * (nx * c.z - nz * c.x), gap * (ny * c.x - nx * c.y)
        if pair.rolling_friction > 0.0:
            roll = rolling_torque(
                normal,
                Vector(wx, wy, wz),
                spheres.radius[i],
                spheres.inertia[i],
                pair.rolling_friction,
                found.normal_force,
                dt,
            )
            tx, ty, tz = tx + roll.x, ty + roll.y, tz + roll.z
        add(sums.load, i, c, Vector(tx, ty, tz))
