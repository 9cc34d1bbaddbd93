"""Branches of steady states R(x, p) = 0 over a parameter p, through their folds, by
pseudo-arclength (Keller 1977).

    R(x, p) = 0,   t_x . (x - x_0) / N^2 + t_p (p - p_0) / P^2 = s

(x_0, p_0) is the last point, t its unit tangent, s the step; N^2 = n X^2 measures all n
unknowns as one of size X, P is the span of p. The bordered matrix is regular at folds,
where t_p changes sign; each fold is then located by steps of other lengths from the
point before it. Steps grow and shrink with the number of Newton iterations.

Source: Keller 1977, in Rabinowitz (ed.), Applications of Bifurcation Theory, Academic
    Press, 359-384.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from contbed.errors import ConvergenceError
from contbed.solvers.continuation import unwatched
from contbed.solvers.linear import Policy, Solver, bordered

Array = Any
Assemble = Callable[[Array, float, bool], tuple[Array, Any]]

DIFFERENCE = 1e-4  # share of the span by which R is differentiated along the parameter
MAX_ITERATIONS = 8  # of Newton's method in one step
MIN_STEP = 1e-7  # step below which the branch is given up
# step, of a distance in which the whole span of the parameter counts as one
MAX_STEP = 0.1
FIRST_STEP = 0.02
FOLD_TOLERANCE = 1e-9  # distance along the branch within which a fold is found
# distance to the next point over the step; a point further aside is on another branch
MAX_DISTANCE = 2.0


@dataclass
class Branch:
    """Points of a branch in the order in which they are found.

    `folds` holds (index of the point behind the fold, parameter, state). `complete`
    says whether the branch reaches an end of the range of the parameter, or the first
    fold if no more is wanted.
    """

    parameter: list[float] = field(default_factory=list)
    states: list[Array] = field(default_factory=list)
    folds: list[tuple[int, float, Array]] = field(default_factory=list)
    complete: bool = False

    def points(self) -> list[tuple[float, Array, int]]:
        """Return the parameter, the state and the number of folds passed of each
        point, folds included.
        """
        points = list(zip(self.parameter, self.states, strict=True))
        turns = [index + k for k, (index, _, _) in enumerate(self.folds)]
        for place, (_, p, x) in zip(turns, self.folds, strict=True):
            points.insert(place, (p, x))
        return [
            (p, x, sum(turn < k for turn in turns)) for k, (p, x) in enumerate(points)
        ]

    def columns(
        self, header: str, row: Callable[[float, Array], dict[str, float]]
    ) -> dict[str, Array]:
        """Return the number, the parameter, the folds passed and the values of `row`
        of each point, by header.
        """
        rows = [
            {"point [1]": float(k), header: p, "turns [1]": float(turns)} | row(p, x)
            for k, (p, x, turns) in enumerate(self.points())
        ]
        return {name: np.array([each[name] for each in rows]) for name in rows[0]}

    def report(self, parameter: str, result: Any) -> None:
        """Add the folds to a result, and a warning where the branch does not reach the
        other end of the range.
        """
        if not self.complete:
            result.warnings.append(
                f"the branch ends at {parameter} = {self.parameter[-1]:.6g} after "
                f"{len(self.parameter)} points; raise continuation.points"
            )
        elif len(self.parameter) > 1 and self.parameter[-1] == self.parameter[0]:
            result.warnings.append(
                "the branch turns back and leaves the range where it began, at "
                f"{parameter} = {self.parameter[0]:.6g}; states that need values beyond "
                "are not found: begin farther outside"
            )
        result.qoi |= {f"fold_{k}": p for k, (_, p, _) in enumerate(self.folds, 1)}


@dataclass
class _Point:
    x: Array
    p: float
    tangent: tuple[Array, float]


class _Continuation:
    """Pseudo-arclength steps from one point of a branch to the next."""

    def __init__(
        self,
        assemble: Assemble,
        weights: Array,
        size: float,
        span: float,
        policy: Policy,
        tolerance: float,
    ):
        self.assemble, self.policy, self.tolerance = assemble, policy, tolerance
        self.metric = weights**2 / (len(weights) * size**2)
        self.weights, self.size, self.span = weights, size, span

    def slope(self, x: Array, p: float, residual: Array) -> Array:
        """Return dR/dp by a one-sided difference."""
        step = DIFFERENCE * self.span
        return (self.assemble(x, p + step, False)[0] - residual) / step

    def bordered(
        self, x: Array, p: float, row: tuple[Array, float]
    ) -> tuple[Array, Callable[[Array, float], Any]]:
        """Return the residual and a solver of the bordered system; its last row and
        column are scaled alike.
        """
        residual, matrix = self.assemble(x, p, True)
        column = self.span * self.slope(x, p, residual)
        weight = float((abs(matrix) @ np.ones(len(x))).max())
        last, corner = weight * self.metric * row[0], weight * row[1] / self.span
        solver = Solver(bordered(matrix, column, last, corner), self.policy)

        def solve(rhs: Array, last: float) -> tuple[Array, float]:
            found = solver(np.append(rhs, weight * last))
            return found[:-1], self.span * float(found[-1])

        return residual, solve

    def tangent(
        self, x: Array, p: float, before: tuple[Array, float]
    ) -> tuple[Array, float]:
        """Return the unit tangent that continues in the direction of the last one."""
        _, solve = self.bordered(x, p, before)
        tx, tp = solve(np.zeros(len(x)), 1.0)
        length = self.distance(tx, tp)
        return tx / length, tp / length

    def distance(self, x: Array, p: float) -> float:
        """Return the length of a way along the branch."""
        return float((self.metric @ x**2 + (p / self.span) ** 2) ** 0.5)

    def step(self, at: _Point, s: float) -> tuple[_Point, int]:
        """Return the point of the branch at distance `s` (backward if negative) and
        the number of iterations.
        """
        tx, tp = at.tangent
        x, p = at.x + s * tx, at.p + s * tp
        for iteration in range(1, MAX_ITERATIONS + 1):
            with np.errstate(all="ignore"):
                residual, solve = self.bordered(x, p, at.tangent)
                ahead = float(
                    self.metric @ (tx * (x - at.x)) + tp * (p - at.p) / self.span**2
                )
                if not np.isfinite(residual).all():
                    break
                change, shift = solve(-residual, s - ahead)
            x, p = x + change, p + shift
            if np.abs(self.weights * change).max() <= self.tolerance * self.size:
                if self.distance(x - at.x, p - at.p) > MAX_DISTANCE * abs(s):
                    break
                return _Point(x, p, self.tangent(x, p, at.tangent)), iteration
        raise ConvergenceError(f"branch: a step of {s:.2g} does not converge", [], x)

    def where(
        self,
        value: Callable[[_Point], float],
        a: _Point,
        length: float,
        after: float = 0.0,
    ) -> tuple[float, _Point]:
        """Return distance and point between those `after` and `length` beyond `a` where
        a value that changes its sign is 0.
        """

        def at(s: float) -> float:
            return value(self.step(a, s)[0] if s > 0.0 else a)

        s = float(brentq(at, after, length, xtol=FOLD_TOLERANCE))
        return s, self.step(a, s)[0]


@dataclass(frozen=True)
class Way:
    """How far a branch is followed by its parameter.

    It begins at `start` and ends where the parameter passes `stop` or returns to
    `start`, or where `points` are found; with `first_fold` at the first fold as well.
    """

    start: float
    stop: float
    points: int
    first_fold: bool = False


def trace(
    assemble: Assemble,
    x: Array,
    way: Way,
    policy: Policy,
    *,
    weights: Array,
    size: float,
    tolerance: float = 1e-8,
    watch: Callable[[float, str], None] = unwatched,
) -> Branch:
    """Follow the branch of `assemble(x, p, jacobian) -> (R, matrix)` from a state `x`.

    `weights` make the unknowns comparable with `size`. A branch that cannot be
    continued is returned incomplete.
    `watch` is called with the share of the way, by the parameter or by the number of
    points, and the parameter.
    """
    start, stop, points = way.start, way.stop, way.points
    continuation = _Continuation(
        assemble, weights, size, abs(stop - start), policy, tolerance
    )
    out = Branch([start], [x])
    toward = (np.zeros_like(x), float(np.sign(stop - start)))
    point, s = _Point(x, start, continuation.tangent(x, start, toward)), FIRST_STEP
    low, high = min(start, stop), max(start, stop)
    while len(out.parameter) < points and s > MIN_STEP:
        try:
            found, iterations = continuation.step(point, s)
        except ConvergenceError:
            s *= 0.25
            continue
        turned = 0.0
        if found.tangent[1] * point.tangent[1] < 0:
            turned, turn = continuation.where(_rise, point, s)
            out.folds.append((len(out.parameter), turn.p, turn.x))
            if way.first_fold:
                out.complete = True
                break
        if not low <= found.p <= high:
            edge = low if found.p < low else high
            # a branch that turns in its first step begins on the edge that it returns to
            after = turned if point.p == edge else 0.0
            _, last = continuation.where(partial(_beyond, edge), point, s, after)
            found = replace(last, p=edge)
            out.complete = True
        out.parameter.append(found.p)
        out.states.append(found.x)
        if out.complete:
            break
        share = max(
            abs(found.p - start) / abs(stop - start), len(out.parameter) / points
        )
        watch(min(share, 1.0), f"{found.p:.4g}")
        point, s = (
            found,
            min(
                MAX_STEP,
                s * (2.0 if iterations <= 3 else 1.0 if iterations <= 5 else 0.5),
            ),
        )
    return out


def _rise(at: _Point) -> float:
    """Return the parameter's part of the tangent, which is 0 at a fold."""
    return at.tangent[1]


def _beyond(edge: float, at: _Point) -> float:
    """Return how far the parameter is beyond an edge of its range."""
    return at.p - edge
