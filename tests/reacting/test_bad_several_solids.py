"""Mistakes in scenes with several kinds of particles: what is wrong, where, and the
remedy.
"""

from __future__ import annotations

import pytest

from contbed.errors import SceneError
from contbed.loading import loads
from contbed.models import plan
from tests.cases import each_case
from tests.refusals import refused

GOOD = """
[mesh]
type = "line"
length = 1.0

[gas]
model = "ideal_gas"
composition = "CO:0.5, CO2:0.5"

[gas.species]
CO = { heat_capacity = 30.0, enthalpy = -110e3 }
CO2 = { heat_capacity = 40.0, enthalpy = -393.5e3 }

[solids.ore]
volume_share = 0.6
diameter = "10 mm"
composition = "FeO:1"
density = 3000.0
constituent = { FeO = { heat_capacity = 50.0 }, Fe = { heat_capacity = 30.0 } }

[solids.coke]
volume_share = 0.4
diameter = "30 mm"
composition = "C:1"
density = 1000.0
constituent = { C = { heat_capacity = 10.0 } }

[packed_bed]
porosity = 0.4

[reactions.reduction]
equation = "FeO + CO -> Fe + CO2"
A = 1e-3
E = "50 kJ/mol"

[reactions.boudouard]
equation = "C + CO2 -> 2 CO"
A = 1e-3
E = "50 kJ/mol"

[boundary.left]
gas.velocity = 0.5
gas.temperature = 900.0

[boundary.right]
solids.ore.velocity = "1 mm/s"
solids.coke.velocity = "1 mm/s"
"""


def test_the_scene_without_mistakes_is_planned():
    text = str(plan(loads(GOOD)))
    assert (
        "ore (0.6 of the volume, 10 mm), coke (0.4 of the volume, 30 mm); Sauter mean "
        "13.64 mm" in text
    )
    assert "at the particles, coke" in text and "FeO_ore, Fe_ore, C_coke" in text


@each_case(__file__, "mistakes")
def test_mistakes(old, new, said):
    assert old in GOOD
    with pytest.raises(SceneError, match=r".*:\d+: ") as error:
        loads(GOOD.replace(old, new))
    assert said in str(error.value)


def test_a_reaction_without_solids_names_its_kind():
    text = (
        GOOD
        + '[reactions.oxidation]\nequation = "2 CO + O2 -> 2 CO2"\nA = 1.0\nE = 0.0\n'
        'basis = "catalyst"\n'
    )
    text = text.replace("CO2 = { heat", "O2 = { heat_capacity = 30.0 }\nCO2 = { heat")
    refused(
        r":\d+: reactions.oxidation.solid: missing; .* name their phase, of ore, coke",
        lambda: plan(loads(text)),
    )


def test_solids_are_needed():
    text = (
        GOOD.split("[solids.ore]")[0]
        + GOOD[GOOD.index("[packed_bed]") : GOOD.index("[boundary.right]")]
    )
    refused(r"solids: this table is missing", loads, text)


FORMER = """
[fluid]
model = "ideal_gas"
composition = "CO:0.5, CO2:0.5"
[bed]
porosity = 0.4
particle_diameter = "10 mm"
[flow]
velocity = 0.5
[solid]
composition = "FeO:1"
[heat]
nusselt = 5.0
[mass]
sherwood = 3.0
[wall]
diameter = 0.1
coefficient = 5.0
[particle]
adsorption = "film"
[adsorption.CO]
henry = 1e-5
[time]
end = 1.0
initial_composition = "CO:1"
gas = "stored"
[boundary.left.fluid]
inflow = 300.0
"""


@each_case(__file__, "former_keys_name_the_present_ones")
def test_former_keys_name_the_present_ones(line, said):
    with pytest.raises(SceneError) as error:
        loads(FORMER + "[mesh]\ntype = 'line'\nlength = 1.0\n", "bed.toml")
    key, text = said.split(": ", 1)
    assert any(
        row.startswith(f"bed.toml:{line}: {key}") and text in row
        for row in error.value.problems
    )
