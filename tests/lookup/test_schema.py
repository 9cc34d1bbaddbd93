"""The JSON schema for editors takes what `contbed check` takes, and refuses wrong
values and keys.
"""

import json
import tomllib
from pathlib import Path

import pytest

from contbed.explain import editor
from contbed.explain.closure_keys import closure_keys
from contbed.models import MODELS, kind_of
from contbed.scene import schema
from tests.cases import each_case
from tests.command_line import command

jsonschema = pytest.importorskip(
    "jsonschema", reason="jsonschema is not installed: pip install 'contbed[notebook]'"
)
ROOT = Path(__file__).parents[2]
FILES = [
    *ROOT.glob("studies/*/*.toml"),
    *ROOT.glob("contbed/*/template.toml"),
    *ROOT.glob("contbed/many/validate/cases/*/scene.toml"),
]


@pytest.fixture(scope="module")
def validators():
    made = {kind: editor.json_schema(kind) for kind in MODELS}
    for one in made.values():
        jsonschema.Draft202012Validator.check_schema(one)
    return {kind: jsonschema.Draft202012Validator(one) for kind, one in made.items()}


def test_every_scene_of_the_project_is_valid(validators):
    """All studies and templates, each by the schema of its kind and by that of all
    kinds together.
    """
    every = jsonschema.Draft202012Validator(editor.json_schema())
    seen = set()
    for file in FILES:
        values = tomllib.loads(file.read_text(encoding="utf-8"))
        if "scene" in values:  # a sweep
            continue
        kind = kind_of(values)
        seen.add(kind)
        wrong = [
            f"{file.name}: {error.json_path}: {error.message}"
            for error in validators[kind].iter_errors(values)
        ]
        assert not wrong
        assert every.is_valid(values)
    assert seen == set(MODELS)


@each_case(__file__, "mistakes_are_found")
def test_mistakes_are_found(validators, old, new):
    text = editor.template("packed_bed")
    assert old in text
    assert not validators["packed_bed"].is_valid(tomllib.loads(text.replace(old, new)))


def test_one_coordinate_may_stand_alone(validators):
    scene = tomllib.loads(editor.template("packed_bed"))
    for across, valid in (
        (0.02, True),
        ("2 cm", True),
        ([0.02, 0.01], True),
        ({}, False),
    ):
        output = scene.get("output", {}) | {"across": across}
        assert validators["packed_bed"].is_valid(scene | {"output": output}) == valid


def test_descriptions_say_the_unit_and_closures_are_offered():
    found = editor.json_schema("packed_bed")["$defs"]
    assert (
        found["packed_bed.Dispersion"]["properties"]["axial"]["description"]
        == "thermal dispersion along the flow [W/m/K]"
    )
    text = json.dumps(found["packed_bed.Closures"]["properties"]["nusselt"])
    assert "nusselt_gunn" in text and "drag_wen_yu" not in text


def test_every_place_that_takes_a_closure_has_a_kind():
    """A key whose value may be a closure's table is known to `contbed closures
    --for`.
    """

    def keys(table, path, seen):
        for key, node in table.get("properties", {}).items():
            if any(schema.is_closure(option) for option in schema.options(node)):
                yield (*path, key)
            for option in schema.options(node):
                inner = option.get("additionalProperties")
                name = (key, "NAME") if isinstance(inner, dict) else (key,)
                for below in (
                    schema.options(inner) if isinstance(inner, dict) else [option]
                ):
                    if (
                        "properties" in below
                        and below.get("title") not in seen
                        and not schema.is_closure(below)
                    ):
                        yield from keys(
                            below, (*path, *name), (*seen, below.get("title"))
                        )

    wanted = {
        ".".join(path)
        for model in MODELS.values()
        for path in keys(schema.of(model.scene), (), ())
    }
    assert wanted <= set(closure_keys())


def test_the_command_prints_json(capsys):
    assert command("schema radiation") == 0
    assert json.loads(capsys.readouterr().out)["$ref"] == "#/$defs/radiation"
    assert command("schema radiations") == 2
