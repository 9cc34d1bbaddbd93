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


@pytest.mark.parametrize(
    ("end", "until", "times"),
    [
        (0.005, None, [0.002, 0.004, 0.005]),
        (0.0052, 0.009, [0.002, 0.004, 0.0052]),
        (0.006, 0.006 * (1.0 + 1e-12), [0.002, 0.004, 0.006]),
        (0.006, 0.003, [0.002, 0.003, 0.004, 0.006]),
        (0.0019, None, [0.0019]),
    ],
)
def test_a_run_ends_at_its_end_with_a_sample(end, until, times):
    """Also where the end is no multiple of the samples, and where the jet would end
    after it.
    """
    sample = min(end, 0.002)
    jet = JET if until is None else f"until = {until}, {JET}"
    time = f"end = {end}, sample = {sample}"
    scene = SCENE.replace("end = 0.02, sample = 0.01", time).replace(JET, jet)
    found = cb.run(loads(scene))
    # particles take whole steps, of some 30 us
    assert found.profiles["t [s]"] == pytest.approx(times, abs=4e-5)
    assert found.qoi["samples"] == len(times)


@each_case(__file__, "times_that_have_no_effect_are_told")
def test_times_that_have_no_effect_are_told(old, new, said):
    told = loads(SCENE.replace(old, new)).warnings
    assert any(said in text for text in told), told


def test_the_weight_of_a_bed_is_that_by_its_gravity():
    """60 spheres of 2 mm over 144 mm2; none without gravity."""
    weight = 60 * 2500 * np.pi / 6 * 8e-9 * 9.81 / 144e-6
    for more, expected in (("", weight), ("gravity = false, ", 0.0)):
        scene = SCENE.replace("count = 60", f"{more}count = 60, fixed = true")
        scene = scene.replace("end = 0.02, sample = 0.01", "end = 1e-3, sample = 1e-3")
        qoi = cb.run(loads(scene)).qoi
        assert qoi["bed_weight [Pa]"] == pytest.approx(expected, rel=1e-12)
