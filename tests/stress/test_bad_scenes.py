"""What goes wrong in real scenes: every mistake is a line that says where it stands
and what to do.
"""

import math
import string
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contbed
from contbed.errors import SceneError
from contbed.loading import load, loads
from contbed.packed_bed.scene import Scene
from contbed.scene.toml_lines import key_lines
from tests.cases import cases_of
from tests.refusals import problems_of, refused

GOOD = """\
title = "counterflow"

[mesh]
type = "axisymmetric"
length = 1.0
radius = "50 mm"

[gas]
density = 0.6
viscosity = 3e-5
heat_capacity = 1100
conductivity = 0.05

[solids.sand]
density = 2500
heat_capacity = 900
conductivity = [1.0, 1e-3]
diameter = "3 mm"

[packed_bed]
porosity = 0.4

[closures]
nusselt = "gunn"
dispersion = "wakao_kaguei"

[heat]

[boundary.bottom]
gas = { velocity = 0.5, temperature = "400 degC" }

[boundary.top]
solids.sand = { velocity = 0.001, temperature = "25 degC" }

[boundary.wall]
gas = { coefficient = "li_finlayson", ambient = 300 }
"""

# by name: text of GOOD, what stands there instead, parts of one of the problems
CASES = {
    name: case
    for name, *case in cases_of(__file__, "case", "name", "text", "instead", "parts")
}
NO_FLOAT = [":9: gas.density = 1000", "wrong kind of value"]
CASES |= {
    "number too long": ("0.6", "9" * 5000, [":9: an integer with more than 4300"]),
    "nested too deeply": ("0.6", "[" * 5000 + "]" * 5000, [":1: arrays or tables are"]),
    "number beyond floats": ("0.6", "1" + "0" * 400, NO_FLOAT),
}


@pytest.mark.parametrize(("old", "new", "parts"), CASES.values(), ids=CASES)
def test_each_mistake_is_one_clear_line(old, new, parts):
    assert GOOD.count(old) >= 1
    lines = problems_of(lambda: loads(GOOD.replace(old, new, 1)))
    assert any(all(part in line for part in parts) for line in lines), "\n".join(lines)
    assert all(line.startswith("scene.toml:") and "\n" not in line for line in lines)
    assert len(lines) <= 8


def test_the_scene_without_mistakes_is_a_scene():
    assert isinstance(loads(GOOD), Scene)


def test_all_mistakes_of_a_file_are_told_at_once_in_the_order_of_the_file():
    text = (
        GOOD.replace("0.4", "40")
        .replace('"gunn"', '"gun"')
        .replace("radius", "raduis")
        .replace('"50 mm"', '"5 kg"')
    )
    text = text.replace("[boundary.wall]", "[boundary.wal]").replace(
        "[packed_bed]", "[packed_bed]\nswirl = 1"
    )
    lines = [int(line.split(":")[1]) for line in problems_of(loads, text)]
    assert lines == sorted(lines)
    assert {6, 21, 22} <= set(lines)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[heat]", "[het]"),
        ("[solids.sand]", "[sold.sand]"),
        ("0.4", "4"),
        ('"gunn"', '"gun"'),
    ],
)
def test_one_mistake_is_told_once_without_what_follows_from_it(old, new):
    assert len(problems_of(lambda: loads(GOOD.replace(old, new, 1)))) == 1


def test_contradictions_are_told_beside_wrong_values():
    text = (
        GOOD.replace("0.4", "40")
        .replace("[boundary.wall]", "[boundary.wal]")
        .replace('"gunn"', '"hsu"')
    )
    lines = problems_of(loads, text)
    assert sum("packed_bed.porosity" in line for line in lines) == 1
    assert any("boundary.wal:" in line for line in lines)


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (b"", ":1: the scene is empty"),
        (b"# nothing\n\n", ":1: the scene is empty"),
        (b'\ntitle = "Bl\xe4hton"\n', ":2: not UTF-8 text (byte 0xe4)"),
        (b"\x00\x01\x02", ":1: not valid TOML"),
        (b"[mesh]\r\ntype = 'lin'\r\n", ":2: mesh.type"),
        (b"\xef\xbb\xbf[mesh]\ntype = 'lin'\n", ":2: mesh.type"),
    ],
)
def test_files_that_hold_no_scene(tmp_path, content, part):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    lines = problems_of(load, path)
    assert any(str(path) + part in line for line in lines), lines
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            'scene = "bed.toml"\n[parameters]\nmesh.length = [1, 2]',
            ":2: parameters: .* a study; run it with `contbed sweep",
        ),
        (
            'scene = "bed.toml"\nminimise = "duty_W"',
            ":2: minimise: .* a study; run it with `contbed optimise FILE`",
        ),
        (
            'format = 1\nkind = "nusselt"',
            ":1: format: this is no scene but a closure; name it in one",
        ),
    ],
)
def test_files_of_other_commands_are_known(tmp_path, text, told):
    (tmp_path / "study.toml").write_text(text)
    refused(told, lambda: load(tmp_path / "study.toml"))


def test_paths_that_are_no_file(tmp_path):
    for path, part in [
        (tmp_path / "no.toml", "no such file"),
        (tmp_path, "is a directory"),
        ("a\0b", "cannot be read"),
    ]:
        refused(part, load, path)


SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(10**300, 10**310),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(
        [
            "3 mm",
            "1e400 m",
            "-4 K",
            "gunn",
            "phase",
            "hsu",
            "line",
            "file",
            "1 degC/m",
            "5 (",
            "2 m^-99999",
            "1 %",
        ]
    ),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["name", "axial", "fixed_temperature", "velocity", "x"])
            | st.text(max_size=4),
            inner,
            max_size=3,
        )
    ),
    max_leaves=5,
)
KEYS = [
    "title",
    *(
        ".".join(map(str, path))
        for path in key_lines(GOOD)
        if not isinstance(path[-1], int)
    ),
]
KEYS += [
    "time",
    "time.end",
    "time.times",
    "solver.degree",
    "region.bed",
    "output.positions",
    "mesh.cells",
]
KEYS += [
    "gas.model",
    "boundary.wall.type",
    "closures.conductivity_solids",
    "closures.tortuosity",
    "mesh.file",
]
KEYS += ["solids.sand.shape", "mesh.refine", "fluid.density", "flow.velocity"]


@settings(max_examples=100)
@given(
    st.dictionaries(st.sampled_from(sorted(set(KEYS))), VALUES, min_size=1, max_size=4)
)
def test_any_values_give_a_scene_or_clear_lines(overrides):
    try:
        scene = loads(GOOD, overrides=overrides)
    except SceneError as error:
        assert error.problems
        assert all(
            line.isprintable() and line.startswith(("scene.toml:", "override: "))
            for line in error.problems
        )
    else:
        assert isinstance(scene, Scene)
        assert 0 < scene.packed_bed.porosity < 1
        assert math.isfinite(scene.mesh.model_dump().get("length", 0.0))


@settings(max_examples=100)
@given(
    st.integers(0, len(GOOD)),
    st.integers(0, 12),
    st.text(string.printable + "\u00e9\u2028", max_size=6),
)
def test_any_damage_to_the_text_gives_a_scene_or_clear_lines(start, length, insert):
    try:
        scene = loads(GOOD[:start] + insert + GOOD[start + length :])
    except SceneError as error:
        assert all(
            line.isprintable() and line.startswith("scene.toml:")
            for line in error.problems
        )
        count = GOOD.count("\n") + insert.count("\n") + 1
        assert all(1 <= int(line.split(":")[1]) <= count for line in error.problems)
    else:
        assert isinstance(scene, Scene)


def test_a_table_of_another_physics_is_refused_with_a_remedy():
    """Beds with species take no radiation: by line, with what they take instead."""
    scene = (
        Path(contbed.__file__).parent / "reacting_bed" / "template.toml"
    ).read_text(encoding="utf-8")
    # a file for one model alone
    scene = scene.replace('model = "packed_bed"\n', "")
    line = len(scene.splitlines()) + 1
    refused(
        rf":{line}: radiation: a bed with species takes radiation by its conductivity",
        lambda: loads(scene.rstrip("\n") + '\n[radiation]\nlevel = "ordinates"\n'),
    )
