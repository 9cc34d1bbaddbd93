"""Steps in time of a reacting bed: particles store moles and heat, the gas too or it
follows at once.

    d/dt C(u) + R(u, t) = 0,    C the content per volume of bed, zero for equations of a gas that follows at once

What is stored is exactly what has passed the ends, weighted as the stages of a step are
(`stages`). No step crosses a jump of a series, or a kink that is larger than its error
allows: streams that enter have at each stage the values of its time, and those before a
jump where it ends there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from contbed.arrays import Array
from contbed.course.history import output_times
from contbed.course.march import FEW_DIGITS, SHORTER, Accept, Control, TimeSteps
from contbed.errors import ConvergenceError
from contbed.reacting_bed import results, solve
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.cycle import Stored
from contbed.reacting_bed.equations.unknowns import Role
from contbed.reacting_bed.history import FLOW, BedHistory
from contbed.reacting_bed.least_amounts import least
from contbed.reacting_bed.positivity_in_time import Bounded, bounded, of_next
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.rate_checks import taken_though_absent
from contbed.reacting_bed.stages import GAMMA, beyond
from contbed.reacting_bed.time_cells import following, on_cells
from contbed.reacting_bed.transient_results import contents

MOST_GROWTH = 2.5
SHORTEST_STEP = 1e-7  # of the first one, below which a run is given up
MOST_TRIALS = 4  # of a step whose amounts are below zero, each of a shorter one
# steps of a run with amounts below zero, from which on shorter ones are known not to
# help
MOST_UNBOUNDED = 10


def begin(course: Course, u: Array) -> BedHistory:
    """Return the history at the start of a run from a state."""
    held = contents(course.problem, u)
    passed, none = np.zeros((len(held), 2)), np.zeros(u.shape[:2])
    pressure = course.problem.bed.gas_pressure
    return BedHistory(
        state=u,
        size=course.first_step,
        held=held,
        passed=passed,
        both_ways=passed,
        sources=passed[:, 0],
        damping=none,
        damped=none[0] > 0.0,
        vertices=course.problem.line.vertices,
        pressure=pressure if course.rounds and np.ndim(pressure) else None,
    )


class BedSteps(TimeSteps[BedHistory]):
    """The time steps of a course."""

    def __init__(self, course: Course, report: solve.Report):
        self.course, self.report = course, report
        self.outputs = {*output_times(course.time)}
        first = course.first_step
        self.control = Control(first, SHORTEST_STEP * first, 2, MOST_GROWTH, FEW_DIGITS)

    def scale(self, after: BedHistory) -> Array:
        """Return the sizes of the unknowns (m,)."""
        return self.course.sizes(after.state)

    def stored(self, state: Array, scale: Array) -> Array:
        """Return what is stored of a state, over its sizes."""
        return Stored.of(self.course.problem, scale).values(state)

    def begun(self, values: Array, scale: Array, after: BedHistory) -> BedHistory:
        """Return the history at the start of a period from extrapolated values."""
        stored = Stored.of(self.course.problem, scale)
        return self.again(replace(after, state=stored.bounded(values, after.state)))

    def again(self, after: BedHistory) -> BedHistory:
        """Return the history at the start of a period that follows another."""
        history = begin(self.course, turned(self.course.problem, after.state))
        return replace(history, damping=after.damping, extents=after.extents)

    def stops(self) -> list[float]:
        """Return output times, and jumps and kinks of the series [s]."""
        return self.course.stops()

    def resolves(self, start: float, end: float) -> bool:
        """Return whether a step sees how the series change."""
        return self.course.resolves(start, end)

    def entered(self, history: BedHistory, stop: float) -> BedHistory:
        """Return the history with a short step after a jump."""
        if not self._jumps(history):
            return history
        return replace(history, size=min(history.size, self.control.first))

    def march(self, history: BedHistory) -> Iterator[BedHistory]:
        """Yield the histories after each step, see `TimeSteps`."""
        self._guess_inside(history)
        yield from super().march(history)

    def repeated(
        self, history: BedHistory, sizes: Iterable[float]
    ) -> Iterator[tuple[BedHistory, float]]:
        """Yield the histories after steps of given sizes, see `TimeSteps`."""
        self._guess_inside(history)
        yield from super().repeated(history, sizes)

    def advanced(self, history: BedHistory, stop: float) -> BedHistory:
        """Return the history after the longest step that its error allows, within
        bounds where one is found.
        """
        size, longest = history.size, None
        for _ in range(MOST_TRIALS):
            try:
                after = self.controlled(history, stop, size)
            except ConvergenceError:
                if longest is None:
                    raise
                break
            if after.unbounded == history.unbounded:
                return after
            longest = longest or after
            if history.unbounded >= MOST_UNBOUNDED:
                break
            size = self.control.rounded(SHORTER * (after.time - history.time))
        assert longest is not None
        self._guess_inside(longest)
        return longest

    def take(
        self, history: BedHistory, end: float, size: float, repeated: bool = False
    ) -> tuple[float, Accept[BedHistory]]:
        """Take a step, on cells adapted to its errors; see `TimeSteps`."""
        course = self.course = self.course.on(history)
        tolerance = course.time.tolerance
        rounds, rough = course.rounds, 0.0
        while True:
            since, time, u = course.since(history.time), history.time, history.state
            guess = self._guess(course, history)
            found = bounded(
                (
                    course.at(time + GAMMA * size, since=since),
                    course.at(time + size, since=since),
                ),
                u,
                guess,
                size,
                self.report,
                course.sizes(guess),
                history.damping,
                self._near(course, history, size),
                repeated,
                history.steps_limited > 0,
            )
            if found.error <= tolerance and course.rounds:
                states = (u, found.states[1])
                better, rough = following(course.problem, states, course.sizes(guess))
                if better is not None and rounds:
                    try:
                        course, history = on_cells(course, history, better)
                        rounds -= 1
                        continue
                    # cells that would hold more than particles can stay as they are
                    except ConvergenceError:
                        pass
            accept = partial(self._passed, history, found, size, end, rough)
            return found.error / tolerance, accept

    def _jumps(self, history: BedHistory) -> bool:
        schedule = self.course.schedule
        return bool(schedule) and history.time > 0.0 and schedule.jumps(history.time)

    def _guess(self, course: Course, history: BedHistory) -> Array:
        """Return the first guess of a step: the state, or after a jump another with the
        flux of the gas that enters.
        """
        if not self._jumps(history):
            return np.asarray(history.state)
        return turned(course.at(history.time, before=False), history.state)

    def _near(self, course: Course, history: BedHistory, size: float) -> Array | None:
        """Return where the first stage of a step is sought first: on the line through
        the last states; None after a jump.
        """
        if history.stage is None or self._jumps(history):
            return None
        u = history.state
        share = GAMMA * size / ((1.0 - GAMMA) * history.taken)
        return beyond(course.problem, u, share * (u - history.stage))

    def _guess_inside(self, history: BedHistory) -> None:
        """Take the first guesses inside of pellets from a history."""
        for kind, pellets in self.course.problem.pellets.items():
            pellets.known.update(
                {
                    count: xi
                    for (count, of), xi in history.extents.items()
                    if of == (kind or "")
                }
            )

    def _passed(
        self,
        history: BedHistory,
        found: Bounded,
        step: float,
        end: float,
        rough: float,
        size: float,
    ) -> BedHistory:
        """Return the history after a step; its weights are those of the stages, so that
        totals close to rounding.
        """
        problems, states = found.problems, found.states
        passed = history.passed
        both_ways = history.both_ways
        sources = history.sources
        carried = history.carried
        fluxes = passed
        for problem, u, weight in zip(
            problems, states, (1.0 - GAMMA, GAMMA), strict=True
        ):
            fluxes = problem.mean(problem.system.fluxes(u)[:, [0, -1]])
            passed = passed + step * weight * fluxes
            both_ways = both_ways + step * weight * np.abs(fluxes)
            sources = sources + step * weight * problem.mean(problem.system.sources(u))
            if problem.layout.temperatures:
                carried += step * weight * results.heat_carried(problem, u)
        row = outlet(problems[1], states[1], fluxes, end)
        pellets = problems[1].pellets.items()
        low = min(
            history.least,
            least(problems[1], states[1], end),
            key=lambda each: each.value,
        )
        absent = history.absent
        if absent is None and not found.within:
            absent = taken_though_absent(problems[1], states[1])
            absent = absent and f"{absent}, at t = {end:.4g} s"
        after = replace(
            history,
            state=states[1],
            stage=states[0],
            time=end,
            size=size,
            taken=step,
            steps=history.steps + 1,
            passed=passed,
            both_ways=both_ways,
            sources=sources,
            carried=carried,
            columns=tuple(row),
            outlet=(*history.outlet, tuple(row.values())),
            least=low,
            damping=of_next(problems[1], found.damping, step, size),
            damped=history.damped | found.cells,
            steps_damped=history.steps_damped + bool(found.cells.any()),
            steps_limited=history.steps_limited + found.limited,
            absent=absent,
            unbounded=history.unbounded + (not found.within),
            most=max(history.most, problems[1].line.cells),
            rough=history.rough + step * rough,
            extents={
                (count, kind or ""): xi
                for kind, each in pellets
                for count, xi in each.known.items()
            },
        )
        return after.keeping(end) if end in self.outputs else after


def turned(problem: Problem, u: Array) -> Array:
    """Return a first guess after a jump of the streams: the gas with its new flux,
    as hot as it was.
    """
    out, gas = u.copy(), problem.rows(Role.GAS)
    out[gas] *= problem.ring_count * problem.streams.moles / u[gas].sum(axis=0).mean()
    return out


def outlet(problem: Problem, u: Array, fluxes: Array, time: float) -> dict[str, float]:
    """Return what leaves with the gas at a time; `fluxes` (m, 2) of all equations
    through both ends.
    """
    end = -1 if problem.streams.ahead else 0
    gas = {name: fluxes[k, end] for k, name in enumerate(problem.layout.gases)}
    total = sum(gas.values())
    T = results.at_end(results.state_at_ends(problem, u).T_fluid, end)
    fractions = {f"x_{name} [1]": float(g / total) for name, g in gas.items()}
    return {"t [s]": time, "T_fluid [K]": T} | fractions | {FLOW: float(total)}
