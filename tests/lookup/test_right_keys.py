"""A closure's name at a wrong key: the message names the key that takes it."""

from pathlib import Path

import pytest

import contbed as cb
from contbed.errors import SceneError
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import scene_of

PACKAGE = Path(cb.__file__).parent


@each_case(__file__, "the_right_key_is_named")
def test_the_right_key_is_named(model, key, value, part):
    text = (PACKAGE / model / "template.toml").read_text()
    refused(part, cb.load, scene_of(text, {key: value}))


def test_a_misspelt_closure_at_its_key_is_only_that():
    text = (PACKAGE / "two_fluid" / "template.toml").read_text()
    with pytest.raises(SceneError) as caught:
        cb.load(scene_of(text, {"closures.drag": "wen_y"}))
    assert "is a closure of the kind" not in str(caught.value)
