"""Tubes and air of a coal boiler: contours from the runs of a sweep."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.errors import ConvergenceError
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
HEIGHT = 1.2  # of the bed [m]
# too many tubes for little air
OUT = {"bubbling_bed.tubes.perimeter": 75.0, "boundary.bottom.gas.mass_flow": 9.5}
# perimeters [m], of beds from 815 to 975 degC
TUBES = (54.0, 50.0, 46.0, 42.0, 38.0, 34.0)
RATE = {
    "reactions.sulphate_reduction.rate_constant": 4e-7
}  # 1/Pa/s at 850 degC: assumed, no published value is confirmed
NOT_COMPARED = ("open",)
KEPT = ("T_ash_mid_K", "T_char_mid_K", "tubes_convection_W", "tubes_radiation_W", "top_radiation_W",
        "combustion_efficiency", "carbon_conversion", "oxygen_ratio", "x_O2_dry", "x_CO_dry", "x_SO2_dry",
        "sulphur_capture", "calcined", "Ca_S", "char_volume_fraction", "ignited")  # fmt: skip
PANELS = (
    ("bed temperature [degC]", lambda q: q["T_ash_mid_K"] - 273.15),
    (
        "heat to tubes [MW]",
        lambda q: 1e-6 * (q["tubes_convection_W"] + q["tubes_radiation_W"]),
    ),
    ("fuel burnt in the bed [%]", lambda q: 100.0 * q["combustion_efficiency"]),
    ("sulphur captured [%]", lambda q: 100.0 * q["sulphur_capture"]),
)


def reference() -> float:
    """Temperature at which such beds are run [degC]."""
    return 850.0


def compute() -> Tables:
    """Parameters and results of every run of the sweep, and of a bed that goes out."""
    out, summaries = [], gallery.swept(HERE / "sweep" / "tubes_and_air.toml")[1]
    for summary in summaries:
        scene = summary["scene"]
        tubes, gas = scene["bubbling_bed"]["tubes"], scene["boundary"]["bottom"]["gas"]
        row = {
            "tube_area_m2": tubes["perimeter"] * HEIGHT,
            "air_kg_s": gas["mass_flow"],
        }
        row |= {name: summary["qoi"][name] for name in KEPT}
        out.append(
            row
            | {
                "open": max(
                    abs(item["relative_residual"])
                    for item in summary["balances"].values()
                )
            }
        )
    out.append(_out(out))
    results = Table.of(
        sorted(out, key=lambda row: (row["tube_area_m2"], row["air_kg_s"])), ".6g"
    )
    return {"results": results, "capture": captured()}


def captured() -> Table:
    """Sulphur captured over the temperature of the bed, with sulphate that CO takes
    apart and without.
    """
    rows = []
    for perimeter in TUBES:
        found = [
            cb.run(
                cb.load(
                    HERE / "boiler.toml",
                    {"bubbling_bed.tubes.perimeter": perimeter} | more,
                ),
                quiet=True,
            ).qoi
            for more in ({}, RATE)
        ]
        names = ("sulphur_capture", "sulphur_capture_with_reduction")
        row = {
            "tube_area_m2": perimeter * HEIGHT,
            "T_bed_degC": found[0]["T_ash_mid_K"] - 273.15,
        }
        rows.append(
            row
            | {
                name: qoi["sulphur_capture"]
                for name, qoi in zip(names, found, strict=True)
            }
        )
    return Table.of(rows, ".6g")


def _out(burning: list[dict[str, Any]]) -> dict[str, Any]:
    """Row of the bed that goes out: its cold state would hold more char than solids,
    so that there is no result.
    """
    scene: Any = cb.load(HERE / "boiler.toml", OUT)
    try:
        cb.run(scene)
    except ConvergenceError:
        air = scene.inlet.mass_flow
        ratio = next(row["oxygen_ratio"] for row in burning if row["air_kg_s"] == air)
        area = scene.bubbling_bed.tubes.perimeter * HEIGHT
        return {
            "tube_area_m2": area,
            "air_kg_s": air,
            "oxygen_ratio": ratio,
            "ignited": 0,
        }
    raise AssertionError("a bed with too many tubes for its air burns")


def plot(tables: Tables) -> dict[str, Any]:
    """Contours over tube area and excess air; crosses are beds that went out."""
    table = tables["results"]
    tubes, air, burns = (
        table[name] for name in ("tube_area_m2", "air_kg_s", "ignited")
    )
    excess = 100.0 * (table["oxygen_ratio"] - 1.0)
    x, flows = np.unique(tubes), np.unique(air)
    y = np.array([excess[air == flow].max() for flow in flows])
    figure, panels = gallery.figure(2, 2, size=(9.0, 7.0))
    for axes, (title, value) in zip(panels.ravel(), PANELS, strict=True):
        grid = np.full((len(flows), len(x)), np.nan)
        grid[np.searchsorted(flows, air), np.searchsorted(x, tubes)] = np.where(
            burns, value(table), np.nan
        )
        filled = axes.contourf(x, y, grid, levels=9)
        lines = axes.contour(
            x, y, grid, levels=filled.levels, colors="white", linewidths=0.6
        )
        axes.clabel(lines, fontsize=8)
        for lit, how in (
            (burns == 1, {"marker": ".", "color": "black"}),
            (burns == 0, {"marker": "x", "color": "#B00020"}),
        ):
            axes.plot(
                tubes[lit],
                y[np.searchsorted(flows, air[lit])],
                linestyle="",
                clip_on=False,
                **how,
            )
        axes.set(
            title=title, xlabel="tube area in the bed [m2]", ylabel="excess air [%]"
        )
    return {"design": figure, "capture": _plot_capture(tables["capture"])}


def _plot_capture(table: Table) -> Any:
    """Both curves over the temperature of the bed, and the temperature at which
    boilers have their optimum.
    """
    figure, axes = gallery.figure(1, 1, size=(5.5, 4.0))
    for name, text in (
        ("sulphur_capture", "sulphate stays"),
        ("sulphur_capture_with_reduction", "CO takes sulphate apart"),
    ):
        axes.plot(table["T_bed_degC"], 100.0 * table[name], marker="o", label=text)
    axes.axvline(
        reference(),
        linestyle="--",
        linewidth=0.8,
        color="grey",
        label="boilers are run here",
    )
    axes.set(xlabel="bed temperature [degC]", ylabel="sulphur captured [%]")
    axes.legend()
    return figure
