"""The picture of a bubbling bed: temperature of every phase over the height, and radiation beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import name_of
from contbed.output.plots import _figure

# Okabe and Ito's colours without yellow
COLOURS = ("#D55E00", "#009E73", "#000000", "#CC79A7", "#E69F00")
GASES = {"emulsion": "#0072B2", "bubble": "#56B4E9"}


def branch_plot(path: Path | str, columns: Mapping[str, Any], title: str = "") -> None:
    """Mean temperatures of the species along a branch; what lies between two folds, unstable, is dashed.

    Parameters
    ----------
    path : PNG file
    columns : as in continuation.csv: point, parameter, turns, temperatures, duties
    title : text above the picture
    """
    headers = list(columns)
    p, turns = np.asarray(columns[headers[1]]), np.asarray(columns["turns [1]"])
    with _figure(path, 4.2, title) as figure:
        axes = figure.subplots()
        for k, header in enumerate(header for header in headers if header.startswith("T_")):
            T = np.asarray(columns[header])
            for turn in np.unique(turns):
                part = np.flatnonzero(turns == turn)
                part = np.append(part, min(part[-1] + 1, len(p) - 1))
                axes.plot(p[part], T[part], color=COLOURS[k % len(COLOURS)], linestyle="--" if turn % 2 else "-",
                          label=name_of(header).removeprefix("T_") if turn == 0 else None)  # fmt: skip
        axes.set(xlabel=name_of(headers[1]), ylabel="mean temperature [K]")
        figure.legend(loc="outside lower center", ncols=5)


def bubbling_plot(path: Path | str, columns: Mapping[str, Any], title: str = "") -> None:
    """Height upward; gases dashed.

    Parameters
    ----------
    path : PNG file
    columns : values by header, as in profiles.csv, the height first
    title : text above the picture
    """
    values = {name_of(header): np.asarray(column) for header, column in columns.items()}
    z = values.pop("z")
    radiation = [name for name in ("G", "q_radiation") if name in values]
    with _figure(path, 5.2, title) as figure:
        panels = figure.subplots(1, 1 + len(radiation), sharey=True, squeeze=False,
                                 width_ratios=[2.2] + [1.0] * len(radiation))[0]  # fmt: skip
        species = [name for name in values if name.startswith("T_") and name.removeprefix("T_") not in GASES]
        for k, name in enumerate(species):
            # the first are the widest, so that equal temperatures show
            panels[0].plot(values[name], z, color=COLOURS[k % len(COLOURS)], label=name.removeprefix("T_"),
                           linewidth=max(1.2, 4.0 - 1.2 * k))  # fmt: skip
        for gas, colour in GASES.items():
            if f"T_{gas}" in values:
                panels[0].plot(values[f"T_{gas}"], z, color=colour, linestyle=(0, (4, 2)), label=f"{gas} gas")
        panels[0].set(xlabel="temperature [K]", ylabel="height above the distributor [m]")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=min(6, len(values)))
        labels = {"G": "$G$ [kW/m$^2$]", "q_radiation": "$q_r$ [kW/m$^2$]"}
        for axes, name in zip(panels[1:], radiation, strict=True):
            axes.plot(1e-3 * values[name], z, color="#D55E00")
            axes.set_xlabel(labels[name])
        for axes in panels:
            axes.set_ylim(z[0], z[-1])
