"""Beds at rest whose particles are used up, or heated, by the gas: exact profiles,
and totals that close.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import fixed_bed, heated, schumann, table

import contbed
from contbed.errors import SceneError
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.scene_text import set_keys

ROWS = [row for row in table("fixed_bed_gas_solid") if row["d"] < 1.0]
# steps to a local tolerance of 1e-4, of one order more than their estimate; the largest
# error of all rows is 1.02e-5
STEPS = 2e-5
CLOSED = 1e-12


def compared(row):
    scene = fixed_bed(*(row[key] for key in ("law", "f", "d", "r", "xi", "tau")))
    result = contbed.run(from_dict(scene))
    assert result.profiles["x_A [1]"][-1] == approx(row["y"], abs=STEPS)
    assert result.profiles["w_P [1]"][-1] == approx(row["X"], abs=STEPS)
    assert_closed(result, CLOSED)
    return result


def test_breakthrough_through_a_bed_that_is_used_up():
    row = next(
        row
        for row in ROWS
        if row["law"] == "bohart_adams" and (row["xi"], row["tau"]) == (2.0, 0.8)
    )
    result = compared(row)
    assert result.tables["outlet"]["t [s]"][-1] == approx(800.0)
    assert np.all(np.diff(result.tables["outlet"]["x_A [1]"]) > 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "row",
    ROWS,
    ids=lambda r: (
        f"{r['law']}-{r['f']:g}-{r['d']:g}-{r['r']:g}-{r['xi']:g}-{r['tau']:g}"
    ),
)
def test_gas_and_conversion_in_beds_at_rest(row):
    compared(row)


def test_heating_of_a_bed_by_a_gas():
    scene, eta_per_s = heated(4.0)
    scene["time"]["end"] = 5.0 / eta_per_s
    result = contbed.run(from_dict(scene))
    theta = (result.qoi["T_fluid_out_K"] - 300.0) / 300.0
    assert theta == approx(schumann(4.0, 5.0), abs=1e-4)
    assert_closed(result, CLOSED, "energy")


def test_steps_do_not_depend_on_how_far_a_bed_is_heated():
    """Errors refer to the temperatures of the scene: 4 K and 300 K take the same
    steps to the same share of them.
    """
    steps, thetas = [], []
    for rise in (4.0, 300.0):
        scene, eta_per_s = heated(4.0)
        scene["boundary"]["left"]["gas"]["temperature"] = 300.0 + rise
        scene["time"] |= {"end": 5.0 / eta_per_s, "tolerance": 1e-3}
        set_keys(scene, "mesh.cells = 6")
        result = contbed.run(from_dict(scene))
        steps.append(result.qoi["time_steps"])
        thetas.append((result.qoi["T_fluid_out_K"] - 300.0) / rise)
    assert abs(steps[0] - steps[1]) <= 2  # rounding may move a step
    assert thetas[0] == approx(thetas[1], abs=1e-5)


def test_phases_start_with_their_own_temperatures():
    """A gas that is not stored follows at once: only the start of the solids counts,
    and the run is that with this temperature for both, to the tolerance of a step.
    """
    scene, eta = heated(5.0)
    set_keys(scene, f"time.end = {4.0 / eta}")
    both = contbed.run(from_dict(scene))
    set_keys(scene, "initial.gas.temperature = 600.0")
    set_keys(scene, "initial.temperature = 450.0")
    set_keys(scene, "initial.solids.particles.temperature = 300.0")
    apart = contbed.run(from_dict(scene))
    for name in ("T_fluid_out_K", "heat_charged_J"):
        if name in both.qoi:
            assert apart.qoi[name] == approx(both.qoi[name], rel=1e-4)
    del scene["time"]
    with pytest.raises(SceneError, match="a steady bed has one first guess"):
        from_dict(scene)


def test_a_bed_of_one_temperature_starts_with_one():
    scene, eta = heated(5.0)
    set_keys(scene, f"time.end = {4.0 / eta}")
    set_keys(scene, "initial.gas.temperature = 600.0")
    del scene["closures"]["nusselt"]
    with pytest.raises(SceneError, match="gas and solids have one temperature; give"):
        from_dict(scene)
