"""Heat through a packed bed between two plates by P1, two-flux and the Rosseland conductivity, over its thickness.

python studies/radiating_bed/study.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.radiation.rosseland import estimate

HERE = Path(__file__).parent
LENGTHS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
LEVELS = ("p1", "two_flux", "rosseland")


def heat(length, level):
    """Heat from the hot plate [W/m2] and the scene."""
    scene = cb.load(HERE / "bed.toml", {"mesh.length": length, "radiation.level": level})
    return cb.run(scene).qoi["heat_left_W"], scene


def main():
    rows = ["length [m],tau [1],P1 [W/m2],two-flux over P1,Rosseland over P1,stated error of Rosseland,chosen by plan"]
    table = []
    for length in LENGTHS:
        found = {level: heat(length, level) for level in LEVELS}
        q, scene = found["p1"]
        tau = 1.5 * (1 - scene.bed.porosity) / scene.bed.porosity * length / scene.bed.particle_diameter
        stated = estimate(scene, scene.mesh)
        built = dict(cb.plan(cb.load(HERE / "bed_cheapest.toml", {"mesh.length": length})).built)["radiation"]
        chosen = "Rosseland" if built.startswith("Rosseland") else "P1"
        table.append((tau, found["two_flux"][0] / q - 1, found["rosseland"][0] / q - 1, stated))
        ratios = ",".join(f"{found[level][0] / q:.4f}" for level in LEVELS[1:])
        rows.append(f"{length:g},{tau:.1f},{q:.2f},{ratios},{stated:.4f},{chosen}")
    (HERE / "levels.csv").write_text("\n".join(rows) + "\n", encoding="ascii")
    print("\n".join(rows))
    plot(np.array(table))


def plot(table):
    """Temperatures of a thin bed by each level, and how far the levels are from P1 over the thickness."""
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.2), layout="constrained")
    for level, dashes, colour in (("p1", "-", "#222222"), ("rosseland", "--", "#0072b2"), ("two_flux", ":", "#d55e00")):
        profiles = cb.run(cb.load(HERE / "bed.toml", {"mesh.length": 0.02, "radiation.level": level})).profiles
        label = {"p1": "P1", "rosseland": "Rosseland", "two_flux": "two-flux"}[level]
        left.plot(1e3 * profiles["x [m]"], profiles["T_solid [K]"], dashes, color=colour, label=label)
    left.set(xlabel="x [mm]", ylabel="temperature of the solid [K]", title="four particles thick", xlim=(0, 20))
    left.legend()
    tau, two_flux, rosseland, stated = table.T
    right.loglog(tau, rosseland, "o-", color="#0072b2", label="Rosseland minus P1")
    right.loglog(tau, stated, "k--", label="error that plan states")
    right.loglog(tau, -two_flux, "s-", color="#d55e00", label="P1 minus two-flux")
    right.axhline(0.01, color="0.6", linewidth=0.8)
    right.set(xlabel=r"optical thickness $\tau$", ylabel="heat, relative to P1")
    right.legend(loc="lower left")
    figure.savefig(HERE / "levels.png", dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    main()
