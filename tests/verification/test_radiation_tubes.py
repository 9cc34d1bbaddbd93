"""Tubes immersed in a radiating bed: a uniform field is a formula, and what they
take is in the balance.
"""

from __future__ import annotations

import numpy as np
import pytest

import contbed as cb
from contbed.closures.optics import (
    SIGMA,
    emissivity_immersed,
    radiation_emissivity_half_space,
)
from contbed.loading import loads
from tests.refusals import refused

SCENE = """
[mesh]
type = "{mesh}"
length = 0.4
{extent}
[gas]
density = 0.5
viscosity = 4e-5
heat_capacity = 1100
conductivity = 0.06
[solids.particles]
density = 2500
heat_capacity = 900
conductivity = 1.5
diameter = "2 mm"
emissivity = 0.7
{optics}
[packed_bed]
porosity = 0.45
[closures]
nusselt = {nusselt}
[heat]
[radiation]
[region.bed]
tubes = {{ area = 8, emissivity = 0.8, temperature = {tube} }}
[boundary.{inlet}]
gas = {{ velocity = 0.2, fixed_temperature = 1150 }}
solids.particles = {{ velocity = 0.001, fixed_temperature = 1150 }}
"""
LINE = {"mesh": "line", "extent": "", "inlet": "left"}


def test_a_black_bed_of_given_temperature_heats_tubes_as_the_closure_says():
    """Particles of given temperature only: G is uniform, K G = 4 K E - p eps_eff
    (G/4 - E_t). Round-off: 1e-12.
    """
    result = cb.run(
        loads(SCENE.format(**LINE, nusselt=10, optics="temperature = 1150", tube=550))
    )
    K = 0.7 * 1.5 * 0.55 / 0.002 / 0.45
    sink = 8 * emissivity_immersed(radiation_emissivity_half_space(0.3), 0.8)
    hot, cold = SIGMA * 1150.0**4, SIGMA * 550.0**4
    G = (4 * K * hot + sink * cold) / (K + sink / 4)
    np.testing.assert_allclose(result.profiles["G [W/m2]"], G, rtol=1e-12)
    assert result.qoi["heat_tubes_W"] == pytest.approx(
        -0.4 * sink * (G / 4 - cold), rel=1e-10
    )


@pytest.mark.parametrize(
    "case",
    [LINE, {"mesh": "axisymmetric", "extent": "radius = 0.1", "inlet": "bottom"}],
)
def test_tubes_cool_the_bed_and_the_balance_closes(case):
    """A run ends with an error if its balance is open by more than 1e-10; tubes as
    hot as the bed do nothing.
    """
    cooled = cb.run(loads(SCENE.format(**case, nusselt='"gunn"', optics="", tube=500)))
    level = cb.run(loads(SCENE.format(**case, nusselt='"gunn"', optics="", tube=1150)))
    assert cooled.qoi["T_solid_out_K"] < 1100
    assert cooled.qoi["heat_tubes_W"] < 0
    assert level.qoi["T_solid_out_K"] == pytest.approx(1150, abs=1e-6)
    assert level.qoi["heat_tubes_W"] == pytest.approx(
        0, abs=1e-6 * abs(cooled.qoi["heat_tubes_W"])
    )


@pytest.mark.parametrize("holds", ["tubes", "glowing"])
def test_what_radiates_holds_the_temperature_of_a_bed_at_rest(holds):
    """Nothing passes its ends: all heat released leaves to the tubes, or to particles
    of given temperature (round-off of 1e-9), and the bed is warmer than these.
    """
    text = SCENE.format(**LINE, nusselt=10, optics="", tube=500)
    text = text.partition("[boundary")[0] + "solids.heat_source = 2e5\n"
    if holds == "glowing":
        glowing = 'diameter = "2 mm"\nemissivity = 0.9\ntemperature = 900\n'
        shares = "volume_share = 0.9\n[solids.glowing]\nvolume_share = 0.1\n"
        text = text.replace("[packed_bed]", f"{shares}{glowing}[packed_bed]")
        text = "\n".join(row for row in text.split("\n") if "tubes" not in row)
    result = cb.run(loads(text))
    left = {"tubes": "heat_tubes_W", "glowing": "heat_species_W"}[holds]
    assert result.qoi[left] == pytest.approx(-0.4 * 2e5, rel=1e-9)
    assert result.qoi["T_solid_mean_K"] > {"tubes": 500, "glowing": 900}[holds]


def test_tubes_need_radiation():
    text = SCENE.format(**LINE, nusselt=10, optics="", tube=500).replace(
        "[radiation]\n", ""
    )
    refused(r"region.bed.tubes.*need \[heat\] and \[radiation\]", loads, text)
