"""Pictures of a calibration: measured and predicted values, residuals, and the keys
with their intervals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import labelled
from contbed.many.calibrate.experiments import Point
from contbed.many.calibrate.found import Calibrated
from contbed.output.plots import styled_figure

_ROW = 3.6  # height of a row of panels [inches]
_MOST_CURVES = 8  # of a panel
_DARK = 0.6  # magnitude of a correlation above which its colour is dark
_FEW = 12  # points of a curve of a prediction up to which they are marked


def plot(found: Calibrated, out: Path) -> None:
    """Draw fit.png, residuals.png and keys.png."""
    groups = {
        name: chosen
        for name, chosen in _panels(found.points).items()
        if found.points[chosen[0]].in_profiles
        or not math.isnan(found.points[chosen[0]].value)
    }
    with styled_figure(
        out / "fit.png", _ROW * len(groups), found.file.settings.title, width=9.0
    ) as figure:
        panels = figure.subplots(len(groups), 1, squeeze=False)[:, 0]
        for axes, ((experiment, quantity), chosen) in zip(
            panels, groups.items(), strict=True
        ):
            if found.points[chosen[0]].in_profiles:
                _curves(axes, found, chosen)
            else:
                _results(axes, found, chosen)
            axes.set_title(f"{experiment}: {quantity}")
    with styled_figure(
        out / "residuals.png", _ROW * 1.1, found.file.settings.title, width=9.0
    ) as figure:
        _residuals(figure, found)
    with styled_figure(
        out / "keys.png",
        1.2 + 0.45 * len(found.keys) + 2.0,
        found.file.settings.title,
        width=9.0,
    ) as f:
        _keys(f, found)


def _panels(points: Sequence[Point]) -> dict[tuple[str, str], list[int]]:
    groups: dict[tuple[str, str], list[int]] = {}
    for k, point in enumerate(points):
        groups.setdefault((point.experiment, point.quantity), []).append(k)
    return groups


def _curves(axes: Any, found: Calibrated, chosen: list[int]) -> None:
    """Draw values over the position, a curve for each time; or over time, a curve
    for each position.
    """
    points, p = found.points, found.prediction
    places = {points[k].x for k in chosen}
    over_time = all(math.isnan(place) for place in places) or (
        len(places) < len({points[k].t for k in chosen})
        and not math.isnan(points[chosen[0]].t)
    )
    series: dict[float | None, list[int]] = {}
    for k in chosen:
        at = points[k].x if over_time else points[k].t
        series.setdefault(None if math.isnan(at) else at, []).append(k)
    for number, (place, members) in enumerate(list(series.items())[:_MOST_CURVES]):
        members = sorted(
            members, key=lambda k: points[k].t if over_time else points[k].x
        )
        along = np.array([points[k].t if over_time else points[k].x for k in members])
        fitted, colour = any(points[k].fitted for k in members), f"C{number}"
        name = (
            "predicted" if place is None else f"{place:g} {'m' if over_time else 's'}"
        )
        line = ("-" if fitted else "--") + (
            "." if len(members) <= _FEW and not fitted else ""
        )
        axes.plot(
            along,
            p.value[members],
            line,
            color=colour,
            label=name if fitted else f"{name}, not fitted",
        )
        wide = p.low_measured[members], p.high_measured[members]
        if np.isfinite(wide[0]).all():
            axes.fill_between(along, *wide, color=colour, alpha=0.12, lw=0)
        axes.fill_between(
            along, p.low[members], p.high[members], color=colour, alpha=0.35, lw=0
        )
        for k in members:
            if not math.isnan(points[k].value):
                x = points[k].t if over_time else points[k].x
                face = colour if points[k].fitted else "white"
                axes.errorbar(
                    x,
                    points[k].value,
                    points[k].error,
                    fmt="o",
                    ms=3,
                    lw=0.6,
                    color=colour,
                    mfc=face,
                )
    axes.set(
        xlabel="time [s]" if over_time else "position [m]",
        ylabel=_unit(points[chosen[0]]),
    )
    axes.legend(
        fontsize=8,
        ncols=2,
        title="bands of 90 %: prediction, and a measurement; open: not fitted",
        title_fontsize=8,
    )


def _results(axes: Any, found: Calibrated, chosen: list[int]) -> None:
    """Draw predicted over measured values with the line of agreement."""
    points, p = found.points, found.prediction
    measured = [k for k in chosen if not math.isnan(points[k].value)]
    values = np.array([points[k].value for k in measured])
    ends = [
        min(values.min(), p.value[measured].min()),
        max(values.max(), p.value[measured].max()),
    ]
    axes.plot(ends, ends, color="black", lw=0.8)
    axes.errorbar(
        values, p.value[measured], found.fit.quantile * p.deviation[measured], [points[k].error for k in measured],
        fmt="o", ms=4, lw=0.6,
    )  # fmt: skip
    axes.set(xlabel=f"measured {_unit(points[chosen[0]])}", ylabel="predicted")


def _residuals(figure: Any, found: Calibrated) -> None:
    """Draw deviations over errors, one after the other and against the normal
    distribution.
    """
    from scipy.special import ndtri

    left, right = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    points, value = found.points, found.prediction.value
    count = 0
    for colour, ((experiment, quantity), chosen) in enumerate(_panels(points).items()):
        for fitted in (True, False):
            shown = [
                k
                for k in chosen
                if points[k].fitted == fitted and not math.isnan(points[k].value)
            ]
            if not shown:
                continue
            left.plot(
                np.arange(count, count + len(shown)),
                [(value[k] - points[k].value) / points[k].error for k in shown],
                "o", ms=3, color=f"C{colour}", mfc=f"C{colour}" if fitted else "white",
                label=f"{experiment}, {quantity}{'' if fitted else ', not fitted'}",
            )  # fmt: skip
            count += len(shown)
    left.axhline(0.0, color="black", lw=0.8)
    left.set(
        xlabel="number of the value", ylabel="(predicted - measured)/standard error"
    )
    left.legend(fontsize=8)
    fit = found.fit
    deviations = np.sort(
        (fit.predicted[found.data.index] - found.data.value) / found.data.error
    )
    shares = (np.arange(len(deviations)) + 0.5) / len(deviations)
    right.plot(ndtri(shares), deviations, "o", ms=3)
    ends = np.array([ndtri(shares[0]), ndtri(shares[-1])])
    right.plot(ends, ends, color="black", lw=0.8)
    right.set(xlabel="normal distribution", ylabel="fitted values, in order")


def _keys(figure: Any, found: Calibrated) -> None:
    """Draw the keys with their intervals in units of their priors, and their
    correlation.
    """
    left, right = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    names = [key.name for key in found.keys]
    rows = np.arange(len(names))
    fit = found.fit
    half = fit.quantile * np.sqrt(np.diag(fit.covariance))
    left.errorbar(fit.z, rows, xerr=half, fmt="o", ms=4, capsize=3, label="covariance")
    kept = [
        (k, found.intervals[name])
        for k, name in enumerate(names)
        if name in found.intervals
    ]
    if kept:
        left.hlines([k + 0.15 for k, _ in kept], [i.low for _, i in kept], [i.high for _, i in kept], color="C1", lw=2,
                    label="profile")  # fmt: skip
    if found.samples is not None:
        low, high = np.quantile(found.samples.z, (0.05, 0.95), axis=0)
        left.hlines(rows - 0.15, low, high, color="C2", lw=2, label="posterior")
    left.axvspan(
        -1.0, 1.0, color="0.9", zorder=0, label="prior, one standard deviation"
    )
    left.set_yticks(rows, names)
    left.set(xlabel="distance from the middle of the prior, in its standard deviations")
    left.set_ylim(len(names) - 0.5, -0.5)
    figure.legend(
        *left.get_legend_handles_labels(), loc="outside lower left", ncols=4, fontsize=8
    )
    spread = np.sqrt(np.diag(fit.covariance))
    correlation = fit.covariance / np.outer(spread, spread)
    picture = right.imshow(correlation, vmin=-1.0, vmax=1.0, cmap="RdBu_r")
    right.set_xticks(rows, [str(k + 1) for k in rows])
    right.set_yticks(rows, [str(k + 1) for k in rows])
    for i in rows:
        for j in rows:
            dark = abs(correlation[i, j]) > _DARK
            right.text(
                j,
                i,
                f"{correlation[i, j]:.2f}",
                ha="center",
                va="center",
                fontsize=7,
                color="white" if dark else "black",
            )
    right.set(title="correlation, keys in this order")
    figure.colorbar(picture, ax=right, shrink=0.8)


def _unit(point: Point) -> str:
    return labelled(point.quantity, point.unit)
