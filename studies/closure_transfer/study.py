"""From packings to beds: conductivity and heat transfer coefficient of four packings, used beside the literature's.

python studies/closure_transfer/study.py
"""

import csv
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

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
LAWS = {"Zhou, Yu, Zulli": partial(nusselt_power, a=1.2, b=0.5), "Gunn": nusselt_gunn}  # of a single particle
EXCHANGE = ("wakao_kaguei", "gunn", "ranz_marshall")


def packings():
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
        yield extract.Packing(bed.position, R, bed.statistics["porosity_core"], 2e-3, 24e-3, WIDTH**2, box)


def fit(beds, paths="cones"):
    """k/k_fluid over k_solid/k_fluid from some beds together."""
    data = extract.conductivity_sweep(beds, RATIOS, K_FLUID, correction(SOFT, REAL, STATIC), paths)
    k = data.pop("k/k_fluid")
    return extract.fit_log_polynomial("conductivity", data, k, {extract.RATIO: "log"}, (3,))


def exchange_points(bed, law):
    """Re, Pr and mean Nu of the particles of a bed at rest, at all velocities and Prandtl numbers."""
    top = bed.x[:, 2].max() + R
    count = (4, 4, round(1.3 * top / (3 * R)))
    grid = Grid(np.zeros(3), np.array([WIDTH, WIDTH, 1.3 * top]) / count, count, (True, True))
    domain = Domain((0, 0, 0), (WIDTH, WIDTH, np.inf), (True, True, False))
    points = []
    for Pr in PRANDTL:
        air = ConstantFluid(1.2, 1005.0, 1.8e-5, 1.8e-5 * 1005.0 / Pr)
        for U in VELOCITIES:
            simulation = Simulation(Particles(bed.x, R), [Material(1000.0, SOFT)], (), domain)
            gas = Gas(grid, air, drag_di_felice, law, isothermal=True)
            points.append(bed_nusselt(Bed(simulation, gas, 1e-2, moving=False), U, 300.0, Solid(0.84)))
    return np.array(points).T


def fit_exchange(beds, law):
    """Nu = 2 + a Re^b Pr^(1/3) of some beds together."""
    return extract.fit_power(*np.concatenate([exchange_points(bed, law) for bed in beds], axis=1))


def outlet(conductivity, scene=SCENE, **overrides):
    """Mean temperature of the gas at the outlet [K]."""
    changes = {"heat.conductivity_solid": conductivity, "output.plots": False, "output.fields": False, **overrides}
    return cb.run(cb.load(scene, changes)).qoi["T_fluid_out_K"]


def outlet_of(found, exchange=None, scene=SCENE):
    """The same with fits that are not kept."""
    with tempfile.TemporaryDirectory() as folder:
        files = {"conductivity": found} | ({} if exchange is None else {"exchange": exchange})
        for name, fit in files.items():
            fit.write(Path(folder) / f"{name}.toml", {"scene": "sample"})
        more = {} if exchange is None else {"heat.nusselt": {"file": str(Path(folder) / "exchange.toml")}}
        return outlet({"file": str(Path(folder) / "conductivity.toml")}, scene, **more)


def both(beds, conductivity):
    """Conductivity and exchange from the packings in a packed and a moving bed, beside those of the literature."""
    laws = {name: fit_exchange(beds, law) for name, law in LAWS.items()}
    fit_of = laws["Zhou, Yu, Zulli"]
    fit_of.write(HERE / "closures/nusselt.toml", {"scene": "closure_transfer/study.py", "seeds": str(SEEDS)})
    print("Nusselt", {name: law.content["parameters"] for name, law in laws.items()}, fit_of.content["residuals"])
    ours = {"heat.nusselt": {"file": "closures/nusselt.toml"}}
    rows = []
    for scene in (SCENE, PAIR):
        file = {"file": "closures/conductivity.toml"}
        base = outlet(file, scene, **ours)
        single = [outlet_of(fit([bed]), fit_exchange([bed], LAWS["Zhou, Yu, Zulli"]), scene) for bed in beds]
        drawn = [
            outlet_of(replace(conductivity, content=k.content), replace(fit_of, content=Nu.content), scene)
            for k, Nu in zip(conductivity.samples(SAMPLES, seed=1), fit_of.samples(SAMPLES, seed=2), strict=True)
        ]
        rows.append((scene.stem, "packings", base, np.std(single, ddof=1), np.std(drawn)))
        rows.append((scene.stem, "packings, Gunn at every particle", outlet_of(conductivity, laws["Gunn"], scene)))
        for nusselt in EXCHANGE:
            rows.append(
                (
                    scene.stem,
                    f"zehner_schluender, {nusselt}",
                    outlet("zehner_schluender", scene, **{"heat.nusselt": nusselt}),
                )
            )
    with open(HERE / "outlet_both.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["scene", "closures", "T_out [K]", "over packings [K]", "over parameters [K]"])
        writer.writerows(
            [name, what, *(f"{value:.4f}" for value in values), *[""] * (3 - len(values))]
            for name, what, *values in rows
        )
    for name, what, *values in rows:
        print(f"{name:12} {what:36}", *(f"{value:9.4f}" for value in values))


def main():
    beds = list(packings())
    whole = fit(beds)
    whole.write(HERE / "closures/conductivity.toml", {"scene": "closure_transfer/study.py", "seeds": str(SEEDS)})
    print("porosities", [round(bed.porosity, 4) for bed in beds], "residuals", whole.content["residuals"])
    rows = [("packings, cones (Eq. 5)", outlet({"file": "closures/conductivity.toml"}))]
    each = [outlet_of(fit([bed])) for bed in beds]
    drawn = [outlet_of(replace(whole, content=c.content)) for c in whole.samples(SAMPLES, seed=1)]
    rows.append(("packings, columns", outlet_of(fit(beds, "columns"))))
    rows += [(name, outlet(name)) for name in LITERATURE]
    mesh = outlet({"file": "closures/conductivity.toml"}, **{"mesh.cells": [48, 120]})
    with open(HERE / "outlet.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["conductivity", "T_out [K]", "difference [K]"])
        writer.writerows((name, f"{T:.3f}", f"{T - rows[0][1]:.3f}") for name, T in rows)
    for name, T in rows:
        print(f"{name:28} {T:8.3f} K {T - rows[0][1]:+7.3f} K")
    both(beds, whole)
    print(
        f"standard deviation over packings {np.std(each, ddof=1):.3f} K, over the parameters {np.std(drawn):.3f} K; "
        f"finer mesh {mesh - rows[0][1]:+.4f} K"
    )


if __name__ == "__main__":
    main()
