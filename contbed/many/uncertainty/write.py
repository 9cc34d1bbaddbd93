"""Uncertainty of a sweep that has a [sample]: uncertainty.csv, indices.csv and a
picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import ContbedError
from contbed.fields import behind, labelled
from contbed.many.derivatives.gradients import gradient
from contbed.many.quantities import Quantity
from contbed.many.store import Store, key_of
from contbed.many.sweep.study import Sample, Study
from contbed.many.sweep.table import Row, chosen
from contbed.many.tables import write_rows
from contbed.many.uncertainty.indices import Indices, indices
from contbed.many.uncertainty.polynomial_chaos import (
    chaos_indices,
    chaos_spread,
    expansion,
)
from contbed.many.uncertainty.propagate import (
    Spread,
    contributions,
    first_order,
    independent,
    of_sample,
    of_size_one,
)
from contbed.many.value_sets import BY_THEMSELVES
from contbed.output.plots import styled_figure
from contbed.scene.identity import scene_hash
from contbed.scene.tables import SceneBase

SLOPES = "gradient.jsonl"  # the derivatives at the means


@dataclass(frozen=True)
class Uncertainty:
    """What is known of one result; `shares` are those of the parameters in the
    variance to first order.
    """

    result: Quantity
    spreads: tuple[Spread, ...]
    indices: Indices | None
    shares: Array | None


@dataclass(frozen=True)
class Report:
    """Uncertainty of all results of a sweep, and what to be warned of."""

    sample: Sample
    results: tuple[Uncertainty, ...]
    warnings: tuple[str, ...]


def write(study: Study, rows: Sequence[Row], out: Path) -> Report | None:
    """Write the uncertainty of the results of a sweep; None if it has no sample that
    stands alone.

    Parameters
    ----------
    study, rows : the sweep and its runs that have ended; out : its folder
    """
    sample = study.sample
    if sample is None or len(study.order) != len(sample.points):
        return None
    by_name = {row.run: row for row in rows}
    if not all(name in by_name for name in study.order):
        return None
    ordered = [by_name[name] for name in study.order]
    results = chosen(study, ordered)
    names = [quantity.key for quantity, _ in results]
    slopes, told = _slopes(study, sample, names, ordered, out)
    found = []
    for quantity, values in results:
        drawn = independent(sample.method, sample.points)
        spreads = [of_sample(values[drawn])]
        shares = None
        if quantity.key in slopes:
            value, slope, runs = slopes[quantity.key]
            spreads.append(first_order(value, slope, sample.distributions, runs))
            parts = of_size_one(contributions(slope, sample.distributions))[0] ** 2
            shares = parts / parts.sum() if parts.sum() > 0.0 else None
        index = None
        if sample.method in BY_THEMSELVES:
            index = indices(sample.method, sample.points, values)
        elif chaos := expansion(
            sample.points, values, list(sample.distributions.values())
        ):
            spreads.append(chaos_spread(chaos))
            index = chaos_indices(chaos)
        found.append(
            Uncertainty(
                quantity,
                tuple(spread for spread in spreads if spread is not None),
                index,
                shares,
            )
        )
    report = Report(sample, tuple(found), tuple(told))
    _write(report, out)
    return report


def _slopes(
    study: Study, sample: Sample, wanted: list[str], rows: Sequence[Row], out: Path
) -> tuple[dict[str, tuple[float, Array, int]], list[str]]:
    """Return value, derivatives and runs of each result at the means of the
    parameters; they are kept in a file.
    """
    if not sample.gradients:
        return {}, []
    floats = [
        name
        for name in wanted
        if any(isinstance(row.qoi.get(name), float) for row in rows)
    ]
    keys = list(sample.distributions)
    if not floats:
        return {}, []
    try:
        scene = study.base(
            {name: spread.mean for name, spread in sample.distributions.items()}
        )
        key = key_of(scene_hash(scene), floats, keys)
        known = Store(out / SLOPES).kept(key, lambda: _gradient(scene, floats, keys))
    except ContbedError as error:
        return {}, [f"no propagation by gradients: {error}"]
    each = zip(floats, known["values"], known["derivatives"], strict=True)
    return {
        name: (value, np.array(slope), known["runs"]) for name, value, slope in each
    }, []


def _gradient(scene: SceneBase, results: list[str], keys: list[str]) -> dict[str, Any]:
    """Return values and derivatives of results, and the number of runs that they
    take.
    """
    found = gradient(scene, results, keys)
    runs = 1 if found.method == "tangent" else 1 + 4 * len(keys)
    return {"values": found.values, "derivatives": found.derivatives, "runs": runs}


def _write(report: Report, out: Path) -> None:
    names = list(report.sample.distributions)
    write_rows(
        out / "uncertainty.csv",
        ("result", "unit", "estimator", "runs", "mean", "standard error of the mean", "standard deviation", "low",
         "high"),
        (
            (one.result.name, one.result.unit, s.estimator, s.runs, s.mean, s.mean_error, s.deviation, s.low, s.high)
            for one in report.results
            for s in one.spreads
        ),
        _nine_digits,
    )  # fmt: skip
    head = next(
        (
            list(one.indices.columns)
            for one in report.results
            if one.indices is not None
        ),
        [],
    )
    write_rows(
        out / "indices.csv",
        ("result", "unit", "parameter", "share by gradients", *head),
        (
            (
                one.result.name, one.result.unit, name, None if one.shares is None else one.shares[k],
                *(() if one.indices is None else (column[k] for column in one.indices.columns.values())),
            )
            for one in report.results
            for k, name in enumerate(names)
        ),
        _nine_digits,
    )  # fmt: skip
    _plot(report, out / "uncertainty.png")


def _nine_digits(value: Any) -> Any:
    return f"{value:.9g}" if isinstance(value, float) else value


_ROW = 1.2  # height of a panel besides its bars [inches]
_BAR = 0.35  # and of a parameter


def _plot(report: Report, path: Path) -> None:
    """Draw the shares or effects of the parameters, a panel for each result."""
    names = list(report.sample.distributions)
    shown = [
        one
        for one in report.results
        if one.indices is not None or one.shares is not None
    ]
    if not shown:
        return
    rows = np.arange(len(names))
    with styled_figure(
        path, len(shown) * (_ROW + _BAR * len(names)), "", width=8.0
    ) as figure:
        panels = figure.subplots(len(shown), 1, squeeze=False)[:, 0]
        for axes, one in zip(panels, shown, strict=True):
            found = {} if one.indices is None else one.indices.columns
            labels = [
                name
                for name in ("first order", "total", "mean magnitude")
                if name in found
            ]
            bars: list[tuple[str, Array, Array]] = [
                (name, found[name], found[f"{name} +-"]) for name in labels
            ]
            if one.shares is not None and "mean magnitude" not in found:
                bars.insert(
                    0, ("first order, by gradients", one.shares, np.zeros(len(names)))
                )
            height = 0.8 / max(len(bars), 1)
            for k, (label, values, errors) in enumerate(bars):
                axes.barh(
                    rows + (k - 0.5 * (len(bars) - 1)) * height,
                    values,
                    height,
                    xerr=errors,
                    label=label,
                )
            axes.set_yticks(rows, names)
            axes.set_ylim(len(names) - 0.5, -0.5)
            axes.set(
                title=one.result.name,
                xlabel=labelled("mean magnitude of effects", one.result.unit)
                if "mean magnitude" in found
                else "share of the variance",
            )
            axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.0))


def table(report: Report) -> str:
    """Return means, standard deviations and indices as lines for a terminal."""
    lines = []
    for one in report.results:
        unit = behind(one.result.unit)
        for s in one.spreads:
            runs = "1 run" if s.runs == 1 else f"{s.runs} runs"
            lines.append(
                f"{one.result.name}, by {s.estimator} ({runs}): mean "
                f"{s.mean:.6g}{unit}, standard deviation "
                f"{s.deviation:.4g}{unit}, 90 % from {s.low:.6g} to {s.high:.6g}{unit}"
            )
        for k, name in enumerate(report.sample.distributions):
            parts = (
                []
                if one.shares is None
                else [f"share by gradients {one.shares[k]:.3f}"]
            )
            if one.indices is not None:
                found = one.indices.columns
                for label in ("first order", "total", "mean magnitude"):
                    if label in found:
                        parts.append(
                            f"{label} {found[label][k]:.3g} +- "
                            f"{found[f'{label} +-'][k]:.2g}"
                        )
            if parts:
                lines.append(f"  {name}: {', '.join(parts)}")
    return "\n".join(lines)
