"""From packings to beds: conductivity and heat transfer coefficient of four
packings, used beside the literature's.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.heat_transfer import bed_nusselt
from contbed.closures import drag_di_felice, nusselt_gunn, nusselt_power
from contbed.dem import extract
from contbed.dem.heat_pair import STATIC, correction
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain
from contbed.materials.constant import ConstantFluid
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
SCENE = HERE / "heated_wall.toml"
SEEDS = (1, 2, 3, 4)
RATIOS = np.geomspace(5, 100, 9)
WIDTH, R, SOFT, REAL, K_FLUID = 0.026, 1e-3, 1e7, 5e10, 0.026
LITERATURE = ("zehner_schluender", "kunii_smith", "krupiczka", "hashin_shtrikman_lower")
SAMPLES = 12
PAIR = HERE / "moving_bed.toml"
VELOCITIES = np.geomspace(0.1, 3.0, 6)
PRANDTL = (0.68, 0.73)  # of air from 250 to 800 K
# of a single particle
LAWS = {"Zhou, Yu, Zulli": partial(nusselt_power, a=1.2, b=0.5), "Gunn": nusselt_gunn}
EXCHANGE = ("wakao_kaguei", "gunn", "ranz_marshall")


def packings() -> Iterator[extract.Packing]:
    """Beds of 2500 spheres with periodic sides, measured between z = 2 mm and 24 mm."""
    for seed in SEEDS:
        bed = pack(
            (WIDTH, WIDTH),
            radius=R,
            count=2500,
            seed=seed,
            periodic=(True, True),
            material=Material(density=1000.0, youngs_modulus=SOFT),
        )
        box = np.zeros(3), np.array([WIDTH, WIDTH, bed.position[:, 2].max() + R])
        yield extract.Packing(
            bed.position, R, bed.statistics["porosity_core"], 2e-3, 24e-3, WIDTH**2, box
        )


def fit(beds: Sequence[extract.Packing], paths: str = "cones") -> Any:
    """k/k_fluid over k_solid/k_fluid from some beds together."""
    data = extract.conductivity_sweep(
        beds, RATIOS, K_FLUID, correction(SOFT, REAL, STATIC), paths
    )
    k = data.pop("k/k_fluid")
    return extract.fit_log_polynomial(
        "conductivity", data, k, {extract.RATIO: "log"}, (3,)
    )


def exchange_points(bed: extract.Packing, law: Any) -> Any:
    """Re, Pr and mean Nu of the particles of a bed at rest, at all velocities and
    Prandtl numbers.
    """
    top = bed.x[:, 2].max() + R
    count = (4, 4, round(1.3 * top / (3 * R)))
    grid = Grid(
        np.zeros(3), np.array([WIDTH, WIDTH, 1.3 * top]) / count, count, (True, True)
    )
    domain = Domain((0, 0, 0), (WIDTH, WIDTH, np.inf), (True, True, False))
    points = []
    for Pr in PRANDTL:
        air = ConstantFluid(1.2, 1005.0, 1.8e-5, 1.8e-5 * 1005.0 / Pr)
        for U in VELOCITIES:
            simulation = Simulation(
                Particles(bed.x, R), [Material(1000.0, SOFT)], (), domain
            )
            gas = Gas(grid, air, drag_di_felice, law, isothermal=True)
            points.append(
                bed_nusselt(
                    Bed(simulation, gas, 1e-2, moving=False), U, 300.0, Solid(0.84)
                )
            )
    return np.array(points).T


def fit_exchange(beds: Sequence[extract.Packing], law: Any) -> Any:
    """Nu = 2 + a Re^b Pr^(1/3) of some beds together."""
    return extract.fit_power(
        *np.concatenate([exchange_points(bed, law) for bed in beds], axis=1)
    )


def outlet(conductivity: Any, scene: Path = SCENE, **overrides: Any) -> float:
    """Mean temperature of the gas at the outlet [K]."""
    changes = {
        "closures.conductivity_solids": conductivity,
        "output.plots": False,
        "output.fields": False,
        **overrides,
    }
    return float(cb.run(cb.load(scene, changes)).qoi["T_fluid_out_K"])


def outlet_of(found: Any, exchange: Any = None, scene: Path = SCENE) -> float:
    """The same with fits that are not kept."""
    with tempfile.TemporaryDirectory() as folder:
        files = {"conductivity": found} | (
            {} if exchange is None else {"exchange": exchange}
        )
        for name, fit in files.items():
            fit.write(Path(folder) / f"{name}.toml", {"scene": "sample"})
        more = (
            {}
            if exchange is None
            else {"closures.nusselt": {"file": str(Path(folder) / "exchange.toml")}}
        )
        return outlet({"file": str(Path(folder) / "conductivity.toml")}, scene, **more)


def reference() -> dict[str, float]:
    """Outlet temperatures [K] with conductivities of the literature."""
    return {name: outlet(name) for name in LITERATURE}


def of_exchange(scene: Path) -> dict[str, float]:
    """Outlet temperatures [K] with Zehner and Schluender's conductivity and each
    exchange of the literature.
    """
    return {
        f"zehner_schluender, {nusselt}": outlet(
            "zehner_schluender", scene, **{"closures.nusselt": nusselt}
        )
        for nusselt in EXCHANGE
    }


def both(beds: Sequence[extract.Packing], conductivity: Any) -> Table:
    """Conductivity and exchange from the packings in a packed and a moving bed,
    beside those of the literature.
    """
    laws = {name: fit_exchange(beds, law) for name, law in LAWS.items()}
    fit_of = laws["Zhou, Yu, Zulli"]
    fit_of.write(
        HERE / "closures/nusselt.toml",
        {"scene": "closure_transfer/study.py", "seeds": str(SEEDS)},
    )
    print(
        "Nusselt",
        {name: law.content["parameters"] for name, law in laws.items()},
        fit_of.content["residuals"],
    )
    ours = {"closures.nusselt": {"file": "closures/nusselt.toml"}}
    rows: list[tuple[Any, ...]] = []
    for scene in (SCENE, PAIR):
        base = outlet({"file": "closures/conductivity.toml"}, scene, **ours)
        single = [
            outlet_of(fit([bed]), fit_exchange([bed], LAWS["Zhou, Yu, Zulli"]), scene)
            for bed in beds
        ]
        drawn = [
            outlet_of(
                replace(conductivity, content=k.content),
                replace(fit_of, content=Nu.content),
                scene,
            )
            for k, Nu in zip(
                conductivity.samples(SAMPLES, seed=1),
                fit_of.samples(SAMPLES, seed=2),
                strict=True,
            )
        ]
        rows.append(
            (scene.stem, "packings", base, np.std(single, ddof=1), np.std(drawn))
        )
        gunn = outlet_of(conductivity, laws["Gunn"], scene)
        rows.append((scene.stem, "packings, Gunn at every particle", gunn, None, None))
        rows += [
            (scene.stem, what, T, None, None) for what, T in of_exchange(scene).items()
        ]
    columns = {"scene": "", "closures": ""}
    columns |= dict.fromkeys(
        ("T_out [K]", "over packings [K]", "over parameters [K]"), ".4f"
    )
    return Table(columns, rows)


def compute() -> Tables:
    """Fits of the packings, written as closure files, and outlet temperatures with
    them and with the literature.
    """
    beds = list(packings())
    whole = fit(beds)
    whole.write(
        HERE / "closures/conductivity.toml",
        {"scene": "closure_transfer/study.py", "seeds": str(SEEDS)},
    )
    print(
        "porosities",
        [round(bed.porosity, 4) for bed in beds],
        "residuals",
        whole.content["residuals"],
    )
    ours = outlet({"file": "closures/conductivity.toml"})
    found = {
        "packings, cones (Eq. 5)": ours,
        "packings, columns": outlet_of(fit(beds, "columns")),
        **reference(),
    }
    each = [outlet_of(fit([bed])) for bed in beds]
    drawn = [
        outlet_of(replace(whole, content=c.content))
        for c in whole.samples(SAMPLES, seed=1)
    ]
    mesh = outlet({"file": "closures/conductivity.toml"}, **{"mesh.cells": [48, 120]})
    print(
        f"deviation over packings {np.std(each, ddof=1):.3f} K, over the parameters "
        f"{np.std(drawn):.3f} K"
    )
    print(f"finer mesh {mesh - ours:+.4f} K")
    columns = {"conductivity": "", "T_out [K]": ".3f", "difference [K]": ".3f"}
    rows = [(name, T, T - ours) for name, T in found.items()]
    return {"outlet": Table(columns, rows), "outlet_both": both(beds, whole)}


def plot(tables: Tables) -> dict[str, Any]:
    """Outlet temperatures by conductivity, and by both closures in each scene."""
    scenes = tables["outlet_both"].values("scene")
    figure, panels = gallery.figure(1, 1 + len(scenes), size=(13, 3.6))
    parts = [(tables["outlet"], "conductivity", "heated_wall, conductivity")]
    parts += [
        (tables["outlet_both"].where({"scene": name}), "closures", f"{name}, both")
        for name in scenes
    ]
    for axes, (table, names, title) in zip(panels, parts, strict=True):
        colours = [
            gallery.BLUE if name.startswith("packings") else gallery.GREY
            for name in table[names]
        ]
        axes.scatter(table["T_out [K]"], range(len(table)), color=colours)
        axes.set_yticks(range(len(table)), table[names], fontsize=8)
        axes.invert_yaxis()
        axes.set(xlabel="gas at the outlet [K]", title=title)
    return {"outlet": figure}
