"""Temperatures in the time loop: heat of an impact, of a contact at rest, conservation,
restart.

One impact: a contact lasts a whole number of steps, so that its heat is that of the
closed form to one step in those of the impact; the impact speed is read at the first
step, which is less. Conservation: rounding of some 1e5 sums, 1e-13.
"""

import numpy as np
import pytest
from pytest import approx

from contbed.dem import heat_impact, heat_pair
from contbed.dem.contact import hertz_impact
from contbed.dem.contact_heat import ContactHeat
from contbed.dem.particles import Material, Particles, pair_table
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, Plane
from contbed.errors import ConvergenceError
from tests.refusals import refused

RADIUS, SPEED = 1e-3, 0.1
SMOOTH = Material(restitution=1.0, sliding_friction=0.0)
HEAVY = Material(
    density=7800.0, youngs_modulus=3e7, restitution=1.0, sliding_friction=0.0
)
GLASS_HEAT = ContactHeat(0.84, 840.0)


def impact(axis, steps, materials=(SMOOTH, SMOOTH), heat=GLASS_HEAT, speed=SPEED):
    """Simulation of two spheres about to meet, T 400 and 300 K, and Hertz's impact."""
    mass = (
        4
        / 3
        * np.pi
        * RADIUS**3
        * np.array([material.density for material in materials])
    )
    m, modulus = mass.prod() / mass.sum(), pair_table(materials)["youngs_modulus"][0, 1]
    dt = hertz_impact(m, RADIUS / 2, modulus, speed)[0] / steps
    position, velocity = np.zeros((2, 3)), np.zeros((2, 3))
    position[1, axis], velocity[0, axis] = 2 * RADIUS + 1.3 * speed * dt, speed
    spheres = Particles(position, RADIUS, [0, 1], velocity=velocity)
    simulation = Simulation(
        spheres,
        materials,
        gravity=(0, 0, 0),
        time_step=dt,
        impact_speed=speed,
        heat=heat,
        T=[400.0, 300.0],
    )
    return simulation, heat_impact.hertz_impact(RADIUS / 2, m, modulus, speed)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("steps", [40, 2000])
def test_heat_of_an_impact(axis, steps):
    simulation, hertz = impact(axis, steps)
    simulation.run(steps + 10)
    assert not len(simulation.contacts())
    capacity = 2500 * 840.0
    wanted = (
        heat_impact.impact_conductance(hertz, (0.84, 0.84), (capacity, capacity))
        * hertz.duration
        * 100.0
    )
    # 1.865e-7 J/K for glass of 2 mm at 0.1 m/s
    assert wanted == approx(1.865e-5, rel=1e-3)
    given = simulation.heat_capacity * (np.array([400.0, 300.0]) - simulation.T)
    assert given[0] == approx(wanted, rel=1.0 / steps)
    # rounding of 300 K against 2e-3 K
    assert given[1] == approx(-given[0], rel=1e-6)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_heat_of_an_impact_of_two_materials(order):
    materials = tuple((SMOOTH, HEAVY)[k] for k in order)
    k, c = np.array([0.84, 30.0])[list(order)], np.array([840.0, 450.0])[list(order)]
    simulation, hertz = impact(
        0, 1000, materials, ContactHeat(k, c, static=0.06, impact=0.2)
    )
    simulation.run(1010)
    store = c * [material.density for material in materials]
    wanted = (
        heat_impact.impact_conductance(hertz, tuple(k), tuple(store), 0.2)
        * hertz.duration
        * 100.0
    )
    given = simulation.heat_capacity * (np.array([400.0, 300.0]) - simulation.T)
    assert given[0] == approx(wanted, rel=2e-3)


def test_softened_spheres_exchange_the_heat_of_hard_ones():
    given = []
    for modulus, factor in (
        (1e7, heat_pair.correction(1e7, 1e9, heat_pair.IMPACT)),
        (1e9, 1.0),
    ):
        materials = (Material(youngs_modulus=modulus, restitution=1.0),) * 2
        simulation, _ = impact(
            2, 1000, materials, ContactHeat(0.84, 840.0, impact=float(factor))
        )
        simulation.run(1010)
        given.append(400.0 - simulation.T[0])
    assert given[0] == approx(given[1], rel=2e-3)


def test_after_the_impact_the_contact_is_at_rest():
    """A sphere on a fixed floor and one on top of it: temperatures meet at the rate
    of Eq. 6.
    """
    damped = Material(restitution=0.2)
    spheres = Particles([[0, 0, RADIUS], [0, 0, 3 * RADIUS]], RADIUS)
    simulation = Simulation(
        spheres,
        [damped],
        [Plane((0, 0, 0), (0, 0, 1))],
        time_step=1e-5,
        heat=ContactHeat(5.0, 1.0, static=0.3),
        T=[300.0, 400.0],
    )
    simulation.run(100_000)
    before, overlap = np.diff(simulation.T)[0], simulation.contacts().overlap[0]
    simulation.run(1000)
    G = heat_pair.contact_conductance(
        heat_pair.contact_radius(RADIUS, RADIUS, 2 * RADIUS - overlap, 0.3), 5.0, 5.0
    )
    rate = G * (1.0 / simulation.heat_capacity).sum()
    # explicit Euler: (1 - rate dt)^steps
    assert np.diff(simulation.T)[0] == approx(
        before * (1.0 - rate * 1e-5) ** 1000, rel=1e-6
    )
    assert before < 100.0


def crowd(**change):
    """64 spheres of two sizes and materials that fly about in a periodic box, 300 to
    400 K.
    """
    rng = np.random.default_rng(3)
    side = 10e-3
    lattice = np.stack(
        np.meshgrid(*3 * [np.arange(4)], indexing="ij"), axis=-1
    ).reshape(-1, 3)
    position = (lattice + 0.5) * side / 4 + rng.uniform(-1, 1, lattice.shape) * 1e-4
    radius = np.where(np.arange(64) % 3, RADIUS, 0.8 * RADIUS)
    spheres = Particles(
        position, radius, np.arange(64) % 2, velocity=rng.normal(0, 0.3, lattice.shape)
    )
    materials = [Material(), Material(density=7800.0, youngs_modulus=3e7)]
    # small capacities, so that much heat moves
    heat = ContactHeat([0.84, 30.0], [0.2, 0.1])
    settings = {
        "time_step": 2e-6,
        "heat": heat,
        "T": rng.uniform(300.0, 400.0, 64),
    } | change
    return Simulation(
        spheres,
        materials,
        domain=Domain((0,) * 3, (side,) * 3, (True,) * 3),
        gravity=(0, 0, 0),
        **settings,
    )


def test_heat_is_conserved_and_evens_out():
    simulation = crowd()
    before, spread = simulation.heat_capacity @ simulation.T, simulation.T.std()
    low, high = simulation.T.min(), simulation.T.max()
    simulation.run(20_000)
    after = simulation.heat_capacity @ simulation.T
    assert after == approx(before, rel=1e-13)
    assert simulation.T.std() < 0.9 * spread
    assert simulation.T.min() >= low and simulation.T.max() <= high


def test_restart_is_bitwise():
    whole, first, second = crowd(), crowd(), crowd()
    whole.run(5000, interval=5000)
    first.run(2345, interval=100)
    second.restore(first.state())
    second.run(5000 - 2345, interval=700)
    assert whole.T.tobytes() == second.T.tobytes()
    assert whole.position.tobytes() == second.position.tobytes()


def test_temperatures_do_not_change_the_motion():
    with_heat, without = crowd(), crowd(heat=None, T=None)
    with_heat.run(1000)
    without.run(1000)
    assert with_heat.position.tobytes() == without.position.tobytes()


def test_a_heat_source():
    simulation = Simulation(
        Particles([[0, 0, 0]], RADIUS), [SMOOTH], heat=GLASS_HEAT, T=300.0
    )
    simulation.heat_source[:] = 2.0
    simulation.run(100)
    assert simulation.T[0] == approx(
        300.0 + 2.0 * simulation.time / simulation.heat_capacity[0], rel=1e-12
    )
    simulation.heat_source[:] = np.nan
    with pytest.raises(
        ConvergenceError, match="temperature of particle 0 is not a number"
    ):
        simulation.run(10)
    assert simulation.steps_done == 100 and np.isfinite(simulation.T).all()


def test_mistakes():
    one = Particles([[0, 0, 0]], RADIUS)
    refused("heat and T belong together", Simulation, one, [SMOOTH], T=300.0)
    refused(
        r"conductivity = 0\.0 must be positive",
        lambda: Simulation(one, [SMOOTH], heat=ContactHeat(0.0), T=300.0),
    )
    refused(
        r"heat_capacity = .* one for each material",
        lambda: Simulation(one, [SMOOTH], heat=ContactHeat(1.0, [1.0, 2.0]), T=300.0),
    )
