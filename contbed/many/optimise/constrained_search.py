"""The smallest value of a function with constraints, by gradients.

    minimise f(x)   with   g(x) <= 0,  h(x) = 0,  low <= x <= high

Sequential quadratic programming, scipy's SLSQP, on variables scaled to 0 ... 1 between
the bounds and functions whose first gradient has the size 1. Where a value cannot be
computed, the search steps back: it begins again at the last point with a gradient,
within half the distance to the one that failed.

First-order conditions (Karush 1939; Kuhn and Tucker 1951), at a point with the active
constraints and bounds A,

    grad f + sum_A lambda grad g = 0,  lambda >= 0  (any sign for h)

are measured by the least residual over all such lambda, in the scaled variables,
relative to the gradient of f; where no constraint or bound holds f back, so that its
gradient vanishes, to that at the start if it is larger. The lambda are the prices of
the constraints: one unit more on the right side of g <= 0 lowers f by lambda.

Source: Kraft 1988, A software package for sequential quadratic programming, DFVLR-FB
    88-28; Nocedal and Wright 2006,
Numerical Optimization, doi:10.1007/978-0-387-40065-5, chapters 12 and 18.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from contbed.arrays import Array, Flags

# residual of the first-order conditions, of the gradient of f, below which they hold
FIRST_ORDER = 1e-3
# change of f over the bounds by its first gradient, of f, which is not scaled up
# further
FLAT = 1e-4
# excess of a constraint, of its change over the bounds, up to which it holds
FEASIBLE = 1e-6
# slack of a constraint, of its change over the bounds, up to which it is active
ACTIVE = 1e-4
# distance from a bound, of the distance of the bounds, up to which a variable lies on
# it
AT_BOUND = 1e-6
DECREASE = 1e-8  # change of the scaled f at which a search ends
ITERATIONS = 100  # of one search
SEARCHES = 12  # begun again after a step back, or because the conditions did not hold
DIGITS = 9  # of a scaled variable; steps smaller than these are no other point
# of the bounds, the distance from a failed point below which there is no stepping back
SMALLEST = 1e-4


class EvaluationFailed(Exception):
    """A value or gradient at a point could not be computed; the message says why."""


class Functions(Protocol):
    """What is minimised: row 0 is f, the others are the constraints."""

    low: Array
    high: Array
    equality: Flags  # of each constraint

    def values(self, x: Array) -> Array:
        """Return f and the constraints, (1 + m,); raises EvaluationFailed."""

    def derivatives(self, x: Array) -> Array:
        """Return their derivatives, (1 + m, n); raises EvaluationFailed."""


@dataclass(frozen=True)
class Optimum:
    """Where a search ended.

    x : variables (n,)
    values, derivatives : of f and the constraints there, (1 + m,) and (1 + m, n)
    prices : what one unit of each constraint costs, (m,) in f per unit of the
        constraint; 0 where it is not active
    bound_prices : the same of the bounds, (n,) in f per unit of x; > 0 at the
        lower, < 0 at the upper one
    active : constraints that hold without slack, (m,)
    residual : of the first-order conditions
    excess : largest excess of a constraint, of its change over the bounds
    remarks : steps back
    """

    x: Array
    values: Array
    derivatives: Array
    prices: Array
    bound_prices: Array
    active: Flags
    residual: float
    excess: float
    remarks: tuple[str, ...] = ()

    @property
    def feasible(self) -> bool:
        """Whether all constraints hold."""
        return self.excess <= FEASIBLE

    @property
    def converged(self) -> bool:
        """Whether the constraints and the first-order conditions hold."""
        return self.feasible and self.residual <= FIRST_ORDER

    def beats(self, other: Optimum) -> bool:
        """Return whether this point is to be preferred: that which keeps the
        constraints, then that with the lower value.
        """
        if self.feasible and other.feasible:
            return bool(self.values[0] < other.values[0])
        return self.excess < other.excess


@dataclass
class _Scaled:
    """The functions in scaled variables, each point computed once."""

    functions: Functions
    start: Array
    size: Array
    known: dict[bytes, Array] = field(default_factory=dict)
    slopes: dict[bytes, Array] = field(default_factory=dict)
    failures: dict[bytes, str] = field(default_factory=dict)
    last: Array | None = None
    failed: Array | None = None
    reason: str = ""

    def x(self, z: Array) -> Array:
        """Return the variables at scaled ones."""
        low, high = self.functions.low, self.functions.high
        first = (self.start - low) / (high - low)
        inside = np.clip(
            self.start + np.round(z - first, DIGITS) * (high - low), low, high
        )
        return np.where(z <= 0.0, low, np.where(z >= 1.0, high, inside))

    def values(self, z: Array) -> Array:
        """Return scaled values."""
        return self._once(self.known, z, self.functions.values) / self.size

    def derivatives(self, z: Array) -> Array:
        """Return scaled derivatives."""
        span = self.functions.high - self.functions.low
        found = self._once(self.slopes, z, self.functions.derivatives)
        self.last = np.clip(z, 0.0, 1.0)
        return found * span / self.size[:, None]

    def _once(
        self, known: dict[bytes, Array], z: Array, function: Callable[[Array], Array]
    ) -> Array:
        x = self.x(z)
        mark = x.tobytes()
        if mark not in known and mark not in self.failures:
            try:
                known[mark] = function(x)
            except EvaluationFailed as error:
                self.failures[mark] = str(error)
        if mark in self.failures:
            self.failed, self.reason = np.clip(z, 0.0, 1.0), self.failures[mark]
            raise EvaluationFailed(self.reason)
        return known[mark]


def minimise(functions: Functions, start: Array) -> Optimum:
    """Return where f is smallest, as far as a search from `start` (n,) finds it.

    Raises
    ------
    EvaluationFailed : at the start
    """
    span = functions.high - functions.low
    first = functions.values(start), functions.derivatives(start)
    scaled = _Scaled(functions, start, _sizes(*first, span))
    z = np.clip((start - functions.low) / span, 0.0, 1.0)
    scaled.derivatives(z)
    reach = 1.0  # how far a search may go from where it begins, of the bounds
    best = optimum_at(scaled, z)
    remarks: list[str] = []
    for _ in range(SEARCHES):
        centre = z
        try:
            z = _search(scaled, z, reach)
            found = optimum_at(scaled, z)
        except EvaluationFailed:
            z, reach = _step_back(scaled, remarks)
            if reach < SMALLEST:
                break
            continue
        if not found.feasible and not best.feasible and not found.excess < best.excess:
            break
        both = found.feasible and best.feasible
        better = found.beats(best) or (both and found.converged > best.converged)
        best = found if better else best
        at_edge = reach < 1.0 and np.abs(z - centre).max() >= reach * (1.0 - AT_BOUND)
        if best.converged and not at_edge:
            break
        if at_edge:
            reach = min(2.0 * reach, 1.0)
        elif not better:
            break
    return Optimum(**{**vars(best), "remarks": tuple(remarks)})


def _sizes(values: Array, derivatives: Array, span: Array) -> Array:
    """Return the change of each function over the bounds by its first gradient, or its
    value where that is 0.

    That of f is no smaller than a share of f: a search that begins where f is smallest
    has a gradient of rounding.
    """
    change = np.abs(derivatives * span).max(axis=1)
    change[0] = max(change[0], FLAT * abs(values[0]))
    return np.where(change > 0.0, change, np.where(values != 0.0, np.abs(values), 1.0))


def _step_back(scaled: _Scaled, remarks: list[str]) -> tuple[Array, float]:
    """Return the last point with a gradient, and half the distance to the point that
    failed.
    """
    assert scaled.last is not None and scaled.failed is not None
    reach = 0.5 * float(np.abs(scaled.failed - scaled.last).max())
    remarks.append(
        f"stepped back to {100.0 * reach:.3g} % of the bounds from the last gradient: "
        f"{scaled.reason}"
    )
    return scaled.last, reach


def _search(scaled: _Scaled, z: Array, reach: float) -> Array:
    """Return where one search from a point ends; where constraints are missed, where
    they are missed least.
    """
    box = np.column_stack([np.maximum(z - reach, 0.0), np.minimum(z + reach, 1.0)])
    equality = scaled.functions.equality

    def part(kind: str, rows: Any) -> dict[str, Any]:
        return {
            "type": kind,
            "fun": lambda at: -scaled.values(at)[1:][rows],
            "jac": lambda at: -scaled.derivatives(at)[1:][rows],
        }

    parts = [
        part(kind, rows)
        for kind, rows in (("ineq", ~equality), ("eq", equality))
        if rows.any()
    ]
    end: Array = np.clip(
        _slsqp(
            lambda at: scaled.values(at)[0],
            z,
            jac=lambda at: scaled.derivatives(at)[0],
            bounds=box,
            constraints=parts,
        ),
        *box.T,
    )
    if _excess(scaled, end) > FEASIBLE:
        nearest = _nearest_feasible(scaled, end, box)
        if _excess(scaled, nearest) < _excess(scaled, end):
            return nearest
    return end


def _nearest_feasible(scaled: _Scaled, z: Array, box: Array) -> Array:
    """Return where the largest excess is smallest: minimise t with g <= t and
    |h| <= t.
    """
    equality = scaled.functions.equality

    def rows(of: Array) -> Array:
        return np.concatenate([of[1:], -of[1:][equality]])

    def slopes(at: Array) -> Array:
        found = rows(scaled.derivatives(at[:-1]))
        return np.column_stack([-found, np.ones(len(found))])

    t = _excess(scaled, z)
    found = _slsqp(
        lambda at: at[-1],
        np.append(z, t),
        jac=lambda at: np.append(np.zeros(len(z)), 1.0),
        bounds=[*map(tuple, box), (0.0, None)],
        constraints={
            "type": "ineq",
            "fun": lambda at: at[-1] - rows(scaled.values(at[:-1])),
            "jac": slopes,
        },
    )
    nearest: Array = np.clip(found[:-1], *box.T)
    return nearest


def _slsqp(function: Callable[[Array], Any], start: Array, **problem: Any) -> Array:
    """Return where a search of scipy ends."""
    from scipy.optimize import minimize

    options = {"ftol": DECREASE, "maxiter": ITERATIONS}
    with np.errstate(all="ignore"):
        found = minimize(function, start, method="SLSQP", options=options, **problem)
    end: Array = found.x
    return end


def _excess(scaled: _Scaled, z: Array) -> float:
    g = scaled.values(z)[1:]
    return float(np.where(scaled.functions.equality, np.abs(g), g).max(initial=0.0))


def optimum_at(scaled: _Scaled, z: Array) -> Optimum:
    """Return values, prices and the residual of the first-order conditions at a
    point.
    """
    from scipy.optimize import nnls

    functions = scaled.functions
    values, slopes = scaled.values(z), scaled.derivatives(z)
    equality = functions.equality
    active = np.where(equality, True, values[1:] >= -ACTIVE)
    low, high = z <= AT_BOUND, z >= 1.0 - AT_BOUND
    unit = np.eye(len(z))
    columns = np.vstack(
        [slopes[1:][active], -slopes[1:][equality], -unit[low], unit[high]]
    ).T
    length = np.linalg.norm(slopes[0]) or 1.0
    if columns.size:
        norms = np.linalg.norm(columns, axis=0)
        norms[norms == 0.0] = 1.0
        weights, distance = nnls(columns / norms, -slopes[0])
        weights = weights / norms
    else:
        weights, distance = np.zeros(0), length
    m, prices = int(active.sum()), np.zeros(len(active))
    prices[active] = weights[:m]
    ends = m + int(equality.sum())
    prices[equality] -= weights[m:ends]
    bounds = np.zeros(len(z))
    bounds[low] += weights[ends : ends + int(low.sum())]
    bounds[high] -= weights[ends + int(low.sum()) :]
    span, size = functions.high - functions.low, scaled.size
    if not weights.any():
        length = max(length, 1.0)
    x = scaled.x(z)
    return Optimum(
        x=x,
        values=scaled.known[x.tobytes()],
        derivatives=scaled.slopes[x.tobytes()],
        prices=prices * size[0] / size[1:],
        bound_prices=bounds * size[0] / span,
        active=active,
        residual=float(distance / length) if slopes[0].any() else 0.0,
        excess=_excess(scaled, z),
    )
