"""Round walls, on every axis: smooth elastic spheres come back as from a mirror, with
the speed they had; none escapes.

Speed after an elastic impact at 100 steps: 1e-5 (order 2.5 of the loop). Direction: the
wall turns under the sphere by (tangential speed x duration/radius) during the contact,
1e-3 here.
"""

import numpy as np
import pytest
from pytest import approx

from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Cylinder, Plane, Tube
from tests.refusals import refused

RADIUS, INNER, OUTER, SPEED = 1e-3, 4e-3, 12e-3, 0.1
SMOOTH = Material(restitution=1.0, sliding_friction=0.0)
AXES = [0, 1, 2]


def turned(axis, across, up, along=0.0):
    """Vector with components along the axis and the two after it."""
    return np.roll([along, across, up], axis)


def fly(axis, wall, position, velocity, seconds):
    simulation = Simulation(
        Particles([position], RADIUS, velocity=[velocity]),
        [SMOOTH],
        [wall],
        gravity=(0, 0, 0),
        time_step=3e-6,
    )
    simulation.run(round(seconds / simulation.time_step))
    return simulation


def round_wall(kind, axis, radius):
    return kind((0.0, 0.0, 0.0), tuple(turned(axis, 0.0, 0.0, 1.0)), radius)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize(
    ("kind", "radius", "start", "way"),
    [(Tube, INNER, 6e-3, -1), (Cylinder, OUTER, 10e-3, 1)],
)
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
def test_reflection_of_a_sphere_that_flies_along_a_radius(
    axis, kind, radius, start, way, angle
):
    across, up = np.cos(angle), np.sin(angle)
    velocity = way * SPEED * turned(axis, across, up)
    simulation = fly(
        axis,
        round_wall(kind, axis, radius),
        start * turned(axis, across, up),
        velocity,
        0.03,
    )
    assert simulation.velocity[0] == approx(-velocity, abs=1e-4 * SPEED)
    assert np.linalg.norm(simulation.velocity) == approx(SPEED, rel=1e-5)
    assert np.abs(simulation.spin).max() < 1e-12 * SPEED / RADIUS


@pytest.mark.parametrize("axis", AXES)
def test_reflection_from_a_tube_is_a_mirrors(axis):
    """Aimed beside the axis by 0.6 of the sum of the radii: the normal is at
    asin(0.6); speed along the tube stays.
    """
    offset = 0.6 * (INNER + RADIUS)
    normal = turned(axis, 0.8, 0.6)
    velocity = turned(axis, -SPEED, 0.0, 0.3 * SPEED)
    simulation = fly(
        axis, round_wall(Tube, axis, INNER), turned(axis, 6e-3, offset), velocity, 0.05
    )
    mirrored = velocity - 2.0 * (velocity @ normal) * normal
    assert simulation.velocity[0] == approx(mirrored, abs=1e-2 * SPEED)
    assert np.linalg.norm(simulation.velocity) == approx(
        np.linalg.norm(velocity), rel=1e-5
    )


@pytest.mark.parametrize("axis", AXES)
def test_none_escapes(axis):
    """40 spheres between a tube, a cylinder around it and two planes: inside for
    ever, and their energy with them.
    """
    rng = np.random.default_rng(axis)
    angle = np.repeat(np.arange(10), 4) * 2.0 * np.pi / 10
    along = np.tile(np.arange(4), 10) * 2.5e-3 + 1.5e-3
    off = 0.5 * (INNER + OUTER)
    position = np.array(
        [
            turned(axis, off * np.cos(a), off * np.sin(a), z)
            for a, z in zip(angle, along, strict=True)
        ]
    )
    walls = [
        round_wall(Tube, axis, INNER), round_wall(Cylinder, axis, OUTER),
        Plane((0.0, 0.0, 0.0), tuple(turned(axis, 0.0, 0.0, 1.0))),
        Plane(tuple(turned(axis, 0.0, 0.0, 11e-3)), tuple(turned(axis, 0.0, 0.0, -1.0))),
    ]  # fmt: skip
    spheres = Particles(position, RADIUS, velocity=rng.normal(0.0, 0.3, (40, 3)))
    simulation = Simulation(
        spheres, [SMOOTH], walls, gravity=(0, 0, 0), time_step=2e-6, impact_speed=1.0
    )
    before = simulation.kinetic_energy
    for _ in range(20):
        simulation.run(5000)
        r = np.linalg.norm(np.delete(simulation.position, axis, axis=1), axis=1)
        assert (r > INNER + 0.9 * RADIUS).all() and (r < OUTER - 0.9 * RADIUS).all()
        assert (
            (simulation.position[:, axis] > 0.9 * RADIUS)
            & (simulation.position[:, axis] < 11e-3 - 0.9e-3)
        ).all()
    assert simulation.kinetic_energy < before * (1.0 + 1e-3)
    # the rest is in overlaps for the moment
    assert simulation.kinetic_energy > 0.8 * before


@pytest.mark.parametrize("kind", [Tube, Cylinder])
def test_bad_round_walls(kind):
    one = Particles([[0, 0, 6e-3]], RADIUS)
    for point, message in (
        ((0, 0, 0), "has no direction"),
        ((0, 0, 1), "radius = 0 m must be positive"),
    ):
        refused(message, Simulation, one, [SMOOTH], [kind((0, 0, 0), point, 0.0)])
    inside = Particles([[0, 0, 1e-3 if kind is Tube else 20e-3]], RADIUS)
    refused(
        r"particle 0 at .* is beyond wall 0",
        lambda: Simulation(inside, [SMOOTH], [kind((0, 0, 0), (1, 0, 0), INNER)]),
    )
