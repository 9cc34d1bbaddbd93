"""Efficiency by indirect losses against the heat to surfaces, and emissions by hand."""

import pytest
from pytest import approx
from reacting_scenes import tables

import contbed as cb
from contbed.bubbling_bed.chemistry.of_boilers import emission
from contbed.bubbling_bed.chemistry.results import _fuel
from contbed.bubbling_bed.plan import plan
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.scene_text import set_keys


def run(composition=None):
    """Results of a combustor whose fuel is fed at the temperature of its heating
    value.
    """
    scene = tables(initial={"temperature": 1150.0})
    set_keys(scene, "solids.char.feed.temperature = 298.15")
    if composition:
        scene["gas"]["composition"] = composition
    return cb.run(from_dict(scene)).qoi


@pytest.fixture(scope="module")
def boiler():
    return run()


@pytest.mark.parametrize("composition", [None, "O2:0.21, N2:0.75, H2:0.04"])
def test_the_indirect_efficiency_is_what_surfaces_take(boiler, composition):
    """The gas may be fuel as well, which takes half its moles of oxygen."""
    if composition:
        oxygen, boiler = boiler["oxygen_ratio"], run(composition)
        lost = (
            0.04 / 0.21 * 0.5
        )  # of hydrogen, per oxygen; air has 28.75, this 27.81 g/mol
        without = oxygen * 28.75 / 27.81
        assert boiler["oxygen_ratio"] == approx(1.0 / (1.0 / without + lost), rel=1e-3)
    taken = sum(
        heat
        for name, heat in boiler.items()
        if name.endswith(("_convection_W", "_radiation_W"))
    )
    # heats of formation of the fuel are given to some 1e-5 of its heating value
    direct = taken / boiler["fuel_power_W"]
    assert boiler["boiler_efficiency"] == approx(direct, abs=5e-5)
    assert 0.3 < boiler["loss_flue_gas"] < 0.7 and 0.0 < boiler["loss_solids"] < 0.01


def test_emissions_by_hand(boiler):
    """100 ppm of CO at 6 % of O2 are 125 mg/m3; of air twice as diluted they count
    twice.
    """
    assert emission(1e-4, 0.06, 0.02801) == approx(124.97, rel=1e-3)
    half = 0.209 - 0.5 * (0.209 - 0.06)
    assert emission(1e-4, half, 0.02801) == approx(2.0 * 124.97, rel=1e-3)
    expected = emission(boiler["x_CO_dry"], boiler["x_O2_dry"], 0.02801)
    assert boiler["emission_CO_mg_m3"] == approx(expected, rel=1e-4)


def test_a_gasifier_has_no_efficiency_of_a_boiler():
    scene = tables(initial={"temperature": 1150.0})
    set_keys(scene, "boundary.bottom.gas.mass_flow = 0.25")
    qoi = cb.run(from_dict(scene)).qoi
    assert qoi["oxygen_ratio"] < 1.0 and "boiler_efficiency" not in qoi


def test_a_gasifier_without_oxygen_has_no_efficiency_of_combustion():
    """Gas that leaves may hold more heating value than the fuel brought."""
    chemistry = BubblingProblem(plan(from_dict(tables()))).chemistry
    unburnt = dict.fromkeys(chemistry.part.gases, 0.0) | {"H2": 1.0, "CO": 1.0}
    qoi = {}
    _fuel(chemistry, {}, unburnt, {}, qoi)
    assert qoi["oxygen_ratio"] == 0.0
    assert not {"combustion_efficiency", "ignited"} & qoi.keys()


def test_gases_burn_out_in_a_freeboard():
    """Heat and elements close, and what burns above the bed counts."""
    scene = tables(initial={"temperature": 1150.0})
    alone = cb.run(from_dict(scene))
    set_keys(scene, "bubbling_bed.freeboard.height = 3.0")
    above = cb.run(from_dict(scene))
    assert_closed(above, 1e-9)
    unburnt = [each.qoi["cold_gas_efficiency"] for each in (alone, above)]
    assert unburnt[1] < 0.05 * unburnt[0]
    assert above.qoi["emission_CO_mg_m3"] < 0.1 * alone.qoi["emission_CO_mg_m3"]


def test_sulphur_that_nothing_burns_is_a_warning():
    scene = tables(initial={"temperature": 1150.0})
    said = "the sulphur of the fuel leaves as H2S"
    assert not any(said in text for text in cb.run(from_dict(scene)).warnings)
    del scene["reactions"]["H2S_oxidation"]
    assert any(said in text for text in cb.run(from_dict(scene)).warnings)
