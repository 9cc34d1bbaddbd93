"""What a calibration found: the fit, its predictions with bands, and what to be
warned of.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.many.calibrate import identify
from contbed.many.calibrate.experiments import Job, Point
from contbed.many.calibrate.fit import Data, Fit
from contbed.many.calibrate.posterior import Samples
from contbed.many.calibrate.settings import CalibrationFile, FittedKey
from contbed.many.store import Content

# distance from a bound of a prior, in standard deviations of it, at which a key is said
# to be there
BOUND = 0.01


@dataclass(frozen=True)
class Prediction:
    """Predictions at all points, each array of shape (points,).

    deviation : standard error from the keys; low, high : band that holds the true value
        with the coverage
    low_measured, high_measured : band that holds a measured value; not a number where
        no error of one is known
    """

    value: Array
    deviation: Array
    low: Array
    high: Array
    low_measured: Array
    high_measured: Array


@dataclass(frozen=True)
class Calibrated:
    """What a calibration found; `before` is the number of runs that were there
    before.
    """

    file: CalibrationFile
    jobs: tuple[Job, ...]
    points: tuple[Point, ...]
    data: Data
    fit: Fit
    combinations: list[identify.Combination]
    intervals: dict[str, identify.Interval]
    samples: Samples | None
    prediction: Prediction
    runs: int
    before: int
    failed: list[Content]
    warnings: list[str] = field(default_factory=list)

    @property
    def keys(self) -> tuple[FittedKey, ...]:
        """The fitted keys."""
        return self.file.keys

    @property
    def values(self) -> dict[str, float]:
        """The fitted keys in SI."""
        return {
            key.name: float(key.prior.value(z))
            for key, z in zip(self.keys, self.fit.z, strict=True)
        }


def data_of(points: Sequence[Point]) -> Data:
    """Return the fitted values, profile after profile, each from one end to the
    other.
    """
    order = sorted(
        (k for k, point in enumerate(points) if point.fitted),
        key=lambda k: (
            points[k].experiment,
            points[k].quantity,
            _series(points[k]),
            _along(points[k]),
        ),
    )
    names: dict[Any, int] = {}
    groups = [
        names.setdefault(
            (points[k].experiment, points[k].quantity, _series(points[k]))
            if points[k].in_profiles
            else k,
            len(names),
        )
        for k in order
    ]
    return Data(
        np.array(order, dtype=np.int64),
        np.array([points[k].value for k in order]),
        np.array([points[k].error for k in order]),
        np.array(groups, dtype=np.int64),
    )


def _series(point: Point) -> float:
    """Return the time of a profile; values without a position are a series over
    time.
    """
    return point.t if not math.isnan(point.x) and not math.isnan(point.t) else -1.0


def _along(point: Point) -> float:
    return point.t if math.isnan(point.x) else point.x


def predict(points: Sequence[Point], found: Fit) -> Prediction:
    """Return predictions with bands, to first order in the keys."""
    deviation = found.bands(found.slopes)
    usual: dict[tuple[str, str], list[float]] = {}
    for point in points:
        if not math.isnan(point.error):
            usual.setdefault((point.experiment, point.quantity), []).append(point.error)
    errors = np.array(
        [
            point.error
            if not math.isnan(point.error)
            else float(
                np.median(usual.get((point.experiment, point.quantity), [math.nan]))
            )
            for point in points
        ]
    )
    half = found.quantile * deviation
    whole = found.quantile * np.hypot(deviation, found.scatter * errors)
    value = found.predicted
    return Prediction(
        value, deviation, value - half, value + half, value - whole, value + whole
    )


def warnings_of(
    file: CalibrationFile, found: Fit, samples: Samples | None
) -> list[str]:
    """Return what a user should know of a fit."""
    told = []
    if not found.converged:
        told.append(
            "the fit has not converged; narrow the priors, or leave out keys that the "
            "data do not see"
        )
    if found.scatter > 1.0:
        told.append(
            f"deviations are {found.scatter:.2g} times the stated standard errors, "
            "more than chance explains: the "
            "errors are too small, or the model lacks something; all errors are taken "
            "as larger by this factor"
        )
    if found.alike > 0.0:
        share = (1.0 - found.alike) / (1.0 + found.alike)
        told.append(
            f"neighbouring deviations are alike, correlation {found.alike:.2f}: the "
            "values count as much as "
            f"{100.0 * share:.0f} % as many independent ones; standard errors of the "
            "keys are widened by "
            f"{1.0 / math.sqrt(share):.2g}"
        )
    for key, z in zip(file.keys, found.z, strict=True):
        if min(abs(z - bound) for bound in key.prior.bounds) < BOUND:
            told.append(
                f"{key.at}: {key.name} is at an end of its prior; the data ask for "
                "more, see whether it may"
            )
    if samples is not None and samples.warning:
        told.append(samples.warning)
    return told
