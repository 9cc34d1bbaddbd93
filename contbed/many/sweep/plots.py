"""The picture of a sweep: results over the parameters that vary.

One parameter gives lines, with a choice beside it one line for each; two numbers give
contours; more give the main effects, every run as a point and the mean over the others
as a line. Runs that failed are crosses.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.many.quantities import Quantity, parameter
from contbed.many.sweep.study import Study
from contbed.many.sweep.table import Row, chosen
from contbed.output.colours import COLOURS
from contbed.output.plots import styled_figure

_FAILED: dict[str, Any] = {
    "color": "#B00020",
    "marker": "x",
    "linestyle": "none",
    "markersize": 5,
}
_MOST_RESULTS = 4
_MOST_EFFECTS = 5
_BINS = 8  # of a parameter with more values than that
_WIDE = 24  # characters of a label


@dataclass(frozen=True)
class _Axis:
    """A parameter that varies: its value in each run as a number, or the number of
    its choice.
    """

    quantity: Quantity
    values: Array
    choices: tuple[str, ...] = ()
    logarithmic: bool = False

    @property
    def scaled(self) -> Array:
        """The values as they are spread along the axis."""
        return np.log10(np.abs(self.values)) if self.logarithmic else self.values

    def label(self, axes: Any, which: str = "x", ticks: int = 4) -> None:
        """Label and scale the x or y axis."""
        from matplotlib.ticker import (
            FuncFormatter,
            LogLocator,
            MaxNLocator,
            NullLocator,
        )

        axes.set(**{f"{which}label": self.quantity.label})
        axis = getattr(axes, f"{which}axis")
        if self.choices:
            axis.set_ticks(range(len(self.choices)), self.choices)
            return
        size = np.abs(self.values)
        if self.logarithmic and size.max() >= 3.0 * size.min():
            scale = getattr(axes, f"set_{which}scale")
            if self.values[0] > 0.0:
                scale("log")
                between = (1.0, 2.0, 5.0) if size.max() < 1e3 * size.min() else (1.0,)
                axis.set_major_locator(LogLocator(subs=between))
            else:
                scale("symlog", linthresh=size.min())
            axis.set_minor_locator(NullLocator())
        else:
            axis.set_major_locator(MaxNLocator(ticks))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def plot(path: Path, study: Study, rows: list[Row]) -> None:
    """Draw a sweep if anything varies in it."""
    axes = [
        axis for name in study.axes if (axis := _axis(name, study, rows)) is not None
    ]
    results = chosen(study, rows)
    if study.qoi:
        results.sort(key=lambda item: study.qoi.index(item[0].key))
    else:
        results = results[:_MOST_RESULTS]
    failed = np.array([bool(row.exit_code) for row in rows])
    if not axes or not results:
        return
    numbers = [axis for axis in axes if not axis.choices]
    lines = len(axes) == 1 or (len(axes) == 2 and len(numbers) == 1)
    if lines:
        _lines(path, study.title, axes, results, failed)
    elif len(axes) == len(numbers) == 2 and _is_plane(numbers):
        _contours(path, study.title, numbers, results, failed)
    else:
        _effects(path, study.title, axes, results, failed)


def _axis(name: str, study: Study, rows: list[Row]) -> _Axis | None:
    values = [row.parameters[name] for row in rows]
    texts = [str(value) for value in values]
    choices = tuple(dict.fromkeys(texts))
    if len(choices) == 1:
        return None
    if all(
        isinstance(value, int | float) and not isinstance(value, bool)
        for value in values
    ):
        numbers = np.array(values, dtype=float)
        return _Axis(parameter(name, values), numbers, (), name in study.logarithmic)
    places = np.array([choices.index(text) for text in texts], dtype=float)
    return _Axis(parameter(name, values), places, choices)


def _lines(
    path: Path,
    title: str,
    axes: list[_Axis],
    results: list[tuple[Quantity, Array]],
    failed: Any,
) -> None:
    along = next((axis for axis in axes if not axis.choices), axes[0])
    beside = next((axis for axis in axes if axis is not along), None)
    with styled_figure(path, 1.2 + 2.6 * len(results), title) as figure:
        panels = figure.subplots(len(results), 1, sharex=True, squeeze=False)[:, 0]
        for panel, (quantity, values) in zip(panels, results, strict=True):
            groups = [np.ones(len(values), bool)]
            if beside is not None:
                groups = [beside.values == k for k in range(len(beside.choices))]
            for k, group in enumerate(groups):
                order = np.flatnonzero(group)[
                    np.argsort(along.values[group], kind="stable")
                ]
                panel.plot(
                    along.values[order],
                    values[order],
                    "o" if along.choices else "o-",
                    markersize=4,
                    color=COLOURS[k % len(COLOURS)],
                    label=beside.choices[k] if beside else None,
                )
            _crosses(panel, along, failed)
            panel.set_ylabel(folded_label(quantity.label))
            along.label(panel)
            panel.label_outer()
        if beside is not None:
            panels[0].legend(title=beside.quantity.label)


def _contours(
    path: Path,
    title: str,
    axes: list[_Axis],
    results: list[tuple[Quantity, Array]],
    failed: Any,
) -> None:
    from matplotlib.tri import Triangulation

    x, y = axes
    across = min(len(results), 2)
    down = -(-len(results) // across)
    with styled_figure(
        path, 0.6 + (3.3 if across > 1 else 5.0) * down, title
    ) as figure:
        panels = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
        for panel, (quantity, values) in zip(panels.flat, results, strict=False):
            net = Triangulation(x.scaled, y.scaled)
            # nothing is said about the surroundings of a run that failed
            hidden = ~np.isfinite(values)[net.triangles].all(axis=1)
            net.set_mask(hidden)
            net.x, net.y = x.values, y.values
            if not hidden.all():
                colours = panel.tricontourf(
                    net, np.nan_to_num(values), levels=14, cmap="viridis"
                )
                figure.colorbar(colours, ax=panel).outline.set_visible(False)
            panel.plot(x.values, y.values, ".", color="white", markersize=2)
            panel.plot(x.values[failed], y.values[failed], **_FAILED)
            x.label(panel)
            y.label(panel, "y")
            panel.set_title(quantity.label, loc="left")
            panel.label_outer()
        for panel in panels.flat[len(results) :]:
            panel.remove()


def _effects(
    path: Path,
    title: str,
    axes: list[_Axis],
    results: list[tuple[Quantity, Array]],
    failed: Any,
) -> None:
    # those that move the first result most
    strongest = sorted(axes, key=lambda axis: -np.ptp(_means(axis, results[0][1])[1]))[
        :_MOST_EFFECTS
    ]
    shown = [axis for axis in axes if any(axis is other for other in strongest)]
    if len(shown) < len(axes):
        title = (
            f"{title}\n" * bool(title)
            + f"the {len(shown)} strongest of {len(axes)} parameters"
        )
    with styled_figure(path, 1.0 + 2.2 * len(results), title) as figure:
        panels = figure.subplots(
            len(results), len(shown), sharex="col", sharey="row", squeeze=False
        )
        for row, (quantity, values) in zip(panels, results, strict=True):
            for panel, axis in zip(row, shown, strict=True):
                panel.plot(axis.values, values, ".", color="0.75", markersize=3)
                panel.plot(*_means(axis, values), "o-", color=COLOURS[0], markersize=4)
                _crosses(panel, axis, failed)
                axis.label(panel, ticks=3)
                panel.set_xlabel(folded_label(axis.quantity.label), fontsize=8)
                panel.tick_params(which="both", labelsize=8)
                panel.set_ylabel(folded_label(quantity.label))
                panel.label_outer()


def _means(axis: _Axis, values: Array) -> tuple[Array, Array]:
    """Return the mean of a result for each value of a parameter, or for slices of
    equally many runs.
    """
    there = np.isfinite(values)
    at, found = axis.values[there], values[there]
    levels = np.unique(at)
    if len(levels) <= _BINS:
        return levels, np.array([found[at == level].mean() for level in levels])
    # with eight runs in a slice its mean is steadier than a run
    slices = np.array_split(
        np.argsort(at, kind="stable"), int(np.clip(len(at) // 8, 2, _BINS))
    )
    return np.array([np.median(at[part]) for part in slices]), np.array(
        [found[part].mean() for part in slices]
    )


def _crosses(panel: Any, axis: _Axis, failed: Any) -> None:
    """Mark failed runs on the lower edge."""
    if failed.any():
        panel.plot(
            axis.values[failed],
            np.zeros(failed.sum()),
            transform=panel.get_xaxis_transform(),
            clip_on=False,
            zorder=4,
            **_FAILED,
        )


def _is_plane(axes: list[_Axis]) -> bool:
    """Return whether the points span a plane, and not a line."""
    correlation = np.corrcoef([axis.scaled for axis in axes])[0, 1]
    return bool(abs(correlation) < 1.0 - 1e-12)


def folded_label(label: str) -> str:
    """Fold a long label: its unit, or its last part, is put on a line of its own."""
    if len(label) <= _WIDE:
        return label
    name, bracket, unit = label.partition(" [")
    if len(name) > _WIDE:
        above, point, last = name.rpartition(".")
        name = f"{above}{point}\n{last}"
    return name + bracket.replace(" ", "\n") + unit
