"""Which model reads a scene, and what becomes of the keys that only others have."""

from __future__ import annotations

import re

import pytest
from small_scenes import STEADY

from contbed.loading import loads
from contbed.models import MODELS, plan
from contbed.plan_text import plan_text
from tests.refusals import problems_of, refused

OTHERS = """\
[two_fluid]
gravity = 9.81
[bubbling_bed]
height = 1.0
"""


def test_a_model_ignores_the_tables_of_others_and_lists_them():
    scene = loads(f'model = "packed_bed"\n{STEADY}{OTHERS}')
    assert scene.ignored == (("two_fluid",), ("bubbling_bed",))
    text = plan_text(plan(scene))
    assert "MODEL   packed_bed" in text
    assert "IGNORED two_fluid" in text


def test_a_key_of_no_model_stays_a_mistake():
    refused(
        r"two_fluid\.gravty = 9\.81: unknown key",
        lambda: loads(
            f'model = "two_fluid"\n{STEADY}{OTHERS}'.replace("gravity", "gravty")
        ),
    )
    refused(
        "colour = 1: unknown key",
        loads,
        f'colour = 1\nmodel = "packed_bed"\n{STEADY}{OTHERS}',
    )


def test_tables_of_two_models_need_the_name_of_one():
    refused(r"tables of several models; say which one", lambda: loads(STEADY + OTHERS))


def test_an_unknown_model_is_named_with_those_that_exist():
    refused(
        r"scene.toml:1: model = .*'packed_bed'", loads, f'model = "packd_bed"\n{STEADY}'
    )


@pytest.mark.parametrize("kind", [k for k in MODELS if k != MODELS[k].name])
def test_a_kind_in_place_of_a_model_tells_the_model_and_what_decides(kind):
    said = f'write model = "{MODELS[kind].name}"; it is a {kind} by'
    refused(re.escape(said), loads, f'model = "{kind}"\n{STEADY}')
    assert MODELS[kind].decides


@pytest.mark.parametrize("kind", MODELS)
def test_templates_run_with_their_model_named(kind):
    text = MODELS[kind].template.read_text(encoding="utf-8")
    line = f'model = "{MODELS[kind].name}"\n'
    named = loads(text if line in text else line + text)
    assert type(named) is type(loads(text))
    assert named.ignored == ()


def test_solids_that_collide_on_a_mesh_are_two_fluids_without_their_table():
    text = MODELS["two_fluid"].template.read_text(encoding="utf-8")
    bare = re.sub(r"(?m)^model = .*$", "", text)
    assert "[two_fluid]" not in bare
    assert loads(bare).kind == "two_fluid"


CARBON_DIOXIDE = """\
[mesh]
type = "line"
length = 1.5
[gas]
model = "coolprop"
name = "CO2"
pressure = "85 bar"
T_range = ["10 degC", "250 degC"]
[solids.pebbles]
material = "steel"
diameter = 0.01
[packed_bed]
porosity = 0.4
[heat]
source = 2.5e5
[boundary.left]
gas.mass_flux = 2.0
gas.temperature = "20 degC"
"""


@pytest.mark.parametrize("first", ["", 'model = "packed_bed"\n'])
@pytest.mark.parametrize("gas", ["coolprop", "constant"])
def test_a_flux_of_one_substance_is_refused_by_name_in_a_packed_bed(first, gas):
    text = CARBON_DIOXIDE
    if gas == "constant":
        head, tail = text.index("model"), text.index("[solids")
        text = text[:head] + 'material = "air"\n' + text[tail:]
    found = problems_of(loads, first + text)
    assert [each.split(": ")[1] for each in found] == [
        "heat.source = 250000.0",
        "boundary.left.gas.mass_flux = 2.0",
    ]
    assert "give region.bed.solids.heat_source" in found[0]
    assert "give gas.velocity, the flux over the density" in found[1]


def test_a_table_without_keys_says_so():
    text = CARBON_DIOXIDE.replace("source", "colour").replace("mass_flux", "velocity")
    assert problems_of(loads, text) == [
        "scene.toml:15: heat.colour = 250000.0: unknown key; this table has no keys"
    ]


def test_a_table_that_only_other_models_have_is_named_with_these():
    """`time` is no misspelt `title`."""
    steady = MODELS["bubbling_bed"].template.read_text()
    refused(
        r"time: unknown table; bubbling_bed does not have it, but packed_bed, "
        r"particles_gas, reacting_bed, single_particle, two_fluid; allowed: ",
        loads,
        steady + "\n[time]\nend = 5.0\n",
    )


def test_the_bottom_of_a_bubbling_bed_is_no_mistake_on_a_line():
    """One file for both: a line has left and right."""
    both = (
        f'model = "packed_bed"\n{STEADY}'
        "[bubbling_bed]\nheight = 1.0\n[boundary.bottom]\ngas.mass_flow = 0.1\n"
    )
    assert ("boundary", "bottom") in loads(both).ignored
    alone = both.replace("[bubbling_bed]\nheight = 1.0\n", "")
    refused("boundary.bottom: a", loads, alone)


def test_a_bed_with_species_says_how_it_takes_radiation():
    reacting = MODELS["reacting_bed"].template.read_text().rstrip("\n")
    alone = reacting.replace('model = "packed_bed"\n', "")
    said = "a bed with species takes radiation by its conductivity"
    refused(f"radiation: {said}", loads, alone + "\n[radiation]\n")
    # a file that others read as well
    warnings = loads(reacting + "\n[radiation]\n").warnings
    assert any(f"is ignored: {said}" in text for text in warnings)
