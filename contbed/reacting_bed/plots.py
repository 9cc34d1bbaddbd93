"""Plots of a reacting bed: temperatures, gas, solids and pressure along it, on one
page.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contbed.fields import name_of
from contbed.output.colours import COLOURS
from contbed.output.curves import (
    Curve,
    branch_plot,
    curves_plot,
    history_plot,
    varies,
)
from contbed.result import Result

STYLES = ("-", "--", ":", "-.")
PANELS = (
    ("T_", "T [K]"),
    ("x_", "mole fraction"),
    ("w_", "mass fraction of solids"),
    ("q_", "loading [mol/kg]"),
    ("p_gas", "p [Pa]"),
)


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
            ("T_", "x_"),
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
    panels: dict[str, list[Curve]] = {}
    for start, label in PANELS:
        names = [name for name in columns if name.startswith(start)]
        if not varies(columns[name] for name in names):
            continue
        looks = looks_of(names, list(result.plan.scene.solids))
        panels[label] = [
            Curve(
                name.split("_", 1)[1],
                x,
                columns[name],
                {"color": colour, "linestyle": style},
            )
            for name, (colour, style) in zip(names, looks, strict=True)
        ]
    curves_plot(folder / "profiles.png", panels, "$x$ [m]", result.plan.scene.title, 2)


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
