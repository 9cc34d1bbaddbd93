"""Response of a discrete solution to a small change, from residuals on both sides of
it.

    R(u, p) = 0,   A = dR/du:      du = -A^-1 (R(u, p + h) - R(u, p - h))/2

The two states u +- du differ by the central difference of the solution, whose error is
O(h^2), as the second-order terms of both sides are alike. The residuals R(u, p +- h) +-
A du belong to these states, to the same order.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from contbed.arrays import Array, Integers
from contbed.solvers.linear import Policy, Solver, constrain
from contbed.solvers.newton import Assemble

# relative, of a key: leaves a truncation of some 1e-10, and 1e-8 of rounding at most
STEP = 1e-5
REFINED = 1e-11  # share of the right-hand side that one solution may leave

Pair = tuple[Array, Array]


class Response:
    """The Jacobian of a solution and its factors; `fixed` are the unknowns that are
    prescribed.
    """

    def __init__(self, matrix: Any, fixed: Integers, policy: Policy):
        self.matrix, self.fixed = matrix, fixed
        self.solver = Solver(constrain(matrix, fixed) if len(fixed) else matrix, policy)

    def states(
        self, starts: Sequence[Array], assemble: Sequence[Assemble]
    ) -> tuple[Pair, Pair]:
        """Return the states below and above, and their residuals.

        Parameters
        ----------
        starts : the solution with the prescribed unknowns of either side in place
        assemble : the equations with the values of either side
        """
        residuals = [
            side(x, False)[0] for side, x in zip(assemble, starts, strict=True)
        ]
        change = 0.5 * (residuals[1] - residuals[0])
        free = change.copy()
        free[self.fixed] = 0.0
        step = -self.solver.approximate(free)
        lift = self.matrix @ step
        rest = free + lift
        rest[self.fixed] = 0.0
        if np.linalg.norm(rest) > REFINED * np.linalg.norm(free):
            step = -self.solver(free)
            lift = self.matrix @ step
        return (starts[0] - step, starts[1] + step), (
            residuals[0] - lift,
            residuals[1] + lift,
        )


class Tangent:
    """A solved steady state `x` of a problem and the factors of its Jacobian."""

    step = STEP
    method = "tangent"
    problem: Any
    x: Array

    @cached_property
    def response(self) -> Response:
        """The factors, found when they are first needed."""
        problem = self.problem
        matrix = problem.steady(self.x, True)[1]
        return Response(matrix, problem.fixed, problem.plan.policy)


def with_prescribed(state: Array, fixed: Integers, values: Array) -> Array:
    """Return a state with prescribed unknowns in place."""
    state = state.copy()
    state[fixed] = values
    return state
