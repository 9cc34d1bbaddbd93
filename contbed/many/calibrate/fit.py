"""Least squares with priors: the most probable keys, their covariance, and how far the
stated errors hold.

With measured values y, their standard errors s, predictions p(z) and keys z scaled by
their priors, the fit minimises

    sum ((p - y)/s)^2 + sum z^2,

the second sum over keys with a normal prior; even priors are bounds (Tarantola 2005,
Inverse Problem Theory, doi:10.1137/1.9780898717921). The covariance is the inverse of
the matrix of second derivatives without those of p.

Where residuals are larger than the stated errors allow (chi-square test), all errors
are multiplied by the root of chi-square per degree of freedom (Birge 1932,
doi:10.1103/PhysRev.40.207). Where neighbours deviate to the same side, n values carry
less information than n independent ones: with the correlation r of neighbours, as much
as n (1 - r)/(1 + r) (Bayley & Hammersley 1946, doi:10.2307/2983560). Both enter the
covariance of the keys; a new measurement scatters with the first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contbed.arrays import Array, Flags, Integers
from contbed.errors import ConvergenceError
from contbed.many.calibrate.model import Model
from contbed.many.distributions import Distribution

COVERAGE = 0.90  # share of intervals and bands that hold the true value
# probability below which chance explains residuals as large, or as alike, as they are
SIGNIFICANT = 0.95
# Distance of both sides of a difference, in standard deviations of the prior: the
# curvature of a prediction changes a slope by its square, and what time steps leave
# undetermined is divided by it
DIFFERENCE = 0.02
MOST_EVALUATIONS = 60
# of the keys, in standard deviations of their priors, and of the sum of squares
TOLERANCE = 1e-6
# further points of the priors that are tried if there is no solution in their middle
TRIALS = 8
SETTLED = 0.1  # standard errors that one more step may still change the keys by
# correlation of neighbours above which a table resolves nothing but the same deviation
MOST_ALIKE = 0.95


@dataclass(frozen=True)
class Data:
    """The measured values that are fitted.

    index : their places among the predictions, shape (data,); value, error : in SI,
        shape (data,)
    groups : number of the profile or series of each, shape (data,), in which the values
        follow each other
    """

    index: Integers
    value: Array
    error: Array
    groups: Integers


@dataclass(frozen=True)
class Problem:
    """What is fitted: a model to measured values, with the priors of its keys."""

    model: Model
    data: Data
    priors: Sequence[Distribution]

    @property
    def ends(self) -> Array:
        """The lowest and the highest scaled coordinate of each key, (2, keys)."""
        return np.array([prior.bounds for prior in self.priors]).T

    @property
    def normal(self) -> Flags:
        """Which keys have a normal prior, (keys,)."""
        return np.array([not prior.even for prior in self.priors])

    def residuals(self, predicted: Array, factor: float = 1.0) -> Array:
        """Return the deviations of predictions, (..., points), over the errors,
        (..., data); the stated errors are multiplied by a factor.
        """
        data = self.data
        return np.asarray(
            (predicted[..., data.index] - data.value) / (factor * data.error)
        )

    def scaled(self, slopes: Array, factor: float = 1.0) -> Array:
        """Return the derivatives of predictions, (points, keys), over the errors,
        (data, keys).
        """
        error = factor * self.data.error
        return np.asarray(slopes[self.data.index] / error[:, None])

    def covariance(self, slopes: Array, factor: float = 1.0) -> Array:
        """Return the covariance of the scaled keys, (keys, keys), by the derivatives of
        predictions; no combination is less certain than by its prior, 1.
        """
        scaled = self.scaled(slopes, factor)
        matrix = scaled.T @ scaled + np.diag(self.normal.astype(float))
        values, vectors = np.linalg.eigh(matrix)
        return np.asarray((vectors / np.maximum(values, 1.0)) @ vectors.T)


@dataclass(frozen=True)
class Fit:
    """The fitted keys.

    z : scaled keys, shape (keys,); covariance : of z, shape (keys, keys)
    predicted : shape (points,); slopes : derivatives of the predictions, shape (points,
        keys)
    chi_square, freedom : of the residuals over the stated errors, and degrees of
        freedom
    scatter : factor of the stated errors that the residuals ask for, at least 1
    alike : correlation of neighbouring residuals, 0 where it may be chance
    """

    z: Array
    covariance: Array
    predicted: Array
    slopes: Array
    chi_square: float
    freedom: float
    scatter: float
    alike: float
    converged: bool

    @property
    def factor(self) -> float:
        """Factor of the stated errors with which the data count for the keys."""
        return self.scatter * math.sqrt((1.0 + self.alike) / (1.0 - self.alike))

    @property
    def correlation(self) -> Array:
        """Correlation of the keys, (keys, keys)."""
        spread = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(spread, spread))

    @property
    def quantile(self) -> float:
        """Standard errors on each side of an interval; of Student's t where the
        errors come from the residuals.
        """
        from scipy.stats import norm, t

        upper = 0.5 * (1.0 + COVERAGE)
        return float(
            t.ppf(upper, max(self.freedom, 1.0))
            if self.scatter > 1.0
            else norm.ppf(upper)
        )

    def bands(self, slopes: Array) -> Array:
        """Return the standard errors of predictions with these derivatives, shape
        (points,).
        """
        return np.asarray(
            np.sqrt(np.einsum("ij,jk,ik->i", slopes, self.covariance, slopes))
        )


def fit(problem: Problem) -> Fit:
    """Fit the keys, from the middle of their priors.

    Raises
    ------
    ConvergenceError : no run in the middle of the priors, nor at points spread in them,
        has a result
    """
    first = least_squares(problem, _start(problem), 1.0)
    residuals = problem.residuals(first.predicted)
    covariance = problem.covariance(first.slopes)
    scaled = problem.scaled(first.slopes)
    used = float(np.trace(covariance @ (scaled.T @ scaled)))
    freedom = max(len(residuals) - used, 0.0)
    found = Fit(
        z=first.z,
        covariance=covariance,
        predicted=first.predicted,
        slopes=first.slopes,
        chi_square=float(residuals @ residuals),
        freedom=freedom,
        scatter=_scatter(residuals, freedom),
        alike=_alike(residuals, problem.data.groups),
        converged=first.converged,
    )
    if found.factor == 1.0:
        return found
    again = least_squares(problem, first.z, found.factor)
    return replace(
        found,
        z=again.z,
        covariance=problem.covariance(again.slopes, found.factor),
        predicted=again.predicted,
        slopes=again.slopes,
        converged=again.converged,
    )


@dataclass(frozen=True)
class Solution:
    """The end of a search: scaled keys, predictions there, their derivatives, and
    half of the sum of squares.
    """

    z: Array
    predicted: Array
    slopes: Array
    cost: float
    converged: bool


def least_squares(
    problem: Problem, z: Array, factor: float, held: Sequence[int] = ()
) -> Solution:
    """Minimise the sum of squares from `z` on.

    Parameters
    ----------
    factor : of the stated errors
    held : keys that stay as they are in `z`
    """
    from scipy.optimize import least_squares as search

    count = len(problem.priors)
    free = np.array([k for k in range(count) if k not in held], dtype=int)
    rows, (low, high) = problem.normal, problem.ends[:, free]
    start = np.array(z, dtype=float)
    known: dict[bytes, tuple[Array, Array]] = {}

    def whole(inner: Array) -> Array:
        full = start.copy()
        full[free] = inner
        return full

    def residuals(inner: Array) -> Array:
        full = whole(inner)
        predicted = problem.model.values(full[None])[0]
        return np.concatenate([problem.residuals(predicted, factor), full[rows]])

    def there(inner: Array) -> tuple[Array, Array]:
        mark = inner.tobytes()
        if mark not in known:
            known[mark] = derivatives(problem, whole(inner), free)
        return known[mark]

    def slopes(inner: Array) -> Array:
        scaled = problem.scaled(there(inner)[1], factor)
        return np.vstack([scaled, np.eye(count)[rows][:, free]])

    if not len(free):
        predicted = problem.model.values(start[None])[0]
        left = residuals(start[free])
        none = np.zeros((len(predicted), 0))
        return Solution(start, predicted, none, 0.5 * float(left @ left), True)
    found: Any = search(
        residuals,
        np.clip(start[free], low + TOLERANCE, high - TOLERANCE),
        slopes,
        bounds=(low, high),
        xtol=TOLERANCE,
        ftol=TOLERANCE,
        gtol=TOLERANCE,
        max_nfev=MOST_EVALUATIONS,
    )
    settled = _rest(found, low, high) < SETTLED
    converged = bool(found.success and settled)
    return Solution(whole(found.x), *there(found.x), float(found.cost), converged)


def _rest(found: Any, low: Array, high: Array) -> float:
    """Return by how many standard errors a further step would change the keys; steps
    end early where runs fail.
    """
    free = (found.x > low + SETTLED) & (found.x < high - SETTLED)
    slopes = found.jac[:, free]
    step = np.linalg.lstsq(slopes, -found.fun, rcond=None)[0]
    return float(np.linalg.norm(slopes @ step))


def derivatives(problem: Problem, z: Array, free: Integers) -> tuple[Array, Array]:
    """Return predictions, shape (points,), and their derivatives with respect to scaled
    keys, (points, keys).

    By tangents where the model has them, else by central differences of all keys at
    once; to one side at a bound of a prior, and where a run of the other failed.

    Raises
    ------
    ConvergenceError : runs on both sides of a key failed
    """
    model, priors = problem.model, problem.priors
    known = model.slopes(z)
    if known is not None:
        return model.values(z[None])[0], known[:, free]
    sides = []
    for k in free:
        for step in (-DIFFERENCE, DIFFERENCE):
            moved = z.copy()
            moved[k] = np.clip(z[k] + step, *priors[k].bounds)
            sides.append(moved)
    found = model.values(np.array([z, *sides]))
    here, there = found[0], found[1:]
    slopes = np.zeros((len(here), len(free)))
    for j, k in enumerate(free):
        ends = [
            (z[k], here),
            *((sides[2 * j + side][k], there[2 * j + side]) for side in (0, 1)),
        ]
        usable = sorted(
            (end for end in ends if np.isfinite(end[1]).all()),
            key=lambda end: float(end[0]),
        )
        if not usable or usable[0][0] == usable[-1][0]:
            raise ConvergenceError(
                f"no run beside the fitted point has a result where key {k + 1} "
                f"differs by {DIFFERENCE:g} standard "
                "deviations of its prior; narrow the priors"
            )
        (left, low), (right, high) = usable[0], usable[-1]
        slopes[:, j] = (high - low) / (right - left)
    return here, slopes


def _start(problem: Problem) -> Array:
    """Return the middle of the priors, or the first of points spread in them that
    have a result.
    """
    from scipy.stats import qmc

    model, priors = problem.model, problem.priors
    middle = np.zeros(len(priors))
    if np.isfinite(model.values(middle[None])).all():
        return middle
    shares = qmc.LatinHypercube(len(priors), seed=np.random.default_rng(0)).random(
        TRIALS
    )
    points = np.column_stack(
        [prior.scaled(prior(shares[:, k])) for k, prior in enumerate(priors)]
    )
    usable = np.isfinite(model.values(points)).all(axis=1)
    if not usable.any():
        why = getattr(model, "problem", str)()
        raise ConvergenceError(
            f"no run has a result in the middle of the priors or at {TRIALS} points "
            "spread in them; change the priors. "
            f"The last problem: {why}"
        )
    return np.asarray(points[int(np.argmax(usable))])


def _scatter(residuals: Array, freedom: float) -> float:
    """Return the factor of the stated errors that the residuals ask for; 1 if chance
    explains them.
    """
    from scipy.stats import chi2

    square = float(residuals @ residuals)
    if freedom < 1.0 or square <= float(chi2.ppf(SIGNIFICANT, freedom)):
        return 1.0
    return math.sqrt(square / freedom)


def _alike(residuals: Array, groups: Integers) -> float:
    """Return the correlation of neighbours in the same group; 0 if chance explains
    it.
    """
    from scipy.special import ndtri

    pairs = groups[1:] == groups[:-1]
    if not pairs.any():
        return 0.0
    square = float(np.mean(residuals**2))
    found = (
        float(np.mean(residuals[1:][pairs] * residuals[:-1][pairs])) / square
        if square > 0.0
        else 0.0
    )
    chance = float(ndtri(SIGNIFICANT)) / math.sqrt(int(pairs.sum()))
    return min(found, MOST_ALIKE) if found > chance else 0.0
