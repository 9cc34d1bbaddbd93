"""`contbed new KIND` for each physics: a commented scene that runs as it is, without
a warning.
"""

import pytest

from contbed import cli, load, run
from contbed.explain import editor
from contbed.models import MODELS, kind_of
from contbed.scene.toml_lines import parse
from tests.command_line import command


@pytest.mark.parametrize("kind", MODELS)
def test_every_physics_has_a_scene_to_begin_with(kind, tmp_path, capsys):
    text = editor.template(kind)
    values, _ = parse(text, "scene.toml", tmp_path)
    assert kind_of(values) == kind
    assert text.startswith("#") and text.count("#") >= 3
    file = tmp_path / "scene.toml"
    assert command(f"new {kind} --out {file}") == 0
    scene = load(file)
    assert scene.warnings == ()
    # a file that is there is not written over
    assert command(f"new {kind} --out {file}") == 2
    assert "is there already" in capsys.readouterr().err


# those that take many steps
LONG = ("two_fluid", "particles_gas", "single_particle")


@pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=[pytest.mark.slow] * (kind in LONG)) for kind in MODELS],
)
def test_it_runs(kind, tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(editor.template(kind))
    result = run(load(file))
    assert result.status == "ok" and result.qoi
    assert result.warnings == []


def test_new_lists_the_kinds_and_names_the_nearest(capsys):
    assert cli.main(["new"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(
        MODELS
    )
    assert command("new packed_bad") == 2
    assert "did you mean 'packed_bed'?" in capsys.readouterr().err
