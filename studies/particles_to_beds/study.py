"""From packings of particles to the outlet of three beds, with a band and what makes
it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.fields import unit_of
from contbed.many.cascade.outcome import Outcome
from contbed.many.cascade.run import cascade
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
BEDS = ("heated_wall", "moving_bed", "bubbling_bed")
NOT_COMPARED = ("CPU [s]",)
INPUTS = {
    "solids.glass.conductivity": "conductivity",
    "solids.pebbles.conductivity": "conductivity",
    "solids.glass.diameter": "diameter",
    "solids.pebbles.diameter": "diameter",
    "solids.char.diameter": "diameter",
    "solids.sand.diameter": "diameter",
    "boundary.bottom.gas.velocity": "velocity or mass flow",
    "boundary.left.gas.velocity": "velocity or mass flow",
    "boundary.bottom.gas.mass_flow": "velocity or mass flow",
    "bubbling_bed.tubes.coefficient": "coefficient of the tubes",
}
COLOURS = {
    "packing": gallery.BLUE,
    "fit": gallery.BLACK,
    "law of conduction": gallery.VERMILION,
    "law of exchange": gallery.ORANGE,
    "conductivity": gallery.GREEN,
    "diameter": gallery.SKY,
    "velocity or mass flow": gallery.PURPLE,
    "coefficient of the tubes": gallery.YELLOW,
    "mesh": gallery.GREY,
}


def reference() -> dict[str, float]:
    """Temperatures of the air [K] at the outlet of the moving bed with each law of
    exchange as that of the bed.
    """
    laws = {"gunn": "gunn", "power": {"name": "power", "a": 1.2, "b": 0.5}}
    return {
        name: float(
            cb.run(cb.load(HERE / "moving_bed.toml", {"closures.nusselt": law})).qoi[
                "T_fluid_out_K"
            ]
        )
        for name, law in laws.items()
    }


def compute() -> Tables:
    """Run the cascades: their results with bands, and the parts of these."""
    found, cpu = {}, {}
    for bed in BEDS:
        with tempfile.TemporaryDirectory() as folder:
            timed = gallery.cpu(
                lambda bed=bed, folder=folder: cascade(
                    HERE / f"data/{bed}.toml", folder
                ),
                samples=1,
            )
            found[bed], cpu[bed] = timed.result, timed.seconds
    return tables_of(found, cpu)


def tables_of(found: Mapping[str, Outcome], cpu: Mapping[str, float]) -> Tables:
    """Tables of outcomes and of their processor time [s]."""
    results, parts = [], []
    for bed, one in found.items():
        for name, value in one.base.items():
            low, high = one.band(name)
            spread = float(np.std(one.samples[name], ddof=1))
            results.append(
                (bed, name, unit_of(name), value, low, high, spread, one.runs, cpu[bed])
            )
            shares = one.shares(name)
            parts += [
                (bed, name, part.name, part.deviation[name], shares[part.name])
                for part in one.parts
            ]
    columns = {"bed": "", "result": "", "unit": ""}
    columns |= dict.fromkeys(("best", "band from", "band to", "deviation"), ".5g") | {
        "runs": "d",
        "CPU [s]": ".0f",
    }
    of_parts = {"bed": "", "result": "", "part": "", "deviation": ".3g", "share": ".4f"}
    return {"results": Table(columns, results), "parts": Table(of_parts, parts)}


def shown(part: str) -> str:
    """Return what a part is called in the picture, where inputs of one kind share a
    colour.
    """
    return INPUTS.get(part, part)


def plot(tables: Tables) -> dict[str, Any]:
    """Share of each part in the variance of each result."""
    table = tables["parts"]
    rows = [
        (bed, name)
        for bed in BEDS
        for name in dict.fromkeys(table.where({"bed": bed}).values("result"))
    ]
    figure, axes = gallery.figure(size=(9, 0.5 * len(rows) + 1.6))
    left = np.zeros(len(rows))
    for part, colour in COLOURS.items():
        shares = [
            sum(
                float(r["share"])
                for r in table.where({"bed": bed, "result": name})
                if shown(r["part"]) == part
            )
            for bed, name in rows
        ]
        axes.barh(range(len(rows)), shares, left=left, color=colour, label=part)
        left += shares
    axes.set_yticks(range(len(rows)), [f"{bed}: {name}" for bed, name in rows])
    axes.invert_yaxis()
    axes.set(xlabel="share of the variance [-]", xlim=(0, 1))
    figure.legend(loc="outside lower center", ncols=4)
    return {"parts": figure}
