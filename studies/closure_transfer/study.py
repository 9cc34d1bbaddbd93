"""From packings to a packed bed: effective conductivity of four packings as a closure, used beside the literature's.

python studies/closure_transfer/study.py
"""

import csv
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import contbed as cb
from contbed.dem import extract
from contbed.dem.heat_pair import STATIC, correction
from contbed.dem.packing import pack
from contbed.dem.particles import Material

HERE = Path(__file__).parent
SCENE = HERE / "heated_wall.toml"
SEEDS = (1, 2, 3, 4)
RATIOS = np.geomspace(5, 100, 9)
WIDTH, R, SOFT, REAL, K_FLUID = 0.026, 1e-3, 1e7, 5e10, 0.026
LITERATURE = ("zehner_schluender", "kunii_smith", "krupiczka", "hashin_shtrikman_lower")
SAMPLES = 12


def packings():
    """Beds of 2500 spheres with periodic sides, measured between z = 2 mm and 24 mm."""
    for seed in SEEDS:
        bed = pack((WIDTH, WIDTH), radius=R, count=2500, seed=seed, periodic=(True, True),
                   material=Material(density=1000.0, youngs_modulus=SOFT))  # fmt: skip
        box = np.zeros(3), np.array([WIDTH, WIDTH, bed.position[:, 2].max() + R])
        yield extract.Packing(bed.position, R, bed.statistics["porosity_core"], 2e-3, 24e-3, WIDTH**2, box)


def fit(beds, paths="cones"):
    """k/k_fluid over k_solid/k_fluid from some beds together."""
    data = extract.conductivity_sweep(beds, RATIOS, K_FLUID, correction(SOFT, REAL, STATIC), paths)
    k = data.pop("k/k_fluid")
    return extract.fit_log_polynomial("conductivity", data, k, {extract.RATIO: "log"}, (3,))


def outlet(conductivity, **overrides):
    """Mean temperature of the gas at the outlet [K]."""
    changes = {"heat.conductivity_solid": conductivity, "output.plots": False, "output.fields": False, **overrides}
    return cb.run(cb.load(SCENE, changes)).qoi["T_fluid_out_K"]


def outlet_of(found):
    """The same with a fit that is not kept."""
    with tempfile.TemporaryDirectory() as folder:
        found.write(Path(folder) / "closure.toml", {"scene": "sample"})
        return outlet({"file": str(Path(folder) / "closure.toml")})


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
    print(f"standard deviation over packings {np.std(each, ddof=1):.3f} K, over the parameters {np.std(drawn):.3f} K; "
          f"finer mesh {mesh - rows[0][1]:+.4f} K")  # fmt: skip


if __name__ == "__main__":
    main()
