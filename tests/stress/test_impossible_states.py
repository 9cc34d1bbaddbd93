"""States that no bed can have end with exit code 3 and a sentence, never with status
ok.
"""

from __future__ import annotations

import json

import pytest

import contbed as cb
from contbed.errors import ConvergenceError
from contbed.loading import from_dict
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import scene_of


def scene(**more):
    """A bed at rest beside a stream, with given changes."""
    return (
        scene_of(
            """
        [mesh]
        type = "line"
        length = 1.0
        cells = 20
        [gas]
        density = 1.0
        heat_capacity = 1000.0
        conductivity = 0.05
        viscosity = 2e-5
        [solids.particles]
        density = 2000.0
        heat_capacity = 900.0
        conductivity = 1.0
        diameter = 0.01
        [packed_bed]
        porosity = 0.4
        [closures]
        nusselt = 10.0
        [heat]
        [boundary.left]
        gas.velocity = 0.3
        gas.temperature = 300.0
        """
        )
        | more
    )


def test_a_sink_that_takes_more_than_there_is(tmp_path):
    """The stream brings 300 W/m3/K/... of heat; the sink takes ten times of it:
    below 0 K, told and not ok.
    """
    with pytest.raises(
        ConvergenceError, match="takes more heat than the bed holds"
    ) as caught:
        cb.run(
            from_dict(scene(region={"bed": {"solids": {"heat_source": -1e6}}})),
            out=tmp_path,
        )
    assert caught.value.exit_code == 3
    assert (
        json.loads((tmp_path / "summary.json").read_text())["status"] == "not converged"
    )


REACTING = scene_of(
    """
[mesh]
type = "line"
length = 0.2
diameter = 0.05
[gas]
model = "ideal_gas"
composition = "N2:1"
species.N2.heat_capacity = 30.0
conductivity = 0.03
[solids.particles]
diameter = 0.003
density = 2000.0
heat_capacity = 800.0
[packed_bed]
porosity = 0.4
pressure_drop = "none"
[closures]
nusselt = 5.0
[heat]
[boundary.left]
gas.mass_flux = 0.5
gas.temperature = 400.0
[boundary.wall]
heat_flux = -1e6
"""
)


@pytest.mark.parametrize(
    "more", [{}, {"time": {"end": 400.0}}], ids=["steady", "in time"]
)
def test_a_wall_that_takes_more_than_a_reacting_bed_holds(more):
    with pytest.raises(
        ConvergenceError,
        match=r"T_\w+ falls to -[\d.e+]+ K: .* takes more heat than the bed holds",
    ):
        cb.run(from_dict(REACTING | more))


def test_far_beyond_the_data_of_a_gas():
    gas = {"model": "cantera", "composition": "N2:1"}
    with pytest.raises(ConvergenceError, match="by more than their whole range"):
        cb.run(
            from_dict(
                scene(gas=gas, region={"bed": {"solids": {"heat_source": 2.6e6}}})
            )
        )


@each_case(__file__, "values_that_cannot_be_meant")
def test_values_that_cannot_be_meant(change, wrong):
    refused(wrong, lambda: from_dict(scene(**change)))
