"""Tubes and air of a coal boiler: table and contours from the runs of the sweep.

contbed sweep studies/coal_boiler_design/sweep/tubes_and_air.toml --out results/boiler
python studies/coal_boiler_design/study.py results/boiler        # results.csv, design.png
"""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

HERE = Path(__file__).parent
HEIGHT = 1.2  # of the bed [m]
KEPT = ("T_ash_mid_K", "T_char_mid_K", "tubes_convection_W", "tubes_radiation_W", "top_radiation_W",
        "combustion_efficiency", "carbon_conversion", "oxygen_ratio", "x_O2_dry", "x_CO_dry", "x_SO2_dry",
        "sulphur_capture", "calcined", "Ca_S", "char_volume_fraction", "ignited")  # fmt: skip
PANELS = (
    ("bed temperature [degC]", lambda q: q["T_ash_mid_K"] - 273.15),
    ("heat to tubes [MW]", lambda q: 1e-6 * (q["tubes_convection_W"] + q["tubes_radiation_W"])),
    ("fuel burnt in the bed [%]", lambda q: 100.0 * q["combustion_efficiency"]),
    ("sulphur captured [%]", lambda q: 100.0 * q["sulphur_capture"]),
)


def runs(folder: Path) -> list[dict[str, float]]:
    """Parameters and results of every run that ended well."""
    out = []
    for path in sorted(folder.glob("runs/*/summary.json")):
        summary = json.loads(path.read_text(encoding="utf-8"))
        scene = summary["scene"]
        row = {"tube_area_m2": scene["tubes"]["perimeter"] * HEIGHT, "air_kg_s": scene["gas"]["mass_flow"]}
        row |= {name: summary["qoi"][name] for name in KEPT}
        out.append(row | {"open": max(abs(item["relative_residual"]) for item in summary["balances"].values())})
    return sorted(out, key=lambda row: (row["tube_area_m2"], row["air_kg_s"]))


def main() -> None:
    """Write the table and the picture."""
    rows = runs(Path(sys.argv[1]))
    with (HERE / "results.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: f"{value:.6g}" for name, value in row.items()} for row in rows)
    area, air = (np.unique([row[name] for row in rows]) for name in ("tube_area_m2", "air_kg_s"))
    excess = {row["air_kg_s"]: 100.0 * (row["oxygen_ratio"] - 1.0) for row in rows}
    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (title, value) in zip(figure.subplots(2, 2).ravel(), PANELS, strict=True):
        grid = np.full((len(air), len(area)), np.nan)
        for row in rows:
            if row["ignited"]:
                grid[np.searchsorted(air, row["air_kg_s"]), np.searchsorted(area, row["tube_area_m2"])] = value(row)
        x, y = area, np.array([excess[flow] for flow in air])
        filled = axes.contourf(x, y, grid, levels=9, cmap="viridis")
        lines = axes.contour(x, y, grid, levels=filled.levels, colors="white", linewidths=0.6)
        axes.clabel(lines, fontsize=8)
        for row in rows:
            burns = {"marker": ".", "color": "black"} if row["ignited"] else {"marker": "x", "color": "#B00020"}
            axes.plot(row["tube_area_m2"], excess[row["air_kg_s"]], markersize=4, clip_on=False, **burns)
        axes.set(title=title, xlabel="tube area in the bed [m2]", ylabel="excess air [%]")
    figure.savefig(HERE / "design.png", dpi=130)


if __name__ == "__main__":
    main()
