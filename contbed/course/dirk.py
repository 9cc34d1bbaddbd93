"""TR-BDF2 in conservative form with error control.

For m(U)' + R(U, t) = 0, where m is the tested heat content and R the tested steady
residual, one step of size dt is

    m(U1) + d dt R(U1) = m(U0) - d dt R(U0)                      U1 at t + gamma dt
    m(U2) + d dt R(U2) = m(U0) - w dt (R(U0) + R(U1))            U2 at t + dt

with gamma = 2 - sqrt 2, d = gamma/2, w = sqrt 2/4 (Bank et al. 1985,
doi:10.1109/T-ED.1985.22232; Hosea & Shampine 1996, doi:10.1016/0168-9274(95)00115-8).
Both stages share one matrix, the method is L-stable, and summing the equations gives
the balance of the step to round-off. The embedded third-order error is filtered by the
same matrix.

Steps of linear problems have few sizes, powers of 2, so a few matrices serve the whole
run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp

from contbed.course.history import SAME
from contbed.course.march import POWERS_OF_TWO, Accept, Control, H, TimeSteps
from contbed.solvers.banded import Ordering
from contbed.solvers.condensed import Modes
from contbed.solvers.continuation import Problem
from contbed.solvers.linear import Policy, Solver, constrain
from contbed.solvers.newton import Options, newton

GAMMA = 2.0 - 2.0**0.5
D = GAMMA / 2.0
W = 2.0**0.5 / 4.0
WEIGHTS = (W, W, D)
# times of the states of a step, from its start, over its size
STAGES = (0.0, GAMMA, 1.0)
BEYOND = (1.0 - GAMMA) / GAMMA  # from the first stage on, over the way to it
_ERROR = (W - (1 - W) / 3, W - (3 * W + 1) / 3, D - D / 3)

# [s] below which a run is given up
SHORTEST = 2.0**-64
MAX_FACTORISATIONS = 3  # kept at a time


class TransientProblem(Problem, Protocol):
    """What the stages of a step solve; boundary values may change with time."""

    fixed_values: Any

    @property
    def time_dependent(self) -> bool:
        """Whether boundary values change with time."""

    def set_time(self, time: float) -> None:
        """Put the boundary values of a time [s] in place."""

    @property
    def nodal_modes(self) -> Modes | None:
        """Modes of the particles at the nodes of a line that are condensed; None
        without.
        """


@dataclass(frozen=True)
class Step:
    """One step.

    `start` and `size` [s]; `states` at the start, the stage and the end, `rates` their
    steady residuals; `gain` of tested content; `error` of the state.
    """

    start: float
    size: float
    states: tuple[Any, Any, Any]
    rates: tuple[Any, Any, Any]
    gain: Any
    error: Any

    @property
    def end(self) -> float:
        """End of the step [s]."""
        return self.start + self.size

    def at(self, time: float) -> Any:
        """Return the state at a time within the step, by the parabola through its
        three states.
        """
        s = (time - self.start) / self.size
        a, b, c = 0.0, GAMMA, 1.0
        la = (s - b) * (s - c) / ((a - b) * (a - c))
        lb = (s - a) * (s - c) / ((b - a) * (b - c))
        lc = (s - a) * (s - b) / ((c - a) * (c - b))
        return la * self.states[0] + lb * self.states[1] + lc * self.states[2]


class DirkSteps(TimeSteps[H]):
    """Steps of a problem that assembles content and steady residual.

    `span` is what errors refer to, `tolerance` the local error over it.
    """

    problem: Any  # a `TransientProblem`; each model uses more of its own
    stages: Any
    tolerance: float
    span: float

    def take(
        self, history: H, end: float, size: float, repeated: bool = False
    ) -> tuple[float, Accept[H]]:
        """Take a step, see `TimeSteps`."""
        step = self.stages.take(history.state, history.time, end, size)
        return self.scaled(step), partial(self.passed, history, step, end)

    def scaled(self, step: Step) -> float:
        """Return the largest error of a step over what is allowed."""
        largest = float(np.abs(step.error * self.problem.weights).max())
        return largest / (self.tolerance * self.span)

    def passed(self, history: H, step: Step, end: float, size: float) -> H:
        """Return the history after a step that ends at a time [s]; `size` is that of
        the next one [s].
        """
        return replace(
            history,
            state=step.states[-1],
            time=end,
            size=size,
            taken=step.size,
            steps=history.steps + 1,
        )

    def kept(
        self, history: H, step: Step, end: float, times: Sequence[float]
    ) -> dict[float, Any]:
        """Return the states at the output times up to the end of a step [s]."""
        kept = dict(history.kept)
        for time in times:
            if time not in kept and history.time < time <= end * (1 + SAME):
                kept[time] = step.states[-1] if time >= end else step.at(time)
        return kept


def ladder(first: float, constant: float | None = None) -> Control:
    """Return the control of steps by powers of 2; all steps are `constant` if that is
    given [s].
    """
    if constant is not None:
        return Control(constant, 0.0, 3, 1.0, POWERS_OF_TWO, True)
    return Control(first, SHORTEST, 3, 4.0, POWERS_OF_TWO)


def stages_of(
    problem: TransientProblem,
    policy: Policy,
    options: Options,
    origin: Any = 0.0,
    start: float = 0.0,
) -> Any:
    """Return the cheapest stages that solve a problem: bands, with insides of
    particles condensed, or general.

    Linear problems are measured from the state `origin` at the time `start`, which
    loses fewer digits than measuring from zero.
    """
    if not problem.linear:
        return _Stages(problem, policy, options)
    affine, modes = _Affine(problem, origin, start), problem.nodal_modes
    mass, stiffness = affine.mass, affine.stiffness
    # matrices of another engine solve by themselves
    if not sp.issparse(stiffness):
        return _Stages(affine, policy, options)
    if modes is not None and (found := modes.matrices(mass, stiffness)) is not None:
        return _LineStages(affine, *found)
    ordering = Ordering.of(abs(mass) + abs(stiffness))
    if ordering is None:
        return _Stages(affine, policy, options)
    return _LineStages(affine, ordering, ordering.band(mass), ordering.band(stiffness))


class _Affine:
    """A linear problem as two matrices and vectors: a residual costs a product instead
    of an assembly.

    The vector of the residual is linear in the weights of the boundary values, which
    the problem puts in place.
    """

    linear, nodal_modes = True, None

    def __init__(self, problem: Any, origin: Any, start: float):
        self.fixed, self.weights, self.origin = problem.fixed, problem.weights, origin
        self.time_dependent = problem.time_dependent
        self._others: list[tuple[Any, Any]] = []
        if problem.time_dependent:
            self._weights = problem.interpolation_weights
            every = np.eye(len(problem.interpolation_weights(start)))
            for weights in every:
                problem.apply_boundary_values(weights)
                self._others.append(
                    (problem.steady(origin, False)[0], np.array(problem.fixed_values))
                )
            problem.apply_boundary_values(np.zeros(len(every)))
        self.vector, self.stiffness = problem.steady(origin, True)
        self._first = self.vector, np.array(problem.fixed_values)
        self._content, self.mass = problem.content(origin, True)
        self.fixed_values = self._first[1]

    def set_time(self, time: float) -> None:
        if self.time_dependent:
            vector, self.fixed_values = self._first
            for share, (other, fixed) in zip(
                self._weights(time), self._others, strict=True
            ):
                vector = vector + share * (other - self._first[0])
                self.fixed_values = self.fixed_values + share * (fixed - self._first[1])
            self.vector = vector

    def content(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        return self._content + self.mass @ (state - self.origin), self.mass

    def steady(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        return self.vector + self.stiffness @ (state - self.origin), self.stiffness


class _Stages:
    """The two stages of a step, with factorisations kept for each size of step."""

    def __init__(self, problem: TransientProblem, policy: Policy, options: Options):
        self.problem, self.policy, self.options = problem, policy, options
        self.fixed = problem.fixed
        self.solvers: dict[float, Callable[[Any], Any]] = {}
        self.last: tuple[Any, Any, Any, Any] | None = None

    def take(self, state: Any, start: float, end: float, dt: float) -> Step:
        if self.last is None or self.last[0] is not state:
            self._set_time(start)
            x = self._inward(state)
            self.last = state, x, self._content(x), self._steady(x)
        _, x, content, steady = self.last
        self._set_time(start + GAMMA * dt)
        state_first, first = self._solve(x, content - D * dt * steady, dt)
        steady_first = self._steady(first)
        self._set_time(end)
        rhs = content - W * dt * (steady + steady_first)
        beyond = first + BEYOND * (first - x)
        # a temperature stays above 0 K
        guess = np.where(first * beyond > 0.0, beyond, first)
        state_last, last = self._solve(guess, rhs, dt)
        steady_last = self._steady(last)
        defect = -dt * (
            _ERROR[0] * steady + _ERROR[1] * steady_first + _ERROR[2] * steady_last
        )
        defect[self.fixed] = 0.0
        error = self._solver(last, dt)(defect)
        content_last = self._content(last)
        if np.isfinite(error).all():
            self.last = state_last, last, content_last, steady_last
        out = self._outward
        return Step(
            start,
            dt,
            (state, state_first, state_last),
            (out(steady), out(steady_first), out(steady_last)),
            out(content_last - content),
            out(error),
        )

    def _inward(self, state: Any) -> Any:
        return state

    def _outward(self, vector: Any) -> Any:
        return vector

    def _set_time(self, time: float) -> None:
        self.problem.set_time(time)

    def _content(self, x: Any) -> Any:
        return self.problem.content(x, False)[0]

    def _steady(self, x: Any) -> Any:
        return self.problem.steady(x, False)[0]

    def _system(self, dt: float) -> Callable[[Any, bool], tuple[Any, Any]]:
        def assemble(state: Any, jacobian: bool) -> tuple[Any, Any]:
            content, mass = self.problem.content(state, jacobian)
            steady, stiffness = self.problem.steady(state, jacobian)
            return (
                content + D * dt * steady,
                mass + D * dt * stiffness if jacobian else None,
            )

        return assemble

    def _solver(self, x: Any, dt: float) -> Callable[[Any], Any]:
        if self.problem.linear and dt in self.solvers:
            return self.solvers[dt]
        matrix = self._system(dt)(x, True)[1]
        solver = Solver(constrain(matrix, self.fixed), self.policy)
        if self.problem.linear:
            while len(self.solvers) >= MAX_FACTORISATIONS:
                self.solvers.pop(next(iter(self.solvers)))
            self.solvers[dt] = solver
        return solver

    def _solve(self, guess: Any, rhs: Any, dt: float) -> tuple[Any, Any]:
        """Return the state of a stage, and its unknowns as the matrices have them."""
        assemble, fixed = self._system(dt), self.fixed
        if self.problem.time_dependent:
            guess = guess.copy()
            guess[fixed] = self.problem.fixed_values
        if self.problem.linear:
            residual = rhs - assemble(guess, False)[0]
            residual[fixed] = 0.0
            found = guess + self._solver(guess, dt)(residual)
            return found, found

        def shifted(state: Any, jacobian: bool) -> tuple[Any, Any]:
            residual, matrix = assemble(state, jacobian)
            return residual - rhs, matrix

        found, _ = newton(shifted, guess, fixed, self.policy, self.options)
        return found, found


class _LineStages(_Stages):
    """The two stages of a step of a linear problem on a line.

    All vectors are in the order of the matrices and count from the origin of `_Affine`.
    """

    def __init__(self, problem: _Affine, ordering: Ordering, mass: Any, stiffness: Any):
        super().__init__(problem, Policy(1), Options())
        self.affine, self.order, self.back = problem, ordering.order, ordering.back
        self.mass, self.stiffness = mass, stiffness
        self.prescribed = ordering.back[problem.fixed]
        self.fixed = np.sort(self.prescribed)

    def _inward(self, state: Any) -> Any:
        return (state - self.affine.origin)[self.order]

    def _outward(self, vector: Any) -> Any:
        return vector[self.back]

    def _set_time(self, time: float) -> None:
        self.affine.set_time(time)
        self.vector = self.affine.vector[self.order]

    def _content(self, x: Any) -> Any:
        return self.mass @ x

    def _steady(self, x: Any) -> Any:
        return self.stiffness @ x + self.vector

    def _solver(self, x: Any, dt: float) -> Callable[[Any], Any]:
        if dt not in self.solvers:
            self.solvers[dt] = self.mass.plus(self.stiffness, D * dt).solver(self.fixed)
        return self.solvers[dt]

    def _solve(self, guess: Any, rhs: Any, dt: float) -> tuple[Any, Any]:
        affine = self.affine
        if affine.time_dependent:
            guess = guess.copy()
            change = affine.fixed_values - affine.origin[affine.fixed]
            guess[self.prescribed] = change
        residual = rhs - self.mass @ guess - (D * dt) * self._steady(guess)
        residual[self.fixed] = 0.0
        found = (guess + self._solver(guess, dt)(residual))[self.back]
        state = affine.origin + found
        # as a restart from this state finds it, to the last bit
        return state, self._inward(state)
