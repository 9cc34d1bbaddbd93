"""Emittance of isothermal slabs over albedo and thickness, by every level and by transport.

python studies/isothermal_slab/study.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.verify.exact_radiation import P1, TWO_FLUX, isothermal_body
from contbed.verify.exact_transport import slab_emittance

HERE = Path(__file__).parent
DIFFUSION = {"two_flux": TWO_FLUX, "p1": P1}
ALBEDOS = (0.0, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999)
THICKNESSES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
LEVELS = {"two-flux": ("two_flux", 1), "P1": ("p1", 1), "4 + 4 ordinates": ("ordinates", 4),
          "8 + 8 ordinates": ("ordinates", 8)}  # fmt: skip
STYLES = {"two-flux": ":", "P1": "--", "8 + 8 ordinates": "-"}
SHOWN = (0.0, 0.5, 0.9, 0.99)


def variant(albedo, tau, level, ordinates=8):
    """The scene of albedo 0.5 and tau = 1 with other values."""
    beta = tau / 0.1
    return cb.load(
        HERE / "albedo_0.5_tau_1.toml",
        {
            "radiation.level": level,
            "radiation.ordinates": ordinates,
            "radiation.absorption": beta * (1.0 - albedo),
            "radiation.scattering": beta * albedo,
        },
    )


def parameters(scene):
    """Albedo and optical thickness of a scene."""
    table = scene.radiation
    beta = table.absorption + table.scattering
    return table.scattering / beta, beta * scene.mesh.length


def closed_form(scene):
    """Emittance by the model of the scene's level: two-flux or P1."""
    albedo, tau = parameters(scene)
    return float(isothermal_body("slab", tau, DIFFUSION[scene.radiation.level], albedo))


def exact(scene):
    """Emittance by transport."""
    albedo, tau = parameters(scene)
    return slab_emittance(tau, albedo)


def found(result):
    """Emittance of both sides of the slab in a run."""
    scene = result.plan.scene
    power = SIGMA * scene.radiation.temperature**4
    return np.array([-result.qoi[f"heat_{name}_W"] / power for name in ("left", "right")])


def main():
    rows = ["albedo [1],tau [1],emittance exact [1]," + ",".join(f"{name} [1],error" for name in LEVELS)]
    emittance, worst, against = {}, dict.fromkeys(LEVELS, 0.0), 0.0
    for albedo in ALBEDOS:
        for tau in THICKNESSES:
            reference = slab_emittance(tau, albedo)
            row = [f"{albedo:g},{tau:g},{reference:.10f}"]
            for name, (level, ordinates) in LEVELS.items():
                scene = variant(albedo, tau, level, ordinates)
                value = found(cb.run(scene))[1]
                emittance[name, albedo, tau] = value
                worst[name] = max(worst[name], abs(value / reference - 1))
                if level in DIFFUSION:
                    against = max(against, abs(value / closed_form(scene) - 1))
                row.append(f"{value:.10f},{value / reference - 1:.1e}")
            rows.append(",".join(row))
    (HERE / "emittance.csv").write_text("\n".join(rows) + "\n", encoding="ascii")
    print(f"two-flux and P1 against closed forms: {against:.1e}")
    for name, value in worst.items():
        print(f"{name:16} against transport: {100 * value:.3g} %")
    plot(emittance)


def plot(emittance):
    """Emittance over thickness, and how far the models are from transport."""
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.5, 4.4), layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(SHOWN)))
    for albedo, colour in zip(SHOWN, colours, strict=True):
        for name, dashes in STYLES.items():
            values = np.array([emittance[name, albedo, tau] for tau in THICKNESSES])
            reference = np.array([slab_emittance(tau, albedo) for tau in THICKNESSES])
            left.semilogx(THICKNESSES, values, dashes, color=colour, linewidth=1.3)
            right.semilogx(THICKNESSES, 100 * (values / reference - 1), dashes, color=colour, linewidth=1.3)
        left.semilogx(THICKNESSES, reference, "o", color=colour, markersize=3.5)
        left.annotate(
            rf"$\omega$ = {albedo:g}",
            (THICKNESSES[-1], reference[-1]),
            (6, 0),
            va="center",
            textcoords="offset points",
            color=colour,
        )
    left.plot([], [], "ko", markersize=3.5, label="transport")
    for name, dashes in STYLES.items():
        left.plot([], [], f"k{dashes}", label=name)
    left.legend(loc="upper left", fontsize=9)
    left.set(xlabel=r"optical thickness $\tau$", ylabel=r"emittance $q/\sigma T^4$", ylim=(0, 1.1))
    right.set(xlabel=r"optical thickness $\tau$", ylabel="difference from transport [%]")
    figure.savefig(HERE / "emittance.png", dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    main()
