"""Plot of named values over time, such as what leaves a bed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from contbed.arrays import Array
from contbed.fields import name_of
from contbed.output.plots import plain_ticks, styled_figure

COLOURS = (
    "#D55E00",
    "#0072B2",
    "#009E73",
    "#000000",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#999999",
)
FLAT = 1e-9  # range over the largest value below which a curve is left out
LABELS = {"K": "$T$ [K]", "1": "mole fraction [1]"}


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
    panels: dict[str, dict[str, Array]] = {}
    for header, values in columns.items():
        known = values[np.isfinite(values)]
        if (
            header != "t [s]"
            and known.size
            and np.ptp(known) > FLAT * np.abs(known).max()
        ):
            panels.setdefault(header.rpartition("[")[2].rstrip("]"), {})[
                name_of(header)
            ] = values
    if not panels:
        return
    t = columns["t [s]"]
    with styled_figure(path, 1.0 + 2.6 * len(panels), title) as figure:
        every = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (unit, curves) in zip(every, panels.items(), strict=True):
            for k, (name, values) in enumerate(curves.items()):
                axes.plot(t, values, color=COLOURS[k % len(COLOURS)], label=name)
            axes.set_ylabel(LABELS.get(unit, f"[{unit}]"))
            axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
            axes.margins(x=0)
            plain_ticks(axes)
        every[-1].set_xlabel("$t$ [s]")
