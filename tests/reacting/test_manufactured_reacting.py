"""Manufactured solutions of a reacting bed with all of its terms: order in space and
in time.
"""

from __future__ import annotations

import numpy as np
import pytest
from manufactured_bed import at, exact, problem_of

from contbed.reacting_bed.solve import Report, newton
from contbed.reacting_bed.stages import GAMMA, stages


def error_in_space(cells, degree):
    """Root mean square of the error of each field over its size."""
    problem = at(problem_of(-2e-3, cells, degree), 0.4)
    start = exact(problem, 0.4)
    found = newton(problem, start * 1.001, Report())
    sizes = np.abs(start).max(axis=(1, 2))
    line = problem.line
    return (
        np.sqrt(np.einsum("ecj,j,c->e", (found - start) ** 2, line.weights, line.h))
        / sizes
    )


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_order_in_space(degree):
    """Polynomials of degree p: order p + 1 of all fields; 0.28 below it is found for
    p = 1, 0.2 and less above.
    """
    coarse, fine = error_in_space(8, degree), error_in_space(16, degree)
    order = np.log2(coarse / fine)
    assert np.all(order > degree + 0.7), order
    assert fine.max() < {1: 5e-4, 2: 4e-6, 3: 2e-8}[degree]  # three times what is found


def error_in_time(problem, steps, end=0.6):
    u, dt = exact(problem, 0.0), end / steps
    for k in range(steps):
        pair = at(problem, (k + GAMMA) * dt, True), at(problem, (k + 1) * dt, True)
        _, u, _ = stages(pair, u, u, dt, Report(), problem.sizes)
    last = exact(problem, end)
    return np.abs(u - last).max(axis=(1, 2)) / np.abs(last).max(axis=(1, 2))


def test_order_in_time():
    """All fields are stored, the streams that enter change: order 2; 1.81 to 2.03
    are found.
    """
    problem = problem_of(-2e-3, 3, 5, True)
    coarse, fine = error_in_time(problem, 20), error_in_time(problem, 40)
    order = np.log2(coarse / fine)
    assert np.all((order > 1.75) & (order < 2.2)), order
    assert fine.max() < 4e-5  # three times what is found
