"""What goes wrong in real scenes: every mistake is a line that says where it stands and what to do."""

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

GOOD = """\
title = "counterflow"

[mesh]
type = "axisymmetric"
length = 1.0
radius = "50 mm"

[fluid]
density = 0.6
viscosity = 3e-5
heat_capacity = 1100
conductivity = 0.05

[solid]
density = 2500
heat_capacity = 900
conductivity = [1.0, 1e-3]

[bed]
porosity = 0.4
particle_diameter = "3 mm"

[flow]
velocity = 0.5
velocity_solid = -0.001

[heat]
nusselt = "gunn"
dispersion = "wakao_kaguei"

[boundary.bottom]
fluid = { inflow = "400 degC" }

[boundary.top]
solid = { inflow = "25 degC" }

[boundary.wall]
fluid = { coefficient = "li_finlayson", ambient = 300 }
"""
TIME = "[time]\nend = 10\ninitial_fluid = 300\ninitial_solid = 300\n"
COOLPROP = 'model = "coolprop"\nname = "Air"\nT_range = [300, 700]\n[solid]\n'
CONSTANT = GOOD[GOOD.index("density = 0.6") : GOOD.index("density = 2500")]
NO_EXCHANGE = "nusselt = 0\n[boundary.bottom.fluid]\ninflow = 300\n[boundary.top.solid]\nflux = 0\n"
BOTTOM = "[boundary.bottom]\n"
RADIATION = "[radiation]\nemissivity = 0.8\n" + BOTTOM
SPECIES = "[radiation.species.char]\nvolume_fraction = 0.3\ndiameter = 0.001\nemissivity = 0.8\n"
SIEVES = "sieves = { apertures = [1e-3, 2e-3], mass_fractions = [1.0] }\n"
SIEVED = SPECIES.replace("diameter = 0.001\n", SIEVES)
LINE = 'type = "line"\nlength = 1.0\n'
AXISYMMETRIC = 'type = "axisymmetric"\nlength = 1.0\nradius = "50 mm"\n'

# name, text of GOOD, what stands there instead, parts of one of the problems; the first has the line
CASES = [
    # the file
    ("no equals sign", "density = 0.6", "density 0.6", [":9: not valid TOML: expected '='"]),
    ("no value", "density = 0.6", "density =", [":9: not valid TOML: invalid value"]),
    ("decimal comma", "density = 0.6", "density = 0,6", [":9: not valid TOML"]),
    ("unit without quotes", '"50 mm"', "50 mm", [":6: not valid TOML"]),
    ("open string", '"50 mm"', '"50 mm', [":6: not valid TOML"]),
    ("key twice", "density = 0.6", "density = 0.6\ndensity = 0.7", [":10: not valid TOML: this key stands twice"]),
    ("table twice", "[solid]", "[mesh]", [":14: not valid TOML: cannot declare ('mesh',) twice"]),
    ("number too long", "0.6", "9" * 5000, [":9: an integer with more than 4300 digits"]),
    ("nested too deeply", "0.6", "[" * 5000 + "]" * 5000, [":1: arrays or tables are nested too deeply"]),
    # names of tables and keys
    ("table misspelt", "[heat]", "[het]", [":27: het: unknown key", "did you mean 'heat'?"]),
    (
        "table unknown",
        "[flow]",
        "[dem]\nn = 1\n[flow]",
        [":23: dem: unknown key", "allowed: title, model, mesh, fluid"],
    ),
    ("key misspelt", "porosity", "porosty", [":20: bed.porosty = 0.4: unknown key", "did you mean 'porosity'?"]),
    ("key in capitals", "porosity", "Porosity", [":20: bed.Porosity = 0.4: unknown key", "did you mean 'porosity'?"]),
    ("key of another mesh", "radius", "height", [":6: mesh.height", "unknown key", "allowed: type, length, radius"]),
    ("key in an inline table", "inflow", "infow", [":32: boundary.bottom.fluid.infow", "did you mean 'inflow'?"]),
    ("key with a line break", "porosity", '"a\\nb"', [':20: bed."a\\nb" = 0.4: unknown key']),
    ("key missing", "porosity = 0.4\n", "", [":19: bed.porosity: missing; allowed: a number > 0 and < 1"]),
    ("table missing", "[bed]\nporosity = 0.4\nparticle_diameter", "[output]\nx", [":1: bed: this table is missing"]),
    ("value for a table", "title", "solver = 3\ntitle", [":1: solver = 3: wrong kind of value; allowed: a table with"]),
    ("list for a table", "[heat]", "[[heat]]", [":27: heat", "wrong kind of value; allowed: a table with nusselt"]),
    # single values
    ("out of range", "0.4", "1.4", [":20: bed.porosity = 1.4: out of range; allowed: a number > 0 and < 1"]),
    ("range with a unit", '"3 mm"', "0", [":21: bed.particle_diameter = 0: out of range; allowed: a number > 0 m"]),
    ("negative with a unit", '"3 mm"', '"-3 mm"', [':21: bed.particle_diameter = "-3 mm": out of range', "> 0 m"]),
    ("nan", "0.4", "nan", [":20: bed.porosity = NaN: not a finite number"]),
    (
        "inf",
        "length = 1.0",
        "length = inf",
        [":5: mesh.length = Infinity: not a finite number; allowed: a number > 0 m"],
    ),
    ("inf in a list", "velocity = 0.5", "velocity = [0, inf]", [":24: flow.velocity[1]", "not a finite number"]),
    ("true for a number", "0.4", "true", [":20: bed.porosity = true: expected a number, found true"]),
    ("true for a whole number", "[bed]", "[solver]\ndegree = true\n[bed]", [":20: solver.degree = true: expected a"]),
    ("one for true", "[bed]", "[solver]\nreduce = 1\n[bed]", [":20: solver.reduce = 1", "allowed: true or false"]),
    ("fraction for a whole number", "radius", "refine = 1.5\nradius", [":6: mesh.refine = 1.5", "an integer >= 0"]),
    ("text for a number", "0.4", '"loose"', [":20: bed.porosity = \"loose\": expected a plain number, found 'loose'"]),
    ("list for a number", "0.4", "[0.4]", [":20: bed.porosity", "wrong kind of value; allowed: a number > 0 and < 1"]),
    ("date for a number", "0.4", "2024-01-01", [':20: bed.porosity = "2024-01-01"', "wrong kind of value"]),
    ("number beyond floats", "0.6", "1" + "0" * 400, [":9: fluid.density = 1000", "wrong kind of value"]),
    ("wrong choice", '"axisymmetric"', '"lines"', [':4: mesh.type = "lines": unknown choice', "did you mean 'line'?"]),
    ("no choice", 'type = "axisymmetric"\n', "", [":3: mesh.type: missing; allowed: 'axisymmetric', 'box'"]),
    ("choice of a key", "[solid]", "model = 3\n[solid]", [":14: fluid.model = 3: unknown choice; allowed: cantera"]),
    ("degree", "[bed]", "[solver]\ndegree = 4\n[bed]", [":20: solver.degree = 4: unknown choice; allowed: 1, 2, 3"]),
    ("cells for each direction", "radius", "cells = [4]\nradius", [":6: mesh.cells[1]: missing"]),
    ("polynomial without terms", "[1.0, 1e-3]", "[]", [":17: solid.conductivity = []: empty; allowed: a list"]),
    ("no computer squares it", "[1.0, 1e-3]", "[1.0, 1e200]", [":17: solid.conductivity[1] = 1e+200:", "no size"]),
    ("nothing is that small", "[1.0, 1e-3]", '"1e-200 W/m/K"', [":17: solid.conductivity", "0, or from 1e-50"]),
    # units
    ("wrong dimension", '"3 mm"', '"3 kg"', [":21: bed.particle_diameter", "expected a length like 'm', found '3 kg'"]),
    ("no unit", '"3 mm"', '"3"', [":21: bed.particle_diameter", "without a unit; write 3 for SI, or '3 m'"]),
    ("unknown unit", '"3 mm"', '"3 quux"', [":21: bed.particle_diameter", "unknown unit 'quux'"]),
    (
        "unit twice",
        '"3 mm"',
        '"3 mm mm"',
        [":21: bed.particle_diameter", "expected a length like 'm', found '3 mm mm'"],
    ),
    ("coulomb for celsius", '"400 degC"', '"400 C"', [":32: boundary.bottom.fluid.inflow", "Celsius are 'degC'"]),
    ("below zero kelvin", '"25 degC"', '"-300 degC"', [":35: boundary.top.solid.inflow", "out of range", "> 0 K"]),
    ("comma in a quantity", '"50 mm"', '"5,0 mm"', [":6: mesh.radius", "the decimal sign is a point"]),
    ("volume flow for a velocity", "velocity = 0.5", 'velocity = "2 L/min"', [":24: flow.velocity", "'2 L/min'"]),
    # closures
    ("closure misspelt", '"gunn"', '"gun"', [":28: heat.nusselt", "unknown nusselt closure", "nearest: nusselt_gunn"]),
    ("closure of another kind", '"gunn"', '"wall_li_finlayson"', [":28: heat.nusselt", "is of kind 'wall'"]),
    ("closure without a name", '"gunn"', "{ Nu = 2 }", [":28: heat.nusselt.name: missing"]),
    ("closure's parameter", '"gunn"', '{ name = "gunn", n = 1 }', [":28: heat.nusselt", "no parameter 'n'"]),
    ("parameter's value", '"gunn"', '{ name = "gunn", exponent_Pr = true }', [":28: heat.nusselt", "a finite number"]),
    ("parameter missing", '"gunn"', '"power"', [":28: heat.nusselt", "closure 'power' needs a, b"]),
    (
        "phase with parameters",
        '"gunn"',
        '2\nconductivity_solid = { name = "phase", x = 1 }',
        [":29: heat.", "no parameters"],
    ),
    ("negative for a closure", '"gunn"', "-1", [":28: heat.nusselt = -1: out of range; allowed: a number >= 0"]),
    ("dispersion's keys", '"wakao_kaguei"', "{ axial = 1, trans = 2 }", [":29: heat.dispersion.trans", "'transverse'"]),
    ("dispersion misspelt", "wakao_kaguei", "wakao", [":29: heat.dispersion", "nearest: dispersion_wakao_kaguei"]),
    # contradictions and gaps
    ("heat without solid", GOOD[GOOD.index("[solid]") : GOOD.index("[bed]")], "", [":22: heat: needs a [solid] table"]),
    (
        "heat without properties",
        "heat_capacity = 1100\n",
        "",
        [":8: fluid.heat_capacity: missing; a scene with [heat]"],
    ),
    (
        "time without heat",
        '[heat]\nnusselt = "gunn"\ndispersion = "wakao_kaguei"\n',
        TIME,
        [":27: time: needs a [heat]"],
    ),
    ("components", "velocity = 0.5", "velocity = [0, 0, 1]", [":24: flow.velocity", "3 components", "scene.toml:4"]),
    ("radial velocity", "velocity = 0.5", "velocity = [1, 1]", [":24: flow.velocity", "radial velocity is 0"]),
    ("boundary misspelt", "[boundary.wall]", "[boundary.walls]", [":37: boundary.walls", "did you mean 'wall'?"]),
    ("boundary of another mesh", "boundary.wall", "boundary.left", [":37: boundary.left", "it has wall, bottom, top"]),
    ("condition on the axis", "boundary.wall", "boundary.axis", [":37: boundary.axis", "line of symmetry"]),
    ("region misspelt", "[heat]", "[region.core]\n[heat]", [":27: region.core", "one region, 'bed'"]),
    (
        "unit forgotten",
        '"3 mm"',
        "3",
        [":21: bed.particle_diameter = 3", "mesh.length (scene.toml:5)", "unit missing?"],
    ),
    ("inflow where it leaves", "velocity = 0.5", "velocity = -0.5", [":32: boundary.bottom.fluid.inflow", "toml:24"]),
    (
        "entering without a temperature",
        "velocity = 0.5",
        "velocity = -0.5",
        [":34: boundary.top.fluid: the fluid enters"],
    ),
    ("inflow without velocity", "velocity = 0.5", "velocity = 0", [":32: boundary.bottom.fluid.inflow", "use fixed"]),
    (
        "inflow at a wall",
        'coefficient = "li_finlayson", ambient',
        "inflow",
        [":38: boundary.wall.fluid", "no fluid enters"],
    ),
    (
        "two conditions",
        'inflow = "25 degC"',
        "inflow = 300, flux = 1",
        [":35: boundary.top.solid", "found inflow, flux"],
    ),
    ("no condition", 'inflow = "25 degC"', "", [":35: boundary.top.solid", "found none"]),
    (
        "coefficient alone",
        ", ambient = 300",
        "",
        [":38: boundary.wall.fluid", "coefficient and ambient belong together"],
    ),
    ("nothing leaves", "[boundary.top]", '[boundary.top]\ntype = "slip"', [":35: boundary.top.type", "cannot leave"]),
    (
        "inlet at the outlet",
        "[boundary.top]",
        '[boundary.top]\ntype = "inlet"',
        [":35: boundary.top.type", "not enter"],
    ),
    ("outlet at the inlet", "[boundary.bottom]", '[boundary.bottom]\ntype = "outlet"', [":32: boundary.bottom.type"]),
    (
        "undetermined",
        GOOD[GOOD.index("velocity = 0.5") :],
        "velocity = 0\n[heat]\nnusselt = 2\n",
        [":25: heat", "undetermined"],
    ),
    (
        "no exchange",
        'nusselt = "gunn"' + GOOD.partition('gunn"')[2],
        NO_EXCHANGE,
        [":27: heat: the steady", "of the solid is"],
    ),
    ("times after the end", "[heat]", TIME + "times = [1, 11]\n[heat]", [":31: time.times[1] = 11", "scene.toml:28"]),
    ("step after the end", "[heat]", TIME + "step = 11\n[heat]", [":31: time.step = 11", "time.end (scene.toml:28)"]),
    ("step and tolerance", "[heat]", TIME + "step = 1\ntolerance = 0.1\n[heat]", [":32: time.tolerance", "toml:31"]),
    (
        "position outside",
        "[heat]",
        "[output]\npositions = [0, 2]\n[heat]",
        [":28: output.positions[1] = 2", "0 to 1 m"],
    ),
    ("negative property", "[1.0, 1e-3]", "[1.0, -1e-2]", [":17: solid.conductivity", "is -5.731 at boundary.bottom"]),
    ("fluid table upside down", CONSTANT, COOLPROP.replace("300", "900"), [":11: fluid.T_range", "lower temperature"]),
    ("outside of the fluid table", CONSTANT, COOLPROP.replace("300", "350"), [":36: boundary.wall.fluid.ambient"]),
    (
        "composition",
        CONSTANT,
        'model = "cantera"\ncomposition = "N2:a"\n[solid]\n',
        [":10: fluid.composition", "must be a number"],
    ),
    ("mesh file missing", AXISYMMETRIC, 'type = "file"\nfile = "no.msh"\n', [':5: mesh.file = "no.msh": no such file']),
    ("mesh file of another kind", AXISYMMETRIC, 'type = "file"\nfile = "a.stl"\n', [":5: mesh.file", "neither"]),
    # radiation
    (
        "radiation: level",
        BOTTOM,
        RADIATION.replace("emissivity", 'level = "p3"\nemissivity'),
        [":32: radiation.level", "allowed: p1"],
    ),
    (
        "radiation: black holes",
        BOTTOM,
        RADIATION.replace("0.8", "0"),
        [":32: radiation.emissivity = 0: out of range", "> 0 and <= 1"],
    ),
    (
        "radiation: brighter than black",
        BOTTOM,
        RADIATION.replace("0.8", "1.1"),
        [":32: radiation.emissivity = 1.1: out of range"],
    ),
    (
        "radiation: no optics",
        BOTTOM,
        RADIATION.replace("emissivity = 0.8\n", ""),
        [":31: radiation: give the optics once", "none"],
    ),
    (
        "radiation: optics twice",
        BOTTOM,
        RADIATION.replace(BOTTOM, SPECIES + BOTTOM),
        [":31: radiation: give the optics once", "emissivity, species"],
    ),
    (
        "radiation: transparent",
        BOTTOM,
        RADIATION.replace("emissivity = 0.8", "absorption = 0"),
        [":31: radiation: nothing stops a ray"],
    ),
    (
        "radiation: forward only",
        BOTTOM,
        RADIATION.replace("emissivity = 0.8", "scattering = 9\nanisotropy = 1"),
        [":31: radiation: nothing"],
    ),
    (
        "radiation: negative scattering",
        BOTTOM,
        RADIATION.replace("emissivity = 0.8", "scattering = -9"),
        [":32: radiation.scattering", ">= 0"],
    ),
    (
        "radiation: two-flux in a plane",
        BOTTOM,
        RADIATION.replace("emissivity", 'level = "two_flux"\nemissivity'),
        [":32: radiation.level", "a line", "toml:4"],
    ),
    (
        "radiation: ordinates with heat",
        BOTTOM,
        RADIATION.replace("emissivity", 'level = "ordinates"\nemissivity'),
        [":32: radiation.level", "alone"],
    ),
    (
        "radiation: temperature with heat",
        BOTTOM,
        RADIATION.replace("0.8", "0.8\ntemperature = 900"),
        [":33: radiation.temperature", "[heat]"],
    ),
    (
        "radiation: conductivity with heat",
        BOTTOM,
        RADIATION.replace("0.8", "0.8\nconductivity = 1"),
        [":33: radiation.conductivity", "[heat]"],
    ),
    (
        "radiation: boundary alone",
        BOTTOM,
        BOTTOM + "radiation = { temperature = 900 }\n",
        [":32: boundary.bottom.radiation", "without a [radiation]"],
    ),
    (
        "radiation: wall and opening",
        BOTTOM,
        RADIATION + "radiation = { temperature = 900, radiosity = 1 }\n",
        [":34: boundary.bottom.radiation", "one of temperature, radiosity"],
    ),
    (
        "radiation: wall of no temperature",
        BOTTOM,
        RADIATION + "radiation = { emissivity = 0.5 }\n",
        [":34: boundary.bottom.radiation", "one of"],
    ),
    (
        "radiation: negative radiosity",
        BOTTOM,
        RADIATION + "radiation = { radiosity = -1 }\n",
        [":34: boundary.bottom.radiation.radiosity", ">= 0"],
    ),
    (
        "radiation: wall's emissivity",
        BOTTOM,
        RADIATION + "radiation = { temperature = 900, emissivity = 2 }\n",
        [":34: boundary.bottom.radiation.emissivity"],
    ),
    (
        "radiation: rosseland and a loose wall",
        BOTTOM,
        RADIATION.replace("emiss", 'level = "rosseland"\nemiss') + "radiation = { temperature = 900 }\n",
        [":35: boundary.bottom.radiation", "fix it"],
    ),
    (
        "radiation: no room for gas",
        BOTTOM,
        SPECIES.replace("0.3", "1.0") + BOTTOM,
        [":32: radiation.species.char.volume_fraction = 1.0: out of range"],
    ),
    (
        "radiation: too many particles",
        BOTTOM,
        SPECIES + SPECIES.replace("char", "ash").replace("0.3", "0.7") + BOTTOM,
        ["radiation.species: the volume fractions sum to 1"],
    ),
    (
        "radiation: two sizes",
        BOTTOM,
        SPECIES.replace("diameter", SIEVES + "diameter") + BOTTOM,
        [":31: radiation.species.char: give one of diameter, sieves"],
    ),
    (
        "radiation: no size",
        BOTTOM,
        SPECIES.replace("diameter = 0.001\n", "") + BOTTOM,
        [":31: radiation.species.char: give one of diameter, sieves"],
    ),
    (
        "radiation: sieve counts",
        BOTTOM,
        SIEVED.replace("[1.0]", "[0.5, 0.5]") + BOTTOM,
        [":33: radiation.species.char.sieves", "2 classes lie between 3 apertures, got 2"],
    ),
    (
        "radiation: sieves upside down",
        BOTTOM,
        SIEVED.replace("1e-3, 2e-3", "2e-3, 1e-3") + BOTTOM,
        [":33: radiation.species.char.sieves", "must increase"],
    ),
    (
        "radiation: sieved twice",
        BOTTOM,
        SIEVED.replace("[1.0]", "[1.2]") + BOTTOM,
        [":33: radiation.species.char.sieves", "mass fraction"],
    ),
    ("diameter on a line", AXISYMMETRIC, LINE + "\n", [":38: boundary.wall.fluid.coefficient", "D_bed = ..."]),
]


@pytest.mark.parametrize(("old", "new", "parts"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_each_mistake_is_one_clear_line(old, new, parts):
    assert GOOD.count(old) >= 1
    with pytest.raises(SceneError) as error:
        loads(GOOD.replace(old, new, 1))
    lines = error.value.problems
    assert any(all(part in line for part in parts) for line in lines), "\n".join(lines)
    assert all(line.startswith("scene.toml:") and "\n" not in line for line in lines)
    assert len(lines) <= 8


def test_the_scene_without_mistakes_is_a_scene():
    assert isinstance(loads(GOOD), Scene)


def test_all_mistakes_of_a_file_are_told_at_once_in_the_order_of_the_file():
    text = GOOD.replace("0.4", "40").replace('"gunn"', '"gun"').replace("radius", "raduis").replace('"50 mm"', '"5 kg"')
    text = text.replace("[boundary.wall]", "[boundary.wal]").replace("[flow]", "[flow]\nswirl = 1")
    with pytest.raises(SceneError) as error:
        loads(text)
    lines = [int(line.split(":")[1]) for line in error.value.problems]
    assert lines == sorted(lines)
    assert {6, 20, 24} <= set(lines)


@pytest.mark.parametrize(
    ("old", "new"), [("[heat]", "[het]"), ("[solid]", "[sold]"), ("0.4", "4"), ('"gunn"', '"gun"')]
)
def test_one_mistake_is_told_once_without_what_follows_from_it(old, new):
    with pytest.raises(SceneError) as error:
        loads(GOOD.replace(old, new, 1))
    assert len(error.value.problems) == 1


def test_contradictions_are_told_beside_wrong_values():
    text = GOOD.replace("0.4", "40").replace("[boundary.wall]", "[boundary.wal]").replace('"gunn"', '"hsu"')
    with pytest.raises(SceneError) as error:
        loads(text)
    assert ["bed.porosity" in line for line in error.value.problems].count(True) == 1
    assert any("boundary.wal:" in line for line in error.value.problems)


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
    with pytest.raises(SceneError) as error:
        load(path)
    assert any(str(path) + part in line for line in error.value.problems), error.value.problems
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            'scene = "bed.toml"\n[parameters]\nflow.velocity = [1, 2]',
            ":2: parameters: .* a study; run it with `contbed sweep",
        ),
        ('scene = "bed.toml"\nminimise = "duty_W"', ":2: minimise: .* a study; run it with `contbed optimise FILE`"),
        ('format = 1\nkind = "nusselt"', ":1: format: this is no scene but a closure; name it in one"),
    ],
)
def test_files_of_other_commands_are_known(tmp_path, text, told):
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(SceneError, match=told):
        load(tmp_path / "study.toml")


def test_paths_that_are_no_file(tmp_path):
    for path, part in [
        (tmp_path / "no.toml", "no such file"),
        (tmp_path, "is a directory"),
        ("a\0b", "cannot be read"),
    ]:
        with pytest.raises(SceneError, match=part):
            load(path)


SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(10**300, 10**310),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(
        ["3 mm", "1e400 m", "-4 K", "gunn", "phase", "hsu", "line", "file", "1 degC/m", "5 (", "2 m^-99999", "1 %"]
    ),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["name", "axial", "fixed", "inflow", "x"]) | st.text(max_size=4), inner, max_size=3
        )
    ),
    max_leaves=5,
)
KEYS = ["title", *(".".join(map(str, path)) for path in key_lines(GOOD) if not isinstance(path[-1], int))]
KEYS += ["time", "time.end", "time.times", "solver.degree", "region.bed", "output.positions", "mesh.cells", "bed.shape"]
KEYS += ["fluid.model", "boundary.wall.type", "heat.conductivity_solid", "heat.tortuosity", "mesh.file", "mesh.refine"]


@settings(max_examples=300)
@given(st.dictionaries(st.sampled_from(sorted(set(KEYS))), VALUES, min_size=1, max_size=4))
def test_any_values_give_a_scene_or_clear_lines(overrides):
    try:
        scene = loads(GOOD, overrides=overrides)
    except SceneError as error:
        assert error.problems
        assert all(line.isprintable() and line.startswith(("scene.toml:", "override: ")) for line in error.problems)
    else:
        assert isinstance(scene, Scene)
        assert 0 < scene.bed.porosity < 1
        assert math.isfinite(scene.mesh.model_dump().get("length", 0.0))


@settings(max_examples=300)
@given(st.integers(0, len(GOOD)), st.integers(0, 12), st.text(string.printable + "\u00e9\u2028", max_size=6))
def test_any_damage_to_the_text_gives_a_scene_or_clear_lines(start, length, insert):
    try:
        scene = loads(GOOD[:start] + insert + GOOD[start + length :])
    except SceneError as error:
        assert all(line.isprintable() and line.startswith("scene.toml:") for line in error.problems)
        count = GOOD.count("\n") + insert.count("\n") + 1
        assert all(1 <= int(line.split(":")[1]) <= count for line in error.problems)
    else:
        assert isinstance(scene, Scene)


def test_a_table_of_another_physics_is_refused_with_a_remedy():
    """Two fluids take no radiation: by line, with the physics that do."""
    scene = (Path(contbed.__file__).parent / "two_fluid" / "template.toml").read_text(encoding="utf-8")
    scene = scene.replace('model = "two_fluid"', "two_fluid = {}")  # a file for one model alone
    line = len(scene.splitlines()) + 1
    with pytest.raises(SceneError, match=rf":{line}: radiation: two fluids exchange heat by .* use .bubbling_bed. or"):
        loads(scene.rstrip("\n") + '\n[radiation]\nlevel = "ordinates"\n')
