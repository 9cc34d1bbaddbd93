"""The bubbling bed with frozen closures at four levels of radiation: table, errors against collocation, pictures.

python studies/bubbling_bed_case1/study.py        # about 5 s: results.csv, profiles.png, convergence.png
"""

from __future__ import annotations

import csv
import time
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import contbed as cb

HERE = Path(__file__).parent
LEVELS = {
    "none": ("no radiation", "#999999"),
    "paper_closure": ("paper's closure", "#E69F00"),
    "two_flux": ("two-flux", "#0072B2"),
    "p1": ("P1", "#D55E00"),
}
CELLS = (8, 16, 32, 64, 128)


def reference() -> dict[str, dict[str, float]]:
    """Named results of each scene by collocation."""
    with open(HERE / "reference.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: {row["result"]: float(row[name]) for row in rows} for name in LEVELS}


def errors(qoi: dict[str, float], exact: dict[str, float]) -> tuple[float, float]:
    """Largest error of a temperature [K], and of a duty relative to itself."""
    kelvin = max(abs(qoi[name] - value) for name, value in exact.items() if name.endswith("_K"))
    return kelvin, max(abs(qoi[name] / value - 1) for name, value in exact.items() if name.endswith("_W") and value)


def main() -> None:
    """Run the scenes, write the table and the pictures."""
    exact, results, seconds = reference(), {}, {}
    cb.run(cb.load(HERE / "p1.toml"))  # imports
    for name in LEVELS:
        start = time.perf_counter()
        results[name] = cb.run(cb.load(HERE / f"{name}.toml"))
        seconds[name] = time.perf_counter() - start
        kelvin, share = errors(results[name].qoi, exact[name])
        print(f"{name:14} {seconds[name]:.2f} s, largest error {kelvin:.1e} K, {share:.1e} of a duty")
    with open(HERE / "results.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["result", *LEVELS])
        for key in results["p1"].qoi:
            writer.writerow([key, *(f"{results[name].qoi[key]:.9g}" for name in LEVELS)])
    profiles(results)
    convergence(exact["p1"])


def profiles(results: dict[str, cb.Result]) -> None:
    """Temperatures over the height for all levels, and what happens in the lowest centimetre."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 4, width_ratios=[1, 1, 1, 1.1])
    panels = (("T_char [K]", "char"), ("T_inert [K]", "inert"), ("T_bubble [K]", "bubble gas"))
    for name, (label, colour) in LEVELS.items():
        columns = results[name].profiles
        for panel, (header, _) in zip(axes, panels, strict=False):
            panel.plot(columns[header], columns["z [m]"], color=colour, label=label)
        if "G [W/m2]" in columns:
            axes[3].semilogy(1e-3 * columns["G [W/m2]"], 1e3 * np.maximum(columns["z [m]"], 1e-9), color=colour)
    for panel, (_, what) in zip(axes, panels, strict=False):
        panel.set(title=what, xlabel="temperature [K]", ylim=(0, 0.6))
    axes[0].set_ylabel("height above the distributor [m]")
    axes[3].set(title="incident radiation", xlabel="$G$ [kW/m$^2$]", ylabel="height [mm]", ylim=(1e-2, 600))
    for panel in axes:
        panel.spines[["top", "right"]].set_visible(False)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(HERE / "profiles.png", dpi=130)


def convergence(exact: dict[str, float]) -> None:
    """Largest error of a temperature over the number of cells, with P1 and each degree."""
    figure = Figure(figsize=(6, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for degree, colour in ((1, "#E69F00"), (2, "#009E73"), (3, "#0072B2")):
        found = []
        for cells in CELLS:
            scene = cb.load(HERE / "p1.toml", {"mesh.cells": cells, "solver.degree": degree})
            found.append(errors(cb.run(scene).qoi, exact)[0])
        axes.loglog(CELLS, found, "o-", color=colour, label=f"degree {degree}")
        order = np.log2(found[-3] / found[-2])
        print(f"degree {degree}: errors {', '.join(f'{error:.1e}' for error in found)} K, order {order:.2f}")
    axes.set(xlabel="cells", ylabel="largest error of a temperature [K]", title="P1 against collocation")
    axes.set_xticks(CELLS, [str(cells) for cells in CELLS])
    axes.minorticks_off()
    axes.grid(which="major", linewidth=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    figure.savefig(HERE / "convergence.png", dpi=130)


if __name__ == "__main__":
    main()
