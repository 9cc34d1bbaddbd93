"""Scenes of particles in a gas that exchange no heat, and jets by their velocity."""

from __future__ import annotations

import numpy as np
import pytest

import contbed as cb
from contbed.errors import SceneError
from contbed.loading import loads
from tests.cases import each_case

RHO, SPEED = 1.25, 4.0
SCENE = """
particles = { count = 60, width = ["12 mm", "12 mm"], height = "40 mm", modulus = "1 MPa", seed = 3 }
solids.glass = { diameter = "2 mm", density = 2500 }
gas = { density = 1.25, viscosity = 1.8e-5 }
boundary.bottom.gas = { velocity = 1.0, temperature = 400.0 }
boundary.jet = { start = 0.004, end = 0.008, gas = { velocity = 4.0 } }
time = { end = 0.02, sample = 0.01 }
output = { plots = false, fields = false }
"""
JET = "gas = { velocity = 4.0 }"
WITH_HEAT = SCENE.replace(
    "1.8e-5", "1.8e-5, heat_capacity = 1e3, conductivity = 0.026"
).replace("2500", "2500, conductivity = 0.84")


def test_a_jet_by_its_velocity_is_that_by_its_flux_and_coefficients_change_no_flow():
    """Bit for bit: 4 m/s of 1.25 kg/m3 are 5 kg/m2/s, at the temperature of the gas
    from below.
    """
    flux = f"gas = {{ mass_flux = {RHO * SPEED}, temperature = 400.0 }}"
    plain = cb.run(loads(SCENE))
    other = cb.run(loads(WITH_HEAT.replace(JET, flux) + 'closures.nusselt = "gunn"\n'))
    for name, column in plain.profiles.items():
        assert np.array_equal(column, other.profiles[name]), name
    coefficients = {name for name in other.qoi if name.startswith("h_")}
    assert len(coefficients) > 4 and set(other.qoi) - set(plain.qoi) == coefficients
    assert [use["kind"] for use in plain.closures] == ["drag"]


@each_case(__file__, "what_does_not_fit_together_is_named")
def test_what_does_not_fit_together_is_named(old, new, said):
    text = f"{SCENE}[heat]\n".replace(old, new, 1).replace("[heat]\n", "")
    with pytest.raises(SceneError) as error:
        loads(text)
    assert any(said in problem for problem in error.value.problems), (
        error.value.problems
    )
