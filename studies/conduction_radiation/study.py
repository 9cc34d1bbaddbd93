"""Heat conduction with radiation between two black walls: each level beside exact transport.

python studies/conduction_radiation/study.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.verify.exact_conduction_radiation import conduction_diffusion, conduction_radiation
from contbed.verify.exact_radiation import P1, TWO_FLUX

HERE = Path(__file__).parent
DIFFUSION = {"two_flux": TWO_FLUX, "p1": P1}
NUMBERS = ("0.01", "0.1", "1", "10")
THICKNESSES = ("0.1", "1", "10")
LEVELS = {"two-flux": ("two_flux", 1), "P1": ("p1", 1), "4 + 4 ordinates": ("ordinates", 4),
          "8 + 8 ordinates": ("ordinates", 8)}  # fmt: skip
COLOURS = dict(zip(LEVELS, ("#d55e00", "#009e73", "#56b4e9", "#0072b2"), strict=True))


def load(N, tau, level="p1", ordinates=4, theta_L=0.5):
    """The scene of one conduction-radiation parameter and thickness, by another level, with a colder cold wall."""
    changes = {"radiation.level": level, "radiation.ordinates": ordinates}
    cold = {"boundary.right.radiation.temperature": 1000.0 * theta_L}
    return cb.load(HERE / f"N_{N}_tau_{tau}.toml", changes | cold)


def parameters(scene):
    """tau, N and theta_L of a scene."""
    table, length = scene.radiation, scene.mesh.length
    hot, cold = (scene.boundary[name].radiation.temperature for name in ("left", "right"))
    N = table.conductivity * table.absorption / (4.0 * SIGMA * hot**3)
    return table.absorption * length, N, cold / hot


def exact(scene):
    """Total flux over sigma T1^4 by transport, or the solution of the model at the level of the scene."""
    return conduction_radiation(*parameters(scene))


def of_model(scene):
    """The solution of the two-flux or P1 equations by collocation."""
    return conduction_diffusion(*parameters(scene), DIFFUSION[scene.radiation.level])


def found(result):
    """Total flux over sigma T1^4."""
    return result.qoi["flux_over_emissive_power"]


def main():
    rows = ["theta_L [1],N [1],tau [1],flux exact [1]," + ",".join(f"{name} [1],error" for name in LEVELS)]
    rows[0] += ",two-flux against collocation,P1 against collocation"
    errors, discretisation = {}, []
    for theta_L in (0.5, 0.1):
        for tau in THICKNESSES:
            for N in NUMBERS:
                reference = exact(load(N, tau, theta_L=theta_L)).total
                row, against = [f"{theta_L:g},{N},{tau},{reference:.8f}"], []
                for name, (level, ordinates) in LEVELS.items():
                    scene = load(N, tau, level, ordinates, theta_L)
                    flux = found(cb.run(scene))
                    errors[name, theta_L, tau, N] = flux / reference - 1
                    row.append(f"{flux:.8f},{flux / reference - 1:.1e}")
                    if level in DIFFUSION:
                        against.append(flux / of_model(scene).total - 1)
                discretisation += against
                rows.append(",".join([*row, *(f"{value:.1e}" for value in against)]))
    (HERE / "results.csv").write_text("\n".join(rows) + "\n", encoding="ascii")
    print(f"two-flux and P1 against collocation: {np.abs(discretisation).max():.1e}")
    for name in LEVELS:
        worst = max(abs(value) for (level, *_), value in errors.items() if level == name)
        print(f"{name:16} against transport: {100 * worst:.3g} %")
    plot(errors)


def plot(errors):
    """Temperatures at tau = 1 by every level, and the error of the flux of each level."""
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    figure, panels = plt.subplots(1, 4, figsize=(14, 4), layout="constrained", width_ratios=(1.5, 1, 1, 1))
    first, others = panels[0], panels[1:]
    for N in NUMBERS[:3]:
        reference = exact(load(N, "1"))
        first.plot(reference.depth, reference.theta, "k", linewidth=3, alpha=0.25)
        for name, (level, ordinates) in LEVELS.items():
            if ordinates != 8:
                profiles = cb.run(load(N, "1", level, ordinates)).profiles
                first.plot(profiles["x [m]"] / 0.1, profiles["T_solid [K]"] / 1000, color=COLOURS[name], linewidth=1)
    for N, at, height in (("1", 0.36, 0.73), ("0.1", 0.75, 0.70), ("0.01", 0.80, 0.80)):
        first.text(at, height, f"N = {N}", fontsize=9)
    first.set(xlabel="optical depth", ylabel=r"$T/T_1$", title=r"$\tau$ = 1, $T_2/T_1$ = 0.5", xlim=(0, 1))
    first.plot([], [], "k", linewidth=3, alpha=0.25, label="transport")
    for name in LEVELS:
        first.plot([], [], color=COLOURS[name], label=name)
    first.legend(loc="lower left", fontsize=9)
    for axes, tau in zip(others, THICKNESSES, strict=True):
        for name in LEVELS:
            values = [abs(errors[name, 0.5, tau, N]) for N in NUMBERS]
            axes.loglog([float(N) for N in NUMBERS], values, "o-", color=COLOURS[name], markersize=4)
        axes.set(title=rf"$\tau$ = {tau}", xlabel="N", ylim=(1e-11, 1))
    others[0].set_ylabel("relative error of the flux")
    figure.savefig(HERE / "conduction_radiation.png", dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    main()
