"""Deviations of a prediction from what was measured, with both uncertainties."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contbed.arrays import Array

COVERAGE = 2.0  # standard uncertainties in which 95 % of normal deviations lie


@dataclass(frozen=True)
class Score:
    """Deviations of one group of points, or of one number, in `unit`.

    group : "2 h", or "0.04 m"
    data, band : root mean square of the standard uncertainties of data and prediction
    """

    group: str
    points: int
    rms: float
    bias: float
    data: float
    band: float
    unit: str

    @property
    def within(self) -> bool:
        """Whether the deviations are within the uncertainty."""
        return bool(self.rms <= COVERAGE * float(np.hypot(self.data, self.band)))


@dataclass(frozen=True)
class Compared:
    """What a comparison finds.

    predicted, band : predictions at the measured points and their standard uncertainty,
        shape (points,)
    reported : predictions by name; influence : RMS change of the prediction by each
        uncertain input
    """

    predicted: Array
    band: Array
    scores: list[Score]
    reported: dict[str, Any]
    influence: dict[str, float] = field(default_factory=dict)


def score(group: str, deviation: Array, data: float, band: Array, unit: str) -> Score:
    """Score the deviations, predicted minus measured, of a group of points.

    Parameters
    ----------
    deviation, band : of each point, shape (points,)
    data : standard uncertainty of a measured point
    """
    rms, spread = (float(np.sqrt(np.mean(values**2))) for values in (deviation, band))
    return Score(
        group, len(deviation), rms, float(np.mean(deviation)), data, spread, unit
    )
