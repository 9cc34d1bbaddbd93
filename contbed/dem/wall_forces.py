"""Forces and torques of walls at rest on the particles of a block, one contact after
the other.
"""

from __future__ import annotations

from typing import NamedTuple

from contbed.compiled.functions import inner
from contbed.dem.contact import (
    FAST,
    ContactConstants,
    Vector,
    contact_law,
    rolling_torque,
)
from contbed.dem.forces import add
from contbed.dem.kernel_arrays import Laws, Row, Side, Sums
from contbed.dem.neighbours import wall_distance


class Ball(NamedTuple):
    """A particle at a wall: velocity [m/s], spin [rad/s], radius [m], mass [kg],
    moment of inertia [kg m2].
    """

    velocity: Vector
    spin: Vector
    radius: float
    mass: float
    inertia: float


class WallForce(NamedTuple):
    """Force [N] and torque [N m] on a particle, its spring after the step [m] and
    its normal speed [m/s].
    """

    force: Vector
    torque: Vector
    spring: Vector
    normal_speed: float


@inner(error_model="numpy", fastmath=set(FAST), nogil=True)
def wall_forces(
    block: int, side: Side, sums: Sums, laws: Laws, now: float, dt: float
) -> None:
    """Add the forces and torques of walls at rest; a wall counts as a plane of infinite
    mass.

    `now` is the number of the step, `dt` its length [s].
    """
    x = side.bodies.position
    motion = side.bodies.motion
    near = side.near
    spheres = side.spheres
    base = block * (len(near.wall) // len(near.used))
    for k in range(base, base + near.used[block]):
        i, surface = near.particle[k], laws.walls[near.wall[k]]
        gap, nx, ny, nz = wall_distance(x[i, 0], x[i, 1], x[i, 2], surface)
        spring, is_open = near.spring, near.onset[k, 0] < 0.0
        if spheres.radius[i] - gap <= 0.0:
            if not is_open:
                near.onset[k, 0], near.onset[k, 1] = -1.0, 0.0
                spring[k, 0], spring[k, 1], spring[k, 2] = 0.0, 0.0, 0.0
            continue
        ball = Ball(
            Vector(motion[i, 0], motion[i, 1], motion[i, 2]),
            Vector(motion[i, 3], motion[i, 4], motion[i, 5]),
            spheres.radius[i],
            spheres.mass[i],
            spheres.inertia[i],
        )
        pair = laws.pairs[spheres.material[i], surface.material]
        found = wall_force(
            ball,
            gap,
            Vector(nx, ny, nz),
            Vector(spring[k, 0], spring[k, 1], spring[k, 2]),
            pair,
            dt,
        )
        spring[k, 0] = found.spring.x
        spring[k, 1] = found.spring.y
        spring[k, 2] = found.spring.z
        if is_open:
            near.onset[k, 0], near.onset[k, 1] = now, abs(found.normal_speed)
        add(sums.load, i, found.force, found.torque)


@inner(error_model="numpy", fastmath=set(FAST), forceinline=True)
def wall_force(
    ball: Ball, gap: float, normal: Vector, spring: Vector, pair: Row, dt: float
) -> WallForce:
    """Evaluate the contact of a particle with a wall.

    Parameters
    ----------
    ball : the particle
    gap : of its centre from the wall, less than its radius [m]
    normal : unit `Vector` into the bed
    spring : `Vector` of the tangential displacement before the step [m]
    pair : row of `kernel_arrays.PAIR` of the two materials
    dt : time step [s]
    """
    nx, ny, nz = normal.x, normal.y, normal.z
    wx, wy, wz = ball.spin.x, ball.spin.y, ball.spin.z
    found = contact_law(
        normal,
        ball.radius - gap,
        Vector(
            ball.velocity.x - gap * (wy * nz - wz * ny),
            ball.velocity.y - gap * (wz * nx - wx * nz),
            ball.velocity.z - gap * (wx * ny - wy * nx),
        ),
        spring,
        ContactConstants(
            ball.radius,
            ball.mass,
            pair.youngs_modulus,
            pair.shear_modulus,
            pair.damping_normal,
            pair.damping_tangential,
            pair.sliding_friction,
        ),
        dt,
    )
    c = found.force
    tx = gap * (nz * c.y - ny * c.z)
    ty = gap * (nx * c.z - nz * c.x)
    tz = gap * (ny * c.x - nx * c.y)
    if pair.rolling_friction > 0.0:
        roll = rolling_torque(
            normal,
            ball.spin,
            ball.radius,
            ball.inertia,
            pair.rolling_friction,
            found.normal_force,
            dt,
        )
        tx, ty, tz = tx + roll.x, ty + roll.y, tz + roll.z
    return WallForce(c, Vector(tx, ty, tz), found.spring, found.normal_speed)
