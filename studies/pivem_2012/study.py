"""Every row of Table 3 of Pivem & de Lemos (2012): closed form, Figs. 3-6, readings of the paper, Brinkman flow.

python studies/pivem_2012/study.py
"""

import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contbed as cb
from contbed.verify import exact

HERE = Path(__file__).parent
LITERAL = {"area": 4.0, "exponent": 1.0, "from_properties": False, "wakao": False, "density": None, "viscosity": None}
READINGS = {
    "as printed": {},
    "spheres: a = 6(1-phi)/D": {"area": 6.0},
    "Re_D from Table 2 (Eq. 21)": {"from_properties": True},
    "Re^0.6 in Eq. 20": {"exponent": 0.6},
    "Re^0.6 and Re_D from Table 2": {"exponent": 0.6, "from_properties": True},
    "Re^0.6 and spheres": {"exponent": 0.6, "area": 6.0},
    "Eq. 19 (Wakao) and spheres": {"wakao": True, "area": 6.0},
    "Re^0.6 with rho = 1 kg/m3 and mu = 1.7e-5 Pa s": {"exponent": 0.6, "density": 1.0, "viscosity": 1.7e-5},
    "true solid velocity: superficial (1-phi) u_s": {"true_velocity": True},
}
SHOWN = ("conductivity_1_slip_0.0", "conductivity_1_slip_0.4", "slip_0.50")  # rows in readings.csv
BRINKMAN = ("slip_0.50", "slip_0.95", "darcy_9.365e-3")
PANELS = (
    ("3a: $Re_D$", "Re_D", ("reynolds_10", "reynolds_50", "reynolds_100")),
    ("3b: $u_s/u_D$", "slip_us_over_uD", ("slip_0.00", "slip_0.25", "slip_0.50", "slip_0.75", "slip_0.95")),
    ("4a: Da", "Da", ("darcy_9.365e-5", "darcy_8.429e-4", "darcy_9.365e-3")),
    (r"4b: $\phi$", "porosity", ("porosity_0.4", "porosity_0.6", "porosity_0.8")),
    (r"5: $(\rho c_p)_s/(\rho c_p)_f$", "capacity_ratio_s_over_f",
     ("capacity_0.25", "capacity_0.5", "capacity_1.0", "capacity_10.0")),
    *(
        (f"6{letter}: $k_s/k_f$, $u_s/u_D = {slip}$", "conductivity_ratio_s_over_f",
         tuple(f"conductivity_{k}_slip_{slip}" for k in (1, 10, 100, 1000)))
        for letter, slip in (("a", "0.0"), ("b", "0.1"), ("c", "0.4"))
    ),
)  # fmt: skip


def table():
    """Rows of Table 3 by the name of their scene."""
    with (HERE / "table3.csv").open(newline="", encoding="ascii") as file:
        return {row.pop("scene"): {key: float(value) for key, value in row.items()} for row in csv.DictReader(file)}


def coefficients(scene, **reading):
    """Arguments of the exact solutions from the values in the scene, under one reading of the paper."""
    choice = {**LITERAL, "true_velocity": False, **reading}
    fluid, solid, eps, d = scene.fluid, scene.solid, scene.bed.porosity, scene.bed.particle_diameter
    u, u_solid = scene.flow.velocity, scene.flow.velocity_solid
    density, viscosity = choice["density"] or fluid.density, choice["viscosity"] or fluid.viscosity
    Re = density * abs(u - u_solid) * d / viscosity if choice["from_properties"] else scene.heat.reynolds
    Pr = viscosity * fluid.heat_capacity / fluid.conductivity
    if choice["wakao"]:
        Nu = 2 + 1.1 * Re**0.6 * Pr ** (1 / 3)
    else:
        Nu = 1 + 4 * (1 - eps) / eps + 0.5 * (1 - eps) ** 0.5 * Re ** choice["exponent"] * Pr ** (1 / 3)
    moved = u_solid * (1 - eps) if choice["true_velocity"] else u_solid
    return {
        "flux_fluid": density * fluid.heat_capacity * u,
        "flux_solid": density * (solid.density / fluid.density) * solid.heat_capacity * moved,
        "d_fluid": eps * fluid.conductivity,
        "d_solid": (1 - eps) * solid.conductivity,
        "ha": Nu * fluid.conductivity / d * choice["area"] * (1 - eps) / d,
    }


def equilibrium(scene, **reading):
    """Equilibrium theta and the length [m] on which the difference of theta falls to 0.01."""
    rate, direction = exact.decay_rate(**coefficients(scene, **reading))
    return 1 / (1 - direction), np.log(100) / rate


def errors(scene, result):
    """Differences from the closed form: theta of fluid and solid anywhere, equilibrium theta, relative length."""
    f, s = exact.semi_infinite(result.profiles["x [m]"], **coefficients(scene))
    theta, length = equilibrium(scene)
    return (
        np.abs(result.profiles["theta_fluid [1]"] - f).max(),
        np.abs(result.profiles["theta_solid [1]"] - s).max(),
        result.qoi["theta_equilibrium"] - theta,
        result.qoi["equilibrium_length_m"] / length - 1,
    )


def write(name, rows):
    (HERE / name).write_text("\n".join(rows) + "\n", encoding="ascii")


def main():
    scenes = {name: cb.load(HERE / f"{name}.toml") for name in table()}
    results = {name: cb.run(scene) for name, scene in scenes.items()}
    rows = [
        "scene,theta_equilibrium [1],mixing theta [1],equilibrium_length [m],"
        "error_fluid [1],error_solid [1],error_equilibrium [1],error_length [1]"
    ]
    worst = 0.0
    for name, result in results.items():
        c, difference = coefficients(scenes[name]), errors(scenes[name], result)
        worst = max(worst, *np.abs(difference))
        mixing = c["flux_solid"] / (c["flux_fluid"] + c["flux_solid"])
        found = result.qoi["theta_equilibrium"], mixing, result.qoi["equilibrium_length_m"]
        rows.append(",".join([name, *(f"{v:.6f}" for v in found), *(f"{v:.1e}" for v in difference)]))
    write("results.csv", rows)
    print(f"{len(results)} rows, largest difference from the closed form {worst:.1e}")
    rows = ["reading," + ",".join(f"{name}: theta_equilibrium [1],{name}: length [m]" for name in SHOWN)]
    for label, reading in READINGS.items():
        values = [value for name in SHOWN for value in equilibrium(scenes[name], **reading)]
        rows.append(",".join([label, *(f"{value:.4f}" for value in values)]))
    write("readings.csv", rows)
    figures(results)
    brinkman(results)


def style():
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})


def figures(results):
    """Figs. 3 to 6 of the paper, up to 1.2 times the longest equilibrium length of each."""
    style()
    figure, panels = plt.subplots(2, 4, figsize=(13, 6), sharey=True, layout="constrained")
    values = table()
    for axes, (title, key, names) in zip(panels.ravel(), PANELS, strict=True):
        for name, colour in zip(names, plt.get_cmap("viridis")(np.linspace(0, 0.85, len(names))), strict=True):
            p = results[name].profiles
            x = 1e3 * p["x [m]"]
            axes.plot(x, p["theta_solid [1]"], color=colour, label=f"{values[name][key]:g}")
            axes.plot(x, p["theta_fluid [1]"], color=colour, linestyle=(0, (4, 2)))
        longest = max(results[name].qoi["equilibrium_length_m"] for name in names)
        axes.set(title=f"Fig. {title}", xlim=(0, 1.2e3 * longest), ylim=(0, 1.3), yticks=np.linspace(0, 1, 6))
        axes.legend(loc="upper right", fontsize=8, ncols=len(names), handlelength=1, columnspacing=1)
    for axes in panels[-1]:
        axes.set_xlabel("x [mm]")
    for axes in panels[:, 0]:
        axes.set_ylabel(r"$\theta_s$ (full), $\theta_f$ (dashed)")
    figure.savefig(HERE / "figures_3_to_6.png", dpi=180)
    plt.close(figure)


def brinkman(plug):
    """Three rows in two dimensions with walls that hold the fluid."""
    rows = [
        "scene,u_max/u_D at the outlet [1],theta_equilibrium on the axis [1],plug [1],"
        "equilibrium_length on the axis [m],plug [m],T_fluid_out [K],plug [K]"
    ]
    style()
    figure, panels = plt.subplots(1, 3, figsize=(12, 3.8), sharey=True, layout="constrained")
    for axes, name in zip(panels, BRINKMAN, strict=True):
        scene = cb.load(HERE / "brinkman" / f"{name}.toml")
        result = cb.run(scene)
        keys = ("theta_equilibrium", "equilibrium_length_m", "T_fluid_out_K")
        pairs = [f"{result.qoi[key]:.5g},{plug[name].qoi[key]:.5g}" for key in keys]
        rows.append(",".join([name, f"{result.qoi['u_max_outlet'] / scene.flow.velocity:.4f}", *pairs]))
        x = result.profiles["x [m]"]
        for phase, colour in (("fluid", "#0072B2"), ("solid", "#D55E00")):
            column = f"theta_{phase} [1]"
            in_plug = np.interp(x, plug[name].profiles["x [m]"], plug[name].profiles[column])
            axes.plot(x, result.profiles[column] - in_plug, color=colour, label=phase)
        axes.axhline(0, color="black", linewidth=0.6)
        axes.set(title=name, xlabel="x [m]", xlim=(0, scene.mesh.length))
    panels[0].set_ylabel(r"$\theta$ on the axis minus plug flow")
    panels[0].legend()
    write("brinkman.csv", rows)
    figure.savefig(HERE / "brinkman.png", dpi=180)
    plt.close(figure)


if __name__ == "__main__":
    main()
