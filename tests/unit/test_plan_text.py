"""What a plan prints: the steps of a run where they are known; the bar of fronts."""

import pytest

import contbed as cb
from contbed.loading import from_dict, load
from contbed.models import MODELS, plan
from contbed.output.progress import Progress
from contbed.packed_bed import fronts
from tests.scene_text import scene_of


def test_plans_give_the_number_of_steps_where_it_is_known():
    for kind, steps in (("two_fluid", "10 or more"), ("particles_gas", "300 of the")):
        assert dict(plan(load(MODELS[kind].template)).built)["steps"].startswith(steps)
    scene = load(MODELS["two_fluid"].template, {"time.step": 1e-3})
    assert dict(plan(scene).built)["steps"].startswith("100 of 0.001 s")


def test_the_bar_of_fronts_reaches_the_end(monkeypatch):
    """A parcel of one cell takes each step: a bed of 40 cells in which the gas stays
    0.4 s, for 2 s.
    """
    monkeypatch.setattr(fronts, "AT_ONCE", 40)  # a report after each step
    reached = []
    monkeypatch.setattr(
        Progress, "advance_to", lambda bar, value, note="": reached.append(value)
    )
    scene = from_dict(
        scene_of(
            """
            [mesh]
            type = "line"
            length = 1.0
            cells = 40
            [gas]
            density = 1.0
            heat_capacity = 1000.0
            conductivity = 0.03
            viscosity = 2e-5
            [solids.particles]
            density = 2000.0
            heat_capacity = 800.0
            conductivity = 1.0
            diameter = 0.02
            [packed_bed]
            porosity = 0.4
            [closures]
            nusselt = 50.0
            conductivity_gas = 0.0
            conductivity_solids = 0.0
            [heat]
            [boundary.left]
            gas.velocity = 1.0
            gas.temperature = 600.0
            [initial]
            gas.temperature = 300.0
            solids.particles.temperature = 300.0
            [time]
            end = 2.0
            """
        )
    )
    cb.run(scene)
    assert len(reached) == pytest.approx(2.0 / 0.4 * 40, rel=0.1)
    assert reached[-1] == pytest.approx(2.0, rel=1e-3)
