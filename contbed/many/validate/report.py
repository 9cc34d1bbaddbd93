"""Table, picture and summary of measured beds that were run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import behind, require
from contbed.many.tables import aligned
from contbed.many.validate.deviations import COVERAGE
from contbed.many.validate.score import Validated
from contbed.many.validate.signal import resampled, spectrum, trace
from contbed.output.plots import styled_figure
from contbed.output.summary import write_json
from contbed.output.versions import versions

_WIDE = 4.4  # height of a row of the picture [inches]
_CURVES = 6  # most groups of one picture
_HEAD = ("case", "group", "points", "RMS", "bias", "data", "band", "verdict", "CPU")


def table(done: Sequence[Validated]) -> str:
    """Return a table for a terminal, one row for each group of each case."""
    rows: list[tuple[str, ...]] = [_HEAD]
    for one in done:
        for k, score in enumerate(one.compared.scores):
            numbers = (
                f"{value:.3g}{behind(score.unit)}"
                for value in (score.rms, score.bias, score.data, score.band)
            )
            verdict = "within uncertainty" if score.within else "beyond uncertainty"
            first = (one.case.name, f"{one.cpu:.1f} s") if k == 0 else ("", "")
            rows.append(
                (first[0], score.group, str(score.points), *numbers, verdict, first[1])
            )
    return "\n".join(aligned(rows, left=(0, 1, 7)))


def summary(done: Sequence[Validated]) -> dict[str, Any]:
    """Return the content of summary.json: scores, influence of inputs and
    predictions of each case.
    """
    return {
        "versions": versions(),
        "cases": {one.case.name: one.to_dict() for one in done},
    }


def write(done: Sequence[Validated], out: Path) -> None:
    """Write summary.json and validation.png into a folder."""
    write_json(out / "summary.json", summary(done))
    with styled_figure(
        out / "validation.png", _WIDE * len(done), "", width=11.0
    ) as figure:
        grid = figure.subplots(len(done), 2, squeeze=False, width_ratios=(1.6, 1.0))
        for (curves, parity), one in zip(grid, done, strict=True):
            if one.case.settings.compare == "signal":
                _traces(curves, one)
                _spectra(parity, one)
            else:
                _curves(curves, one)
                _parity(parity, one)


def _curves(axes: Any, one: Validated) -> None:
    """Draw measured points with error bars and the predictions with their band, one
    colour for each group.
    """
    points, found, settings = one.case.points, one.compared, one.case.settings
    by_time = settings.each == "time" and settings.compare == "profiles"
    of, along = (points.t, points.x) if by_time else (points.x, points.t)
    if settings.compare == "levels":
        of, along = points.height, points.x
    if settings.compare == "history":
        of = np.zeros_like(points.t)
    groups = np.unique(of)
    if len(groups) > _CURVES:
        groups = groups[np.linspace(0, len(groups) - 1, _CURVES).astype(int)]
    for k, group in enumerate(groups):
        chosen = np.flatnonzero(of == group)
        chosen = chosen[np.argsort(along[chosen])]
        x, colour = along[chosen], f"C{k}"
        name = f", {group:g} s" if by_time else f", {group:g} m"
        if settings.compare == "history":
            name = ""
        axes.errorbar(
            x,
            points.value[chosen],
            COVERAGE * one.case.uncertainty,
            fmt="o",
            ms=3,
            lw=0.6,
            alpha=0.6,
            color=colour,
            label=f"measured{name}",
        )
        axes.plot(x, found.predicted[chosen], color=colour, label=f"predicted{name}")
        spread = COVERAGE * found.band[chosen]
        axes.fill_between(
            x,
            found.predicted[chosen] - spread,
            found.predicted[chosen] + spread,
            color=colour,
            alpha=0.2,
            lw=0,
        )
    axes.set(
        title=one.case.settings.title,
        xlabel="time [s]" if along is points.t else "position [m]",
        ylabel=require(one.case.settings.quantity).label,
    )
    axes.legend(fontsize=8, ncols=2)


def _parity(axes: Any, one: Validated) -> None:
    """Draw predicted over measured values with the line of agreement."""
    measured, found = one.case.points.value, one.compared
    ends = [
        min(measured.min(), found.predicted.min()),
        max(measured.max(), found.predicted.max()),
    ]
    axes.plot(ends, ends, color="black", lw=0.8)
    axes.errorbar(
        measured,
        found.predicted,
        yerr=COVERAGE * found.band,
        xerr=COVERAGE * one.case.uncertainty,
        fmt="o",
        ms=3,
        lw=0.5,
        alpha=0.6,
    )
    score = found.scores[-1]
    label = require(one.case.settings.quantity).label
    axes.set(
        title=f"RMS {score.rms:.3g} {one.case.unit}, bias {score.bias:+.3g} "
        f"{one.case.unit}",
        xlabel=f"measured {label}",
        ylabel=f"predicted {label}",
    )


def _traces(axes: Any, one: Validated) -> None:
    """Draw the measured signal and that of the run at the same times, both without
    their means.
    """
    points, settings = one.case.points, one.case.settings
    assert settings.signal is not None
    t, values = trace(one.case, one.result, settings.signal.column)
    at_once = (t >= points.t[0]) & (t <= points.t[-1])
    axes.plot(
        points.t,
        points.value - points.value.mean(),
        "o-",
        ms=2,
        lw=0.8,
        label="measured",
    )
    axes.plot(t[at_once], values[at_once] - values.mean(), label="predicted")
    axes.set(
        title=settings.title, xlabel="time [s]", ylabel=require(settings.quantity).label
    )
    axes.legend(fontsize=8)


def _spectra(axes: Any, one: Validated) -> None:
    """Draw the power per frequency of both signals."""
    points, settings = one.case.points, one.case.settings
    assert settings.signal is not None
    record = points.t[-1] - points.t[0]
    predicted = resampled(*trace(one.case, one.result, settings.signal.column))
    for name, series in (
        ("measured", resampled(points.t, points.value)),
        ("predicted", predicted),
    ):
        axes.loglog(*spectrum(*series, record), label=name)
    deviation = one.compared.scores[0]
    axes.set(
        title=f"{deviation.group}: {deviation.bias:+.3g} {deviation.unit}",
        xlabel="frequency [Hz]",
        ylabel=f"power [{one.case.unit}$^2$ s]",
    )
    axes.legend(fontsize=8)
