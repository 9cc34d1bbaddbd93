"""A warning of fronts that a fluid which expands moves at another speed."""

import pytest

import contbed
from contbed.loading import loads

STORE = """
[mesh]
type = "line"
length = 4.0
cells = 40
[gas]
model = "coolprop"
name = "{name}"
pressure = 1e6
T_range = [{low}, {high}]
[solids.rock]
diameter = 0.02
density = 2500.0
heat_capacity = 900.0
conductivity = 5.0
[packed_bed]
porosity = 0.38
[heat]
[closures]
nusselt = 200.0
conductivity_gas = 1.0
[initial]
temperature = {start}
[time]
end = {end}
[boundary.left]
gas = {{ velocity = {velocity}, temperature = {enters} }}
"""
OIL = {"name": "INCOMP::TVP1", "low": 520.0, "high": 665.0, "end": 1800.0}
OIL |= {"velocity": 5e-4}


@pytest.mark.parametrize(
    ("start", "enters", "told"),
    [
        (563.15, 663.15, "2.7 % slower"),
        pytest.param(663.15, 563.15, "2.5 % faster", marks=pytest.mark.slow),
    ],
    ids=["charged", "discharged"],
)
def test_oil_in_a_store(start, enters, told):
    """Density and heat capacity of the oil by CoolProp: what a cubic metre holds with
    the density of the oil that enters, over its integral.
    """
    scene = loads(STORE.format(**OIL, start=start, enters=enters))
    (text,) = [each for each in contbed.run(scene).warnings if "expands" in each]
    assert "from 827.3 to 709" in text and told in text
