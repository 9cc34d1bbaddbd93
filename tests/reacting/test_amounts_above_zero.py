"""Gases and solids that are used up at a point, or begin at zero: no amount is below
zero, and order and balances stay.

Without damping polynomials undershoot there, which each test sees first. With it
nothing is further below zero than 1e-10 of its size, to which Newton's method solves; a
fraction is at most one where no other is below zero.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from reacting_bed_scenes import (
    bilinear,
    danckwerts,
    isothermal,
    shrinking_core,
    species,
    table,
)
from solving import solved

import contbed
from contbed.fem.line_dg import Ends, Line, System
from contbed.loading import from_dict
from contbed.reacting_bed import positivity_in_time, solve
from contbed.reacting_bed.least_amounts import lowest
from tests.balances import assert_closed
from tests.scene_text import set_keys

LEFT = 1e-10  # below zero, of the size of an amount: what Newton's method leaves
CLOSED = 1e-12


def undamped(result):
    """The least amount of each field on the same cells without damping."""
    problem, u = result.solved
    bare = replace(problem, damping=None)
    with np.errstate(all="ignore"):
        return lowest(
            bare, solve.newton(bare, u, solve.Report(), max_iterations=60)
        ).min()


def assert_within_bounds(result):
    """Fractions of the state, of its profiles and of what leaves are in [0, 1];
    balances close.
    """
    assert lowest(*result.solved).min() >= -LEFT
    for name, column in result.profiles.items():
        if name.startswith(("x_", "w_")):
            assert np.all((column >= -LEFT) & (column <= 1.0 + LEFT)), name
    assert result.qoi["share_negative"] == 0.0
    assert not any("below zero" in text for text in result.warnings)
    assert_closed(result, CLOSED)


CORE = table("counter_current_shrinking_core")[1]


@pytest.mark.parametrize(
    ("scene", "least"),
    [
        pytest.param(
            shrinking_core(*(CORE[key] for key in ("N", "n", "f", "d", "r"))),
            -1e-5,
            id="shrinking-core",
        ),
        pytest.param(
            shrinking_core(50.0, 0.8, 0.3, 0.4, 0.3), -5e-5, id="long-shrinking-core"
        ),
        pytest.param(bilinear(50.0, 0.7), -1e-6, id="bilinear"),
        pytest.param(danckwerts(1e4, 100.0), -1e-7, id="dispersed"),
    ],
)
def test_what_is_used_up_stays_above_zero(scene, least):
    result = solved(scene)
    assert undamped(result) < least
    assert result.qoi["cells_damped"] > 0
    assert_within_bounds(result)


def test_a_core_that_is_used_up_is_as_exact_as_before():
    """The table is exact to 1e-10; without damping 2e-10 of the conversion is
    missing.
    """
    result = solved(shrinking_core(*(CORE[key] for key in ("N", "n", "f", "d", "r"))))
    gas = result.qoi["out_A_mol_m2s"] / (
        result.qoi["out_A_mol_m2s"] + result.qoi["out_B_mol_m2s"]
    )
    assert gas == pytest.approx(CORE["gas_out"], abs=1e-8)
    assert result.qoi["conversion_S"] == pytest.approx(CORE["X_out"], abs=1e-8)


def test_gas_from_the_right_is_damped_as_from_the_left():
    """Mirrored, to what Newton's method leaves; damping of the other sign steepens
    what it should flatten.
    """
    right, left = in_series(4, 8.0), in_series(4, 8.0)
    right["output"] = left["output"] = {
        "positions": [0.1, 0.3, 0.45, 0.55, 0.7, 0.9],
        "plots": False,
    }
    left["boundary"] = {"right": left["boundary"]["left"]}
    one, other = solved(right), solved(left)
    assert other.qoi["cells_damped"] == one.qoi["cells_damped"] > 0
    assert_within_bounds(other)
    for name in ("x_A [1]", "x_B [1]", "x_C [1]"):
        assert_allclose(other.profiles[name][::-1], one.profiles[name], atol=1e-9)


def in_series(cells: int, Da: float):
    """A -> B -> C of first order in plug flow: C = 1 - (1 + Da x/L) exp(-Da x/L) is
    zero where the gas enters.
    """
    scene = isothermal("A:1", species(A=0.028, B=0.028, C=0.028))
    k = Da * 0.5 / 0.4
    scene["reactions"] = {"first": {"equation": "A -> B", "A": k, "E": 0.0}}
    scene["reactions"]["second"] = {"equation": "B -> C", "A": k, "E": 0.0}
    scene["mesh"]["cells"] = cells
    return scene


def test_order_of_the_fields_stays():
    """Polynomials of degree 3 are of order 4 where C begins at zero and would
    undershoot.
    """
    errors = []
    for cells in (48, 96, 192):
        result = solved(in_series(cells, 8.0))
        problem, u = result.solved
        assert undamped(result) < -LEFT
        assert result.qoi["cells_damped"] >= 1
        assert_within_bounds(result)
        depth = 8.0 * problem.line.points
        errors.append(
            np.abs(
                problem.bed.state(list(u)).x["C"] - 1.0 + (1.0 + depth) * np.exp(-depth)
            ).max()
        )
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.8), (errors, orders)


def test_what_damping_changes_is_told():
    """Two cells cannot hold a layer of an eightieth of the bed."""
    result = solved(in_series(2, 80.0))
    assert_within_bounds(result)
    (text,) = result.warnings
    assert text.startswith(
        "amounts are damped in 2 cells where they would be negative, which changes "
        "what leaves by"
    )


def test_damping_takes_nothing_and_its_derivatives_are_exact():
    """Residuals of a cell sum to those without damping; the matrix is that of
    differences, to their rounding.
    """
    line = Line(np.array([0.0, 0.3, 1.0]), 3)

    class Point:
        def __call__(self, u, q, x):
            return self.convective(u), [0.0], [1.0 - u[0]]

        def convective(self, u):
            return [u[0]]

        def diffusive(self, u, q):
            return [0.0]

        def damped(self, u, J):
            return J

    ends = Ends(
        (np.ones(1),) * 2,
        (np.array([True]), np.array([False])),
        (np.full(1, np.nan),) * 2,
    )
    plain, damped = (
        System(line, [1], [False], Point(), ends, damping=d)
        for d in (None, np.array([[0.7, 5.0]]))
    )
    u, v = np.random.default_rng(3).uniform(0.0, 1.0, (2, 1, 2, 4))
    (bare, _), (residual, slopes) = plain.assemble(u), damped.assemble(u)
    assert np.abs(residual - bare).max() > 0.1
    assert_allclose(residual.sum(axis=2), bare.sum(axis=2), rtol=0.0, atol=1e-14)
    product = (slopes.matrix(np.ones(1)) @ v.ravel()).reshape(v.shape)
    difference = damped.assemble(u + v)[0] - residual  # of a linear system
    assert_allclose(product, difference, rtol=0.0, atol=1e-13)


def test_a_run_in_time_tells_how_far_and_where_an_amount_falls_below_zero(monkeypatch):
    """A step through cells that do not resolve it, at its start, if no bounds are
    found; at the end all is above.
    """
    monkeypatch.setattr(positivity_in_time, "TRIALS", 0)
    scene = danckwerts(20.0, 0.0)
    set_keys(scene, "time = { end = 1.6 }")
    set_keys(scene, 'initial.gas = { composition = "B:1" }')
    result = contbed.run(from_dict(scene))
    (text,) = (text for text in result.warnings if "below zero" in text)
    assert text.startswith("A falls to -0.00")
    assert " of the gas at x = 0.008333 m at t = " in text
    assert "than time.tolerance = 0.0001" in text
    assert result.qoi["share_negative"] == 0.0
