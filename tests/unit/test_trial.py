"""Processor time that a plan predicts for runs with time steps: how it follows from a trial, and that it is right."""

import time
from contextlib import ExitStack
from dataclasses import replace
from types import SimpleNamespace

import pytest
from numba.core import event
from small_scenes import STEADY

import contbed as cb
from contbed import cli, models, trial
from contbed.errors import ConvergenceError
from contbed.loading import from_dict, loads
from contbed.models import plan
from contbed.output.progress import Progress
from contbed.trial import Trial, predicted_time

WARMING = STEADY.replace("cells = 10", "cells = 200") + (
    "[time]\nend = 2000.0\ninitial_fluid = 400.0\ninitial_solid = 400.0\ntolerance = 1e-5\n"
)

PACKING = """
packing = { count = 600, radius = "1 mm", width = ["12 mm", "12 mm"], seed = 1 }
conduction = { particles = 1.4, fluid = 0.026 }
closure = { ratios = [2, 5, 10, 20, 50] }
"""


def test_cost_and_number_of_steps_follow_from_the_second_half():
    """Ten short and dear steps, then ten that take 0.1 s of processor for 1 s each."""
    seen = Trial([0.01 * k for k in range(1, 11)], [0.05 * k for k in range(1, 11)])
    seen.reached += [0.1 + k for k in range(1, 11)]
    seen.spent += [0.5 + 0.1 * k for k in range(1, 11)]
    assert seen.cost_of_a_step() == pytest.approx(0.1)
    assert seen.steps_to(100.1) == pytest.approx(20 + 90)


def test_bars_are_watched_only_inside_of_the_block():
    seen = []
    with Progress(2.0, quiet=True) as bar:
        bar.advance_to(0.5)
        with Progress.watched(lambda progress, value: seen.append(value)):
            bar.advance_to(1.0)
        bar.advance_to(1.5)
    assert seen == [1.0]


def _busy(seconds):
    start = time.process_time()
    while time.process_time() - start < seconds:
        pass


def test_compiling_is_no_part_of_what_a_run_is_predicted_to_take(monkeypatch):
    """Steps of 10 ms, of which two compile for 100 and 200 ms, the second a kernel that calls another one."""

    def run(plan, result, folder, quiet, start):
        with Progress(5.0, quiet=True) as bar:
            for step in range(5):
                with ExitStack() as stack:
                    for _ in range((1, 0, 2, 0, 0)[step]):
                        stack.enter_context(event.trigger_event("numba:compile"))
                        _busy(0.1)
                _busy(0.01)
                bar.advance_to(step + 1.0)

    monkeypatch.setattr(models, "solver_of", lambda scene: run)
    monkeypatch.setattr(models, "model_of", lambda scene: SimpleNamespace(compiles=True))
    seconds, steps = trial._predict(SimpleNamespace(scene=None), 5.0)
    assert steps == 5
    assert 0.05 <= seconds < 0.15


def test_a_steady_scene_has_no_line():
    assert predicted_time(plan(loads(STEADY))) == ""


def test_the_plan_says_how_long_a_transient_takes(tmp_path, capsys, monkeypatch):
    """The number of steps is that of a run on a coarse mesh where the budget is too small for the run itself."""
    monkeypatch.setattr(trial, "BUDGET", 0.05)
    monkeypatch.setattr(trial, "COARSE", 20)
    (tmp_path / "scene.toml").write_text(WARMING)
    assert cli.main(["plan", str(tmp_path / "scene.toml")]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("time: "))
    assert line.endswith("steps, by a trial")
    assert not list(tmp_path.glob("*/"))


def test_predicted_steps_and_time_of_a_transient():
    """Within a factor of 2: the promise of the plan."""
    scene = loads(WARMING)
    seconds, steps = trial._predict(plan(scene), scene.time.end)
    start = time.process_time()
    result = cb.run(scene)
    spent = time.process_time() - start
    assert 0.5 < steps / result.qoi["time_steps"] < 2.0
    assert 0.5 < seconds / spent < 2.0


def test_predicted_time_of_a_packing():
    """Within a factor of 2 of what its spheres take to settle, once everything is compiled."""
    scene = loads(PACKING)
    cb.run(scene)
    start = time.process_time()
    cb.run(scene)
    assert 0.5 < plan(scene).seconds() / (time.process_time() - start) < 2.0
    # what this process has taken so far is no part of it, but what a command took to come so far
    assert predicted_time(plan(scene)).endswith(" s of processor")
    assert predicted_time(plan(scene), 600.0).endswith(" min of processor")
    assert replace(plan(scene), engine="lammps").seconds() is None


def test_predicted_steps_of_fronts(monkeypatch):
    """A parcel of one cell takes each step: a bed of 400 cells in which the gas stays 0.4 s, for 20 s."""
    monkeypatch.setattr(trial, "BUDGET", 0.02)
    scene = from_dict(
        {
            "mesh": {"type": "line", "length": 1.0, "cells": 400},
            "fluid": {"density": 1.0, "heat_capacity": 1000.0, "conductivity": 0.03, "viscosity": 2e-5},
            "solid": {"density": 2000.0, "heat_capacity": 800.0, "conductivity": 1.0},
            "bed": {"porosity": 0.4, "particle_diameter": 0.02},
            "flow": {"velocity": 1.0},
            "heat": {"nusselt": 50.0, "conductivity_fluid": 0.0, "conductivity_solid": 0.0},
            "boundary": {"left": {"fluid": {"inflow": 600.0}}},
            "time": {"end": 20.0, "initial_fluid": 300.0, "initial_solid": 300.0},
        }
    )
    planned = plan(scene)
    _, steps = trial._predict(planned, scene.time.end)
    assert planned.fronts and steps == pytest.approx(20.0 / 0.4 * 400, rel=0.01)
    assert predicted_time(planned).endswith("steps, by a trial")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "changes"),
    [
        ("taghipour_bed/bed_0.46.toml", {"time.end": 2.5, "time.average_from": 2.0}),
        ("vaishali_2007/dpt_wenyu.toml", {"time.end": 1.5, "time.average_from": 1.0}),
        ("zhou_2009_htc/bubbling.toml", {"time.end": 0.05, "time.average_from": 0.04, "time.sample": 0.005}),
        ("patil_packed_bed/dispersion.toml", {}),
    ],
)
def test_predicted_time_of_studies(scene, changes):
    """The second run has everything compiled; planning, which settles particles, is not counted."""
    loaded = cb.load(f"studies/{scene}", changes)
    trial._predict(plan(loaded), loaded.time.end)  # compiles
    planned = plan(loaded)
    seconds, _ = trial._predict(planned, loaded.time.end)
    result = cb.run(loaded)
    assert 0.5 < seconds / (result.timings["total"] - result.timings["plan"]) < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["hamel_gasifiers/wsv_d.toml", "coal_boiler_design/boiler.toml"])
def test_predicted_time_of_searches(scene):
    """Within a factor of 2: the promise of the plan."""
    loaded = cb.load(f"studies/{scene}")
    seconds, _ = trial._searched(plan(loaded))
    start = time.process_time()
    cb.run(loaded)
    assert 0.5 < seconds / (time.process_time() - start) < 2.0


def test_a_run_that_fails_at_once_has_no_line():
    bed = {"type": "line", "length": 0.1, "cells": 4}
    scene = from_dict(
        {
            "mesh": bed,
            "two_fluid": {},
            "gas": {"density": 1.2, "viscosity": 1.8e-5},
            "solid": {"particle_diameter": 1e-3, "density": 2500.0},
            "initial": {"eps_s": 0.3},
            "boundary": {"left": {"type": "wall"}, "right": {"type": "outlet"}},
            "time": {"end": 0.01},
        }
    )
    planned = plan(scene)
    object.__setattr__(planned, "probes", {"nowhere": 10**6})
    assert predicted_time(planned) == ""


def test_a_search_that_ends_is_told_as_it_was():
    line = predicted_time(plan(cb.load("contbed/bubbling_bed/template.toml")))
    assert line.startswith("time: about ") and line.endswith(" of processor, by a trial")


@pytest.mark.parametrize(("guesses", "seconds"), [(1, 10.0), (3, 30.0)])
def test_time_of_a_search_follows_from_the_share_of_its_way(monkeypatch, guesses, seconds):
    """A search of 20 equal parts of 0.5 s, stopped after 5 s; exact, as its parts are equal."""
    planned = plan(cb.load("contbed/bubbling_bed/template.toml"))
    now = SimpleNamespace(process_time=lambda: now.value, value=0.0)

    def run(plan, result, folder, quiet, start):
        for _ in range(guesses):
            with Progress(100.0, "%", quiet) as progress:
                for part in range(1, 21):
                    now.value += 0.5
                    progress.advance_to(5.0 * part)

    monkeypatch.setattr(trial, "clock", now)
    monkeypatch.setattr(type(planned), "guesses", guesses)
    monkeypatch.setattr(models.Model, "find", lambda self, module, name: run)
    assert trial._searched(planned) == (pytest.approx(seconds), False)
    assert trial._text_of_search(planned).endswith("of processor, by the first 5 s of a trial")


def test_a_search_that_fails_has_no_line(monkeypatch):
    planned = plan(cb.load("contbed/bubbling_bed/template.toml"))

    def run(*arguments):
        raise ConvergenceError("no steady state is found", [])

    monkeypatch.setattr(models.Model, "find", lambda self, module, name: run)
    assert predicted_time(planned) == ""
