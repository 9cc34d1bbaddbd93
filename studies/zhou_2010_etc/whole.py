"""The paper's number of spheres, 16,000, settled by LAMMPS with the modulus of simulations and with that of glass."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contbed.dem.heat_pair import correction
from contbed.dem.packing import pack
from contbed.dem.particles import Material
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies.zhou_2010_etc import study

HERE = Path(__file__).parent
COUNT, SMALL = 16_000, 2_500
RATIOS = (10, 100, 1000)
# kinetic energy over N m g d: at 50 GPa a sphere that is loose between others bounces for long, and one of 16,000 that
# does by half of its diameter is as much
AT_REST = 3e-5
HEADS = {
    "E [Pa]": "g",
    "porosity of the core": ".4f",
    "coordination": ".4g",
    "correction": "",
    **{f"{ratio}": ".5g" for ratio in RATIOS},
}


def reference() -> Table:
    """k_e/k_f of beds of 2,500 that contbed settles."""
    return Table.read(HERE / "moduli.csv")


def compute() -> Tables:
    """k_e/k_f of beds of each modulus, contacts as simulated and corrected."""
    width = study.WIDTH * (COUNT / SMALL) ** 0.5
    rows = []
    for modulus in (study.SOFT, study.REAL):
        material = Material(density=1000.0, youngs_modulus=modulus)
        bed = pack(
            (width, width),
            radius=study.R,
            count=COUNT,
            seed=1,
            material=material,
            at_rest=AT_REST,
            engine="lammps",
        )
        found = bed.statistics
        for name, exponent in study.EXPONENTS.items():
            factor = correction(modulus, study.REAL, exponent)
            k = study.relative(bed.position, RATIOS, factor, eps=found["porosity_core"], area=width**2)
            rows.append((modulus, found["porosity_core"], found["coordination"], name, *k))
            print(f"{modulus:g} Pa, correction {name}: {k.round(3)}", flush=True)
    return {"whole": Table(HEADS, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """k_e/k_f at a ratio of 1000 over the exponent of the correction, beside beds of 2,500."""
    figure, axes = gallery.figure(size=(6.0, 4.0))
    names = list(study.EXPONENTS)
    for table, marker, text in ((reference(), "o", "2,500, contbed"), (tables["whole"], "x", "16,000, LAMMPS")):
        for modulus, colour in ((study.SOFT, gallery.BLUE), (study.REAL, gallery.BLACK)):
            found = table.where({"E [Pa]": modulus})
            style = {"ls": "", "marker": marker, "color": colour, "ms": 7}
            axes.plot(names, [float(found.where({"correction": name})["1000"][0]) for name in names], **style)
            axes.plot([], [], **style, label=f"{text}, {modulus / 1e9:g} GPa")
    axes.set(xlabel="exponent of the correction to 50 GPa", ylabel="$k_e/k_f$ at $k_p/k_f$ = 1000", ylim=(0, None))
    axes.legend()
    return {"whole": figure}
