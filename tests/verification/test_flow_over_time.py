"""Flow beside no-slip walls with the properties of the local temperature, while a
bed cools or warms up.
"""

from __future__ import annotations

import numpy as np
import pytest
from moving_beds import started
from pytest import approx

import contbed as cb
from contbed.course import dirk
from contbed.errors import ContbedError, ConvergenceError
from contbed.loading import from_dict
from contbed.output.progress import Progress
from contbed.packed_bed import local_flow
from tests.balances import assert_closed
from tests.restarts import interrupt, same_run
from tests.scene_text import scene_of


def cooling(end, **more):
    """A hot bed of light particles between two walls, cooled by nitrogen within some
    seconds.
    """
    return from_dict(
        scene_of(
            """
                packed_bed = { porosity = 0.4 }
                closures = { nusselt = 10.0 }
                heat = {}
                output = { plots = false, fields = false }

                [mesh]
                type = "rectangle"
                length = 0.3
                height = 0.06
                cells = [6, 2]

                [gas]
                model = "cantera"
                composition = "N2:1"
                mechanism = "gri30.yaml"

                [solids.particles]
                density = 10.0
                heat_capacity = 900.0
                conductivity = 1.0
                diameter = 5e-3

                [boundary]
                left = { gas = { velocity = 0.5, temperature = 300.0 } }
                bottom = { type = "no_slip" }

                [boundary.top]
                type = "no_slip"
                solids = { particles = { coefficient = 100.0, ambient = 900.0 } }
            """,
            {
                "time": {"end": end} | more.pop("time", {}),
                "initial": started(900.0, 900.0),
            },
        )
        | more
    )


def test_the_flow_ends_as_that_of_the_steady_state():
    """Largest velocity and pressure drop of the steady bed on these cells, whose flow
    has the local properties as well: 5e-3, a quarter of the change of properties that
    the last flow does not know of. Mass is conserved at any time.
    """
    result = cb.run(cooling(60.0, time={"tolerance": 5e-2}))
    steady = cooling(60.0).model_copy(update={"time": None})
    wanted = cb.run(steady).qoi
    for name in ("u_max", "pressure_drop_Pa", "T_fluid_out_K"):
        assert result.qoi[name] == approx(wanted[name], rel=5e-3)
    assert result.qoi["flow_solutions"] > 10
    assert local_flow.CHANGE < result.qoi["flow_change"] < local_flow.LAGS
    assert_closed(result, 1e-12, "fluid volume")
    assert_closed(result, 1e-10, "energy")
    assert not any("density of the fluid changes" in text for text in result.warnings)


@pytest.mark.slow
def test_the_flow_starts_with_the_initial_temperatures():
    """Until the bed has cooled, nitrogen of 900 K has three times the velocity and
    more of the pressure drop.
    """
    start = cb.run(cooling(1e-4, time={"tolerance": 0.5})).qoi
    cold = cb.run(
        cooling(1e-4, time={"tolerance": 0.5}, initial=started(300.0, 300.0))
    ).qoi
    assert start["u_max"] == approx(3.0 * cold["u_max"], rel=0.05)
    assert start["pressure_drop_Pa"] > 2.5 * cold["pressure_drop_Pa"]


def test_mass_flux_of_a_gas_that_enters_hotter():
    """Nitrogen that warms from 300 to 600 K at a given velocity: it has the same
    velocity at the inlet at the end, and carries in the integral of u rho h over time,
    with p M/(R T) and 1040 to 1075 J/kg/K; to 2 %, the spread of c_p.
    """
    ramp = {"times": [0.0, 1.0], "values": [300.0, 600.0]}
    boundary = {
        "left": {"gas": {"velocity": 0.5, "temperature": ramp}},
        "bottom": {"type": "no_slip"},
        "top": {"type": "no_slip"},
    }
    scene = cooling(
        1.0, boundary=boundary, time={"tolerance": 1e-2}, initial=started(300.0, 300.0)
    )
    result = cb.run(scene)
    of_one = 0.5 * 0.06 * 101325.0 * 0.028014 / 8.314463 * 1050.0
    entered = of_one * (1.0 - np.log(2.0))
    space, velocity = result.nodal["u"]
    np.testing.assert_allclose(velocity[0, space.points[0] == 0.0], 0.5, rtol=0.02)
    assert result.balances["fluid volume"]["in"] == approx(0.03, rel=1e-12)
    assert result.balances["energy"]["in"] == approx(entered, rel=0.02)
    assert_closed(result, 1e-10, "energy")


@pytest.mark.slow
def test_the_flow_has_a_first_order_error(monkeypatch):
    """Temperatures with the flow solved after every step against `CHANGE`: below 3e-3
    of theta.

    Both take steps of their own, which differ by less than that at this tolerance.
    """
    found = {}
    for change in (0.0, local_flow.CHANGE):
        monkeypatch.setattr(local_flow, "CHANGE", change)
        result = cb.run(cooling(2.0, time={"tolerance": 1e-3}))
        found[change] = result.profiles["T_solid [K]"]
    assert 1e-5 < np.abs(found[0.0] - found[local_flow.CHANGE]).max() / 600.0 < 3e-3


@pytest.mark.slow
def test_a_restarted_run_keeps_its_flow(tmp_path):
    """Interrupted after some steps and continued: the same bytes as without."""
    scene = cooling(2.0, time={"tolerance": 1e-1})
    interrupt(scene, tmp_path, Progress, "advance_to", 9)
    same_run(cb.run(scene, out=tmp_path, restart=tmp_path), cb.run(scene))


@pytest.mark.slow
def test_jumps_that_are_too_large_are_told(monkeypatch):
    """A bed that changes before the flow is solved again: the lag of the flow has a
    number and a remedy.
    """
    monkeypatch.setattr(local_flow, "CHANGE", 0.5)
    result = cb.run(cooling(10.0, time={"tolerance": 0.5}))
    (text,) = (
        text for text in result.warnings if "with the flow from before it" in text
    )
    assert "lower time.tolerance or time.step" in text


def test_a_step_in_which_newton_fails_is_made_shorter(monkeypatch):
    """The run goes on with a shorter step; at the shortest, or with given steps, it
    ends.
    """
    take, failed = dirk._Stages.take, []

    def fails(self, state, start, end, dt):
        if dt > 0.05:
            failed.append(dt)
            raise ConvergenceError("time step: no descent", [])
        return take(self, state, start, end, dt)

    monkeypatch.setattr(dirk._Stages, "take", fails)
    result = cb.run(cooling(0.3, time={"tolerance": 0.5}))
    assert failed
    assert result.qoi["time_reached_s"] == 0.3
    with pytest.raises(ContbedError, match="no descent"):
        cb.run(cooling(0.3, time={"step": 0.1}))
