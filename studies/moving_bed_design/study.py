"""Two sweeps over the moving-bed heater: a map of its design, and what uncertain
values leave open.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from contbed.many.sweep.plots import folded_label
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
SILICA_IN = 973.15
WITHIN = 10.0
DIAMETER, VELOCITY = (
    "solids.silica.diameter [m]",
    "boundary.top.solids.silica.velocity [m/s]",
)
STEAM, SILICA, HOT = (
    "T_fluid_out [K]",
    "T_solid_out [K]",
    "boundary.top.solids.silica.fixed_temperature [K]",
)
NOT_COMPARED = (
    "estimated_error [-]",
    "heat_bottom [W]",
    "heat_top [W]",
    "theta_overshoot [-]",
)


def reference() -> float:
    """Steam within WITHIN of the silica that enters [K]."""
    return SILICA_IN - WITHIN


def compute() -> Tables:
    """Both sweeps; prints what the README says."""
    tables = {
        name: gallery.swept(HERE / "sweeps" / f"{name}.toml")[0]
        for name in ("map", "uncertainty")
    }
    told(tables)
    return tables


def told(tables: Tables) -> None:
    """Print the slowest silica for each pebble size, and means, deviations and
    correlations.
    """
    table = tables["map"]
    for d in np.unique(table[DIAMETER]):
        close = (table[DIAMETER] == d) & (table[STEAM] > reference())
        slowest = np.abs(table[VELOCITY][close]).min(initial=np.inf)
        print(f"{1e3 * d:5.1f} mm: within {WITHIN:g} K from {1e3 * slowest:.2f} mm/s")
    steam, silica, hot, velocity = (
        tables["uncertainty"][name] for name in (STEAM, SILICA, HOT, VELOCITY)
    )
    for what, values, cause in (("steam", steam, hot), ("silica", silica, velocity)):
        correlation = np.corrcoef(values, cause)[0, 1]
        print(
            f"{what} {values.mean():.1f} K, deviation {values.std(ddof=1):.1f} K, "
            f"correlation {correlation:.3f}"
        )
    print(
        f"below the silica's inlet: mean {(hot - steam).mean():.1f} K, largest "
        f"{(hot - steam).max():.1f} K"
    )


def plot(tables: Tables) -> dict[str, Any]:
    """Outlet temperatures over pebble size and velocity, and over the five uncertain
    values.
    """
    return {
        "map": plot_map(tables["map"]),
        "uncertainty": plot_uncertainty(tables["uncertainty"]),
    }


def plot_map(table: Table) -> Any:
    """Contours of both outlet temperatures; the line is where the steam comes within
    WITHIN of the silica.
    """
    figure, panels = gallery.figure(1, 2, size=(9, 4), sharey=True)
    x, y = (np.unique(table[name]) for name in (DIAMETER, VELOCITY))
    place = np.searchsorted(y, table[VELOCITY]), np.searchsorted(x, table[DIAMETER])
    for axes, (name, title) in zip(
        panels, ((STEAM, "steam"), (SILICA, "silica")), strict=True
    ):
        grid = np.full((len(y), len(x)), np.nan)
        grid[place] = table[name]
        filled = axes.contourf(1e3 * x, 1e3 * y, grid, levels=12, cmap="inferno")
        figure.colorbar(filled, ax=axes, label=f"{title} at its outlet [K]")
        axes.set(xscale="log", xlabel="pebbles [mm]")
        gallery.ticks(axes, x=(4, 8, 16, 32))
        if name == STEAM:
            axes.contour(1e3 * x, 1e3 * y, grid, levels=[reference()], colors="white")
    panels[0].set_ylabel("solid velocity [mm/s]")
    return figure


def plot_uncertainty(table: Table) -> Any:
    """Both outlet temperatures over each uncertain value."""
    names = table.columns[: table.columns.index(NOT_COMPARED[0])]
    figure, panels = gallery.figure(
        2, len(names), size=(2.4 * len(names), 5), sharex="col", sharey="row"
    )
    for column, name in zip(panels.T, names, strict=True):
        for axes, result, colour in zip(
            column, (STEAM, SILICA), (gallery.BLUE, gallery.VERMILION), strict=True
        ):
            axes.plot(table[name], table[result], ".", color=colour)
        column[1].set_xlabel(folded_label(name), fontsize=8)
    panels[0, 0].set_ylabel("steam at its outlet [K]")
    panels[1, 0].set_ylabel("silica at its outlet [K]")
    return figure
