"""Measured points beside the band of a cascade: what every run predicts at them, and
which share the band holds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import ContbedError
from contbed.fields import header
from contbed.many.validate.case import Case, Points
from contbed.many.validate.score import looked_up
from contbed.output.tables import read_table

NODES = 21  # of the normal distribution of a measured value about each prediction


@dataclass(frozen=True)
class Held:
    """Measured points, and the band of the prediction at each of them, (points,).

    best : by the best values and first laws
    low, high : ends of the band of the prediction
    low_measured, high_measured : of a measured value, which scatters by its standard
        uncertainty as well
    shares : of each part of the uncertainty in the sum of the variances at all points
    """

    points: Points
    best: Array
    low: Array
    high: Array
    low_measured: Array
    high_measured: Array
    shares: Mapping[str, float]

    @property
    def inside(self) -> float:
        """Share of the points in the band of the prediction."""
        return float(
            np.mean((self.low <= self.points.value) & (self.points.value <= self.high))
        )

    @property
    def inside_measured(self) -> float:
        """Share of the points in the band of a measured value."""
        value = self.points.value
        return float(
            np.mean((self.low_measured <= value) & (value <= self.high_measured))
        )


def outputs(case: Case) -> dict[str, Any]:
    """Return the keys of a scene that let a run have output at all measured points."""
    times = sorted(set(case.points.t.tolist()))
    return {
        "time.end": times[-1],
        "time.times": times,
        "output.positions": sorted(set(case.points.x.tolist())),
    }


def names(case: Case) -> list[str]:
    """Return the names of the points among the results of a run."""
    return [f"measured point {k + 1}" for k in range(len(case.points.value))]


def predicted(case: Case, folder: Path) -> dict[str, float]:
    """Return what a run in a folder predicts at each point, by its name.

    Raises
    ------
    ContbedError : its profiles are damaged
    """
    profiles = read_table(folder / "profiles.csv")
    if missing := [
        name
        for name in (header("t"), header(case.settings.quantity))
        if name not in profiles
    ]:
        text = (
            f"has no column {missing[0]!r}; remove {folder}, and the same command "
            "computes it again"
        )
        raise ContbedError(f"{folder / 'profiles.csv'}: {text}")
    axis = next(column for column in profiles if column != header("t"))
    values, times = profiles[header(case.settings.quantity)], profiles[header("t")]
    found = looked_up(values, times, profiles[axis], case.points.t, case.points.x)
    return dict(zip(names(case), found.tolist(), strict=True))


def held(
    case: Case,
    base: Mapping[str, float],
    deviations: Mapping[str, Mapping[str, float]],
    samples: Mapping[str, Array],
    probability: float,
) -> Held:
    """Return the bands at the points.

    Parameters
    ----------
    base : results of the best values
    deviations : standard deviation of each result by part of the uncertainty
    samples : each result of the runs with everything at random, (runs,)
    probability : of the bands
    """
    of = names(case)
    runs = np.array([samples[name] for name in of])
    tails = 0.5 * (1.0 - probability), 0.5 * (1.0 + probability)
    low, high = np.quantile(runs, tails, axis=1)
    quantiles = np.array(
        [NormalDist().inv_cdf((k + 0.5) / NODES) for k in range(NODES)]
    )
    spread = (runs[:, :, None] + case.uncertainty * quantiles).reshape(len(of), -1)
    low_measured, high_measured = np.quantile(spread, tails, axis=1)
    squares = {
        part: sum(by[name] ** 2 for name in of) for part, by in deviations.items()
    }
    total = sum(squares.values()) or 1.0
    shares = {part: square / total for part, square in squares.items()}
    best = np.array([base[name] for name in of])
    return Held(case.points, best, low, high, low_measured, high_measured, shares)
