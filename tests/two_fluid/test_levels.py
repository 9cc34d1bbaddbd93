"""Lateral profiles at levels: those of the row of cells that a level cuts, and the
mean speed of the particles.
"""

import numpy as np
import pytest

import contbed as cb
from contbed.loading import loads
from tests.refusals import refused

SCENE = """
mesh = { type = "rectangle", length = 0.02, height = 0.04, cells = [5, 8] }
two_fluid = {}
gas = { density = 1.2, viscosity = 1.8e-5 }
solids.beads = { diameter = 275e-6, density = 2500.0 }
time = { end = 4e-3, sample = 1e-3, average_from = 1e-3 }
output = { plots = false, fields = false, levels = [0.0111, 0.032], window = { start = 0.0101, end = 0.0149 } }
[initial]
noise = 0.2
seed = 3
layer = [
    { end = 0.02, solids.beads.volume_fraction = 0.4 },
    { start = 0.02, solids.beads.volume_fraction = 0.1 },
]
[boundary]
left = { type = "wall" }
right = { type = "wall" }
bottom = { type = "inlet", gas.velocity = 0.3 }
top = { type = "outlet" }
"""


def test_a_level_has_the_profile_of_its_row_of_cells():
    tables = cb.run(loads(SCENE)).tables
    levels, row = tables["levels"], tables["lateral"]
    assert set(levels) == {"height [m]", *row}
    assert "speed_solid [m/s]" in levels
    first = levels["height [m]"] == 0.0111
    assert first.sum() == 5
    for name, column in row.items():
        assert np.array_equal(levels[name][first], column), name
    assert not np.array_equal(levels["eps_s [1]"][~first], row["eps_s [1]"])
    assert levels["eps_s [1]"][~first].max() < 0.2


def test_speed_is_the_mean_of_the_magnitude():
    """Not less than the magnitude of the mean velocity, and its root mean square not
    less than the mean.
    """
    from contbed.two_fluid.plan import plan
    from contbed.two_fluid.run import Run

    run = Run(plan(loads(SCENE)))
    speeds, weights = [], []

    def keep(bed):
        run.after_step(bed)
        if bed.state.time > 1e-3:
            s = bed.state.eps_s
            speeds.append(
                bed.state.dt * s * np.sqrt((bed.state.u_solid**2).sum(axis=1))
            )
            weights.append(bed.state.dt * s)

    run.bed.advance(4e-3, keep)
    found = run.averages.means()
    assert found["speed_solid"] == pytest.approx(
        np.sum(speeds, axis=0) / np.sum(weights, axis=0), rel=1e-12
    )
    assert (
        found["speed_solid"] >= np.linalg.norm(found["u_solid"], axis=1) * (1.0 - 1e-12)
    ).all()


def test_a_level_outside_of_the_vessel_is_refused():
    refused(
        r":7: output.levels\[1\].* outside of the vessel, which reaches from 0 to 0.04",
        lambda: loads(SCENE.replace("0.032]", "0.042]")),
    )
