"""A closure's name at a wrong key: the message names the key that takes it."""

from pathlib import Path

import pytest

import contbed as cb
from contbed.errors import SceneError
from tests.refusals import refused
from tests.scene_text import scene_of

PACKAGE = Path(cb.__file__).parent


@pytest.mark.parametrize(
    ("model", "key", "value", "part"),
    [
        (
            "bubbling_bed",
            "solids.sand.gas_coefficient",
            "ranz_marshall",
            "kind nusselt: for solids.sand.nusselt or .*closures.nusselt",
        ),
        ("packed_bed", "packed_bed.porosity", "gunn", "for closures.nusselt"),
        ("two_fluid", "closures.drag", "gunn", "for closures.nusselt"),
        ("two_fluid", "gas.density", "wen_yu", "kind drag: for closures.drag"),
        ("packed_bed", "packed_bed.porosity", "wen_yu", "for no key of this model"),
    ],
)
def test_the_right_key_is_named(model, key, value, part):
    text = (PACKAGE / model / "template.toml").read_text()
    refused(part, cb.load, scene_of(text, {key: value}))


def test_a_misspelt_closure_at_its_key_is_only_that():
    text = (PACKAGE / "two_fluid" / "template.toml").read_text()
    with pytest.raises(SceneError) as caught:
        cb.load(scene_of(text, {"closures.drag": "wen_y"}))
    assert "is a closure of the kind" not in str(caught.value)
