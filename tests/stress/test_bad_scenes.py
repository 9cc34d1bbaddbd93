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
TIME = "[initial]\ntemperature = 300\n[time]\nend = 10\n"
COOLPROP = 'model = "coolprop"\nname = "Air"\nT_range = [300, 700]\n[solids.sand]\n'
CONSTANT = GOOD[GOOD.index("density = 0.6") : GOOD.index("density = 2500")]
NO_EXCHANGE = """\
nusselt = 0
[heat]
[boundary.bottom.gas]
velocity = 0.5
temperature = 300
[boundary.top.solids.sand]
heat_flux = 0
"""
BOTTOM = "[boundary.bottom]\n"
OPTICS = "absorption = 3\n"
RADIATION = "[radiation]\n" + OPTICS + BOTTOM
CHAR = """\
[radiation]
[solids.char]
volume_share = 0.5
diameter = 0.001
emissivity = 0.8
"""
SIEVES = "sieves = { apertures = [1e-3, 2e-3], mass_fractions = [1.0] }\n"
SIEVED = CHAR.replace("diameter = 0.001\n", SIEVES)
LINE = 'type = "line"\nlength = 1.0\n'
AXISYMMETRIC = 'type = "axisymmetric"\nlength = 1.0\nradius = "50 mm"\n'

# name, text of GOOD, what stands there instead, parts of one of the problems; the first
# has the line
CASES = [
    # the file
    (
        "no equals sign",
        "density = 0.6",
        "density 0.6",
        [":9: not valid TOML: expected '='"],
    ),
    ("no value", "density = 0.6", "density =", [":9: not valid TOML: invalid value"]),
    ("decimal comma", "density = 0.6", "density = 0,6", [":9: not valid TOML"]),
    ("unit without quotes", '"50 mm"', "50 mm", [":6: not valid TOML"]),
    ("open string", '"50 mm"', '"50 mm', [":6: not valid TOML"]),
    (
        "key twice",
        "density = 0.6",
        "density = 0.6\ndensity = 0.7",
        [":10: not valid TOML: this key stands twice"],
    ),
    (
        "table twice",
        "[solids.sand]",
        "[mesh]",
        [":14: not valid TOML: cannot declare ('mesh',) twice"],
    ),
    (
        "number too long",
        "0.6",
        "9" * 5000,
        [":9: an integer with more than 4300 digits"],
    ),
    (
        "nested too deeply",
        "0.6",
        "[" * 5000 + "]" * 5000,
        [":1: arrays or tables are nested too deeply"],
    ),
    # names of tables and keys
    (
        "table misspelt",
        "[heat]",
        "[het]",
        [":27: het: unknown key", "did you mean 'heat'?"],
    ),
    (
        "table unknown",
        "[closures]",
        "[dem]\nn = 1\n[closures]",
        [":23: dem: unknown key", "allowed: title, model, mesh, gas"],
    ),
    (
        "key misspelt",
        "porosity",
        "porosty",
        [":21: packed_bed.porosty = 0.4: unknown key", "did you mean 'porosity'?"],
    ),
    (
        "key in capitals",
        "porosity",
        "Porosity",
        [":21: packed_bed.Porosity = 0.4: unknown key", "did you mean 'porosity'?"],
    ),
    (
        "key of another mesh",
        "radius",
        "height",
        [":6: mesh.height", "unknown key", "allowed: type, length, graded"],
    ),
    (
        "key in an inline table",
        "velocity",
        "velosity",
        [":30: boundary.bottom.gas.velosity", "did you mean 'velocity'?"],
    ),
    (
        "key with a line break",
        "porosity",
        '"a\\nb"',
        [':21: packed_bed."a\\nb" = 0.4: unknown key'],
    ),
    (
        "key missing",
        "porosity = 0.4\n",
        "",
        [":20: packed_bed.porosity: missing; allowed: a number > 0 and < 1"],
    ),
    (
        "table missing",
        "[packed_bed]\nporosity = 0.4\n",
        "",
        [":1: packed_bed: this table is missing"],
    ),
    (
        "value for a table",
        "title",
        "solver = 3\ntitle",
        [":1: solver = 3: wrong kind of value; allowed: a table with"],
    ),
    (
        "list for a table",
        "[heat]",
        "[[heat]]",
        [":27: heat", "wrong kind of value; allowed: a table"],
    ),
    # single values
    (
        "out of range",
        "0.4",
        "1.4",
        [":21: packed_bed.porosity = 1.4: out of range; allowed: a number > 0 and < 1"],
    ),
    (
        "range with a unit",
        '"3 mm"',
        "0",
        [":18: solids.sand.diameter = 0: out of range; allowed: a number > 0 m"],
    ),
    (
        "negative with a unit",
        '"3 mm"',
        '"-3 mm"',
        [':18: solids.sand.diameter = "-3 mm": out of range', "> 0 m"],
    ),
    ("nan", "0.4", "nan", [":21: packed_bed.porosity = NaN: not a finite number"]),
    (
        "inf",
        "length = 1.0",
        "length = inf",
        [":5: mesh.length = Infinity: not a finite number; allowed: a number > 0 m"],
    ),
    (
        "inf in a list",
        "velocity = 0.5",
        "velocity = [0, inf]",
        [":30: boundary.bottom.gas.velocity[1]", "not a finite number"],
    ),
    (
        "true for a number",
        "0.4",
        "true",
        [":21: packed_bed.porosity = true: expected a number, found true"],
    ),
    (
        "true for a whole number",
        "[packed_bed]",
        "[solver]\ndegree = true\n[packed_bed]",
        [":21: solver.degree = true: expected a"],
    ),
    (
        "one for true",
        "[packed_bed]",
        "[solver]\nreduce = 1\n[packed_bed]",
        [":21: solver.reduce = 1", "allowed: true or false"],
    ),
    (
        "fraction for a whole number",
        "radius",
        "refine = 1.5\nradius",
        [":6: mesh.refine = 1.5", "an integer >= 0"],
    ),
    (
        "text for a number",
        "0.4",
        '"loose"',
        [
            ':21: packed_bed.porosity = "loose": expected a plain number, found '
            "'loose'"
        ],
    ),
    (
        "list for a number",
        "0.4",
        "[0.4]",
        [
            ":21: packed_bed.porosity",
            "wrong kind of value; allowed: a number > 0 and < 1",
        ],
    ),
    (
        "date for a number",
        "0.4",
        "2024-01-01",
        [':21: packed_bed.porosity = "2024-01-01"', "wrong kind of value"],
    ),
    (
        "number beyond floats",
        "0.6",
        "1" + "0" * 400,
        [":9: gas.density = 1000", "wrong kind of value"],
    ),
    (
        "wrong choice",
        '"axisymmetric"',
        '"lines"',
        [':4: mesh.type = "lines": unknown choice', "did you mean 'line'?"],
    ),
    (
        "no choice",
        'type = "axisymmetric"\n',
        "",
        [":3: mesh.type: missing; allowed: 'axisymmetric', 'box'"],
    ),
    (
        "choice of a key",
        "[solids.sand]",
        "model = 3\n[solids.sand]",
        [":14: gas.model = 3: unknown choice; allowed: cantera"],
    ),
    (
        "degree",
        "[packed_bed]",
        "[solver]\ndegree = 4\n[packed_bed]",
        [":21: solver.degree = 4: unknown choice; allowed: 1, 2, 3"],
    ),
    (
        "cells for each direction",
        "radius",
        "cells = [4]\nradius",
        [":6: mesh.cells[1]: missing"],
    ),
    (
        "polynomial without terms",
        "[1.0, 1e-3]",
        "[]",
        [":17: solids.sand.conductivity = []: empty; allowed: a list"],
    ),
    (
        "no computer squares it",
        "[1.0, 1e-3]",
        "[1.0, 1e200]",
        [":17: solids.sand.conductivity[1] = 1e+200:", "no size"],
    ),
    (
        "nothing is that small",
        "[1.0, 1e-3]",
        '"1e-200 W/m/K"',
        [":17: solids.sand.conductivity", "0, or from 1e-50"],
    ),
    # units
    (
        "wrong dimension",
        '"3 mm"',
        '"3 kg"',
        [":18: solids.sand.diameter", "expected a length like 'm', found '3 kg'"],
    ),
    (
        "no unit",
        '"3 mm"',
        '"3"',
        [":18: solids.sand.diameter", "without a unit; write 3 for SI, or '3 m'"],
    ),
    (
        "unknown unit",
        '"3 mm"',
        '"3 quux"',
        [":18: solids.sand.diameter", "unknown unit 'quux'"],
    ),
    (
        "unit twice",
        '"3 mm"',
        '"3 mm mm"',
        [":18: solids.sand.diameter", "expected a length like 'm', found '3 mm mm'"],
    ),
    (
        "coulomb for celsius",
        '"400 degC"',
        '"400 C"',
        [":30: boundary.bottom.gas.temperature", "Celsius are 'degC'"],
    ),
    (
        "below zero kelvin",
        '"25 degC"',
        '"-300 degC"',
        [":33: boundary.top.solids.sand.temperature", "out of range", "> 0 K"],
    ),
    (
        "comma in a quantity",
        '"50 mm"',
        '"5,0 mm"',
        [":6: mesh.radius", "the decimal sign is a point"],
    ),
    (
        "volume flow for a velocity",
        "velocity = 0.5",
        'velocity = "2 L/min"',
        [":30: boundary.bottom.gas.velocity", "'2 L/min'"],
    ),
    # closures
    (
        "closure misspelt",
        '"gunn"',
        '"gun"',
        [":24: closures.nusselt", "unknown nusselt closure", "nearest: nusselt_gunn"],
    ),
    (
        "closure of another kind",
        '"gunn"',
        '"wall_li_finlayson"',
        [":24: closures.nusselt", "is of kind 'wall'"],
    ),
    (
        "closure without a name",
        '"gunn"',
        "{ Nu = 2 }",
        [":24: closures.nusselt.name: missing"],
    ),
    (
        "closure's parameter",
        '"gunn"',
        '{ name = "gunn", n = 1 }',
        [":24: closures.nusselt", "no parameter 'n'"],
    ),
    (
        "parameter's value",
        '"gunn"',
        '{ name = "gunn", exponent_Pr = true }',
        [":24: closures.nusselt", "a finite number"],
    ),
    (
        "parameter missing",
        '"gunn"',
        '"power"',
        [":24: closures.nusselt", "closure 'power' needs a, b"],
    ),
    (
        "phase with parameters",
        '"gunn"',
        '2\nconductivity_solids = { name = "phase", x = 1 }',
        [":25: closures.", "no parameters"],
    ),
    (
        "negative for a closure",
        '"gunn"',
        "-1",
        [":24: closures.nusselt = -1: out of range; allowed: a number >= 0"],
    ),
    (
        "dispersion's keys",
        '"wakao_kaguei"',
        "{ axial = 1, trans = 2 }",
        [":25: closures.dispersion.trans", "'transverse'"],
    ),
    (
        "dispersion misspelt",
        "wakao_kaguei",
        "wakao",
        [":25: closures.dispersion", "nearest: dispersion_wakao_kaguei"],
    ),
    # contradictions and gaps
    (
        "no solid",
        GOOD[GOOD.index("[solids.sand]") : GOOD.index("[packed_bed]")],
        "",
        [":1: solids: this table is missing"],
    ),
    (
        "heat without properties",
        "heat_capacity = 1100\n",
        "",
        [":8: gas.heat_capacity: missing; a scene with [heat]"],
    ),
    (
        "time without heat",
        "[heat]\n",
        TIME,
        [":29: time: needs a [heat]"],
    ),
    (
        "components",
        "velocity = 0.5",
        "velocity = [0, 0, 1]",
        [":30: boundary.bottom.gas.velocity", "3 components", "scene.toml:4"],
    ),
    (
        "radial velocity",
        "velocity = 0.5",
        "velocity = [1, 1]",
        [":30: boundary.bottom.gas.velocity", "radial velocity is 0"],
    ),
    (
        "boundary misspelt",
        "[boundary.wall]",
        "[boundary.walls]",
        [":35: boundary.walls", "did you mean 'wall'?"],
    ),
    (
        "boundary of another mesh",
        "boundary.wall",
        "boundary.left",
        [":35: boundary.left", "it has wall, bottom, top"],
    ),
    (
        "condition on the axis",
        "boundary.wall",
        "boundary.axis",
        [":35: boundary.axis", "line of symmetry"],
    ),
    (
        "region misspelt",
        "[heat]",
        "[region.core]\n[heat]",
        [":27: region.core", "one region, 'bed'"],
    ),
    (
        "unit forgotten",
        '"3 mm"',
        "3",
        [
            ":18: solids.sand.diameter = 3",
            "mesh.length (scene.toml:5)",
            "unit missing?",
        ],
    ),
    (
        "inflow where it leaves",
        "velocity = 0.5",
        "velocity = -0.5",
        [":30: boundary.bottom.gas.temperature", "toml:30"],
    ),
    (
        "entering without a temperature",
        "velocity = 0.5",
        "velocity = -0.5",
        [":32: boundary.top.gas: the gas enters"],
    ),
    (
        "inflow without velocity",
        "velocity = 0.5, ",
        "",
        [":30: boundary.bottom.gas.temperature", "use fixed"],
    ),
    (
        "inflow at a wall",
        'coefficient = "li_finlayson", ambient',
        "temperature",
        [":36: boundary.wall.gas", "no gas enters"],
    ),
    (
        "two conditions",
        'temperature = "25 degC"',
        "temperature = 300, heat_flux = 1",
        [":33: boundary.top.solids.sand", "found temperature, heat_flux"],
    ),
    (
        "no condition",
        ', temperature = "25 degC"',
        "",
        [":33: boundary.top.solids.sand", "without a temperature"],
    ),
    (
        "coefficient alone",
        ", ambient = 300",
        "",
        [":36: boundary.wall.gas", "coefficient and ambient belong together"],
    ),
    (
        "nothing leaves",
        "[boundary.top]",
        '[boundary.top]\ntype = "slip"',
        [":33: boundary.top.type", "cannot leave"],
    ),
    (
        "inlet at the outlet",
        "[boundary.top]",
        '[boundary.top]\ntype = "inlet"',
        [":33: boundary.top.type", "not enter"],
    ),
    (
        "outlet at the inlet",
        "[boundary.bottom]",
        '[boundary.bottom]\ntype = "outlet"',
        [":30: boundary.bottom.type"],
    ),
    (
        "undetermined",
        GOOD[GOOD.index("[boundary.bottom]") :],
        "",
        [":27: heat", "undetermined"],
    ),
    (
        "no exchange",
        'nusselt = "gunn"' + GOOD.partition('gunn"')[2],
        NO_EXCHANGE,
        [":25: heat: the steady", "of the solid is"],
    ),
    (
        "times after the end",
        "[heat]",
        TIME + "times = [1, 11]\n[heat]",
        [":31: time.times[1] = 11", "scene.toml:30"],
    ),
    (
        "step after the end",
        "[heat]",
        TIME + "step = 11\n[heat]",
        [":31: time.step = 11", "time.end (scene.toml:30)"],
    ),
    (
        "step and tolerance",
        "[heat]",
        TIME + "step = 1\ntolerance = 0.1\n[heat]",
        [":32: time.tolerance", "toml:31"],
    ),
    (
        "position outside",
        "[heat]",
        "[output]\npositions = [0, 2]\n[heat]",
        [":28: output.positions[1] = 2", "0 to 1 m"],
    ),
    (
        "negative property",
        "[1.0, 1e-3]",
        "[1.0, -1e-2]",
        [":17: solids.sand.conductivity", "is -5.731 at boundary.bottom"],
    ),
    (
        "fluid table upside down",
        CONSTANT,
        COOLPROP.replace("300", "900"),
        [":11: gas.T_range", "lower temperature"],
    ),
    (
        "outside of the fluid table",
        CONSTANT,
        COOLPROP.replace("300", "350"),
        [":34: boundary.wall.gas.ambient"],
    ),
    (
        "composition",
        CONSTANT,
        'model = "cantera"\ncomposition = "N2:a"\n[solids.sand]\n',
        [":10: gas.composition", "must be a number"],
    ),
    (
        "mesh file missing",
        AXISYMMETRIC,
        'type = "file"\nfile = "no.msh"\n',
        [':5: mesh.file = "no.msh": no such file'],
    ),
    (
        "mesh file of another kind",
        AXISYMMETRIC,
        'type = "file"\nfile = "a.stl"\n',
        [":5: mesh.file", "neither"],
    ),
    # radiation
    (
        "radiation: level",
        BOTTOM,
        RADIATION.replace("absorption", 'level = "p3"\nabsorption'),
        [":30: radiation.level", "allowed: p1"],
    ),
    (
        "radiation: black holes",
        BOTTOM,
        CHAR.replace("0.8", "0") + BOTTOM,
        [":33: solids.char.emissivity = 0: out of range", "> 0 and <= 1"],
    ),
    (
        "radiation: brighter than black",
        BOTTOM,
        CHAR.replace("0.8", "1.1") + BOTTOM,
        [":33: solids.char.emissivity = 1.1: out of range"],
    ),
    (
        "radiation: no optics",
        BOTTOM,
        RADIATION.replace(OPTICS, ""),
        [":29: radiation: give the optics once", "none"],
    ),
    (
        "radiation: optics twice",
        BOTTOM,
        CHAR.replace("[radiation]\n", "[radiation]\n" + OPTICS) + BOTTOM,
        [":29: radiation: give the optics once", "emissivity, absorption"],
    ),
    (
        "radiation: one without an emissivity",
        BOTTOM,
        CHAR + BOTTOM,
        [":14: solids.sand.emissivity: missing"],
    ),
    (
        "radiation: transparent",
        BOTTOM,
        RADIATION.replace("absorption = 3", "absorption = 0"),
        [":29: radiation: nothing stops a ray"],
    ),
    (
        "radiation: forward only",
        BOTTOM,
        RADIATION.replace("absorption = 3", "scattering = 9\nanisotropy = 1"),
        [":29: radiation: nothing"],
    ),
    (
        "radiation: negative scattering",
        BOTTOM,
        RADIATION.replace("absorption = 3", "scattering = -9"),
        [":30: radiation.scattering", ">= 0"],
    ),
    (
        "radiation: two-flux in a plane",
        BOTTOM,
        RADIATION.replace("absorption", 'level = "two_flux"\nabsorption'),
        [":30: radiation.level", "a line", "toml:4"],
    ),
    (
        "radiation: ordinates with heat",
        BOTTOM,
        RADIATION.replace("absorption", 'level = "ordinates"\nabsorption'),
        [":30: radiation.level", "alone"],
    ),
    (
        "radiation: temperature with heat",
        BOTTOM,
        RADIATION.replace("= 3", "= 3\ntemperature = 900"),
        [":31: radiation.temperature", "[heat]"],
    ),
    (
        "radiation: conductivity with heat",
        BOTTOM,
        RADIATION.replace("= 3", "= 3\nconductivity = 1"),
        [":31: radiation.conductivity", "[heat]"],
    ),
    (
        "radiation: boundary alone",
        BOTTOM,
        BOTTOM + "radiation = { temperature = 900 }\n",
        [":30: boundary.bottom.radiation", "without a [radiation]"],
    ),
    (
        "radiation: wall and opening",
        BOTTOM,
        RADIATION + "radiation = { temperature = 900, radiosity = 1 }\n",
        [":32: boundary.bottom.radiation", "one of temperature, radiosity"],
    ),
    (
        "radiation: wall of no temperature",
        BOTTOM,
        RADIATION + "radiation = { emissivity = 0.5 }\n",
        [":32: boundary.bottom.radiation", "one of"],
    ),
    (
        "radiation: negative radiosity",
        BOTTOM,
        RADIATION + "radiation = { radiosity = -1 }\n",
        [":32: boundary.bottom.radiation.radiosity", ">= 0"],
    ),
    (
        "radiation: wall's emissivity",
        BOTTOM,
        RADIATION + "radiation = { temperature = 900, emissivity = 2 }\n",
        [":32: boundary.bottom.radiation.emissivity"],
    ),
    (
        "radiation: rosseland and a loose wall",
        BOTTOM,
        RADIATION.replace("absorption", 'level = "rosseland"\nabsorption')
        + "radiation = { temperature = 900 }\n",
        [":33: boundary.bottom.radiation", "solids.NAME.fixed_temperature"],
    ),
    (
        "radiation: more than all particles",
        BOTTOM,
        CHAR.replace("0.5", "1.5") + BOTTOM,
        [":31: solids.char.volume_share = 1.5: out of range"],
    ),
    (
        "radiation: too many particles",
        BOTTOM,
        CHAR + BOTTOM,
        ["solids: the volume shares sum to 1.5"],
    ),
    (
        "radiation: two sizes",
        BOTTOM,
        CHAR.replace("diameter", SIEVES + "diameter") + BOTTOM,
        [":30: solids.char: give one of diameter, sieves"],
    ),
    (
        "radiation: no size",
        BOTTOM,
        CHAR.replace("diameter = 0.001\n", "") + BOTTOM,
        [":30: solids.char: give one of diameter, sieves"],
    ),
    (
        "radiation: sieve counts",
        BOTTOM,
        SIEVED.replace("[1.0]", "[0.5, 0.5]") + BOTTOM,
        [":32: solids.char.sieves", "2 classes lie between 3 apertures, got 2"],
    ),
    (
        "radiation: sieves upside down",
        BOTTOM,
        SIEVED.replace("1e-3, 2e-3", "2e-3, 1e-3") + BOTTOM,
        [":32: solids.char.sieves", "must increase"],
    ),
    (
        "radiation: sieved twice",
        BOTTOM,
        SIEVED.replace("[1.0]", "[1.2]") + BOTTOM,
        [":32: solids.char.sieves", "mass fraction"],
    ),
    (
        "two solids that fill the bed",
        BOTTOM,
        CHAR.replace("[radiation]\n", "") + "density = 900\n" + BOTTOM,
        [
            ":14: solids: a bed without species has one solid with a density; found "
            "sand, char"
        ],
    ),
    (
        "a condition of another solid",
        "solids.sand =",
        "solids.ash =",
        [":33: boundary.top.solids.ash", "the solid that fills the bed is 'sand'"],
    ),
    (
        "velocity given twice",
        'temperature = "25 degC" }',
        'temperature = "25 degC" }\ngas.velocity = 0.1',
        [
            ":34: boundary.top.gas.velocity",
            "boundary.bottom.gas.velocity (scene.toml:30)",
        ],
    ),
    ("former table", "[gas]", "[fluid]", [":8: fluid: this key is called 'gas' now"]),
    (
        "former key",
        "[heat]",
        "[heat]\nnusselt = 2",
        [":28: heat.nusselt = 2: this key is called 'closures.nusselt' now"],
    ),
    (
        "former flow",
        "[heat]",
        "[flow]\nvelocity = 1\n[heat]",
        [
            ":28: flow.velocity = 1: give boundary.NAME.gas.velocity where the gas "
            "enters"
        ],
    ),
    (
        "diameter on a line",
        AXISYMMETRIC,
        LINE + "\n",
        [":36: boundary.wall.gas.coefficient", "D_bed = ..."],
    ),
]


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [case[1:] for case in CASES],
    ids=[case[0] for case in CASES],
)
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
    with pytest.raises(SceneError) as error:
        loads(text)
    lines = [int(line.split(":")[1]) for line in error.value.problems]
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
    with pytest.raises(SceneError) as error:
        loads(text)
    assert ["packed_bed.porosity" in line for line in error.value.problems].count(
        True
    ) == 1
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
    assert any(str(path) + part in line for line in error.value.problems), (
        error.value.problems
    )
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


@settings(max_examples=300)
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


@settings(max_examples=300)
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
    """Two fluids take no radiation: by line, with the physics that do."""
    scene = (Path(contbed.__file__).parent / "two_fluid" / "template.toml").read_text(
        encoding="utf-8"
    )
    # a file for one model alone
    scene = scene.replace('model = "two_fluid"', "two_fluid = {}")
    line = len(scene.splitlines()) + 1
    refused(
        rf":{line}: radiation: particles of two fluids radiate to walls only, .* use .bubbling_bed. "
        r"or",
        lambda: loads(scene.rstrip("\n") + '\n[radiation]\nlevel = "ordinates"\n'),
    )
