"""Steps in time of a reacting bed: particles store moles and heat, the gas too or it
follows at once.

    d/dt C(u) + R(u, t) = 0,    C the content per volume of bed, zero for equations of a gas that follows at once

What is stored is exactly what has passed the ends, weighted as the stages of a step are
(`stages`). No step crosses a jump of a series, or a kink that is larger than its error
allows: streams that enter have at each stage the values of its time, and those before a
jump where it ends there.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.errors import ConvergenceError
from contbed.output.progress import Progress
from contbed.reacting_bed import results, solve
from contbed.reacting_bed.amounts import finer, least
from contbed.reacting_bed.bounded import Bounded, bounded, of_next
from contbed.reacting_bed.course import FIRST_STEP, SHORTEST_STEP, Course
from contbed.reacting_bed.equations.unknowns import Role
from contbed.reacting_bed.history import FLOW, SAME, History, output_times
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.rate_checks import rate_without_value, taken_though_absent
from contbed.reacting_bed.stages import GAMMA
from contbed.reacting_bed.time_cells import fitted, following, on_cells
from contbed.reacting_bed.transient_results import contents, fill
from contbed.result import Result
from contbed.scene.identity import identity

Array = NDArray[np.float64]
SAFETY, MOST_GROWTH, LEAST_GROWTH = 0.8, 2.5, 0.2
# steps between two powers of 2: a thousandth, of estimates that rounding changes by
# 1e-9
DIGITS = 2**10
SHORTER = 0.25  # of a step that does not converge
MOST_TRIALS = 4  # of a step whose amounts are below zero, each of a shorter one
# steps of a run with amounts below zero, from which on shorter ones are known not to
# help
MOST_UNBOUNDED = 10


def run_transient(
    course: Course,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
    periods: Callable[..., Iterator[Any]] | None = None,
) -> None:
    """Take steps to the end and fill the result; the checkpoint in `folder` always
    holds an accepted step.

    `periods` are those of a cycle, see `cycle`, of which the last is the run; None for
    any other run.

    Raises
    ------
    ConvergenceError : steps become ever smaller
    SceneError : the checkpoint does not fit the output times
    """
    time, origin = course.time, course.scene.origin
    report = solve.Report()
    if start is None:
        fit = fitted(course)
        history = begin(fit, fit.start())
    else:
        history = History.unpack(*start)
        # of a cycle the state alone counts, from which periods begin anew
        if periods is None:
            history = history.fitted(time, origin)
    label = identity(course.scene) if folder is not None else {}

    def save() -> None:
        if folder is not None:
            from contbed.output import checkpoint

            arrays, meta = history.pack()
            checkpoint.save(folder, arrays, meta | {"identity": label})

    saved = clock.monotonic()

    def save_if_due() -> None:
        nonlocal saved
        if clock.monotonic() - saved >= time.checkpoint_every:
            save()
            saved = clock.monotonic()

    found = None
    try:
        with result.timed("bed"), Progress(time.end, "s", quiet) as progress:
            for found in (
                ()
                if periods is None
                else periods(course, history.u, report, progress.advance_to)
            ):
                history = found.history
                save_if_due()
            if found is not None and found.taken is not None:
                raise _Infeasible(found.taken, report.history, history.u)
            for after in march(course, history, report):
                taken, history = taken_in(course, history, after), after
                if taken is not None:
                    raise _Infeasible(taken, report.history, history.u)
                progress.advance_to(history.time)
                save_if_due()
    except _Infeasible:
        raise
    except ConvergenceError as error:
        advice = _advice(course.on(history), history)
        raise ConvergenceError(
            f"{origin.name}: {error} at t = {history.time:.4g} s; {advice}",
            report.history,
            history.u,
        ) from None
    finally:
        result.history += report.history[-50:]
        if history.steps:
            fill(course, history, result)
        if found is not None:
            result.qoi |= found.qoi()
        save()
    if found is not None and not found.closed:
        assert time.cycle is not None
        raise ConvergenceError(
            f"{origin.at(('time', 'cycle'))}: time.cycle: of {found.periods} periods "
            "the best changes the bed by "
            f"{found.change:.3g} of its typical sizes, allowed are "
            f"{time.cycle.tolerance:.3g}: use more mesh.cells, "
            "raise time.cycle.tolerance, or begin with the profiles of that period, "
            "which were written, initial.file",
            report.history,
            history.u,
        )


class _Infeasible(ConvergenceError):
    """Rates consume an absent species, so that no state exists."""


def taken_in(course: Course, before: History, after: History) -> str | None:
    """Return what rates take though there is none of it, after a step with amounts
    below zero; None if they do not.
    """
    if after.unbounded == before.unbounded:
        return None
    sentence = taken_though_absent(course.on(after).at(after.time), after.u)
    return None if sentence is None else f"{sentence}, at t = {after.time:.4g} s"


def _advice(course: Course, history: History) -> str:
    """Return what to try where steps fail at a state."""
    problem, stops = (
        course.at(history.time, before=False),
        "it would flow back from the other end",
    )
    if (without := rate_without_value(problem, history.u)) is not None:
        return (
            f"{without}: add a small amount to what it divides by, such as c_X + 1e-6"
        )
    gases = slice(len(problem.layout.gases))
    enters = abs(sum(problem.streams.gas.values()))
    u = turned(problem, history.u)
    taken = -float(problem.mean(problem.system.sources(u))[gases].sum())
    cooled = _contraction(problem, u)
    if problem.bed.gas_pressure is not None and taken >= enters:
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


def begin(course: Course, u: Array) -> History:
    """Return the history at the start of a run from a state."""
    held = contents(course.problem, u)
    passed, none = np.zeros((len(held), 2)), np.zeros(u.shape[:2])
    first, vertices = FIRST_STEP * course.time.end, course.problem.line.vertices
    history = History(
        u, first, held, passed, passed, passed[:, 0], none, none[0] > 0.0, vertices
    )
    pressure = course.problem.bed.gas_pressure
    return (
        replace(history, pressure=pressure)
        if course.rounds and np.ndim(pressure)
        else history
    )


def march(course: Course, history: History, report: solve.Report) -> Iterator[History]:
    """Yield the histories after each accepted step to the end of the run.

    Raises
    ------
    ConvergenceError : steps become ever smaller
    """
    time = course.time
    outputs = output_times(time)
    _guess_inside(course, history)
    for stop in course.stops():
        while history.time < stop * (1.0 - SAME):
            course = course.on(history)
            history = advanced(course, history, stop, report)
            if history.time == stop and stop in outputs:
                history = history.keeping(stop)
            yield history


def advanced(
    course: Course, history: History, stop: float, report: solve.Report
) -> History:
    """Return the history after the longest step towards a time that its error allows,
    within bounds where one is found.

    Raises
    ------
    ConvergenceError : steps become ever smaller
    """
    dt, longest = history.dt, None
    for _ in range(MOST_TRIALS):
        try:
            after = _advanced(course, history, stop, report, dt)
        except ConvergenceError:
            if longest is None:
                raise
            break
        if after.unbounded == history.unbounded:
            return after
        longest = longest or after
        if history.unbounded >= MOST_UNBOUNDED:
            break
        dt = with_few_digits(SHORTER * (after.time - history.time))
    assert longest is not None
    _guess_inside(course, longest)
    return longest


def _guess_inside(course: Course, history: History) -> None:
    """Take the first guesses inside of pellets from a history."""
    for kind, pellets in course.problem.pellets.items():
        pellets.known.update(
            {
                count: xi
                for (count, of), xi in history.extents.items()
                if of == (kind or "")
            }
        )


def _advanced(
    course: Course, history: History, stop: float, report: solve.Report, dt: float
) -> History:
    """Return the history after a step no longer than dt that its error allows."""
    time, rounds = course.time, course.rounds
    shortest, rough = SHORTEST_STEP * time.end, 0.0
    u = _guess(course, history)
    if u is not history.u:
        dt = min(dt, FIRST_STEP * time.end)
    while True:
        step = course.seen(history.time, min(dt, stop - history.time))
        if step < shortest and stop - history.time > 2.0 * step:
            raise ConvergenceError("steps in time become ever smaller")
        try:
            found = bounded(
                _problems(course, history.time, step),
                history.u,
                u,
                step,
                report,
                course.sizes(u),
                history.damping,
            )
        except ConvergenceError:
            dt = SHORTER * step
            if dt < shortest:
                raise
            continue
        growth = SAFETY * (time.tolerance / max(found.error, 1e-300)) ** 0.5
        if found.error > time.tolerance and growth < 1.0:
            dt = with_few_digits(step * max(growth, LEAST_GROWTH))
            continue
        if course.rounds:
            better, rough = following(
                course.problem, (history.u, found.states[1]), course.sizes(u)
            )
            if better is not None and rounds:
                try:
                    course, history = on_cells(course, history, better)
                    u, rounds = _guess(course, history), rounds - 1
                    continue
                # cells that would hold more than particles can stay as they are
                except ConvergenceError:
                    rounds = 0
        later = (
            with_few_digits(dt * min(max(growth, LEAST_GROWTH), MOST_GROWTH))
            if step == dt
            else dt
        )
        end = history.time + step
        end = stop if end >= stop * (1.0 - SAME) else end
        return _passed(history, found, step, end, later, rough)


def _guess(course: Course, history: History) -> Array:
    """Return the first guess of a step: the state, or after a jump another with the
    flux of the gas that enters.
    """
    if course.schedule and history.time > 0.0 and course.schedule.jumps(history.time):
        return turned(course.at(history.time, before=False), history.u)
    return history.u


def _problems(course: Course, time: float, step: float) -> tuple[Problem, Problem]:
    """Return the bed at both stages of a step."""
    since = course.since(time)
    return course.at(time + GAMMA * step, since=since), course.at(
        time + step, since=since
    )


def repeated(
    course: Course, history: History, ends: Sequence[float], report: solve.Report
) -> Iterator[tuple[History, float]]:
    """Yield the histories after steps that end at given times [s], whatever their
    errors, and these.

    Raises
    ------
    ConvergenceError : a step is not found
    """
    outputs = output_times(course.time)
    _guess_inside(course, history)
    for end in ends:
        step, guess = end - history.time, _guess(course, history)
        problems, sizes = _problems(course, history.time, step), course.sizes(guess)
        found = bounded(
            problems, history.u, guess, step, report, sizes, history.damping, kept=True
        )
        history = _passed(history, found, step, end, history.dt)
        if end in outputs:
            history = history.keeping(end)
        yield history, found.error


def with_few_digits(dt: float) -> float:
    """Return the next shorter step of so few digits that rounding in the estimates
    of errors does not decide them.
    """
    mantissa, exponent = math.frexp(dt)
    return math.ldexp(math.floor(mantissa * DIGITS), exponent) / DIGITS


def _passed(
    history: History,
    found: Bounded,
    step: float,
    end: float,
    dt: float,
    rough: float = 0.0,
) -> History:
    """Return the history after a step; its weights are those of the stages, so that
    totals close to rounding.
    """
    problems, states = found.problems, found.states
    passed, both_ways, sources, carried = (
        history.passed,
        history.both_ways,
        history.sources,
        history.carried,
    )
    fluxes = passed
    for problem, u, weight in zip(problems, states, (1.0 - GAMMA, GAMMA), strict=True):
        fluxes = problem.mean(problem.system.fluxes(u)[:, [0, -1]])
        passed = passed + step * weight * fluxes
        both_ways = both_ways + step * weight * np.abs(fluxes)
        sources = sources + step * weight * problem.mean(problem.system.sources(u))
        if problem.layout.temperatures:
            carried += step * weight * results.heat_carried(problem, u)
    row = outlet(problems[1], states[1], fluxes, end)
    pellets = problems[1].pellets.items()
    low = min(
        history.least, least(problems[1], states[1], end), key=lambda each: each.value
    )
    return replace(
        history,
        u=states[1],
        time=end,
        dt=dt,
        steps=history.steps + 1,
        passed=passed,
        both_ways=both_ways,
        sources=sources,
        carried=carried,
        columns=tuple(row),
        outlet=(*history.outlet, tuple(row.values())),
        least=low,
        damping=of_next(problems[1], found.damping, step, dt),
        damped=history.damped | found.cells,
        steps_damped=history.steps_damped + bool(found.cells.any()),
        steps_limited=history.steps_limited + found.limited,
        unbounded=history.unbounded + (not found.within),
        most=max(history.most, problems[1].line.cells),
        rough=history.rough + step * rough,
        extents={
            (count, kind or ""): xi
            for kind, each in pellets
            for count, xi in each.known.items()
        },
    )


def turned(problem: Problem, u: Array) -> Array:
    """Return a first guess after a jump of the streams: the gas with its new flux,
    as hot as it was.
    """
    out, count = u.copy(), len(problem.names) // len(problem.layout.names)
    gas = problem.rows(Role.GAS)
    out[gas] *= count * sum(problem.streams.gas.values()) / u[gas].sum(axis=0).mean()
    return out


def outlet(problem: Problem, u: Array, fluxes: Array, time: float) -> dict[str, float]:
    """Return what leaves with the gas at a time; `fluxes` (m, 2) of all equations
    through both ends.
    """
    end = -1 if problem.streams.ahead else 0
    gas = {name: fluxes[k, end] for k, name in enumerate(problem.layout.gases)}
    total = sum(gas.values())
    state = results.values_at(problem, u, problem.line.vertices[[0, -1]])
    T = float(np.broadcast_to(state.T_fluid, (2,))[end])
    fractions = {f"x_{name} [1]": float(g / total) for name, g in gas.items()}
    return {"t [s]": time, "T_fluid [K]": T} | fractions | {FLOW: float(total)}
