"""Fronts that cells do not resolve: temperatures that swing are a warning, and what
particles hold is shown as they hold it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from adsorption_scenes import DENSITY, EPS, adsorber
from reacting_bed_scenes import T, heated
from solving import course_of

import contbed
from contbed.loading import from_dict
from contbed.models import plan
from contbed.reacting_bed.results import loadings
from contbed.reacting_bed.swings import largest_swing, unresolved_front

MIDDLE = 0.5


def bed(cells):
    scene, _ = heated(10.0)
    scene["mesh"]["cells"] = cells
    return plan(from_dict(scene | {"time": {"end": 1.0}})).problem


def with_temperature(problem, of):
    """A state whose temperatures are polynomials of the position in a cell (N,)."""
    u = problem.start()
    xi = np.broadcast_to(problem.line.nodes, problem.line.points.shape)
    for k, each in enumerate(problem.unknowns):
        if each.is_temperature:
            u[k] = of(xi, np.arange(problem.line.cells)[:, None])
    return u


def test_a_swing_is_what_a_polynomial_has_beyond_its_neighbours():
    """300 K, a cell with 300 + 40 (xi - 1/2) K, 300 K: 20 K beyond all means, with jumps
    of 20 K.
    """
    problem = bed(3)
    u = with_temperature(
        problem, lambda xi, cell: 300.0 + (cell == 1) * 40.0 * (xi - MIDDLE)
    )
    found = largest_swing(problem, u, 5.0)
    assert found.size == pytest.approx(20.0, rel=1e-10)
    assert (found.x, found.time) == (pytest.approx(0.1), 5.0)
    assert (
        "swing by 20 K at x = 0.1 m at t = 5 s" in unresolved_front(problem, found)[0]
    )


@pytest.mark.parametrize("ahead", [True, False])
def test_a_swing_beside_the_inlet_counts(ahead):
    """The cell there falls from 40 K above the gas that enters to its temperature; its
    mean is 40/3 K above. The same at the outlet is no swing, where nothing enters.
    """
    problem = bed(3)
    flux = abs(problem.streams.mass_flux) * (1.0 if ahead else -1.0)
    streams = replace(problem.streams, mass_flux=flux)
    problem = replace(problem, streams=streams)
    left = with_temperature(
        problem, lambda xi, cell: 600.0 + (cell == 0) * 40.0 * (1.0 - xi) ** 2
    )
    right = with_temperature(
        problem, lambda xi, cell: 600.0 + (cell == 2) * 40.0 * xi**2
    )
    inlet, outlet = (left, right) if ahead else (right, left)
    assert largest_swing(problem, inlet).size == pytest.approx(80.0 / 3.0, rel=1e-10)
    assert not largest_swing(problem, outlet).size


@pytest.mark.parametrize(
    "of",
    [
        # a peak without jumps at the ends of its cell
        lambda xi, cell: 600.0 + (cell == 1) * 400.0 * xi * (1.0 - xi),
        # a jump between flat cells
        lambda xi, cell: 600.0 + 300.0 * (cell < 1) + 0.0 * xi,
        # a slope through all cells
        lambda xi, cell: 600.0 + 100.0 * (cell + xi),
    ],
    ids=["peak", "jump", "slope"],
)
def test_what_is_resolved_does_not_swing(of):
    """From the temperature of the gas that enters."""
    problem = bed(3)
    found = largest_swing(problem, with_temperature(problem, of))
    assert not found.size and unresolved_front(problem, found) == []


@pytest.mark.parametrize(
    ("units", "passed", "warns"), [(3000.0, 0.25, True), (10.0, 0.5, False)]
)
def test_a_front_within_a_cell_warns_and_a_wide_one_does_not(units, passed, warns):
    """Schumann's fronts of 3000 and of 10 transfer units on 6 cells, where gas of 600 K
    enters a bed of 300 K; the first leaves these bounds by 35 K.
    """
    scene, per_second = heated(units)
    scene["mesh"]["cells"] = 6
    time = {"end": passed * units / per_second, "tolerance": 1e-3}
    found = contbed.run(from_dict(scene | {"time": time}))
    assert (min(found.profiles["T_fluid [K]"]) < 270.0) == warns
    swings = [text for text in found.warnings if "swing" in text]
    assert len(swings) == warns
    # positions of profiles may miss the largest
    assert all(35.0 <= float(text.split()[3]) < 60.0 for text in swings)


def test_what_particles_hold_is_shown_between_the_nodes_as_they_hold_it():
    """A front in one cell: concentrations between nodes fall far below zero, what is
    shown does not, with the same in the cell.
    """
    scene, _ = adsorber(100.0, 10.0, 1.0, capacity=2.0)
    problem = course_of(scene | {"time": {"end": 1.0}}).problem
    u, line = problem.start(), problem.line
    rows = [k for k, name in enumerate(problem.names) if name.startswith("a_A")]
    u[rows, 3] = np.array([0.0, 0.0, 0.1, 1.0])
    fine = line.vertices[3] + line.h[3] * (np.arange(3000) + MIDDLE) / 3000
    assert line.at(u[rows[0]], fine).min() < -0.05
    (shown,) = loadings(problem, u, fine).values()
    assert shown.min() >= -1e-12 * shown.max()
    inside = problem.bed.phases["particles"].inside
    inner = {"A": [u[k, 3] for k in rows]}
    held = sum(inside.held(inner, np.full(len(line.nodes), T))[0]["A"])
    assert shown.mean() == pytest.approx(
        held @ line.weights / (1.0 - EPS) / DENSITY, rel=1e-6
    )
