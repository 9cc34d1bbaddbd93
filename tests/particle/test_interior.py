"""The inside of a particle by polynomials: exact modes, uptake, conservation."""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx

from contbed.particle.interior import interior

# lowest roots: tan x = x; J_1; pi: modes of a sphere, cylinder, slab without flux over
# the surface
FIRST = {"sphere": 4.493409457909064, "cylinder": 3.831705970207512, "slab": np.pi}


@pytest.mark.parametrize("shape", FIRST)
@pytest.mark.parametrize(("points", "error"), [(3, 2e-3), (6, 1e-8), (12, 1e-11)])
def test_slowest_mode(shape, points, error):
    rates, _ = interior(points, shape).modes()
    assert np.sqrt(rates[1]) == approx(FIRST[shape], rel=error)


@pytest.mark.parametrize("shape", FIRST)
def test_mean_changes_by_the_flux_alone(shape):
    inside = interior(5, shape)
    assert inside.weights.sum() == approx(1.0, rel=1e-14) and np.all(inside.weights > 0)
    assert (
        np.abs(inside.stiffness.sum(axis=0)).max()
        < 1e-13 * np.abs(inside.stiffness).max()
    )
    assert inside.stiffness == approx(inside.stiffness.T)


@pytest.mark.parametrize("shape", FIRST)
def test_even_polynomials_are_exact(shape):
    inside = interior(4, shape)
    s, r = inside.surface, inside.radii
    # laplacian of r^4 is 4 (s + 2) r^2; its flux at the surface is 4
    tested = -inside.stiffness @ r**4
    tested[-1] += s * 4.0
    assert tested == approx(inside.weights * 4 * (s + 2) * r**2, abs=1e-12)
    assert inside.weights @ r**4 == approx(s / (s + 4.0), rel=1e-13)  # mean


@pytest.mark.parametrize(
    ("points", "error"), [(2, 2e-2), (3, 2e-3), (4, 1e-4), (6, 1e-7)]
)
def test_uptake_of_a_sphere_in_a_periodic_gas(points, error):
    # exact share of the film that the uptake has: phi/(Bi + phi), phi = sqrt(p) coth
    # sqrt(p) - 1, p = i omega R^2/alpha
    inside, Bi, p = interior(points), 10.0, 20j
    matrix = p * np.diag(inside.weights) + inside.stiffness
    matrix[-1, -1] += 3.0 * Bi
    rhs = np.zeros(points + 1)
    rhs[-1] = 3.0 * Bi
    flux = 1.0 - np.linalg.solve(matrix, rhs)[-1]
    phi = np.sqrt(p) / np.tanh(np.sqrt(p)) - 1.0
    assert abs(flux / (phi / (Bi + phi)) - 1.0) < error


@pytest.mark.parametrize(("points", "shape"), [(1, "sphere"), (3, "cube")])
def test_what_is_not_offered(points, shape):
    with pytest.raises(ValueError, match=r"inside of a particle|shape"):
        interior(points, shape)
