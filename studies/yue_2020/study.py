"""Spouted bed of Yue et al. (2020): mean speed of the particles at four heights, by
two fluids in plane and box.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.many.validate import levels
from contbed.many.validate.case import Case, read_case
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
BED = "yue_2020"
NOT_COMPARED = ("CPU [s]",)
# m: middle of the bed, height of the bed at rest
SPEED, MIDDLE, REST = "speed_solid [m/s]", 0.14, 0.2
MODELS = (
    "plane", "plane, newtonian friction", "box", "box, walls that rub", "box, walls "
                                                                        "that stick",
    "box, walls that rub, drag of Beetstra",
)  # fmt: skip
FRICTION = 0.3  # coefficient of the case's spheres, taken for the walls as well
WALLS = ("front", "left", "right", "bottom")
COLOURS = {
    "plane": gallery.BLUE,
    "plane, newtonian friction": gallery.SKY,
    "box": gallery.VERMILION,
    "box, walls that rub": gallery.GREEN,
    "box, walls that stick": gallery.ORANGE,
    "box, walls that rub, drag of Beetstra": gallery.YELLOW,
}


def scene_of(model: str) -> cb.Scene:
    """Scene of a model: that of the case, or of this folder."""
    if model == "plane":
        return read_case(BED).scene()
    if model == "box":
        return cb.load(HERE / "box.toml")
    if model.startswith("box, walls that rub"):
        rub: dict[str, Any] = {
            f"boundary.{wall}.solids.beads.friction": FRICTION for wall in WALLS
        }
        return cb.load(
            HERE / "box.toml",
            rub | ({"closures.drag": "drag_beetstra"} if "Beetstra" in model else {}),
        )
    if model == "box, walls that stick":
        stuck = {
            "type": "wall",
            "gas": {"wall": "slip"},
            "solids": {"beads": {"wall": "no_slip"}},
        }
        return cb.load(HERE / "box.toml", {f"boundary.{wall}": stuck for wall in WALLS})
    return read_case(BED).scene(
        **{"closures.friction_viscosity": "friction_viscosity_newtonian"}
    )


def reference() -> Case:
    """The measured bed with its points."""
    return read_case(BED)


def compute(cases: Sequence[str] = MODELS) -> Tables:
    """Run the models; their deviations and profiles; committed rows of others are
    kept.
    """
    runs, cpu = {}, {}
    for model in cases:
        timed = gallery.cpu(lambda model=model: cb.run(scene_of(model)), samples=1)
        runs[model], cpu[model] = timed.result, timed.seconds
    return gallery.updated(
        HERE, tables_of(runs, cpu), {"scores": ["model"], "profiles": ["model"]}
    )


def symmetric() -> dict[float, float]:
    """L1 of the best profile that is alike on both sides, the mean of measured
    points and their mirror, by height.
    """
    points, found = reference().points, {}
    for height in np.unique(points.height):
        x, v = points.x[points.height == height], points.value[points.height == height]
        mirrored = np.interp(2.0 * MIDDLE - x, x, v)
        found[float(height)] = float(np.abs(v - 0.5 * (v + mirrored)).sum() / v.sum())
    return found


def tables_of(runs: Mapping[str, Any], cpu: Mapping[str, float]) -> Tables:
    """Tables of the results of each model, and of its processor time [s]."""
    case = reference()
    points = case.points
    scores = [
        ("best symmetric profile", height, L1, None, None, None)
        for height, L1 in symmetric().items()
    ]
    profiles = [
        ("measured", h, x - MIDDLE, v)
        for h, x, v in zip(points.height, points.x, points.value, strict=True)
    ]
    for model, result in runs.items():
        compared = levels.compare(case, result)
        for one in compared.scores:
            height = None if one.group == "all" else float(one.group.split()[0])
            L1 = compared.reported[f"L1 of {one.group}"]
            scores.append(
                (
                    model,
                    height,
                    L1,
                    one.rms,
                    one.bias,
                    cpu.get(model) if height is None else None,
                )
            )
        places = np.array(compared.reported["x [m]"])
        for height in np.unique(result.tables["levels"]["height [m]"]):
            speeds = levels.at(case, result, float(height), places)
            profiles += [
                (model, height, x - MIDDLE, v)
                for x, v in zip(places, speeds, strict=True)
            ]
    return {
        "scores": Table(
            dict.fromkeys(
                ("model", "height [m]", "L1 [1]", "RMS [m/s]", "bias [m/s]", "CPU [s]"),
                ".3g",
            ),
            scores,
        ),
        "profiles": Table(
            dict.fromkeys(("model", "height [m]", "x [m]", SPEED), ".4g"), profiles
        ),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Speeds over the width at the four heights."""
    table = tables["profiles"]
    heights = sorted({float(row["height [m]"]) for row in table})
    figure, panels = gallery.figure(
        1, len(heights), size=(3.2 * len(heights), 3.6), sharey=True
    )
    for axes, height in zip(panels, heights, strict=True):
        for model in table.values("model"):
            rows = [
                row
                for row in table
                if row["model"] == model and float(row["height [m]"]) == height
            ]
            x, v = ([float(row[key]) for row in rows] for key in ("x [m]", SPEED))
            if model == "measured":
                axes.plot(x, v, "o", color=gallery.BLACK, ms=3, label=model)
            elif rows:
                axes.plot(x, v, color=COLOURS[model], label=model)
        axes.set(title=f"{height:g} m, H/H0 = {height / REST:.2f}", xlabel="$x$ [m]")
    panels[0].set_ylabel("mean speed of the particles [m/s]")
    figure.legend(
        *panels[0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=len(COLOURS) + 1,
    )
    return {"yue": figure}
