"""Pictures of particles in a gas: pressure drop, height, coordination and
temperatures over time, heat around tubes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from contbed.arrays import Array
from contbed.fields import FIELDS, field, header, name_of
from contbed.output.curves import Curve, curves_plot
from contbed.output.plots import styled_figure
from contbed.result import Result


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png, and tube_NAME.png for each tube."""
    title = result.plan.scene.title
    history_plot(folder / "profiles.png", result.profiles, title)
    for name, table in result.tables.items():
        if name.startswith("tube_"):
            tube_plot(folder / f"{name}.png", table, title)


def history_plot(
    path: Path | str, columns: Mapping[str, Array], title: str = ""
) -> None:
    """Draw pressure drop, height, coordination and temperatures over time, one below
    the other.

    Parameters
    ----------
    path : PNG file
    columns : values by header, as in profiles.csv, time first
    title : text above the picture
    """
    values = {name_of(key): column for key, column in columns.items()}
    t = values.pop("t")
    panels = {
        _label(name): [Curve(None, t, column)]
        for name, column in values.items()
        if not name.startswith("T_")
    }
    if "T_solid" in values:
        names = ("T_fluid", "T_solid")
        panels["$T$ [K]"] = [Curve(_label(name), t, values[name]) for name in names]
    curves_plot(path, panels, FIELDS["t"].label, title)


def tube_plot(path: Path | str, table: Mapping[str, Array], title: str = "") -> None:
    """Draw the heat transfer coefficients of a tube over the angle from its bottom, by
    mechanism, and the porosity.

    Parameters
    ----------
    path : PNG file
    table : columns by header, as in tube_NAME.csv
    title : text above the picture
    """
    angle = table["angle [deg]"]
    with styled_figure(path, 5.6, title) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        for name, text, colour in (
            ("h", "sum", "#000000"),
            ("h_gap", "gas between particles and tube", "#0072B2"),
            ("h_convection", "convection of the gas", "#009E73"),
            ("h_contact", "contacts", "#D55E00"),
        ):
            upper.plot(angle, table[header(name)], "o-", color=colour, label=text)
        # room for the legend above the curves
        upper.set(
            ylabel=FIELDS["h"].label, ylim=(0.0, 1.35 * float(table[header("h")].max()))
        )
        upper.legend(loc="upper center", ncols=2)
        lower.plot(angle, table[header("eps")], "o-", color="#0072B2")
        lower.set(
            ylabel=_label("eps"), xlabel=FIELDS["angle"].label, xticks=range(0, 361, 60)
        )


def _label(name: str) -> str:
    """Return the label of a column, "middle p" of a probe with the name of the probe
    before it.
    """
    found, probe = field(name), name.rpartition(" ")[0]
    assert found is not None, "every column is a field"
    return f"{probe} {found.label}".strip()
