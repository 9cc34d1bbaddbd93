"""The picture of a two-fluid run: pressure drop over time, and profiles along and across the bed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from contbed.output.plots import styled_figure
from contbed.result import Result

_PANELS = ("eps_s [1]", "u_solid [m/s]", "theta [m2/s2]")


def two_fluid_plot(
    path: Path | str, rows: Mapping[str, Any], tables: Mapping[str, Mapping[str, Any]], title: str = ""
) -> None:
    """Write the picture.

    Parameters
    ----------
    path : PNG file
    rows : columns over time, with "t [s]"
    tables : "axial" and, for more than a line, "lateral", as in the files of these names; "spectrum" is left out
    """
    tables = {name: table for name, table in tables.items() if name != "spectrum"}
    with styled_figure(path, 2.4 + 2.3 * len(tables), title) as figure:
        panels = figure.subplots(1 + len(tables), 3, squeeze=False)
        for axes, name in zip(
            panels[0], ("pressure_drop [Pa]", "centre_of_solids [m]", "theta_mean [m2/s2]"), strict=True
        ):
            # the first pressure is that of fields that have not met yet
            axes.plot(rows["t [s]"][1:], rows[name][1:], color="#0072B2", linewidth=1)
            axes.set(xlabel="t [s]", ylabel=name.replace("_", " "))
            axes.margins(x=0)
        for line, table in zip(panels[1:], tables.values(), strict=True):
            coordinate = next(iter(table))
            for axes, name in zip(line, _PANELS, strict=True):
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
                    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 1.18), fontsize="x-small")
                axes.set(xlabel=coordinate, ylabel=name.replace("_", " "))
                axes.margins(x=0)


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png."""
    two_fluid_plot(folder / "profiles.png", result.profiles, result.tables, result.plan.scene.title)
