"""Mistakes in scenes with several kinds of particles: what is wrong, where, and the
remedy.
"""

from __future__ import annotations

import pytest

from contbed.errors import SceneError
from contbed.loading import loads
from contbed.models import plan
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


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "volume_share = 0.4",
            "volume_share = 0.5",
            "solids: the shares of the volume sum to 1.1, not to 1",
        ),
        (
            '"30 mm"',
            '"30 m"',
            'solids.coke.diameter = "30 m": 30 m is more than the length of the bed',
        ),
        (
            "[solids.ore]",
            "[solid]\ndensity = 1.0\n[solids.ore]",
            "this key is called 'solids.NAME' now",
        ),
        ("solids.coke", "solids.coke_1", "letters and digits in its name"),
        (
            'equation = "C + CO2',
            'solid = "coal"\nequation = "C + CO2',
            "there is no solid phase 'coal'; allowed: ore, coke",
        ),
        (
            "[reactions.boudouard]",
            '[reactions.boudouard]\nbasis = "bed"\nsolid = "coke"',
            "is not that of a phase",
        ),
        (
            'composition = "C:1"',
            'composition = "C:0.8"',
            'solids.coke.composition = "C:0.8": fractions sum to 0.8',
        ),
        (
            "density = 1000.0\n",
            "",
            "solids.coke.density: missing; or give solids.coke.constituent.C.density",
        ),
        (
            'solids.coke.velocity = "1',
            'solids.coke.velocity = "-1',
            "solid phases that move go one way",
        ),
        ('solids.coke.velocity = "1 mm/s"', "", "takes C of particles at rest"),
        (
            "density = 1000.0",
            "density = 1000.0\nnusselt = 3.0",
            "add closures.nusselt, which holds for the other phases",
        ),
        (
            "density = 1000.0",
            "density = 1000.0\nsherwood = 3.0",
            "has no meaning without closures.sherwood",
        ),
        (
            "{ C = {",
            "{ FeO = { heat_capacity = 51.0 }, C = {",
            "has other data in solids.ore",
        ),
        (
            "solids.coke.velocity",
            "solids.coal.velocity",
            "no such solid phase; allowed: ore, coke",
        ),
        (
            "gas.velocity = 0.5",
            "gas.velocity = 0.5\nsolids.ore.velocity = 0.001",
            "gives it already; remove one",
        ),
        (
            "gas.temperature",
            "solids.ore.temperature = 300.0\ngas.temperature",
            "ore does not enter here",
        ),
    ],
)
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


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (2, "fluid: this key is called 'gas' now"),
        (6, "bed.porosity: this key is called 'packed_bed.porosity' now"),
        (7, "bed.particle_diameter: this key is called 'solids.NAME.diameter' now"),
        (9, "flow.velocity: give boundary.NAME.gas.velocity where the gas enters"),
        (10, "solid: this key is called 'solids.NAME' now"),
        (13, "heat.nusselt: this key is called 'closures.nusselt' now"),
        (15, "mass.sherwood: this key is called 'closures.sherwood' now"),
        (17, "wall.diameter: this key is called 'mesh.diameter' now"),
        (18, "wall.coefficient: this key is called 'boundary.wall.coefficient' now"),
        (19, "particle: this key is called 'solids.NAME.inside' now"),
        (21, "adsorption: this key is called 'solids.NAME.adsorption' now"),
        (
            25,
            "time.initial_composition: this key is called 'initial.gas.composition' now",
        ),
        (26, "time.gas: this key is called 'packed_bed.gas_storage' now"),
        (
            28,
            "boundary.left.fluid.inflow: this key is called "
            "'boundary.left.gas.temperature' now",
        ),
    ],
)
def test_former_keys_name_the_present_ones(line, said):
    with pytest.raises(SceneError) as error:
        loads(FORMER + "[mesh]\ntype = 'line'\nlength = 1.0\n", "bed.toml")
    key, text = said.split(": ", 1)
    assert any(
        row.startswith(f"bed.toml:{line}: {key}") and text in row
        for row in error.value.problems
    )
