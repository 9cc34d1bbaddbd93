"""Contact laws of spheres: Hertz-Mindlin with history, damping by restitution, rolling
friction; the safe step.

Equations, with the unit normal n from j to i, overlap delta, a = sqrt(R* delta) and the
velocity v of i against j at the contact, split into v_n = v.n and v_t = v - v_n n:

    F_n = 4/3 E* a delta - c_n sqrt(m* a) v_n               c = 2 sqrt(5/6) b sqrt(k / a), k_n = 2 E* a
    F_t = -k_t xi - c_t sqrt(m* a) v_t, |F_t| <= mu F_n     k_t = 8 G* a (Mindlin), dxi/dt = v_t, xi tangent
    T_r = -mu_r R* F_n w_t/|w_t|                            w_t : rolling part of the relative spin

The normal force may pull at the end of an impact: only so the restitution is the one
asked for. Friction never exceeds mu F_n, dashpot included, and is zero where F_n pulls.
The rolling torque is at most what stops the rotation in ROLLING_STEPS steps, so that it
neither chatters nor drives a particle with many contacts.

Sources: Zhou, Yu, Horio (2010 review, Table 1) as used by Hou, Zhou, Yu (2011) with
    signs and dimensions corrected;
damping: Tsuji, Tanaka, Ishida (1992), Powder Technology 71, 239.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from contbed.compiled.functions import entry, inner
from contbed.dem.particles import Material, Particles
from contbed.errors import SceneError

FAST = frozenset(("contract", "arcp", "nsz", "reassoc"))  # not nnan: a NaN must be seen
ROLLING_STEPS = 8.0
# of the time that a surface wave needs around the smallest particle
RAYLEIGH_SHARE = 0.2
STEPS_PER_IMPACT = 20.0  # up to 2.3e-3 error of the largest overlap
# t_c of a Hertz impact in units of (m*^2 / (R* E*^2 v))^(1/5)
DURATION = 2.868265699195


class Vector(NamedTuple):
    """Components along x, y and z."""

    x: float
    y: float
    z: float


class ContactConstants(NamedTuple):
    """Effective radius [m] and mass [kg] of a contact, then its columns of the table
    of pairs of materials.
    """

    radius: float
    mass: float
    youngs_modulus: float
    shear_modulus: float
    damping_normal: float
    damping_tangential: float
    sliding_friction: float


class ContactForce(NamedTuple):
    """Force on i [N] and its normal part, the tangential spring [m] after the step
    and the normal speed [m/s].
    """

    force: Vector
    normal_force: float
    spring: Vector
    normal_speed: float


@entry(error_model="numpy", fastmath=set(FAST), forceinline=True)
def contact_law(
    normal: Vector,
    overlap: float,
    velocity: Vector,
    spring: Vector,
    contact: ContactConstants,
    dt: float,
) -> ContactForce:
    """Evaluate the Hertz-Mindlin force of a closed contact with history and dashpots
    (see the top of this file).

    Without branches, so that loops over contacts turn into vector instructions.

    Parameters
    ----------
    normal : unit `Vector` from j to i
    overlap : [m]
    velocity : `Vector` of i against j at the contact [m/s]
    spring : `Vector` of the tangential displacement before the step [m]
    contact : `ContactConstants`
    dt : time step [s]

    Returns
    -------
    ContactForce
    """
    nx, ny, nz = normal.x, normal.y, normal.z
    vn = velocity.x * nx + velocity.y * ny + velocity.z * nz
    ux, uy, uz = velocity.x - vn * nx, velocity.y - vn * ny, velocity.z - vn * nz
    a = sqrt(contact.radius * overlap)
    root = sqrt(contact.mass * a)
    load = (
        4.0 / 3.0 * contact.youngs_modulus * a * overlap
        - contact.damping_normal * root * vn
    )
    limit = contact.sliding_friction * max(load, 0.0)
    kt, ct = 8.0 * contact.shear_modulus * a, contact.damping_tangential * root
    out = spring.x * nx + spring.y * ny + spring.z * nz
    sx = spring.x - out * nx + dt * ux
    sy = spring.y - out * ny + dt * uy
    sz = spring.z - out * nz + dt * uz
    spring2 = kt * kt * (sx * sx + sy * sy + sz * sz)
    slips = spring2 > limit * limit
    shrink = limit / sqrt(spring2) if slips else 1.0
    ct = 0.0 if slips else ct
    sx, sy, sz = shrink * sx, shrink * sy, shrink * sz
    tx, ty, tz = -kt * sx - ct * ux, -kt * sy - ct * uy, -kt * sz - ct * uz
    force2 = tx * tx + ty * ty + tz * tz
    cut = limit / sqrt(force2) if force2 > limit * limit else 1.0
    force = Vector(load * nx + cut * tx, load * ny + cut * ty, load * nz + cut * tz)
    return ContactForce(force, load, Vector(sx, sy, sz), vn)


@inner(error_model="numpy", fastmath=set(FAST))
def rolling_torque(
    normal: Vector,
    spin: Vector,
    radius: float,
    inertia: float,
    friction: float,
    normal_force: float,
    dt: float,
) -> Vector:
    """Evaluate the torque on i [N m] against the rolling part of the relative
    spin [rad/s], a `Vector`.

    Constant directional torque mu_r R* F_n, bounded as said at the top of this file.
    `normal` is a unit `Vector`, `radius` [m] and `inertia` [kg m2] are effective ones,
    `friction` is mu_r [-], `normal_force` [N].
    """
    along = spin.x * normal.x + spin.y * normal.y + spin.z * normal.z
    wx = spin.x - along * normal.x
    wy = spin.y - along * normal.y
    wz = spin.z - along * normal.z
    rate = sqrt(wx * wx + wy * wy + wz * wz)
    if rate == 0.0 or normal_force <= 0.0:
        return Vector(0.0, 0.0, 0.0)
    brake = min(friction * radius * normal_force / rate, inertia / (ROLLING_STEPS * dt))
    return Vector(-brake * wx, -brake * wy, -brake * wz)


def hertz_impact(
    mass: float, radius: float, modulus: float, speed: float
) -> tuple[float, float]:
    """Find duration [s] and largest overlap [m] of an elastic impact of effective
    mass [kg], radius [m], modulus [Pa].

    t_c = 2.868266 (m*^2 / (R* E*^2 v))^(1/5), delta_max = (15 m* v^2 / (16 E*
    sqrt(R*)))^(2/5)
    Source: Johnson, Contact Mechanics (1985), section 11.4.
    """
    duration = DURATION * (mass**2 / (radius * modulus**2 * speed)) ** 0.2
    return duration, (
        15.0 * mass * speed**2 / (16.0 * modulus * np.sqrt(radius))
    ) ** 0.4


def rayleigh_time(radius: float, material: Material) -> float:
    """Find the time that a Rayleigh wave needs for half the circumference [s].

    t = pi R sqrt(rho / G) / (0.1631 nu + 0.8766)

    Source: Thornton and Randall (1988), in: Micromechanics of Granular Materials,
        133-142.
    """
    factor = 0.1631 * material.poisson_ratio + 0.8766
    return float(
        np.pi * radius * np.sqrt(material.density / material.shear_modulus) / factor
    )


def largest_safe_step(
    particles: Particles, materials: Sequence[Material], impact_speed: float = 0.1
) -> float:
    """Find the largest time step [s]: 0.2 of the Rayleigh time, and 20 steps in an
    impact at `impact_speed` [m/s].

    Taken over the smallest particle of every material that occurs, in contact with its
    like.
    """
    steps = []
    for index in np.unique(particles.material):
        material = materials[index]
        radius = float(particles.radius[particles.material == index].min())
        mass = 4.0 / 3.0 * np.pi * radius**3 * material.density
        steps.append(RAYLEIGH_SHARE * rayleigh_time(radius, material))
        steps.append(
            hertz_impact(
                mass / 2.0, radius / 2.0, material.contact_modulus, impact_speed
            )[0]
            / STEPS_PER_IMPACT
        )
    return min(steps)


def require_safe_step(
    time_step: float,
    particles: Particles,
    materials: Sequence[Material],
    impact_speed: float,
) -> None:
    """Refuse a time step that is not positive or larger than the largest safe one.

    Raises
    ------
    SceneError : names the largest safe step
    """
    safe = largest_safe_step(particles, materials, impact_speed)
    if not 0.0 < time_step <= safe * (1.0 + 1e-12):
        raise SceneError(
            f"dem: time step {time_step:g} s, the largest safe one is {safe:.4g} s "
            f"(impacts at {impact_speed:g} m/s); reduce it or soften the particles"
        )
