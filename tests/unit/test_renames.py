"""Former names of tables and keys of a scene: each is found, taken out, and answered
by its present name.
"""

import re
import tomllib
from copy import deepcopy
from typing import Any

import pytest

from contbed.loading import from_dict
from contbed.models import MODELS
from contbed.scene import schema
from contbed.scene.renames import NAME, renamed, take_former_keys
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import set_keys

RENAMED = {
    "fluid": "gas",
    "fluid.temperature": "gas.material_temperature",
    "boundary.NAME.fluid.inflow": "boundary.NAME.gas.temperature",
    "boundary.NAME.gas": "boundary.NAME.gas.wall",
    "initial.layer.eps_s": "initial.layer.solids.NAME.volume_fraction",
    "flow.velocity": "the velocity stands at the boundary where the gas enters",
}


@each_case(__file__, "a_former_key_is_answered_by_its_present_name")
def test_a_former_key_is_answered_by_its_present_name(
    values: dict[str, Any], path: Any, now: str
) -> None:
    assert take_former_keys(values, RENAMED) == [
        (tuple(path), f"this key is called '{now}' now")
    ]


def test_former_keys_are_taken_out_with_tables_that_become_empty() -> None:
    values = {
        "fluid": {"temperature": 300.0, "density": 1.0},
        "boundary": {"left": {"fluid": {"inflow": 300.0}, "gas": {"velocity": 1.0}}},
        "flow": {"velocity": 1.0},
    }
    texts = dict(take_former_keys(values, RENAMED))
    assert len(texts) == 4
    assert texts["flow", "velocity"] == RENAMED["flow.velocity"]
    assert values == {"boundary": {"left": {"gas": {"velocity": 1.0}}}}


@pytest.mark.parametrize("kind", MODELS)
def test_a_former_key_of_a_template_says_what_to_do(kind: str) -> None:
    values = tomllib.loads(MODELS[kind].template.read_text(encoding="utf-8"))
    values.pop("model", None)
    for former, now in renamed(kind).items():
        if " " in now and NAME not in former:
            scene = deepcopy(values)
            set_keys(scene, f"{former} = 1")
            refused(re.escape(now), from_dict, scene)


@pytest.mark.parametrize("kind", MODELS)
def test_present_names_are_keys_of_the_scene(kind: str) -> None:
    model = MODELS[kind].scene
    for former, now in renamed(kind).items():
        nodes = [schema.of(model)]
        for step in () if " " in now else now.split("."):
            items = [item for node in nodes for item in schema.children(node, 0)]
            nodes = [
                below
                for node in (*nodes, *items)
                for below in schema.children(node, step)
            ]
        assert nodes, (former, now)
