"""A hot bed of three species at five levels of radiation: table, pictures, run times.

python studies/rabi_two_flux_bed/study.py        # about 1 min: results.csv, profiles.png, packing.csv
"""

from __future__ import annotations

import csv
import statistics
import time
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import contbed as cb
from contbed.bubbling_bed.problem import BubblingProblem

HERE = Path(__file__).parent
LEVELS = {
    "none": ("no radiation", "#999999"),
    "pairwise": ("pairs of species", "#009E73"),
    "paper": ("paper's closure", "#E69F00"),
    "two_flux": ("two-flux", "#0072B2"),
    "p1": ("P1", "#D55E00"),
}
REPEATS = 5


def cost(scene: cb.Scene) -> float:
    """CPU seconds of one plan and solution, median."""
    found = []
    for _ in range(REPEATS):
        start = time.process_time()
        BubblingProblem(cb.plan(scene)).solve()
        found.append(time.process_time() - start)
    return statistics.median(found)


def table(path: Path, results: dict[str, cb.Result], seconds: dict[str, float]) -> None:
    """Named results of all runs, one column for each."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["result", *results])
        for key in next(iter(results.values())).qoi:
            writer.writerow([key, *(f"{result.qoi[key]:.7g}" for result in results.values())])
        if seconds:
            writer.writerow(["cpu_s", *(f"{value:.2f}" for value in seconds.values())])


def main() -> None:
    """Run the scenes, write the tables and the picture."""
    results = {name: cb.run(cb.load(HERE / f"{name}.toml")) for name in LEVELS}
    seconds = {name: cost(cb.load(HERE / f"{name}.toml")) for name in LEVELS}
    table(HERE / "results.csv", results, seconds)
    p1 = {"independent": results["p1"]}
    p1["close_packed"] = cb.run(cb.load(HERE / "p1.toml", {"radiation.correction": "close_packed"}))
    p1["backward"] = cb.run(cb.load(HERE / "p1.toml", {"radiation.anisotropy": -4 / 9}))
    table(HERE / "packing.csv", p1, {})
    for name, result in results.items():
        print(f"{name:10} {seconds[name]:.2f} s, balance {result.balances['energy']['relative_residual']:.1e}")
    profiles(results)


def profiles(results: dict[str, cb.Result]) -> None:
    """Temperatures of the species over the height, and their difference to P1 near the distributor."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 4)
    species = ("char", "limestone", "inert")
    for name, (label, colour) in LEVELS.items():
        columns = results[name].profiles
        for panel, which in zip(axes, species, strict=False):
            if name != "none":
                panel.plot(columns[f"T_{which} [K]"], columns["z [m]"], color=colour, label=label)
        if name not in ("none", "p1"):
            z, T = results["p1"].profiles["z [m]"], results["p1"].profiles["T_inert [K]"]
            own = np.interp(z, columns["z [m]"], columns["T_inert [K]"])
            axes[3].plot(own - T, z, color=colour)
    for panel, which in zip(axes, species, strict=False):
        panel.set(title=which, xlabel="temperature [K]", ylim=(0, 0.9))
    axes[0].set_ylabel("height above the distributor [m]")
    axes[3].set(title="inert less that with P1", xlabel="difference [K]", ylim=(0, 0.9))
    for panel in axes:
        panel.spines[["top", "right"]].set_visible(False)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(HERE / "profiles.png", dpi=130)


if __name__ == "__main__":
    main()
