"""Which model reads a scene, and what becomes of the keys that only others have."""

from __future__ import annotations

import re

import pytest
from small_scenes import STEADY

from contbed.loading import loads
from contbed.models import MODELS, plan
from contbed.plan_text import plan_text
from tests.refusals import refused

OTHERS = """\
[two_fluid]
gravity = 9.81
[bubbling_bed]
height = 1.0
"""


def test_a_model_ignores_the_tables_of_others_and_lists_them():
    scene = loads(f'model = "packed_bed"\n{STEADY}{OTHERS}')
    assert scene.ignored == (("two_fluid",), ("bubbling_bed",))
    text = plan_text(plan(scene))
    assert "MODEL   packed_bed" in text
    assert "IGNORED two_fluid" in text


def test_a_key_of_no_model_stays_a_mistake():
    refused(
        r"two_fluid\.gravty = 9\.81: unknown key",
        lambda: loads(
            f'model = "two_fluid"\n{STEADY}{OTHERS}'.replace("gravity", "gravty")
        ),
    )
    refused(
        "colour = 1: unknown key",
        loads,
        f'colour = 1\nmodel = "packed_bed"\n{STEADY}{OTHERS}',
    )


def test_tables_of_two_models_need_the_name_of_one():
    refused(r"tables of several models; say which one", lambda: loads(STEADY + OTHERS))


def test_an_unknown_model_is_named_with_those_that_exist():
    refused(
        r"scene.toml:1: model = .*'packed_bed'", loads, f'model = "packd_bed"\n{STEADY}'
    )


@pytest.mark.parametrize("kind", MODELS)
def test_templates_run_with_their_model_named(kind):
    text = MODELS[kind].template.read_text(encoding="utf-8")
    line = f'model = "{MODELS[kind].name}"\n'
    named = loads(text if line in text else line + text)
    assert type(named) is type(loads(text))
    assert named.ignored == ()


def test_solids_that_collide_on_a_mesh_are_two_fluids_without_their_table():
    text = MODELS["two_fluid"].template.read_text(encoding="utf-8")
    bare = re.sub(r"(?m)^model = .*$", "", text)
    assert "[two_fluid]" not in bare
    assert loads(bare).kind == "two_fluid"
