"""Steps in time of a reacting bed: particles store moles and heat, the gas too or it follows at once.

    d/dt C(u) + R(u, t) = 0,    C what is held per volume of bed, zero for equations of a gas that follows at once

What is stored is exactly what has passed the ends, weighted as the stages of a step are (`stages`). No step crosses a
jump of a series, or a kink that is larger than its error allows: streams that enter have at each stage the values of
its time, and those before a jump where it ends there.
"""

from __future__ import annotations

import math
import time as clock
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.closures.reactions import R_GAS
from contbed.errors import ConvergenceError
from contbed.materials.composition import mole_fractions
from contbed.output.progress import Progress
from contbed.reacting_bed import results, solve
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.amounts import least
from contbed.reacting_bed.bounded import Bounded, bounded
from contbed.reacting_bed.equations.bed import conserved
from contbed.reacting_bed.history import SAME, History, output_times
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.schedule import Schedule
from contbed.reacting_bed.stages import GAMMA
from contbed.reacting_bed.storage import Storage
from contbed.reacting_bed.transient_results import contents, fill
from contbed.result import Result
from contbed.scene.identity import identity
from contbed.scene.toml_lines import KeyPath

Array = NDArray[np.float64]
Save = Callable[[History], None]
SMOOTH = 1e-5  # share of a solid that is left, below which its powers are straight lines
FIRST_STEP = 1e-5  # of the whole time, at the start and after a jump
SHORTEST_STEP = 1e-12  # of the whole time, below which a run is given up
SAFETY, MOST_GROWTH, LEAST_GROWTH = 0.8, 2.5, 0.2
STAGES = (GAMMA, 1.0)  # times of the stages of a step over its size
DIGITS = 2**10  # steps between two powers of 2: a thousandth, of estimates that rounding changes by 1e-9
SHORTER = 0.25  # of a step that does not converge
MOST_TRIALS = 4  # of a step whose amounts are below zero, each of a shorter one
MOST_UNBOUNDED = 10  # steps of a run with amounts below zero, from which on shorter ones are known not to help
LEAST_RANGE = 1.0  # [K] of the temperatures of a run, where those of the scene and of the bed differ by less


@dataclass(frozen=True)
class Course:
    """The bed of a scene in the course of a run, whose series have the values of a time; `problem` is at the start.

    `temperatures` are the lowest and highest of the scene: of what enters, of the wall and of the start [K].
    """

    scene: s.ReactingScene
    problem: Problem
    schedule: Schedule
    temperatures: tuple[float, float]

    @classmethod
    def of(cls, scene: s.ReactingScene, problem: Problem, schedule: Schedule, stores_gas: bool) -> Course:
        """Return the bed of a plan; a gas that is stored is so at the pressures of the first moment.

        Raises
        ------
        ConvergenceError : these are not found
        """
        moments = [problem.within(schedule.frozen(scene, moment)) for moment in schedule.moments() or [0.0]]
        problem = problem.with_small(SMOOTH).with_peaks(_peaks(scene, moments))
        course = cls(scene, problem, schedule, _temperatures(scene, moments))
        if not stores_gas:
            return course
        pressure: Any = problem.bed.p_in
        if problem.layout.pressure:
            u = course.start()
            storage = Storage.after(course.problem, u, FIRST_STEP * course.time.end)
            at_once = solve.newton(course.problem, u, solve.Report(), storage, most=solve.FIRST_ITERATIONS)
            pressure = problem.at_all_points(at_once)[problem.layout.names.index("p")]
        return replace(course, problem=course.problem.with_gas_stored(pressure))

    @property
    def time(self) -> s.Time:
        """The [time] table."""
        assert self.scene.time is not None
        return self.scene.time

    @cached_property
    def small(self) -> dict[KeyPath, float]:
        """Sizes of kinks of the series that a step may pass."""
        return self.schedule.small(self.time)

    @cached_property
    def cuts(self) -> list[float]:
        """Jumps and kinks of the series, with the start and the end of the run [s]."""
        return self.schedule.cuts(self.time.end, self.small)

    def seen(self, time: float, step: float) -> float:
        """Return the longest step [s] from a time, halved until its stages tell what the series do meanwhile."""
        while step > SHORTEST_STEP * self.time.end and not self.schedule.sees(time, time + step, STAGES, self.small):
            step *= 0.5
        return step

    def since(self, time: float) -> float:
        """Return the last jump or kink up to a time [s]."""
        return self.cuts[bisect_right(self.cuts, time * (1.0 + SAME)) - 1]

    def at(self, time: float, before: bool = True, since: float = 0.0) -> Problem:
        """Return the problem at a time [s], at a jump that `before` it, `since` an earlier one, or just after it."""
        if not self.schedule:
            return self.problem
        return self.problem.within(self.schedule.frozen(self.scene, time, before, since))

    def start(self) -> Array:
        """Return the state at the start (m, N, p + 1)."""
        problem, time = self.problem, self.time
        T = time.initial_temperature or problem.streams.T_gas
        u, moles = problem.start(T), sum(problem.streams.gas.values())
        if time.initial_composition is not None:
            fractions = mole_fractions(time.initial_composition)
            for k, name in enumerate(problem.names):
                if name.startswith("g_"):
                    u[k] = fractions.get(name[2:], 0.0) * moles
        molar, m = problem.streams.pressure / (R_GAS * T), len(problem.layout.names)
        for k, name in enumerate(problem.names):
            if name.startswith("a_"):  # particles begin in equilibrium with the gas around them
                gas = k - k % m + problem.layout.gases.index(str(conserved(name)))
                u[k] = u[gas] / moles * molar
        return u

    def sizes(self, u: Array) -> Array:
        """Return what errors of the unknowns refer to (m,): temperatures to the range of the scene and of a state."""
        out = self.problem.sizes.copy()
        rows = [k for k, name in enumerate(self.problem.names) if name in self.problem.layout.temperatures]
        if rows:
            low, high = self.temperatures
            out[rows] = max(high, u[rows].max()) - min(low, u[rows].min())
            out[rows] = np.maximum(out[rows], LEAST_RANGE)
        return out

    def stops(self) -> list[float]:
        """Return the times at which a step ends: output times, and jumps and kinks of the series [s]."""
        time = self.time
        found: list[float] = []
        for stop in sorted({*output_times(time), *self.cuts} - {0.0}):
            if not found or stop - found[-1] > SAME * stop:
                found.append(stop)
        return found


def _peaks(scene: s.ReactingScene, moments: list[Problem]) -> dict[str, float]:
    """Return the largest mole fraction of each gas that enters or fills the bed."""
    parts = [{name: g / sum(at.streams.gas.values()) for name, g in at.streams.gas.items()} for at in moments]
    assert scene.time is not None
    if scene.time.initial_composition is not None:
        parts.append(mole_fractions(scene.time.initial_composition))
    return {name: max(part.get(name, 0.0) for part in parts) for part in parts for name in part}


def _temperatures(scene: s.ReactingScene, moments: list[Problem]) -> tuple[float, float]:
    """Return the lowest and highest temperature of what enters, of the wall and of the start [K]."""
    assert scene.time is not None
    found: list[Any] = [T for at in moments for T in (at.streams.T_gas, at.streams.T_solid)]
    found += [at.scene.wall.ambient for at in moments if at.scene.wall is not None]
    known = [constant(T) for T in (*found, scene.time.initial_temperature) if T is not None]
    return min(known), max(known)


def run_transient(
    course: Course, result: Result, folder: Path | None, quiet: bool, start: tuple[Any, Any] | None
) -> None:
    """Take steps to the end and fill the result; the checkpoint in `folder` always holds an accepted step.

    Raises
    ------
    ConvergenceError : steps become ever smaller
    SceneError : the checkpoint does not fit the output times
    """
    time, origin = course.time, course.scene.origin
    report = solve.Report()
    history = begin(course) if start is None else History.unpack(*start).fitted(time, origin)
    label = identity(course.scene) if folder is not None else {}

    def save() -> None:
        if folder is not None:
            from contbed.output import checkpoint

            arrays, meta = history.pack()
            checkpoint.save(folder, arrays, meta | {"identity": label})

    saved = clock.monotonic()
    try:
        with result.timed("bed"), Progress(time.end, "s", quiet) as progress:
            for after in march(course, history, report):
                history = after
                progress.advance_to(history.time)
                if clock.monotonic() - saved >= time.checkpoint_every:
                    save()
                    saved = clock.monotonic()
    except ConvergenceError as error:
        raise ConvergenceError(
            f"{origin.name}: {error} at t = {history.time:.4g} s; {_advice(course, history)}",
            report.history,
            history.u,
        ) from None
    finally:
        result.history += report.history[-50:]
        if history.steps:
            fill(course.at, history, result)
        save()


def _advice(course: Course, history: History) -> str:
    """Return what to try where steps fail at a state."""
    problem, stops = course.at(history.time, before=False), "it would flow back from the other end"
    gases = [k for k, name in enumerate(problem.layout.names) if name.startswith("g_")]
    enters = abs(sum(problem.streams.gas.values()))
    u = turned(problem, history.u)
    taken = -float(problem.mean(problem.system.sources(u))[gases].sum())
    cooled = _contraction(problem, u)
    if problem.bed.gas_pressure is not None and taken >= enters:
        return (
            f"reactions take {taken:.3g} mol/m2/s of the gas that fills the bed and {enters:.3g} enter: {stops}. "
            'Begin with time.initial_composition of gas that has reacted, or give time.gas = "quasi_steady"'
        )
    if problem.bed.gas_pressure is not None and taken + cooled >= enters:
        return (
            f"the particles cool the gas that fills the bed, which makes room for {cooled:.3g} mol/m2/s, and "
            f'{enters:.3g} enter: {stops}. Give time.gas = "quasi_steady"'
        )
    return "use more mesh.cells, or smooth a rate whose slope is infinite where nothing is left"


def _contraction(problem: Problem, u: Array) -> float:
    """Return the moles that the gas in the pores makes room for as it cools to the particles [mol/m2/s].

    At constant pressure these are -n/T dT/dt, and the heat n c dT/dt is what the equations of the gas leave at `u`;
    none where gas and particles have one temperature.
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


def begin(course: Course) -> History:
    """Return the history at the start of a run."""
    u = course.start()
    held = contents(course.problem, u)
    passed, none = np.zeros((len(held), 2)), np.zeros(u.shape[:2])
    return History(u, FIRST_STEP * course.time.end, held, passed, passed, passed[:, 0], none, none[0] > 0.0)


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
            history = advanced(course, history, stop, report)
            if history.time == stop and stop in outputs:
                history = replace(history, kept={**history.kept, stop: history.u})
            yield history


def advanced(course: Course, history: History, stop: float, report: solve.Report) -> History:
    """Return the history after the longest step towards a time that its error allows, within bounds where one is found.

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
        pellets.known.update({count: xi for (count, of), xi in history.extents.items() if of == (kind or "")})


def _advanced(course: Course, history: History, stop: float, report: solve.Report, dt: float) -> History:
    """Return the history after a step no longer than dt that its error allows."""
    time = course.time
    shortest = SHORTEST_STEP * time.end
    u, since = history.u, course.since(history.time)
    if course.schedule and history.time > 0.0 and course.schedule.jumps(history.time):
        dt = min(dt, FIRST_STEP * time.end)
        u = turned(course.at(history.time, before=False), u)
    while True:
        step = course.seen(history.time, min(dt, stop - history.time))
        if step < shortest and stop - history.time > 2.0 * step:
            raise ConvergenceError("steps in time become ever smaller")
        problems = (course.at(history.time + GAMMA * step, since=since), course.at(history.time + step, since=since))
        try:
            found = bounded(problems, history.u, u, step, report, course.sizes(u), history.damping)
        except ConvergenceError:
            dt = SHORTER * step
            if dt < shortest:
                raise
            continue
        growth = SAFETY * (time.tolerance / max(found.error, 1e-300)) ** 0.5
        if found.error > time.tolerance and growth < 1.0:
            dt = with_few_digits(step * max(growth, LEAST_GROWTH))
            continue
        later = with_few_digits(dt * min(max(growth, LEAST_GROWTH), MOST_GROWTH)) if step == dt else dt
        end = history.time + step
        end = stop if end >= stop * (1.0 - SAME) else end
        return _passed(history, found, step, end, later)


def with_few_digits(dt: float) -> float:
    """Return the next shorter step of so few digits that rounding in the estimates of errors does not decide them."""
    mantissa, exponent = math.frexp(dt)
    return math.ldexp(math.floor(mantissa * DIGITS), exponent) / DIGITS


def _passed(history: History, found: Bounded, step: float, end: float, dt: float) -> History:
    """Return the history after a step; its weights are those of the stages, so that totals close to rounding."""
    problems, states = found.problems, found.states
    passed, both_ways, sources, carried = history.passed, history.both_ways, history.sources, history.carried
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
    low = min(history.least, least(problems[1], states[1], end), key=lambda each: each.value)
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
        damping=found.damping,
        damped=history.damped | found.cells,
        steps_damped=history.steps_damped + bool(found.cells.any()),
        steps_limited=history.steps_limited + found.limited,
        unbounded=history.unbounded + (not found.within),
        extents={(count, kind or ""): xi for kind, each in pellets for count, xi in each.known.items()},
    )


def turned(problem: Problem, u: Array) -> Array:
    """Return a first guess after a jump of the streams: the gas with its new flux, as hot as it was."""
    out, count = u.copy(), len(problem.names) // len(problem.layout.names)
    gas = [k for k, name in enumerate(problem.names) if name.startswith("g_")]
    out[gas] *= count * sum(problem.streams.gas.values()) / u[gas].sum(axis=0).mean()
    return out


def outlet(problem: Problem, u: Array, fluxes: Array, time: float) -> dict[str, float]:
    """Return what leaves with the gas at a time; `fluxes` (m, 2) of all equations through both ends."""
    end = -1 if problem.streams.ahead else 0
    gas = {name: fluxes[k, end] for k, name in enumerate(problem.layout.gases)}
    total = sum(gas.values())
    state = results.values_at(problem, u, problem.line.vertices[[0, -1]])
    T = float(np.broadcast_to(state.T_fluid, (2,))[end])
    return {"t [s]": time, "T_fluid [K]": T} | {f"x_{k} [1]": float(g / total) for k, g in gas.items()}
