"""Plots of a reacting bed: temperatures, gas, solids and pressure along it, on one
page.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import name_of
from contbed.output.history_plot import history_plot
from contbed.output.plots import plain_ticks, styled_figure
from contbed.result import Result

COLOURS = (
    "#D55E00",
    "#009E73",
    "#000000",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#0072B2",
    "#999999",
)
STYLES = ("-", "--", ":", "-.")
PANELS = (
    ("T_", "T [K]"),
    ("x_", "mole fraction"),
    ("w_", "mass fraction of solids"),
    ("q_", "loading [mol/kg]"),
    ("p_gas", "p [Pa]"),
)
FLAT = 1e-9  # relative range below which a panel is left out


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png, outlet.png of a run over time, and continuation.png where
    steady states were followed.
    """
    if "outlet" in result.tables:
        history_plot(
            folder / "outlet.png", result.tables["outlet"], result.plan.scene.title
        )
    if "continuation" in result.tables:
        branch_plot(
            folder / "continuation.png",
            result.tables["continuation"],
            result.plan.scene.title,
        )
    columns = {
        name_of(header): np.asarray(values)
        for header, values in result.profiles.items()
    }
    if "t" in columns:  # the last of the output times
        last = columns["t"] == columns["t"].max()
        columns = {
            name: values[last] for name, values in columns.items() if name != "t"
        }
    x = columns.pop("x")
    panels = []
    for start, label in PANELS:
        found = {
            name: values for name, values in columns.items() if name.startswith(start)
        }
        if any(
            np.ptp(values) > FLAT * np.abs(values).max() for values in found.values()
        ):
            panels.append((found, label))
    if not panels:
        return
    rows = (len(panels) + 1) // 2
    with styled_figure(
        folder / "profiles.png", 0.6 + 2.5 * rows, result.plan.scene.title
    ) as figure:
        every = figure.subplots(rows, min(len(panels), 2), squeeze=False).ravel()
        for spare in every[len(panels) :]:
            spare.remove()
        for axes, (found, label) in zip(every[: len(panels)], panels, strict=True):
            looks = looks_of(list(found), list(result.plan.scene.solids))
            for (name, values), (colour, style) in zip(
                found.items(), looks, strict=True
            ):
                axes.plot(x, values, style, color=colour, label=name.split("_", 1)[1])
            axes.set_ylabel(label)
            axes.margins(x=0)
            plain_ticks(axes)
            axes.set_xlabel("$x$ [m]")
            if len(found) > 1:
                axes.legend(fontsize=8, ncols=2)


def looks_of(names: list[str], kinds: list[str]) -> list[tuple[str, str]]:
    """Return colour and style of each line: a colour for each constituent, a style
    for each solid phase.
    """
    parts = [name.split("_") for name in names]
    there = [
        next((part for part in reversed(each) if part in kinds), None) for each in parts
    ]
    alone = [
        tuple(part for part in each if part != kind)
        for each, kind in zip(parts, there, strict=True)
    ]
    order = list(dict.fromkeys(alone))
    looks = []
    for name, kind, without in zip(names, there, alone, strict=True):
        style = "-" if kind is None else STYLES[kinds.index(kind) % len(STYLES)]
        looks.append(
            (
                COLOURS[order.index(without) % len(COLOURS)],
                "--" if name == "T_fluid" else style,
            )
        )
    return looks


def branch_plot(path: Path, columns: Mapping[str, Any], title: str) -> None:
    """Plot the temperature and composition of the gas that leaves along a branch;
    between two folds dashed.
    """
    headers = list(columns)
    p, turns = np.asarray(columns[headers[1]]), np.asarray(columns["turns [1]"])
    shown = [header for header in headers[3:] if np.ptp(columns[header]) > FLAT]
    panels = [
        [header for header in shown if header.startswith(start)]
        for start in ("T_", "x_")
    ]
    panels = [panel for panel in panels if panel]
    with styled_figure(path, 1.0 + 2.4 * len(panels), title) as figure:
        for axes, panel in zip(
            figure.subplots(len(panels), 1, squeeze=False)[:, 0], panels, strict=True
        ):
            for k, header in enumerate(panel):
                for turn in np.unique(turns):
                    part = np.flatnonzero(turns == turn)
                    part = np.append(max(part[0] - 1, 0), part)  # from the fold on
                    label = header if turn == 0 else None
                    style = "--" if turn % 2 else "-"
                    axes.plot(
                        p[part],
                        np.asarray(columns[header])[part],
                        style,
                        color=COLOURS[k % 8],
                        label=label,
                    )
            axes.set_xlabel(headers[1].removesuffix(" [1]"))
            axes.legend(fontsize=8)
