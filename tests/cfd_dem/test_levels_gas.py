"""Averages across a bed of particles in a gas at several heights."""

from types import SimpleNamespace

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

import contbed as cb
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.levels import Levels
from contbed.loading import loads
from tests.cfd_dem.test_probes import SCENE
from tests.refusals import refused

WITH_LEVELS = SCENE.replace(
    "fields = false,", "fields = false, levels = [0.004, 0.05],"
).replace("sample =", "average_from = 0.002, sample =")


def particles(x, z, velocity):
    position = np.column_stack([x, np.full(len(x), 0.5), z])
    return SimpleNamespace(position=position, velocity=np.array(velocity, dtype=float))


def test_particles_near_a_height_are_averaged_by_column():
    grid = Grid(np.array([1.0, 0.0, 0.0]), np.array([0.5, 1.0, 0.1]), (4, 1, 10))
    levels = Levels(grid, (0.3, 0.9))
    # two in the first column, one of them almost a cell above; one in the last; one
    # between the heights
    levels(
        particles(
            [1.1, 1.2, 3.0, 2.0],
            [0.3, 0.39, 0.25, 0.45],
            [(3, 0, 4), (0, 0, -1), (0, 2, 0), (9, 9, 9)],
        )
    )
    levels(particles([1.4], [0.95], [(0, 0, 2)]))
    found = levels.table()
    assert_array_equal(found["height [m]"], [0.3, 0.3, 0.9])
    assert_allclose(found["x [m]"], [1.25, 2.75, 1.25], rtol=1e-15)
    assert_allclose(found["speed_solid [m/s]"], [3.0, 2.0, 2.0], rtol=1e-15)
    assert_allclose(found["u_solid [m/s]"], [1.5, 0.0, 2.0], rtol=1e-15)


def test_averages_are_those_of_samples_from_their_start_on(tmp_path):
    result = cb.run(loads(WITH_LEVELS), out=tmp_path)
    table = result.tables["levels"]
    assert (table["height [m]"] == 0.004).all()  # no particle is as high as the second
    assert 0.0 < table["speed_solid [m/s]"].max() < 1.0
    assert (np.abs(table["u_solid [m/s]"]) <= table["speed_solid [m/s]"]).all()
    assert (
        (tmp_path / "levels.csv")
        .read_text()
        .startswith("height [m],x [m],speed_solid [m/s],u_solid [m/s]")
    )


def test_a_height_above_the_box_is_refused():
    refused(
        r"output\.levels.*outside of the box from 0 to 0\.06 m",
        lambda: loads(WITH_LEVELS.replace("0.05]", "0.07]")),
    )
