"""Transient run of a packed or moving bed: its parts between changes of the scene,
the flow as it changes, results.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contbed.fem.probe import Line
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.shared import Solved, check_state, heat_balance, heat_problem
from contbed.result import Result
from contbed.scene.mesh import MeshLine

if TYPE_CHECKING:
    from contbed.packed_bed.local_flow import FlowOverTime


def transient(
    plan: Plan,
    line: Line,
    flow: Any,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
    levels: list[list[int]] | None = None,
    flows: list[list[int]] | None = None,
) -> None:
    """Take the steps of a transient run and report.

    `levels` are the sizes of all steps in a run that is repeated, and `flows` the
    numbers of those after which the flow was solved anew.
    """
    from contbed.output import checkpoint
    from contbed.output.progress import Progress
    from contbed.packed_bed.of_stores import store_findings
    from contbed.packed_bed.results import transient_findings
    from contbed.packed_bed.transient import (
        History,
        by_streams,
        enter,
        integrated_fluxes,
        run_transient,
    )
    from contbed.scene.identity import identity

    scene = plan.scene
    assert scene.time is not None
    label = identity(scene)
    vertices = (
        {"vertices": plan.line_vertices}
        if isinstance(plan.solved.mesh, MeshLine)
        else {}
    )
    history = None if start is None else History.unpack(*start)
    cycle, whole = None, history is None

    def save(arrays: dict[str, Any], meta: dict[str, Any]) -> None:
        assert folder is not None
        flows = (
            local.pack() if local is not None and local.flow.local is not None else {}
        )
        checkpoint.save(folder, arrays | vertices | flows, meta | {"identity": label})

    def keep(state: Any) -> None:
        """Keep a state from which a cycle resumes, whose periods begin at 0."""
        arrays, meta = History(state).pack()
        keeper.offer(arrays | vertices, meta)

    local: FlowOverTime | None = None
    if flow is not None and not plan.medium.fluid.constant:
        from contbed.packed_bed.local_flow import FlowOverTime

        local = FlowOverTime(result, flow)
    intervals = plan.intervals()
    if scene.time.cycle is not None:
        with (
            result.timed("cycle"),
            checkpoint.Keeper(folder, label, scene.time.checkpoint_every) as keeper,
        ):
            cycle = _cycle(
                plan,
                intervals,
                flow,
                result,
                None if history is None else history.state,
                keep,
            )
        history, start, folder = History(cycle.state), None, None
    elif history is not None:
        history = history.fitted(scene.time, scene.origin)
    taken: list[list[int]] = []
    renewed: list[list[int]] = []
    # of those that have passed only the last is needed, for the results
    if history is not None and cycle is None:
        reached = history.time * (1 + 1e-12)
        intervals = [
            interval
            for interval in intervals
            if interval is None or interval.end > reached
        ] or intervals[-1:]
    try:
        with Progress(scene.time.end, "s", quiet) as progress:
            for k, interval in enumerate(intervals):
                if interval is not None:
                    plan = plan.within(interval)
                problem = heat_problem(plan, flow, result, interval)
                with result.timed("heat"):
                    history = history or History(problem.begin(plan.policy))
                    if (
                        interval is not None
                        and (cycle or interval.start > 0.0)
                        and history.time <= interval.start * (1 + 1e-12)
                    ):
                        enter(
                            problem,
                            history,
                            plan.policy,
                            None if interval.jumps else history.size,
                        )
                    steps = len(history.levels)
                known = levels if cycle is None else cycle.levels
                end = scene.time.end if interval is None else interval.end
                if local is not None:
                    local.steps, local.known = [], None if flows is None else flows[k]
                    if start is not None and k == 0:
                        local.restore(problem, start[0])
                    begins = history.time <= (
                        0.0 if interval is None else interval.start
                    ) * (1 + 1e-12)
                    if begins or local.outdated(plan, problem, history.state, 0):
                        local.solve(plan, problem, history.state, 0)
                    problem = heat_problem(
                        plan, local.flow, result, interval, problem.system
                    )
                while True:
                    with result.timed("heat"):
                        run_transient(
                            problem,
                            history,
                            plan.policy,
                            end=end,
                            advance=progress.advance_to,
                            save=save if folder is not None else None,
                            levels=None
                            if known is None
                            else known[k][len(history.levels) - steps :],
                            enough=None
                            if local is None
                            else partial(
                                _outdated, local, plan, problem, history, steps
                            ),
                        )
                    if local is None:
                        break
                    local.solve(
                        plan, problem, history.state, len(history.levels) - steps
                    )
                    if history.time >= end * (1 - 1e-12):
                        break
                    problem = heat_problem(
                        plan, local.flow, result, interval, problem.system
                    )
                taken.append(history.levels[steps:])
                if local is not None:
                    renewed.append(local.steps)
        if whole and cycle is None:
            result.solved = Solved(
                line, None, None, flow, taken, renewed if local is not None else None
            )
    finally:
        if history is not None:
            with result.timed("results"):
                if local is not None:
                    local.report(plan, line)
                if cycle is not None:
                    result.qoi |= {
                        "cycle_periods": cycle.periods,
                        "cycle_change_K": cycle.residual,
                    }
                if history.steps:
                    fluxes, reactions = (
                        integrated_fluxes(problem, history),
                        history.reactions(problem),
                    )
                    source = problem.source() * history.time
                    held = problem.throughput() * history.time + problem.capacity()
                    result.balances["energy"] = heat_balance(
                        fluxes, reactions, source, history.gain, "J", held
                    )
                transient_findings(plan, line, problem, history, result)
                if history.steps:
                    totals = by_streams(fluxes, reactions)
                    store_findings(plan, problem, history, totals, result)
                if history.snapshots:
                    # closures as used at the last output
                    problem.steady(history.snapshots[-1], False)
                check_state(plan, problem, history.snapshots, result)
            if folder is not None:
                save(*history.pack())


def _outdated(
    local: FlowOverTime, plan: Plan, problem: Any, history: Any, steps: int
) -> bool:
    """Return whether the flow is to be solved anew after the last step; `steps` were
    taken before this part.
    """
    return local.outdated(plan, problem, history.state, len(history.levels) - steps)


def _cycle(
    plan: Plan,
    intervals: Any,
    flow: Any,
    result: Result,
    guess: Any,
    keep: Callable[[Any], None],
) -> Any:
    """Find the state that one run gives back, from a guess or, where it is None,
    from the state at the start.
    """
    from contbed.packed_bed.cycle import find_cycle

    time = plan.scene.time
    assert time is not None and time.cycle is not None
    problems = []
    for interval in intervals:
        plan = plan.within(interval)
        problems.append(heat_problem(plan, flow, result, interval))
    start = problems[0].begin(plan.policy) if guess is None else guess
    return find_cycle(problems, start, plan.policy, time.cycle.tolerance, keep)
