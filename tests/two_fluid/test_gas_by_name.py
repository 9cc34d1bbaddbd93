"""Two fluids and developed flow whose gas is a material, a mixture of Cantera or a
fluid of CoolProp.
"""

import pytest
from pytest import approx

from contbed.loading import from_dict
from contbed.materials import gas_mixture
from tests.cases import each_case
from tests.imported import modules_after
from tests.refusals import refusal
from tests.scene_text import changed, scene_of

BED = scene_of(
    """
model = "two_fluid"
[mesh]
type = "rectangle"
length = 0.1
height = 0.4
cells = [4, 16]
[gas]
model = "cantera"
composition = "N2:0.79, O2:0.21"
[solids.beads]
diameter = 275e-6
density = 2500.0
heat_capacity = 800.0
[heat]
[boundary.left]
type = "wall"
[boundary.right]
type = "wall"
[boundary.bottom]
type = "inlet"
gas.velocity = 0.4
gas.temperature = 500.0
[boundary.top]
type = "outlet"
[initial]
gas.temperature = 600.0
solids.beads.volume_fraction = 0.5
[time]
end = 0.1
"""
)
RISER = scene_of(
    """
model = "developed_flow"
[gas]
model = "cantera"
composition = "N2:0.79, O2:0.21"
reference_temperature = 400.0
[solids.beads]
diameter = 1e-3
density = 2500.0
[boundary.wall]
solids.beads.specularity = 0.05
[developed_flow]
section = "channel"
radius = 0.0152
gas_velocity = 9.0
solids_mass_flux = 100.0
"""
)
COOLPROP = {"model": "coolprop", "name": "Air", "T_range": [300.0, 900.0]}
AIR = gas_mixture("N2:0.79, O2:0.21", 101325.0)


def properties(gas, T):
    """Density, viscosity, heat capacity and conductivity of a gas at a temperature."""
    return tuple(
        float(part(T))
        for part in (gas.density, gas.viscosity, gas.heat_capacity, gas.conductivity)
    )


def cold():
    """The bed without [heat]."""
    return changed(BED, {}, ("heat",))


@each_case(__file__, "properties_are_those_at_one_temperature")
def test_properties_are_those_at_one_temperature(changes, without, T):
    assert from_dict(changed(BED, changes, without)).fluid[:4] == approx(
        properties(AIR, T), rel=1e-12
    )


def test_the_two_libraries_agree_on_air():
    """CoolProp's air has argon: within 2 %."""
    found = from_dict(changed(BED, {"gas": COOLPROP})).fluid
    assert found[:4] == approx(properties(AIR, 600.0), rel=0.02)


@pytest.mark.parametrize("T", [600.0, "600 K"])
def test_a_reference_temperature_needs_no_range(T):
    given = {"model": "coolprop", "name": "Air"}
    alone = from_dict(changed(cold(), {"gas": given | {"reference_temperature": T}}))
    found = from_dict(changed(cold(), {"gas": COOLPROP | {"reference_temperature": T}}))
    assert alone.fluid[:4] == approx(found.fluid[:4], rel=1e-6)


def test_a_liquid_of_the_library():
    salt = {"material": "solar_salt", "material_temperature": "340 degC"}
    assert from_dict(changed(BED, {"gas": salt})).fluid.density == approx(
        2263.7234 - 0.636 * 613.15
    )


def test_developed_flow_takes_them_at_the_reference_temperature():
    assert from_dict(RISER).fluid[:4] == approx(properties(AIR, 400.0), rel=1e-12)


@pytest.mark.parametrize(
    ("scene", "changes", "without", "said"),
    [
        (cold(), {}, ("initial.gas.temperature", "boundary.bottom.gas.temperature"), "give gas.reference_temperature"),
        (BED, {"gas": COOLPROP | {"reference_temperature": 1000.0}}, (), "known from "
                                                                         "300 to 900 "
                                                                         "K, not at "
                                                                         "1000 K"),
        (BED, {"gas": {"density": 1.2, "viscosity": 1.8e-5}}, (), "gas.heat_capacity: "
                                                                  "missing; [heat] "
                                                                  "needs it"),
        (cold(), {"gas.density_law": "ideal_gas"}, (), "gas.density_law = "
                                                       "\"ideal_gas\": has no meaning "
                                                       "without"),
        (RISER, {}, ("gas.reference_temperature",), "give gas.reference_temperature"),
        (BED, {"solids.sand": {"diameter": 1e-3, "density": 2500.0}}, (), "one solid "
                                                                          "phase, [solids.NAME]; found"),
        (BED, {"initial.solids.beds.volume_fraction": 0.1}, (), "initial.solids.beds: "
                                                                "no such solid; "
                                                                "allowed: beads"),
        (RISER, {"boundary.wall.solids": {"sand": {"specularity": 0.1}}}, (), "boundary.wall.solids.sand: no such"),
    ],
)  # fmt: skip
def test_a_mistake_is_named(scene, changes, without, said):
    assert said in refusal(lambda: from_dict(changed(scene, changes, without)))


def test_a_gas_of_constants_imports_no_library():
    found = modules_after(
        "from contbed.loading import load; from contbed.models import MODELS, plan\n"
        "plan(load(MODELS['two_fluid'].template))"
    )
    assert "contbed.two_fluid.plan" in found
    assert not {"cantera", "CoolProp"} & found
