"""Steady states that Newton does not reach from a cold start: implicit Euler steps of growing size."""

from __future__ import annotations

from typing import Any

from contbed.errors import ConvergenceError
from contbed.solvers.linear import Policy
from contbed.solvers.newton import newton
from contbed.solvers.timestep import Problem

GROWTH = 4.0
STEPS = 200


def relax(
    problem: Problem,
    state: Any,
    policy: Policy,
    lower: Any = 0.0,
    first: float = 1e-3,
    last: float = 1e12,
    growth: float = GROWTH,
    tolerance: float = 1e-6,
) -> Any:
    """March from `state` to a steady state with steps that grow from `first` to `last` [s].

    A step that fails is shortened. Unknowns stay above `lower`.
    """
    dt = first
    history: list[float] = []
    for _ in range(STEPS):
        before = problem.content(state, False)[0]

        def assemble(x: Any, jacobian: bool, before: Any = before, dt: float = dt) -> tuple[Any, Any]:
            content, mass = problem.content(x, jacobian)
            steady, stiffness = problem.steady(x, jacobian)
            return (content - before) / dt + steady, mass / dt + stiffness if jacobian else None

        try:
            state, history = newton(
                assemble, state, problem.fixed, policy, tolerance=tolerance, lower=lower, what="continuation"
            )
        except ConvergenceError:
            dt /= growth**2
            if dt < 1e-6 * first:
                raise
            continue
        if dt >= last:
            return state
        dt *= growth
    raise ConvergenceError(f"continuation: no steady state after {STEPS} steps, step {dt:.3g} s", history, state)
