"""Newton's method with exact Jacobians and step control; the history of residuals is
kept when it fails.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.errors import ConvergenceError
from contbed.solvers.linear import Policy, Solver, constrain

MAX_SHARE_TO_BOUND = 0.7  # share of the way to a lower bound that one step may go
MAX_POLISHING_STEPS = 6  # steps at most after convergence

Assemble = Callable[[Any, bool], tuple[Any, Any]]


@dataclass(frozen=True)
class Options:
    """How Newton's method ends.

    No step takes an unknown further than `MAX_SHARE_TO_BOUND` of its distance to
    `lower`. Residuals below `floor` count as rounding where the relative step is below
    `far_step`; if `floor` is None, it is estimated from the terms that cancel in them.
    `weights` make the steps of all unknowns comparable. A `rough` solution, where
    another problem starts, is not improved after convergence.
    """

    tolerance: float = 1e-10
    iterations: int = 30
    lower: Any = -np.inf
    weights: Any = 1.0
    what: str = "Newton"
    floor: float | None = None
    far_step: float = np.inf
    rough: bool = False

    @classmethod
    def of(cls, scene: Any, **others: Any) -> Options:
        """Return the options of a scene."""
        solver = scene.solver
        return cls(solver.newton_tolerance, solver.newton_iterations, **others)


def newton(
    assemble: Assemble,
    state: Any,
    fixed: Any,
    policy: Policy,
    options: Options = Options(),
    linear: bool = False,
) -> tuple[Any, list[float]]:
    """Solve `assemble(state, jacobian) -> (residual, matrix)` for the unknowns not in
    `fixed`.

    `state` already holds the fixed values. The norm is that of the residual relative to
    the first one. A step that raises it is halved. A linear problem takes one step.
    Returns the state and the history of norms.
    """
    tolerance, floor, what = options.tolerance, options.floor, options.what
    weights, far_step = options.weights, options.far_step
    state = state.copy()
    residual, matrix = assemble(state, True)
    residual[fixed] = 0.0
    scale = max(float(np.linalg.norm(residual)), 1e-300)
    if floor is None:
        floor = (
            0.0
            if linear
            else 1e-15
            * float(np.linalg.norm(abs(matrix) @ np.maximum(1.0, np.abs(state))))
        )
    history = [1.0]
    solver = None
    goal = 1e-2 * tolerance
    for _ in range(options.iterations):
        try:
            solver, step = _direction(
                solver, constrain(matrix, fixed), -residual, policy, history, goal
            )
        except ConvergenceError:
            if not history[-1] * scale <= floor or not np.isfinite(far_step):
                raise
            return state, history  # the residual is rounding, which no factors reduce
        if linear:
            return state + step, history
        damping = 1.0
        nearest = state - MAX_SHARE_TO_BOUND * (state - options.lower)
        while True:
            trial = np.maximum(state + damping * step, nearest)
            # a step too far may leave the range of a property; it is halved below
            with np.errstate(all="ignore"):
                residual, _ = assemble(trial, False)
                residual[fixed] = 0.0
                norm = float(np.linalg.norm(residual))
            if np.isfinite(norm) and (
                norm <= (1 - 0.1 * damping) * history[-1] * scale or norm <= floor
            ):
                break
            damping /= 2
            if damping < 1e-3 and (
                history[-1] <= tolerance
                or (np.isfinite(far_step) and history[-1] * scale <= floor)
            ):
                return state, history  # as low as rounding lets it
            if damping < 1e-3:
                message = f"{what}: no descent after {len(history)} iterations"
                raise ConvergenceError(message, [*history, norm / scale], state)
        state = trial
        history.append(norm / scale)
        largest = max(1e-300, np.abs(weights * state).max())
        length = float(np.abs(weights * step).max()) / largest
        small = damping == 1.0 and length <= tolerance
        rounded = norm <= floor and length <= far_step
        if norm <= goal * scale or rounded or small:
            return state if options.rough else _polish(
                assemble, state, residual, fixed, solver
            ), history
        _, matrix = assemble(state, True)
    if norm <= floor and np.isfinite(far_step):
        return state, history
    message = (
        f"{what}: not converged in {options.iterations} iterations, residual "
        f"{history[-1]:.2g}"
    )
    raise ConvergenceError(message, history, state)


def _polish(
    assemble: Assemble, state: Any, residual: Any, fixed: Any, solver: Solver
) -> Any:
    """Improve the state with the factors at hand as long as each step lowers the
    residual fivefold.
    """
    norm = np.linalg.norm(residual)
    for _ in range(MAX_POLISHING_STEPS):
        better = state + solver.approximate(-residual)
        # a step too far may leave the range of a property; the state stays then
        with np.errstate(all="ignore"):
            residual, _ = assemble(better, False)
            residual[fixed] = 0.0
            after = np.linalg.norm(residual)
        if not after < 0.2 * norm:
            return better if after < norm else state
        state, norm = better, after
    return state


def _direction(
    solver: Solver | None,
    matrix: Any,
    rhs: Any,
    policy: Policy,
    history: list[float],
    goal: float,
) -> tuple[Solver, Any]:
    """Return the Newton step; factors of an earlier matrix are kept as long as GMRES
    needs few iterations with them.

    The linear tolerance is the square of the last reduction, so that convergence stays
    superlinear, but not below what reaches `goal` (Eisenstat & Walker 1996,
    doi:10.1137/0917003, choice 2; Kelley 1995, Eq. 6.20).
    """
    if solver is not None:
        forcing = max(
            (history[-1] / history[-2]) ** 2, 0.5 * goal / max(history[-1], 1e-300)
        )
        step = solver.solve_other(matrix, rhs, min(0.1, forcing))
        if step is not None:
            return solver, step
    solver = Solver(matrix, policy)
    return solver, solver(rhs)
