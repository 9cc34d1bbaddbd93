"""Shells inside of a sphere against Thiele's effectiveness."""

from __future__ import annotations

import numpy as np
import pytest

from contbed.particle.shells import shells
from tests.particle.tables import sphere


@pytest.mark.parametrize(
    ("phi", "tolerance"), [(1.0, 1e-8), (10.0, 1e-5), (100.0, 1e-4), (1000.0, 4e-4)]
)
def test_first_order(phi, tolerance):
    points = shells()
    matrix = points.stiffness + phi**2 * np.diag(points.weights)
    c = np.append(np.linalg.solve(matrix[:-1, :-1], -matrix[:-1, -1]), 1.0)
    assert points.weights @ c == pytest.approx(sphere(phi), rel=tolerance)


def test_matrices():
    points = shells()
    assert np.all(points.weights[1:] > 0.0)
    np.testing.assert_allclose(
        points.stiffness, points.stiffness.T, rtol=1e-12, atol=1e-10
    )
    # a parabola: the flux through the surface is what its laplacian of 6 makes, 3 K r^2
    # = flux at the surface
    flow = points.stiffness @ points.radii**2
    np.testing.assert_allclose(flow[:-1], -6.0 * points.weights[:-1], atol=1e-9)
    assert flow.sum() == pytest.approx(0.0, abs=1e-9)
