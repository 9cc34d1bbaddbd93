"""Particles as points of a VTU file, for ParaView's glyphs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from contbed.output.files import atomic
from contbed.output.plots import plot_profiles_and_fields as plot

__all__ = ["history_plot", "plot", "write_particles"]


def write_particles(path: Path | str, x: NDArray, columns: Mapping[str, NDArray]) -> None:
    """Write centres (n, 3) and columns of shape (n,) or (n, 3)."""
    grid = meshio.Mesh(x, [("vertex", np.arange(len(x))[:, None])], dict(columns))
    with atomic(path) as temporary:
        meshio.write(temporary, grid, file_format="vtu")


def history_plot(path: Path | str, columns: Mapping[str, NDArray], title: str = "") -> None:
    """Pressure drop, height, coordination and temperatures over time, one below the other.

    Parameters
    ----------
    path : PNG file
    columns : values by header, as in profiles.csv, time first
    title : text above the picture
    """
    from contbed.fields import FIELDS, name_of
    from contbed.output.plots import styled_figure

    values = {name_of(key): column for key, column in columns.items()}
    t = values.pop("t")
    groups = [[name] for name in values if not name.startswith("T_")]
    if "T_solid" in values:
        groups.append(["T_fluid", "T_solid"])
    with styled_figure(path, 0.8 + 1.6 * len(groups), title) as figure:
        panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
        for axes, group in zip(panels, groups, strict=True):
            for name, colour in zip(group, ("#0072B2", "#D55E00"), strict=False):
                axes.plot(t, values[name], color=colour, label=FIELDS[name].label)
            axes.set_ylabel(FIELDS[group[0]].label)
            axes.margins(x=0)
            if len(group) > 1:
                axes.set_ylabel("$T$ [K]")
                axes.legend()
        panels[-1].set_xlabel(FIELDS["t"].label)
