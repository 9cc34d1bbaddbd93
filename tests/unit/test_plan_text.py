"""What a plan prints: the steps of a run where they are known."""

from contbed.loading import load
from contbed.models import MODELS, plan


def test_plans_give_the_number_of_steps_where_it_is_known():
    for kind, steps in (("two_fluid", "10 or more"), ("particles_gas", "300 of the")):
        assert dict(plan(load(MODELS[kind].template)).built)["steps"].startswith(steps)
    scene = load(MODELS["two_fluid"].template, {"time.step": 1e-3})
    assert dict(plan(scene).built)["steps"].startswith("100 of 0.001 s")
