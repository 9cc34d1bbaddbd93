"""The riser as a square duct in three dimensions, beside the plane: what does the plane
get wrong?

Each run keeps its checkpoints in results/vaishali_2007 and goes on from there with the
same command.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import contbed as cb
from contbed.output import stored
from contbed.two_fluid.averages import along
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.raw import resumed

HERE = Path(__file__).parent
SCENE = HERE / "ff_wenyu_duct.toml"
KEPT = Path("results/vaishali_2007")
WIDTH = 0.152  # of the duct [m]
# part of the width around the middle that counts as core, and as middle of the depth
CORE = 0.25
MEASURED = 0.2  # m2/s2, granular temperature of the core by CARPT in the paper
PLANE = "plane"
NOT_COMPARED = ("steps",)
RESULTS = {
    "run": "", "cells": "", "averaged [s]": ".3g", "pressure drop [Pa]": ".4g", "eps_s core [1]": ".3g",
    "u_solid core [m/s]": ".3g", "u_solid walls [m/s]": ".3g", "theta core [m2/s2]": ".2g",
    "theta_total core [m2/s2]": ".2g", "halves [1]": ".2g", "steps": "d",
}  # fmt: skip
PROFILE = (
    "x [m]",
    "eps_s [1]",
    "u_solid [m/s]",
    "theta [m2/s2]",
    "theta_total [m2/s2]",
)


class Model(NamedTuple):
    """Cells across, in depth and along, and the keys of the scene that a run
    changes.
    """

    cells: tuple[int, int, int]
    changes: dict[str, Any]


MODELS = {
    "duct": Model((16, 16, 350), {}),
    "duct, cells twice as wide": Model((8, 8, 175), {}),
    "duct, cells twice as wide, drag of Igci et al.": Model(
        (8, 8, 175), {"closures.drag": "igci"}
    ),
}
COLOURS = dict(
    zip(
        (PLANE, *MODELS),
        (gallery.GREY, gallery.BLACK, gallery.BLUE, gallery.VERMILION),
        strict=True,
    )
)


def reference() -> dict[str, float]:
    """Granular temperature of the core by CARPT [m2/s2]."""
    return {"theta_total core [m2/s2]": MEASURED}


def scene_of(run: str) -> Any:
    """Scene of a run of the duct."""
    return cb.load(
        SCENE, {"mesh.cells": list(MODELS[run].cells), **MODELS[run].changes}
    )


def folder_of(run: str) -> Path:
    """Where a run keeps its results and its checkpoint."""
    return KEPT / run.replace(" ", "_").replace(",", "").replace(".", "")


def profile(folder: Path, window: Any) -> tuple[Table, dict[str, float]]:
    """Profile across the middle of the depth, and means of the core, from the
    averages in the last file of fields.
    """
    mesh = stored.read_fields(stored.read_series(folder / "fields.pvd")[-1][1])
    corners = mesh.points[mesh.cells[0].data]
    centres, volume = corners.mean(axis=1), np.ptp(corners, axis=1).prod(axis=1)
    data = {
        name.partition(" ")[0]: values[0] for name, values in mesh.cell_data.items()
    }
    s = data["eps_s_mean"]
    values = {
        "eps_s [1]": s,
        "u_solid [m/s]": data["u_solid_mean"][:, -1],
        "theta [m2/s2]": data["theta_mean"],
        "theta_total [m2/s2]": data["theta_total_mean"],
    }
    weights = {name: s for name in values if name != "eps_s [1]"}
    middle = np.abs(centres[:, 1] - 0.5 * WIDTH) < 0.5 * CORE * WIDTH
    there = middle & (centres[:, 2] > window.start) & (centres[:, 2] < window.end)

    def means(place: Any, bins: int) -> Any:
        held = [
            {name: value[place] for name, value in each.items()}
            for each in (values, weights)
        ]
        return along(centres[place, 0], volume[place], *held, bins)

    x, columns = means(there, len(np.unique(np.round(centres[:, 0], 6))))
    _, core = means(
        there & (np.abs(centres[:, 0] - 0.5 * WIDTH) < 0.5 * CORE * WIDTH), 1
    )
    return Table.from_columns({"x [m]": x, **columns}, ".4g"), {
        name: float(value[0]) for name, value in core.items()
    }


def compute(cases: Sequence[str] = tuple(MODELS)) -> Tables:
    """Run the models, or go on with them; results and profiles across the middle."""
    rows, profiles = [], []
    for name in cases:
        scene, folder = scene_of(name), folder_of(name)
        result = resumed(scene, folder)
        across, core = profile(folder, scene.output.window)
        q, u = result.qoi, across["u_solid [m/s]"]
        found = (
            q["averaged [s]"],
            q["pressure_drop_mean [Pa]"],
            core["eps_s [1]"],
            core["u_solid [m/s]"],
        )
        walls, theta = (
            0.5 * (u[0] + u[-1]),
            (core["theta [m2/s2]"], core["theta_total [m2/s2]"]),
        )
        rows.append(
            (
                name,
                "x".join(map(str, MODELS[name].cells)),
                *found,
                walls,
                *theta,
                q["difference_of_halves"],
                q["steps"],
            )
        )
        print(*rows[-1], flush=True)
        profiles += [
            (name, *values)
            for values in zip(*(across[column] for column in PROFILE), strict=True)
        ]
    tables = {
        "duct": Table(RESULTS, rows),
        "duct_profiles": Table({"run": ""} | dict.fromkeys(PROFILE, ".4g"), profiles),
    }
    if len(cases) == len(MODELS):
        return tables
    keys = {"duct": ["run"], "duct_profiles": ["run", "x [m]"]}
    return gallery.updated(HERE, tables, keys)


def plot(tables: Tables) -> dict[str, Any]:
    """Fraction, velocity and fluctuations of the particles across, beside the plane."""
    figure, panels = gallery.figure(1, 3, size=(12.0, 4.0))
    plane = Table.read(HERE / "ff_wenyu_lateral.csv")
    for name, colour in COLOURS.items():
        found = plane if name == PLANE else tables["duct_profiles"].where({"run": name})
        if not len(found):
            continue
        for panel, column in zip(
            panels, ("eps_s [1]", "u_solid [m/s]", "theta_total [m2/s2]"), strict=True
        ):
            panel.plot(found["x [m]"], found[column], color=colour, label=name)
    panels[2].plot(
        0.5 * WIDTH, MEASURED, "o", color=gallery.BLACK, mfc="none", label="CARPT, core"
    )
    for panel, field in zip(panels, ("eps_s", "u_solid", "theta"), strict=True):
        panel.set(xlabel=gallery.label("x"), ylabel=gallery.label(field))
    panels[2].set(yscale="log", ylabel=r"$\theta$ with resolved motion [m$^2$/s$^2$]")
    figure.legend(
        *panels[2].get_legend_handles_labels(), loc="outside lower center", ncols=3
    )
    return {"duct": figure}
