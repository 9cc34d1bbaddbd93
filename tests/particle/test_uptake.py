"""Exact breakthroughs and moving beds of particles with an inside, and of the
cheaper levels, by Laplace transforms.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from pytest import approx
from scipy.special import jn_zeros

from contbed.particle import uptake
from contbed.particle.interior import interior
from studies._exact.packed_bed import schumann
from tests.particle.tables import rows


@pytest.mark.parametrize("row", rows("breakthrough_spheres.csv"))
def test_breakthrough_of_the_table(row):
    eta = np.array([row["eta"]])
    # Talbot's contour with 32 nodes; the table has 12 digits
    exact = uptake.breakthrough(row["xi"], eta, row["Bi"])[0]
    assert exact == approx(row["theta_gas"], abs=1e-9)
    corrected = uptake.breakthrough(row["xi"], eta, row["Bi"], "effective")[0]
    assert corrected - exact == approx(row["ldf_error"], abs=1e-9)


@pytest.mark.parametrize("row", rows("moving_bed_spheres.csv"))
def test_moving_bed_of_the_table(row):
    exact = uptake.moving_bed(row["Gamma"], row["Bi"], row["Fo"])
    assert exact == approx(row["gas_out"], abs=1e-10)
    corrected = uptake.moving_bed(row["Gamma"], row["Bi"], row["Fo"], "effective")
    assert corrected - exact == approx(row["ldf_error_gas"], abs=1e-10)


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "slab"])
def test_uptake_is_that_of_the_resolved_inside(shape):
    inside, biot, p = interior(12, shape), 3.0, 5.0 + 8.0j
    matrix = p * np.diag(inside.weights) + inside.stiffness
    matrix[-1, -1] += inside.surface * biot
    rhs = np.zeros(13)
    rhs[-1] = inside.surface * biot
    # spectral accuracy
    assert (
        abs(
            1.0
            - np.linalg.solve(matrix, rhs)[-1]
            - uptake.uptake(p, biot, "interior", shape)
        )
        < 1e-12
    )


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "slab"])
def test_levels_agree_where_the_particle_follows_slowly(shape):
    # the corrected film is exact to first order in p, the film alone is not
    exact, effective, lumped = (
        uptake.uptake(1e-4, 5.0, level, shape)
        for level in ("interior", "effective", "lumped")
    )
    assert abs(effective / exact - 1) < 1e-8 and abs(lumped / exact - 1) > 1e-6


def test_inversion_of_a_known_transform():
    t = np.array([0.1, 1.0, 7.0])
    assert uptake.invert(lambda p: 1.0 / (p + 1.0) ** 2, t) == approx(
        t * np.exp(-t), abs=1e-10
    )


def test_cylinder_cools_with_the_zeros_of_bessel_functions():
    # mean of a cylinder after its surface jumps: 1 - sum 4/z^2 exp(-z^2 Fo)
    z = jn_zeros(0, 60)
    fourier = np.array([0.02, 0.2])
    mean = uptake.invert(
        lambda p: (
            2.0 * uptake._potential(np.sqrt(p.astype(complex)), "cylinder") / p**2
        ),
        fourier,
    )
    assert mean == approx(
        1.0 - np.exp(-np.outer(fourier, z**2)) @ (4.0 / z**2), abs=1e-9
    )


def test_errors_of_levels_fall_with_the_biot_number():
    errors = [
        uptake.breakthrough_error(20.0, biot, "effective") for biot in (0.1, 1.0, 10.0)
    ]
    # 5.3e-6, 4.2e-4 of the table's comparison of levels; 1.38e-2 is what the bed of
    # studies/adsorber shows in a run
    assert errors == approx([5.3e-6, 4.2e-4, 1.38e-2], rel=0.1)
    assert uptake.breakthrough_error(20.0, 1.0, "lumped") > 20 * errors[1]
    assert uptake.moving_bed_error(-0.8, 1.0, 1.0, "effective") == approx(
        4.62e-4 / 0.8, rel=0.01
    )
    # the solids' error is the gas's over Gamma, the balance of heat
    assert uptake.moving_bed_error(-0.5, 1.0, 1.0, "effective") == approx(
        2
        * abs(
            uptake.moving_bed(-0.5, 1.0, 1.0, "effective")
            - uptake.moving_bed(-0.5, 1.0, 1.0)
        ),
        rel=1e-12,
    )


def test_slow_pores_do_not_shorten_the_bed_that_is_compared():
    """At Bi = 4000 the outlets of a run with a linear driving force and of one with 5
    points inside differ by 0.030: the rest is what cells and steps of both add.
    """
    error = uptake.breakthrough_error(5760.0, 4000.0, "effective")
    assert error == approx(0.030, abs=0.005)
    # beyond all films the inside decides alone
    assert uptake.breakthrough_error(2 * 5760.0, 8000.0, "effective") == approx(
        error, rel=1e-2
    )


def test_a_short_bed_errs_most_when_the_gas_arrives():
    # the film alone and an inside let exp(-xi) through at once, the corrected film
    # exp(-xi/c)
    expected = np.exp(-1.0 / 1.2) - np.exp(-1.0)
    assert uptake.breakthrough_error(1.0, 1.0, "effective") == approx(
        expected, rel=1e-12
    )
    assert uptake.breakthrough_error(1.0, 1.0, "effective", last=1e-6) == approx(
        expected, rel=1e-12
    )
    assert uptake.breakthrough_error(1.0, 1.0, "lumped", last=1e-6) == 0.0


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "slab"])
def test_points_inside_approach_the_exact_uptake(shape):
    p, biot = 5.0 + 8.0j, 3.0
    inside = interior(3, shape)
    matrix = p * np.diag(inside.weights) + inside.stiffness
    matrix[-1, -1] += inside.surface * biot
    rhs = np.zeros(4)
    rhs[-1] = inside.surface * biot
    # the modes of three points are the matrices of three points
    assert (
        abs(1.0 - np.linalg.solve(matrix, rhs)[-1] - uptake.uptake(p, biot, 3, shape))
        < 1e-13
    )
    errors = [
        abs(
            uptake.uptake(p, biot, n, shape) - uptake.uptake(p, biot, "interior", shape)
        )
        for n in (2, 3, 4, 6)
    ]
    assert all(after < 0.1 * before for before, after in pairwise(errors))


@pytest.mark.parametrize(
    ("gamma", "biot", "fourier"), [(-1.5, 10.0, 3.0), (-3.0, 1.0, 4.0)]
)
def test_a_long_moving_bed_with_heavy_solids_leaves_the_gas_at_their_temperature(
    gamma, biot, fourier
):
    # one temperature: theta = (1 - m)/(exp(N (1 - m)) - m) with N transfer units and m
    # = |Gamma|, of a heat exchanger
    m, units = -gamma, 3.0 * -gamma * biot * fourier
    exact = (
        (m - 1.0) / (m * np.exp(units * (m - 1.0) / m) - 1.0)
        if m != 1.0
        else 1.0 / (1.0 + units)
    )
    found = uptake.moving_bed(gamma, biot, fourier, "lumped")
    assert found == approx(exact, rel=1e-6)
    assert 0.0 <= uptake.moving_bed(gamma, biot, fourier) < 1e-3


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "slab"])
@pytest.mark.parametrize("gamma", [-1.0 - 1e-12, -1.0 - 1e-8, -1.5, -1e3])
@pytest.mark.parametrize("biot", [1e-6, 1e-3, 1e3])
def test_gas_against_particles_leaves_between_what_enters(gamma, biot, shape):
    """With particles that all but follow the gas, and with flows of heat that are
    all but equal.
    """
    for fourier in (1e-3, 1.0, 1e4):
        for level in ("lumped", "effective", "interior", 3):
            # Talbot's contour is exact to 1e-9
            assert (
                -1e-9
                <= uptake.moving_bed(gamma, biot, fourier, level, shape)
                <= 1.0 + 1e-9
            )


def test_uptake_of_a_sphere_at_small_p():
    """H = p/(3 Bi + p) - ..., to first order p/(3 Bi); the difference of all but
    equal numbers lost all digits.
    """
    for p in (1e-14, 1e-10):
        # of the next order is 1 + 5/Bi times p/15
        assert complex(uptake.uptake(p, 2.0)).real == approx(p / 6.0, rel=1e-9, abs=0.0)
    # on both sides of where the series begins
    below, above = (
        complex(uptake.uptake(uptake.SMALL * (1.0 + k), 2.0)).real
        for k in (-1e-9, 1e-9)
    )
    assert (above - below) / below == approx(2e-9, rel=1e-2)


def test_gas_in_a_steady_bed_misses_by_the_coefficient():
    x = np.linspace(0.0, 30.0, 300001)
    c = uptake.correction(4.0)
    # a grid of 1e-4 transfer units
    assert uptake.steady_error(50.0, 4.0, "lumped") == approx(
        (np.exp(-x / c) - np.exp(-x)).max(), rel=1e-8
    )
    assert uptake.steady_error(0.1, 4.0, "lumped") == approx(
        np.exp(-0.1 / c) - np.exp(-0.1), rel=1e-12
    )
    assert uptake.steady_error(50.0, 4.0, "effective") == 0.0


@pytest.mark.parametrize("xi", [0.01, 1.0, 50.0, uptake.MOST_UNITS])
def test_breakthrough_of_particles_of_one_temperature_is_that_of_schumann(xi):
    eta = np.linspace(0.2, 2.0, 10) * xi
    exact = schumann(xi, xi + eta, 1.0, 1.0, 1.0)[0]
    # rounding on the contour grows with the length of the bed
    np.testing.assert_allclose(
        uptake.breakthrough(xi, eta, 1.0, "lumped"), exact, rtol=0, atol=3e-7
    )


def test_a_bed_too_long_for_the_contour_is_refused():
    with pytest.raises(ValueError, match=r"100 transfer units; .* up to 80"):
        uptake.breakthrough(100.0, np.array([100.0]), 1.0, "lumped")
