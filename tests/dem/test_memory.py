"""Order of memory and threads: neither is seen from outside.

Another order of the particles changes the order of sums, and so the last digits, which
collisions amplify: those runs are compared over few collisions, to 1e-9. Threads change
nothing: those runs are compared bit for bit.
"""

from itertools import cycle

import numpy as np
import pytest

from contbed.cfd_dem.plan import MEMORY
from contbed.compiled import threads
from contbed.dem.contact_heat import ContactHeat
from contbed.dem.kernel_arrays import BLOCK
from contbed.dem.ordering import CUBE
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, box
from contbed.output import checkpoint

RADIUS = 1e-3
GLASS = Material(rolling_friction=0.02)
COUNT = 14  # along each side: 2744 particles in three blocks
SIDE = COUNT * 2.05e-3
DOMAIN = Domain((0.0,) * 3, (SIDE, SIDE, np.inf), (True, False, False))


def crowd(order=None, speed=0.3, sizes=True, heat=True):
    """Spheres close to each other that move at random in a box with one periodic
    side.
    """
    rng = np.random.default_rng(2)
    lattice = np.stack(
        np.meshgrid(*3 * [np.arange(COUNT)], indexing="ij"), axis=-1
    ).reshape(-1, 3)
    n = len(lattice)
    order = np.arange(n) if order is None else order
    velocity, spin = (
        rng.normal(0, speed, (n, 3))[order],
        rng.normal(0, 30.0, (n, 3))[order],
    )
    radius = (
        np.where(np.arange(n) % 5 == 0, 0.8, 1.0)[order] * RADIUS if sizes else RADIUS
    )
    particles = Particles(
        ((lattice + 0.5) * SIDE / COUNT)[order], radius, velocity=velocity, spin=spin
    )
    T = (300.0 + np.arange(n) % 7)[order]
    warm = {"heat": ContactHeat(1.0, 800.0), "T": T} if heat else {}
    return Simulation(
        particles, [GLASS], box(DOMAIN), DOMAIN, time_step=5e-6, skin=1e-4, **warm
    )


@pytest.fixture(scope="module")
def alone():
    """A crowd after some hundred steps and several lists, on one thread."""
    with threads.using(1):
        simulation = crowd()
        simulation.force[::3, 2] = 1e-5
        simulation.run(301)
    return simulation


def bytes_of(memory):
    """Size of all arrays; the system gives memory only to the part that is in use."""
    parts = [memory.side, memory.other, memory.room, memory.sums]
    found = {}
    while parts:
        part = parts.pop()
        if isinstance(part, np.ndarray):
            found[part.ctypes.data] = part.nbytes
        elif isinstance(part, tuple):
            parts += part
    return sum(found.values())


def test_plans_tell_the_memory_of_particles():
    """Six unknowns each; what a run takes besides its arrays for the gas, and their
    parts out of use, is within 2.
    """
    bed = crowd(sizes=False, heat=False)
    told = 1e9 * MEMORY.predicted_GB(6 * len(bed.position))
    assert 1.0 < told / bytes_of(bed._memory) < 2.0


def test_memory_follows_space(alone):
    """Particles are mixed for the user; in memory those of a cube of cells follow
    each other.
    """
    memory = alone._memory
    assert sorted(memory.user.tolist()) == list(range(len(alone.position)))
    assert (memory.user != np.arange(len(memory.user))).any()
    x = memory.side.pairs.listed
    reach = 2.0 * RADIUS + 1e-4
    ends = np.array([np.ptp(x[k : k + 64], axis=0) for k in range(0, len(x) - 64, 64)])
    assert np.median(ends.max(axis=1)) < (1 << CUBE) * reach
    assert memory.blocks == 3 and len(x) > 2 * BLOCK
    assert memory.side.pairs.used[1].sum() > 0


@pytest.mark.parametrize("number", [2, 3])
def test_the_same_bits_on_several_threads(alone, number, monkeypatch):
    monkeypatch.setattr("contbed.dem.memory.LEAST", 1)
    with threads.using(number):
        simulation = crowd()
        simulation.force[::3, 2] = 1e-5
        simulation.run(301)
    state = simulation.state()
    for name, array in alone.state().items():
        assert array.tobytes() == state[name].tobytes(), name


def test_the_number_of_threads_may_change_at_any_time(alone, monkeypatch):
    """As it does where a run measures which number is the fastest."""
    turn = cycle([2, 1, 3])
    monkeypatch.setattr("contbed.compiled.threads.count", lambda *_: next(turn))
    simulation = crowd()
    simulation.force[::3, 2] = 1e-5
    simulation.run(301, 7)
    state = simulation.state()
    for name, array in alone.state().items():
        assert array.tobytes() == state[name].tobytes(), name


def test_the_same_bits_of_equal_spheres_on_two_threads(monkeypatch):
    monkeypatch.setattr("contbed.dem.memory.LEAST", 1)
    found = []
    for number in (1, 2):
        with threads.using(number):
            simulation = crowd(sizes=False, heat=False)
            simulation.run(150)
        found.append(simulation.state())
    for name, array in found[0].items():
        assert array.tobytes() == found[1][name].tobytes(), name


def test_the_order_of_the_user_does_not_matter():
    order = np.random.default_rng(5).permutation(COUNT**3)
    first, second = crowd(), crowd(order)
    for simulation in (first, second):
        simulation.run(100)
    assert len(first.contacts()) > 100
    for name, scale in (
        ("position", RADIUS),
        ("velocity", 0.3),
        ("spin", 30.0),
        ("T", 1.0),
    ):
        assert (
            np.abs(getattr(first, name)[order] - getattr(second, name)).max()
            < 1e-9 * scale
        ), name
    contacts = second.contacts()
    back = np.sort([order[contacts.i], order[contacts.j]], axis=0)
    closed = first.contacts()
    assert set(zip(*back.tolist(), strict=True)) == set(
        zip(closed.i.tolist(), closed.j.tolist(), strict=True)
    )
    assert (contacts.i < contacts.j).all()


def test_forces_and_sources_reach_the_particle_that_the_user_means():
    simulation = crowd(speed=0.0)
    simulation.gravity[:] = 0.0
    simulation.velocity[:], simulation.spin[:] = 0.0, 0.0
    simulation.force[1234], simulation.heat_source[77] = (0.0, 0.0, 1e-6), 1.0
    before = simulation.T.copy()
    simulation.run(50)
    assert int(simulation.velocity[:, 2].argmax()) == 1234
    assert (simulation.T - before)[77] == pytest.approx(
        simulation.time / simulation.heat_capacity[77], rel=1e-9
    )


def test_springs_survive_a_new_order():
    """Friction between two spheres that change places in memory while they touch: as
    in a run whose list stays.
    """
    found = []
    for skin in (1e-5, 5e-3):
        pair = Particles(
            [[0, 0, 0], [1.999e-3, 0, 0], [0.03, 0, 0]],
            RADIUS,
            velocity=[[0, 0, 0.5], [0, 0, 0.45], [-0.5, 0.1, 0]],
        )
        simulation = Simulation(
            pair, [GLASS], gravity=(0, 0, 0), time_step=1e-6, skin=skin
        )
        simulation.run(400)
        contacts = simulation.contacts()
        found.append(
            (simulation.velocity.copy(), contacts.since, contacts.impact_speed)
        )
    for first, second in zip(*found, strict=True):
        assert first == pytest.approx(second, rel=1e-9, abs=1e-12)


def test_restart_across_a_new_order(tmp_path):
    whole, first = crowd(), crowd()
    whole.run(200)
    first.run(90)
    user = first._memory.user.copy()
    checkpoint.save(tmp_path, first.state(), {})
    second = crowd()
    second.restore(checkpoint.load(tmp_path)[0])
    second.run(110)
    assert (second._memory.user != user).any()
    state = second.state()
    for name, array in whole.state().items():
        assert array.tobytes() == state[name].tobytes(), name


def test_lists_that_outgrow_their_room():
    """A cloud that falls together needs more room than at the start; the run is that
    of one that had it.
    """
    roomy, tight = crowd(speed=0.05), crowd(speed=0.05)
    tight._memory._places = (1, 1, 1)
    tight._memory._allocate()
    tight._memory.start()
    for simulation in (roomy, tight):
        simulation.run(60)
    assert min(tight._memory._places[:2]) > 1
    for name, array in roomy.state().items():
        assert array.tobytes() == tight.state()[name].tobytes(), name


def test_memory_of_a_particle():
    simulation = crowd(sizes=False, heat=False)
    assert bytes_of(simulation._memory) < 2200 * len(simulation.position)
