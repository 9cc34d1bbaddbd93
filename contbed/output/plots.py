"""Figures in the common style, and errors on logarithmic axes."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.output.files import atomic

WIDTH = 8.0  # inches, 1600 pixels
DPI = 200
# of PNG: lines on white get no smaller by more, which takes three times as long
_COMPRESSION = 2
_NOISE = 1e-6  # relative range below which a field counts as constant
_STYLE: dict[Any, Any] = {
    "font.size": 11,
    "axes.titlesize": 11,
    "axes.labelsize": 12,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.use_mathtext": True,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.8,
    "legend.frameon": False,
    "figure.titlesize": 12,
    "image.cmap": "viridis",
}


@contextmanager
def styled_figure(
    path: Path | str,
    height: float,
    title: str,
    width: float | None = None,
) -> Iterator[Any]:
    """Yield a figure in the common style, saved as PNG when the block ends."""
    matplotlib = _matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        figure = Figure(figsize=(width or WIDTH, height), dpi=DPI, layout="constrained")
        FigureCanvasAgg(figure)
        if title:
            # a dollar in a title is a dollar, not the start of a formula
            figure.suptitle(title, parse_math=False, wrap=True)
        yield figure
        with atomic(path) as temporary:
            figure.savefig(
                temporary,
                format="png",
                pil_kwargs={"compress_level": _COMPRESSION},
            )


def _matplotlib() -> Any:
    """Import matplotlib; ignore a backend in MPLBACKEND that does not exist, because
    only files are written.
    """
    if "matplotlib" in sys.modules:
        return sys.modules["matplotlib"]
    named = os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib
    finally:
        if named is not None:
            os.environ["MPLBACKEND"] = named
    if named is not None:
        with suppress(ValueError):
            matplotlib.rcParams["backend"] = named
    return matplotlib


def shown_range(values: Sequence[Array]) -> tuple[float, float]:
    """Return the range of values, widened for a field that is constant except for
    solver noise.
    """
    low = min(float(np.nanmin(v)) for v in values)
    high = max(float(np.nanmax(v)) for v in values)
    if high - low <= _NOISE * max(abs(low), abs(high)):
        spread = 0.05 * abs(low) or 1.0
        return low - spread, high + spread
    return low, high


def error_plot(
    path: Path | str,
    curves: Mapping[str, Any],
    x_label: str,
    y_label: str,
    title: str = "",
) -> None:
    """Plot errors on logarithmic axes, one line for each (x, error) in `curves`;
    only positive values.
    """
    with styled_figure(path, 5.0, title) as figure:
        axes = figure.subplots()
        for (label, (x, error)), marker in zip(
            curves.items(), itertools.cycle("osD^vPX<>"), strict=False
        ):
            x, error = np.asarray(x, dtype=float), np.asarray(error, dtype=float)
            shown = error > 0
            axes.loglog(
                x[shown],
                error[shown],
                marker=marker,
                markersize=5,
                linewidth=1.2,
                label=label,
            )
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        axes.grid(which="major", linewidth=0.3)
        if len(curves) > 1:
            figure.legend(loc="outside lower center", ncols=3, fontsize=9)
