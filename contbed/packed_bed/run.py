"""Run of a packed or moving bed: flow, then steady or transient heat, or its closed
form.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contbed.balance import Balance
from contbed.fem.probe import Line, line_along
from contbed.fields import distinct
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.pressure import compressed
from contbed.packed_bed.run_parts import (
    Solved,
    check_state,
    heat_balance,
    heat_problem,
    report_flow,
)
from contbed.packed_bed.schedule import PHASES
from contbed.result import Result

RESTART_MAY_CHANGE = (
    "time.end",
    "time.times",
    "time.checkpoint_every",
    "time.cycle.tolerance",
    "output",
    "solver.memory_GB",
)


def run(
    plan: Plan,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    """Solve and fill the result; a steady plan may be refined on the way.

    Parameters
    ----------
    folder : where checkpoints go; None for none
    start : arrays and numbers of a checkpoint to resume from

    Raises
    ------
    ConvergenceError : Newton or the time steps fail
    """
    _solve(plan, result, folder, quiet, start)
    held = any(table.temperature is not None for table in plan.scene.boundary.values())
    if not plan.plug or held:
        from contbed.packed_bed.missed_layers import heat_at_once, missed_layers

        result.warnings += [*missed_layers(plan), *heat_at_once(plan)]
    drop = result.qoi.get("pressure_drop_Pa")
    if drop is not None and (text := compressed(plan, drop)):
        result.warnings.append(text)


def _solve(
    plan: Plan,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    scene = plan.scene
    if plan.fronts:
        with result.timed("heat"):
            _schumann(plan, result)
        return
    # a cycle has those of its first guess
    names = ("vertices", "search.begin.vertices")
    if start is not None and (found := [name for name in names if name in start[0]]):
        plan = result.plan = plan.on([start[0][found[0]]])
    if scene.time is not None:
        from contbed.packed_bed.transient_run import run_transient

        line, flow = _line_and_flow(plan, None, result)
        run_transient(plan, line, flow, result, folder, quiet, start)
        return
    flow, estimate = None, None
    for attempt in range(plan.adaptations + 1):
        better, flow, estimate = on_one_mesh(
            plan, flow, estimate, attempt == plan.adaptations, result
        )
        if better is None:
            return
        plan = result.plan = better
        result.adaptations += 1


def _line_and_flow(plan: Plan, before: Any, result: Result) -> tuple[Line, Any]:
    """Return the line of the profiles, and the flow from that on the mesh `before`;
    None for plug flow.
    """
    scene, flow = plan.scene, None
    # before a matrix is assembled, which may take most
    plan.policy.check_memory(max(plan.unknowns().values(), default=0))
    # before anything is solved, as a line that leaves the mesh is a mistake of the
    # scene
    line = line_along(plan.mesh, scene.output.positions, scene.output.across)
    result.warnings += (
        [line.note] if line.note and line.note not in result.warnings else []
    )
    if not plan.plug:
        from contbed.packed_bed.flow import solved_flow

        with result.timed("flow"):
            flow = solved_flow(plan, before, result)
            report_flow(plan, line, flow, result)
    return line, flow


def on_one_mesh(
    plan: Plan, flow: Any, before: Any, last: bool, result: Result
) -> tuple[Plan | None, Any, Any]:
    """Solve a steady scene on the mesh of its plan; report it if that mesh is good
    enough or the `last` one.

    Parameters
    ----------
    flow, before : the flow and the estimated errors on the former mesh, or None

    Returns
    -------
    the plan on a better mesh, None where this one is kept; the flow and the estimated errors on this mesh
    """
    from contbed.packed_bed.results import plug_findings

    line, flow = _line_and_flow(plan, flow, result)
    if plan.scene.heat is None:
        better, estimate = None, None
        if flow is None:
            with result.timed("results"):
                plug_findings(plan, line, result)
        else:
            better, estimate = _better(plan, flow, None, None, before, last, result)
        result.solved = Solved(line, None, None, flow)
    else:
        better, estimate = _steady(
            plan, line, heat_problem(plan, flow, result), result, before, last
        )
    return better, flow, estimate


def _better(
    plan: Plan,
    flow: Any,
    problem: Any,
    state: Any,
    before: Any,
    last: bool,
    result: Result,
) -> tuple[Plan | None, Any]:
    """Return the plan on a better mesh, None where the errors are small or the mesh is
    the last one, and the estimate.

    `before` is the estimate on the former mesh.
    """
    from contbed.packed_bed import cell_errors, direction_errors

    if plan.tensor and (plan.balanced or not plan.adaptations):
        estimate = direction_errors.estimated(plan, flow, problem, state, before)
        if (
            not last
            and direction_errors.exceeded(estimate)
            and not direction_errors.full(estimate, before, plan.most_cells)
        ):
            return plan.on(
                direction_errors.next_vertices(estimate, plan.most_cells)
            ), estimate
        direction_errors.report(plan, estimate, result)
        return None, estimate
    if plan.adaptations:
        error = problem.estimated_error(state)
        largest, asked = (
            cell_errors.total(plan.mesh, error),
            plan.scene.solver.tolerance,
        )
        most = cell_errors.MOST * largest
        if not last and most > asked:
            return plan.refined(error), None
        result.qoi["estimated_error"] = largest
        if most > asked:
            wrong, allowed = distinct(most, asked)
            result.warnings.append(
                f"the temperature is wrong by up to about {wrong} of the span of "
                f"temperatures, by its estimate; solver.tolerance asks for {allowed}: "
                "raise solver.adapt, or give more mesh.cells"
            )
    return None, None


def steady_balance(
    problem: Any, state: Any, residual: Any
) -> tuple[Any, Any, dict[str, Any]]:
    """Return heat through boundaries, heat conducted in by prescribed temperatures,
    and their balance.
    """
    fluxes, conducted = problem.fluxes(state), problem.conducted_in(residual)
    balance = heat_balance(
        fluxes, conducted, problem.source(), 0.0, "W", problem.throughput()
    )
    return fluxes, conducted, balance


def _steady(
    plan: Plan, line: Line, problem: Any, result: Result, before: Any, last: bool
) -> tuple[Plan | None, Any]:
    """Solve and report; or, on a mesh that may still be bettered and should be, return
    the plan on a better one.

    The estimated errors are returned as well; `before` are those on the former mesh.
    """
    from contbed.packed_bed.results import steady_findings

    with result.timed("heat"):
        state, history = problem.solve(plan.policy)
        result.history += history
    if not plan.plug and not plan.medium.fluid.constant:
        from contbed.packed_bed.local_flow import settled

        problem, state = settled(plan, line, problem, state, result)
    with result.timed("results"):
        better, estimate = _better(
            plan, problem.flow, problem, state, before, last, result
        )
    if better is not None:
        return better, estimate
    with result.timed("heat"):
        residual, _ = problem.steady(state, False)
        fluxes, conducted, balance = steady_balance(problem, state, residual)
        if (
            abs(balance["relative_residual"])
            > 0.1 * plan.scene.solver.balance_tolerance
        ):
            state, residual = problem.refined(state, plan.policy)
            fluxes, conducted, balance = steady_balance(problem, state, residual)
    with result.timed("results"):
        result.balances["energy"] = balance
        steady_findings(plan, line, problem, state, fluxes, conducted, result)
        result.solved = Solved(line, problem, state, problem.flow)
        check_state(plan, problem, [state], result)
    return None, estimate


def _schumann(plan: Plan, result: Result) -> None:
    from contbed.packed_bed.results import front_findings
    from contbed.packed_bed.schumann import Schumann

    scene, medium = plan.scene, plan.medium
    time, porosity = scene.time, scene.packed_bed.porosity
    assert time is not None
    speed = abs(float(plan.velocity[0]))
    gas, solid = (scene.initial.given(phase) for phase in PHASES)
    assert isinstance(gas, float) and isinstance(solid, float)  # `plan` sees to it
    bed = Schumann(
        length=scene.mesh.length,  # type: ignore[union-attr]
        velocity=speed / porosity,
        capacity_fluid=porosity * _capacity(medium.fluid),
        capacity_solid=(1.0 - porosity) * _capacity(medium.solid),
        exchange=float(medium.exchange(medium.T_fluid_in, lambda density: speed)),
        inlet=medium.T_fluid_in,
        fluid=gas,
        solid=solid,
    )
    result.closures = [use.to_dict() for use in medium.ranges()]
    heat = {name: value * plan.section for name, value in bed.heat(time.end).items()}
    result.balances["energy"] = Balance(
        heat["in"], heat["out"], "J", stored=heat["stored"]
    ).as_dict()
    front_findings(plan, bed, sorted({*time.times, time.end}), heat, result)


def _capacity(phase: Any) -> float:
    """Return the heat capacity of a volume of a phase of constant properties [J/m3/K]."""
    return float(phase.density(300.0) * phase.heat_capacity(300.0))
