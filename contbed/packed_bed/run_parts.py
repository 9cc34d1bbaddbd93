"""What steady and transient runs of a packed bed share: flow, problem of the
temperatures, balances and checks.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from contbed.balance import HELD_SHARE, Balance
from contbed.errors import ConvergenceError
from contbed.fem.probe import Line
from contbed.materials.common import extrapolation
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.schedule import PHASES, ScheduleInterval
from contbed.result import Result, beyond_ranges
from contbed.scene.boundary import conditions_of

OVERSHOOT = 1e-3  # share of the span of temperatures beyond which a warning is given


@dataclass(frozen=True)
class Solved:
    """What a run has solved: the `flow`, and `problem` and `state` of steady
    temperatures, None without [heat].

    `shares` are the sizes of all time steps of a transient over the length of each part
    of the run, `flows` the numbers of the steps before which the flow was solved anew.
    """

    line: Line
    problem: Any
    state: Any
    flow: Any
    shares: list[list[float]] | None = None
    flows: list[int] | None = None


def heat_problem(
    plan: Plan,
    flow: Any,
    result: Result,
    interval: ScheduleInterval | None = None,
    system: Any = None,
) -> Any:
    """Return the problem of the temperatures in a flow; `system` is that of an
    earlier one on this mesh.
    """
    from contbed.packed_bed.heat import HeatProblem

    with result.timed("heat setup"):
        problem = HeatProblem(plan, flow, interval, system)
    told = dict.fromkeys(problem.idle)
    result.warnings += [text for text in told if text not in result.warnings]
    return problem


def report_flow(plan: Plan, line: Line, flow: Any, result: Result) -> None:
    """Fill in the balance of the volume, the fields and the named results of a flow."""
    from contbed.packed_bed.flow import AT_REST
    from contbed.packed_bed.results import flow_findings

    # volumes at the density of the fluid that enters
    outflow = {name: flow.outflow(name) / flow.share for name in plan.mesh.boundaries}
    floor = 0.0
    # nothing crosses walls; what moves between them is the scale
    if "outlet" not in plan.roles.values():
        extents = np.ptp(plan.mesh.skfem.p, axis=1)
        floor = (plan.speed or AT_REST) * float(extents.prod() / extents.max())
    balance = Balance.of_fluxes((-v for v in outflow.values()), "m3/s", floor=floor)
    result.balances["fluid volume"] = balance.as_dict()
    result.nodal |= {
        "u": (flow.system.fields["u"][0], flow.expanded),
        "p": (flow.system.fields["p"][0], flow.pressure),
    }
    flow_findings(plan, line, flow, result)


def heat_balance(
    fluxes: Any,
    conducted: Any,
    source: float,
    stored: float,
    unit: str,
    held: float,
    both_ways: float | None = None,
) -> dict[str, Any]:
    """Return the balance of heat through boundaries and into prescribed temperatures.

    `held` is the heat that streams and bed hold, the scale of the balance; for
    `both_ways` see `Balance.of_fluxes`.
    """
    parts = [value for flux in fluxes.values() for value in flux.values()] + list(
        conducted.values()
    )
    floor = HELD_SHARE * held
    return Balance.of_fluxes(parts, unit, source, stored, floor, both_ways).as_dict()


def _require_physical(phase: str, material: Any, T: Any) -> None:
    """Raise ConvergenceError for temperatures [K] that no bed can have, or far
    beyond the data of the material.
    """
    lowest, highest = float(T.min()), float(T.max())
    if lowest <= 0.0:
        raise ConvergenceError(
            f"T_{phase} falls to {lowest:.4g} K: a source, a flux or a wall takes more "
            "heat than the bed holds; "
            "this is no steady or reachable state"
        )
    low, high = material.T_range
    span = high - low
    if isfinite(span) and not low - span <= lowest <= highest <= high + span:
        raise ConvergenceError(
            f"T_{phase} reaches {lowest if lowest < low - span else highest:.4g} K, "
            "beyond the properties of "
            f"{material.name}, {low:.6g} to {high:.6g} K, by more than their whole "
            "range: the result would mean nothing"
        )


def check_state(plan: Plan, problem: Any, states: list[Any], result: Result) -> None:
    """Record closure ranges at the last state, and check material ranges and bounds of
    theta over all states.

    Nothing is clipped.
    """
    if not states:
        return
    result.closures = [use.to_dict() for use in plan.medium.ranges()]
    result.warnings += beyond_ranges(result.closures)
    for phase in PHASES:
        material = getattr(plan.medium, phase)
        values = problem.system.part(states[-1], f"T_{phase}")
        if text := extrapolation(
            material.name, material.heat_capacity, material.T_range, values
        ):
            result.warnings.append(text)
        _require_physical(phase, material, values)
    beyond = overshoot(plan, problem, states)
    if beyond is None:
        return
    result.qoi["theta_overshoot"] = beyond
    if beyond > OVERSHOOT:
        given = getattr(plan.scene.mesh, "cells", None) is not None
        result.warnings.append(
            f"theta leaves [0, 1] by {beyond:.2g}: a layer is not resolved; refine the "
            f"mesh{' or leave out mesh.cells' if given else ''}"
        )


def overshoot(plan: Plan, problem: Any, states: list[Any]) -> float | None:
    """Return how far theta leaves [0, 1] in any of the states; None where sources or
    fluxes may take it out.
    """
    low, high = problem.T_span
    has_heat = problem.source() or any(
        condition.heat_flux for *_, condition in conditions_of(plan.scene.boundary)
    )
    if has_heat or high <= low:
        return None
    both = [
        problem.system.part(state, name)
        for state in states
        for name in ("T_fluid", "T_solid")
    ]
    beyond = max(max(float(T.max()) - high, low - float(T.min())) for T in both) / (
        high - low
    )
    return float(max(beyond, 0.0))
