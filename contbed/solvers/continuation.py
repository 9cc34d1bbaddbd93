"""Steady states that Newton does not reach from a cold start: implicit Euler steps
of growing size.
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
