"""Contact laws against exact results, on every axis.

Elastic and damped impacts: 1e-6 of duration, overlap and restitution; the dashpot
starts with a force that grows with overlap^(1/4), so its error falls with the time step
to the power 5/4 and 1e5 steps an impact are taken. The slope of the tangential force is
exact to round-off, 1e-12. Rolling: the contact point moves with the overlap, so exact
results use the arm of the contact; what is left is the first-order error of the time
step, 1e-4.
"""

import numpy as np
import pytest
from pytest import approx

from contbed.dem.contact import (
    ContactConstants,
    Vector,
    contact_law,
    hertz_impact,
    largest_safe_step,
    rayleigh_time,
)
from contbed.dem.particles import Material, Particles, damping_ratio, pair_table
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Plane
from tests.cases import each_case
from tests.refusals import refused

RADIUS, SPEED = 1e-3, 0.1
GLASS = Material()
SMOOTH = Material(restitution=1.0, sliding_friction=0.0)
AXES = [0, 1, 2]


def along(axis, value=1.0):
    vector = np.zeros(3)
    vector[axis] = value
    return vector


def impact(axis, material, steps, radii=(RADIUS, RADIUS), speed=SPEED):
    """Two spheres that meet along an axis: simulation at first touch, effective mass
    and radius, duration, overlap.
    """
    mass = 4.0 / 3.0 * np.pi * np.array(radii) ** 3 * material.density
    m, r = mass.prod() / mass.sum(), radii[0] * radii[1] / sum(radii)
    duration, overlap = hertz_impact(
        m, r, pair_table([material])["youngs_modulus"][0, 0], speed
    )
    apart = along(axis, sum(radii))
    velocity = [along(axis, speed / 2), along(axis, -speed / 2)]
    spheres = Particles([np.zeros(3), apart], radii, velocity=velocity)
    return (
        Simulation(
            spheres, [material], gravity=np.zeros(3), time_step=duration / steps
        ),
        duration,
        overlap,
    )


@pytest.mark.parametrize(
    ("axis", "radii"),
    [(0, (RADIUS, RADIUS)), *((axis, (RADIUS, 3 * RADIUS)) for axis in AXES)],
)
def test_hertz_impact(axis, radii):
    steps = 4000
    simulation, duration, overlap = impact(axis, SMOOTH, steps, radii)
    largest, touching = 0.0, 0
    for _ in range(steps + 40):
        simulation.run(1)
        closed = simulation.contacts()
        largest, touching = max(largest, *closed.overlap, 0.0), touching + len(closed)
    assert largest == approx(overlap, rel=1e-6)
    assert touching * simulation.time_step == approx(
        duration, abs=1.01 * simulation.time_step
    )
    assert np.diff(simulation.velocity[:, axis])[0] == approx(SPEED, rel=1e-6)
    assert np.abs(np.delete(simulation.velocity, axis, axis=1)).max() == 0.0


def test_duration_of_an_impact():
    """From the instants of first touch and of parting, which the motion at constant
    speed before and after gives.
    """
    simulation, duration, _ = impact(2, SMOOTH, 4000)
    simulation.run(4400)
    gap = np.diff(simulation.position[:, 2])[0] - 2 * RADIUS
    parted = simulation.time - gap / np.diff(simulation.velocity[:, 2])[0]
    assert parted == approx(duration, rel=1e-6)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("restitution", [0.9, 0.5, 0.2])
def test_restitution(axis, restitution):
    simulation, _, _ = impact(axis, Material(restitution=restitution), 100_000)
    simulation.run(300_000)
    assert not len(simulation.contacts())
    assert np.diff(simulation.velocity[:, axis])[0] == approx(
        restitution * SPEED, rel=1e-6
    )


def test_restitution_does_not_depend_on_speed():
    found = []
    for speed in (0.01, 1.0):
        simulation, _, _ = impact(0, Material(restitution=0.7), 1000, speed=speed)
        simulation.run(2000)
        found.append(np.diff(simulation.velocity[:, 0])[0] / speed)
    assert found[0] == approx(found[1], rel=1e-5)


def test_damping_ratio():
    b = damping_ratio([0.9, 0.5])
    assert np.exp(-np.pi * b / np.sqrt(1 - b**2)) == approx([0.9, 0.5], rel=1e-14)


def constants(pair, radius, mass):
    """Of a contact with this effective radius and mass; rolling friction, the last
    column, is not among them.
    """
    return ContactConstants(radius, mass, *pair.tolist()[:-1])


@pytest.mark.parametrize("axis", AXES)
def test_mindlin_slope(axis):
    """Small motion at fixed overlap: slope 8 G* sqrt(R* delta), for equal spheres
    k_n 2 (1 - nu)/(2 - nu).
    """
    pair = pair_table([Material(restitution=1.0)])[0, 0]
    overlap, moved = 1e-6, 1e-12
    n, t = along(axis), along((axis + 1) % 3)
    contact = constants(pair, RADIUS / 2, 1.0)
    found = contact_law(
        Vector(*n), overlap, Vector(*t), Vector(0.0, 0.0, 0.0), contact, moved
    )
    force = np.array(found.force)
    k_n = 2.0 * pair["youngs_modulus"] * np.sqrt(RADIUS / 2 * overlap)
    slope = -np.dot(force, t) / moved
    assert slope == approx(
        8.0 * pair["shear_modulus"] * np.sqrt(RADIUS / 2 * overlap), rel=1e-12
    )
    assert slope == approx(
        k_n * 2 * (1 - GLASS.poisson_ratio) / (2 - GLASS.poisson_ratio), rel=1e-12
    )
    assert np.dot(force, n) == approx(2.0 / 3.0 * k_n * overlap, rel=1e-12)


def test_friction_never_exceeds_coulomb_and_releases_in_tension():
    pair = pair_table([GLASS])[0, 0]
    spring = Vector(0.0, 0.0, 0.0)
    for speed in (0.0, -0.5, 0.5, 50.0):
        contact = constants(pair, RADIUS, 1e-5)
        found = contact_law(
            Vector(0.0, 0.0, 1.0), 1e-6, Vector(3.0, 4.0, speed), spring, contact, 1e-6
        )
        (fx, fy, fz), normal, spring, _ = found
        assert np.hypot(fx, fy) <= GLASS.sliding_friction * max(normal, 0.0) * (
            1 + 1e-12
        )
        assert fz == normal
    assert normal < 0.0 and fx == 0.0


def on_plane(
    axis, spin_axis, material, v0=0.0, spin=0.0, tilt=0.0, seconds=0.1, step=2e-7
):
    """A sphere at rest in its dent on a plane across `axis`, launched along the axis
    after it.
    """
    forward = (axis + 1) % 3
    gravity = along(axis, -9.81 * np.cos(tilt)) + along(forward, 9.81 * np.sin(tilt))
    mass = 4.0 / 3.0 * np.pi * RADIUS**3 * material.density
    modulus = pair_table([material])["youngs_modulus"][0, 0]
    dent = (9.81 * np.cos(tilt) * mass * 0.75 / (modulus * np.sqrt(RADIUS))) ** (
        2.0 / 3.0
    )
    sphere = Particles(
        [along(axis, RADIUS - dent)],
        RADIUS,
        velocity=[along(forward, v0)],
        spin=[along(spin_axis, spin)],
    )
    simulation = Simulation(
        sphere,
        [material],
        [Plane((0, 0, 0), tuple(along(axis)))],
        gravity=gravity,
        time_step=step,
    )
    simulation.run(round(seconds / step), interval=100_000)
    return simulation, forward, RADIUS - dent


@pytest.mark.parametrize("axis", AXES)
def test_slide_to_roll(axis):
    """Rolls with v0 / (1 + I/(m a^2)), a the arm of the contact: 5/7 v0 but for the
    dent.
    """
    v0, material = 0.05, Material(youngs_modulus=1e8, restitution=0.5)
    seconds = 2 * 2 * v0 / (7 * 0.3 * 9.81)
    simulation, forward, arm = on_plane(
        axis, (axis + 2) % 3, material, v0, step=1e-6, seconds=seconds
    )
    rolling = v0 / (1.0 + 0.4 * RADIUS**2 / arm**2)
    assert simulation.velocity[0, forward] == approx(rolling, rel=1e-4)
    assert rolling == approx(5 / 7 * v0, rel=1e-3)
    assert simulation.spin[0, (axis + 2) % 3] * arm == approx(rolling, rel=1e-4)


@pytest.mark.parametrize("axis", AXES)
def test_sliding_slows_by_friction(axis):
    v0, material = 0.05, Material(youngs_modulus=1e8, restitution=0.5)
    seconds = 0.5 * 2 * v0 / (7 * 0.3 * 9.81)
    simulation, forward, _ = on_plane(
        axis, (axis + 2) % 3, material, v0, step=1e-6, seconds=seconds
    )
    assert simulation.velocity[0, forward] == approx(
        v0 - 0.3 * 9.81 * seconds, rel=2e-3
    )


@pytest.mark.parametrize(("slope", "slips"), [(3.0, False), (4.0, True)])
def test_rolls_down_without_slip_if_tan_below_3_5_mu(slope, slips):
    material = Material(youngs_modulus=1e8, restitution=0.5, sliding_friction=0.2)
    simulation, forward, arm = on_plane(
        2, 1, material, tilt=np.arctan(slope * 0.2), seconds=0.02, step=1e-6
    )
    slip = (
        abs(simulation.velocity[0, forward] - simulation.spin[0, 1] * arm)
        / simulation.velocity[0, forward]
    )
    assert (slip > 1e-2) == slips


@pytest.mark.parametrize("axis", AXES)
def test_rolling_stop(axis):
    """Rolling resistance stops a rolling sphere after v0^2 / (2 a), a = 5/7 mu_r g,
    and it stays at rest.
    """
    v0, friction = 0.02, 0.05
    material = Material(youngs_modulus=1e8, restitution=0.5, rolling_friction=friction)
    spin_axis = (axis + 2) % 3
    slowing = 5 / 7 * friction * 9.81
    seconds = 1.2 * v0 / slowing
    simulation, forward, _ = on_plane(
        axis, spin_axis, material, v0, v0 / RADIUS, step=1e-6, seconds=seconds
    )
    assert simulation.position[0, forward] == approx(v0**2 / (2 * slowing), rel=5e-3)
    assert abs(simulation.velocity[0, forward]) < 1e-6 * v0
    assert abs(simulation.spin[0, spin_axis]) * RADIUS < 1e-6 * v0


def test_safe_step():
    spheres = Particles([[0, 0, 0]], RADIUS)
    assert rayleigh_time(RADIUS, GLASS) == approx(8.653e-5, rel=1e-3)
    assert largest_safe_step(spheres, [GLASS], 1e-4) == approx(
        0.2 * rayleigh_time(RADIUS, GLASS)
    )
    assert largest_safe_step(spheres, [GLASS], 0.1) == approx(3.232e-4 / 20, rel=1e-3)


def test_time_step_too_large_names_the_safe_one():
    refused(
        r"time step 0.0001 s, the largest safe one is 1\.616e-05 s",
        lambda: Simulation(Particles([[0, 0, 0]], RADIUS), [GLASS], time_step=1e-4),
    )


@each_case(__file__, "bad_material")
def test_bad_material(change, message):
    refused(message, Material, **change)
