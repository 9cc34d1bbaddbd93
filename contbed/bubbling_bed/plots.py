"""Plots of a bubbling bed: one page of profiles and heat flows, and branches of
steady states.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import FIELDS, name_of
from contbed.output.curves import branch_plot
from contbed.output.plots import styled_figure
from contbed.result import Result

# Okabe and Ito's colours without yellow
COLOURS = ("#D55E00", "#009E73", "#000000", "#CC79A7", "#E69F00", "#56B4E9", "#0072B2")

Panel = tuple[Any, float]  # the function that draws it, and its relative width
WIDEST = 5.0  # sum of the widths of panels in one row

_BUBBLES = {"d_b": "#009E73", "delta": "#CC79A7", "u_b": "#E69F00"}


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png, and continuation.png where steady states were followed."""
    title = result.plan.scene.title
    bubbling_plot(folder / "profiles.png", result.profiles, title, result.qoi)
    if "continuation" in result.tables:
        table = result.tables["continuation"]
        branch_plot(folder / "continuation.png", table, ("T_",), title)


def bubbling_plot(
    path: Path | str,
    columns: Mapping[str, Any],
    title: str = "",
    results: Mapping[str, Any] | None = None,
) -> None:
    """Plot temperatures of all phases, radiation, bubbles and gases over the height,
    and heat flows, on one page.

    Quantities that the run did not solve for are left out.

    Parameters
    ----------
    path : PNG file
    columns : values by header, as in profiles.csv, the height first
    title : text above the picture
    results : named results; those in W are drawn as heat flows
    """
    values = {name_of(header): np.asarray(column) for header, column in columns.items()}
    z = values.pop("z")
    flows = {
        name: value
        for name, value in (results or {}).items()
        if name.endswith("_W") and value and not name.endswith("_water_W")
    }
    panels: list[Panel] = [(_temperatures, 2.0)]
    panels += [(_radiation, 1.0)] if "G" in values else []
    panels += [(partial(_single, name), 0.7) for name in _BUBBLES if name in values]
    panels += [(_gases, 1.3)] if any(name.startswith("x_") for name in values) else []
    panels += [(_heat, 1.5)] if flows else []
    rows = _rows(panels)
    across = max(sum(width for _, width in row) for row in rows)
    width, height = max(7.0, 2.6 * across), 5.6 if len(rows) == 1 else 8.4
    with styled_figure(path, height, title, width=width) as figure:
        parts = figure.subfigures(len(rows), 1, squeeze=False)[:, 0]
        for part, row in zip(parts, rows, strict=True):
            axes = part.subplots(
                1, len(row), squeeze=False, width_ratios=[width for _, width in row]
            )[0]
            for panel, (draw, _) in zip(axes, row, strict=True):
                if draw is _heat:
                    _heat(panel, flows)
                    continue
                draw(panel, z, values)
                panel.set_ylim(z[0], z[-1])
            axes[0].set_ylabel("height above the distributor [m]")


def _rows(panels: list[Panel]) -> list[list[Panel]]:
    """Return the panels in one row, or in two where one would be too wide to read."""
    if sum(width for _, width in panels) <= WIDEST:
        return [panels]
    half = -(-len(panels) // 2)
    return [panels[:half], panels[half:]]


def _temperatures(axes: Any, z: Any, values: Mapping[str, Any]) -> None:
    """Plot solids, the first with the widest line so that equal temperatures show;
    gases are dashed.
    """
    dashed = {
        "T_emulsion": "emulsion gas",
        "T_bubble": "bubble gas",
        "T_freeboard": "freeboard gas",
    }
    colours = dict(zip(dashed, ("#0072B2", "#56B4E9", "#0072B2"), strict=True))
    others = {"T_up": "rising particles", "T_down": "falling particles"}
    k = 0
    for name in (name for name in values if name.startswith("T_")):
        if name in dashed:
            axes.plot(
                values[name],
                z,
                color=colours[name],
                linestyle=(0, (4, 2)),
                label=dashed[name],
            )
        else:
            axes.plot(
                values[name],
                z,
                color=COLOURS[k % len(COLOURS)],
                linewidth=max(1.2, 4.0 - 1.2 * k),
                label=others.get(name, name.removeprefix("T_").replace("_", " ")),
            )
            k += 1
    axes.set_xlabel("temperature [K]")
    axes.legend(frameon=False, fontsize=8)


def _radiation(axes: Any, z: Any, values: Mapping[str, Any]) -> None:
    for name, label, colour in (
        ("G", "$G$", "#D55E00"),
        ("G_freeboard", None, "#D55E00"),
        ("q_radiation", "$q_r$", "#000000"),
    ):
        if name in values:
            axes.plot(1e-3 * values[name], z, color=colour, label=label)
    axes.set_xlabel("radiation [kW/m$^2$]")
    axes.legend(frameon=False, fontsize=8)


def _single(name: str, axes: Any, z: Any, values: Mapping[str, Any]) -> None:
    """Plot one quantity of the bubbles, as each has a unit of its own."""
    axes.plot(values[name], z, color=_BUBBLES[name])
    axes.set_xlabel(f"bubbles: {FIELDS[name].label}")


def _gases(axes: Any, z: Any, values: Mapping[str, Any]) -> None:
    """Plot mole fractions except nitrogen's; those in bubbles are dashed."""
    names = [
        name
        for name in values
        if name.startswith("x_") and not name.startswith("x_N2_")
    ]
    colours: dict[str, str] = {}
    for name in names:
        gas, _, phase = name.removeprefix("x_").rpartition("_")
        if np.nanmax(values[name]) < 1e-3:
            continue
        colour = colours.setdefault(gas, COLOURS[len(colours) % len(COLOURS)])
        axes.plot(
            values[name],
            z,
            color=colour,
            linestyle="--" if phase == "bubble" else "-",
            label=gas if phase == "emulsion" else None,
        )
    axes.set_xlabel("mole fraction (bubbles dashed)")
    axes.legend(frameon=False, fontsize=8)


def _heat(axes: Any, flows: Mapping[str, float]) -> None:
    names = list(flows)[::-1]
    colours = ["#D55E00" if name.startswith("release") else "#0072B2" for name in names]
    axes.barh(
        [name.removesuffix("_W").replace("_", " ") for name in names],
        [1e-3 * flows[name] for name in names],
        color=colours,
    )
    axes.tick_params(axis="y", labelsize=7)
    axes.axvline(0.0, color="black", linewidth=0.6)
    axes.set_xlabel("heat [kW], released or taken out")
