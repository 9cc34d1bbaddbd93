"""Run of a packed or moving bed: flow, then steady or transient heat, or fronts along characteristics."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from contbed.balance import HELD_SHARE, Balance
from contbed.errors import ConvergenceError
from contbed.fem.probe import Line, line_along
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.scene import Time
from contbed.packed_bed.schedule import Piece
from contbed.result import Result, outside
from contbed.scene.mesh import MeshLine

RESTART_MAY_CHANGE = ("time.end", "time.times", "time.checkpoint_every", "output", "solver.memory_GB")
TURNS = 40  # of flow and temperatures, each with the other's last solution
SETTLED = 0.1  # share of solver.tolerance by which theta may still change in a turn
OVERSHOOT = 1e-3  # share of the span of temperatures beyond which a warning is given


@dataclass(frozen=True)
class Solved:
    """What a run has solved: the `flow`, and `problem` and `state` of steady temperatures, None without [heat].

    `levels` are the sizes of all time steps of a transient from its start, one list for each part of the run.
    """

    line: Line
    problem: Any
    state: Any
    flow: Any
    levels: list[list[int]] | None = None


def run(plan: Plan, result: Result, folder: Path | None, quiet: bool, start: tuple[Any, Any] | None) -> None:
    """Solve and fill the result; a steady plan may be refined on the way.

    Parameters
    ----------
    folder : where checkpoints go; None for none
    start : arrays and numbers of a checkpoint to go on from

    Raises
    ------
    ConvergenceError : Newton or the time steps fail
    """
    scene = plan.scene
    if plan.fronts:
        with result.timed("heat"):
            _track_fronts(plan, result)
        return
    if start is not None and "vertices" in start[0]:
        plan = result.plan = plan.on([start[0]["vertices"]])
    if scene.time is not None:
        line, flow = _line_and_flow(plan, None, result)
        transient(plan, line, flow, result, folder, quiet, start)
        return
    flow, estimate = None, None
    for attempt in range(plan.adaptations + 1):
        better, flow, estimate = on_one_mesh(plan, flow, estimate, attempt == plan.adaptations, result)
        if better is None:
            return
        plan = result.plan = better
        result.adaptations += 1


def _line_and_flow(plan: Plan, before: Any, result: Result) -> tuple[Line, Any]:
    """Return the line of the profiles, and the flow from that on the mesh `before`; None for plug flow."""
    scene, flow = plan.scene, None
    plan.policy.check_memory(max(plan.unknowns().values()))  # before a matrix is assembled, which may take most
    # before anything is solved, as a line that leaves the mesh is a mistake of the scene
    line = line_along(plan.mesh, scene.output.positions, scene.output.across)
    result.warnings += [line.note] if line.note and line.note not in result.warnings else []
    if not plan.plug:
        with result.timed("flow"):
            flow = solved_flow(plan, before, result)
            report_flow(plan, line, flow, result)
    return line, flow


def on_one_mesh(plan: Plan, flow: Any, before: Any, last: bool, result: Result) -> tuple[Plan | None, Any, Any]:
    """Solve a steady scene on the mesh of its plan; report it if that mesh is good enough or the `last` one.

    Parameters
    ----------
    flow, before : the flow and the estimated errors on the former mesh, or None

    Returns
    -------
    the plan on a better mesh, None where this one is kept; the flow and the estimated errors on this mesh
    """
    line, flow = _line_and_flow(plan, flow, result)
    if plan.scene.heat is None:
        better, estimate = _better(plan, flow, None, None, before, last, result)
        result.solved = Solved(line, None, None, flow)
    else:
        better, estimate = _steady(plan, line, _heat_problem(plan, flow, result), result, before, last)
    return better, flow, estimate


def _better(
    plan: Plan, flow: Any, problem: Any, state: Any, before: Any, last: bool, result: Result
) -> tuple[Plan | None, Any]:
    """Return the plan on a better mesh, None where the errors are small or the mesh is the last one, and the estimate.

    `before` is the estimate on the former mesh.
    """
    from contbed.packed_bed import accuracy

    if plan.tensor and (plan.balanced or not plan.adaptations):
        estimate = accuracy.estimated(plan, flow, problem, state, before)
        if not last and accuracy.exceeded(estimate) and not accuracy.full(estimate, before, plan.most_cells):
            return plan.on(accuracy.next_vertices(estimate, plan.most_cells)), estimate
        accuracy.report(plan, estimate, result)
        return None, estimate
    if plan.adaptations:
        error = problem.estimated_error(state)
        if not last and error.max() > plan.scene.solver.tolerance:
            return plan.refined(error), None
        result.qoi["estimated_error"] = float(error.max())
    return None, None


def _heat_problem(plan: Plan, flow: Any, result: Result, piece: Piece | None = None) -> Any:
    from contbed.packed_bed.heat import HeatProblem
    from contbed.packed_bed.heat_coefficients import Motion

    with result.timed("heat setup"):
        motion = Motion(plan.velocity, plan.velocity_solid, flow)
        problem = HeatProblem(plan.solved, plan.mesh, plan.medium, motion, plan.section, piece)
    result.warnings += [text for text in problem.idle if text not in result.warnings]
    return problem


def solved_flow(plan: Plan, before: Any, result: Result, local: Any = None) -> Any:
    """Solve for the flow, from the one `before` if there is one, with `local` properties if they vary."""
    from contbed.packed_bed.flow import coefficients, solve_flow

    scene, options = plan.scene, plan.scene.solver
    c = coefficients(scene, plan.medium, plan.velocity, plan.velocity_solid)
    flow = solve_flow(
        plan.mesh,
        c,
        plan.velocity,
        plan.conditions,
        plan.policy,
        tolerance=options.newton_tolerance,
        iterations=options.newton_iterations,
        before=before,
        local=local,
    )
    result.history += flow.history
    return flow


def report_flow(plan: Plan, line: Line, flow: Any, result: Result) -> None:
    """Fill in the balance of the volume, the fields and the named results of a flow."""
    from contbed.packed_bed.flow import coefficients
    from contbed.packed_bed.results import flow_findings

    outflow = {name: flow.outflow(name) for name in plan.mesh.boundaries}
    floor = 0.0
    if "outlet" not in plan.conditions.values():  # nothing crosses walls; what moves between them is the scale
        extents = np.ptp(plan.mesh.skfem.p, axis=1)
        speed = coefficients(plan.scene, plan.medium, plan.velocity, plan.velocity_solid).speed
        floor = speed * float(extents.prod() / extents.max())
    balance = Balance.of_fluxes((-v for v in outflow.values()), "m3/s", floor=floor)
    result.balances["fluid volume"] = balance.as_dict()
    result.nodal |= {"u": (flow.system.fields["u"][0], flow.expanded), "p": (flow.system.fields["p"][0], flow.pressure)}
    flow_findings(plan, line, flow, result)


def _heat_balance(fluxes: Any, reactions: Any, source: float, stored: float, unit: str, held: float) -> dict[str, Any]:
    """Return the balance of heat through boundaries and into prescribed temperatures.

    `held` is the heat that streams and bed hold, the scale of the balance.
    """
    parts = [value for flux in fluxes.values() for value in flux.values()] + list(reactions.values())
    return Balance.of_fluxes(parts, unit, source, stored, HELD_SHARE * held).as_dict()


def steady_balance(problem: Any, state: Any, residual: Any) -> tuple[Any, Any, dict[str, Any]]:
    """Return heat through boundaries, heat conducted in by prescribed temperatures, and their balance."""
    fluxes, reactions = problem.fluxes(state), problem.reactions(residual)
    balance = _heat_balance(fluxes, reactions, problem.source(), 0.0, "W", problem.throughput())
    return fluxes, reactions, balance


def _with_local_properties(plan: Plan, line: Line, problem: Any, state: Any, result: Result) -> tuple[Any, Any]:
    """Solve flow and temperatures in turn until both belong to each other; return problem and state.

    Raises
    ------
    ConvergenceError : they do not settle
    """
    from contbed.packed_bed.flow import LocalProperties

    space, fluid = problem.system.fields["T_fluid"][0], plan.medium.fluid
    allowed, change = SETTLED * plan.scene.solver.tolerance, np.inf
    for _ in range(TURNS):
        T = problem.system.part(state, "T_fluid")
        expansion, viscosity = plan.medium.mass_flux_scale() / fluid.density(T), fluid.viscosity(T)
        local = LocalProperties(space, *(np.broadcast_to(values, T.shape) for values in (expansion, viscosity)))
        with result.timed("flow"):
            flow = solved_flow(plan, problem.motion.flow, result, local)
        problem = _heat_problem(plan, flow, result)
        with result.timed("heat"):
            found, history = problem.solve(plan.policy, state)
            result.history += history
        change, state = float(np.abs(problem.weights * (found - state)).max() / problem.span_of(found)), found
        if change <= allowed:
            report_flow(plan, line, flow, result)
            return problem, state
    raise ConvergenceError(
        f"flow and temperatures change each other: after {TURNS} turns theta still changes by {change:.1g} in each; "
        "an expanding fluid may have no steady flow here: try a smaller difference of temperatures or a slip wall"
    )


def _steady(plan: Plan, line: Line, problem: Any, result: Result, before: Any, last: bool) -> tuple[Plan | None, Any]:
    """Solve and report; or, on a mesh that may still be bettered and should be, return the plan on a better one.

    The estimated errors are returned as well; `before` are those on the former mesh.
    """
    from contbed.packed_bed.results import steady_findings

    with result.timed("heat"):
        state, history = problem.solve(plan.policy)
        result.history += history
    if not plan.plug and not plan.medium.fluid.constant:
        problem, state = _with_local_properties(plan, line, problem, state, result)
    with result.timed("results"):
        better, estimate = _better(plan, problem.motion.flow, problem, state, before, last, result)
    if better is not None:
        return better, estimate
    with result.timed("heat"):
        residual, _ = problem.steady(state, False)
        fluxes, reactions, balance = steady_balance(problem, state, residual)
        if abs(balance["relative_residual"]) > 0.1 * plan.scene.solver.balance_tolerance:
            state, residual = problem.refined(state, plan.policy)
            fluxes, reactions, balance = steady_balance(problem, state, residual)
    with result.timed("results"):
        result.balances["energy"] = balance
        steady_findings(plan, line, problem, state, fluxes, reactions, result)
        result.solved = Solved(line, problem, state, problem.motion.flow)
        _check_state(plan, problem, [state], result)
    return None, estimate


def transient(
    plan: Plan,
    line: Line,
    flow: Any,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
    levels: list[list[int]] | None = None,
) -> None:
    """Take the steps of a transient run and report; `levels` are the sizes of all of them in a run that is repeated."""
    from contbed.output import checkpoint
    from contbed.output.progress import Progress
    from contbed.packed_bed.cycle import exchanged
    from contbed.packed_bed.results import transient_findings
    from contbed.packed_bed.transient import History, enter, integrated_fluxes, run_transient, streamed
    from contbed.scene.identity import identity

    scene = plan.scene
    assert scene.time is not None
    label = identity(scene)
    history = None if start is None else History.unpack(*start).fitted(scene.time, scene.origin)

    def save(arrays: dict[str, Any], meta: dict[str, Any]) -> None:
        assert folder is not None
        grid = {"vertices": plan.line_vertices} if isinstance(plan.solved.mesh, MeshLine) else {}
        checkpoint.save(folder, arrays | grid, meta | {"identity": label})

    pieces = plan.pieces()
    cycle, whole = None, history is None
    if scene.time.cycle is not None and history is None:
        with result.timed("cycle"):
            cycle = _cycle(plan, pieces, flow, result)
        history = History(cycle.state)
    heats: list[float] = []
    taken: list[list[int]] = []
    if history is not None and cycle is None:  # of those that have passed only the last is needed, for the results
        reached = history.time * (1 + 1e-12)
        pieces = [piece for piece in pieces if piece is None or piece.end > reached] or pieces[-1:]
    try:
        with Progress(scene.time.end, "s", quiet) as progress:
            for k, piece in enumerate(pieces):
                if piece is not None:
                    plan = plan.within(piece)
                problem = _heat_problem(plan, flow, result, piece)
                with result.timed("heat"):
                    history = history or History(problem.begin(plan.policy))
                    if piece is not None and (cycle or piece.start > 0.0) and history.time <= piece.start * (1 + 1e-12):
                        enter(problem, history, plan.policy, None if piece.jumps else history.size)
                    before, steps = streamed(history), len(history.levels)
                    known = levels if cycle is None else cycle.levels
                    run_transient(
                        problem,
                        history,
                        plan.policy,
                        end=scene.time.end if piece is None else piece.end,
                        advance=progress.advance_to,
                        save=save if folder is not None else None,
                        levels=None if known is None else known[k],
                    )
                    taken.append(history.levels[steps:])
                    heats.append(streamed(history) - before)
        if whole and cycle is None:
            result.solved = Solved(line, None, None, flow, taken)
    finally:
        if history is not None:
            with result.timed("results"):
                if cycle is not None and len(heats) == len(pieces):
                    result.qoi |= {"cycle_periods": cycle.periods, "cycle_change_K": cycle.residual}
                    result.qoi |= exchanged(heats, _most(plan, pieces))
                if history.steps:
                    fluxes, reactions = integrated_fluxes(problem, history), history.reactions(problem)
                    source = problem.source() * history.time
                    held = problem.throughput() * history.time + problem.capacity()
                    result.balances["energy"] = _heat_balance(fluxes, reactions, source, history.gain, "J", held)
                transient_findings(plan, line, problem, history, result)
                if history.snapshots:
                    problem.steady(history.snapshots[-1], False)  # closures as used at the last output
                _check_state(plan, problem, history.snapshots, result)
            if folder is not None:
                save(*history.pack())


def _cycle(plan: Plan, pieces: Any, flow: Any, result: Result) -> Any:
    """Find the state that one run gives back."""
    from contbed.packed_bed.cycle import find_cycle

    time = plan.scene.time
    assert time is not None and time.cycle is not None
    problems = []
    for piece in pieces:
        plan = plan.within(piece)
        problems.append(_heat_problem(plan, flow, result, piece))
    start = problems[0].begin(plan.policy)
    return find_cycle(problems, start, plan.policy, time.cycle.tolerance)


def _most(plan: Plan, pieces: Any) -> list[float]:
    """Return the heat that the fluid of each part could leave in the bed between the inlet temperatures [J]."""
    conditions = [c for piece in pieces for scene in (piece.first, piece.last) for c in scene.boundary.values()]
    inlets = [c.fluid.inflow or c.fluid.fixed for c in conditions if c.fluid is not None]
    entering = [T for T in inlets if T is not None]
    if not entering:
        return [0.0] * len(pieces)
    found = []
    for piece in pieces:
        part = plan.within(piece)
        enthalpy = part.medium.fluid.enthalpy
        flow = float(np.abs(part.velocity[part.mesh.axis])) * part.section * part.medium.mass_flux_scale()
        rise = float(enthalpy(max(entering)) - enthalpy(min(entering)))
        found.append(flow * rise * (piece.end - piece.start))
    return found


def _track_fronts(plan: Plan, result: Result) -> None:
    from contbed.packed_bed.equations.fronts import track
    from contbed.packed_bed.results import front_findings

    scene, medium = plan.scene, plan.medium
    time, bed = scene.time, scene.bed
    assert time is not None
    u = float(plan.velocity[0])
    times = sorted({*time.times, time.end})
    snapshots, sums = track(
        scene.mesh.length,  # type: ignore[union-attr]
        plan.mesh.skfem.nelements,
        abs(u) / bed.porosity,
        bed.porosity * medium.fluid.density(300.0) * medium.fluid.heat_capacity(300.0),
        (1.0 - bed.porosity) * medium.solid.density(300.0) * medium.solid.heat_capacity(300.0),
        float(medium.exchange(medium.T_fluid_in, lambda density: abs(u))),
        medium.T_fluid_in,
        _start_of_fronts(time),
        times,
    )
    result.closures = [use.to_dict() for use in medium.ranges()]
    sums = {name: value * plan.section for name, value in sums.items()}
    result.balances["energy"] = Balance(sums["in"], sums["out"], "J", stored=sums["stored"]).as_dict()
    front_findings(plan, snapshots, u < 0, result)


def _start_of_fronts(time: Time) -> tuple[float, float]:
    assert isinstance(time.initial_fluid, float) and isinstance(time.initial_solid, float)  # `plan` sees to it
    return time.initial_fluid, time.initial_solid


def _require_physical(phase: str, material: Any, T: Any) -> None:
    """Raise ConvergenceError for temperatures [K] that no bed can have, or far beyond the data of the material."""
    lowest, highest = float(T.min()), float(T.max())
    if lowest <= 0.0:
        raise ConvergenceError(
            f"T_{phase} falls to {lowest:.4g} K: a source, a flux or a wall takes more heat than the bed holds; "
            "this is no steady or reachable state"
        )
    low, high = material.T_range
    span = high - low
    if isfinite(span) and not low - span <= lowest <= highest <= high + span:
        raise ConvergenceError(
            f"T_{phase} reaches {lowest if lowest < low - span else highest:.4g} K, beyond the properties of "
            f"{material.name}, {low:.6g} to {high:.6g} K, by more than their whole range: the result would mean nothing"
        )


def _check_state(plan: Plan, problem: Any, states: list[Any], result: Result) -> None:
    """Record closure ranges at the last state, and check material ranges and bounds of theta over all states.

    Nothing is clipped.
    """
    if not states:
        return
    result.closures = [use.to_dict() for use in plan.medium.ranges()]
    result.warnings += [outside(closure) for closure in result.closures if closure["share_outside"] > 0]
    for phase in ("fluid", "solid"):
        material = getattr(plan.medium, phase)
        values = problem.system.part(states[-1], f"T_{phase}")
        if (share := material.share_outside(values)) > 0:
            low, high = material.T_range
            result.warnings.append(
                f"{material.name}: {share:.1%} of the points are outside {low:.6g} to {high:.6g} K, used "
                f"{values.min():.6g} to {values.max():.6g} K"
            )
        _require_physical(phase, material, values)
    beyond = overshoot(plan, problem, states)
    if beyond is None:
        return
    result.qoi["theta_overshoot"] = beyond
    if beyond > OVERSHOOT:
        result.warnings.append(
            f"theta leaves [0, 1] by {beyond:.2g}: a layer is not resolved; refine the mesh or leave out mesh.cells"
        )


def overshoot(plan: Plan, problem: Any, states: list[Any]) -> float | None:
    """Return how far theta leaves [0, 1] in any of the states; None where sources or fluxes may take it out."""
    low, high = problem.T_span
    has_heat = problem.source() or any(
        table.flux for b in plan.scene.boundary.values() for table in (b.fluid, b.solid) if table is not None
    )
    if has_heat or high <= low:
        return None
    both = [problem.system.part(state, name) for state in states for name in ("T_fluid", "T_solid")]
    beyond = max(max(float(T.max()) - high, low - float(T.min())) for T in both) / (high - low)
    return float(max(beyond, 0.0))
