"""Breakthrough of an adsorber: Rosen's curve, the linear driving force and a
Langmuir front over cells and CPU.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.chemistry.thermo import R_GAS
from contbed.particle.uptake import Level, breakthrough
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
NOT_COMPARED = ("CPU [s]", "steps")
LEVELS: dict[str, Level] = {
    "film": "lumped",
    "linear_driving_force": "effective",
    "interior": "interior",
}
# level, points inside, cells, tolerance of steps
RUNS = (
    ("film", 2, 20, 1e-4),
    ("linear_driving_force", 2, 20, 1e-4),
    ("interior", 2, 20, 1e-4),
    ("interior", 3, 20, 1e-4),
    ("interior", 4, 20, 1e-4),
    ("interior", 4, 3, 1e-4),
    ("interior", 4, 6, 1e-4),
    ("interior", 4, 20, 1e-3),
    ("interior", 4, 20, 1e-5),
)
FRONTS = ((5, 1e-3), (10, 1e-3), (20, 1e-3), (20, 1e-4))  # cells, tolerance of steps
MOMENTS = np.linspace(2.0, 240.0, 120)  # [s] of the curves
PATTERN = (0.02, 0.98)  # of c/c_0, between which the front is compared
# least share of the end at which curves are compared: the contour of the closed form
# needs a time above 0
LATE = 1e-3


def numbers(scene: Any) -> dict[str, float]:
    """Transfer units and their time [s], Biot number, what particles hold over the
    concentration of the gas.
    """
    solid, inlet = scene.solids["sorbent"], scene.boundary["left"].gas
    gas, d, eps = solid.adsorption["CO2"], solid.diameter, scene.packed_bed.porosity
    T, film = inlet.temperature, scene.closures.sherwood * scene.gas.diffusivity / d
    p = 1e-6 * scene.gas.pressure
    q = (
        gas.henry * p
        if gas.henry is not None
        else gas.capacity * gas.affinity * p / (1.0 + gas.affinity * p)
    )
    K = solid.density * q / (p / (R_GAS * T))
    area = 6.0 * (1.0 - eps) / d
    return {
        "units": film * area * scene.mesh.length / inlet.velocity,
        "unit": (1.0 - eps) * K / (film * area),
        "biot": film * 0.5 * d / gas.diffusivity,
        "r": 1.0 / (1.0 + (gas.affinity or 0.0) * p),
    }


def reference(scene: Any, times: Any, level: Level = "interior") -> Any:
    """What leaves over what enters by Rosen's closed form, or that of a cheaper
    level.
    """
    n = numbers(scene)
    return breakthrough(n["units"], np.asarray(times) / n["unit"], n["biot"], level)


def pattern(scene: Any, share: Any) -> Any:
    """Times [s] at which a Langmuir front of constant shape, with the resistance of
    the film, is at c/c_0.
    """
    n = numbers(scene)
    after = (np.log(share) - n["r"] * np.log(1.0 - share)) / (1.0 - n["r"]) + 1.0
    return (n["units"] + after) * n["unit"]


def curve(result: Any) -> tuple[Any, Any]:
    """Times [s] of all steps, and what leaves over what enters."""
    table = result.tables["outlet"]
    return table["t [s]"], table["x_CO2 [1]"] / 1e-6


def _spheres(rows: list[Any], curves: list[Any]) -> None:
    for level, points, cells, tolerance in RUNS:
        changes = {"solids.sorbent.inside": {"adsorption": level, "points": points}}
        scene = cb.load(
            HERE / "rosen.toml",
            changes | {"mesh.cells": cells, "time.tolerance": tolerance},
        )
        seconds, result = gallery.cpu(lambda scene=scene: cb.run(scene))
        t, share = curve(result)
        late = t > LATE * t[-1]
        errors = [
            float(np.abs(share - reference(scene, t, of))[late].max())
            for of in ("interior", LEVELS[level])
        ]
        shown = points if level == "interior" else 1
        closed = max(
            abs(each["relative_residual"]) for each in result.balances.values()
        )
        rows.append(
            ["Rosen", level, shown, cells, tolerance, *errors, closed, result.qoi["time_steps"], seconds]
        )  # fmt: skip
        if (cells, tolerance, points) in ((20, 1e-4, 4), (20, 1e-4, 2)) and (
            level,
            points,
        ) != ("interior", 2):
            exact = reference(scene, MOMENTS)
            curves += [
                [level, *row]
                for row in zip(
                    MOMENTS, np.interp(MOMENTS, t, share), exact, strict=True
                )
            ]


def _fronts(rows: list[Any], curves: list[Any]) -> None:
    for cells, tolerance in FRONTS:
        scene = cb.load(
            HERE / "langmuir.toml", {"mesh.cells": cells, "time.tolerance": tolerance}
        )
        seconds, result = gallery.cpu(lambda scene=scene: cb.run(scene))
        t, share = curve(result)
        levels = np.linspace(*PATTERN, 200)
        exact = np.interp(t, pattern(scene, levels), levels)
        inside = (t > pattern(scene, levels)[0]) & (t < pattern(scene, levels)[-1])
        error = float(np.abs(share - exact)[inside].max())
        closed = max(
            abs(each["relative_residual"]) for each in result.balances.values()
        )
        rows.append(
            ["Langmuir", "film", 1, cells, tolerance, error, error, closed, result.qoi["time_steps"], seconds]
        )  # fmt: skip
    found = np.interp(MOMENTS, t, share)
    whole = np.linspace(1e-6, 1.0 - 1e-6, 20001)
    exact = np.interp(MOMENTS, pattern(scene, whole), whole)
    curves += [["Langmuir", *row] for row in zip(MOMENTS, found, exact, strict=True)]


def compute() -> Tables:
    """Errors against closed forms over levels, points, cells and tolerances, and
    curves.
    """
    rows: list[Any] = []
    curves: list[Any] = []
    _spheres(rows, curves)
    _fronts(rows, curves)
    columns = {
        "closed form": "",
        "inside": "",
        "points": "d",
        "cells": "d",
        "tolerance": ".0e",
        "error": ".3e",
    }
    columns |= {
        "error of its own closed form": ".3e",
        "elements": ".0e",
        "steps": "d",
        "CPU [s]": ".2f",
    }
    return {
        "results": Table(columns, rows),
        "curves": Table(
            {"case": "", "t [s]": ".6g", "c/c0": ".6f", "exact": ".6f"}, curves
        ),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Breakthrough of the levels beside Rosen's curve, and the Langmuir front beside
    its pattern.
    """
    figure, (spheres, front) = gallery.figure(1, 2)
    table = tables["curves"]
    colours = {
        "film": gallery.GREY,
        "linear_driving_force": gallery.BLUE,
        "interior": gallery.VERMILION,
    }
    for axes, cases in ((spheres, colours), (front, {"Langmuir": gallery.GREEN})):
        for case, colour in cases.items():
            here = table["case"] == case
            axes.plot(
                table["t [s]"][here],
                table["c/c0"][here],
                color=colour,
                label=case.replace("_", " "),
            )
        axes.plot(
            table["t [s]"][here][::5],
            table["exact"][here][::5],
            "o",
            markersize=3,
            color="k",
            label="exact",
        )
        axes.set(xlabel="time [s]", ylabel="$c/c_0$ of what leaves")
        axes.legend()
    return {"breakthrough": figure}
