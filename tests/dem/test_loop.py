"""The time loop: what it conserves, symmetry, periodic sides, walls, restart, and what
happens when it goes wrong.

Momentum and angular momentum: round-off of some 1e4 sums, 1e-12 of what is exchanged.
Energy of a smooth elastic gas: velocity Verlet has no drift but an error that
oscillates with the overlaps, 1e-4 at 200 steps an impact. Rotated or shifted runs
differ by round-off that collisions amplify; they are compared over few collisions, to
1e-9.
"""

import os
import signal
import sys
import threading
import time

import numpy as np
import pytest
from pytest import approx

from contbed.compiled import threads
from contbed.compiled.interrupts import deferred_interrupt
from contbed.dem import memory as memory_module
from contbed.dem import neighbours
from contbed.dem.particles import Material, Particles, pair_table
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Cylinder, Domain, Plane, Tube, box
from contbed.errors import ConvergenceError
from contbed.output import checkpoint
from tests.refusals import refused

RADIUS = 1e-3
GLASS = Material(rolling_friction=0.02)
SIDE = 12e-3
CLOSED = Domain((0.0,) * 3, (SIDE,) * 3)
AROUND = Domain((0.0,) * 3, (SIDE,) * 3, (True,) * 3)


def gas(speed=0.2, spin=0.0, seed=1):
    """64 spheres on a jittered lattice in a box of 12 mm."""
    rng = np.random.default_rng(seed)
    lattice = np.stack(
        np.meshgrid(*3 * [np.arange(4)], indexing="ij"), axis=-1
    ).reshape(-1, 3)
    position = (lattice + 0.5) * SIDE / 4 + rng.uniform(-1, 1, lattice.shape) * 4e-4
    velocity, turning = (
        rng.normal(0, speed, lattice.shape),
        rng.normal(0, 1.0, lattice.shape) * spin,
    )
    return Particles(position, RADIUS, velocity=velocity, spin=turning)


def momenta(simulation):
    linear = simulation.mass[:, None] * simulation.velocity
    return linear.sum(axis=0), (
        np.cross(simulation.position, linear)
        + simulation.inertia[:, None] * simulation.spin
    ).sum(0)


def test_energy_of_smooth_elastic_spheres():
    smooth = Material(restitution=1.0, sliding_friction=0.0)
    simulation = Simulation(
        gas(),
        [smooth],
        box(CLOSED, open_top=False),
        CLOSED,
        gravity=(0, 0, 0),
        time_step=1e-6,
    )
    modulus = pair_table([smooth])["youngs_modulus"][0, 0]
    before = simulation.kinetic_energy
    energies = []
    for _ in range(5):
        simulation.run(20_000)
        stored = 0.0
        for delta in simulation.contacts().overlap:
            stored += 8 / 15 * modulus * np.sqrt(RADIUS / 2) * delta**2.5
        for delta in (
            RADIUS
            - neighbours.wall_gaps(simulation.position, simulation._laws.walls).ravel()
        ):
            stored += (
                8 / 15 * 2 * modulus / 2 * np.sqrt(RADIUS) * max(delta, 0.0) ** 2.5
            )
        energies.append(simulation.kinetic_energy + stored)
    assert energies == approx([before] * 5, rel=1e-4)


def test_friction_takes_energy_only():
    simulation = Simulation(
        gas(spin=50.0), [GLASS], domain=AROUND, gravity=(0, 0, 0), time_step=2e-6
    )
    energies = [simulation.kinetic_energy]
    for _ in range(20):
        simulation.run(2000)
        energies.append(simulation.kinetic_energy)
    assert energies[-1] < 0.5 * energies[0]
    # overlaps store and return a little
    assert (np.diff(energies) < 1e-3 * energies[0]).all()


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_momentum_and_angular_momentum(axis):
    """Free spheres of two sizes, spinning about every axis; a cloud that meets
    another one.
    """
    particles = gas(0.05, 100.0)
    particles.radius[::3] *= 0.7
    particles.velocity[:, axis] += np.where(
        particles.position[:, axis] < SIDE / 2, 0.5, -0.5
    )
    simulation = Simulation(particles, [GLASS], gravity=(0, 0, 0), time_step=2e-6)
    linear, angular = momenta(simulation)
    scale = float((simulation.mass * np.linalg.norm(simulation.velocity, axis=1)).sum())
    simulation.run(10_000)
    assert simulation.contacts().since.size or simulation.kinetic_energy > 0.0
    after = momenta(simulation)
    assert np.abs(after[0] - linear).max() < 1e-12 * scale
    assert np.abs(after[1] - angular).max() < 1e-12 * scale * SIDE


@pytest.mark.parametrize("turn", [1, 2])
def test_the_same_on_every_axis(turn):
    """Axes exchanged in a cycle: the same motion, gravity and walls included."""
    found = []
    for roll in (0, turn):
        particles = gas(spin=20.0)
        for name in ("position", "velocity", "spin"):
            setattr(
                particles,
                name,
                np.ascontiguousarray(np.roll(getattr(particles, name), roll, axis=1)),
            )
        gravity = np.roll([0, 0, -9.81], roll)
        simulation = Simulation(
            particles, [GLASS], box(CLOSED, open_top=False), CLOSED, gravity, 5e-6
        )
        simulation.run(2000)
        found.append(np.roll(simulation.position, -roll, axis=1))
    assert np.abs(found[0] - found[1]).max() < 1e-9 * RADIUS


def test_periodic_sides_do_not_matter_where_they_are():
    found = []
    for shift in (0.0, 0.37 * SIDE):
        particles = gas(spin=20.0)
        particles.position += shift
        simulation = Simulation(
            particles, [GLASS], domain=AROUND, gravity=(0, 0, 0), time_step=5e-6
        )
        simulation.run(2000)
        assert len(simulation.contacts()) >= 0
        found.append((simulation.velocity, np.mod(simulation.position - shift, SIDE)))
    assert np.abs(found[0][0] - found[1][0]).max() < 1e-9
    apart = found[0][1] - found[1][1]
    assert np.abs(apart - SIDE * np.rint(apart / SIDE)).max() < 1e-9 * SIDE


def test_contact_across_a_periodic_side():
    particles = Particles([[0.4 * RADIUS, 0, 0], [SIDE - 1.59 * RADIUS, 0, 0]], RADIUS)
    domain = Domain((0, -SIDE, -SIDE), (SIDE, SIDE, SIDE), (True, False, False))
    simulation = Simulation(particles, [GLASS], domain=domain, gravity=(0, 0, 0))
    closed = simulation.contacts()
    assert closed.overlap == approx([0.01 * RADIUS])
    assert closed.normal == approx(np.array([[1.0, 0.0, 0.0]]))
    simulation.run(5)
    assert simulation.velocity[0, 0] > 0.0 > simulation.velocity[1, 0]


@pytest.mark.parametrize(("count", "number"), [(300, 1), (3000, 1), (3000, 2)])
@pytest.mark.parametrize("domain", [AROUND, CLOSED])
def test_the_list_has_every_pair_once(domain, count, number):
    """Also across blocks of memory, for particles of several sizes and on two
    threads.
    """
    rng = np.random.default_rng(3)
    x, radius = (
        rng.uniform(0, SIDE, (count, 3)),
        rng.uniform(0.3, 1.0, count) * RADIUS * (300 / count) ** (1 / 3),
    )
    with threads.using(number):
        simulation = Simulation(
            Particles(x, radius),
            [GLASS],
            domain=domain,
            skin=2e-4,
            largest_overlap=10.0,
        )
    record = simulation._memory.read()
    row, other, gap, normal = simulation._listed_pairs(record)
    apart = x[:, None] - x[None]
    apart -= np.where(domain.periodic, SIDE * np.rint(apart / SIDE), 0.0)
    distance = np.linalg.norm(apart, axis=-1)
    near = distance < radius[:, None] + radius + 2e-4
    pairs = np.sort([record.user[row], record.user[other]], axis=0)
    assert sorted(zip(*pairs.tolist(), strict=True)) == [
        (i, j) for i, j in np.argwhere(near).tolist() if i < j
    ]
    assert gap == approx(
        distance[tuple(pairs)] - radius[pairs[0]] - radius[pairs[1]], abs=1e-15
    )
    assert np.linalg.norm(normal, axis=1) == approx(1.0)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_round_walls(axis):
    """A sphere falls on a tube and into a cylinder, both along the axis, and ends
    beside the tube at the bottom.
    """
    down, side = (axis + 1) % 3, (axis + 2) % 3
    gravity, direction, start = np.zeros(3), np.zeros(3), np.zeros(3)
    gravity[down], direction[axis], start[down], start[side] = -9.81, 1.0, 5e-3, 1e-3
    walls = [
        Cylinder((0,) * 3, tuple(direction), 8e-3),
        Tube((0,) * 3, tuple(direction), 2e-3),
    ]
    material = Material(restitution=0.3, rolling_friction=0.05)
    simulation = Simulation(
        Particles([start], RADIUS), [material], walls, gravity=gravity, time_step=1e-5
    )
    simulation.run(100_000)
    assert simulation.position[0, down] == approx(-7e-3, rel=2e-2)
    assert np.hypot(
        simulation.position[0, down], simulation.position[0, side]
    ) == approx(7e-3, rel=1e-3)
    assert simulation.kinetic_energy < 1e-12


def test_two_materials_in_contact_with_a_wall_of_a_third():
    soft, hard = (
        Material(1000.0, 1e6, restitution=0.2),
        Material(8000.0, 1e8, restitution=0.2),
    )
    slick = Material(restitution=0.2, sliding_friction=0.0)
    particles = Particles([[0, 0, RADIUS], [0, 0, 3 * RADIUS]], RADIUS, material=[0, 1])
    simulation = Simulation(
        particles, [soft, hard, slick], [Plane((0, 0, 0), (0, 0, 1), 2)], time_step=2e-6
    )
    simulation.run(100_000)
    weight = simulation.mass * 9.81
    overlap, modulus = (
        simulation.contacts().overlap[0],
        pair_table([soft, hard, slick])["youngs_modulus"],
    )
    force = 4 / 3 * modulus[0, 1] * np.sqrt(RADIUS / 2) * overlap**1.5
    floor = (
        4
        / 3
        * modulus[0, 2]
        * np.sqrt(RADIUS)
        * (RADIUS - simulation.position[0, 2]) ** 1.5
    )
    assert force == approx(weight[1], rel=1e-3)
    assert floor == approx(weight.sum(), rel=1e-3)


def test_force_on_particles():
    simulation = Simulation(Particles([[0, 0, 0]], RADIUS), [GLASS])
    simulation.force[:] = -simulation.mass[:, None] * simulation.gravity
    simulation.run(1)
    simulation.velocity[:] = 0.0
    simulation.run(100)
    assert np.abs(simulation.velocity).max() < 1e-15


def falling(**change):
    particles = gas(0.1, 20.0)
    particles.radius[::5] *= 0.8
    return Simulation(
        particles,
        [GLASS],
        box(CLOSED),
        Domain(CLOSED.lower, (SIDE, SIDE, np.inf)),
        time_step=5e-6,
        **change,
    )


def test_restart_is_bitwise(tmp_path):
    """A then B, from a file, gives what AB gives; and so do intervals of any length."""
    whole, first = falling(), falling()
    whole.run(12_000, interval=12_000)
    first.run(7654, interval=100)
    assert len(first.contacts())
    checkpoint.save(tmp_path, first.state(), {})
    second = falling()
    second.restore(checkpoint.load(tmp_path)[0])
    second.run(12_000 - 7654, interval=1234)
    for name, array in whole.state().items():
        assert array.tobytes() == second.state()[name].tobytes(), name


def test_restart_of_another_simulation():
    state = falling().state()
    alone = Simulation(Particles([[0, 0, 0]], RADIUS), [GLASS])
    refused(
        r"does not fit this scene: position is float64 of shape \(64, 3\)",
        alone.restore,
        state,
    )
    refused(
        "the checkpoint lacks row",
        lambda: falling().restore(
            {name: array for name, array in state.items() if name != "row"}
        ),
    )
    refused(
        r"numbers is float64 of shape \(5,\), expected float64 of shape \(6,\)",
        lambda: falling().restore(state | {"numbers": state["numbers"][:-1]}),
    )


@pytest.mark.parametrize("name", ["entry", "user", "wall", "wall_particle"])
def test_lists_of_a_checkpoint_name_what_exists(name):
    """Compiled loops would read beyond their arrays."""
    whole = falling()
    whole.run(2000)
    state = whole.state()
    assert state[name].size
    refused(
        "lists name particles or walls that do not exist",
        falling().restore,
        state | {name: np.full_like(state[name], 1000)},
    )


def test_lists_of_a_checkpoint_reach_as_far_as_those_of_the_run():
    """A wider skin takes longer to be passed: pairs that meet in the meantime have
    to be in the list.
    """
    narrow, wide = falling(skin=0.1 * RADIUS), falling(skin=0.4 * RADIUS)
    refused(
        r"the checkpoint has lists with a skin of 0.0001 m, expected 0.0004 m",
        lambda: wide.restore(narrow.state()),
    )
    narrow.restore(wide.state())


def test_history_keeps_first_touch_and_impact_speed():
    particles = Particles(
        [[0, 0, 0], [2.1 * RADIUS, 0, 0]], RADIUS, velocity=[[0.1, 0, 0], [0, 0, 0]]
    )
    simulation = Simulation(particles, [GLASS], gravity=(0, 0, 0), time_step=1e-6)
    simulation.run(1050)
    closed = simulation.contacts()
    assert closed.since == approx([0.1 * RADIUS / 0.1], abs=2e-6)
    assert closed.impact_speed == approx([0.1])


def test_blow_up_names_the_particle_and_keeps_the_state():
    simulation = falling()
    simulation.run(100)
    before = simulation.state()
    simulation.force[7, 0] = np.nan
    with pytest.raises(
        ConvergenceError, match=r"particle 7 at .* moves at nan m/s"
    ) as caught:
        simulation.run(1000, interval=1000)
    assert simulation.steps_done == 100
    assert caught.value.state["position"].tobytes() == before["position"].tobytes()
    simulation.force[:] = 0.0
    simulation.force[9, 2] = 100.0
    with pytest.raises(
        ConvergenceError,
        match=r"particle 9 at .* more than 0.1 of the smallest radius in a step",
    ):
        simulation.run(1000, interval=1000)


def test_lost_particles_are_named():
    domain = Domain((0.0,) * 3, (SIDE,) * 3)
    particles = Particles(
        [[SIDE / 2] * 3, [SIDE - 2e-3, SIDE / 2, SIDE / 2]],
        RADIUS,
        velocity=[[0, 0, 0], [1.0, 0, 0]],
    )
    simulation = Simulation(particles, [GLASS], domain=domain, gravity=(0, 0, 0))
    with pytest.raises(
        ConvergenceError, match=r"particle 1 at .* left the domain at t = 0\.00"
    ):
        simulation.run(1000)
    simulation = Simulation(
        particles,
        [Material(youngs_modulus=1e3)],
        box(domain),
        domain,
        gravity=(0, 0, 0),
        time_step=1e-5,
    )
    with pytest.raises(
        ConvergenceError,
        match=r"particle 1 at .* (pushed through a wall|left the domain)",
    ):
        simulation.run(10_000)


@pytest.mark.parametrize(
    ("position", "walls", "message"),
    [
        (
            [[0, 0, 0], [0, 0, 1.5e-3]],
            [],
            "particles 0 and 1 overlap by 0.0005 m at the start, 0.5 of the smaller",
        ),
        ([[0, 0, 0], [0, 0, 0]], [], "particles 0 and 1 overlap by 0.002 m"),
        (
            [[0, 0, 0.5e-3]],
            [Plane((0, 0, 0), (0, 0, 1))],
            "particle 0 at .* overlaps wall 0",
        ),
        (
            [[0, 0, -2e-3]],
            [Plane((0, 0, 0), (0, 0, 1))],
            "particle 0 at .* is beyond wall 0",
        ),
        ([[0, 0, 1.0]], [], "particle 0 at .* is outside the domain"),
        (np.zeros((0, 3)), [], "no particles"),
    ],
)
def test_bad_starts(position, walls, message):
    domain = Domain((-1, -1, -1), (1, 1, 0.5))
    refused(
        message, lambda: Simulation(Particles(position, RADIUS), [GLASS], walls, domain)
    )


def test_other_mistakes():
    one = Particles([[0, 0, 0]], RADIUS)
    refused(
        r"periodic length 0\.002 m in x, at least 0\.0063 m",
        lambda: Simulation(
            one, [GLASS], domain=Domain((0, 0, 0), (2e-3, 1, 1), (True, False, False))
        ),
    )
    refused(
        "material 1 does not exist, there are 1",
        lambda: Simulation(one, [GLASS], [Plane((0, 0, -1), (0, 0, 1), material=1)]),
    )
    refused(
        r"position of particle 1 is not finite",
        Particles,
        [[0, 0, 0], [np.nan, 0, 0]],
        RADIUS,
    )
    refused(
        r"radius has shape \(3,\), \(1,\) is needed", Particles, [[0, 0, 0]], [1, 2, 3]
    )
    refused("radius 0 m of particle 0", Particles, [[0, 0, 0]], 0.0)
    refused(
        "has no direction",
        lambda: Simulation(one, [GLASS], [Plane((0, 0, -1), (0, 0, 0))]),
    )


def interrupted(simulation, seconds):
    """Run until SIGINT arrives after `seconds`, whatever handler the test runner has
    set.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    try:
        with pytest.raises(KeyboardInterrupt):
            timer.start()
            simulation.run(10_000_000, interval=20)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)


def test_an_interrupt_comes_at_once_and_leaves_a_whole_state():
    """Many short pieces of compiled code, so that most signals arrive while arrays
    go in or out of one.
    """
    simulation = falling()
    simulation.run(1)  # compiles, which an interrupt waits for
    for k in range(20):
        start = time.perf_counter()
        interrupted(simulation, 2e-3 + 1.3e-3 * k)
        # 0.2 s unless other processes take the cores
        assert time.perf_counter() - start < 10.0
    whole = falling()
    whole.run(simulation.steps_done, interval=simulation.steps_done)
    for name, array in whole.state().items():
        assert array.tobytes() == simulation.state()[name].tobytes(), name


def test_a_long_interval_is_cut_so_that_an_interrupt_is_heard(monkeypatch):
    monkeypatch.setattr(memory_module, "CHUNK", 64 * 100)
    cut, whole = falling(), falling()
    cut.run(1234, interval=1234)
    monkeypatch.undo()
    whole.run(1234, interval=1234)
    for name, array in whole.state().items():
        assert array.tobytes() == cut.state()[name].tobytes(), name


def test_an_interrupt_at_any_line_of_the_guard_leaves_it_ready():
    """Between all lines of entering and leaving: an interrupt is told, or held and
    told, and the next one is held.
    """

    def interrupt_at(wanted):
        """Send SIGINT at one of the lines; return how many there are."""
        lines = 0

        def trace(frame, event, argument):
            nonlocal lines
            guard = frame.f_code.co_filename.endswith(
                "interrupts.py"
            ) and frame.f_code.co_name in (
                "__enter__",
                "__exit__",
            )
            if guard and event == "line":
                lines += 1
                if lines == wanted:
                    os.kill(os.getpid(), signal.SIGINT)
            return trace

        former, handler = (
            sys.gettrace(),
            signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        sys.settrace(trace)
        try:
            with deferred_interrupt():
                pass
        except KeyboardInterrupt:
            pass
        finally:
            sys.settrace(former)
            signal.signal(signal.SIGINT, handler)
        assert not deferred_interrupt._held, wanted
        return lines

    for line in range(1, interrupt_at(0) + 1):
        interrupt_at(line)
