"""Pictures of a calibration: measured and predicted values, residuals, and the keys
with their intervals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
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


def _of(found: Calibrated, chosen: list[int]) -> Any:
    """Return what is known of some points, each an array (points,)."""
    names = ("t", "x", "value", "error", "fitted")
    points = [found.points[k] for k in chosen]
    return SimpleNamespace(
        **{name: np.array([getattr(one, name) for one in points]) for name in names}
    )


def _panels(points: Sequence[Point]) -> dict[tuple[str, str], list[int]]:
    groups: dict[tuple[str, str], list[int]] = {}
    for k, point in enumerate(points):
        groups.setdefault((point.experiment, point.quantity), []).append(k)
    return groups


def _curves(axes: Any, found: Calibrated, chosen: list[int]) -> None:
    """Draw values over the position, a curve for each time; or over time, a curve
    for each position.
    """
    here, p, order = _of(found, chosen), found.prediction, np.array(chosen)
    over_time = np.isnan(here.x).all() or (
        len(np.unique(here.x)) < len(np.unique(here.t)) and not np.isnan(here.t[0])
    )
    at, along = (here.x, here.t) if over_time else (here.t, here.x)
    for number, place in enumerate(np.unique(at)[:_MOST_CURVES]):
        rows = np.flatnonzero((at == place) | (np.isnan(at) & np.isnan(place)))
        rows = rows[np.argsort(along[rows], kind="stable")]
        members, s, colour = order[rows], along[rows], f"C{number}"
        fitted = here.fitted[rows]
        name = "predicted"
        if not np.isnan(place):
            name = f"{place:g} {'m' if over_time else 's'}"
        line = "-"
        if not fitted.any():
            name, line = f"{name}, not fitted", "--" + "." * (len(rows) <= _FEW)
        axes.plot(s, p.value[members], line, color=colour, label=name)
        wide = p.low_measured[members], p.high_measured[members]
        if np.isfinite(wide[0]).all():
            axes.fill_between(s, *wide, color=colour, alpha=0.12, lw=0)
        band = p.low[members], p.high[members]
        axes.fill_between(s, *band, color=colour, alpha=0.35, lw=0)
        for which, face in ((fitted, colour), (~fitted, "white")):
            k = rows[which]
            look = {"fmt": "o", "ms": 3, "lw": 0.6, "color": colour, "mfc": face}
            axes.errorbar(along[k], here.value[k], here.error[k], **look)
    axes.set(
        xlabel="time [s]" if over_time else "position [m]",
        ylabel=_unit(found.points[chosen[0]]),
    )
    axes.legend(
        fontsize=8,
        ncols=2,
        title="bands of 90 %: prediction, and a measurement; open: not fitted",
        title_fontsize=8,
    )


def _results(axes: Any, found: Calibrated, chosen: list[int]) -> None:
    """Draw predicted over measured values with the line of agreement."""
    here, p = _of(found, chosen), found.prediction
    predicted, half = p.value[chosen], found.fit.quantile * p.deviation[chosen]
    both = np.array([here.value, predicted])[:, np.isfinite(here.value)]
    ends = [both.min(), both.max()]
    axes.plot(ends, ends, color="black", lw=0.8)
    axes.errorbar(here.value, predicted, half, here.error, fmt="o", ms=4, lw=0.6)
    axes.set(xlabel=f"measured {_unit(found.points[chosen[0]])}", ylabel="predicted")


def _residuals(figure: Any, found: Calibrated) -> None:
    """Draw deviations over errors, one after the other and against the normal
    distribution.
    """
    from scipy.special import ndtri

    left, right = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    count = 0
    for number, (names, chosen) in enumerate(_panels(found.points).items()):
        here, colour = _of(found, chosen), f"C{number}"
        deviations = (found.prediction.value[chosen] - here.value) / here.error
        for name, which in (("", here.fitted), (", not fitted", ~here.fitted)):
            shown = deviations[which & np.isfinite(here.value)]
            if not len(shown):
                continue
            left.plot(
                np.arange(count, count + len(shown)),
                shown,
                "o",
                ms=3,
                color=colour,
                mfc="white" if name else colour,
                label=", ".join(names) + name,
            )
            count += len(shown)
    left.axhline(0.0, color="black", lw=0.8)
    left.set(
        xlabel="number of the value", ylabel="(predicted - measured)/standard error"
    )
    left.legend(fontsize=8)
    fit = found.fit
    predicted = fit.predicted[found.data.index]
    deviations = np.sort((predicted - found.data.value) / found.data.error)
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
    if found.intervals:  # of all keys, in their order
        ends = np.array([(each.low, each.high) for each in found.intervals.values()])
        left.hlines(rows + 0.15, *ends.T, color="C1", lw=2, label="profile")
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
    correlation = fit.correlation
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
