"""Scenes that would run programs: geometries of gmsh, mechanisms of Cantera,
programs of a benchmark.
"""

import json
import subprocess
import sys
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest

from contbed.errors import SceneError
from contbed.loading import from_dict, load
from contbed.models import MODELS, plan
from contbed.scene.gas import GasCantera
from contbed.scene.inputs import all_inputs, inputs_elsewhere
from contbed.scene.mechanism import code_in_mechanism, other_format
from contbed.scene.mesh import MeshFile
from tests.command_line import command
from tests.refusals import refused

SCENE = """\
[mesh]
type = "file"
file = "bed.geo"
[gas]
density = 1
viscosity = 2e-5
[solids.sand]
diameter = "3 mm"
[packed_bed]
porosity = 0.4
[boundary]
left = { type = "inlet", gas.velocity = [0.1, 0.0] }
right.type = "outlet"
Exit.type = "no_slip"
"""
GEO = """\
SetFactory("Built-in");
Point(1) = {0, 0, 0, 0.5}; Point(2) = {1, 0, 0, 0.5}; Point(3) = {1, 1, 0, 0.5};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1};
Curve Loop(1) = {1, 2, 3}; Plane Surface(1) = {1};
Physical Surface("bed System") = {1}; Physical Curve("Exit") = {1};
Physical Curve("left") = {3}; Physical Curve("right") = {2};
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "bed.geo").write_text(GEO)
    return tmp_path


def test_a_geometry_is_refused_and_not_run(folder, capsys):
    try:
        import gmsh  # noqa: F401
    except (ImportError, OSError) as error:
        pytest.skip(f"gmsh cannot be imported: {error}")
    (folder / "bed.geo").write_text(GEO + f'SystemCall "touch {folder / "mark"}";\n')
    for name in ("check", "plan", "run", "converge"):
        assert command(f"{name} scene.toml") == 2
        assert (
            capsys.readouterr()
            .err.splitlines()[0]
            .endswith(
                'scene.toml:3: mesh.file = "bed.geo": a geometry of gmsh may run '
                "programs and write files; "
                "refused unless you trust it: --trust, in Python load(..., trust=True)"
            )
        )
    (folder / "study.toml").write_text(
        'scene = "scene.toml"\n[parameters]\npacked_bed.porosity = [0.4, 0.5]\n'
    )
    assert command("sweep study.toml --jobs 1") == 2
    assert not (folder / "mark").exists()
    load("scene.toml", trust=True)
    command("plan scene.toml --trust")
    assert (folder / "mark").exists()


MECHANISMS = {
    "plain": ("extensions:\n- {type: python, name: evil}\n", True),
    "quoted": ('"extensions":\n- {type: python, name: evil}\n', True),
    "escaped": ('"\\x65xtensions":\n- {type: python, name: evil}\n', True),
    "explicit": ("? extensions\n: - {type: python, name: evil}\n", True),
    "flow": ("{a: 1, 'extensions': [{type: python, name: evil}]}\n", True),
    "twice": ("extensions: []\nextensions:\n- {type: python, name: evil}\n", True),
    "comment": ("# extensions\na: 1\n", False),
    "text": ("a: the extensions of this file\n", False),
    "none": ("a: 1\n", False),
}


@pytest.mark.parametrize(("text", "runs"), MECHANISMS.values(), ids=MECHANISMS)
def test_extensions_of_a_mechanism(tmp_path, text, runs):
    pytest.importorskip("ruamel.yaml")
    (tmp_path / "mine.yaml").write_text(text)
    assert bool(code_in_mechanism(tmp_path / "mine.yaml")) == runs


def test_a_mechanism_in_another_encoding_or_format(tmp_path):
    (tmp_path / "mine.yaml").write_bytes(
        "extensions:\n- {type: python, name: evil}\n".encode("utf-16")
    )
    assert code_in_mechanism(tmp_path / "mine.yaml")
    assert other_format(tmp_path / "mine.yaml") == ""
    assert other_format(Path("gri.INP")).endswith("convert it: ck2yaml --input=gri.INP")
    assert other_format(Path("gri.txt")).endswith(
        "a mechanism is a YAML file of Cantera"
    )


def test_a_mechanism_does_not_import_a_module(tmp_path):
    cantera = pytest.importorskip("cantera")
    shipped = next(
        Path(f) / "gri30.yaml"
        for f in cantera.get_data_directories()
        if (Path(f) / "gri30.yaml").is_file()
    )
    (tmp_path / "mine.yaml").write_text(
        shipped.read_text() + "\nextensions:\n- type: python\n  name: evil\n"
    )
    (tmp_path / "evil.py").write_text("open('mark', 'w').close()\n")
    text = SCENE.replace('"file"\nfile = "bed.geo"', '"line"\nlength = 1.0').split(
        "[boundary"
    )[0]
    gas = 'model = "cantera"\ncomposition = "N2:1"\nmechanism = "mine.yaml"'
    (tmp_path / "scene.toml").write_text(
        text.replace("density = 1\nviscosity = 2e-5", gas)
    )
    for name in ("check", "run"):
        done = subprocess.run(
            [sys.executable, "-m", "contbed", name, "scene.toml"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 2
        assert (
            "mine.yaml:" in done.stderr
            and "extensions import Python modules" in done.stderr
        )
    assert not (tmp_path / "mark").exists()
    (tmp_path / "mine.yaml").unlink()
    refused(
        r"scene.toml:7: gas.mechanism = .*: no such mechanism; looked in ",
        lambda: load(tmp_path / "scene.toml"),
    )


def packed(**keys):
    """The template of a packed bed with other keys."""
    scene = tomllib.loads(MODELS["packed_bed"].template.read_text())
    return scene | keys


def test_files_outside_of_the_folder_of_a_scene_are_listed(tmp_path, capsys):
    (tmp_path / "k.csv").write_text("T [K],k [W/m/K]\n300,1\n900,2\n")
    inside = tmp_path / "inside"
    inside.mkdir()
    text = MODELS["packed_bed"].template.read_text()
    (inside / "scene.toml").write_text(text)
    key = "solids.silica.conductivity"
    assert command(f"check {inside}/scene.toml") == 0
    assert "reads files" not in capsys.readouterr().out
    file = "{file='../k.csv'}"
    assert command(f'check {inside}/scene.toml --set "{key}={file}"') == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if "outside of its folder" in line] == [
        f"{inside}/scene.toml: reads files outside of its folder: {tmp_path}/k.csv"
    ]


def test_files_that_a_geometry_or_a_mechanism_names_are_inputs_as_well(tmp_path):
    """Also of files that it includes, but not of comments; of Cantera's own files
    nothing is listed.
    """
    inside = tmp_path / "inside"
    inside.mkdir()
    (tmp_path / "part.geo").write_text(
        'Merge "part.step";\nInclude "inside/bed.geo";\n'
    )
    for name in ("part.step", "unused.step"):
        (tmp_path / name).write_text("")
    (inside / "bed.geo").write_text(
        '// Merge "../unused.step";\n'
        '/* Include "../unused.step"; */ a = 1; Include "../part.geo";\n'
        'Merge "../missing.step";\n' + GEO
    )
    geometry = MeshFile(type="file", file="bed.geo")
    assert inputs_elsewhere(geometry, inside) == [
        inside / "../part.geo",
        inside / "../part.step",
    ]
    species = (
        "phases: [{name: gas, thermo: ideal-gas, species: [{FILE/species: [N2]}]}]"
    )
    (inside / "gas.yaml").write_text(species.replace("FILE", "../own.yaml"))
    (tmp_path / "own.yaml").write_text(species.replace("FILE", "nasa_gas.yaml"))
    own = GasCantera(composition="N2:1", mechanism="gas.yaml")
    assert inputs_elsewhere(own, inside) == [inside / "../own.yaml"]
    assert [each.name for each in all_inputs(own, inside)] == [
        "gas.yaml",
        "own.yaml",
        "nasa_gas.yaml",
    ]
    shipped = GasCantera(composition="N2:1", mechanism="methane_pox_on_pt.yaml")
    assert len(all_inputs(shipped, inside)) == 1


def test_aliases_of_a_file_that_a_mechanism_names_are_refused(tmp_path):
    bomb = "a: &a [x, x, x, x, x, x, x, x, x, x]\n"
    for one, other in pairwise("abcdefg"):
        bomb += f"{other}: &{other} [{', '.join([f'*{one}'] * 10)}]\n"
    (tmp_path / "bomb.yaml").write_text(bomb)
    (tmp_path / "gas.yaml").write_text(
        "phases: [{name: gas, thermo: ideal-gas, species: [{bomb.yaml/a: all}]}]"
    )
    keys = {"gas": GAS | {"mechanism": "gas.yaml"}}
    refused(
        r"gas\.mechanism.*bomb\.yaml: aliases of aliases multiply",
        lambda: from_dict(packed(**keys), base=tmp_path),
    )


GAS = {"composition": "N2:1", "pressure": 101325.0}


@pytest.mark.parametrize("keys", [
    {"gas": {"mechanism": "FILE"} | GAS},
    {"solids": {"silica": {"diameter": 3e-3, "conductivity": {"file": "FILE"}}}},
    {"closures": {"nusselt": {"file": "FILE"}}},
    {"particles": {"file": "FILE"}, "solids": {"glass": {"conductivity": 1.0}}},
])  # fmt: skip
@pytest.mark.parametrize("name", ["own.csv", "own.yaml"])
def test_what_a_file_of_others_holds_is_not_shown(tmp_path, keys, name):
    """As that of /etc/passwd, when a scene of others names it."""
    (tmp_path / name).write_text("root:secret:0\nuser:secret:1\nsecret;secret\n")
    text = json.dumps(keys).replace("FILE", name)
    scene = json.loads(text) if "particles" in keys else packed(**json.loads(text))
    with pytest.raises(SceneError, match=name.replace(".", r"\.")) as caught:
        plan(from_dict(scene, base=tmp_path, trust=True))
    assert "secret" not in str(caught.value)
