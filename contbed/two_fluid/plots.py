"""The picture of a two-fluid run: pressure drop over time, and profiles along and across the bed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from contbed.output.plots import _figure

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
    with _figure(path, 2.4 + 2.3 * len(tables), title) as figure:
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


def developed_plot(path: Path | str, columns: Mapping[str, Any], title: str = "") -> None:
    """Write the profiles of a fully developed flow across its section, under the headers of profiles.csv."""
    panels = [("u_gas [m/s]", "u_solid [m/s]"), ("eps_s [1]",), ("theta [m2/s2]",)]
    panels = [tuple(name for name in names if name in columns) for names in panels]
    panels = [names for names in panels if names]
    r = 1e3 * columns["r [m]"]
    with _figure(path, 3.2, title, width=1.5 + 2.5 * len(panels)) as figure:
        for axes, names in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
            for name in names:
                solid = name != "u_gas [m/s]"
                axes.plot(
                    r,
                    columns[name],
                    color="#D55E00" if solid else "#0072B2",
                    linewidth=1.2,
                    label="particles" if solid else "gas",
                )
            if len(names) > 1:
                axes.legend()
            label = "u [m/s]" if names[0].startswith("u_") else names[0].replace("_", " ")
            axes.set(xlabel="r [mm]", ylabel=label)
            axes.margins(x=0)
