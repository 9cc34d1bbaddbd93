"""The smallest value of a function without gradients, by Gaussian processes for it and
for its constraints.

    minimise f(x)   with   g(x) <= 0,  low <= x <= high

f and g are known at points with errors of known size. Each is modelled by a Gaussian
process with the Matern kernel 5/2 (Rasmussen & Williams 2006) on variables scaled to 0
... 1. The next point is that of the largest expected improvement over the best
predicted value among the points computed, times the probability that all g hold there;
while no point holds them, the probability alone. Predictions in place of values as what
is to be improved keep a lucky value from ending the search (Picheny, Wagner &
Ginsbourger 2013).

Source: Jones, Schonlau & Welch 1998, doi:10.1023/A:1008306431147; Schonlau, Welch &
    Jones 1998, constraints by their
probability, doi:10.1214/lnms/1215456182; Picheny, Wagner & Ginsbourger 2013,
doi:10.1007/s00158-013-0919-4.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.distance import cdist
from scipy.stats import norm, qmc

from contbed.arrays import Array, Flags
from contbed.errors import ContbedError

# of the kernel, of the bounds: shorter ones are noise, longer ones a plane
LENGTHS = (0.05, 20.0)
VARIANCES = (1e-2, 1e3)  # of the kernel, of that of the values
# variance of errors, of that of the values, where repeats do not determine it
NOISE = (1e-8, 1.0)
RESTARTS = 1  # of the fit of the kernel, beside its first start
JITTER = 1e-9  # variance that keeps the matrix regular, of that of the values
SPREAD = 11  # 2**11 candidates over the bounds
NEAR = 256  # candidates about the best point at each distance
SAME = 1e-6  # distance, of the bounds, up to which two points are one
DISTANCES = (0.1, 0.03, 0.01, 0.003)  # of the bounds


@dataclass(frozen=True)
class Known:
    """What is known: points in scaled variables (points, keys), values and variances of
    their errors.

    values : f, then g (points, 1 + m); nan where a run failed
    variances : of the error of each value, (1 + m,); nan where it is to be found by the
        fit
    """

    z: Array
    values: Array
    variances: Array


def require_sklearn() -> Any:
    """Return scikit-learn's module of Gaussian processes, or raise ContbedError with
    what to install.
    """
    try:
        from sklearn import gaussian_process
    except ImportError:
        raise ContbedError(
            "a search without gradients needs scikit-learn: pip install "
            "'contbed[surrogate]'"
        ) from None
    return gaussian_process


class Surrogate:
    """Gaussian processes of f and of each g, fitted to what is known."""

    def __init__(self, known: Known):
        there = np.isfinite(known.values).all(axis=1)
        self.z, values = known.z[there], known.values[there]
        self.middle, self.size = values.mean(axis=0), values.std(axis=0)
        self.size[self.size == 0.0] = 1.0
        found = [
            _fitted(
                self.z,
                (values[:, k] - self.middle[k]) / self.size[k],
                known.variances[k] / self.size[k] ** 2,
            )
            for k in range(values.shape[1])
        ]
        self.fits = [fit for fit, _ in found]
        # of f and g at a point
        self.errors: Array = self.size * np.sqrt([noise for _, noise in found])

    def predict(self, z: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation of f and g without the error of a run,
        (points, 1 + m) each.
        """
        found = [fit(z) for fit in self.fits]
        mean, deviation = (np.column_stack([one[k] for one in found]) for k in (0, 1))
        return self.middle + self.size * mean, self.size * deviation


def _fitted(z: Array, y: Array, variance: float) -> tuple[Any, float]:
    """Return a function of points that gives mean and standard deviation, and the
    variance of the error of a point.
    """
    process = require_sklearn()
    kernels = process.kernels
    kernel = kernels.ConstantKernel(1.0, VARIANCES) * kernels.Matern(
        np.full(z.shape[1], 0.5), LENGTHS, nu=2.5
    )
    told = np.isfinite(variance)
    if not told:
        kernel = kernel + kernels.WhiteKernel(1e-2, NOISE)
    alpha = JITTER + (variance if told else 0.0)
    model = process.GaussianProcessRegressor(
        kernel, alpha=alpha, n_restarts_optimizer=RESTARTS, random_state=0
    )
    with warnings.catch_warnings():
        # a length at its bound is a plane, or a variable that does nothing
        warnings.simplefilter("ignore")
        model.fit(z, y)
    noise = 0.0 if told else float(model.kernel_.k2.noise_level)

    def predict(at: Array) -> tuple[Array, Array]:
        mean, deviation = model.predict(at, return_std=True)
        return mean, np.sqrt(np.maximum(deviation**2 - noise, 0.0))

    return predict, noise if not told else variance


def best_known(known: Known, surrogate: Surrogate) -> tuple[int, bool]:
    """Return the number of the best point by predicted values, and whether all g
    hold there by them.
    """
    rows = np.flatnonzero(np.isfinite(known.values).all(axis=1))
    mean, _ = surrogate.predict(known.z[rows])
    missed = np.maximum(mean[:, 1:] / surrogate.size[1:], 0.0).max(axis=1, initial=0.0)
    holds = missed <= 0.0
    order = np.where(holds, mean[:, 0], np.inf) if holds.any() else missed
    return int(rows[np.argmin(order)]), bool(holds.any())


@dataclass(frozen=True)
class Proposal:
    """The next point, and what it promises: improvement of f, or the probability of
    all g if none holds them yet.
    """

    z: Array
    promise: float
    feasible: bool


def propose(
    known: Known, surrogate: Surrogate, steps: Sequence[float], number: int
) -> Proposal:
    """Return the candidate that promises most.

    Parameters
    ----------
    known, surrogate : points, and the processes fitted to them
    steps : of each variable, 0 for a continuous one: candidates lie on multiples from 0
    number : of the proposal; the same number gives the same candidates
    """
    best, feasible = best_known(known, surrogate)
    z = _unknown(
        _candidates(known.z[best], np.asarray(steps, dtype=float), number), known.z
    )
    if not len(z):
        return Proposal(known.z[best], 0.0, feasible)
    mean, deviation = surrogate.predict(z)
    deviation = np.maximum(deviation, 1e-12 * surrogate.size)
    log_holds = norm.logcdf(-mean[:, 1:] / deviation[:, 1:]).sum(axis=1)
    if not feasible:
        chosen = int(np.argmax(log_holds))
        return Proposal(z[chosen], float(np.exp(log_holds[chosen])), False)
    goal = surrogate.predict(known.z[best : best + 1])[0][0, 0]
    promised = expected_improvement(goal, mean[:, 0], deviation[:, 0]) * np.exp(
        log_holds
    )
    chosen = int(np.argmax(promised))
    return Proposal(z[chosen], float(promised[chosen]), True)


def expected_improvement(goal: float, mean: Array, deviation: Array) -> Array:
    """Return the expected value of max(goal - f, 0) of normally distributed f."""
    u = (goal - mean) / deviation
    found: Array = deviation * (u * norm.cdf(u) + norm.pdf(u))
    return found


def first_points(count: int, steps: Sequence[float]) -> Array:
    """Return points that fill the box 0 ... 1, (count, keys)."""
    sobol = qmc.Sobol(len(steps), seed=0)
    return on_steps(
        sobol.random_base2(int(np.ceil(np.log2(count))))[:count],
        np.asarray(steps, dtype=float),
    )


def _candidates(best: Array, steps: Array, number: int) -> Array:
    over = qmc.Sobol(len(best), seed=number).random_base2(SPREAD)
    random = np.random.default_rng(number)
    near = [
        best + distance * random.standard_normal((NEAR, len(best)))
        for distance in DISTANCES
    ]
    return on_steps(np.clip(np.vstack([over, *near]), 0.0, 1.0), steps)


def _unknown(z: Array, known: Array) -> Array:
    """Return the points that are not known: a run of one of these would add nothing."""
    far: Flags = (cdist(z, known, "chebyshev") > SAME).all(axis=1)
    return z[far]


def on_steps(z: Array, steps: Array) -> Array:
    """Return points with variables that have steps moved onto them."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(steps > 0.0, np.minimum(np.round(z / steps) * steps, 1.0), z)
