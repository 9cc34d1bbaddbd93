"""What a plan prints: the time of packings, and no time where no formula gives it;
the bar of fronts.
"""

import time
from dataclasses import replace

import pytest

import contbed as cb
from contbed.dem.particles import Material, Particles
from contbed.dem.settling import settling_time, stages_of
from contbed.loading import from_dict, load, loads
from contbed.models import MODELS, plan
from contbed.output.progress import Progress
from contbed.plan_text import duration
from tests.scene_text import scene_of

PACKING = """
[particles]
packing = { count = 600, width = ["12 mm", "12 mm"], seed = 1 }
closure = { ratios = [2, 5, 10, 20, 50] }
[solids.spheres]
diameter = "2 mm"
conductivity = 1.4
youngs_modulus = "10 MPa"
[gas]
conductivity = 0.026
"""


def test_the_plan_predicts_the_time_of_a_packing():
    """Within a factor of 2 of what its spheres take to settle, once everything is
    compiled.
    """
    scene = loads(PACKING)
    cb.run(scene)
    start = time.process_time()
    cb.run(scene)
    spent = time.process_time() - start
    assert 0.5 < plan(scene).seconds() / spent < 2.0
    assert str(plan(scene)).endswith(
        f"time: about {duration(plan(scene).seconds())} of processor"
    )
    assert replace(plan(scene), engine="lammps").seconds() is None


def test_stiffer_particles_settle_in_more_and_shorter_steps():
    """A tenth more modulus to the power of 2.5 is one more stage, of steps 10^0.4
    shorter.
    """
    material = Material(2500.0, 1e6, 0.25, 0.8, 0.4)
    bed = Particles([[0.01, 0.01, 0.1]], 1e-3)
    soft, stiff = (
        settling_time(
            stages_of(bed, replace(material, youngs_modulus=modulus), 1e-6, 9.81),
            30000,
            0.1,
            9.81,
        )
        for modulus in (1e6, 1e7)
    )
    assert stiff / soft == pytest.approx(1.0 + 0.13 / 0.6 * 10**0.4, rel=1e-3)


@pytest.mark.parametrize("kind", MODELS)
def test_other_plans_predict_no_time(kind):
    text = str(plan(load(MODELS[kind].template)))
    assert "time: " not in text and "of processor" not in text and " a step" not in text


def test_plans_give_the_number_of_steps_where_it_is_known():
    for kind, steps in (("two_fluid", "10 or more"), ("particles_gas", "300 of the")):
        assert dict(plan(load(MODELS[kind].template)).built)["steps"].startswith(steps)
    scene = load(MODELS["two_fluid"].template, {"time.step": 1e-3})
    assert dict(plan(scene).built)["steps"].startswith("100 of 0.001 s")


def test_the_bar_of_fronts_reaches_the_end(monkeypatch):
    """A parcel of one cell takes each step: a bed of 40 cells in which the gas stays
    0.4 s, for 2 s.
    """
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
