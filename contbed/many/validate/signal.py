"""A measured signal over time, such as the pressure in a fluidized bed, against that of
a run: its statistics.

Two runs of a bed that bubbles agree in their statistics only: standard deviation, rate
at which the signal rises through its mean, and frequency at the peak of the spectrum.
The standard uncertainty of the first two comes from their scatter between blocks of a
second (method of batch means), that of the peak is the resolution, one over the length
of the measured record: peaks of a bed that bubbles differ by as much from one record of
3 s to the next. The spectrum of the prediction is the mean over pieces as long as the
measured record that overlap by half (Welch 1967, IEEE Trans. Audio Electroacoust. 15,
70, doi:10.1109/TAU.1967.1161901), so that both resolve the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.fields import name_of
from contbed.many.validate.case import Case, Signal
from contbed.many.validate.deviations import Compared, Score
from contbed.result import Result

# Hz, at which signals are resampled: far above the 2 to 3 Hz of slugs, below the
# samples of a run
RATE = 100.0
BLOCK = 1.0  # s, of the batches; a few bubbles pass in it
LOWEST = 0.5  # Hz, below which a peak is drift and no bubbles


class Statistics(NamedTuple):
    """Values and standard uncertainties of what is compared: deviation [unit],
    crossings and peak [Hz].
    """

    value: tuple[float, float, float]
    uncertainty: tuple[float, float, float]


NAMES = ("standard deviation", "rises through the mean", "peak of the spectrum")


def compare(case: Case, result: Result) -> Compared:
    """Score the statistics of a run's signal against those of the measured one.

    Raises
    ------
    SceneError : the run has no such column
    """
    settings, points = case.settings.signal, case.points
    assert settings is not None, "required of a case that compares signals"
    t, values = trace(case, result, settings.column)
    measured = statistics(
        *resampled(points.t, points.value), points.t[-1] - points.t[0], case.uncertainty
    )
    predicted = statistics(*resampled(t, values), points.t[-1] - points.t[0])
    units = (case.unit, "Hz", "Hz")
    scores = [
        Score(name, len(points.t), abs(p - m), p - m, u_m, u_p, unit)
        for name, p, m, u_p, u_m, unit in zip(
            NAMES,
            predicted.value,
            measured.value,
            predicted.uncertainty,
            measured.uncertainty,
            units,
            strict=True,
        )
    ]
    reported: dict[str, float] = {}
    for who, found in (("measured", measured), ("predicted", predicted)):
        for name, value, unit in zip(NAMES, found.value, units, strict=True):
            reported[f"{who} {name} [{unit}]"] = value
    for column in (settings.column, *settings.report):
        series = trace(case, result, column)[1]
        unit = column.rpartition(" ")[2]
        reported[f"mean of {name_of(column)} {unit}"] = float(series.mean())
        reported[f"standard deviation of {name_of(column)} {unit}"] = float(
            series.std()
        )
    at_points = np.interp(points.t, t, values - values.mean(), np.nan, np.nan)
    return Compared(at_points, np.zeros(len(at_points)), scores, reported)


def trace(case: Case, result: Result, column: str) -> tuple[Array, Array]:
    """Return times [s] and values of a column of profiles.csv from `signal.start` on.

    Raises
    ------
    SceneError : there is no such column
    """
    settings: Signal | None = case.settings.signal
    assert settings is not None, "required of a case that compares signals"
    if column not in result.profiles:
        have = ", ".join(result.profiles)
        raise SceneError(
            f"{case.origin.at(('signal',))}: signal: profiles.csv has no column "
            f"'{column}'; it has {have}"
        )
    t = result.profiles["t [s]"]
    late = t >= settings.start
    return t[late], result.profiles[column][late]


def resampled(t: Array, values: Array) -> tuple[float, Array]:
    """Interpolate a series at even times; return the interval [s] and the values
    without their mean.
    """
    count = round((t[-1] - t[0]) * RATE) + 1
    even = np.interp(np.linspace(t[0], t[-1], count), t, values)
    return (t[-1] - t[0]) / (count - 1), even - even.mean()


def statistics(
    interval: float, values: Array, record: float, noise: float = 0.0
) -> Statistics:
    """Find deviation, rate of rises and peak frequency of a series without its mean.

    Parameters
    ----------
    interval : of the series [s]
    values : shape (samples,)
    record : length of the pieces of the spectrum [s]
    noise : standard uncertainty of a value, which adds to that of the deviation
    """
    rises = (values[:-1] < 0.0) & (values[1:] >= 0.0)
    length = interval * (len(values) - 1)
    blocks = max(2, int(length / BLOCK))
    deviations = [
        float(np.sqrt(np.mean(part**2))) for part in np.array_split(values, blocks)
    ]
    rates = [float(part.mean()) / interval for part in np.array_split(rises, blocks)]
    frequency, power = spectrum(interval, values, record)
    peak = float(frequency[np.argmax(np.where(frequency >= LOWEST, power, 0.0))])
    scatter = [
        float(np.std(parts, ddof=1) / np.sqrt(blocks)) for parts in (deviations, rates)
    ]
    return Statistics(
        (float(values.std()), float(rises.sum() / length), peak),
        (float(np.hypot(scatter[0], noise)), scatter[1], float(1.0 / record)),
    )


def spectrum(interval: float, values: Array, record: float) -> tuple[Array, Array]:
    """Find the frequencies [Hz] and the power per frequency of a series, mean over
    pieces of `record` [s].
    """
    from scipy.signal import welch

    size = min(len(values), round(record / interval) + 1)
    frequency, power = welch(
        values,
        1.0 / interval,
        window="boxcar",
        nperseg=size,
        noverlap=size - max(1, size // 2),
        detrend="constant",
    )
    return frequency[1:], power[1:]
