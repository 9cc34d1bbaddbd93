"""The state is a value: a step leaves it alone, a saved one is the same to the last
bit. Phases of a step are timed.
"""

from pathlib import Path

import numpy as np
import pytest
from test_core_exact import WALLS, fluidized
from test_heat_two_fluid import bubbling

import contbed as cb
from contbed.two_fluid.simulation import Simulation
from contbed.two_fluid.state import flatten, rebuild
from contbed.two_fluid.step import step

PHASES = (
    "continuity",
    "closures",
    "momentum",
    "pressure",
    "reconstruction",
    "granular temperature",
)
STUDY = Path(__file__).parents[2] / "studies" / "two_fluid_checks"


def beds():
    """Beds with every part of the state: isothermal, on a skewed grid, with an ideal
    gas.
    """
    return [
        fluidized(WALLS[2], noise=0.01),
        fluidized(WALLS[2], shape="triangle"),
        bubbling("triangle", True),
    ]


@pytest.mark.parametrize("number", range(3))
def test_a_step_leaves_its_state_alone(number):
    b = beds()[number]
    for _ in range(3):
        b.step(b.next_step())
    before = {name: np.array(value) for name, value in flatten(b.state).items()}
    new = step(b.state, 1e-4, b.model)
    again = step(b.state, 1e-4, b.model)
    for name, value in flatten(b.state).items():
        assert np.array_equal(value, before[name]), name
    for name, value in flatten(new).items():
        assert np.array_equal(value, flatten(again)[name]), name


@pytest.mark.parametrize("number", range(3))
def test_a_saved_state_is_the_same(number):
    b = beds()[number]
    b.step(b.next_step())
    saved = flatten(b.state)
    other = rebuild(Simulation(b.model).state, saved)
    assert (
        type(other.account) is type(b.state.account)
        and other.counters == b.state.counters
    )
    assert saved.keys() == flatten(other).keys()
    for name, value in flatten(other).items():
        assert np.array_equal(value, saved[name]), name


def test_phases_of_the_step_are_timed():
    """They are all of the flow but its start, rows and compilation, so that their
    sum is not more.
    """
    timings = cb.run(
        cb.load(STUDY / "closed_box_jj.toml", {"mesh.cells": [4, 20], "time.end": 0.02})
    ).timings
    phases = {name: timings[f"flow: {name}"] for name in PHASES}
    assert {name for name in timings if name.startswith("flow: ")} == {
        f"flow: {name}" for name in PHASES
    }
    assert all(seconds > 0.0 for seconds in phases.values())
    assert sum(phases.values()) <= timings["flow"]


def test_time_of_a_phase_is_without_those_that_it_calls():
    from contbed.two_fluid.timing import Timer

    timer = Timer()
    timer.run("outer", lambda: timer.run("inner", lambda: sum(range(10**5))))
    assert timer.seconds["outer"] < timer.seconds["inner"]
