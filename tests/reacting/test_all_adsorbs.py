"""Adsorbers whose particles take up all of the gas that enters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contbed
from contbed.errors import SceneError
from contbed.reacting_bed.plan import plan

FOLDER = Path(__file__).parents[1] / "data" / "first_hour"
# of the scenes [mol/m3 bed]: gas in the pores, and adsorbed behind the front
MOLAR = 1e5 / (8.31446261815324 * 298.15)
PORES = 0.38 * MOLAR
HELD = 0.62 * 1100.0 * 2.858 * 5.0 / 6.0
FEED = 0.05 * MOLAR  # [mol/m2/s]
SPEED = FEED / (PORES + HELD)  # of the front [m/s]
LENGTH = 0.3
CELLS = 4


def loaded(name, **time):
    scene = contbed.load(FOLDER / f"{name}.toml")
    return scene.with_table("time", **time) if time else scene


@pytest.mark.parametrize("name", ["pure", "p100", "pst"])
def test_gas_is_stored_in_cells_of_one_value(name):
    made = plan(loaded(name))
    assert made.stores_gas and made.problem.line.degree == 0


def test_a_pure_adsorbate_displaces_helium():
    """The front moves as the moles that it leaves behind ask for, and the gas ahead of
    it with eps times the speed of the front.
    """
    # the front passes one cell between both times
    later = 2.5 * LENGTH / CELLS / SPEED
    times = (later - LENGTH / CELLS / SPEED, later)
    scene = loaded("pure", end=later, times=times, tolerance=3e-3)
    scene = scene.with_table("mesh", cells=CELLS)
    result = contbed.run(scene)
    for balance in result.balances.values():
        assert abs(balance["relative_residual"]) < 1e-11
    t, x, helium = (
        np.array(result.profiles[key]) for key in ("t [s]", "x [m]", "x_He [1]")
    )
    left = [
        np.trapezoid(helium[np.isclose(t, time)], x[np.isclose(t, time)])
        for time in times
    ]
    assert (left[0] - left[1]) / (times[1] - times[0]) == pytest.approx(SPEED, rel=0.02)
    # all that flows ahead of the front is helium
    outlet = result.tables["outlet"]
    assert np.min(outlet["x_He [1]"]) > 1.0 - 1e-4


def test_gas_that_follows_at_once_is_refused():
    scene = loaded("pure").with_table("packed_bed", gas_storage="quasi_steady")
    with pytest.raises(SceneError, match="all of the gas that enters is adsorbed"):
        plan(scene)
