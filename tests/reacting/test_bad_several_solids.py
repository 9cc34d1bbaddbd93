"""Mistakes in scenes with several kinds of particles: what is wrong, where, and the remedy."""

from __future__ import annotations

import pytest

from contbed.errors import SceneError
from contbed.loading import loads
from contbed.models import plan

GOOD = """
[mesh]
type = "line"
length = 1.0
[fluid]
model = "ideal_gas"
composition = "CO:0.5, CO2:0.5"
[fluid.species]
CO = { heat_capacity = 30.0, enthalpy = -110e3 }
CO2 = { heat_capacity = 40.0, enthalpy = -393.5e3 }
[bed]
porosity = 0.4
[flow]
velocity = 0.5
velocity_solid = "-1 mm/s"
[boundary.left.fluid]
inflow = 900.0
[solids.ore]
volume_share = 0.6
particle_diameter = "10 mm"
composition = "FeO:1"
density = 3000.0
constituent = { FeO = { heat_capacity = 50.0 }, Fe = { heat_capacity = 30.0 } }
[solids.coke]
volume_share = 0.4
particle_diameter = "30 mm"
composition = "C:1"
density = 1000.0
constituent = { C = { heat_capacity = 10.0 } }
[reactions.reduction]
equation = "FeO + CO -> Fe + CO2"
A = 1e-3
E = "50 kJ/mol"
[reactions.boudouard]
equation = "C + CO2 -> 2 CO"
A = 1e-3
E = "50 kJ/mol"
"""


def test_the_scene_without_mistakes_is_planned():
    text = str(plan(loads(GOOD)))
    assert "ore (0.6 of the volume, 10 mm), coke (0.4 of the volume, 30 mm); Sauter mean 13.64 mm" in text
    assert "at the particles, coke" in text and "FeO_ore, Fe_ore, C_coke" in text


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("volume_share = 0.4", "volume_share = 0.5", "solids: the shares of the volume sum to 1.1, not to 1"),
        (
            "[bed]",
            '[bed]\nparticle_diameter = "3 mm"',
            'bed.particle_diameter = "3 mm": each kind of [solids] has its own',
        ),
        ('"30 mm"', '"30 m"', 'solids.coke.particle_diameter = "30 m": 30 m is more than the length of the bed'),
        ("[solids.ore]", "[solid]\ndensity = 1.0\n[solids.ore]", "one kind fills the bed already"),
        ("[solids.coke]", "[solids.coke_1]", "letters and digits only"),
        ('equation = "C + CO2', 'solid = "coal"\nequation = "C + CO2', "there is no kind 'coal'; allowed: ore, coke"),
        ("[reactions.boudouard]", '[reactions.boudouard]\nbasis = "bed"\nsolid = "coke"', "is not that of a kind"),
        ('composition = "C:1"', 'composition = "C:0.8"', 'solids.coke.composition = "C:0.8": fractions sum to 0.8'),
        ("density = 1000.0\n", "", "solids.coke.density: missing; or give solids.coke.constituent.C.density"),
        ("density = 1000.0", 'density = 1000.0\nvelocity_solid = "1 mm/s"', "kinds that move go one way"),
        ("density = 1000.0", "density = 1000.0\nvelocity_solid = 0.0", "takes C of particles at rest"),
        ("density = 1000.0", "density = 1000.0\nnusselt = 3.0", "give heat.nusselt, which the others have"),
        ("density = 1000.0", "density = 1000.0\nsherwood = 3.0", "has no meaning without mass.sherwood"),
        ("{ C = {", "{ FeO = { heat_capacity = 51.0 }, C = {", "has other data in solids.ore"),
        ("[flow]", "[adsorption.CO]\nhenry = 1.0\ndiffusivity = 1e-6\n[flow]", "give solids.NAME.adsorption.CO"),
        ("[flow]", "[particle]\ndiffusivity = { CO = 1e-6 }\n[flow]", "give solids.NAME.diffusivity.CO"),
    ],
)
def test_mistakes(old, new, said):
    assert old in GOOD
    with pytest.raises(SceneError, match=r".*:\d+: ") as error:
        loads(GOOD.replace(old, new))
    assert said in str(error.value)


def test_a_reaction_without_solids_names_its_kind():
    text = GOOD + '[reactions.oxidation]\nequation = "2 CO + O2 -> 2 CO2"\nA = 1.0\nE = 0.0\nbasis = "catalyst"\n'
    text = text.replace("CO2 = { heat", "O2 = { heat_capacity = 30.0 }\nCO2 = { heat")
    with pytest.raises(SceneError, match=r":\d+: reactions.oxidation.solid: missing; .* name their kind, of ore, coke"):
        plan(loads(text))


def test_one_kind_takes_no_keys_of_several():
    text = GOOD.split("[solids.ore]")[0]
    with pytest.raises(SceneError, match=r"bed.particle_diameter: missing"):
        loads(text.replace('velocity_solid = "-1 mm/s"\n', ""))
