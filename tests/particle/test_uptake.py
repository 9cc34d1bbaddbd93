"""Exact breakthroughs and moving beds of particles with an inside, and of the cheaper levels, by Laplace transforms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import jn_zeros

from contbed.particle import uptake
from contbed.particle.interior import interior
from tests.particle.tables import rows


@pytest.mark.parametrize("row", rows("breakthrough_spheres.csv"))
def test_breakthrough_of_the_table(row):
    eta = np.array([row["eta"]])
    # Talbot's contour with 32 nodes; the table has 12 digits
    exact = uptake.breakthrough(row["xi"], eta, row["Bi"])[0]
    assert exact == pytest.approx(row["theta_gas"], abs=1e-9)
    corrected = uptake.breakthrough(row["xi"], eta, row["Bi"], "effective")[0]
    assert corrected - exact == pytest.approx(row["ldf_error"], abs=1e-9)


@pytest.mark.parametrize("row", rows("moving_bed_spheres.csv"))
def test_moving_bed_of_the_table(row):
    exact = uptake.moving_bed(row["Gamma"], row["Bi"], row["Fo"])
    assert exact == pytest.approx(row["gas_out"], abs=1e-10)
    corrected = uptake.moving_bed(row["Gamma"], row["Bi"], row["Fo"], "effective")
    assert corrected - exact == pytest.approx(row["ldf_error_gas"], abs=1e-10)


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "slab"])
def test_uptake_is_that_of_the_resolved_inside(shape):
    inside, biot, p = interior(12, shape), 3.0, 5.0 + 8.0j
    matrix = p * np.diag(inside.weights) + inside.stiffness
    matrix[-1, -1] += inside.surface * biot
    rhs = np.zeros(13)
    rhs[-1] = inside.surface * biot
    # spectral accuracy
    assert abs(1.0 - np.linalg.solve(matrix, rhs)[-1] - uptake.uptake(p, biot, "interior", shape)) < 1e-12


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "slab"])
def test_levels_agree_where_the_particle_follows_slowly(shape):
    # the corrected film is exact to first order in p, the film alone is not
    exact, effective, lumped = (uptake.uptake(1e-4, 5.0, level, shape) for level in ("interior", "effective", "lumped"))
    assert abs(effective / exact - 1) < 1e-8 and abs(lumped / exact - 1) > 1e-6


def test_inversion_of_a_known_transform():
    t = np.array([0.1, 1.0, 7.0])
    assert uptake.invert(lambda p: 1.0 / (p + 1.0) ** 2, t) == pytest.approx(t * np.exp(-t), abs=1e-10)


def test_cylinder_cools_with_the_zeros_of_bessel_functions():
    # mean of a cylinder after its surface jumps: 1 - sum 4/z^2 exp(-z^2 Fo)
    z = jn_zeros(0, 60)
    fourier = np.array([0.02, 0.2])
    mean = uptake.invert(lambda p: 2.0 * uptake._potential(np.sqrt(p.astype(complex)), "cylinder") / p**2, fourier)
    assert mean == pytest.approx(1.0 - np.exp(-np.outer(fourier, z**2)) @ (4.0 / z**2), abs=1e-9)


def test_errors_of_levels_fall_with_the_biot_number():
    errors = [uptake.breakthrough_error(20.0, biot, "effective") for biot in (0.1, 1.0, 10.0)]
    # 5.3e-6, 4.2e-4, 1.1e-2 of the table's comparison of levels
    assert errors == pytest.approx([5.3e-6, 4.2e-4, 1.1e-2], rel=0.1)
    assert uptake.breakthrough_error(20.0, 1.0, "lumped") > 20 * errors[1]
    assert uptake.moving_bed_error(-0.8, 1.0, 1.0, "effective") == pytest.approx(4.6e-4, rel=0.01)
