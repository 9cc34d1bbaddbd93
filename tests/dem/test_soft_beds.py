"""Spheres too soft for the weight of their bed: the estimate, and the warning of
scenes.

Exact: a simple cubic lattice under a pressure, where each contact bears p d^2.
    Measured: two packings that settle soft
and stiff; the estimate has one pressure and one number of contacts for all depths, so
that a third of the difference is all it is good for.
"""

import re
from pathlib import Path

import numpy as np
import pytest

import contbed as cb
from contbed.dem.packing import pack
from contbed.dem.particles import Material
from contbed.dem.scene import SOLID_SHARE
from contbed.dem.softness import denser_by_weight, overlap_by_pressure
from contbed.loading import loads
from tests.imported import modules_after

RADIUS = 1e-3
PACKING = """
[particles]
modulus = "10 MPa"

[particles.packing]
count = 700
width = ["12 mm", "12 mm"]

[solids.spheres]
diameter = "2 mm"
conductivity = 1.4
youngs_modulus = "10 MPa"
"""
GAS = (Path(cb.__file__).parent / "cfd_dem" / "template.toml").read_text()


def test_overlap_in_a_simple_cubic_lattice():
    """Round-off: F = p d^2 = 4/3 E* sqrt(R/2) delta^1.5."""
    material, pressure = Material(2500.0, 3e6, 0.2), 40.0
    # 6 contacts as in a random bed, which has more spheres in a volume
    more = SOLID_SHARE / (np.pi / 6.0)
    overlap = overlap_by_pressure(more * pressure, RADIUS, material)
    modulus = material.youngs_modulus / (2.0 * (1.0 - 0.2**2))
    force = 4.0 / 3.0 * modulus * np.sqrt(0.5 * RADIUS) * overlap**1.5
    assert force == pytest.approx(pressure * (2.0 * RADIUS) ** 2, rel=1e-12)


def test_soft_packings_are_denser():
    heights, estimates = [], []
    for modulus in (2e5, 1e7):
        material = Material(2500.0, modulus, restitution=0.5)
        packing = pack(
            (8e-3, 8e-3),
            radius=RADIUS,
            count=350,
            seed=1,
            material=material,
            periodic=(True, True),
        )
        heights.append(packing.statistics["surface"])
        estimates.append(denser_by_weight(heights[-1], RADIUS, material))
    assert heights[1] / heights[0] - 1.0 == pytest.approx(
        estimates[0] - estimates[1], rel=1.0 / 3.0
    )


@pytest.mark.parametrize(
    ("text", "key"), [(PACKING, "particles.modulus"), (GAS, "particles.modulus")]
)
def test_scenes_of_soft_beds_are_told_the_modulus_that_is_enough(text, key):
    """A tenth more than the modulus of the warning, which has two digits, is enough,
    and a tenth less is not.
    """

    def told(modulus):
        return [
            line
            for line in loads(text, overrides={key: modulus}).warnings
            if key in line
        ]

    assert not told(1e7)
    (warning,) = told(1e4)
    enough = float(re.search(r"(\S+) Pa keep", warning)[1])
    assert 1e4 < enough < 1e7 and told(0.9 * enough) and not told(1.1 * enough)


@pytest.mark.parametrize("folder", ["dem", "cfd_dem"])
def test_checks_load_no_compiled_code(folder):
    """What only compares numbers of a scene does not wait for numba."""
    assert "numba" not in modules_after(f"import contbed.{folder}.checks")
