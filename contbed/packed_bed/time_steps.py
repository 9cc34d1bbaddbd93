"""Time steps of a packed bed: the account of a step, jumps between the parts of a run,
and the flow that follows the temperatures.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from contbed.course.dirk import (
    STAGES,
    WEIGHTS,
    DirkSteps,
    Step,
    ladder,
    stages_of,
)
from contbed.course.history import SAME, History, output_times
from contbed.course.march import Accept
from contbed.packed_bed.cell_errors import estimate, refinable
from contbed.packed_bed.equations.two_energy import FIELDS
from contbed.packed_bed.heat import HeatProblem
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.run_parts import heat_problem
from contbed.packed_bed.streams import Outlets
from contbed.result import Result
from contbed.scene.mesh import MeshLine

# [K] scale of the errors of a bed that only fluxes or sources drive from one
# temperature
ONE_KELVIN = 1.0
# of the estimated error of a cell that a step may add where properties vary: a front
# which the cells cannot hold needs no finer steps
OF_CELLS = 0.1
# [s] first step, at the start and after a jump, of steps that follow their errors
FIRST_STEP = 2.0**-10


@dataclass(frozen=True, kw_only=True)
class HeatHistory(History):
    """State of a transient run and its integrals over time so far.

    `mean` is the time integral of the state, `reaction` of the heat that prescribed
    temperatures conduct in by boundary, `flux` of the boundary fluxes where properties
    or boundary values vary, `both_ways` of the magnitudes of these and `conducted` of
    those, `gain` of the content; `ranges` is the record of how
    closures were used, see `Medium.state`; rows of `outlet` end with the heat so far,
    see `by_streams`; `flow` that of `FlowOverTime.pack`;
    `vertices` are those of a line.
    """

    mean: Any = 0.0
    reaction: Any = 0.0
    flux: Mapping[str, float] = field(default_factory=dict)
    both_ways: float = 0.0
    conducted: float = 0.0
    gain: float = 0.0
    ranges: Mapping[str, Any] = field(default_factory=dict)
    flow: Mapping[str, Any] = field(default_factory=dict)
    vertices: Any = None

    def conducted_in(self, problem: HeatProblem) -> dict[str, float]:
        """Return the heat that prescribed temperatures have conducted in so far by
        boundary [J].
        """
        names = problem.boundaries
        heats = np.broadcast_to(self.reaction, len(names)).tolist()
        return dict(zip(names, heats, strict=True))


class HeatSteps(DirkSteps[HeatHistory]):
    """The time steps of a plan.

    `local` is the flow that follows the temperatures, None for another; `renewed` are
    the numbers of the steps before which it was solved anew, `known` those of a run
    that is repeated. `accounts` says whether fluxes and outlets are recorded.
    """

    def __init__(
        self,
        plan: Plan,
        flow: Any,
        result: Result,
        known: Collection[int] | None = None,
        accounts: bool = True,
    ):
        time = plan.scene.time
        assert time is not None
        self.plan, self.flow, self.result = plan, flow, result
        self.known, self.accounts = known, accounts
        self.intervals = plan.intervals()
        self.outputs = output_times(time)
        self.tolerance = time.tolerance
        self.periodic = time.cycle is not None
        self.control = ladder(FIRST_STEP, time.step)
        self.local: Any = None
        self.renewed: list[int] = []
        self.posed: dict[float, tuple[Plan, HeatProblem]] = {}
        if flow is not None and not plan.medium.fluid.constant:
            from contbed.packed_bed.local_flow import FlowOverTime

            self.local = FlowOverTime(result, flow)
        self._pose(self.intervals[0])

    def _pose(self, interval: Any) -> None:
        """Pose the problem of a part of the run, in the present flow."""
        start = 0.0 if interval is None else interval.start
        if start not in self.posed:
            if not self.periodic:
                self.posed.clear()
            plan = self.plan if interval is None else self.plan.within(interval)
            flow = self.flow if self.local is None else self.local.flow
            problem = heat_problem(plan, flow, self.result, interval)
            self.posed[start] = plan, problem
        self.plan, self.problem = self.posed[start]
        low, high = self.problem.T_span
        self.span = high - low if high > low else ONE_KELVIN

    def begin(self) -> HeatHistory:
        """Return the history at the start of the run: prescribed temperatures have
        taken or given the heat between the state without them and that with them.
        """
        problem = self.problem
        state = problem.begin(self.plan.policy)
        line = isinstance(self.plan.solved.mesh, MeshLine)
        vertices = self.plan.line_vertices if line else None
        first = self.control.first
        history = HeatHistory(
            state=problem.unprescribed(), size=first, vertices=vertices
        )
        history = _prescribed(problem, history, state)
        return history.keeping(0.0) if self.outputs[0] == 0.0 else history

    def scale(self, after: HeatHistory) -> Any:
        """Return the span of temperatures, as that of each unknown."""
        return self.span / np.broadcast_to(self.problem.weights, after.state.shape)

    def stored(self, state: Any, scale: Any) -> Any:
        """Return the state over its scale: all of it is stored."""
        return state / scale

    def begun(self, values: Any, scale: Any, after: HeatHistory) -> HeatHistory:
        """Return the history at the start of a period from an extrapolated state."""
        return self.again(replace(after, state=values * scale))

    def again(self, after: HeatHistory) -> HeatHistory:
        """Return the history at the start of a period from a state."""
        first, vertices = self.control.first, after.vertices
        nothing = np.zeros(len(self.problem.boundaries))
        return HeatHistory(
            state=after.state, size=first, vertices=vertices, reaction=nothing
        )

    def stops(self) -> list[float]:
        """Return the times of jumps and kinks, and the end [s]."""
        ends = [each.end for each in self.intervals if each is not None]
        return ends or [self.outputs[-1]]

    def resolves(self, start: float, end: float) -> bool:
        """Return whether a step misses less of the series than is small."""
        interval = self.problem.interval
        return interval is None or interval.resolves(start, end, STAGES)

    def entered(self, history: HeatHistory, stop: float) -> HeatHistory:
        """Return the history at the begin of the part of the run that ends at a stop,
        after a jump, or within it.
        """
        interval = self.intervals[self.stops().index(stop)]
        self._pose(interval)
        self.plan.medium.restore(history.ranges)
        begins = history.time <= (interval.start if interval else 0.0) * (1 + SAME)
        if begins and interval is not None:
            history = self._jumped(history)
        if self.local is not None:
            if history.flow:
                self.local.restore(self.problem, history.flow)
            history = self._with_flow(history, begins)
        else:
            self._stage()
        if self.problem.linear:  # closures have been evaluated once for all steps
            self.plan.medium.record()
            history = replace(history, ranges=self.plan.medium.state())
        self.outlets = Outlets(self.problem, history.state)
        return history

    def _stage(self) -> None:
        """Prepare the stages of the present problem."""
        problem = self.problem
        # temperatures count from it, intraparticle modes from 0
        uniform = np.zeros(problem.system.size)
        uniform[problem.heats] = problem.T_span[0]
        policy = problem.system.ordered(self.plan.policy)
        start = 0.0 if problem.interval is None else problem.interval.start
        options = problem.options("time step")
        self.stages = stages_of(problem, policy, options, uniform, start)

    def _with_flow(self, history: HeatHistory, begins: bool = False) -> HeatHistory:
        """Return the history with the flow of its temperatures, which is solved anew
        where they have changed much.
        """
        local = self.local
        done = self.renewed[-1:] == [history.steps]
        if begins or (not done and self._outdated(history)):
            self.renew_flow(history)
        if self.problem.flow is not local.flow:
            interval, system = self.problem.interval, self.problem.system
            self.problem = heat_problem(
                self.plan, local.flow, self.result, interval, system
            )
            self._stage()
            self.outlets = Outlets(self.problem, history.state)
        return replace(history, flow=local.pack())

    def renew_flow(self, history: HeatHistory) -> None:
        """Solve the flow at the time and the temperatures of a history."""
        self.problem.set_time(history.time)
        self.local.solve(self.plan, self.problem, history.state)
        self.renewed.append(history.steps)

    def _outdated(self, history: HeatHistory) -> bool:
        if self.known is not None:
            return history.steps in self.known
        found: bool = self.local.outdated(self.plan, self.problem, history.state)
        return found

    def _jumped(self, history: HeatHistory) -> HeatHistory:
        """Return the history at the begin of a part of the run: prescribed temperatures
        have their values after a jump, and give the heat that it takes.
        """
        problem, interval = self.problem, self.problem.interval
        assert interval is not None
        problem.set_time(interval.start)
        state = np.array(history.state)
        state[problem.fixed] = problem.fixed_values
        state = problem.consistent(state, self.plan.policy)
        if interval.jumps:
            history = replace(history, size=self.control.first)
        return _prescribed(problem, history, state)

    def take(
        self, history: HeatHistory, end: float, size: float, repeated: bool = False
    ) -> tuple[float, Accept[HeatHistory]]:
        """Take a step in the flow of its temperatures."""
        if self.local is not None:
            history = self._with_flow(history)
        return super().take(history, end, size, repeated)

    def scaled(self, step: Step) -> float:
        """Return the largest error of a step over what is allowed: the tolerance and a
        share of the error of the cells.
        """
        problem = self.problem
        if problem.linear or not refinable(problem.mesh):
            return super().scaled(step)
        error = np.abs(step.error * problem.weights)
        allowed = self.tolerance * self.span
        largest = error[problem.heats.stop :].max(initial=0.0) / allowed
        for name in FIELDS:
            space = problem.system.fields[name][0]
            cells = estimate(space, problem.system.part(step.states[-1], name))
            local = problem.system.part(error, name)[space.dofs]
            share = local / (allowed + OF_CELLS * cells)
            largest = max(largest, float(share.max()))
        return float(largest)

    def passed(
        self, history: HeatHistory, step: Step, end: float, size: float
    ) -> HeatHistory:
        """Return the history after a step; the weights are those of the method, so the
        sums close to round-off.
        """
        problem, after = self.problem, super().passed(history, step, end, size)
        if not self.accounts:
            return after
        weights = [weight * step.size for weight in WEIGHTS]
        reaction, conducted = history.reaction, history.conducted
        if len(problem.fixed):
            supplied = step.gain + _weighted(weights, step.rates)
            heats = _by_boundary(problem, supplied[problem.fixed])
            reaction = reaction + heats
            conducted += float(np.abs(heats).sum())
        ranges = history.ranges
        if not problem.linear:
            problem.medium.record()
            ranges = problem.medium.state()
        flux, both_ways = self._fluxes(history, step, weights)
        streams = by_streams(fluxes_of(flux), {"": float(np.sum(reaction))})
        return replace(
            after,
            mean=history.mean + _weighted(weights, step.states),
            reaction=reaction,
            conducted=conducted,
            flux=flux,
            both_ways=both_ways,
            gain=history.gain + float(np.sum(step.gain[problem.heats])),
            ranges=ranges,
            kept=self.kept(history, step, end, self.outputs),
            outlet=(*history.outlet, (*self.outlets(end, after.state), *streams)),
        )

    def _fluxes(
        self, history: HeatHistory, step: Step, weights: list[float]
    ) -> tuple[Mapping[str, float], float]:
        """Return the integrals of the boundary fluxes after a step, and the sum of the
        integrals of their magnitudes.
        """
        problem, sums = self.problem, dict(history.flux)
        both_ways = history.both_ways
        if problem.linear and problem.interval is None:
            return sums, both_ways
        for weight, state, share in zip(weights, step.states, STAGES, strict=True):
            problem.set_time(step.start + share * step.size)
            for name, parts in problem.fluxes(state).items():
                for kind, value in parts.items():
                    key = f"{name}.{kind}"
                    sums[key] = sums.get(key, 0.0) + weight * value
                    both_ways += weight * abs(value)
        return sums, both_ways


def _prescribed(problem: HeatProblem, history: HeatHistory, state: Any) -> HeatHistory:
    """Return the history with a state in which prescribed temperatures have their
    values, which give the heat that it takes.
    """
    between, reaction = np.array(history.state), np.zeros(len(problem.boundaries))
    before = problem.content(between, False)[0][problem.heats]
    for owner in np.unique(problem.fixed_owner):
        nodes = problem.fixed[problem.fixed_owner == owner]
        between[nodes] = state[nodes]
        after = problem.content(between, False)[0][problem.heats]
        reaction[owner] = float(np.sum(after - before))
        before = after
    return replace(
        history,
        state=state,
        gain=history.gain + float(reaction.sum()),
        reaction=history.reaction + reaction,
        conducted=history.conducted + float(np.abs(reaction).sum()),
    )


def _weighted(weights: list[float], values: tuple[Any, ...]) -> Any:
    pairs = zip(weights, values, strict=True)
    return sum(weight * value for weight, value in pairs)


def _by_boundary(problem: HeatProblem, reaction: Any) -> Any:
    return np.array(list(problem.sums_by_boundary(reaction).values()))


def integrated_fluxes(
    problem: HeatProblem, history: HeatHistory
) -> dict[str, dict[str, float]]:
    """Return the heat through each boundary over the run [J].

    Linear fluxes are those of the mean state times the duration.
    """
    if problem.linear and problem.interval is None:
        fluxes = problem.fluxes(history.mean / history.time)
        return {
            name: {kind: value * history.time for kind, value in parts.items()}
            for name, parts in fluxes.items()
        }
    return fluxes_of(history.flux)


def heat_both_ways(
    fluxes: Mapping[str, Mapping[str, float]], history: HeatHistory
) -> float:
    """Return the heat through all boundaries, in plus out, of a run with these
    fluxes [J].
    """
    found = history.both_ways
    if not history.flux:
        parts = [value for flux in fluxes.values() for value in flux.values()]
        found = sum(abs(value) for value in parts)
    return found + history.conducted


def fluxes_of(flux: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Return the heat through each boundary so far, where values change [J]."""
    out: dict[str, dict[str, float]] = {}
    for key, value in flux.items():
        name, kind = key.rsplit(".", 1)
        out.setdefault(name, {})[kind] = value
    return out


def by_streams(
    fluxes: dict[str, dict[str, float]], reactions: dict[str, float]
) -> tuple[float, float]:
    """Return the heat into the bed by streams of the fluid, and otherwise [J]."""
    kinds = [pair for parts in fluxes.values() for pair in parts.items()]
    left = sum(value for kind, value in kinds if kind == "T_fluid")
    other = sum(value for kind, value in kinds if kind != "T_fluid")
    return left, other + sum(reactions.values())
