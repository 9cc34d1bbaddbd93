"""Transient run of a packed or moving bed: its steps or its cycle, and results."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from contbed.course.cycle import MOST, Period, periods
from contbed.course.history import Saver
from contbed.errors import ConvergenceError
from contbed.fem.probe import Line
from contbed.output.progress import Progress
from contbed.packed_bed.of_stores import store_findings
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.results import transient_findings, wall_findings
from contbed.packed_bed.run_parts import Solved, check_state, heat_balance
from contbed.packed_bed.time_steps import (
    HeatHistory,
    HeatSteps,
    by_streams,
    heat_both_ways,
    integrated_fluxes,
)
from contbed.result import Result


def run_transient(
    plan: Plan,
    line: Line,
    flow: Any,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    """Take the steps of a transient run and report.

    Parameters
    ----------
    folder : where checkpoints go; None for none
    start : arrays and numbers of a checkpoint to resume from
    """
    scene = plan.scene
    assert scene.time is not None
    steps = HeatSteps(plan, flow, result)
    with Saver(folder, scene) as saver:
        if scene.time.cycle is not None:
            with result.timed("cycle"):
                period = _cycle(steps, start, saver, quiet)
            found = Run(steps, line, period.begin)
            found.follow(quiet, None, period.sizes)
            result.qoi |= {
                "cycle_periods": period.number,
                "cycle_change_K": period.largest * steps.span,
            }
            return
        with result.timed("heat"):
            history = steps.begin()
        if start is not None:
            history = history.resumed(*start).fitted(scene.time, scene.origin)
        saver.offer(history)
        found = Run(steps, line, history)
        found.follow(quiet, saver)
    if start is None:
        renewed = None if steps.local is None else steps.renewed
        result.solved = Solved(line, None, None, flow, found.shares, renewed)


class Run:
    """The steps of a run, and the report of what was reached, whatever happens.

    `shares` are the sizes of the steps of each part of the run over its length.
    """

    def __init__(self, steps: HeatSteps, line: Line, history: HeatHistory):
        self.steps, self.line, self.history = steps, line, history
        self.shares: list[list[float]] = [[]]

    def follow(
        self,
        quiet: bool,
        saver: Saver | None = None,
        sizes: Iterable[float] | None = None,
    ) -> None:
        """Take the steps, of given `sizes` [s] in a run that is repeated."""
        steps, ends = self.steps, self.steps.stops()
        end, result = ends[-1], self.steps.result
        if sizes is None:
            histories = steps.march(self.history)
        else:
            repeated = steps.repeated(self.history, sizes)
            histories = (after for after, _ in repeated)
        part = dict(zip(ends, [0.0, *ends[:-1]], strict=True))
        try:
            with Progress(end, "s", quiet) as progress, result.timed("heat"):
                for after in histories:
                    self.history = after
                    self.shares[-1].append(after.taken)
                    if after.time in part:
                        length = after.time - part[after.time]
                        self.shares[-1] = [size / length for size in self.shares[-1]]
                        self.shares.append([])
                    progress.advance_to(after.time)
                    if saver is not None:
                        saver.offer(after)
            if steps.local is not None:
                steps.renew_flow(self.history)
        finally:
            with result.timed("results"):
                self._report()

    def _report(self) -> None:
        steps, history = self.steps, self.history
        plan, problem, result = steps.plan, steps.problem, steps.result
        if steps.local is not None:
            steps.local.report(plan, self.line)
        if history.steps:
            fluxes = integrated_fluxes(problem, history)
            conducted = history.conducted_in(problem)
            source = problem.source() * history.time
            held = problem.throughput() * history.time + problem.capacity()
            both_ways = heat_both_ways(fluxes, history)
            result.balances["energy"] = heat_balance(
                fluxes, conducted, source, history.gain, "J", held, both_ways
            )
        transient_findings(plan, self.line, problem, history, result)
        if history.steps:
            wall_findings(plan, fluxes, conducted, history.time, result)
            totals = by_streams(fluxes, conducted)
            store_findings(plan, self.line, problem, history, totals, result)
        snapshots = list(history.kept.values())
        if snapshots:
            # closures as used at the last output
            problem.steady(snapshots[-1], False)
        check_state(plan, problem, snapshots, result)


def _cycle(
    steps: HeatSteps, start: tuple[Any, Any] | None, saver: Saver, quiet: bool
) -> Period:
    """Return the period that closes the cycle.

    Raises
    ------
    ConvergenceError : none does
    """
    time = steps.plan.scene.time
    assert time is not None and time.cycle is not None
    steps.accounts = False
    tolerance = time.cycle.tolerance
    with Progress(time.end, "s", quiet) as progress:
        for period in periods(
            steps, steps.begin(), start, tolerance, saver.offer, progress.advance_to
        ):
            if period.closed:
                steps.accounts = True
                return period
    raise ConvergenceError(
        f"cycle: after {MOST} periods temperatures still change by "
        f"{period.largest * steps.span:.3g} K over one period, and "
        f"{tolerance * steps.span:.3g} K are allowed; raise "
        "time.cycle.tolerance"
    )
