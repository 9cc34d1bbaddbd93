"""The two-energy equations at their limits: layers, insulating phases, time steps,
properties over decades.
"""

from typing import Any

import numpy as np
import pytest

import contbed as cb
from contbed.loading import from_dict
from studies.stress import study
from tests.balances import assert_closed
from tests.scene_text import scene_of, set_keys

Case = study.Case

# every 29th case: 29 shares no factor with the numbers of values, so that each value of
# each number is met
THIN = list(study.cases())[::29]


def test_the_sample_meets_every_value():
    for name, values in (
        ("peclet", study.PECLET),
        ("ntu", study.NTU),
        ("ratio", study.RATIO),
        ("slip", study.SLIP),
    ):
        assert {getattr(case, name) for case in THIN} == set(values)
    assert {case.insulating for case in THIN} == set(study.INSULATING)


# 1e-3 is what a user asks of 100 nodes; the balance is checked to 1e-10 by the run
# itself
@pytest.mark.parametrize("case", THIN, ids=str)
def test_graded_cells_meet_the_exact_solution(case):
    assert max(study.measure(case)) <= study.TOLERANCE


@pytest.mark.slow
def test_the_whole_table():
    table = study.compute()["stress"]
    assert len(table) == len(list(study.cases()))
    assert study.missed(table) == []


def test_a_temperature_that_nothing_carries_in_is_left_out_and_told():
    result = cb.run(from_dict(study.scene(Case(10.0, 100.0, 1.0, 0.0, "solid"))))
    assert result.warnings == [
        "boundary.left.solids.particles.fixed_temperature has no effect: the solid "
        "neither conducts nor enters there"
    ]
    # nothing heats the bed; 1e-9 is the rounding of the temperatures times the exchange
    assert np.abs(result.profiles["theta_solid [1]"]).max() < 1e-9


TRANSIENT = [
    Case(1.0, 1.0, 10.0, 0.5, "none"),
    Case(1e3, 1e4, 10.0, 0.5, "none"),
    Case(1e3, 1e2, 10.0, -1.0, "none"),
    Case(10.0, 1e6, 1.0, -0.25, "both"),
    Case(10.0, 1e2, 1.0, 0.5, "both"),
    Case(1e3, 1e6, 1.0, 0.0, "fluid"),
    Case(1e3, 1e2, 1.0, 0.0, "both"),
]


def transient(case: Any, end: float, **time: float) -> Any:
    values = study.scene(case)
    values["time"] = {"end": end, **time}
    # what the phases exchange is NTU times what the flow carries, and so is its rounding
    closed = max(1e-10, 1e-15 * case.ntu)
    values.setdefault("solver", {})["balance_tolerance"] = closed
    values["initial"] = {
        "gas": {"temperature": 300.0},
        "solids": {"particles": {"temperature": 320.0}},
    }
    return cb.run(from_dict(values))


@pytest.mark.parametrize("case", TRANSIENT, ids=str)
@pytest.mark.parametrize(
    "end, steps", [(1e-8, 10), (1.0, 100), (1e3, 1), (1e6, 1)], ids=str
)
def test_time_steps_of_any_size(case, end, steps):
    """In units of the fluid's residence time. The run itself checks the balance, to
    1e-10 or 1e-15 NTU.
    """
    result = transient(case, end, step=end / steps)
    assert result.qoi["time_steps"] == steps
    overshoot = result.qoi["theta_overshoot"]
    # an unresolved front may overshoot, by less than the jump of 0.2 that starts it,
    # but not unseen
    assert overshoot < 0.2
    assert any("theta leaves" in text for text in result.warnings) == (overshoot > 1e-3)
    if steps == 1:
        # L-stable: one step of t leaves the initial jump times (relaxation time)/t;
        # none relaxes in more than 30
        steady = cb.run(from_dict(study.scene(case)))
        assert difference(result, steady) <= 30.0 / end


@pytest.mark.parametrize(
    "case",
    [
        TRANSIENT[0],
        TRANSIENT[2],
        *(pytest.param(c, marks=pytest.mark.slow) for c in TRANSIENT[3:]),
    ],
    ids=str,
)
def test_the_steady_state_is_the_limit_of_long_times(case):
    # 1e5 residence times reach the steady state to round-off; 1e-6 is what is asked
    assert (
        difference(
            transient(case, 1e5, tolerance=1e-4), cb.run(from_dict(study.scene(case)))
        )
        <= 1e-6
    )


def difference(one: Any, other: Any) -> float:
    return max(
        float(np.abs(one.profiles[k] - other.profiles[k]).max())
        for k in ("theta_fluid [1]", "theta_solid [1]")
    )


def hot(
    T_fluid: float, T_solid: float, gas: str, slip: int, walls: bool
) -> dict[str, Any]:
    """Gas through ceramic particles with radiation; the solid enters with or against
    the gas. SI.
    """
    values: dict[str, Any] = scene_of(
        """
        [mesh]
        type = "line"
        length = 0.5
        [gas]
        model = "cantera"
        [solids.particles]
        density = 2200.0
        heat_capacity = [560.0, 0.75, -1e-4]
        conductivity = [1.0, 1e-3]
        diameter = 5e-3
        [packed_bed]
        porosity = 0.4
        [closures]
        nusselt = "wakao_kaguei"
        conductivity_solids.name = "zehner_bauer_schluender"
        conductivity_solids.emissivity = 0.9
        dispersion = "wakao_kaguei"
        [heat]
        [boundary.left]
        gas.velocity = 0.5
        """,
        {"gas.composition": gas, "boundary.left.gas.temperature": T_fluid},
    )
    values["boundary"].setdefault("left" if slip > 0 else "right", {})["solids"] = {
        "particles": {"velocity": abs(slip) * 8e-4, "temperature": T_solid}
    }
    if walls:
        values["mesh"] = {
            "type": "rectangle",
            "length": 0.5,
            "height": 0.1,
            "cells": [30, 10],
            "graded": True,
        }
        values["boundary"]["bottom"] = {"type": "no_slip"}
        values["boundary"]["top"] = {
            "type": "no_slip",
            "solids": {"particles": {"fixed_temperature": T_solid}},
        }
    return values


STEAM, AIR = "H2O:1", "N2:0.79, O2:0.21"


@pytest.mark.parametrize(
    "walls",
    [False, pytest.param(True, marks=pytest.mark.slow)],
    ids=["plug", "computed flow"],
)
@pytest.mark.parametrize("slip", [1, -1], ids=["co-current", "counter-current"])
@pytest.mark.parametrize("gas", [STEAM, AIR])
@pytest.mark.parametrize("T", [(300.0, 2000.0), (2000.0, 300.0)], ids=str)
def test_newton_from_a_cold_start(T, gas, slip, walls):
    result = cb.run(from_dict(hot(*T, gas, slip, walls)))
    # at most six norms for each problem, as quadratic convergence has it; a computed
    # flow and the temperatures that its properties follow are solved in turn, at most
    # eleven times here
    begins = [k for k, norm in enumerate(result.history) if norm == 1.0]
    assert max(np.diff([*begins, len(result.history)])) <= 6
    assert len(begins) <= (22 if walls else 1) * (1 + result.adaptations)
    assert_closed(result, 1e-10)
    assert result.qoi["theta_overshoot"] <= 1e-3


def test_newton_from_a_cold_start_with_computed_flow():
    """The one of the slow cases in which Newton with full steps leaves the positive
    temperatures.
    """
    result = cb.run(from_dict(hot(2000.0, 300.0, STEAM, -1, walls=True)))
    assert_closed(result, 1e-10)
    # of flow and temperatures in turn
    starts = [k for k, norm in enumerate(result.history) if norm == 1.0]
    assert max(np.diff([*starts, len(result.history)])) <= 12


def test_continuation_takes_over_where_newton_gives_up():
    values = hot(300.0, 2000.0, AIR, -1, walls=False)
    set_keys(values, "mesh.cells = 40")
    found = cb.run(from_dict(values))
    set_keys(values, "solver = { newton_iterations = 2 }")
    relaxed = cb.run(from_dict(values))
    # both solve the same discrete equations to 1e-10 of the temperatures
    np.testing.assert_allclose(
        relaxed.profiles["T_fluid [K]"], found.profiles["T_fluid [K]"], rtol=1e-9
    )


def test_hot_transient_closes_its_balance():
    values = hot(300.0, 2000.0, STEAM, -1, walls=False)
    set_keys(
        values,
        """
        mesh.cells = 30
        time = { end = 200.0, step = 20.0 }
        initial = { temperature = 300.0 }
        """,
    )
    result = cb.run(from_dict(values))
    assert_closed(result, 1e-10, "energy")
