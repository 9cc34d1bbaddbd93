"""The spouted bed by its 175,800 particles in the gas: mean speeds at four heights,
beside two fluids.

The run keeps its checkpoint in results/yue_2020 and goes on from there with the same
command.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.many.validate import levels
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.raw import resumed
from studies.yue_2020 import study

HERE = Path(__file__).parent
SCENE = HERE / "particles.toml"
KEPT = Path("results/yue_2020")
MODEL = "particles"
# of the two-fluid models, that with the smallest deviation
BESIDE = "box, walls that rub"
COLOURS = {MODEL: gallery.VERMILION, BESIDE: gallery.GREEN}


def reference() -> Any:
    """The measured bed with its points."""
    return study.reference()


def compute() -> Tables:
    """Run the bed, or go on with it; deviations, and profiles at the measured
    places.
    """
    return tables_of(resumed(cb.load(SCENE), KEPT))


def tables_of(result: Any) -> Tables:
    """Tables of the deviations of a run, and of its profiles."""
    case = reference()
    compared = levels.compare(case, result)
    scores = [
        (one.group, compared.reported[f"L1 of {one.group}"], one.rms, one.bias)
        for one in compared.scores
    ]
    places, profiles = np.array(compared.reported["x [m]"]), []
    for height in np.unique(result.tables["levels"]["height [m]"]):
        speeds = levels.at(case, result, float(height), places)
        profiles += [
            (height, x - study.MIDDLE, v) for x, v in zip(places, speeds, strict=True)
        ]
    return {
        "particles_scores": Table(
            dict.fromkeys(("height", "L1 [1]", "RMS [m/s]", "bias [m/s]"), ".3g"),
            scores,
        ),
        "particles_profiles": Table(
            dict.fromkeys(("height [m]", "x [m]", study.SPEED), ".4g"), profiles
        ),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Speeds over the width at the four heights, measured, of particles and of two
    fluids.
    """
    fluids, particles = Table.read(HERE / "profiles.csv"), tables["particles_profiles"]
    heights = np.unique(particles["height [m]"])
    figure, panels = gallery.figure(
        1, len(heights), size=(3.2 * len(heights), 3.6), sharey=True
    )
    for axes, height in zip(panels, heights, strict=True):
        for model, table in (
            ("measured", fluids.where({"model": "measured"})),
            (BESIDE, fluids.where({"model": BESIDE})),
            (MODEL, particles),
        ):
            row = np.isclose(table["height [m]"], height)
            style = (
                {"color": COLOURS[model]}
                if model in COLOURS
                else {"color": gallery.BLACK, "marker": "o", "ms": 3, "ls": ""}
            )
            if row.any():
                axes.plot(
                    table["x [m]"][row], table[study.SPEED][row], label=model, **style
                )
        axes.set(
            title=f"{height:g} m, H/H0 = {height / study.REST:.2f}", xlabel="$x$ [m]"
        )
    panels[0].set_ylabel("mean speed of the particles [m/s]")
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3
    )
    return {"particles": figure}
