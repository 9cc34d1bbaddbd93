"""A plane riser on cells that resolve its clusters, on coarser ones, and with
filtered closures on these.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
# m2/s2, square of Stokes' terminal velocity, over which the filtered stress is given
TERMINAL_SQUARED = 0.065191
STRESS = {
    "closures.granular_pressure": "igci",
    "closures.granular_viscosity": "igci",
    "closures.granular_bulk_viscosity": "none",
    "two_fluid.granular_temperature": "frozen",
    "initial.solids.catalyst.granular_temperature": TERMINAL_SQUARED,
}
LESS = ", less near walls"  # ending of the names of models with factors near walls
NEAR_WALLS = {"closures.wall_drag": "igci"}
STRESS_NEAR_WALLS = {
    "closures.wall_pressure": "igci",
    "closures.wall_viscosity": "igci",
}
NOT_COMPARED = ("CPU [s]",)
COLUMNS = dict.fromkeys(("model", "cells"), "") | {
    "pressure drop [Pa]": ".4g", "holdup [1]": ".4g", "halves [1]": ".2g", "steps": "d", "CPU [s]": ".3g",
}  # fmt: skip


class Model(NamedTuple):
    """Cells across and along, and the keys of riser.toml that a model changes."""

    cells: tuple[int, int]
    changes: dict[str, Any]


MODELS = {
    "resolved": Model((48, 640), {}),
    "cells twice as wide": Model((24, 320), {}),
    "four times": Model((12, 160), {}),
    "eight times": Model((6, 80), {}),
    "drag of Igci et al.": Model((6, 80), {"closures.drag": "igci"}),
    "drag and stress of Igci et al.": Model(
        (6, 80), {"closures.drag": "igci"} | STRESS
    ),
    "drag of Milioli et al.": Model((6, 80), {"closures.drag": "milioli"}),
    "drag of Milioli et al., stress of Igci et al.": Model(
        (6, 80), {"closures.drag": "milioli"} | STRESS
    ),
    f"drag of Igci et al.{LESS}": Model(
        (6, 80), {"closures.drag": "igci"} | NEAR_WALLS
    ),
    f"drag and stress of Igci et al.{LESS}": Model(
        (6, 80), {"closures.drag": "igci"} | STRESS | NEAR_WALLS | STRESS_NEAR_WALLS
    ),
}
COLOURS = dict(zip((name for name in MODELS if not name.endswith(LESS)), (
    gallery.BLACK, gallery.GREY, gallery.SKY, gallery.BLUE, gallery.VERMILION, gallery.ORANGE, gallery.GREEN,
    gallery.PURPLE), strict=True))  # fmt: skip


def reference() -> dict[str, Any]:
    """Pressure drop and holdup of the resolved riser, as committed."""
    table = Table.read(HERE / "results.csv").where({"model": "resolved"})
    return {
        name: float(table[name][0]) for name in ("pressure drop [Pa]", "holdup [1]")
    }


def compute(cases: Sequence[str] = tuple(MODELS)) -> Tables:
    """Run the models; what they hold and carry, and their profiles across."""
    rows, profiles = [], []
    for name in cases:
        model = MODELS[name]
        scene = cb.load(
            HERE / "riser.toml", {"mesh.cells": list(model.cells), **model.changes}
        )
        cpu, result = gallery.cpu(lambda scene=scene: cb.run(scene), samples=1)
        found, across = result.qoi, result.tables["lateral"]
        holdup = float(result.tables["axial"]["eps_s [1]"].mean())
        drop, halves = found["pressure_drop_mean [Pa]"], found["difference_of_halves"]
        rows.append(
            (
                name,
                "x".join(map(str, model.cells)),
                drop,
                holdup,
                halves,
                found["steps"],
                cpu,
            )
        )
        print(*rows[-1], flush=True)
        for x, eps_s, u in zip(
            across["x [m]"], across["eps_s [1]"], across["u_solid [m/s]"], strict=True
        ):
            profiles.append((name, x, eps_s, u))
    tables = {
        "results": Table(COLUMNS, rows),
        "profiles": Table(
            dict.fromkeys(("model", "x [m]", "eps_s [1]", "u_solid [m/s]"), ".4g"),
            profiles,
        ),
    }
    if len(cases) == len(MODELS):
        return tables
    keys = {"results": ["model"], "profiles": ["model", "x [m]"]}
    return gallery.updated(HERE, tables, keys)


def plot(tables: Tables) -> dict[str, Any]:
    """Fraction and velocity of the particles across, between 0.256 and 0.768 m."""
    figure, panels = gallery.figure(1, 2, size=(10.0, 3.9))
    for model in MODELS:
        rows = tables["profiles"].where({"model": model})
        style = (
            {"lw": 2.2}
            if model == "resolved"
            else {"ls": "--" if model.endswith(LESS) else "-"}
        )
        style |= {"color": COLOURS[model.removesuffix(LESS)], "label": model}
        for panel, key in zip(panels, ("eps_s [1]", "u_solid [m/s]"), strict=True):
            panel.plot(1e3 * rows["x [m]"], rows[key], **style)
            panel.set(xlabel="$x$ [mm]", ylabel=key.replace("_", " "))
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3
    )
    return {"coarse_riser": figure}
