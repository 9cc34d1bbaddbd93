"""Every row of Table 3 of Pivem & de Lemos (2012): closed form, Figs. 3-6, readings
of the paper, Brinkman flow.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.packed_bed.recognition import velocities
from studies import _exact as exact
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
LITERAL = {
    "area": 4.0,
    "exponent": 1.0,
    "from_properties": False,
    "wakao": False,
    "density": None,
    "viscosity": None,
}
READINGS = {
    "as printed": {},
    "spheres: a = 6(1-phi)/D": {"area": 6.0},
    "Re_D from Table 2 (Eq. 21)": {"from_properties": True},
    "Re^0.6 in Eq. 20": {"exponent": 0.6},
    "Re^0.6 and Re_D from Table 2": {"exponent": 0.6, "from_properties": True},
    "Re^0.6 and spheres": {"exponent": 0.6, "area": 6.0},
    "Eq. 19 (Wakao) and spheres": {"wakao": True, "area": 6.0},
    "Re^0.6 with rho = 1 kg/m3 and mu = 1.7e-5 Pa s": {
        "exponent": 0.6,
        "density": 1.0,
        "viscosity": 1.7e-5,
    },
    "true solid velocity: superficial (1-phi) u_s": {"true_velocity": True},
}
# rows in readings.csv
SHOWN = ("conductivity_1_slip_0.0", "conductivity_1_slip_0.4", "slip_0.50")
THETA = {"fluid": "theta_fluid [1]", "solid": "theta_solid [1]"}
ERRORS = (
    "error_fluid [1]",
    "error_solid [1]",
    "error_equilibrium [1]",
    "error_length [1]",
)
NOT_COMPARED = ERRORS
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


def reference() -> dict[str, dict[str, float]]:
    """Rows of Table 3 by the name of their scene."""
    printed = Table.read(HERE / "table3.csv")
    return {name: printed.row(name) for name in printed.values("scene")}


def coefficients(scene: cb.Scene, **reading: Any) -> dict[str, float]:
    """Arguments of the exact solutions from the values in the scene, under one
    reading of the paper.
    """
    choice = {**LITERAL, "true_velocity": False, **reading}
    fluid, solid, eps, d = (
        scene.gas,
        scene.solid,
        scene.packed_bed.porosity,
        scene.diameter,
    )
    u, u_solid = (float(vector[0]) for vector in velocities(scene))
    density, viscosity = (
        choice["density"] or fluid.density,
        choice["viscosity"] or fluid.viscosity,
    )
    Re = (
        density * abs(u - u_solid) * d / viscosity
        if choice["from_properties"]
        else scene.packed_bed.reynolds
    )
    Pr = viscosity * fluid.heat_capacity / fluid.conductivity
    if choice["wakao"]:
        Nu = 2 + 1.1 * Re**0.6 * Pr ** (1 / 3)
    else:
        Nu = (
            1
            + 4 * (1 - eps) / eps
            + 0.5 * (1 - eps) ** 0.5 * Re ** choice["exponent"] * Pr ** (1 / 3)
        )
    moved = u_solid * (1 - eps) if choice["true_velocity"] else u_solid
    return {
        "flux_fluid": density * fluid.heat_capacity * u,
        "flux_solid": density
        * (solid.density / fluid.density)
        * solid.heat_capacity
        * moved,
        "d_fluid": eps * fluid.conductivity,
        "d_solid": (1 - eps) * solid.conductivity,
        "ha": Nu * fluid.conductivity / d * choice["area"] * (1 - eps) / d,
    }


def equilibrium(scene: cb.Scene, **reading: Any) -> tuple[float, float]:
    """Equilibrium theta and the length [m] on which the difference of theta falls to
    0.01.
    """
    rate, direction = exact.decay_rate(**coefficients(scene, **reading))
    return 1 / (1 - direction), np.log(100) / rate


def errors(scene: cb.Scene, result: cb.Result) -> tuple[float, ...]:
    """Differences from the closed form: theta of fluid and solid anywhere,
    equilibrium theta, relative length.
    """
    f, s = exact.semi_infinite(result.profiles["x [m]"], **coefficients(scene))
    theta, length = equilibrium(scene)
    return (
        np.abs(result.profiles["theta_fluid [1]"] - f).max(),
        np.abs(result.profiles["theta_solid [1]"] - s).max(),
        result.qoi["theta_equilibrium"] - theta,
        result.qoi["equilibrium_length_m"] / length - 1,
    )


def compute() -> Tables:
    """All rows beside the closed form, readings of the paper, and three rows with
    the flow of a channel.
    """
    scenes = {name: cb.load(HERE / f"{name}.toml") for name in reference()}
    results = {name: cb.run(scene) for name, scene in scenes.items()}
    rows, profiles = [], []
    for name, result in results.items():
        c = coefficients(scenes[name])
        mixing = c["flux_solid"] / (c["flux_fluid"] + c["flux_solid"])
        found = (
            result.qoi["theta_equilibrium"],
            mixing,
            result.qoi["equilibrium_length_m"],
        )
        rows.append((name, *found, *errors(scenes[name], result)))
        x = np.linspace(0, 1, 41) ** 2 * result.profiles["x [m]"][-1]
        theta = (
            np.interp(x, result.profiles["x [m]"], result.profiles[key])
            for key in THETA.values()
        )
        profiles += [(name, *row) for row in zip(x, *theta, strict=True)]
    columns = {
        "scene": "",
        "theta_equilibrium [1]": ".6f",
        "mixing theta [1]": ".6f",
        "equilibrium_length [m]": ".6f",
    }
    places = {"scene": "", "x [m]": ".5g"}
    return {
        "results": Table(columns | dict.fromkeys(ERRORS, ".1e"), rows),
        "readings": readings(scenes),
        "profiles": Table(places | dict.fromkeys(THETA.values(), ".5g"), profiles),
        **brinkman(results),
    }


def readings(scenes: dict[str, cb.Scene]) -> Table:
    """Equilibrium and its length under each reading of the paper."""
    columns = {"reading": ""}
    columns |= {
        f"{name}: {what}": ".4f"
        for name in SHOWN
        for what in ("theta_equilibrium [1]", "length [m]")
    }
    rows = [
        (
            text,
            *(
                value
                for name in SHOWN
                for value in equilibrium(scenes[name], **reading)
            ),
        )
        for text, reading in READINGS.items()
    ]
    return Table(columns, rows)


def brinkman(plug: dict[str, cb.Result]) -> Tables:
    """Three rows in two dimensions with walls that hold the fluid."""
    rows, profiles = [], []
    for name in BRINKMAN:
        scene = cb.load(HERE / "brinkman" / f"{name}.toml")
        result, flat = cb.run(scene), plug[name]
        keys = ("theta_equilibrium", "equilibrium_length_m", "T_fluid_out_K")
        pairs = [value for key in keys for value in (result.qoi[key], flat.qoi[key])]
        rows.append(
            (
                name,
                result.qoi["u_max_outlet"] / scene.boundary["left"].gas.velocity,
                *pairs,
            )
        )
        x = np.linspace(0, scene.mesh.length, 109)
        change = [
            np.interp(x, result.profiles["x [m]"], result.profiles[key])
            - np.interp(x, flat.profiles["x [m]"], flat.profiles[key])
            for key in THETA.values()
        ]
        profiles += [(name, *row) for row in zip(x, *change, strict=True)]
    columns = {"scene": "", "u_max/u_D at the outlet [1]": ".4f"}
    for name in (
        "theta_equilibrium on the axis [1]",
        "equilibrium_length on the axis [m]",
        "T_fluid_out [K]",
    ):
        columns[name] = columns[f"plug {name[name.index('[') :]}"] = ".5g"
    return {
        "brinkman": Table(columns, rows),
        "brinkman_profiles": Table(
            {"scene": "", "x [m]": ".5g", **dict.fromkeys(THETA.values(), ".4g")},
            profiles,
        ),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Figs. 3 to 6 of the paper, and what the flow in the channel changes."""
    return {
        "figures_3_to_6": plot_rows(tables),
        "brinkman": plot_brinkman(tables["brinkman_profiles"]),
    }


def plot_rows(tables: Tables) -> Any:
    """Profiles of all rows, up to 1.2 times the longest equilibrium length of each
    figure.
    """
    figure, panels = gallery.figure(2, 4, size=(13, 6), sharey=True)
    values = reference()
    for axes, (title, key, names) in zip(panels.ravel(), PANELS, strict=True):
        for name, colour in zip(names, gallery.shades(len(names)), strict=True):
            p = tables["profiles"].where({"scene": name})
            x = 1e3 * p["x [m]"]
            axes.plot(
                x, p["theta_solid [1]"], color=colour, label=f"{values[name][key]:g}"
            )
            axes.plot(x, p["theta_fluid [1]"], color=colour, linestyle=(0, (4, 2)))
        longest = max(
            tables["results"].row(name)["equilibrium_length [m]"] for name in names
        )
        axes.set(
            title=f"Fig. {title}",
            xlim=(0, 1.2e3 * longest),
            ylim=(0, 1.3),
            yticks=np.linspace(0, 1, 6),
        )
        axes.legend(
            loc="upper right", ncols=len(names), handlelength=1, columnspacing=1
        )
    for axes in panels[-1]:
        axes.set_xlabel("x [mm]")
    for axes in panels[:, 0]:
        axes.set_ylabel(r"$\theta_s$ (full), $\theta_f$ (dashed)")
    return figure


def plot_brinkman(profiles: Table) -> Any:
    """Temperatures on the axis of the channel minus those of plug flow."""
    figure, panels = gallery.figure(1, 3, sharey=True)
    for axes, name in zip(panels, BRINKMAN, strict=True):
        found = profiles.where({"scene": name})
        for (phase, key), colour in zip(
            THETA.items(), (gallery.BLUE, gallery.VERMILION), strict=True
        ):
            axes.plot(found["x [m]"], found[key], color=colour, label=phase)
        axes.axhline(0, color="black", linewidth=0.6)
        axes.set(title=name, xlabel=gallery.label("x"), xlim=(0, found["x [m]"][-1]))
    panels[0].set_ylabel(r"$\theta$ on the axis minus plug flow")
    panels[0].legend()
    return figure
