"""Adsorbers whose particles take up all of the gas that enters."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import fsolve
from solving import course_of

import contbed
from contbed.errors import SceneError
from contbed.loading import from_dict
from contbed.reacting_bed.plan import plan
from contbed.reacting_bed.solve import Report
from contbed.reacting_bed.time_steps import BedSteps, begin
from tests.balances import assert_closed
from tests.scene_text import scene_of

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


ROLL_UP = """
    [mesh]
    type = "line"
    length = 0.25
    cells = 10

    [gas]
    model = "ideal_gas"
    composition = "CO2:0.3, CH4:0.3, He:0.4"
    pressure = 5e5
    viscosity = 1.8e-5
    diffusivity = 1e-6
    species = { CO2 = {}, CH4 = {}, He = {} }

    [solids.sorbent]
    diameter = 1.5e-3
    density = 850.0
    adsorption.CO2 = { capacity = 8.0, affinity = 4e-6, diffusivity = 1e-6 }
    adsorption.CH4 = { capacity = 8.0, affinity = 8e-7, diffusivity = 1e-6 }
    inside.adsorption = "linear_driving_force"

    [packed_bed]
    porosity = 0.4
    pressure_drop = "none"
    gas_storage = "stored"

    [closures]
    sherwood = 10.0

    [boundary.left.gas]
    velocity = 0.03
    temperature = 298.15

    [initial]
    gas.composition = "He:1"

    [time]
    end = 130.0
    tolerance = 1e-2

    [output]
    plots = false
"""


def test_a_weak_adsorbate_rolls_up_ahead_of_a_strong_one():
    """Steep fronts in cells that are longer than they are: damping that grows does
    not stop the run.
    """
    molar, solids = 5e5 / (8.31446261815324 * 298.15), 0.6 * 850.0

    def held(carbon_dioxide, methane):
        """Moles per volume of bed: Langmuir's isotherm, and the pores."""
        p = 5e5 * np.array([carbon_dioxide, methane])
        share = np.array([4e-6, 8e-7]) * p
        x = np.array([carbon_dioxide, methane, 1.0 - carbon_dioxide - methane])
        q = 8.0 * np.append(share, 0.0) / (1.0 + share.sum())
        return solids * q + 0.4 * molar * x

    def open_by(unknowns):
        """Return what the shock of CO2 leaves of each gas; flows and speeds are over
        those of the feed.
        """
        plateau, flow, speed = unknowns
        before = flow * np.array([0.0, plateau, 1.0 - plateau])
        gained = held(0.3, 0.3) - held(0.0, plateau)
        return np.array([0.3, 0.3, 0.4]) - before - speed * gained / molar

    plateau = fsolve(open_by, [0.5, 0.8, 0.02])[0]
    result = contbed.run(from_dict(scene_of(ROLL_UP)))
    assert_closed(result, 1e-12)
    # films and cells widen both fronts, whose ends take 0.6 % of the short plateau
    top = np.max(result.tables["outlet"]["x_CH4 [1]"])
    assert top == pytest.approx(plateau, rel=8e-3)
    assert result.qoi["time_steps"] < 300


def test_residuals_of_a_step_are_few():
    """A predictor, and matrices where corrections fall slowly, find both stages to
    rounding.
    """
    scene = scene_of(ROLL_UP, {"time.end": 2.0, "mesh.cells": 60})
    course, report = course_of(scene), Report()
    steps = BedSteps(course, report).march(begin(course, course.start()))
    for history in islice(steps, 30):
        taken = history.steps
    # one matrix for a step without a predictor takes 29
    assert len(report.history) < 15 * taken


def test_a_plan_says_what_fronts_shorter_than_a_cell_cost():
    """A unit of film and inside is u (1 + Bi/5)/(k a), with k = Sh D/d and Bi = 5."""
    unit = 0.03 * (1.0 + 5.0 / 5.0) / (10.0 * 1e-6 / 1.5e-3 * 6.0 * 0.6 / 1.5e-3)
    advice = f"as short as {1e3 * unit:.3g} mm, less than a cell"
    assert advice in str(plan(from_dict(scene_of(ROLL_UP))))
    for changes in ({"mesh.cells": 80}, {"solver.degree": 0}):
        assert advice not in str(plan(from_dict(scene_of(ROLL_UP, changes))))


def test_a_liquid_says_that_it_carries_no_species():
    with pytest.raises(SceneError, match=r"ideal_gas; species, .* take an ideal gas"):
        contbed.load(FOLDER / "pure.toml", {"gas.model": "coolprop"})
