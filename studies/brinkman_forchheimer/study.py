"""Developed Brinkman-Forchheimer flow around a bed that slides along a channel, against the exact solution.

python studies/brinkman_forchheimer/study.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.verify import exact

HERE = Path(__file__).parent
SCENES = ("slip_0.00_darcy", "slip_0.00", "slip_0.50", "slip_0.95", "slip_-0.25")
LABELS = ("$u_s = 0$, $c_F = 0$", "$u_s = 0$", "$u_s = 0.5\\, u_D$", "$u_s = 0.95\\, u_D$", "$u_s = -0.25\\, u_D$")
COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7")
ACROSS = (16, 24, 32, 48, 64, 96, 128)  # cells across the channel in the convergence plot


def reference(scene, y=0.0):
    """Exact developed flow at the distance y [m] from a wall, from the values in the scene."""
    flow, fluid, bed = scene.flow, scene.fluid, scene.bed
    return exact.brinkman_forchheimer_channel(
        y,
        scene.mesh.height,
        flow.velocity,
        flow.velocity_solid,
        fluid.viscosity,
        fluid.density,
        bed.permeability,
        bed.forchheimer,
        bed.porosity,
    )


def errors(scene, result):
    """Relative errors of the largest velocity at the outlet and of the pressure gradient."""
    wanted = reference(scene)
    return (
        result.qoi["u_max_outlet"] / wanted.u_max - 1,
        result.qoi["pressure_gradient_Pa_m"] / wanted.pressure_gradient - 1,
    )


def with_cells(scene, across):
    """The scene with another number of cells across the channel."""
    mesh = scene.mesh.model_copy(update={"cells": (scene.mesh.cells[0], across)})
    return scene.model_copy(update={"mesh": mesh})


def main():
    scenes = {name: cb.load(HERE / f"{name}.toml") for name in SCENES}
    lines = ["scene,u_s/u_D [1],c_F [1],cells across,u_max/u_D [1],P* [1],error of u_max [1],error of dp/dx [1]"]
    history = {}
    for name, scene in scenes.items():
        fluid, u, height = scene.fluid, scene.flow.velocity, scene.mesh.height
        for across in (*ACROSS, scene.mesh.cells[1]):
            if across > scene.mesh.cells[1] or (name, across) in history:
                continue
            result = cb.run(with_cells(scene, across))
            history[name, across] = errors(scene, result)
            gradient = result.qoi["pressure_gradient_Pa_m"] * height**2 / (fluid.viscosity * u)
            numbers = f"{result.qoi['u_max_outlet'] / u:.11f},{gradient:.8f}"
            u_max, dp = history[name, across]
            case = f"{name},{scene.flow.velocity_solid / u:g},{scene.bed.forchheimer:g},{across}"
            lines.append(f"{case},{numbers},{u_max:.1e},{dp:.1e}")
        print(lines[-1])
    (HERE / "results.csv").write_text("\n".join(lines) + "\n", encoding="ascii")
    plot(scenes, history)


def plot(scenes, history):
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12, 3.9), layout="constrained")
    for (name, scene), label, colour in zip(scenes.items(), LABELS, COLOURS, strict=True):
        eta = np.linspace(0, 0.5, 501) ** 2 * 2
        left.plot(eta, reference(scene, eta * scene.mesh.height).u / scene.flow.velocity, color=colour, label=label)
        cells = [n for key, n in history if key == name]
        for axes, part in ((middle, 0), (right, 1)):
            axes.loglog(cells, [abs(history[name, n][part]) for n in cells], "o-", color=colour, markersize=4)
    for axes, start in ((middle, 1e-5), (right, 1e-3)):
        n = np.array([40, 160])
        axes.loglog(n, start * (n[0] / n) ** 4, color="grey", linestyle=(0, (4, 2)))
        axes.annotate(
            "order 4", (n[1], start * 4**-4.0), color="grey", fontsize=9, xytext=(3, 3), textcoords="offset points"
        )
        axes.axhline(1e-8, color="grey", linewidth=0.8)
        axes.set(xlabel="cells across the channel", xticks=[16, 32, 64, 128, 256], ylim=(1e-11, 1e-1))
        axes.set_xticklabels(["16", "32", "64", "128", "256"])
        axes.minorticks_off()
    left.set(xlabel="y/H", ylabel="$u/u_D$", xlim=(0, 0.5), ylim=(0, 1.2), title="exact profiles")
    left.legend(fontsize=9, loc="lower right")
    middle.set(title="relative error of the largest velocity")
    right.set(title="relative error of the pressure gradient")
    figure.savefig(HERE / "convergence.png", dpi=200)
    plt.close(figure)


if __name__ == "__main__":
    main()
