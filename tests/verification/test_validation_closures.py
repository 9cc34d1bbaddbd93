"""Scatter of closures in the band of a prediction: a larger closure is a bed that
conducts better.
"""

import numpy as np
import pytest

from contbed.closures import binding
from contbed.many.validate.case import read_case
from contbed.many.validate.score import at, validate
from contbed.runner import run
from tests.refusals import refusal

SCENE = """\
mesh = { type = "line", length = 0.05, cells = 10 }

[gas]
density = 1.2
heat_capacity = 1000.0
conductivity = 0.03
viscosity = 2e-5

[solids.particles]
density = 2000.0
heat_capacity = 900.0
conductivity = 5.0
diameter = "1 mm"

[packed_bed]
porosity = 0.4

[closures]
nusselt = 0.0
conductivity_gas = 0.0
conductivity_solids = "conductivity_parallel"

[heat]

[boundary.left]
solids.particles.fixed_temperature = 400.0

[initial]
gas.temperature = 300
solids.particles.temperature = 300

[time]
end = 100
"""
CASE = """\
title = "a slab"
source = "closed form"
licence = "none"
scene = "scene.toml"
quantity = "T_solid"
uncertainty = "1 K"
[measured]
file = "measured.csv"
column = "T"
time = "t"
position = "x"
[uncertain_closures]
conductivity = "10 %"
"""


@pytest.fixture
def slab(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "case.toml").write_text(CASE)
    (tmp_path / "measured.csv").write_text(
        "t [s],x [mm],T [K]\n50,10,320\n50,20,310\n100,10,330\n100,30,310\n"
    )
    return tmp_path


def test_band_is_that_of_both_conductivities(slab):
    """The law is linear in both conductivities: 10 % of it are 10 % of each; nothing
    else depends on them here.
    """
    case = read_case(str(slab))
    found = validate(case).compared
    low, high = (
        at(
            case,
            run(
                case.scene(
                    **{
                        "solids.particles.conductivity": 5.0 * factor,
                        "gas.conductivity": 0.03 * factor,
                    }
                )
            ),
            case.points.t,
            case.points.x,
        )
        for factor in (0.9, 1.1)
    )
    assert (high - low > 0.5).all()
    assert found.band == pytest.approx(0.5 * (high - low), rel=1e-6)
    assert found.influence["closure of kind conductivity"] == pytest.approx(
        np.sqrt(np.mean(found.band**2)), rel=1e-12
    )


def test_the_factor_ends_with_its_context():
    gives = ("k_fluid", "k_solid", "eps")
    with binding.scaled({"conductivity": 2.0, "nusselt": 3.0}):
        doubled = binding.bind("parallel", "conductivity", gives)
    plain = binding.bind("parallel", "conductivity", gives)
    known = {"k_fluid": 0.025, "k_solid": 1.0, "eps": 0.4}
    assert doubled(**known) == 2.0 * plain(**known)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "conductivity =",
            "conductivty =",
            "case.toml:13: uncertain_closures.conductivty: no such kind of closure",
        ),
        (
            '"10 %"',
            '"10 K"',
            'case.toml:13: uncertain_closures.conductivity: expected a share like "9 '
            '%", found "10 K"',
        ),
    ],
)
def test_mistakes(slab, old, new, words):
    (slab / "case.toml").write_text(CASE.replace(old, new))
    assert words in refusal(lambda: validate(read_case(str(slab))))
