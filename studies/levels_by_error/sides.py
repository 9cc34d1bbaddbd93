"""Heat through the sides of 100 random round beds: one dimension, two dimensions,
and what the plan predicts.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.packed_bed.plan import plan
from contbed.packed_bed.sides import error_without_sides
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
NOT_COMPARED = ("CPU 1-D [s]", "CPU 2-D [s]", "CPU [s]", "CPU over 1-D")
BEDS, SEED = 100, 1
ACCURACIES = (0.1, 0.01, 1e-3)
SPAN = 200.0  # [K] from what enters to what is around the bed
LAID = {
    "type": "axisymmetric",
    "length": 0.5,
    "radius": 0.05,
    "cells": [16, 60],
    "graded": True,
}


def bed(random: np.random.Generator) -> dict[str, Any]:
    """Tables of one random bed: coefficients at its wall, conductivities, and
    particles at rest or along the gas.
    """
    coefficients = 10.0 ** random.uniform(-2.5, 1.5, 2)
    gas_wall, solid_wall = (
        {"coefficient": float(h), "ambient": 300.0 + SPAN} for h in coefficients
    )
    gas = {
        "density": 1.0,
        "heat_capacity": 1000.0,
        "conductivity": 0.03,
        "viscosity": 2e-5,
    }
    velocity = float(10.0 ** random.uniform(-0.5, 0.5))
    bottom: dict[str, Any] = {"gas": {"velocity": velocity, "temperature": 300.0}}
    if random.random() < 0.5:
        solids = {
            "velocity": float(10.0 ** random.uniform(-4.0, -3.0)),
            "temperature": 300.0,
        }
        bottom["solids"] = {"particles": solids}
    nusselt, conductivity_gas = 10.0, float(10.0 ** random.uniform(-1.5, 0.5))
    conductivity_solids = float(10.0 ** random.uniform(-1.0, 1.0))
    return {
        "mesh": dict(LAID),
        "gas": gas,
        "solids": {
            "particles": {
                "density": 2000.0,
                "heat_capacity": 800.0,
                "conductivity": 1.0,
                "diameter": 0.005,
            }
        },
        "packed_bed": {"porosity": 0.4},
        "closures": {
            "nusselt": nusselt,
            "conductivity_gas": conductivity_gas,
            "conductivity_solids": conductivity_solids,
        },
        "heat": {},
        "boundary": {
            "bottom": bottom,
            "wall": {"gas": gas_wall, "solids": {"particles": solid_wall}},
        },
    }


def reference(scene: dict[str, Any]) -> tuple[float, Any]:
    """CPU [s] and temperatures of what leaves over the span, resolved across the
    bed.
    """
    seconds, result = gallery.cpu(lambda: cb.run(cb.load(scene)), samples=1)
    return seconds, leaving(result)


def leaving(result: Any) -> Any:
    """Temperatures of the phases that leave over the span."""
    names = [f"T_{phase}_out_K" for phase in ("fluid", "solid")]
    return np.array(
        [(result.qoi[name] - 300.0) / SPAN for name in names if name in result.qoi]
    )


def compute() -> Tables:
    """Bound, true error of one dimension, and CPU of both; the choice at each
    accuracy.
    """
    random = np.random.default_rng(SEED)
    rows = []
    for number in range(BEDS):
        keys = bed(random)
        scene = cb.load(keys)
        bound = error_without_sides(scene, plan(scene).medium)
        assert bound is not None
        in_two, exact = reference(keys)
        # without its wall a bed is solved on a line
        line = cb.load(keys | {"boundary": {"bottom": keys["boundary"]["bottom"]}})
        in_one, result = gallery.cpu(lambda line=line: cb.run(line), samples=1)
        error = float(np.abs(leaving(result) - exact).max())
        taken = []
        for accuracy in ACCURACIES:
            found = plan(cb.load(keys | {"solver": {"accuracy": accuracy}}))
            taken.append(f"{found.mesh.skfem.dim()}-D")
        motion = "along" if "solids" in keys["boundary"]["bottom"] else "at rest"
        rows.append([number, motion, bound, error, in_one, in_two, *taken])
    columns = {
        "bed": "d",
        "solids": "",
        "bound": ".3e",
        "error of 1-D": ".3e",
        "CPU 1-D [s]": ".3f",
    }
    columns |= {"CPU 2-D [s]": ".3f"} | {
        f"accuracy {accuracy:g}": "" for accuracy in ACCURACIES
    }
    tables = {"sides": Table(columns, rows)}
    return tables | {"sides_summary": summary(tables["sides"])}


def summary(table: Table) -> Table:
    """Largest error and mean CPU of each dimension and of the choice at each
    accuracy.
    """
    ways = {"1-D": ["1-D"] * len(table), "2-D": ["2-D"] * len(table)}
    ways |= {
        f"plan, accuracy {accuracy:g}": list(table[f"accuracy {accuracy:g}"])
        for accuracy in ACCURACIES
    }
    rows = []
    lines = table["CPU 1-D [s]"].sum()
    for way, taken in ways.items():
        line = np.array([each == "1-D" for each in taken])
        total = float(np.where(line, table["CPU 1-D [s]"], table["CPU 2-D [s]"]).sum())
        errors = np.where(line, table["error of 1-D"], 0.0)
        rows.append(
            [
                way,
                int(line.sum()),
                float(errors.max()),
                total / len(table),
                total / lines,
            ]
        )
    columns = {
        "way": "",
        "beds in 1-D": "d",
        "largest error": ".1e",
        "CPU [s]": ".3f",
        "CPU over 1-D": ".1f",
    }
    return Table(columns, rows)


def plot(tables: Tables) -> dict[str, Any]:
    """Error of one dimension over its bound, and the largest error of each way over
    its CPU.
    """
    figure, (left, right) = gallery.figure(1, 2, size=(10.5, 4.4))
    for solids, colour in (("at rest", gallery.BLUE), ("along", gallery.VERMILION)):
        here = tables["sides"].where({"solids": solids})
        left.loglog(
            here["bound"],
            here["error of 1-D"],
            "o",
            color=colour,
            markersize=3,
            label=f"solids {solids}",
        )
    ends = np.array([1e-4, 1.0])
    left.loglog(ends, ends, color="k", linewidth=0.8)
    left.set(
        xlabel="bound of the plan",
        ylabel="error of one dimension",
        title="what leaves, over the span",
    )
    left.legend(loc="upper left")
    for row in tables["sides_summary"]:
        x, y = float(row["CPU [s]"]), max(float(row["largest error"]), 1e-4)
        colour = gallery.VERMILION if row["way"].startswith("plan") else gallery.BLUE
        right.semilogy([x], [y], "o", color=colour, markersize=7)
        gallery.label_line(
            right, row["way"].replace("plan, accuracy", "plan"), x, y, colour, (8, 0)
        )
    right.set(
        xlabel="mean CPU [s]", ylabel="largest error of all beds, 2-D drawn at 1e-4"
    )
    right.margins(x=0.3)
    return {"sides": figure}
