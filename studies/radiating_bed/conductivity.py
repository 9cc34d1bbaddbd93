"""Effective conductivity of a packed bed from 75 to 1475 degC with radiation, beside Zehner, Bauer & Schluender.

The bed of `bed.toml`, 0.5 m thick, between plates 10 K apart: P1 in the two-energy model, the same without radiation,
and the closure with its radiation term in place of P1. The run time with and without radiation is measured beside it.

    python studies/radiating_bed/conductivity.py     # conductivity.csv; 3 s
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import contbed as cb
from contbed.closures import conductivity_zehner_bauer_schluender, conductivity_zehner_schluender

HERE = Path(__file__).parent
LENGTH = 0.5
APART = 10.0
CELSIUS = (75, 275, 475, 675, 875, 1075, 1275, 1475)
EMISSIVITY = 0.8


def scene(T: float, radiates: bool) -> cb.Scene:
    """The bed around a mean temperature [K]."""
    overrides: dict[str, object] = {}
    for side, plate in (("left", T + APART / 2), ("right", T - APART / 2)):
        overrides[f"boundary.{side}.fluid.fixed"] = plate
        overrides[f"boundary.{side}.solid.fixed"] = plate
        overrides[f"boundary.{side}.radiation.temperature"] = plate
    loaded = cb.load(HERE / "bed.toml", overrides)
    if radiates:
        return loaded
    sides = {name: table.model_copy(update={"radiation": None}) for name, table in loaded.boundary.items()}
    return loaded.model_copy(update={"radiation": None, "boundary": sides})


def conductivity(loaded: cb.Scene) -> float:
    """Heat flux times thickness over the difference of the plates [W/m/K]."""
    return cb.run(loaded).qoi["heat_left_W"] * LENGTH / APART


def run_time(loaded: cb.Scene) -> float:
    """Median user time of a run [s]."""
    times = []
    for _ in range(9):
        start = time.process_time()
        cb.run(loaded)
        times.append(time.process_time() - start)
    return float(np.median(times))


def main() -> None:
    """Write the table and print the cost ratio."""
    bed, fluid, solid = scene(1000.0, True).bed, scene(1000.0, True).fluid, scene(1000.0, True).solid
    phases = {"k_fluid": fluid.conductivity, "k_solid": solid.conductivity, "eps": bed.porosity}
    rows = []
    for celsius in CELSIUS:
        T = celsius + 273.15
        rise = conductivity(scene(T, True)) - conductivity(scene(T, False))
        radiating = conductivity_zehner_bauer_schluender(
            **phases, T=T, d_p=bed.particle_diameter, emissivity=EMISSIVITY
        )
        predicted = float(radiating - conductivity_zehner_schluender(**phases))
        rows.append((celsius, conductivity(scene(T, False)), rise, predicted, rise / predicted))
    names = ["mean temperature [degC]", "k without radiation [W/m/K]", "rise by P1 [W/m/K]", "rise by ZBS [W/m/K]"]
    header = ",".join([*names, "P1 over ZBS [1]"])
    np.savetxt(HERE / "conductivity.csv", rows, "%.5g", ",", header=header, comments="")
    print(header, *(",".join(f"{value:.4g}" for value in row) for row in rows), sep="\n")
    ratio = run_time(scene(1748.15, True)) / run_time(scene(1748.15, False))
    print(f"run time with radiation over without: {ratio:.2f}")


if __name__ == "__main__":
    main()
