"""Gas between particles: exact pressure drop, exchange to rounding, Schumann's
fronts, fluidization, restart.
"""

from dataclasses import replace
from functools import partial
from itertools import cycle

import numpy as np
import pytest
from pytest import approx
from scipy.special import i0e

from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.gas_quantities import Motion
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.heat_transfer import Average, coefficients
from contbed.closures import drag_di_felice, drag_gidaspow, drag_wen_yu, nusselt_gunn
from contbed.compiled import threads
from contbed.dem.heat import radiation_conductance
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain
from contbed.errors import ConvergenceError
from contbed.materials.constant import ConstantFluid
from contbed.materials.gas import gas_mixture
from tests.refusals import refused

AIR = ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026)
HOT_AIR = gas_mixture("N2:0.79, O2:0.21", 101325.0)
D = 2e-3
GLASS = Material(2500.0, 1e6, restitution=0.5)
VOLUME = np.pi / 6 * D**3


def lattice(step, *count):
    return np.stack(
        np.meshgrid(*[(np.arange(n) + 0.5) * step for n in count], indexing="ij"), -1
    ).reshape(-1, 3)


def at_rest(x, d=D):
    return Motion(x, np.zeros_like(x), np.full(len(x), d / 2))


@pytest.fixture(scope="module")
def packing():
    return pack(
        (10 * D, 10 * D),
        radius=D / 2,
        count=1000,
        seed=1,
        periodic=(True, True),
        material=GLASS,
    )


@pytest.fixture(scope="module")
def scattered():
    """400 spheres at random, with random velocities: for what must hold whatever the
    state is.
    """
    rng = np.random.default_rng(2)
    x = rng.uniform(D / 2, 12 * D - D / 2, (400, 3)) * [1, 1, 2]
    return Motion(x, rng.normal(0, 0.3, (400, 3)), rng.uniform(0.4, 0.6, 400) * D)


def box(periodic=(False, False), height=24, **options):
    return Grid(
        np.zeros(3), np.full(3, 3 * D), (4, 4, height // 3), periodic, **options
    )


def bed_of(packing, U, gas=None, nusselt=None, periodic=(True, True), **options):
    simulation = Simulation(
        Particles(packing.position, packing.radius),
        [GLASS],
        packing.walls,
        packing.domain,
        impact_speed=0.3,
    )
    grid = Grid(np.zeros(3), np.array([2.5, 2.5, 1.0]) * D, (4, 4, 40), periodic)
    gas = gas or Gas(grid, AIR, drag_gidaspow, nusselt)
    gas.inlet(U, 300.0)
    return Bed(simulation, gas, **options)


def crowd():
    """So many spheres that three threads take parts of them."""
    rng = np.random.default_rng(4)
    x = lattice(1.1 * D, 24, 24, 24) + rng.uniform(-0.04, 0.04, (13824, 3)) * D
    gas = Gas(
        Grid(np.zeros(3), np.full(3, 3.3 * D), (8, 8, 9), (True, False)),
        AIR,
        drag_gidaspow,
        nusselt_gunn,
    )
    gas.inlet(0.7, 300.0)
    return gas, Motion(
        x,
        rng.normal(0, 0.3, x.shape),
        np.full(len(x), D / 2),
        rng.uniform(300.0, 400.0, len(x)),
    )


def test_the_same_bits_on_several_threads(monkeypatch):
    """With heat; sums are in parts whatever the number of threads is, which may
    change from one kernel to the next.
    """
    found, turn = [], cycle((1, 3, 2))
    with threads.using(3):
        assert threads.count(len(crowd()[1].x)) == 3
    for count in (lambda *_: 1, lambda *_: 3, lambda *_: next(turn)):
        gas, bed = crowd()
        monkeypatch.setattr(threads, "count", count)
        found.append([*gas.step(1e-4, bed), *gas.step(1e-4, bed), gas.u, gas.p, gas.T])
    for other in found[1:]:
        assert all(
            one.tobytes() == value.tobytes()
            for one, value in zip(found[0], other, strict=True)
        )


@pytest.mark.parametrize("drag", [drag_di_felice, drag_gidaspow, drag_wen_yu])
@pytest.mark.parametrize("periodic", [True, False])
def test_a_uniform_bed_has_the_pressure_drop_of_its_closure(drag, periodic):
    # every cell holds the same share of the same lattice: nothing is approximated,
    # 1e-12 is rounding
    step, U = 1.05 * D, 0.8
    x = lattice(step, 9, 9, 15)
    gas = Gas(
        Grid(np.zeros(3), np.full(3, 3 * step), (3, 3, 5), (periodic,) * 2),
        AIR,
        drag,
        gravity=(0, 0, 0),
        tolerance=1e-13,
    )
    gas.inlet(U, 300.0)
    for _ in range(200):
        force, _ = gas.step(1e-3, at_rest(x))
    eps = 1 - np.pi / 6 / 1.05**3
    wanted = (
        drag(Re=U * 1.2 * D / 1.8e-5, eps=eps, d_p=D, mu=1.8e-5)
        * U
        / eps**2
        * 15
        * step
    )
    assert gas.pressure_drop == approx(wanted, rel=1e-12)
    assert force[:, 2].sum() == approx(wanted * (9 * step) ** 2, rel=1e-12)
    assert np.abs(force[:, :2]).max() < 1e-12 * force[:, 2].max()


@pytest.mark.parametrize("periodic", [True, False])
def test_what_the_gas_gives_is_what_the_particles_get(scattered, periodic):
    gas = Gas(box((periodic, periodic)), AIR, drag_di_felice)
    gas.inlet(1.0, 300.0)
    for _ in range(5):
        force, _ = gas.step(1e-4, scattered)
        for axis in range(3):
            given = gas.given[gas.grid.face_axis == axis].sum()
            assert force[:, axis].sum() == approx(
                given, rel=1e-12, abs=1e-15 * np.abs(force).sum()
            )


def test_volumes_and_porosity_keep_the_solid(scattered):
    # particles that reach beyond a wall count inside of it: not a grain is lost
    gas = Gas(box(), AIR, drag_di_felice)
    gas.step(1e-4, scattered)
    assert ((1 - gas.eps) * gas.grid.volume).sum() == approx(
        scattered.volume.sum(), rel=1e-12
    )
    for axis in range(3):
        own = gas.grid.face_volume[gas.grid.face_axis == axis]
        assert own.sum() == approx(gas.grid.cells * gas.grid.volume, rel=1e-12)


def test_spheres_above_the_grid_fall_freely():
    # thrown up from above the grid into a jet of hot air: the parabola of a fall in
    # vacuum, which the particles' steps meet exactly, 1e-12 is rounding; the gas does
    # what it does without the spheres
    D3, top, start, speed = (
        3 * D,
        24 * D,
        np.array([[0.3, 0.5, 1.05], [0.5, 0.5, 1.5]]),
        np.array([0.2, 0.1, 0.5]),
    )
    domain = Domain((0, 0, 0), (4 * D3, 4 * D3, np.inf), (True, True, False))
    beds = []
    for place in (
        start * [4 * D3, 4 * D3, top],
        np.array([[2 * D3, 2 * D3, 1e3 * top]]),
    ):
        spheres = Particles(place, D / 2, velocity=np.tile(speed, (len(place), 1)))
        gas = Gas(box((True, True)), AIR, drag_di_felice, nusselt_gunn)
        gas.inlet(10.0, 400.0)
        simulation = Simulation(spheres, [GLASS], (), domain, impact_speed=0.3)
        beds.append(Bed(simulation, gas, T=300.0))
        beds[-1].run(0.02)
    bed, far = beds
    t = bed.time
    fallen = (
        start * [4 * D3, 4 * D3, top]
        + speed * t
        - 0.5 * np.array([0.0, 0.0, 9.81]) * t**2
    )
    assert bed.simulation.position == approx(fallen, rel=1e-12)
    assert np.array_equal(bed.T, [300.0, 300.0]) and bed.above > 0
    assert (bed.gas.eps == 1.0).all() and not bed.gas.given.any()
    assert np.array_equal(bed.gas.q, far.gas.q) and np.array_equal(bed.gas.T, far.gas.T)


def test_a_sphere_across_the_top_counts_with_its_part_below():
    # a cap of height h has the volume pi h^2 (3 R - h)/3; what the gas gives is what it
    # gets, 1e-12 is rounding
    R, height = D / 2, 24 * D
    for h in (1e-3 * R, 0.5 * R, R, 1.5 * R, 2 * R):
        sphere = Motion(
            np.array([[6.1 * D, 5.7 * D, height + R - h]]),
            np.array([[0.1, 0.2, -0.3]]),
            np.array([R]),
        )
        gas = Gas(box(), AIR, drag_di_felice)
        gas.inlet(1.0, 300.0)
        for _ in range(3):
            force, _ = gas.step(1e-4, sphere)
        held = (1 - gas.eps) * gas.grid.volume
        assert held.sum() == approx(
            np.pi * h**2 * (3 * R - h) / 3, rel=1e-12, abs=1e-15 * gas.grid.volume
        )
        assert held.reshape(gas.grid.count)[:, :, :-1].sum() == 0.0
        given = [gas.given[gas.grid.face_axis == axis].sum() for axis in range(3)]
        assert force[0] == approx(given, rel=1e-12, abs=1e-15 * np.abs(force).sum())
        assert force[0, 2] > 0.0


def test_heat_of_spheres_that_cross_the_top_stays(scattered):
    # half of the spheres reach or are above the grid: what they receive is what the gas
    # gives
    lifted = Motion(
        scattered.x + np.array([0, 0, 12 * D]),
        scattered.v,
        scattered.radius,
        np.linspace(300.0, 900.0, 400),
    )
    gas = Gas(box(), AIR, drag_di_felice, nusselt_gunn)
    gas.inlet(1.0, 300.0)
    total = 0.0
    for _ in range(5):
        force, received = gas.step(1e-4, lifted)
        total += 1e-4 * received.sum()
        above = lifted.x[:, 2] - lifted.radius > 24 * D
        assert (
            above.sum() > 100 and not force[above].any() and not received[above].any()
        )
        for axis in range(3):
            given = gas.given[gas.grid.face_axis == axis].sum()
            assert force[:, axis].sum() == approx(
                given, rel=1e-12, abs=1e-15 * np.abs(force).sum()
            )
    assert total == approx(-gas.sums["gained"], rel=1e-12)


def test_gas_at_rest_stays_at_rest(scattered):
    bed = Motion(scattered.x, np.zeros_like(scattered.x), scattered.radius)
    gas = Gas(box(), AIR, drag_di_felice, tolerance=1e-12)
    for _ in range(20):
        force, _ = gas.step(1e-4, bed)
    assert np.abs(gas.u).max() < 1e-12
    # and its pressure is the weight of the gas above, so that spheres feel buoyancy
    z = gas.grid.centres[:, 2]
    assert gas.p == approx(1.2 * 9.81 * (24 * D - z), rel=1e-10)
    assert force[:, 2] == approx(1.2 * 9.81 * bed.volume, rel=1e-9)


def test_both_horizontal_axes_are_alike(scattered):
    turned = Motion(
        *(np.ascontiguousarray(v[:, [1, 0, 2]]) for v in (scattered.x, scattered.v)),
        scattered.radius,
    )
    forces = []
    for bed in (scattered, turned):
        gas = Gas(box(), AIR, drag_di_felice, no_slip=True, tolerance=1e-12)
        gas.inlet(1.0, 300.0)
        for _ in range(5):
            force, _ = gas.step(1e-4, bed)
        forces.append(force)
    assert forces[1][:, [1, 0, 2]] == approx(
        forces[0], rel=1e-9, abs=1e-12 * np.abs(forces[0]).max()
    )


def test_gas_flows_around_blocked_cells():
    blocked = np.zeros((4, 4, 8), bool)
    blocked[1:3, :, 3:5] = True
    gas = Gas(box(blocked=blocked), AIR, drag_di_felice, tolerance=1e-12)
    gas.inlet(0.5, 300.0)
    empty = at_rest(np.array([[D, D, D]]), 1e-5)
    for _ in range(300):
        gas.step(1e-3, empty)
    around = gas.grid.cell_face[blocked.ravel()]
    assert np.abs(gas.q[around]).max() == 0.0
    through = gas.q.copy()[gas.grid.cell_face[:, 5]].reshape(4, 4, 8).sum((0, 1)) / 16
    assert through == approx(np.full(8, 0.5), rel=1e-6)


def schumann(z, t, h_v, eps, u, fluid, solid):
    """Temperatures of fluid and solid over the step at the inlet; u superficial,
    heat capacities in J/m3/K.
    """
    xi, tau = (
        h_v * z / (u * fluid),
        np.maximum(h_v / ((1 - eps) * solid) * (t - z * eps / u), 0.0),
    )
    s = (np.arange(2000) + 0.5) / 2000 * xi[:, None]
    argument = 2 * np.sqrt(tau[:, None] * s)
    kernel = np.exp(-s + argument - tau[:, None]) * i0e(argument)
    hot = np.where(tau > 0, 1 - kernel.mean(axis=1) * xi, 0.0)
    return hot, np.where(
        tau > 0,
        hot - np.exp(-((xi**0.5 - tau**0.5) ** 2)) * i0e(2 * np.sqrt(xi * tau)),
        0.0,
    )


def test_schumann_fronts_at_the_order_of_the_grid():
    # Patil, Peters, Kuipers, Table 1 and Fig. 1: copper of 3.95 mm on a 4 mm lattice,
    # 125 layers, water of 0.1 m/s
    water, d, step = ConstantFluid(1000.0, 4187.0, 1e-3, 0.5), 3.95e-3, 4e-3
    x, eps = lattice(step, 3, 3, 125), 1 - np.pi / 6 * (3.95 / 4) ** 3
    assert eps == approx(0.4958, abs=1e-4)
    gunn = partial(nusselt_gunn, exponent_Pr=0.33)
    h_v = gunn(Re=395.0, Pr=8.374, eps=eps) * 0.5 / d * 6 * (1 - eps) / d
    errors, solids = [], []
    for cells in (25, 50, 100):
        grid = Grid(
            np.zeros(3),
            np.array([3 * step, 3 * step, 0.5 / cells]),
            (1, 1, cells),
            (True, True),
        )
        gas = Gas(grid, water, drag_gidaspow, gunn, gravity=(0, 0, 0))
        gas.inlet(0.1, 310.0)
        copper = Simulation(
            Particles(x, d / 2),
            [Material(8400.0)],
            (),
            Domain((0, 0, 0), (0.012, 0.012, 0.5), (True, True, False)),
            skin=5e-5,
        )
        bed = Bed(
            copper,
            gas,
            gas_step=0.4 * 0.5 / cells * eps / 0.1,
            T=300.0,
            heat_capacity=385.0,
            moving=False,
        )
        bed.run(2.25)
        fluid, _ = schumann(
            grid.centres[:, 2], 2.25, h_v, eps, 0.1, 4.187e6, 8400 * 385.0
        )
        _, solid = schumann(x[:125, 2], 2.25, h_v, eps, 0.1, 4.187e6, 8400 * 385.0)
        errors.append(np.abs((gas.T - 300) / 10 - fluid).mean())
        solids.append(np.abs((bed.T[:125] - 300) / 10 - solid).mean())
        heat = bed.balance()
        assert heat["in"] - heat["out"] - heat["stored"] == approx(
            0.0, abs=1e-12 * heat["in"]
        )
    # first order: halving cells and steps halves the error; 0.02 of the step in
    # temperature on cells of 20 mm
    order = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (order > 0.85).all() and (order < 1.4).all()
    assert errors[0] < 0.02 and errors[2] < 6e-3 and solids[2] < 8e-3


def ergun_velocity(eps):
    a, b = 1.75 / eps**3 * 1.2 / D, 150 * (1 - eps) / eps**3 * 1.8e-5 / D**2
    return (-b + np.sqrt(b**2 + 4 * a * (2500.0 - 1.2) * 9.81)) / (2 * a)


def test_minimum_fluidization_is_ergun_s(packing):
    # drag_gidaspow is Ergun's law, so that only porosity and grid matter: within 5 %,
    # at the porosity of the whole bed
    weight = 1000 * VOLUME * 2500.0 * 9.81
    eps = 1 - 1000 * VOLUME / ((10 * D) ** 2 * packing.statistics["surface"])
    velocities, lift = np.linspace(0.8, 1.2, 3) * ergun_velocity(eps), []
    for U in velocities:
        bed = bed_of(packing, U, moving=False, gas_step=1e-3)
        bed.run(0.03)
        lift.append(bed.force[:, 2].sum() / weight)
    assert np.interp(1.0, lift, velocities) == approx(ergun_velocity(eps), rel=0.05)


@pytest.mark.slow
def test_a_fluidized_bed_is_carried_by_the_gas(packing):
    bed = bed_of(packing, 1.3, gas_step=2e-4)
    bed.run(0.1)
    drops = []
    bed.run(0.15, 1e-3, lambda bed: drops.append(bed.gas.pressure_drop))
    # weight of particles and gas; 5 %: the floor carries 3 % of this bed, which is 9
    # diameters high
    area = (10 * D) ** 2
    wanted = 1000 * VOLUME * 2500.0 * 9.81 / area + 1.2 * 9.81 * (
        40 * D - 1000 * VOLUME / area
    )
    assert np.mean(drops) == approx(wanted, rel=0.05)
    assert (
        bed.simulation.position[:, 2].max() < 40 * D and bed.gas.counts["raised"] == 0
    )


def hot_bed(packing):
    gas = Gas(
        Grid(np.zeros(3), np.array([2.5, 2.5, 2.5]) * D, (4, 4, 20), (True, True)),
        gas_mixture("N2:0.79, O2:0.21", 101325.0),
        drag_di_felice,
        nusselt_gunn,
    )
    bed = bed_of(
        packing,
        1.0,
        gas,
        T=np.linspace(300.0, 340.0, 1000),
        solid=Solid(0.84, modulus=5e10),
    )
    gas.inlet(1.0, 300.0, slot=(3 * D, 7 * D), slot_velocity=8.0, slot_T=900.0)
    return bed


def test_a_hot_jet_closes_its_balances_and_restarts_bit_for_bit(packing):
    whole = hot_bed(packing)
    whole.run(0.01)
    state = {name: value.copy() for name, value in whole.state().items()}
    before = (
        whole.gas.mass.sum() - whole.gas.sums["mass_in"] + whole.gas.sums["mass_out"]
    )
    whole.run(0.01)
    heat, gas = whole.balance(), whole.gas
    assert heat["in"] > 0.1
    assert heat["in"] - heat["out"] - heat["stored"] == approx(
        0.0, abs=1e-10 * heat["in"]
    )
    after = gas.mass.sum() - gas.sums["mass_in"] + gas.sums["mass_out"]
    assert after == approx(before, rel=1e-12)
    assert gas.T.min() > 300.0 - 1e-6 and gas.T.max() < 900.0 + 1e-6
    # the gas fills the room that the pressure gives it, to what one step misses
    assert gas.mass / gas.density == approx(gas.eps * gas.open_volume, rel=0.01)
    again = hot_bed(packing)
    again.restore(state)
    again.run(0.01)
    for name, value in whole.state().items():
        assert np.array_equal(value, again.state()[name], equal_nan=True), name


def test_a_hot_jet_that_begins_shortens_the_first_step():
    """Air of 900 K and 40 m/s from an eighth of the floor into a loose bed, where the
    mean gas takes 1 m/s.

    A step by the mean gas would be 3 of a cell; convection by upwinding keeps
    temperatures between those that enter.
    """
    simulation = Simulation(
        Particles(lattice(1.1 * D, 20, 3, 30), D / 2),
        [GLASS],
        [],
        Domain(),
        impact_speed=0.3,
    )
    gas = Gas(
        Grid(np.zeros(3), np.array([3.0, 4.0, 3.0]) * D, (8, 1, 40), (True, True)),
        HOT_AIR,
        drag_gidaspow,
        nusselt_gunn,
    )
    gas.inlet(0.7, 300.0, (6 * D, 9 * D), 40.0, 900.0)
    bed = Bed(simulation, gas, gas_step=1e-3, T=300.0)
    bed.run(1e-3)
    assert gas.counts["steps"] > 10
    assert gas.T.min() >= 300.0 - 1e-9 and 500.0 < gas.T.max() <= 900.0 + 1e-9


def test_a_step_in_which_more_leaves_a_cell_than_it_holds_is_an_error():
    gas = Gas(box(), HOT_AIR, drag_gidaspow, nusselt_gunn)
    bed = replace(at_rest(lattice(1.1 * D, 8, 8, 12)), T=np.full(768, 300.0))
    gas.inlet(0.7, 300.0)
    gas.start(bed)
    gas.inlet(0.7, 300.0, (3 * D, 6 * D), 40.0, 900.0)
    with pytest.raises(
        ConvergenceError,
        match=r"more leaves a cell in a step of 0.01 s than it holds; shorten gas.step",
    ):
        gas.step(1e-2, bed)


def test_radiation_between_particles_loses_nothing(packing):
    """Round-off of the balance; particles of one temperature exchange none."""
    found = {}
    for name, T, e in (
        ("mixed", np.linspace(600.0, 1200.0, 1000), 0.9),
        ("even", 900.0, 0.9),
        ("none", 900.0, 0.0),
    ):
        bed = found[name] = bed_of(
            packing,
            0.5,
            nusselt=nusselt_gunn,
            T=T,
            emissivity=e,
            moving=False,
            gas_step=1e-3,
        )
        bed.run(0.02)
        heat = bed.balance()
        open_by = heat["in"] - heat["out"] - heat["stored"]
        assert heat["source"] == 0.0
        assert open_by == approx(0.0, abs=1e-10 * abs(bed.gas.sums["gained"]))
    assert approx(found["none"].T, abs=1e-3) == found["even"].T
    # coefficients are those at the temperature of the particles, not of the gas
    average = Average(Solid(1.0), 0.9, 300.0)
    average(found["mixed"])
    T = float(found["mixed"].T.mean())
    wanted = coefficients(found["mixed"], Solid(1.0), 0.9, T)["radiation"]
    assert average.mean["radiation"] == approx(wanted, rel=1e-12)


def test_radiation_between_particles_has_the_slope_of_its_conductances(packing):
    """What it adds in a step, beside 4 sigma e T^3 at 900 K: T varies by 1e-3 of itself,
    and the gas takes 1e-3 of what it changes.
    """
    T = 900.0 + np.random.default_rng(5).uniform(-1.0, 1.0, 1000)
    beds = []
    for e in (0.9, 0.0):
        bed = bed_of(
            packing,
            0.5,
            nusselt=nusselt_gunn,
            T=T,
            solid=Solid(0.0),
            emissivity=e,
            moving=False,
            gas_step=1e-3,
        )
        bed.run(1e-3)
        beds.append(bed)
    hot = beds[0]
    pairs, around = hot._network[0], hot.gas.around(hot.motion)
    d_p = float(2.0 * hot.simulation.radius.mean())
    G = radiation_conductance(pairs, 1000, 900.0, d_p, 0.9, around.eps)
    flow = G * (T[pairs.j] - T[pairs.i])
    wanted = np.bincount(pairs.i, flow, 1000) - np.bincount(pairs.j, flow, 1000)
    found = (beds[0].T - beds[1].T) * hot.capacity / 1e-3
    assert found == approx(wanted, abs=1e-2 * np.abs(wanted).max())


def test_what_cannot_be_is_refused(packing):
    refused(
        r"slot from 0.5 to 0.6 m is outside",
        bed_of(packing, 1.0).gas.inlet,
        1.0,
        300.0,
        slot=(0.5, 0.6),
        slot_velocity=1.0,
    )
    refused(
        r"blocked cells of shape \(1, 1, 1\)",
        lambda: box(blocked=np.zeros((1, 1, 1), bool)),
    )
    refused("go together", bed_of, packing, 1.0, T=300.0)
