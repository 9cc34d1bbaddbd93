"""Points inside of particles fall below zero before a front reaches them; what the
particles hold does not.
"""

from __future__ import annotations

import numpy as np
from adsorption_scenes import adsorber
from solving import marched

from contbed.loading import from_dict
from contbed.models import plan
from contbed.reacting_bed.course import Course
from tests.scene_text import set_keys


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
