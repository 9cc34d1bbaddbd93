"""Radiative equilibrium between plates: error of each level of radiation and what it costs.

python studies/heaslet_warming/study.py
"""

import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.verify.exact_radiation import P1, TWO_FLUX, equilibrium_flux, equilibrium_profile
from contbed.verify.exact_transport import Equilibrium

HERE = Path(__file__).parent
DIFFUSION = {"two_flux": TWO_FLUX, "p1": P1}
THICKNESSES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
LEVELS = (("two_flux", 1), ("p1", 1), ("ordinates", 2), ("ordinates", 4), ("ordinates", 8), ("ordinates", 16))
COLOURS = {"two_flux": "#d55e00", "p1": "#009e73", "ordinates": "#0072b2"}
MARKS = {0.1: "v", 1.0: "o", 10.0: "s", 100.0: "^"}
REPEATS = 5


def parameters(scene):
    """Optical thickness and emissivities of a scene."""
    table, ends = scene.radiation, (scene.boundary["left"], scene.boundary["right"])
    return (table.absorption + table.scattering) * scene.mesh.length, tuple(end.radiation.emissivity for end in ends)


def closed_form(scene):
    """flux_dimensionless and temperature_slip that the level of a scene has: P1 and two-flux."""
    tau, emissivity = parameters(scene)
    D = DIFFUSION[scene.radiation.level]
    return np.array([equilibrium_flux(tau, D, emissivity), 1 - equilibrium_profile(0.0, tau, D, emissivity)])


def exact(scene):
    """The same two numbers by transport theory."""
    found = Equilibrium(*parameters(scene))
    return np.array([found.flux, found.slip])


def found(result):
    """The two numbers of a run."""
    return np.array([result.qoi["flux_dimensionless"], result.qoi["temperature_slip"]])


def variant(tau, level, ordinates):
    """The scene of tau = 1 with another thickness and level."""
    share = {"absorption": 0.7, "scattering": 0.3}
    changes = {f"radiation.{key}": part * tau / 0.1 for key, part in share.items()}
    return cb.load(HERE / "tau_1.toml", changes | {"radiation.level": level, "radiation.ordinates": ordinates})


def name_of(level, ordinates):
    return {"p1": "P1", "two_flux": "two-flux"}.get(level, f"{ordinates} + {ordinates} ordinates")


def timed(scene):
    """A result and the best wall time of some runs [s]."""
    best = np.inf
    for _ in range(REPEATS):
        start = time.perf_counter()
        result = cb.run(scene)
        best = min(best, time.perf_counter() - start)
    return result, best


def main():
    rows = ["tau [1],level,flux exact [1],flux [1],error of flux [1],slip exact [1],error of slip [1],cells,time [s]"]
    errors, times = {}, {}
    for level, ordinates in LEVELS:
        for tau in THICKNESSES:
            scene = variant(tau, level, ordinates)
            result, seconds = timed(scene)
            psi, slip = exact(scene)
            error = found(result) / [psi, slip] - 1
            errors[level, ordinates, tau], times[level, ordinates, tau] = error[0], seconds
            cells = result.plan.mesh.skfem.nelements
            rows.append(
                f"{tau:g},{name_of(level, ordinates)},{psi:.10f},{result.qoi['flux_dimensionless']:.10f},"
                f"{error[0]:.1e},{slip:.10f},{error[1]:.1e},{cells},{seconds:.4f}"
            )
        worst = max(abs(errors[level, ordinates, tau]) for tau in THICKNESSES)
        print(f"{name_of(level, ordinates):18} worst error of the flux {100 * worst:.3g} %")
    (HERE / "levels.csv").write_text("\n".join(rows) + "\n", encoding="ascii")
    plot(errors, times)


def plot(errors, times):
    """Error over thickness, and over run time at four thicknesses."""
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.5, 4.6), sharey=True, layout="constrained")
    widths = dict(zip((2, 4, 8, 16), (0.8, 1.3, 1.8, 2.3), strict=True))
    for level, ordinates in LEVELS:
        values = [abs(errors[level, ordinates, tau]) for tau in THICKNESSES]
        line = {"color": COLOURS[level], "linewidth": widths.get(ordinates, 1.8)}
        left.loglog(THICKNESSES, values, **line)
        left.annotate(
            name_of(level, ordinates),
            (THICKNESSES[-1], values[-1]),
            (5, 0),
            textcoords="offset points",
            va="center",
            color=COLOURS[level],
            fontsize=9,
        )
    for tau, mark in MARKS.items():
        for level, ordinates in LEVELS:
            x, y = times[level, ordinates, tau], abs(errors[level, ordinates, tau])
            right.semilogy(1e3 * x, y, mark, color=COLOURS[level], markersize=4 + 2 * np.log2(ordinates))
        right.semilogy([], [], mark, color="0.3", label=rf"$\tau$ = {tau:g}")
    for level, _ in LEVELS[:3]:
        right.semilogy([], [], "o", color=COLOURS[level], label=name_of(level, 2).replace("2 + 2 ", ""))
    right.legend(loc="upper right", fontsize=9)
    left.set(xlabel=r"optical thickness $\tau$", ylabel="relative error of the flux", xlim=(0.01, 100))
    right.set(xlabel="run time [ms]; larger marks: more ordinates", xlim=(0, None))
    figure.savefig(HERE / "levels.png", dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    main()
