"""Plots of a bubbling bed: profiles over its height, heat flows, and branches of
steady states.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import FIELDS, name_of
from contbed.output.colours import COLOURS
from contbed.output.curves import Curve, branch_plot, curves_plot
from contbed.output.plots import styled_figure
from contbed.result import Result

# gases are dashed, so that particles of the same temperature show
GASES = {
    "T_emulsion": "emulsion gas",
    "T_bubble": "bubble gas",
    "T_freeboard": "freeboard gas",
}
PARTICLES = {"T_up": "rising particles", "T_down": "falling particles"}
RADIATION = {
    "G": "$G$",
    "G_freeboard": "$G$ of the freeboard",
    "q_radiation": "$q_r$",
}
BUBBLES = ("d_b", "delta", "u_b")
SCARCE = 1e-3  # mole fraction that gases have somewhere to be shown


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png, heat.png, and continuation.png where steady states were
    followed.
    """
    title = result.plan.scene.title
    profiles_plot(folder / "profiles.png", result.profiles, title)
    heat_plot(folder / "heat.png", result.qoi, title)
    if "continuation" in result.tables:
        table = result.tables["continuation"]
        branch_plot(folder / "continuation.png", table, ("T_",), title)


def profiles_plot(
    path: Path | str, columns: Mapping[str, Any], title: str = ""
) -> None:
    """Plot temperatures of all phases, radiation, bubbles and gases over the height.

    Parameters
    ----------
    path : PNG file
    columns : values by header, as in profiles.csv
    title : text above the picture
    """
    values = {name_of(header): np.asarray(column) for header, column in columns.items()}
    z = values.pop("z")
    panels = {
        "temperature [K]": _temperatures(z, values),
        "radiation [kW/m$^2$]": [
            Curve(text, z, 1e-3 * values[name])
            for name, text in RADIATION.items()
            if name in values
        ],
    }
    for name in BUBBLES:
        if name in values:
            panels[f"bubbles: {FIELDS[name].label}"] = [Curve(None, z, values[name])]
    panels["mole fraction (bubbles dashed)"] = _gases(z, values)
    shown = {label: curves for label, curves in panels.items() if curves}
    curves_plot(path, shown, "height above the distributor [m]", title, 2)


def _temperatures(z: Any, values: Mapping[str, Any]) -> list[Curve]:
    texts = GASES | PARTICLES
    return [
        Curve(
            texts.get(name, name.removeprefix("T_").replace("_", " ")),
            z,
            values[name],
            {"linestyle": "--" if name in GASES else "-"},
        )
        for name in values
        if name.startswith("T_")
    ]


def _gases(z: Any, values: Mapping[str, Any]) -> list[Curve]:
    """Return the mole fractions of gases that are not scarce, except nitrogen's."""
    colours: dict[str, str] = {}
    curves = []
    for name, x in values.items():
        gas, _, phase = name.removeprefix("x_").rpartition("_")
        if not name.startswith("x_") or gas == "N2" or np.nanmax(x) < SCARCE:
            continue
        look = {
            "color": colours.setdefault(gas, COLOURS[len(colours) % len(COLOURS)]),
            "linestyle": "--" if phase == "bubble" else "-",
        }
        curves.append(Curve(gas if phase == "emulsion" else None, z, x, look))
    return curves


def heat_plot(path: Path | str, results: Mapping[str, Any], title: str = "") -> None:
    """Plot the heat that is released or taken out; nothing where there is none."""
    heats = {
        name.removesuffix("_W"): 1e-3 * value
        for name, value in reversed(list(results.items()))
        if name.endswith("_W") and value and not name.endswith("_water_W")
    }
    if not heats:
        return
    released = [name.startswith("release") for name in heats]
    with styled_figure(path, 4.7, title) as figure:
        axes = figure.subplots()
        axes.barh(
            [name.replace("_", " ") for name in heats],
            list(heats.values()),
            color=[COLOURS[0] if each else COLOURS[1] for each in released],
        )
        axes.axvline(0.0, color="black", linewidth=0.6)
        axes.set_xlabel("heat [kW], released or taken out")
