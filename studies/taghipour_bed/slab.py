"""The bed as a slab with front and back walls, 30 s: does the plane have the height of
the real, flat bed?

Each run keeps its checkpoints in results/studies/taghipour_bed and goes on from there
with the same command.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.raw import raw, resumed
from studies.taghipour_bed.study import SHARES, heights

HERE = Path(__file__).parent
SOLID = {
    side: f"boundary.{side}.solids.beads.wall"
    for side in ("left", "right", "front", "back")
}
TIMES = {"time.end": 30.0, "time.average_from": 3.0}
NOT_COMPARED = ("walls_over_weight", "missing", "halves")
RESULTS = {
    "run": "", "cells": "", **{f"{share}_over_weight": ".3g" for share in SHARES}, "H_0.3": ".4g", "H_0.2": ".4g",
    "H_centre": ".4g", "halves": ".2g", "mass_drift": ".1g",
}  # fmt: skip
# scene, and the keys that a run changes
RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "plane, no slip": ("bed_0.46", TIMES),
    "plane, slip": ("bed_0.46_slip", TIMES),
    "slab, no slip": ("bed_0.46_slab", {}),
    "slab, no slip at the sides only": (
        "bed_0.46_slab",
        {SOLID[side]: "slip" for side in ("front", "back")},
    ),
    "slab, slip": ("bed_0.46_slab", dict.fromkeys(SOLID.values(), "slip")),
}
COLOURS = dict(
    zip(
        RUNS,
        (gallery.GREY, gallery.SKY, gallery.BLACK, gallery.ORANGE, gallery.BLUE),
        strict=True,
    )
)


def reference() -> dict[str, float]:
    """Part of the weight that the gas carries where walls hold nothing."""
    return {"pressure_over_weight": 1.0}


def scene_of(run: str) -> cb.Scene:
    """Scene of a run."""
    name, changes = RUNS[run]
    return cb.load(HERE / f"{name}.toml", changes)


def compute(cases: Sequence[str] = tuple(RUNS)) -> Tables:
    """Run the beds, or go on with them; who carries the weight, heights, and
    fractions over the height.
    """
    rows, profiles = [], []
    for run in cases:
        scene = scene_of(run)
        result = resumed(scene, raw(HERE.name) / run.replace(",", "").replace(" ", "_"))
        q, axial = result.qoi, result.tables["axial"]
        z, eps_s = axial["height [m]"], axial["eps_s [1]"]
        shares = [q[f"weight_{share}"] for share in SHARES]
        cells = "x".join(str(n) for n in scene.mesh.cells)
        rows.append(
            (
                run,
                cells,
                *shares,
                *heights(z, eps_s),
                q["difference_of_halves"],
                q["mass_drift_relative"],
            )
        )
        profiles += [(run, *pair) for pair in zip(z, eps_s, strict=True)]
        print(*rows[-1], flush=True)
    tables = {
        "slab": Table(RESULTS, rows),
        "slab_profiles": Table(
            {"run": "", "height [m]": ".4g", "eps_s [1]": ".4g"}, profiles
        ),
    }
    keys = {"slab": ["run"], "slab_profiles": ["run", "height [m]"]}
    return gallery.updated(HERE, tables, keys)


def plot(tables: Tables) -> dict[str, Any]:
    """Solids volume fraction over the height, mean over the section."""
    figure, axes = gallery.figure(size=(6.4, 4.4))
    for run in tables["slab_profiles"].values("run"):
        found = tables["slab_profiles"].where({"run": run})
        axes.plot(
            found["height [m]"], found["eps_s [1]"], color=COLOURS[run], label=run
        )
    axes.set(
        xlabel="height [m]",
        ylabel="solids volume fraction",
        xlim=(0.0, 0.9),
        ylim=(0.0, None),
    )
    axes.legend()
    return {"slab": figure}
