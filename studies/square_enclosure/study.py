"""Isothermal absorbing medium in a square with cold black walls: P1 on a mesh, P1 by a spectral method, transport.

python studies/square_enclosure/study.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.fem.probe import Probe
from contbed.verify.exact_radiation import square_p1, square_transport

HERE = Path(__file__).parent
THICKNESSES = ("0.1", "1", "10")
PLACES = np.array([0.1, 0.3, 0.5])  # along a wall, over its length
COLOURS = dict(zip(THICKNESSES, ("#009e73", "#0072b2", "#d55e00"), strict=True))


def thickness(scene):
    """kappa L of a scene."""
    return scene.radiation.absorption * scene.mesh.length


def wall_flux(result, at, wall="bottom"):
    """Flux to a wall over sigma T^4 at places `at` along it, over its length: G/2 on a cold black wall."""
    scene = result.plan.scene
    sizes = scene.mesh.length, scene.mesh.height
    along = 1 if wall in ("left", "right") else 0
    points = np.empty((2, len(at)))
    points[along] = sizes[along] * np.asarray(at)
    points[1 - along] = sizes[1 - along] if wall in ("right", "top") else 0.0
    space, G = result.nodal["G"]
    return 0.5 * Probe(result.plan.mesh, points)(space, G) / (SIGMA * scene.radiation.temperature**4)


def main():
    rows = ["kappa L [1],x/L [1],P1 [1],P1 spectral [1],difference,transport [1],P1 minus transport"]
    results = {tau: cb.run(cb.load(HERE / f"tau_{tau}.toml")) for tau in THICKNESSES}
    for tau, result in results.items():
        found, spectral, exact = (
            f(PLACES)
            for f in (
                lambda x, r=result: wall_flux(r, x),
                lambda x, k=float(tau): square_p1(x, k),
                lambda x, k=float(tau): square_transport(x, k),
            )
        )
        for values in zip(PLACES, found, spectral, exact, strict=True):
            x, p1, reference, transport = values
            rows.append(
                f"{tau},{x:g},{p1:.10f},{reference:.10f},{p1 / reference - 1:.1e},{transport:.8f},"
                f"{p1 / transport - 1:.3f}"
            )
        print(rows[-1], f"{result.plan.mesh.skfem.nelements} cells, {result.timings['total']:.2f} s")
    (HERE / "wall_flux.csv").write_text("\n".join(rows) + "\n", encoding="ascii")
    plot(results)


def plot(results):
    """Flux along a wall by P1 and by transport, and G in the square at kappa L = 1."""
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.2), layout="constrained")
    x = np.linspace(0.005, 0.995, 67)
    for tau, result in results.items():
        values = wall_flux(result, x)
        left.plot(x, values, color=COLOURS[tau])
        left.plot(x, square_transport(x, float(tau)), "--", color=COLOURS[tau])
        left.annotate(
            rf"$\kappa L$ = {tau}",
            (x[-1], values[33]),
            (8, 0),
            textcoords="offset points",
            va="center",
            color=COLOURS[tau],
        )
    left.plot([], [], "k", label="P1")
    left.plot([], [], "k--", label="transport")
    left.legend(loc="center", bbox_to_anchor=(0.5, 0.42))
    left.set(xlabel="x/L along the wall", ylabel=r"$q/\sigma T^4$", xlim=(0, 1), ylim=(0, 1.15))
    side = np.linspace(0.0, 1.0, 201)
    scene = results["1"].plan.scene
    points = scene.mesh.length * np.array(np.meshgrid(side, side)).reshape(2, -1)
    space, G = results["1"].nodal["G"]
    field = Probe(results["1"].plan.mesh, points)(space, G).reshape(201, 201) / (4 * SIGMA * 1000.0**4)
    picture = right.contourf(side, side, field, levels=20, cmap="inferno")
    right.set(aspect="equal", xlabel="x/L", ylabel="y/L", title=r"$\kappa L$ = 1")
    figure.colorbar(picture, ax=right, label=r"$G/4\sigma T^4$")
    figure.savefig(HERE / "square.png", dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    main()
