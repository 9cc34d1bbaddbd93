"""The picture of a two-fluid run: pressure drop over time, and profiles along and
across the bed.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.fields import field, name_of
from contbed.output.maps import cell_maps
from contbed.output.plots import styled_figure
from contbed.output.stored import read_fields, read_series
from contbed.result import Result

_MAPS = ("eps_s", "T_gas", "T_solid")
_PANELS = ("eps_s [1]", "u_solid [m/s]", "theta [m2/s2]")


def two_fluid_plot(
    path: Path | str,
    rows: Mapping[str, Any],
    tables: Mapping[str, Mapping[str, Any]],
    title: str = "",
) -> None:
    """Write the picture.

    Parameters
    ----------
    path : PNG file
    rows : columns over time, with "t [s]"
    tables : "axial" and, for more than a line, "lateral", as in the files of these
        names, and "bubbles"; "spectrum" is left out
    """
    tables = {name: table for name, table in tables.items() if name != "spectrum"}
    with styled_figure(path, 2.4 + 2.3 * len(tables), title) as figure:
        panels = figure.subplots(1 + len(tables), 3, squeeze=False)
        for axes, name in zip(
            panels[0],
            ("pressure_drop [Pa]", "centre_of_solids [m]", "theta_mean [m2/s2]"),
            strict=True,
        ):
            # the first pressure is that of fields that have not met yet
            axes.plot(rows["t [s]"][1:], rows[name][1:], color="#0072B2", linewidth=1)
            axes.set(xlabel=_label("t [s]"), ylabel=_label(name))
            axes.margins(x=0)
        for line, table in zip(panels[1:], tables.values(), strict=True):
            coordinate, *others = table
            shown = _PANELS if _PANELS[0] in table else others
            for axes, name in zip(line, shown, strict=True):
                axes.plot(table[coordinate], table[name], color="#D55E00", linewidth=1)
                if name.startswith("theta") and "theta_total [m2/s2]" in table:
                    axes.plot(
                        table[coordinate],
                        table["theta_total [m2/s2]"],
                        color="#000000",
                        linestyle="--",
                        linewidth=1,
                        label="with resolved motion",
                    )
                    axes.legend(
                        loc="upper left", bbox_to_anchor=(0.0, 1.18), fontsize="x-small"
                    )
                axes.set(xlabel=_label(coordinate), ylabel=_label(name))
                axes.margins(x=0)


def _label(header: str) -> str:
    """Return symbol and unit of a column."""
    found = field(name_of(header))
    return found.label if found is not None else header


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png, and fields.png of a plane or a box from its last file of
    fields.
    """
    title = result.plan.scene.title
    two_fluid_plot(folder / "profiles.png", result.profiles, result.tables, title)
    series = folder / "fields.pvd"
    stored = read_series(series) if series.is_file() else []
    if stored and result.plan.mesh.skfem.dim() > 1:
        time, file = stored[-1]
        fields_plot(folder / "fields.png", file, time, title)


def fields_plot(path: Path, file: Path, time: float, title: str = "") -> None:
    """Draw the solids volume fraction, and both temperatures where there are some, at
    the last time.

    Cells of a box are those that its middle plane cuts.

    Parameters
    ----------
    path : PNG file
    file : of fields
    time : of these fields [s]
    title : text above the picture
    """
    stored = read_fields(file)
    corners = stored.points[stored.cells[0].data]
    fields = {
        name: values[0] for name, values in stored.cell_data.items() if name in _MAPS
    }
    extent = np.ptp(stored.points, axis=0)
    thin = int(np.argmin(extent))
    first, second = (k for k in range(3) if k != thin)
    middle = 0.5 * (stored.points[:, thin].min() + stored.points[:, thin].max())
    if extent[thin] > 0.0:
        cut = (corners[:, :, thin].min(axis=1) <= middle) & (
            corners[:, :, thin].max(axis=1) > middle
        )
        corners, fields = (
            corners[cut],
            {name: values[cut] for name, values in fields.items()},
        )
        title = f"{title}   {'xyz'[thin]} = {middle:.4g} m".strip()
    flat = _around(corners[:, :, [first, second]])
    shown = {name: fields[name] for name in _MAPS if name in fields}
    cell_maps(
        path,
        flat,
        shown,
        ("xyz"[first], "xyz"[second]),
        f"{title}   t = {time:.4g} s".strip(),
    )


def _around(corners: Array) -> Array:
    """Return the corners of cells (cells, corners, 2) in order around the middle of
    each.
    """
    from_middle = corners - corners.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(from_middle[..., 1], from_middle[..., 0]), axis=1)
    return np.take_along_axis(corners, order[..., None], axis=1)
