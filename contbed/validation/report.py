"""Table, picture and summary of measured beds that were run."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import FIELDS
from contbed.output.files import atomic
from contbed.output.plots import styled_figure
from contbed.validation.score import COVERAGE, Validated
from contbed.versions import versions

_WIDE = 4.4  # height of a row of the picture [inches]
_CURVES = 6  # most groups of one picture
_HEAD = ("case", "group", "points", "RMS", "bias", "data", "band", "verdict", "CPU")


def table(done: Sequence[Validated]) -> str:
    """Return a table for a terminal, one row for each group of each case."""
    rows: list[tuple[str, ...]] = [_HEAD]
    for one in done:
        unit = one.case.unit
        for k, score in enumerate(one.scores):
            numbers = (f"{value:.3g} {unit}" for value in (score.rms, score.bias, score.data, score.band))
            verdict = "within uncertainty" if score.within else "beyond uncertainty"
            first = (one.case.name, f"{one.cpu:.1f} s") if k == 0 else ("", "")
            rows.append((first[0], score.group, str(score.points), *numbers, verdict, first[1]))
    widths = [max(len(row[k]) for row in rows) for k in range(len(_HEAD))]
    left = (0, 1, 7)
    return "\n".join(
        "  ".join(
            cell.ljust(width) if k in left else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    )


def summary(done: Sequence[Validated]) -> dict[str, Any]:
    """Return the content of summary.json: scores, influence of inputs and predictions of each case."""
    return {"versions": versions(), "cases": {one.case.name: one.to_dict() for one in done}}


def write(done: Sequence[Validated], out: Path) -> None:
    """Write summary.json and validation.png into a folder."""
    with atomic(out / "summary.json") as path:
        path.write_text(json.dumps(summary(done), indent=1), encoding="utf-8")
    with styled_figure(out / "validation.png", _WIDE * len(done), "", width=11.0) as figure:
        grid = figure.subplots(len(done), 2, squeeze=False, width_ratios=(1.6, 1.0))
        for (curves, parity), one in zip(grid, done, strict=True):
            _curves(curves, one)
            _parity(parity, one)


def _curves(axes: Any, one: Validated) -> None:
    """Draw measured points with error bars and the predictions with their band, one colour for each group."""
    points, by_time = one.case.points, one.case.settings.each == "time"
    of, along = (points.t, points.x) if by_time else (points.x, points.t)
    groups = np.unique(of)
    if len(groups) > _CURVES:
        groups = groups[np.linspace(0, len(groups) - 1, _CURVES).astype(int)]
    for k, group in enumerate(groups):
        chosen = np.flatnonzero(of == group)
        chosen = chosen[np.argsort(along[chosen])]
        x, colour = along[chosen], f"C{k}"
        name = f"{group:g} s" if by_time else f"{group:g} m"
        axes.errorbar(
            x,
            points.value[chosen],
            COVERAGE * one.case.uncertainty,
            fmt="o",
            ms=3,
            lw=0.6,
            alpha=0.6,
            color=colour,
            label=f"measured, {name}",
        )
        axes.plot(x, one.predicted[chosen], color=colour, label=f"predicted, {name}")
        spread = COVERAGE * one.band[chosen]
        axes.fill_between(
            x, one.predicted[chosen] - spread, one.predicted[chosen] + spread, color=colour, alpha=0.2, lw=0
        )
    axes.set(
        title=one.case.settings.title,
        xlabel="position [m]" if by_time else "time [s]",
        ylabel=FIELDS[one.case.settings.quantity].label,
    )
    axes.legend(fontsize=8, ncols=2)


def _parity(axes: Any, one: Validated) -> None:
    """Draw predicted over measured values with the line of agreement."""
    measured = one.case.points.value
    ends = [min(measured.min(), one.predicted.min()), max(measured.max(), one.predicted.max())]
    axes.plot(ends, ends, color="black", lw=0.8)
    axes.errorbar(
        measured,
        one.predicted,
        yerr=COVERAGE * one.band,
        xerr=COVERAGE * one.case.uncertainty,
        fmt="o",
        ms=3,
        lw=0.5,
        alpha=0.6,
    )
    score = one.scores[-1]
    label = FIELDS[one.case.settings.quantity].label
    axes.set(
        title=f"RMS {score.rms:.3g} {one.case.unit}, bias {score.bias:+.3g} {one.case.unit}",
        xlabel=f"measured {label}",
        ylabel=f"predicted {label}",
    )
