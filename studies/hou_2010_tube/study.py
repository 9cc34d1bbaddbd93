"""Local heat transfer coefficient around a horizontal tube in a bubbling bed: Hou,
Zhou and Yu 2010, Figs. 12, 13.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.closures import bed_tube_molerus_wirth, bed_tube_zabrodsky
from contbed.dem.packing import pack
from contbed.dem.particles import Material
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.raw import raw, resumed

HERE = Path(__file__).parent
SCENE = HERE / "tube.toml"
U_MF = 0.27  # m/s, of the paper; Ergun's of these particles at a porosity of 0.405
EPS_MF = 0.405
# velocity over minimum fluidization [m/s]; the paper has 0.08, 0.5, 0.8
EXCESS = ("0.08", "0.3", "0.5", "0.8")
SECTORS = {
    "excess velocity [m/s]": "g", "angle [deg]": "g", "h [W/m2/K]": ".4g", "h_contact "
                                                                           "[W/m2/K]": ".3g",
    "h_gap [W/m2/K]": ".4g", "h_convection [W/m2/K]": ".3g", "contacts [1]": ".3g", "eps [1]": ".3f",
    "h of the bed [W/m2/K]": ".4g",
}  # fmt: skip
PARTS = list(SECTORS)[2:]
OVERALL = {
    "excess velocity [m/s]": "g", **{name: SECTORS[name] for name in PARTS}, "height [m]": ".3f",
    "Molerus and Wirth [W/m2/K]": ".3g", "Zabrodsky, largest [W/m2/K]": ".3g",
}  # fmt: skip
COLOURS = dict(
    zip(
        EXCESS,
        (gallery.BLUE, gallery.GREEN, gallery.ORANGE, gallery.VERMILION),
        strict=True,
    )
)


def settled() -> Path:
    """File of the bed before it is fluidized, settled once for all velocities and
    with strong damping.
    """
    scene: Any = cb.load(SCENE)
    file, table, solid = raw(HERE.name) / "packing.csv", scene.particles, scene.solid
    if not file.is_file():
        sides = (table.periodic, table.periodic)
        damped = replace(Material.of(solid, table.modulus), restitution=0.3)
        bed = pack(
            table.width,
            radius=solid.radius,
            count=table.count,
            periodic=sides,
            material=damped,
            at_rest=1e-3,
        )
        file.parent.mkdir(parents=True, exist_ok=True)
        np.savetxt(file, bed.position, delimiter=",", header="x,y,z", comments="")
    return file.absolute()


def scene_of(excess: str, file: Path | None = None) -> Any:
    """Scene at a velocity above that of minimum fluidization [m/s]; it settles its
    bed, or takes that of a file.
    """
    start = (
        {} if file is None else {"particles.file": str(file), "particles.count": None}
    )
    return cb.load(
        SCENE, {"boundary.bottom.gas.velocity": U_MF + float(excess), **start}
    )


def reference(excess: str) -> tuple[float, float]:
    """Coefficients of the bed by correlations for fluidized beds [W/m2/K]: at this
    velocity, and the largest at any.
    """
    scene = scene_of(excess)
    fluid, d_p, rho_s = scene.gas, scene.solid.diameter, scene.solid.density
    Ar = d_p**3 * fluid.density * (rho_s - fluid.density) * 9.81 / fluid.viscosity**2
    at_velocity = bed_tube_molerus_wirth(
        Ar=Ar,
        u_excess=float(excess),
        u_mf=U_MF,
        eps_mf=EPS_MF,
        rho_gas=fluid.density,
        mu=fluid.viscosity,
        cp_gas=fluid.heat_capacity,
        k_gas=fluid.conductivity,
        rho_solid=rho_s,
        cp_solid=scene.solid.heat_capacity,
    )
    return float(at_velocity), float(
        bed_tube_zabrodsky(d_p=d_p, rho_solid=rho_s, k_gas=fluid.conductivity)
    )


def compute(cases: Sequence[str] = EXCESS) -> Tables:
    """Means by sector and around the tube for each velocity; a run that was cut off
    goes on, others are kept.
    """
    sectors, overall = [], []
    for excess in cases:
        scene = scene_of(excess, settled())
        result = resumed(scene, raw(HERE.name) / excess)
        # as measured: heat flux over the difference of tube and bed, whose particles
        # beside the tube have warmed up
        colder = (
            scene.particles.tubes["tube"].temperature - result.qoi["T_solid_mean_K"]
        )
        table = result.tables["tube_tube"] | {
            "h of the bed [W/m2/K]": result.tables["tube_tube"]["q [W/m2]"] / colder
        }
        sectors += [
            (float(excess), *row)
            for row in zip(*(table[name] for name in list(SECTORS)[1:]), strict=True)
        ]
        means = [
            table[name].sum() if name.startswith("contacts") else table[name].mean()
            for name in PARTS
        ]
        overall.append(
            (float(excess), *means, result.qoi["height [m]"], *reference(excess))
        )
    tables = {"sectors": Table(SECTORS, sectors), "overall": Table(OVERALL, overall)}
    keys = {
        "sectors": ["excess velocity [m/s]", "angle [deg]"],
        "overall": ["excess velocity [m/s]"],
    }
    return gallery.updated(HERE, tables, keys)


def plot(tables: Tables) -> dict[str, Any]:
    """Local coefficient, its parts and porosity over the angle."""
    figure, (left, middle, right) = gallery.figure(1, 3, size=(14.0, 4.6))
    for excess in tables["sectors"].values("excess velocity [m/s]"):
        found = tables["sectors"].where({"excess velocity [m/s]": excess})
        angle, h, colour = (
            found["angle [deg]"],
            found["h of the bed [W/m2/K]"],
            COLOURS[excess],
        )
        left.plot(
            angle,
            h,
            "o-",
            color=colour,
            label=f"{excess} m/s above minimum fluidization: mean {h.mean():.0f}",
        )
        left.plot(angle, found["h [W/m2/K]"], ":", color=colour)
        right.plot(angle, found["eps [1]"], "o-", color=colour)
        for name, style in (("h_gap", "o-"), ("h_convection", "s--")):
            middle.plot(angle, found[f"{name} [W/m2/K]"], style, color=colour)
    left.set(
        ylabel="$h$ [W/m$^2$/K]",
        ylim=(0, None),
        title="local; dotted: if nothing warmed up",
    )
    middle.set(
        ylabel="$h$ [W/m$^2$/K]",
        ylim=(0, None),
        title="gas in gaps; dashed: convection",
    )
    right.set(ylabel="porosity", title="within one diameter of the tube")
    for axes in (left, middle, right):
        axes.set(
            xlabel="angle from the bottom of the tube [deg]", xticks=range(0, 361, 60)
        )
    figure.legend(
        *left.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=len(COLOURS),
    )
    return {"tube": figure}
