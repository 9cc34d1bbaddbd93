"""Materials by name: their values against the tables of their sources, and how a
scene uses them.
"""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed.loading import from_dict
from contbed.scene.identity import resolved
from contbed.scene.library import MATERIALS, data_sheet
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import scene_of

STUDIES = Path(__file__).parents[2] / "studies"
INERT, BEADS = ("solids", "inert"), ("solids", "beads")
BED = scene_of(
    """
[mesh]
type = "line"
length = 0.5
[gas]
material = "solar_salt"
material_temperature = "340 degC"
[solids.beads]
material = "alumina"
diameter = 0.01
[packed_bed]
porosity = 0.5
[closures]
nusselt = "gunn"
[heat]
[boundary.left]
gas.velocity = 1e-3
gas.temperature = 600
[boundary.right]
solids.beads.velocity = 1e-3
solids.beads.temperature = 800
"""
)


# the equations of Waples and Waples and of Miao et al., those of the Eurocode in degC
CELSIUS = {
    ("granite", "heat_capacity"): lambda t: 775.0 * _waples(t) / _waples(26.85),
    ("granite", "conductivity"): lambda t: 1.0 / (0.24094 + 4.6019e-4 * (t + 273.15)),
    ("concrete", "heat_capacity"): lambda t: np.interp(
        t, [20, 100, 200, 400, 1200], [900, 900, 1000, 1100, 1100]
    ),
    ("concrete", "conductivity"): lambda t: (
        1.36 - 0.136 * t / 100 + 0.0057 * (t / 100) ** 2
    ),
}


def _waples(t):
    return 8.95e-10 * t**3 - 2.13e-6 * t**2 + 0.00172 * t + 0.716


@pytest.mark.parametrize("key", CELSIUS)
def test_rocks_and_concrete_follow_their_equations(key):
    name, quantity = key
    for t in np.linspace(25.0, 570.0, 60):
        assert MATERIALS[name].at(t + 273.15)[quantity] == approx(
            float(CELSIUS[key](t)), rel=MATERIALS[name].error
        )


@each_case(__file__, "printed_values")
def test_printed_values(material, quantity, T, values):
    for at, value in zip(T, values, strict=True):
        assert MATERIALS[material].at(at)[quantity] == approx(
            value, rel=MATERIALS[material].error
        )


@each_case(__file__, "heat_capacities_follow_the_shomate_equation")
def test_heat_capacities_follow_the_shomate_equation(name, mass, shomate):
    a, b, c, d, e = shomate
    for T in np.linspace(*MATERIALS[name].T_range, 23):
        t = T / 1000.0
        expected = (a + b * t + c * t**2 + d * t**3 + e / t**2) / mass
        assert MATERIALS[name].at(T)["heat_capacity"] == approx(
            expected, rel=MATERIALS[name].error
        )


def test_solar_salt_in_celsius():
    """The equations of the report, with t in degC and the viscosity in mPa s."""
    for t in (290.0, 400.0, 565.0):
        found = MATERIALS["solar_salt"].at(t + 273.15)
        assert found["density"] == approx(2090.0 - 0.636 * t, rel=1e-6)
        assert found["heat_capacity"] == approx(1443.0 + 0.172 * t, rel=1e-6)
        assert found["conductivity"] == approx(0.443 + 1.9e-4 * t, rel=1e-6)
        viscosity = 22.714 - 0.120 * t + 2.281e-4 * t**2 - 1.474e-7 * t**3
        assert found["viscosity"] == approx(viscosity * 1e-3, rel=1e-5)


def test_every_material_is_positive_and_says_its_source():
    for name, entry in MATERIALS.items():
        assert entry.source and "source: " in data_sheet(name)
        for T in np.linspace(*entry.T_range, 50):
            assert all(value > 0.0 for value in entry.at(T).values())


def test_a_scene_takes_the_values_of_its_materials():
    scene = cb.load(BED)
    assert scene.gas.density == approx(2090.0 - 0.636 * 340.0, rel=1e-6)
    assert scene.solid.heat_capacity == MATERIALS["alumina"].heat_capacity
    constant = cb.load(
        BED,
        {"solids.beads.material_temperature": "700 K", "solids.beads.density": 3000.0},
    ).solid
    assert constant.density == 3000.0  # what is given replaces what the library has
    assert constant.heat_capacity == approx(
        MATERIALS["alumina"].at(700.0)["heat_capacity"]
    )
    assert from_dict(resolved(scene)) == scene


def test_the_range_of_a_material_is_watched():
    assert cb.run(cb.load(BED)).warnings == []
    hot = cb.run(
        cb.load(
            BED,
            {
                "solids.beads.material": "sand",
                "boundary.right.solids.beads.temperature": 900.0,
            },
        )
    )
    assert any(
        "sand" in text and "data from 298 to 847 K are extrapolated" in text
        for text in hot.warnings
    )


@each_case(__file__, "mistakes")
def test_mistakes(solid, part):
    refused(
        part, lambda: cb.load({**BED, "solids": {"beads": solid | {"diameter": 0.01}}})
    )


def test_a_liquid_that_the_library_lacks_is_found_elsewhere():
    gas = {"material": "water", "material_temperature": 300.0}
    refused(
        'allowed: solar_salt; or give model = "coolprop" and a name such as "Water"',
        lambda: cb.load({**BED, "gas": gas}),
    )


def test_scenes_from_dicts_and_short_reprs():
    result = cb.run(cb.load(BED))
    text = repr(result)
    assert text.startswith("<Result of a packed_bed scene: ok; ") and len(text) < 250
    refused(
        r"scene:1: packed_bed.porosity = 2: out of range",
        cb.load,
        {**BED, "packed_bed": {"porosity": 2}},
    )


def scene_with(path, table, added, removed=()):
    """Return the scene of a study with keys of one table added and removed."""
    values = tomllib.loads((STUDIES / path).read_text())
    values.pop("output", None)
    part = values
    for name in table:
        part = part[name]
    part |= added
    for key in removed:
        part.pop(key)
    return cb.load(values)


def test_particles_of_other_scenes_are_of_a_material():
    hot = {"material": "alumina", "material_temperature": "850 degC", "density": 3600.0}
    found = scene_with("bubbling_bed_case1/p1.toml", INERT, hot).solids["inert"]
    exact = MATERIALS["alumina"].at(1123.15)
    assert found.density == 3600.0  # what is given replaces what the library has
    assert found.heat_capacity == approx(exact["heat_capacity"], rel=1e-14)
    assert found.conductivity == approx(exact["conductivity"], rel=1e-14)
    assert found.mixing_conductivity == 2e4  # that of mixing is not the material's
    riser = scene_with(
        "two_fluid_checks/cooling.toml", BEADS, {"material": "FCC"}, ["density"]
    )
    assert riser.solid.density == 1400.0


@each_case(__file__, "mistakes_of_solids")
def test_mistakes_of_solids(added, part):
    refused(part, scene_with, "bubbling_bed_case1/p1.toml", INERT, added)
