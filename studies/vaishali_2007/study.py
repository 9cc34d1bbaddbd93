"""Profiles of the riser in the window of the measurements, contbed beside twoPhaseEulerFoam, in profiles.png.

python study.py [SCENE ...]     runs these scenes (some 11 minutes of CPU each), keeps their lateral.csv, and draws
"""

from __future__ import annotations

import csv
import shutil
import sys
import tempfile
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import contbed as cb

HERE = Path(__file__).parent
WIDTH = 0.152  # of the riser [m]
PANELS = ("eps_s [1]", "u_solid [m/s]", "theta_total [m2/s2]")
PRINTED = ("steps", "mass_drift_relative", "eps_s_max", "difference_of_halves")
COLOURS = {"wenyu": "#0072B2", "syamlal": "#D55E00"}
# in each flow one more profile of ours: on the fine grid of accuracy.py, and with the highest flux
MORE = {
    "ff": ("ff_wenyu_fine", "#009E73", "contbed, wenyu, 30x700"),
    "dpt": ("dpt_wenyu_36.8", "#CC79A7", "contbed, wenyu, 36.8 kg/m2/s"),
}


def run(name: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        found = cb.run(cb.load(HERE / f"{name}.toml"), Path(folder)).qoi
        print(f"{name}: {time.process_time() - began:.0f} s of CPU", *(f"{key} {found[key]:.2g}" for key in PRINTED))
        shutil.copy(Path(folder) / "lateral.csv", HERE / f"{name}_lateral.csv")


def columns(path: Path) -> dict[str, np.ndarray]:
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def peer(path: Path) -> dict[str, np.ndarray]:
    """The peer's profile under our names; what its averages lack in the third direction counts as the lateral one."""
    found = columns(path)
    moved = (found["var_us_axial"] + 2.0 * found["var_us_lateral"]) / 3.0
    return {
        "x [m]": WIDTH * found["x_over_W"],
        "eps_s [1]": found["es_mean"],
        "u_solid [m/s]": found["us_mean"],
        "theta_total [m2/s2]": found["theta_mean"] + moved,
    }


def draw() -> None:
    figure, axes = plt.subplots(2, 3, figsize=(9, 5.2), layout="constrained", sharex=True)
    for line, flow, name in zip(axes, ("ff", "dpt"), ("fast fluidization", "dilute transport"), strict=True):
        curves = []
        for drag, colour in COLOURS.items():
            curves.append((columns(HERE / f"{flow}_{drag}_lateral.csv"), "-", colour, f"contbed, {drag}"))
            data = peer(HERE / f"twoPhaseEulerFoam_{flow}_{drag}.csv")
            curves.append((data, "--", colour, f"twoPhaseEulerFoam, {drag}"))
        scene, colour, label = MORE[flow]
        curves.append((columns(HERE / f"{scene}_lateral.csv"), "-", colour, label))
        for data, style, colour, label in curves:
            for panel, key in zip(line, PANELS, strict=True):
                panel.plot(data["x [m]"], data[key], style, color=colour, label=label)
        for panel, key in zip(line, PANELS, strict=True):
            panel.set(ylabel=key.replace("_", " "), title=name)
    for panel in axes[1]:
        panel.set_xlabel("x [m]")
    known = {curve.get_label(): curve for panel in axes[:, 0] for curve in panel.lines}
    figure.legend(known.values(), known.keys(), loc="outside lower center", ncols=3, fontsize="small")
    figure.savefig(HERE / "profiles.png", dpi=130)


if __name__ == "__main__":
    for scene in sys.argv[1:]:
        run(scene)
    draw()
