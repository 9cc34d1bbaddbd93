"""Points inside of particles fall below zero before a front reaches them; what that
costs, and what a limiter would.

A polynomial through a few points inside undershoots ahead of a steep front. What the
particle holds does not, and is of the order of the polynomials. Points moved towards
their mean until none is below zero, as Zhang and Shu do between cells, hold as much,
but take up more than they should.
"""

from __future__ import annotations

import numpy as np
import pytest
from adsorption_scenes import adsorber
from scipy.linalg import expm
from solving import marched

from contbed.loading import from_dict
from contbed.models import plan
from contbed.particle.interior import interior
from contbed.particle.level import SHAPES
from contbed.reacting_bed.course import Course
from tests.scene_text import set_keys

TIMES = np.geomspace(1e-5, 1.0, 400)  # Fourier numbers
EXACT = 20  # points


def uptake(count, biot, limits=False):
    """Concentrations at the points of a sphere after a step around it (times,
    points), exact in time, and the mean.
    """
    points = interior(count, SHAPES["spheres"])
    w, film = np.array(points.weights), np.zeros(count + 1)
    film[-1] = points.surface * biot
    A = -(np.array(points.stiffness) + np.diag(film)) / w[:, None]
    c, before, found = np.zeros(len(w)), 0.0, []
    for t in TIMES:
        c, before = 1.0 + expm(A * (t - before)) @ (c - 1.0), t
        if limits and c.min() < 0.0:
            mean = c @ w
            c = mean + mean / (mean - c.min()) * (c - mean)
        found.append(c)
    return np.array(found), np.array(found) @ w


@pytest.mark.parametrize(
    ("biot", "count", "low", "error"),
    [
        (0.5, 3, 3.4e-4, 1e-5),
        (3.0, 3, 1.8e-3, 3e-4),
        (3.0, 6, 5.1e-4, 1.3e-5),
        (10.0, 3, 4.4e-3, 2.1e-3),
    ],
)
def test_undershoots_cost_less_than_a_limiter(biot, count, low, error):
    """To the two digits that `equations.inside` tells."""
    c, held = uptake(count, biot)
    _, exact = uptake(EXACT, biot)
    assert -c.min() == pytest.approx(low, rel=0.05)
    assert TIMES[c.min(axis=1) < -1e-6].max() < 0.025
    assert held.min() > 0.0
    missed = np.abs(held - exact).max()
    assert missed < error
    assert np.abs(uptake(count, biot, limits=True)[1] - exact).max() > 1.1 * missed


def test_particles_of_a_bed_hold_nothing_below_zero():
    scene, unit = adsorber(100.0, 10.0, 3.0)
    set_keys(scene, "mesh.cells = 6")
    set_keys(scene, 'solids.particles.inside = { adsorption = "interior" }')
    scene["time"] |= {"end": 4.0 * unit, "tolerance": 1e-3}
    found = plan(from_dict(scene))
    course = Course.of(found.scene, found.problem, found.schedule, found.stores_gas)
    problem = course.problem
    rows = [k for k, name in enumerate(problem.names) if name.startswith("a_")]
    weights = np.array(problem.bed.phases["particles"].inside.weights)
    lowest, least = 0.0, 0.0
    for after in marched(course):
        points = after.state[rows] / problem.sizes[rows][:, None, None]
        lowest, least = (
            min(lowest, points.min()),
            min(least, np.tensordot(weights, points, axes=1).min()),
        )
    assert -3e-3 < lowest < -1e-3  # of Bi = 3
    assert least > -1e-9  # what Newton's method leaves below zero in the gas
