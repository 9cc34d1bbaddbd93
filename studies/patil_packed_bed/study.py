"""Heating of a packed bed (Patil, Peters & Kuipers, Fig. 1): Schumann's solution, both readings of Table 1, dispersion.

python studies/patil_packed_bed/study.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import mpmath
import numpy as np

import contbed as cb
from contbed.verify import exact

HERE = Path(__file__).parent
SCENES = ("schumann", "schumann_bed_b", "dispersion")
SPACING = {"schumann": 0.1, "schumann_bed_b": 0.1, "dispersion": 0.05}  # of the positions in errors.csv [m]


def gunn(Re, Pr, eps):
    """Nusselt number of Eq. 5 as printed."""
    return (7 - 10 * eps + 5 * eps**2) * (1 + 0.7 * Re**0.2 * Pr**0.33) + (
        1.33 - 2.4 * eps + 1.2 * eps**2
    ) * Re**0.7 * Pr**0.33


def rates(scene):
    """Interstitial velocity [m/s] and the exchange rates h a/(eps rho c_p)_f and h a/((1 - eps) rho c_p)_s [1/s]."""
    fluid, solid, eps, d = scene.fluid, scene.solid, scene.bed.porosity, scene.bed.particle_diameter
    Re = fluid.density * scene.flow.velocity * d / fluid.viscosity
    Pr = fluid.viscosity * fluid.heat_capacity / fluid.conductivity
    ha = gunn(Re, Pr, eps) * fluid.conductivity / d * 6 * (1 - eps) / d
    capacity = fluid.density * fluid.heat_capacity, solid.density * solid.heat_capacity
    return scene.flow.velocity / eps, ha / (eps * capacity[0]), ha / ((1 - eps) * capacity[1])


def with_dispersion(z, t, scene):
    """Fluid and solid theta at one point: numerical inversion (Talbot's contour) of the exact Laplace transform.

    f_t + u f_z = alpha f_zz + A (s - f), s_t = B (f - s); u f - alpha f_z = u at z = 0 (Danckwerts), f_z = 0 at z = L.
    """
    u, A, B = (mpmath.mpf(float(value)) for value in rates(scene))
    fluid, length = scene.fluid, mpmath.mpf(scene.mesh.length)
    capacity = scene.bed.porosity * fluid.density * fluid.heat_capacity
    alpha = mpmath.mpf((scene.heat.conductivity_fluid + scene.heat.dispersion.axial) / capacity)

    def transform(p):
        root = mpmath.sqrt(u**2 + 4 * alpha * (p + A * p / (p + B)))
        falling, rising = (u - root) / (2 * alpha), (u + root) / (2 * alpha)
        back = -falling / rising * mpmath.exp((falling - rising) * length)
        shape = mpmath.exp(falling * z) + back * mpmath.exp(rising * z)
        return u / p * shape / (u - alpha * falling + back * (u - alpha * rising))

    with mpmath.workdps(30):
        f = mpmath.invertlaplace(transform, t, method="talbot", degree=40)
        s = mpmath.invertlaplace(lambda p: transform(p) * B / (p + B), t, method="talbot", degree=40)
    return float(f), float(s)


def reference(scene, z, t):
    """Exact theta of fluid and solid at z [m] and t [s], from the values in the scene."""
    if scene.heat.dispersion is None:
        return exact.schumann(z, t, *rates(scene))
    return np.array([with_dispersion(a, b, scene) for a, b in zip(z, t, strict=True)]).T


def points(name, result):
    """The output points that are compared: multiples of the spacing."""
    z = result.profiles["z [m]"]
    return np.isclose(z / SPACING[name], np.round(z / SPACING[name]))


def errors(scene, result, chosen=slice(None)):
    """Differences of theta from the reference at the chosen output points; fluid and solid."""
    columns = {name: values[chosen] for name, values in result.profiles.items()}
    f, s = reference(scene, columns["z [m]"], columns["t [s]"])
    return columns["theta_fluid [1]"] - f, columns["theta_solid [1]"] - s


def main():
    scenes = {name: cb.load(HERE / f"{name}.toml") for name in SCENES}
    results = {name: cb.run(scene) for name, scene in scenes.items()}
    lines = ["scene,t [s],z [m],theta_fluid [1],theta_solid [1],error_fluid [1],error_solid [1]"]
    for name, result in results.items():
        chosen = points(name, result)
        columns = [result.profiles[key][chosen] for key in ("t [s]", "z [m]", "theta_fluid [1]", "theta_solid [1]")]
        differences = errors(scenes[name], result, chosen)
        print(f"{name}: largest error {max(np.abs(d).max() for d in differences):.1e} at {chosen.sum()} points")
        for row in zip(*columns, *differences, strict=True):
            numbers = [f"{value:.8g}" for value in row[:4]] + [f"{value:.1e}" for value in row[4:]]
            lines.append(",".join([name, *numbers]))
    (HERE / "errors.csv").write_text("\n".join(lines) + "\n", encoding="ascii")
    plot(scenes, results)


def plot(scenes, results):
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    titles = ("bed A, no conduction", "bed B, no conduction", "bed A with axial dispersion")
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.8), sharey=True, layout="constrained")
    for axes, name, title in zip(panels, SCENES, titles, strict=True):
        p = results[name].profiles
        times = np.unique(p["t [s]"])
        z = np.arange(SPACING[name], scenes[name].mesh.length + 1e-9, SPACING[name])
        for time, colour in zip(times, plt.get_cmap("viridis")(np.linspace(0, 0.85, len(times))), strict=True):
            at = p["t [s]"] == time
            along, fluid, solid = (p[key][at] for key in ("z [m]", "theta_fluid [1]", "theta_solid [1]"))
            axes.plot(along, 1 - fluid, color=colour, label=f"{time:.3g} s")
            axes.plot(along, 1 - solid, color=colour, linestyle=(0, (4, 2)), linewidth=1)
            f, _ = reference(scenes[name], z, np.full_like(z, time))
            axes.plot(z, 1 - f, "o", color=colour, markersize=4, markerfacecolor="white", clip_on=False, zorder=3)
        axes.set(title=title, xlabel="z [m]", xlim=(0, scenes[name].mesh.length), ylim=(-0.02, 1.02))
    panels[0].set_ylabel(r"$(T_{in}-T)/(T_{in}-T_0)$")
    shapes = [
        plt.Line2D([], [], color="black", label="fluid"),
        plt.Line2D([], [], color="black", linestyle=(0, (4, 2)), linewidth=1, label="solid"),
        plt.Line2D([], [], color="black", linestyle="", marker="o", markerfacecolor="white", label="fluid, exact"),
    ]
    panels[1].legend(handles=[*panels[0].lines[::3], *shapes], fontsize=8, loc="lower right")
    figure.savefig(HERE / "profiles.png", dpi=200)
    plt.close(figure)


if __name__ == "__main__":
    main()
