"""Transient run of a reacting bed: its steps or its cycle, results, and what to try
where steps fail.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.course.cycle import Period, Search, periods
from contbed.course.history import Saver
from contbed.errors import ConvergenceError
from contbed.fields import distinct
from contbed.output.progress import Progress
from contbed.reacting_bed import solve
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.cycle import Stored
from contbed.reacting_bed.history import BedHistory
from contbed.reacting_bed.least_amounts import finer
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.rate_checks import rate_without_value
from contbed.reacting_bed.time_cells import fitted
from contbed.reacting_bed.time_steps import BedSteps, begin, turned
from contbed.reacting_bed.transient_results import fill
from contbed.result import Result

# steps of which each hundred shows whether fronts are too short for polynomials: share
# in which cells were damped, steps to the end at their size, growth of their size above
# which they become few by themselves, and hundreds in a row that must show it
JUDGED, DAMPED, TOO_MANY, GROWTH, HUNDREDS = 100, 1 / 3, 20_000, 1.5, 3
MANY = 5_000  # steps left from which the progress says how to take fewer


class ShortFrontsError(ConvergenceError):
    """Polynomials follow fronts shorter than a cell in too many steps."""


def run_transient(
    course: Course,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    """Take steps to the end, of a run or of the periods of a cycle, and fill the
    result; the checkpoint in `folder` always holds an accepted step.

    Raises
    ------
    ShortFrontsError : cells of one value are far faster; the result is not filled
    ConvergenceError : steps become ever smaller
    SceneError : the checkpoint does not fit the output times
    """
    time, origin = course.time, course.scene.origin
    report = solve.Report()
    steps = BedSteps(course, report)
    history = begin(fit := fitted(course), fit.start())
    period: Period | None = None
    creeps = False
    if time.cycle is None and start is not None:
        history = history.resumed(*start).fitted(time, origin)
    try:
        with (
            result.timed("bed"),
            Saver(folder, course.scene) as saver,
            Progress(time.end, "s", quiet) as progress,
        ):
            if time.cycle is None:
                saver.offer(history)
                begun = earlier = judged = history
                slow, note = 0, ""
                for history in steps.march(begun):
                    _require_feasible(history, report)
                    if history.steps >= judged.steps + JUDGED:
                        slow += 1
                        if not _creeps(course, earlier, judged, history):
                            slow = 0
                        note = _note(course, judged, history)
                        earlier, judged = judged, history
                        creeps = slow >= HUNDREDS
                        if creeps:
                            raise ShortFrontsError(
                                f"{history.steps} steps to t = {history.time:.3g} s", []
                            )
                    progress.advance_to(history.time, note)
                    saver.offer(history)
            else:
                for period in searched(steps, start, saver.offer, progress.advance_to):
                    history = period.history
                _require_feasible(history, report)
    except (_Infeasible, ShortFrontsError):
        raise
    except ConvergenceError as error:
        advice = _advice(course.on(history), history)
        raise ConvergenceError(
            f"{origin.name}: {error} at t = {history.time:.4g} s; {advice}",
            report.history,
            history.state,
        ) from None
    finally:
        result.history += report.history[-50:]
        if history.steps and not creeps:
            fill(course, history, result)
        if period is not None:
            result.qoi |= cycle_findings(course, period)
    if period is not None and not period.closed:
        assert time.cycle is not None
        changes, allowed = distinct(period.largest, time.cycle.tolerance)
        raise ConvergenceError(
            f"{origin.at(('time', 'cycle'))}: time.cycle: of {period.number} "
            f"periods the best changes the bed by {changes} of its typical "
            f"sizes, allowed are {allowed}: use more mesh.cells, "
            "raise time.cycle.tolerance, or begin with the profiles of that period, "
            "which were written, initial.file",
            report.history,
            history.state,
        )


def _creeps(
    course: Course, earlier: BedHistory, before: BedHistory, now: BedHistory
) -> bool:
    """Return whether fronts are shorter than a cell and polynomials, which the scene
    does not ask for, follow them in far too many steps, which do not grow as they do
    behind a jump.
    """
    if _chosen(course) or course.rounds:
        return False
    steps = now.steps - before.steps
    damped = now.steps_damped - before.steps_damped
    passed, former = now.time - before.time, before.time - earlier.time
    left = _left(course, before, now)
    grows = passed > GROWTH * former
    return damped > DAMPED * steps and left > TOO_MANY and not grows


def _chosen(course: Course) -> bool:
    """Return whether the scene has chosen its cells, or they have one value already."""
    return course.scene.solver.degree is not None or not course.problem.line.degree


def _left(course: Course, before: BedHistory, now: BedHistory) -> float:
    """Return the steps to the end at the size of those between two histories."""
    return (course.time.end - now.time) * (
        (now.steps - before.steps) / (now.time - before.time)
    )


def _note(course: Course, before: BedHistory, now: BedHistory) -> str:
    """Return what a user who waits may change: nothing where few steps are left, or
    the scene has chosen its cells.
    """
    left = _left(course, before, now)
    if left < MANY or _chosen(course):
        return ""
    return f"some {left:.1g} steps are left; solver.degree = 0 takes fewer for fronts"


def _require_feasible(history: BedHistory, report: solve.Report) -> None:
    if history.absent is not None:
        raise _Infeasible(history.absent, report.history, history.state)


class _Infeasible(ConvergenceError):
    """Rates consume an absent species, so that no state exists."""


def _advice(course: Course, history: BedHistory) -> str:
    """Return what to try where steps fail at a state."""
    problem = course.at(history.time, before=False)
    stops = "it would flow back from the other end"
    if (without := rate_without_value(problem, history.state)) is not None:
        return (
            f"{without}: add a small amount to what it divides by, such as c_X + 1e-6"
        )
    gases = slice(len(problem.layout.gases))
    enters = problem.moles
    u = turned(problem, history.state)
    taken = -float(problem.mean(problem.system.sources(u))[gases].sum())
    cooled = _contraction(problem, u)
    if problem.bed.gas_pressure is not None and taken >= enters:
        if problem.layout.inside and problem.line.degree:
            return (
                f"particles take {taken:.3g} mol/m2/s of gas and {enters:.3g} enter: "
                f"{stops}. Give solver.degree = 0, one value a cell, whose flux does "
                "not reverse"
            )
        return (
            f"reactions take {taken:.3g} mol/m2/s of the gas that fills the bed and "
            f"{enters:.3g} enter: {stops}. "
            "Begin with initial.gas.composition of gas that has reacted, or give "
            "packed_bed.gas_storage = "
            '"quasi_steady"'
        )
    if problem.bed.gas_pressure is not None and taken + cooled >= enters:
        return (
            "the particles cool the gas that fills the bed, which makes room for "
            f"{cooled:.3g} mol/m2/s, and "
            f'{enters:.3g} enter: {stops}. Give packed_bed.gas_storage = "quasi_steady"'
        )
    if problem.layout.inside and problem.line.degree:
        return (
            "fronts of adsorption may be shorter than a cell: give solver.degree = 0, "
            f"one value a cell, or use {finer(course.scene)}"
        )
    return (
        f"use {finer(course.scene)}, or smooth a rate whose slope is infinite where "
        "nothing is left"
    )


def _contraction(problem: Problem, u: Array) -> float:
    """Return the moles that the gas in the pores makes room for as it cools to the
    particles [mol/m2/s].

    At constant pressure these are -n/T dT/dt, and the heat n c dT/dt is what the
    equations of the gas leave at `u`; none where gas and particles have one
    temperature.
    """
    layout, residual = problem.layout, problem.system.assemble(u, False)[0]
    room = np.zeros(len(u))
    for k, name in enumerate(problem.names):
        if name != "T_fluid":
            continue
        first = k - k % len(layout.names)
        rows = [first + layout.names.index(f"g_{gas}") for gas in layout.gases]
        T, total = u[k], u[rows].sum(axis=0)
        lost, capacity = residual[k].copy(), np.zeros_like(T)
        for row, gas in zip(rows, layout.gases, strict=True):
            h = problem.bed.enthalpies[gas]
            lost -= residual[row] * h(T)
            capacity += u[row] / total * (h(T + 0.5) - h(T - 0.5))
        room[k] = float((lost / (capacity * T)).sum())
    return float(problem.mean(room).sum())


def searched(
    steps: BedSteps,
    start: tuple[Any, Any] | None,
    save: Callable[[Search[BedHistory]], None],
    advance: Callable[[float, str], None],
) -> Iterator[Period]:
    """Yield the periods of the cycle from the start of the scene, or from a checkpoint.

    `advance` is called with the time that each step has reached [s], and which period
    it is.
    """
    course = steps.course
    assert course.time.cycle is not None
    first = begin(course, turned(course.problem, course.start()))
    return periods(steps, first, start, course.time.cycle.tolerance, save, advance)


def cycle_findings(course: Course, period: Period) -> dict[str, float]:
    """Return named results of the last period of a search."""
    found: dict[str, float] = {
        "cycle_periods": period.number,
        "cycle_change": period.largest,
    }
    kelvin = Stored.of(course.problem, period.scale).in_kelvin(period.change)
    return found if kelvin is None else found | {"cycle_change_K": kelvin}
