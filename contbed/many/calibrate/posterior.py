"""Samples of the posterior distribution of the keys, by the affine-invariant sampler of
emcee.

Foreman-Mackey et al. 2013, doi:10.1086/670067. The same seed gives the same samples, so
that a command that was killed finds its runs again and resumes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import ContbedError
from contbed.many.calibrate.fit import Fit, Problem
from contbed.many.calibrate.settings import Posterior

# share of the steps at the beginning, in which the walkers leave their start
FORGOTTEN = 0.25
# autocorrelation times that a chain must hold for intervals at 90 % to settle
ENOUGH = 20.0
# spread of the start, in standard deviations of the prior, where the fit leaves none
LEAST = 1e-3


@dataclass(frozen=True)
class Samples:
    """Samples of the scaled keys, shape (samples, keys).

    acceptance : share of accepted moves; autocorrelation : time in steps, the longest
        of the keys
    """

    z: Array
    acceptance: float
    autocorrelation: float
    steps: int

    @property
    def warning(self) -> str:
        """What is wrong with the samples, or nothing."""
        if self.steps >= ENOUGH * self.autocorrelation:
            return ""
        return (
            f"posterior.steps = {self.steps}: only "
            f"{self.steps / self.autocorrelation:.0f} autocorrelation times; "
            f"at least {ENOUGH * self.autocorrelation:.0f} steps are needed"
        )


def require_emcee() -> Any:
    """Return the module emcee, or raise ContbedError with what to install."""
    try:
        import emcee
    except ImportError:
        raise ContbedError(
            "[posterior] needs emcee: pip install 'contbed[calibrate]'"
        ) from None
    return emcee


def sample(
    problem: Problem,
    found: Fit,
    settings: Posterior,
    each: Any = None,
) -> Samples:
    """Sample the keys from about the fit on.

    Parameters
    ----------
    each : called after each step, without arguments

    Raises
    ------
    ContbedError : emcee is not installed
    """
    emcee = require_emcee()
    low, high = problem.ends
    keys = len(problem.priors)

    def logarithm(z: Array) -> Array:
        """Return the logarithm of the probability, shape (walkers,); runs that fail
        have none.
        """
        result = np.full(len(z), -np.inf)
        inside = np.all((z >= low) & (z <= high), axis=1)
        if inside.any():
            residuals = problem.residuals(problem.model.values(z[inside]), found.factor)
            normal = z[inside][:, problem.normal]
            square = (residuals**2).sum(axis=1) + (normal**2).sum(axis=1)
            result[inside] = np.where(np.isfinite(square), -0.5 * square, -np.inf)
        return result

    random = np.random.default_rng(settings.seed)
    root = np.linalg.cholesky(found.covariance + LEAST**2 * np.eye(keys))
    start = found.z + random.standard_normal((settings.walkers, keys)) @ root.T
    start = np.where(start < low, 2.0 * low - start, start)  # reflected at the bounds
    start = np.clip(np.where(start > high, 2.0 * high - start, start), low, high)
    sampler = emcee.EnsembleSampler(settings.walkers, keys, logarithm, vectorize=True)
    sampler.random_state = np.random.RandomState(settings.seed).get_state()
    for _ in sampler.sample(start, iterations=settings.steps):
        if each is not None:
            each()
    dropped = int(FORGOTTEN * settings.steps)
    time = float(np.max(sampler.get_autocorr_time(quiet=True, tol=0)))
    return Samples(
        sampler.get_chain(discard=dropped, flat=True),
        float(np.mean(sampler.acceptance_fraction)),
        time,
        settings.steps,
    )
