"""Plots of a reacting bed: temperatures, gas, solids and pressure along it, on one page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contbed.fields import name_of
from contbed.output.plots import plain_ticks, styled_figure
from contbed.result import Result

COLOURS = ("#D55E00", "#009E73", "#000000", "#CC79A7", "#E69F00", "#56B4E9", "#0072B2", "#999999")
PANELS = (("T_", "T [K]"), ("x_", "mole fraction"), ("w_", "mass fraction of solids"), ("p_gas", "p [Pa]"))
FLAT = 1e-9  # relative range below which a panel is left out


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png."""
    columns = {name_of(header): np.asarray(values) for header, values in result.profiles.items()}
    x = columns.pop("x")
    panels = []
    for start, label in PANELS:
        found = {name: values for name, values in columns.items() if name.startswith(start)}
        if any(np.ptp(values) > FLAT * np.abs(values).max() for values in found.values()):
            panels.append((found, label))
    if not panels:
        return
    with styled_figure(folder / "profiles.png", 1.0 + 2.2 * len(panels), result.plan.scene.title) as figure:
        every = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (found, label) in zip(every, panels, strict=True):
            for k, (name, values) in enumerate(found.items()):
                style = "--" if name == "T_fluid" else "-"
                axes.plot(x, values, style, color=COLOURS[k % len(COLOURS)], label=name.split("_", 1)[1])
            axes.set_ylabel(label)
            axes.margins(x=0)
            plain_ticks(axes)
            if len(found) > 1:
                axes.legend(fontsize=8, ncols=2)
        every[-1].set_xlabel("$x$ [m]")
