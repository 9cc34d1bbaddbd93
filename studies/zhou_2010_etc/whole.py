"""The paper's number of spheres, 16,000, settled by LAMMPS with the modulus of
simulations and with that of glass.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies.zhou_2010_etc import study

HERE = Path(__file__).parent
COUNT = 16_000
# kinetic energy over N m g d: at 50 GPa a sphere that is loose between others bounces
# for long, and one of 16,000 that does by half of its diameter is as much
AT_REST = 3e-5
HEADS = {
    "E [Pa]": "g",
    "porosity of the core": ".4f",
    "coordination": ".4g",
    "correction": "",
    **dict.fromkeys(map(str, study.POINTS), ".5g"),
}


def reference() -> Table:
    """k_e/k_f of beds of 2,500 that contbed settles."""
    return Table.read(HERE / "moduli.csv")


def compute() -> Tables:
    """k_e/k_f of beds of each modulus, contacts as simulated and corrected."""
    rows = []
    for modulus in (study.SOFT, study.REAL):
        bed = study.own(modulus, count=COUNT, at_rest=AT_REST, engine="lammps")
        found = bed.statistics["porosity_core"], bed.statistics["coordination"]
        rows += [(modulus, *found, *row) for row in study.corrected(bed)]
    return {"whole": Table(HEADS, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """k_e/k_f at a ratio of 1000 over the exponent of the correction, beside beds of
    2,500.
    """
    figure, axes = gallery.figure(size=(6.0, 4.0))
    for table, marker, text in (
        (reference(), "o", "2,500, contbed"),
        (tables["whole"], "x", "16,000, LAMMPS"),
    ):
        for modulus, colour in (
            (study.SOFT, gallery.BLUE),
            (study.REAL, gallery.BLACK),
        ):
            found, label = (
                table.where({"E [Pa]": modulus}),
                f"{text}, {modulus / 1e9:g} GPa",
            )
            axes.plot(
                found["correction"],
                found["1000"],
                marker,
                color=colour,
                ms=7,
                label=label,
            )
    axes.set(
        xlabel="exponent of the correction to 50 GPa",
        ylabel="$k_e/k_f$ at $k_p/k_f$ = 1000",
        ylim=(0, None),
    )
    axes.legend()
    return {"whole": figure}
