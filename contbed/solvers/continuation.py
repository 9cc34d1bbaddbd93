"""Steady states that Newton does not reach from a cold start: implicit Euler steps
of growing size, and the way from an easier problem.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from contbed.errors import ConvergenceError
from contbed.solvers.linear import Policy
from contbed.solvers.newton import Options, newton

GROWTH = 4.0
MAX_STEPS = 200
# on the way from an easier problem
FIRST_SHARE = 0.25
LEAST_SHARE = 2.0**-8
LONGER = 1.5


class Problem(Protocol):
    """The functions and data that a model with a content and a residual provides."""

    fixed: Any
    linear: bool
    weights: Any

    def content(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Return the tested heat content m(U) and, if wanted, its Jacobian."""

    def steady(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Return the tested steady residual R(U) and, if wanted, its Jacobian."""


def unwatched(share: float, note: str) -> None:
    """Take no notice of how far a march is."""


@dataclass(frozen=True)
class PseudoSteps:
    """Steps of a march to a steady state.

    They grow from `first` to `last` [s] by the factor `growth`. A step that needs more
    than `iterations` of Newton's method is shortened; after `patience` steps of which
    none is the longest so far the march is given up.
    """

    first: float = 1e-3
    last: float = 1e12
    growth: float = GROWTH
    patience: int = MAX_STEPS
    iterations: int = 30


def relax(
    problem: Problem,
    state: Any,
    policy: Policy,
    lower: Any = 0.0,
    steps: PseudoSteps = PseudoSteps(),
    tolerance: float = 1e-6,
    watch: Callable[[float, str], None] = unwatched,
) -> Any:
    """March from `state` to a steady state with steps that grow.

    A step that fails is shortened. Unknowns stay above `lower`. `watch` is called with
    the share of the way to the last step, by powers of ten, and the step.

    Raises
    ------
    ConvergenceError
        Where steps no longer grow; it carries the last state.

    """
    dt, longest, stale = steps.first, 0.0, 0
    history: list[float] = []
    options = Options(
        tolerance,
        steps.iterations,
        lower,
        what="continuation",
        rough=True,  # the state is only where the next step starts
    )
    for _ in range(MAX_STEPS):
        before = problem.content(state, False)[0]

        def assemble(
            x: Any, jacobian: bool, before: Any = before, dt: float = dt
        ) -> tuple[Any, Any]:
            content, mass = problem.content(x, jacobian)
            steady, stiffness = problem.steady(x, jacobian)
            return (
                content - before
            ) / dt + steady, mass / dt + stiffness if jacobian else None

        stale += 1
        if stale > steps.patience:
            break
        try:
            # a step too far may overflow; it is shortened below
            with np.errstate(over="ignore", invalid="ignore"):
                state, history = newton(assemble, state, problem.fixed, policy, options)
        except ConvergenceError as error:
            history = error.history
            dt /= steps.growth**2
            continue
        if dt > longest:
            longest, stale = dt, 0
        if dt >= steps.last:
            return state
        share = np.log(max(dt / steps.first, 1.0)) / np.log(steps.last / steps.first)
        watch(share, f"step {dt:.2g} s")
        dt *= steps.growth
    message = (
        "no steady state by steps in time; the longest step that converged is "
        f"{longest:.3g} s"
    )
    raise ConvergenceError(message, history, state)


def from_easier(solve: Callable[[float, Any], Any], start: Any) -> Any:
    """Return the state of a problem, followed from that of an easier one.

    Parameters
    ----------
    solve : finds a state from a nearby one, for the share of the way that is left: 1 is
        the easier problem, 0 the one that is meant
    start : state where the easier problem begins

    Raises
    ------
    ConvergenceError : a state is not found, however short the step
    """
    state, left, step = solve(1.0, start), 1.0, FIRST_SHARE
    while left > 0.0:
        wanted = max(left - step, 0.0)
        try:
            state = solve(wanted, state)
        except ConvergenceError:
            step = 0.5 * (left - wanted)
            if step < LEAST_SHARE:
                raise
            continue
        left, step = wanted, LONGER * step
    return state
