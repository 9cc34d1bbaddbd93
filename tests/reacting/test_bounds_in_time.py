"""Runs in time: no amount falls below zero, order, steps and totals stay; each test
first sees how far it would fall.

Amounts are bounded to 1e-10 of their size, to which Newton's method solves.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pytest import approx
from reacting_bed_scenes import (
    N_SOLID,
    fixed_bed,
    isothermal,
    let_move,
    shrinking_core,
    solids,
    species,
)
from solving import course_of, marched

import contbed
from contbed.fem.ad.dual import Dual
from contbed.loading import from_dict
from contbed.reacting_bed import course as course_module
from contbed.reacting_bed import positivity_in_time as module
from contbed.reacting_bed.equations.consumption_limit import within
from contbed.reacting_bed.least_amounts import between_nodes, lowest
from contbed.reacting_bed.solve import Report
from contbed.reacting_bed.stages import GAMMA, stages
from tests.balances import assert_closed
from tests.scene_text import set_keys

LEFT = 1.1e-10  # below zero, of the size of an amount
CLOSED = 1e-12


def least_of(scene):
    """The least amount of all steps, at nodes and between them where polynomials are
    the solution.
    """
    course = course_of(scene)
    least = 0.0
    for history in marched(course):
        problem = course.at(history.time)
        kept = [
            k for k, name in enumerate(problem.names) if name.startswith(("g_", "n_"))
        ]
        least = min(least, lowest(problem, history.state)[kept].min())
    return least


def unbounded(monkeypatch, scene):
    """The least amount of all steps without bounds."""
    with monkeypatch.context() as patch:
        patch.setattr(module, "TRIALS", 0)
        return least_of(scene)


def cores(end):
    """Fast cores of 0.2 mm at rest, whose front is shorter than a cell."""
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    set_keys(
        scene,
        """
        mesh.length = 0.1
        mesh.cells = 4
        solids.particles.diameter = 2e-4
        """,
    )
    scene["solids"]["particles"] |= solids()
    table = {
        "equation": "A + S -> B + P",
        "law": "shrinking_core",
        "A": 1e-2,
        "E": 0.0,
        "diffusivity": 1e-7,
    }
    return scene | {"reactions": {"r": table}, "time": {"end": end, "tolerance": 1e-3}}


def fast_cores():
    """Cores so fast that A below zero takes P in the first step, before there is
    any: P ended alone makes it worse.
    """
    scene = cores(1.0)
    set_keys(scene, "reactions.r.A = 1.0")
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    return scene


def in_series():
    """A -> B -> C: C begins at zero where the gas enters."""
    scene = isothermal("A:1", species(A=0.028, B=0.028, C=0.028))
    set_keys(
        scene,
        """
        reactions = { first = { equation = "A -> B", A = 10.0, E = 0.0 } }
        reactions.second = { equation = "B -> C", A = 10.0, E = 0.0 }
        mesh.cells = 6
        packed_bed.gas_storage = "quasi_steady"
        """,
    )
    return scene | {"time": {"end": 0.2}}


def test_the_first_step_and_the_end_do_not_decide_how_many_steps_follow(monkeypatch):
    """The chain in gas that fills the pores, to its steady state: B and C are zero
    where the gas enters, and damping there settles.

    Where it comes and goes the same runs take from 240 to 1900 steps. The gas that
    leaves differs by errors of steps, at most 1e-4 each.
    """
    random, steps, leaves = np.random.default_rng(7), [], []
    times = np.linspace(0.3, 2.0, 18)
    for _ in range(4):
        scene = in_series()
        set_keys(scene, 'mesh.cells = 20\npacked_bed.gas_storage = "stored"')
        scene["time"] = {"end": random.uniform(2.0, 3.0), "times": times.tolist()}
        monkeypatch.setattr(
            course_module, "FIRST_STEP", 10.0 ** random.uniform(-4.0, -2.5)
        )
        result = contbed.run(from_dict(scene))
        outlet = result.tables["outlet"]
        steps.append(np.sum(outlet["t [s]"] <= 2.0))
        leaves.append(
            [np.interp(times, outlet["t [s]"], outlet[f"x_{gas} [1]"]) for gas in "ABC"]
        )
    assert max(steps) < 1.3 * min(steps)
    assert np.ptp(leaves, axis=0).max() < 1e-3


def moving():
    """Cores against the gas, from a bed that has not reacted."""
    scene = shrinking_core(10.0, 0.8, 0.3, 0.4, 0.3)
    set_keys(scene, "mesh.cells = 8")
    return scene | {"time": {"end": 3600.0, "tolerance": 1e-3}}


@pytest.mark.parametrize(
    ("scene", "falls"),
    [
        pytest.param(cores(60.0), -5e-4, id="cores-at-rest"),
        pytest.param(fast_cores(), -1e-3, id="fast-cores"),
        pytest.param(in_series(), -1e-3, id="in-series"),
        pytest.param(moving(), -5e-3, id="moving-cores"),
    ],
)
def test_no_amount_falls_below_zero(monkeypatch, scene, falls):
    assert unbounded(monkeypatch, scene) < falls
    assert least_of(scene) > -LEFT
    result = contbed.run(from_dict(scene))
    assert 0 < result.qoi["cells_damped"] <= result.qoi["cells"]
    assert 0 < result.qoi["steps_damped"] <= result.qoi["time_steps"]
    assert not any("below zero" in text for text in result.warnings)
    assert_closed(result, CLOSED)
    for name, column in result.profiles.items():
        if name.startswith(("x_", "w_")):
            assert np.all((column > -LEFT) & (column < 1.0 + LEFT)), name


def constant_rate(tau):
    """A rate of first order in the gas that knows nothing of the solid, over two
    transfer units.
    """
    scene = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, tau)
    scene["reactions"]["r"] |= {
        "orders": {"A": 1.0},
        "A": scene["reactions"]["r"]["A"] * N_SOLID,
    }
    set_keys(scene, "mesh.cells = 20")
    return scene


def test_a_rate_ends_with_the_solid():
    """Behind a front at xi = tau - 1 nothing is left; before it
    y = exp(-(xi - tau + 1)), S = 1 - y.

    Where the rate goes on the solid falls to -0.5. At the end the last stage takes what
    is left of some nodes: the gas errs by up to 1.5e-4 on other cells and at other
    times, what has reacted by rounding.
    """
    scene = constant_rate(1.5)
    assert least_of(scene) > -LEFT
    result = contbed.run(from_dict(scene))
    assert result.qoi["steps_limited"] > 0
    assert result.profiles["x_A [1]"][-1] == approx(np.exp(-1.5), abs=1e-3)
    assert result.profiles["w_P [1]"][-1] == approx(np.exp(-1.5), abs=1e-10)
    assert_closed(result, CLOSED)


def test_nothing_changes_where_nothing_falls_below_zero(monkeypatch):
    scene = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 0.8)
    set_keys(scene, 'gas.composition = "A:0.9, B:0.1"')
    one = contbed.run(from_dict(scene))
    assert (
        one.qoi["cells_damped"],
        one.qoi["steps_damped"],
        one.qoi["steps_limited"],
    ) == (0, 0, 0)
    monkeypatch.setattr(module, "lowest", lambda problem, u: np.zeros(u.shape[:2]))
    other = contbed.run(from_dict(scene))
    for name, column in one.tables["outlet"].items():
        assert np.array_equal(column, other.tables["outlet"][name]), name
    for name, column in one.profiles.items():
        assert np.array_equal(column, other.profiles[name]), name


@pytest.mark.parametrize("bounds", [False, True], ids=["free", "damped"])
def test_order_two_in_time_with_damping(bounds):
    """Steps of one length with and without a damping that is constant: 4 for order
    2.
    """
    scene = in_series() | {"initial": {"gas": {"composition": "A:1"}}}
    set_keys(scene, 'packed_bed.gas_storage = "stored"')
    course = course_of(scene)
    problem = course.problem
    if bounds:
        problem = replace(problem, damping=np.full((3, 6), 0.3))
    found = []
    for steps in (20, 40, 80):
        u = course.start()
        for _ in range(steps):
            _, u, _ = stages(
                (problem, problem), u, u, 0.2 / steps, Report(), course.sizes(u)
            )
        found.append(u / problem.sizes[:, None, None])
    coarse, middle, fine = found
    ratio = np.abs(coarse - middle).max() / np.abs(middle - fine).max()
    assert 3.7 < ratio < 4.5


def test_damping_of_a_step_is_that_of_what_it_stores():
    """In long steps that of what is carried, in short ones of what a stage stores,
    h/(gamma dt) of solids that move.
    """
    problem = course_of(moving()).problem
    carries, stores = (module.flattening(problem, dt) for dt in (1e12, 1e-6))
    names = list(problem.names)
    gas, solid = (
        [names.index(name) for name in ("g_A", "g_B")],
        [names.index(name) for name in ("n_S", "n_P")],
    )
    v = abs(problem.bed.velocity_solid)
    assert_allclose(carries[gas], 1.0, rtol=1e-12)
    assert_allclose(carries[solid], v, rtol=1e-6)
    assert_allclose(stores[gas], 1.0, rtol=1e-12)
    assert_allclose(
        stores[solid], v + problem.line.h / (GAMMA * 1e-6) * np.ones((2, 1)), rtol=1e-12
    )


CHAIN = [
    SimpleNamespace(stoichiometry=s)
    for s in ({"X": -1.0, "Y": 2.0, "g": -1.0}, {"Y": -1.0, "Z": 1.0})
]


def test_rates_take_no_more_than_there_is():
    """X -> 2 Y -> Z: Y lives of X, and what X keeps Y does not gain; a reaction that
    runs back takes of Z.
    """
    first, second = np.array([3.0, 3.0, 0.5, 1.0]), np.array([5.0, 5.0, 0.5, -2.0])
    most = {
        "Y": np.zeros(4),
        "Z": np.full(4, 0.5),
        "X": np.array([np.inf, 1.0, 1.0, np.inf]),
    }
    (one,), (two,) = within([[first], [second]], CHAIN, most)
    assert_allclose(one, [3.0, 1.0, 0.5, 1.0], rtol=1e-14)
    assert_allclose(two, [5.0, 2.0, 0.5, -0.5], rtol=1e-14)
    for name, limit in most.items():
        lost = -sum(
            r.stoichiometry.get(name, 0.0) * rate
            for r, rate in zip(CHAIN, (one, two), strict=True)
        )
        assert np.all(lost <= limit + 1e-14), name


def test_derivatives_of_limited_rates():
    """Against differences of steps of 1e-6, to their error."""
    most = {"Y": np.array([0.3])}

    def rates(a, b):
        return [part[0] for part in within([[a * a], [b * 3.0]], CHAIN, most)]

    a, b, step = np.array([1.1]), np.array([2.0]), 1e-6
    exact = rates(Dual(a, {"a": np.ones(1)}), Dual(b, {"b": np.ones(1)}))
    for slot, up, down in (
        ("a", (a + step, b), (a - step, b)),
        ("b", (a, b + step), (a, b - step)),
    ):
        for rate, more, less in zip(exact, rates(*up), rates(*down), strict=True):
            assert rate.tangents.get(slot, np.zeros(1)) == approx(
                (more - less) / (2.0 * step), abs=1e-8
            )


def test_what_is_shown_between_nodes_holds_as_much():
    """Solids at rest of a front in one cell: nothing below zero between nodes, and
    the same in the cell.
    """
    problem = course_of(cores(1.0)).problem
    u = problem.start()
    k, made = problem.names.index("n_S"), problem.names.index("n_P")
    u[k, 3] *= np.array([0.0, 0.0, 0.1, 1.0])
    u[made, 3] = u[k, 2] - u[k, 3]
    shown, xi = between_nodes(problem, u), np.linspace(0.0, 1.0, 999)
    assert (u[k, 3] @ problem.line.basis(xi).T).min() < -0.05 * problem.sizes[k]
    assert (
        shown[[k, made], 3] @ problem.line.basis(xi).T
    ).min() >= -1e-12 * problem.sizes[k]
    assert_allclose(shown @ problem.line.weights, u @ problem.line.weights, rtol=1e-14)
    assert_allclose(shown[k] + shown[made], u[k] + u[made], rtol=1e-14)
    assert np.array_equal(np.delete(shown, 3, axis=1), np.delete(u, 3, axis=1))


def test_gas_to_the_left_is_damped_as_to_the_right():
    """Mirrored fields to rounding of Newton's method, whose tolerance is 1e-10, at
    the steps of both.
    """
    right, left = cores(60.0), cores(60.0)
    # of cells: at a vertex it is the value on its left
    inside = 0.1 * (np.arange(8) + 0.5) / 8
    right["output"] = left["output"] = {"positions": inside.tolist(), "plots": False}
    left["boundary"] = {"right": left["boundary"]["left"]}
    one, other = contbed.run(from_dict(right)), contbed.run(from_dict(left))
    assert one.qoi["steps_damped"] > 10
    for name in ("x_A [1]", "x_B [1]", "w_S [1]"):
        assert_allclose(other.profiles[name][::-1], one.profiles[name], atol=1e-7)


def test_damping_of_short_steps_leaves_no_solid_in_the_cell_where_it_enters():
    """A counter-current bed from its start to its steady state: P ends at 0.5 mol/m3 of
    it, 3e-5 of all solids.

    With the damping of the first steps, of 0.6 s, cells become flat, and 45 mol/m3 stay
    where no P enters.
    """
    scene = let_move(isothermal("A:1", species(A=0.028, B=0.028)), -1e-4)
    scene["solids"]["particles"] |= solids()
    set_keys(
        scene,
        """
        mesh.cells = 10
        reactions = { r = { equation = "A + S -> B + P", A = 1e-5, E = 0.0, basis = "bed" } }
        reactions.r.orders = { A = 1.0, S = 1.0 }
        """,
    )
    steady = contbed.run(from_dict(scene))
    set_keys(scene, "time = { end = 6e4 }")
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    found = contbed.run(from_dict(scene))
    assert found.qoi["steps_damped"] > 0
    key = "n_P [mol/m3]"
    assert found.profiles[key] == approx(steady.profiles[key], abs=2.0)
