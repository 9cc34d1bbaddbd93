"""Figures of the studies: one style, one palette, labels with units from
`contbed.fields`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import FIELDS

# Okabe and Ito's colours, told apart with any colour vision
BLUE, VERMILION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
PURPLE, SKY, BLACK, GREY, YELLOW = "#CC79A7", "#56B4E9", "#222222", "#999999", "#F0E442"
PALETTE = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK)
PANEL = (4.2, 3.9)  # width and height of a panel [inches]
DPI = 150
STYLE: dict[Any, Any] = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.labelsize": 10,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": f"cycler('color', {list(PALETTE)})",
    "axes.formatter.use_mathtext": True,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.5,
    "lines.markersize": 4,
    "image.cmap": "viridis",
}


def figure(
    rows: int = 1,
    columns: int = 1,
    size: tuple[float, float] | None = None,
    **options: Any,
) -> tuple[Any, Any]:
    """A figure and its axes, shaped as matplotlib's `subplots` returns them.

    Parameters
    ----------
    size : width and height of the whole figure [inches]; by default PANEL for each
        panel
    options : of `Figure.subplots`, such as sharey or width_ratios
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    whole = Figure(
        figsize=size or (columns * PANEL[0], rows * PANEL[1]), layout="constrained"
    )
    FigureCanvasAgg(whole)
    return whole, whole.subplots(rows, columns, **options)


def save(figures: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write figures by name as PNG."""
    paths = [folder / f"{name}.png" for name in figures]
    for path, each in zip(paths, figures.values(), strict=True):
        each.savefig(path, dpi=DPI)
    return paths


def label(name: str) -> str:
    """Axis label of a field, symbol and unit."""
    return FIELDS[name].label


def shades(
    count: int, name: str = "viridis", first: float = 0.0, last: float = 0.85
) -> Any:
    """Colours of a sequence of curves."""
    from matplotlib import colormaps

    return colormaps[name](np.linspace(first, last, count))


def label_line(
    axes: Any,
    text: str,
    x: float,
    y: float,
    colour: Any,
    shift: tuple[float, float] = (6, 0),
) -> None:
    """Name a curve beside one of its points; `shift` is in points."""
    axes.annotate(
        text,
        (x, y),
        shift,
        textcoords="offset points",
        va="center",
        color=colour,
        fontsize=9,
    )


def order_line(axes: Any, x: Sequence[float], start: float, order: float) -> None:
    """A grey dashed line of the slope -order through (x[0], start)."""
    along = np.asarray(x, dtype=float)
    values = start * (along[0] / along) ** order
    axes.loglog(along, values, color="grey", linestyle=(0, (4, 2)), linewidth=1)
    label_line(axes, f"order {order:g}", along[-1], values[-1], "grey", (3, 5))


def ticks(axes: Any, x: Sequence[float] = (), y: Sequence[float] = ()) -> None:
    """Ticks at these numbers alone, written plainly."""
    if len(x):
        axes.set_xticks(x, [f"{value:g}" for value in x])
    if len(y):
        axes.set_yticks(y, [f"{value:g}" for value in y])
    axes.minorticks_off()
