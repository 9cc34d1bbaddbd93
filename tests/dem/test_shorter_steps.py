"""A sphere that is too fast for the time step: from then on the step is half as
long, where that is allowed.
"""

import pytest
from numpy.testing import assert_array_equal
from pytest import approx

from contbed.dem import simulation
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.errors import ConvergenceError
from tests.refusals import refused

RADIUS, STEP = 1e-3, 2e-6
LIMIT = 0.1 * RADIUS / STEP  # m/s, 50
GLASS = Material(youngs_modulus=1e7)


def spheres(speed, halvings, step=STEP):
    """A stray sphere, and two that collide elsewhere."""
    x = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.50201, 0.0002, 0.0]]
    v = [[0.0, 0.0, speed], [0.3, 0.0, 0.0], [-0.3, 0.0, 0.0]]
    particles = Particles(x, RADIUS, velocity=v)
    return Simulation(
        particles,
        [GLASS],
        gravity=(0, 0, 0),
        time_step=step,
        impact_speed=1.0,
        most_halvings=halvings,
    )


@pytest.mark.parametrize(("speed", "needed"), [(0.9, 0), (1.1, 1), (3.9, 2)])
def test_the_step_is_halved_as_often_as_the_speed_asks_for(speed, needed):
    found = spheres(speed * LIMIT, 2)
    found.run(100, interval=30)
    assert (found.halvings, found.time_step, found.steps_done) == (
        needed,
        STEP / 2**needed,
        100 * 2**needed,
    )
    # free flight: a sum of 400 equal parts
    assert found.position[0, 2] == approx(speed * LIMIT * 100 * STEP, rel=1e-13)


def test_what_follows_is_what_the_shorter_step_gives():
    """Bit for bit: halves of floating-point numbers are exact."""
    found, short = spheres(1.5 * LIMIT, 1), spheres(1.5 * LIMIT, 0, STEP / 2)
    found.run(60)
    short.run(120)
    assert len(short.contacts()) == 1
    for name, values in short.state().items():
        assert_array_equal(found.state()[name], values, err_msg=name)


def test_contacts_keep_their_times():
    """The pair touches at full steps; then the stray sphere is pushed beyond the
    limit.
    """
    found = spheres(0.9 * LIMIT, 1)
    found.run(30)
    (since,) = found.contacts().since
    assert 0.0 < since < found.time
    found.force[0, 2] = 0.01 * LIMIT * found.mass[0] / STEP
    found.run(40, interval=5)
    assert found.halvings == 1
    assert found.contacts().since == approx([since], rel=1e-15)
    assert found.time == approx(70 * STEP, rel=1e-15)
    # the first half kick is that of the force before
    assert found.velocity[0, 2] == approx((0.9 + 0.01 * 39.5) * LIMIT, rel=1e-12)


def test_a_restart_goes_on_with_the_shorter_step():
    whole, again = spheres(1.5 * LIMIT, 1), spheres(1.5 * LIMIT, 1)
    whole.run(30)
    again.restore(whole.state())
    assert again.halvings == 1
    whole.run(60)
    again.run(60)
    for name, values in whole.state().items():
        assert_array_equal(again.state()[name], values, err_msg=name)
    refused(
        "the checkpoint has time step 1e-06 s, expected 2e-06 s",
        lambda: spheres(0.0, 0).restore(whole.state()),
    )


def test_a_sphere_that_stays_too_fast_ends_the_run():
    found = spheres(4.1 * LIMIT, 2)
    with pytest.raises(
        ConvergenceError,
        match=r"particle 0 at .* moves at 205 m/s, more than 0.1 of the smallest radius",
    ):
        found.run(10)
    assert found.halvings == 2 and found.time == 0.0
    assert_array_equal(found.position, spheres(0.0, 0).position)


def test_without_halvings_it_ends_at_once():
    with pytest.raises(ConvergenceError, match="moves at 55 m/s"):
        spheres(1.1 * LIMIT, 0).run(10)
    assert simulation.STRIDE == 0.1
