"""The bubbling bed with frozen closures at four levels of radiation, beside
collocation.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
LEVELS = {
    "none": ("no radiation", gallery.GREY),
    "paper_closure": ("paper's closure", gallery.ORANGE),
    "two_flux": ("two-flux", gallery.BLUE),
    "p1": ("P1", gallery.VERMILION),
}
CELLS = (8, 16, 32, 64, 128)
DEGREES = {1: gallery.ORANGE, 2: gallery.GREEN, 3: gallery.BLUE}
PANELS = {"T_char [K]": "char", "T_inert [K]": "inert", "T_bubble [K]": "bubble gas"}
NOT_COMPARED = ("largest error of a temperature [K]",)


def reference() -> dict[str, dict[str, float]]:
    """Named results of each scene by collocation (collocation.py)."""
    table = Table.read(HERE / "reference.csv")
    return {
        level: dict(zip(table["result"], table[level], strict=True)) for level in LEVELS
    }


def errors(qoi: dict[str, float], exact: dict[str, float]) -> tuple[float, float]:
    """Largest error of a temperature [K], and of a duty relative to itself."""
    kelvin = max(
        abs(qoi[name] - value) for name, value in exact.items() if name.endswith("_K")
    )
    return kelvin, max(
        abs(qoi[name] / value - 1)
        for name, value in exact.items()
        if name.endswith("_W") and value
    )


def compute() -> Tables:
    """Named results and profiles of all scenes, and the errors of P1 over cells and
    degree.
    """
    exact, results = (
        reference(),
        {name: cb.run(cb.load(HERE / f"{name}.toml")) for name in LEVELS},
    )
    for name, result in results.items():
        kelvin, share = errors(result.qoi, exact[name])
        print(f"{name:14} largest error {kelvin:.1e} K, {share:.1e} of a duty")
    rows = [
        [key, *(results[name].qoi[key] for name in LEVELS)] for key in results["p1"].qoi
    ]
    profiles: list[tuple[Any, ...]] = []
    for name, result in results.items():
        columns = result.profiles
        G = columns.get("G [W/m2]", [None] * len(columns["z [m]"]))
        profiles += [
            (name, *row)
            for row in zip(
                columns["z [m]"], *(columns[key] for key in PANELS), G, strict=True
            )
        ]
    places = {
        "level": "",
        "z [m]": ".5g",
        **dict.fromkeys(PANELS, ".7g"),
        "G [W/m2]": ".6g",
    }
    return {
        "results": Table({"result": "", **dict.fromkeys(LEVELS, ".9g")}, rows),
        "profiles": Table(places, profiles[::3]),
        "convergence": convergence(exact["p1"]),
    }


def convergence(exact: dict[str, float]) -> Table:
    """Largest error of a temperature over the number of cells, with P1 and each
    degree.
    """
    rows = []
    for degree in DEGREES:
        for cells in CELLS:
            scene = cb.load(
                HERE / "p1.toml", {"mesh.cells": cells, "solver.degree": degree}
            )
            rows.append((degree, cells, errors(cb.run(scene).qoi, exact)[0]))
    return Table({"degree": "d", "cells": "d", NOT_COMPARED[0]: ".3e"}, rows)


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures over the height for all levels; errors over the number of cells."""
    return {
        "profiles": plot_profiles(tables["profiles"]),
        "convergence": plot_errors(tables["convergence"]),
    }


def plot_profiles(profiles: Table) -> Any:
    """Temperatures over the height for all levels, and what happens in the lowest
    centimetre.
    """
    figure, axes = gallery.figure(1, 4, size=(11, 4.6), width_ratios=[1, 1, 1, 1.1])
    for name, (text, colour) in LEVELS.items():
        found = profiles.where({"level": name})
        for panel, header in zip(axes, PANELS, strict=False):
            panel.plot(found[header], found["z [m]"], color=colour, label=text)
        axes[3].semilogy(
            1e-3 * found["G [W/m2]"],
            1e3 * np.maximum(found["z [m]"], 1e-9),
            color=colour,
        )
    for panel, what in zip(axes, PANELS.values(), strict=False):
        panel.set(title=what, xlabel="temperature [K]", ylim=(0, 0.6))
    axes[0].set_ylabel("height above the distributor [m]")
    axes[3].set(
        title="incident radiation",
        xlabel="$G$ [kW/m$^2$]",
        ylabel="height [mm]",
        ylim=(1e-2, 600),
    )
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4
    )
    return figure


def plot_errors(table: Table) -> Any:
    """Largest error of a temperature over the number of cells."""
    figure, axes = gallery.figure(1, 1, size=(6, 4.4))
    for degree, colour in DEGREES.items():
        found = table.where({"degree": degree})
        axes.loglog(
            found["cells"],
            found[NOT_COMPARED[0]],
            "o-",
            color=colour,
            label=f"degree {degree}",
        )
    axes.set(xlabel="cells", ylabel=NOT_COMPARED[0], title="P1 against collocation")
    gallery.ticks(axes, x=CELLS)
    axes.grid(which="major", linewidth=0.3)
    axes.legend()
    return figure
