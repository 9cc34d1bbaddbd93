"""Humid air by its humidity, against CoolProp's own equation of humid air."""

from pathlib import Path

import numpy as np
import pytest
from CoolProp.CoolProp import PropsSI
from CoolProp.HumidAirProp import HAPropsSI
from pytest import approx

import contbed as cb
from contbed.loading import loads
from contbed.materials.composition import mole_fractions
from contbed.materials.condensation import above_saturation
from contbed.materials.constants import fluid_of
from contbed.scene.humid_air import dew_point, saturation_pressure
from tests.refusals import refused
from tests.scene_text import scene_of

P = 101325.0
BED = """
[mesh]
type = "line"
length = 0.5
[gas]
material = "humid air"
humidity_ratio = 0.01
[solids.stones]
diameter = 0.01
density = 2600
heat_capacity = 900
conductivity = 2
[packed_bed]
porosity = 0.4
[closures]
nusselt = "gunn"
[heat]
[boundary.left]
gas.velocity = 0.5
gas.temperature = 350
[boundary.right]
solids.stones.velocity = 1e-3
solids.stones.temperature = 310
"""
HALF = {
    "gas.humidity_ratio": None,
    "gas.relative_humidity": 0.5,
    "gas.dry_bulb": "30 degC",
}


def bed(values):
    """Return the tables of the bed; a key of None is left out."""
    return scene_of(BED, values)


@pytest.mark.parametrize("T", [280.0, 300.0, 320.0, 350.0])
def test_saturation_and_dew_points(T):
    """Interactions with the gas raise the share of water by 0.4 to 0.7 %."""
    for humidity in (0.5, 1.0):
        share = humidity * saturation_pressure(T) / P
        exact = HAPropsSI("psi_w", "T", T, "P", P, "R", humidity)
        assert share == approx(exact, rel=0.007)
    assert dew_point(saturation_pressure(T)) == approx(T, abs=1e-9)
    dew = HAPropsSI("Tdp", "T", T + 20.0, "P", P, "psi_w", saturation_pressure(T) / P)
    assert dew_point(saturation_pressure(T)) == approx(dew, abs=0.15)


@pytest.mark.parametrize("ratio", [0.0, 0.01, 0.03])
def test_properties_are_those_of_coolprop(ratio):
    """Ideal mixture by Cantera: density 0.1 %, heat capacity 0.4 %, viscosity 1.2 %,
    conductivity 1.8 % from 300 to 470 K.
    """
    scene = cb.load(bed({"gas.humidity_ratio": ratio}))
    gas = fluid_of(scene.gas, scene.origin)
    for T in (300.0, 350.0, 400.0, 470.0):

        def exact(name, T=T):
            return HAPropsSI(name, "T", T, "P", P, "W", ratio)

        assert gas.density(T) == approx(1.0 / exact("Vha"), rel=1e-3)
        assert gas.heat_capacity(T) == approx(exact("cp_ha"), rel=4e-3)
        assert gas.viscosity(T) == approx(exact("mu"), rel=0.012)
        assert gas.conductivity(T) == approx(exact("k"), rel=0.018)


def test_humidity_ratio_and_relative_humidity_agree():
    shares = mole_fractions(cb.load(bed(HALF)).gas.composition)
    T = 303.15
    ratio = HAPropsSI("W", "T", T, "P", P, "R", 0.5)
    same = mole_fractions(cb.load(bed({"gas.humidity_ratio": ratio})).gas.composition)
    assert shares["H2O"] == approx(same["H2O"], rel=0.006)
    assert shares["H2O"] == approx(0.5 * saturation_pressure(T) / P, rel=1e-9)
    assert sum(shares.values()) == approx(1.0, rel=1e-12)


def test_condensation_is_warned_of():
    assert not cb.load(bed(HALF)).warnings
    (text,) = cb.load(
        bed(HALF | {"boundary.right.solids.stones.temperature": 285.0})
    ).warnings
    assert "boundary.right.solids.stones.temperature" in text
    assert "condenses or freezes below 291" in text


def test_water_above_its_saturation_in_a_result_is_warned_of():
    """Steam of 1 atm: CoolProp has it saturated at 373.124 K."""
    z, T = np.array([0.0, 1.0, 2.0]), np.array([380.0, 360.0, 390.0])
    (text,) = above_saturation("the gas", z, T, np.full(3, P))
    assert "1.013e+05 Pa at 360 K and 1 m, condenses below 373.12 K" in text
    assert PropsSI("T", "P", P, "Q", 1, "Water") == pytest.approx(373.12, abs=5e-3)
    assert not above_saturation("the gas", z, T + 14.0, np.full(3, P))
    assert not above_saturation("the gas", z, T, np.zeros(3))


BUBBLING = """
[bubbling_bed]
height = 1.0
section = 1.0
solids_fraction = 0.5
[bubbling_bed.tubes]
perimeter = 10.0
coefficient = 200.0
[gas]
composition = "H2O:1"
[boundary.bottom]
gas.mass_flow = 0.3
gas.temperature = 400.0
[solids.stones]
diameter = 6e-4
density = 2600
heat_capacity = 900
nusselt = "ranz_marshall"
mixing_conductivity = 1e4
"""
REACTING = """
[mesh]
type = "line"
length = 1.0
diameter = 0.1
[gas]
model = "cantera"
composition = "H2O:1"
[packed_bed]
porosity = 0.4
[solids.stones]
diameter = 0.005
density = 2600
[heat]
[boundary.left]
gas.molar_flux = 10.0
gas.temperature = 400.0
[boundary.wall]
coefficient = 200.0
"""


@pytest.mark.parametrize(
    ("text", "coolant", "gas"),
    [
        (BUBBLING, "bubbling_bed.tubes.temperature", "the gas of the emulsion"),
        (REACTING, "boundary.wall.ambient", "the gas"),
    ],
    ids=["bubbling", "reacting"],
)
def test_steam_cooled_below_its_dew_point_is_warned_of(text, coolant, gas):
    """Steam of 1 atm in beds that tubes or a wall keep below 373 K, and above."""
    cold, hot = (
        cb.run(cb.load(scene_of(text, {coolant: T}))).warnings for T in (350.0, 390.0)
    )
    assert any(f"water in {gas}, 1.01" in each for each in cold)
    assert not any("water in" in each for each in hot)


def test_bubbling_beds_burn_in_humid_air():
    template = Path(cb.__file__).parent / "bubbling_bed" / "template.toml"
    values = {"gas": {"material": "humid air", "humidity_ratio": 0.02}}
    found = cb.load(scene_of(template.read_text(), values))
    assert found.gas.model == "cantera"
    assert "H2O" in found.gas.composition


@pytest.mark.parametrize(
    ("values", "part"),
    [
        ({"gas.relative_humidity": 0.5}, "give humidity_ratio, or relative_humidity"),
        (
            {"gas.humidity_ratio": None, "gas.relative_humidity": 0.5},
            "give humidity_ratio, or relative_humidity",
        ),
        (HALF | {"gas.relative_humidity": 1.2}, "out of range"),
        (HALF | {"gas.dry_bulb": "150 degC"}, "water boils there"),
        ({"gas.composition": "N2:1"}, "not both"),
        (
            {"gas.material": None, "gas.composition": "N2:1"},
            'of material = "humid air"',
        ),
    ],
)
def test_mistakes(values, part):
    refused(part, cb.load, bed(values))


def test_air_by_name_is_humid_air_without_water():
    dry = cb.load(bed({"gas.material": "air", "gas.humidity_ratio": None})).gas
    assert dry.composition == cb.load(bed({"gas.humidity_ratio": 0.0})).gas.composition
    mistaken = {"gas.material": "air"}
    refused('humidity_ratio: of material = "humid air" only', cb.load, bed(mistaken))


@pytest.mark.parametrize("model", ["two_fluid", "developed_flow"])
def test_constants_of_air_at_20_degC_are_taken_with_a_warning(model):
    """Cantera's data of air begin at 300 K; CoolProp's own air is the measure."""
    template = Path(cb.__file__).parent / model / "template.toml"
    given = scene_of(template.read_text())
    given["gas"] = {"material": "air", "reference_temperature": "20 degC"}
    scene = cb.load(given)
    (text,) = [each for each in scene.warnings if "extrapolated" in each]
    assert "293.15 K, where the heat capacity differs by 0.07%" in text
    for value, name, error in (
        (scene.fluid.density, "D", 1e-3),
        (scene.fluid.heat_capacity, "C", 4e-3),
        (scene.fluid.viscosity, "V", 0.012),
        (scene.fluid.conductivity, "L", 0.018),
    ):
        exact = PropsSI(name, "T", 293.15, "P", P, "Air")
        assert value == approx(exact, rel=error), name
    given["gas"]["reference_temperature"] = 150.0
    refused("known from 300 to 3000 K, not at 150 K", cb.load, given)


@pytest.mark.parametrize(
    ("humidity", "key", "step"),
    [
        ("humidity_ratio = 0.02", "gas.humidity_ratio", 1e-4),
        ("relative_humidity = 0.8\ndry_bulb = 333", "gas.dry_bulb", 0.5),
        ("relative_humidity = 0.8\ndry_bulb = 333", "gas.pressure", 500.0),
    ],
)
def test_the_composition_follows_what_it_depends_on(humidity, key, step):
    """Derivatives beside central differences of scenes that are read anew: their
    truncation, 1e-3.
    """
    text = BED.replace("humidity_ratio = 0.01", f"{humidity}\npressure = 1e5")
    at = {"gas.humidity_ratio": 0.02, "gas.dry_bulb": 333.0, "gas.pressure": 1e5}[key]
    scene = loads(text)
    found = cb.gradient(scene, ["pressure_drop_Pa"], [key])
    drops = [
        cb.run(loads(text, overrides={key: at + sign * step})).qoi["pressure_drop_Pa"]
        for sign in (1, -1)
    ]
    wanted = (drops[0] - drops[1]) / (2 * step)
    assert found.derivatives[0, 0] == approx(wanted, rel=1e-3)


STORE = """
mesh = { type = "line", length = 0.4, cells = 20 }
gas = { material = "humid air", humidity_ratio = 0.01 }
solids.rock = { material = "granite", diameter = 25e-3 }
packed_bed.porosity = 0.42
closures = { nusselt = 20, conductivity_solids = 0.4, conductivity_gas = 0 }
heat = {}
initial.temperature = 283.15
boundary.left.gas = { velocity = 0.15, temperature = 303.15 }
time = { end = 600 }
"""


def test_steps_do_not_follow_a_front_within_a_cell():
    """Air passes the bed in 1 s and is followed no finer than the cells hold its front;
    half a tenth of the error of the cells is left in the outlet, beside steps of
    constant size.
    """
    found = cb.run(loads(STORE))
    beside = cb.run(loads(STORE, overrides={"time.step": 2.0}))
    assert found.qoi["time_steps"] < 160
    outlet = found.qoi["T_fluid_out_K"], beside.qoi["T_fluid_out_K"]
    assert outlet[0] == approx(outlet[1], abs=5e-3)
