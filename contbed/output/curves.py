"""Pictures of curves over one coordinate, a panel for each label of the other axis."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contbed.arrays import Array
from contbed.fields import FIELDS, labelled, name_of, unit_in
from contbed.output.colours import COLOURS
from contbed.output.plots import shown_range, styled_figure
from contbed.output.tables import evenly

# colour and dashes of a phase; the fluid is dashed so that the solid shows through
LOOKS: dict[str, dict[str, Any]] = {
    "fluid": {"color": "#0072B2", "linestyle": (0, (4, 2)), "zorder": 3},
    "solid": {"color": "#D55E00"},
    "other": {"color": "#009E73"},
}
PAIRS = (("T_fluid", "T_solid"), ("theta_fluid", "theta_solid"))
MOST_TIMES = 7  # in one picture
FLAT = 1e-9  # range over the largest value below which a curve is left out
HOUR = 3600.0  # [s]
LABELS = {"K": "$T$ [K]", "1": "mole fraction [1]"}


class Curve(NamedTuple):
    """Points of a curve, its name in the legend, and how its line looks."""

    name: str | None
    x: Array
    y: Array
    look: Mapping[str, Any] = {}


Panels = Mapping[str, Sequence[Curve]]  # by the label of the vertical axis


def draw(figure: Any, panels: Panels, x_label: str, across: int = 1) -> None:
    """Draw panels of curves into a figure, `across` of them side by side."""
    rows = -(-len(panels) // across)
    every = figure.subplots(
        rows, min(across, len(panels)), sharex=True, squeeze=False
    ).ravel()
    for spare in every[len(panels) :]:
        spare.remove()
    for axes, (label, curves) in zip(every, panels.items(), strict=False):
        for k, curve in enumerate(curves):
            look = {"color": COLOURS[k % len(COLOURS)], **curve.look}
            axes.plot(curve.x, curve.y, label=curve.name, **look)
        low, high = shown_range([curve.y for curve in curves])
        margin = 0.05 * (high - low)
        axes.set(ylim=(low - margin, high + margin), ylabel=label)
        axes.margins(x=0)
        if any(curve.name for curve in curves):
            axes.legend(fontsize=8, ncols=1 + (len(curves) > 6))
    for axes in every[: len(panels)][-across:]:
        axes.set_xlabel(x_label)
        axes.tick_params(labelbottom=True)


def curves_plot(
    path: Path | str, panels: Panels, x_label: str, title: str = "", across: int = 1
) -> None:
    """Write a picture of panels of curves; nothing where there are none."""
    rows = -(-len(panels) // across)
    height = 4.7 if rows == 1 else 1.0 + 2.4 * rows
    if panels:
        with styled_figure(path, height, title) as figure:
            draw(figure, panels, x_label, across)


def profile_plot(
    path: Path | str, columns: Mapping[str, Array], along: str, title: str = ""
) -> None:
    """Plot steady profiles along the bed: temperatures of both phases, or the other
    columns where there are none.

    Parameters
    ----------
    path : PNG file
    columns : values by header, as in profiles.csv
    along : which of them is the coordinate
    title : text above the picture
    """
    values = {name_of(header): np.asarray(column) for header, column in columns.items()}
    x = values.pop(name_of(along))
    panels = {}
    for group in groups_of(list(values)):
        several = len(group) > 1
        panels[_group_label(group)] = [
            Curve(phase if several else None, x, values[name], LOOKS[phase])
            for name in group
            if (phase := phase_of(name))
        ]
    curves_plot(path, panels, FIELDS[name_of(along)].label, title)


def transient_plot(
    path: Path | str, columns: Mapping[str, Array], along: str, title: str = ""
) -> None:
    """Plot profiles at several times, dark to light.

    Parameters are those of `profile_plot`; the columns include "t [s]".
    """
    values = {name_of(header): np.asarray(column) for header, column in columns.items()}
    x, t = values.pop(name_of(along)), values.pop("t")
    names = [name for group in groups_of(list(values)) for name in group]
    panels = {
        FIELDS[name].label: list(over_times(x, values[name], t)) for name in names
    }
    curves_plot(path, panels, FIELDS[name_of(along)].label, title, len(names))


def over_times(
    x: Array, y: Array, t: Array, name: str = "", **look: Any
) -> Iterator[Curve]:
    """Yield the curve of each of at most `MOST_TIMES` times, dark to light."""
    from matplotlib import colormaps

    times = np.unique(t)
    times = times[evenly(len(times), MOST_TIMES)]
    colours = colormaps["viridis"](np.linspace(0.0, 0.85, len(times)))
    for time, colour in zip(times, colours, strict=True):
        rows = t == time
        label = f"{name}, {_instant(time)}".removeprefix(", ")
        yield Curve(label, x[rows], y[rows], {"color": colour, **look})


def _instant(time: float) -> str:
    """Return a time in seconds, from an hour on in hours."""
    return f"{time:.4g} s" if time < HOUR else f"{time / HOUR:.4g} h"


def history_plot(
    path: Path | str, columns: Mapping[str, Array], title: str = ""
) -> None:
    """Plot columns over "t [s]", those of one unit together; what does not change is
    left out.

    Parameters
    ----------
    path : PNG file, which is not written where nothing changes
    columns : values by header "name [unit]"; NaN where there is none
    title : text above the picture
    """
    t = columns["t [s]"]
    panels: dict[str, list[Curve]] = {}
    for header, values in columns.items():
        if header != "t [s]" and varies([values]):
            unit = unit_in(header)
            label = LABELS.get(unit, f"[{unit}]")
            panels.setdefault(label, []).append(Curve(name_of(header), t, values))
    curves_plot(path, panels, "$t$ [s]", title)


def branch_plot(
    path: Path | str, columns: Mapping[str, Any], starts: Iterable[str], title: str
) -> None:
    """Plot columns of continuation.csv along a branch, a panel for each beginning of
    their names; between two folds dashed.
    """
    headers = list(columns)
    p, turns = np.asarray(columns[headers[1]]), np.asarray(columns["turns [1]"])
    panels: dict[str, list[Curve]] = {}
    for start in starts:
        shown = [name for name in headers[3:] if name.startswith(start)]
        shown = [name for name in shown if varies([np.asarray(columns[name])])]
        for k, header in enumerate(shown):
            for turn in np.unique(turns):
                part = np.flatnonzero(turns == turn)
                part = np.append(max(part[0] - 1, 0), part)  # from the fold on
                look = {
                    "color": COLOURS[k % len(COLOURS)],
                    "linestyle": "--" if turn % 2 else "-",
                }
                name = name_of(header).removeprefix(start) if turn == 0 else None
                values = np.asarray(columns[header])[part]
                curve = Curve(name, p[part], values, look)
                panels.setdefault(LABELS[unit_in(header)], []).append(curve)
    curves_plot(path, panels, headers[1].removesuffix(" [1]"), title)


def varies(curves: Iterable[Array]) -> bool:
    """Return whether one of several columns changes by more than rounding."""
    for values in curves:
        known = values[np.isfinite(values)]
        if known.size and np.ptp(known) > FLAT * np.abs(known).max():
            return True
    return False


def groups_of(names: list[str]) -> list[tuple[str, ...]]:
    """Return the fields to plot in groups that share an axis: temperatures, else all
    others one by one.
    """
    groups = [tuple(name for name in pair if name in names) for pair in PAIRS]
    return next(([group] for group in groups if group), [(name,) for name in names])


def phase_of(name: str) -> str:
    """Return the phase of a field by its name, "other" where it has none."""
    return next(
        (phase for phase in ("fluid", "solid") if name.endswith(phase)), "other"
    )


def _group_label(group: tuple[str, ...]) -> str:
    """Return the axis label of fields that share an axis."""
    symbols = ", ".join(f"${FIELDS[name].symbol}$" for name in group)
    return labelled(symbols, FIELDS[group[0]].unit)
