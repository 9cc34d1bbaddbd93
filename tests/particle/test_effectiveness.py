"""Effectiveness of particles against exact values, limits and derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx

from contbed.chemistry import effectiveness
from contbed.fem.ad.dual import Dual
from tests.particle.tables import overall, rows, sphere


@pytest.mark.parametrize("row", rows("thiele_sphere.csv"))
def test_sphere_with_film(row):
    eta = sphere(row["phi"])
    # the table has 12 digits
    assert eta == approx(row["eta"], rel=5e-12)
    assert overall(eta, row["phi"], row["Bi"]) == approx(row["eta_overall"], rel=5e-12)


def test_series_and_closed_form_meet():
    at = effectiveness.SERIES_UP_TO
    below, above = sphere(np.array([at * (1 - 1e-13), at * (1 + 1e-13)]))
    # the closed form of the sphere loses phi^2/3 of its digits there
    assert below == approx(above, rel=1e-13)


def test_no_diffusion_limit_and_strong_limit():
    assert sphere(0.0) == 1.0
    assert sphere(1e4) == approx(3.0 / 1e4 * (1 - 1e-4), rel=1e-14)
    # film alone: rate per volume 3 k_film/R c
    assert overall(sphere(1e6), 1e6, 2.0) * 1e12 / 6.0 == approx(1.0, rel=1e-5)


@pytest.mark.parametrize("square", [-0.01, 0.0, 1e-3, 0.3, 25.0])
def test_effectiveness_of_a_rate_constant_and_its_slope(square):
    R, D = 2e-3, 4e-6
    k = Dual(np.array([square * D / R**2]), {"k": np.ones(1)})
    eta = effectiveness.effectiveness_of(R, k, D)
    if square > 0:
        assert eta.value[0] == approx(float(sphere(np.sqrt(square))), rel=1e-12)
    step = 1e-4 * D / R**2
    up, down = (
        effectiveness.effectiveness_of(R, k.value[0] + s, D) for s in (step, -step)
    )
    # central difference: error of order step^2 of an analytic function
    assert eta.tangents["k"][0] == approx(float(up - down) / (2 * step), rel=1e-6)
