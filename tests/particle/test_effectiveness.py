"""Effectiveness of particles against exact values, limits and derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from contbed.fem.ad.dual import Dual
from contbed.particle import effectiveness, nonisothermal
from tests.particle.tables import rows


@pytest.mark.parametrize("row", rows("thiele_sphere.csv"))
def test_sphere_with_film(row):
    eta = effectiveness.sphere(row["phi"])
    # the table has 12 digits
    assert eta == pytest.approx(row["eta"], rel=5e-12)
    assert effectiveness.overall(eta, row["phi"], row["Bi"]) == pytest.approx(
        row["eta_overall"], rel=5e-12
    )


@pytest.mark.parametrize("law", [effectiveness.sphere, effectiveness.slab])
def test_series_and_closed_form_meet(law):
    at = effectiveness.SERIES_UP_TO
    below, above = law(np.array([at * (1 - 1e-13), at * (1 + 1e-13)]))
    # the closed form of the sphere loses phi^2/3 of its digits there
    assert below == pytest.approx(above, rel=1e-13)


def test_no_diffusion_limit_and_strong_limit():
    assert effectiveness.sphere(0.0) == 1.0 and effectiveness.slab(0.0) == 1.0
    assert effectiveness.sphere(1e4) == pytest.approx(3.0 / 1e4 * (1 - 1e-4), rel=1e-14)
    assert effectiveness.slab(1e4) == pytest.approx(1e-4, rel=1e-14)
    # film alone: rate per volume 3 k_film/R c
    assert effectiveness.overall(
        effectiveness.sphere(1e6), 1e6, 2.0
    ) * 1e12 / 6.0 == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize("square", [-0.01, 0.0, 1e-3, 0.3, 25.0])
def test_effectiveness_of_a_rate_constant_and_its_slope(square):
    R, D = 2e-3, 4e-6
    k = Dual(np.array([square * D / R**2]), {"k": np.ones(1)})
    eta = effectiveness.effectiveness_of(R, k, D)
    if square > 0:
        assert eta.value[0] == pytest.approx(
            float(effectiveness.sphere(np.sqrt(square))), rel=1e-12
        )
    step = 1e-4 * D / R**2
    up, down = (
        effectiveness.effectiveness_of(R, k.value[0] + s, D) for s in (step, -step)
    )
    # central difference: error of order step^2 of an analytic function
    assert eta.tangents["k"][0] == pytest.approx(
        float(up - down) / (2 * step), rel=1e-6
    )


def test_thiele_modulus():
    assert effectiveness.thiele(2e-3, 9.0, 4e-6) == pytest.approx(3.0, rel=1e-14)
    assert effectiveness.thiele(2e-3, -1.0, 4e-6) == 0.0


@pytest.mark.parametrize(
    "row", [r for r in rows("nonisothermal_effectiveness.csv") if r["kind"] == "state"]
)
def test_states_with_heat_of_reaction(row):
    found = nonisothermal.states(row["phi"], row["g"], row["b"])
    closest = min(found, key=lambda state: abs(state.eta - row["eta"]))
    # 1e-10 is the tolerance stated for the table; an almost empty centre amplifies phi,
    # there 1e-7
    assert closest.eta == pytest.approx(row["eta"], rel=1e-10)
    assert closest.centre == pytest.approx(row["y_centre"], rel=1e-7)


@pytest.mark.parametrize(
    "row", [r for r in rows("nonisothermal_effectiveness.csv") if r["kind"] == "fold"]
)
def test_folds(row):
    phi, state = min(
        nonisothermal.folds(row["g"], row["b"]),
        key=lambda fold: abs(fold[0] - row["phi"]),
    )
    assert phi == pytest.approx(row["phi"], rel=1e-10)
    # at a fold eta is known to the root of the digits of phi: the table states 7
    assert state.eta == pytest.approx(row["eta"], rel=3e-7)


@pytest.mark.parametrize(("phi", "count"), [(0.29, 1), (0.3, 3), (0.57, 3), (0.58, 1)])
def test_number_of_states_changes_at_the_folds(phi, count):
    assert len(nonisothermal.states(phi, 20.0, 0.6)) == count


def test_without_heat_of_reaction_it_is_isothermal():
    (state,) = nonisothermal.states(3.0, 15.0, 0.0)
    assert state.eta == pytest.approx(float(effectiveness.sphere(3.0)), rel=1e-11)
    assert state.centre == pytest.approx(3.0 / np.sinh(3.0), rel=1e-10)


def test_state_against_collocation_in_r():
    phi, g, b = 1.3, 12.0, 0.25
    used = lambda y: b * (1.0 - y)  # noqa: E731
    rate = lambda y: phi**2 * y * np.exp(g * used(y) / (1.0 + used(y)))  # noqa: E731
    r = np.linspace(0.0, 1.0, 60)
    found = solve_bvp(
        lambda r, y: np.array([y[1], rate(y[0])]),
        lambda centre, surface: np.array([centre[1], surface[0] - 1.0]),
        r,
        np.array([np.full_like(r, 0.8), 0.2 * r]),
        S=np.diag([0.0, -2.0]),
        tol=1e-9,
        max_nodes=20000,
    )
    near = min(
        nonisothermal.states(phi, g, b), key=lambda s: abs(s.centre - found.y[0, 0])
    )
    # tolerance of the other method
    assert near.eta == pytest.approx(3.0 * found.y[1, -1] / phi**2, rel=1e-7)


@pytest.mark.parametrize(
    ("phi", "g", "b"), [(1.0, 20.0, -1.5), (0.0, 20.0, 0.1), (1.0, 1e4, 0.5)]
)
def test_numbers_that_no_particle_has(phi, g, b):
    with pytest.raises(ValueError, match=r"phi =|b ="):
        nonisothermal.states(phi, g, b)


def test_prater_temperature():
    assert nonisothermal.hottest(0.6, 0.0) == pytest.approx(1.6)
