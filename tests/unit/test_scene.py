"""From a TOML text to a scene: values, lines, overrides, hashes and names of
closures.
"""

import json
import math
import pickle
import tomllib
from pathlib import Path

import numpy as np
import pytest

from contbed.closures.binding import bind, bind_dispersion, is_phase
from contbed.explain import catalogue, sheets
from contbed.loading import from_dict, load, loads
from contbed.packed_bed.scene import Dispersion
from contbed.scene import schema
from contbed.scene.identity import resolved, scene_hash
from contbed.scene.tables import Closure
from contbed.scene.toml_lines import dotted, key_lines, parse_key
from tests.refusals import problems_of, refused

FLOW = """\
[mesh]
type = "line"
length = 2
[gas]
density = 1
viscosity = "0.02 cP"
[packed_bed]
porosity = 0.4
[solids.sand]
diameter = "3 mm"
[boundary.left]
gas.velocity = "10 cm/s"
"""
HEAT = (
    FLOW.replace("[gas]", "[gas]\nheat_capacity = 1000\nconductivity = 0.03")
    .replace(
        "[solids.sand]",
        "[solids.sand]\ndensity = 2500\nheat_capacity = [800, 0.1]\nconductivity = 1",
    )
    .replace("[packed_bed]", "[packed_bed]\nreynolds = 50")
    + """\
gas.temperature = "100 degC"
[heat]
[closures]
nusselt = { name = "gunn", exponent_Pr = 0.33 }
"""
)


def test_values_are_si_and_defaults_come_from_the_schema():
    scene = loads(HEAT)
    assert scene.gas.model == "constant"
    assert scene.gas.viscosity == pytest.approx(2e-5, rel=1e-14)
    assert scene.diameter == 0.003
    assert scene.boundary["left"].gas.velocity == pytest.approx(0.1, rel=1e-14)
    assert scene.boundary["left"].gas.temperature == 373.15
    assert scene.packed_bed.reynolds == 50.0
    assert isinstance(scene.packed_bed.reynolds, float)
    assert scene.solid.heat_capacity == (800.0, 0.1)
    assert scene.time is None
    assert scene.solver.degree == 2


def test_a_number_with_a_unit_is_not_taken_for_the_name_of_a_closure():
    scene = loads(FLOW + '[closures]\npermeability = "1 mm^2"\n')
    assert scene.closures.permeability == pytest.approx(1e-6, rel=1e-14)


def test_dispersion_is_two_numbers_or_a_closure():
    for text, value in [
        ("{ axial = 1 }", Dispersion(axial=1)),
        ('"vdi"', "vdi"),
        ('{ name = "vdi", D_bed = 0.1 }', Closure(name="vdi", D_bed=0.1)),
    ]:
        if text == '"vdi"':
            refused("diameter of the bed", loads, HEAT + f"dispersion = {text}\n")
        else:
            assert loads(HEAT + f"dispersion = {text}\n").closures.dispersion == value


def test_a_scene_knows_the_folder_of_its_mesh_file_from_anywhere(tmp_path, monkeypatch):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "bed.msh").write_text("a mesh")
    file = tmp_path / "sub" / "scene.toml"
    file.write_text(
        FLOW.replace(
            'type = "line"\nlength = 2', 'type = "file"\nfile = "bed.msh"'
        ).replace('"10 cm/s"', '["10 cm/s", 0]')
    )
    monkeypatch.chdir(tmp_path)
    scene = load("sub/scene.toml")
    monkeypatch.chdir("/")
    assert scene.mesh.file == "bed.msh"
    assert (scene.origin.base / scene.mesh.file).read_text() == "a mesh"
    before = scene_hash(scene)
    (tmp_path / "sub" / "bed.msh").write_text("another mesh")
    assert scene_hash(scene) != before


@pytest.mark.parametrize("key", ["origin", "_origin", "base"])
def test_the_origin_cannot_be_set_in_a_scene(key):
    refused("unknown key", loads, f"{key} = 1\n{FLOW}")


def test_resolved_is_json_and_gives_the_same_scene_back():
    scene = loads(HEAT)
    values = json.loads(json.dumps(resolved(scene)))
    again = from_dict(values)
    assert again == scene
    assert scene_hash(again) == scene_hash(scene)
    assert (
        pickle.loads(pickle.dumps(scene)).origin.at(("packed_bed", "porosity"))
        == "scene.toml:11"
    )


def test_the_hash_follows_the_values_and_not_their_spelling():
    base = scene_hash(loads(FLOW))
    other = FLOW.replace('"3 mm"', "3e-3").replace("length = 2", "length = 2.0")
    assert scene_hash(loads(f'title = "x"\n{other}')) == base
    assert scene_hash(loads(FLOW.replace("0.4", "0.41"))) != base


def test_a_scene_does_not_change():
    with pytest.raises(ValueError, match="frozen"):
        loads(FLOW).packed_bed.porosity = 0.5


def test_overrides_replace_and_create():
    scene = loads(
        FLOW,
        overrides={
            "mesh.refine": np.int64(2),
            "solver.degree": 3,
            "packed_bed.porosity": np.float64(0.5),
        },
    )
    assert (scene.mesh.refine, scene.solver.degree, scene.packed_bed.porosity) == (
        2,
        3,
        0.5,
    )


def test_mistakes_in_overrides_say_so():
    wrong = {
        "packed_bed.porosity": 2,
        "solver.degre": 1,
        "mesh.length.x": 1,
        "a..b": 1,
        "boundary.left.gas.velocity": [1, 2],
    }
    problems = "\n".join(problems_of(loads, FLOW, overrides=wrong))
    assert "override: packed_bed.porosity = 2: out of range" in problems
    assert "override: solver.degre = 1: unknown key" in problems
    assert "override: mesh.length.x: cannot be set" in problems
    assert 'override: "a..b" = 1: unknown key' in problems
    assert "override: boundary.left.gas.velocity = [1, 2]: has 2 components" in problems


def test_flow_alone_and_transverse_flow_are_scenes():
    assert loads(FLOW).heat is None
    box = 'type = "rectangle"\nheight = 1\nlength = 2'
    outlet = '[boundary.top]\ntype = "outlet"\n[boundary.right]\ntype = "no_slip"\n'
    assert (
        loads(FLOW.replace('type = "line"\nlength = 2', box) + outlet)
        .boundary["top"]
        .type
        == "outlet"
    )
    still = FLOW.replace('"10 cm/s"', "0")
    assert loads(still).boundary["left"].gas.velocity == 0.0


LINES = '''\
title = """a
[not.a.table]
b"""
bed.porosity = 0.4
[mesh]   # [comment]
"type" = 'line # no'
[[item]]
x = 1
[[item]]
x = [1,
  2, # one, two
  { y = 1, z.k = "#]}" },
]
[item.sub]
'quoted "key"' = 1
[a.b]
c = 1
[a]
d.e = \'\'\'
\'\'\'
f = 1979-05-27 07:32:00
'''


def test_every_key_has_its_line():
    lines = key_lines(LINES)
    expected = {
        ("title",): 1, ("bed", "porosity"): 4, ("mesh",): 5, ("mesh", "type"): 6, ("item", 0): 7, ("item", 1): 9,
        ("item", 1, "x"): 10, ("item", 1, "x", 1): 11, ("item", 1, "x", 2, "z", "k"): 12, ("item", 1, "sub"): 14,
        ("item", 1, "sub", 'quoted "key"'): 15, ("a", "b", "c"): 17, ("a",): 18, ("a", "d", "e"): 19, ("a", "f"): 21,
    }  # fmt: skip
    assert {path: lines[path] for path in expected} == expected

    def paths(value, path=()):
        yield path
        items = (
            value.items()
            if isinstance(value, dict)
            else enumerate(value)
            if isinstance(value, list)
            else ()
        )
        for key, inner in items:
            yield from paths(inner, (*path, key))

    assert set(paths(tomllib.loads(LINES))) - {()} == set(lines)


def test_dotted_keys():
    for text, path in [
        ("a.b", ("a", "b")),
        ('a."b c".d', ("a", "b c", "d")),
        ("'x.y'", ("x.y",)),
    ]:
        assert parse_key(text) == path
        assert parse_key(dotted(path)) == path
    for text in ("", "a.", ".a", "a..b", "a b", "a.[b]", '"a'):
        with pytest.raises(ValueError, match="not a dotted key"):
            parse_key(text)


def test_closures_are_found_with_and_without_their_kind():
    known = {"Re": 10.0, "Pr": 0.7, "eps": 0.4}
    for spec in ("gunn", "nusselt_gunn", Closure(name="gunn", exponent_Pr=0.33)):
        closure = bind(spec, "nusselt", known)
        assert closure.name == "nusselt_gunn"
        assert math.isfinite(closure(**known))
    axial, transverse = bind_dispersion(
        Closure(name="vdi", D_bed=0.1), ("Pe", "k_fluid", "d_p")
    )
    assert (axial.name, transverse.name) == (
        "dispersion_vdi_axial",
        "dispersion_vdi_transverse",
    )
    assert axial.parameters == {}
    assert transverse.parameters == {"D_bed": 0.1}
    refused("of kind 'wall'", bind, "wall_li_finlayson", "nusselt", known)
    assert (
        is_phase("phase")
        and is_phase(Closure(name="conductivity_phase"))
        and not is_phase("hsu")
    )


def test_the_schema_knows_units():
    for key, unit in {
        "solids.sand.diameter": "m",
        "boundary.left.gas.velocity": "m/s",
        "packed_bed.porosity": "1",
        "boundary.left.gas.temperature": "K",
        "mesh.length": "m",
        "solids.sand.conductivity": "W/m/K",
        "gas.T_range": "K",
        "output.positions": "m",
        "closures.dispersion.axial": "W/m/K",
        "mesh.type": None,
        "no.such": None,
    }.items():
        assert sheets.unit(parse_key(key)) == unit, key


def test_every_key_of_the_schema_explains_itself():
    for table in catalogue.tables():
        assert f"[{table}]" in sheets.explain(table)
        for node in sheets.at(tuple(table.split("."))):
            for key in schema.keys(node):
                assert sheets.explain(f"{table}.{key}")


def test_text_and_file_give_the_same(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_bytes(HEAT.replace("\n", "\r\n").encode("utf-8-sig"))
    assert load(path) == load(str(path)) == loads(HEAT)
    assert load(path).origin.base == Path(tmp_path)


def test_former_keys_name_the_present_ones():
    """One line for each, at the key's own line, and nothing about the key that seems
    to be missing.
    """
    (line,) = problems_of(lambda: loads(FLOW + '[boundary.right]\nflow = "outlet"\n'))
    assert line.endswith(
        "boundary.right.flow = \"outlet\": this key is called 'boundary.right.type' now"
    )
    text = (Path(__file__).parents[2] / "studies/two_fluid_checks/slip.toml").read_text(
        encoding="utf-8"
    )
    whole, line = problems_of(
        lambda: loads(
            text.replace('model = "two_fluid"', "")
            .replace("solids.beads]", "solid]")
            .replace("diam", "particle_diam")
        )
    )
    assert "solid: this key is called 'solids.NAME' now" in whole
    assert (
        "solid.particle_diameter" in line
        and "is called 'solids.NAME.diameter' now" in line
    )
