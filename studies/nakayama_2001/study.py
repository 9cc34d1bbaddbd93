"""Hot fluid through a cold stationary bed with tortuosity and dispersion: the exact solution of Nakayama et al. (2001).

python studies/nakayama_2001/study.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.verify import exact

HERE = Path(__file__).parent
PRINTED = {"G": -0.013219, "alpha": 0.625}  # Table 1 of Pivem & de Lemos (2012)


def groups(scene):
    """Dimensionless numbers of a scene (Eqs. 30-34) and the length sqrt(k_f/(a h)) of X [m], Wakao's coefficient."""
    fluid, eps, d = scene.fluid, scene.bed.porosity, scene.bed.particle_diameter
    Pr = fluid.viscosity * fluid.heat_capacity / fluid.conductivity
    Pe_d = fluid.density * fluid.heat_capacity * scene.flow.velocity * d / fluid.conductivity
    ratio = scene.solid.conductivity / fluid.conductivity
    Nu = 2 + 1.1 * (Pe_d / Pr) ** 0.6 * Pr ** (1 / 3)
    return {
        "Pe": exact.nakayama_peclet(Pe_d, Pr, eps),
        "ratio": ratio,
        "dispersion": scene.heat.dispersion.axial / fluid.conductivity,
        "G": exact.tortuosity_parameter(eps, ratio),
        "length": d / np.sqrt(6 * (1 - eps) * Nu),
    }


def coefficients(scene):
    """Arguments of the exact solutions, from the values in the scene."""
    g = groups(scene)
    return exact.nakayama_coefficients(g["Pe"], scene.bed.porosity, g["ratio"], g["dispersion"], g["G"])


def reference(scene, x):
    """Exact theta of fluid and solid, hot fluid over a cold bed: Eqs. 28 and 29."""
    f, s = exact.semi_infinite(x / groups(scene)["length"], **coefficients(scene))
    return 1 - f, 1 - s


def exact_parameters(scene):
    """alpha and theta far downstream."""
    alpha, direction = exact.decay_rate(**coefficients(scene))
    return {"alpha": alpha, "theta_inf": 1 - 1 / (1 - direction)}


def found_parameters(scene, result):
    """alpha fitted to the logarithm of theta_fluid - theta_solid between 1 and 0.01, and theta at the outlet."""
    p = result.profiles
    gap = p["theta_fluid [1]"] - p["theta_solid [1]"]
    X = p["x [m]"] / groups(scene)["length"]
    used = (gap > 0.01) & (gap < 1)
    return {"alpha": -np.polyfit(X[used], np.log(gap[used]), 1)[0], "theta_inf": p["theta_solid [1]"][-1]}


def errors(scene, result):
    """Differences of theta from the exact solution; fluid and solid."""
    f, s = reference(scene, result.profiles["x [m]"])
    return result.profiles["theta_fluid [1]"] - f, result.profiles["theta_solid [1]"] - s


def main():
    scene = cb.load(HERE / "hot_fluid.toml")
    result = cb.run(scene)
    found, wanted = found_parameters(scene, result), exact_parameters(scene)
    rows = [(name, f"{found[name]:.12f}", f"{wanted[name]:.12f}", found[name] - wanted[name]) for name in found]
    for phase, difference in zip(("fluid", "solid"), errors(scene, result), strict=True):
        rows.append((f"theta_{phase}", "profile", "profile", np.abs(difference).max()))
    lines = ["quantity [1],contbed,exact,difference"] + [f"{a},{b},{c},{d:.1e}" for a, b, c, d in rows]
    print("\n".join(lines))
    (HERE / "results.csv").write_text("\n".join(lines) + "\n", encoding="ascii")
    plot(scene, result)


def plot(scene, result):
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    p, g = result.profiles, groups(scene)
    X = p["x [m]"] / g["length"]
    marks = np.linspace(0, 10, 21)
    alpha = PRINTED["alpha"]
    weight = alpha * g["ratio"] * (1 - scene.bed.porosity + (g["ratio"] - 1) * g["G"])
    stagnant = scene.bed.porosity + g["G"] * (1 - g["ratio"]) ** 2 + (1 - scene.bed.porosity) * g["ratio"]
    weight /= g["Pe"] + alpha * (stagnant + g["dispersion"])
    printed_f = 1 + weight * np.expm1(-alpha * marks)
    printed = {"fluid": printed_f, "solid": printed_f - np.exp(-alpha * marks)}
    for phase, colour in (("fluid", "#0072B2"), ("solid", "#D55E00")):
        left.plot(X, p[f"theta_{phase} [1]"], color=colour, label=f"{phase}, contbed")
        line = dict(zip(("fluid", "solid"), reference(scene, marks * g["length"]), strict=True))[phase]
        left.plot(marks, line, "o", color=colour, markerfacecolor="white", markersize=4, label=f"{phase}, exact")
        right.plot(marks, printed[phase] - line, "o-", color=colour, markersize=4, label=phase)
    left.set(xlabel="X", ylabel=r"$\theta_f,\ \theta_s$", xlim=(0, 10), ylim=(0, 1.02))
    left.legend(loc="lower right")
    right.set(xlabel="X", ylabel=r"$\theta$ with printed $\alpha = 0.625$, minus exact", xlim=(0, 10))
    right.axhline(0, color="black", linewidth=0.6)
    right.legend()
    figure.savefig(HERE / "profiles.png", dpi=200)
    plt.close(figure)


if __name__ == "__main__":
    main()
