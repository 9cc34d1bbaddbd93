"""A hot bed of three species at five levels of radiation: temperatures, duties, run
times.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.bubbling_bed.problem import BubblingProblem
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
LEVELS = {
    "none": ("no radiation", gallery.GREY),
    "pairwise": ("pairs of species", gallery.GREEN),
    "paper": ("paper's closure", gallery.ORANGE),
    "two_flux": ("two-flux", gallery.BLUE),
    "p1": ("P1", gallery.VERMILION),
}
NOT_COMPARED = ("cpu_s",)
SPECIES = ("char", "limestone", "inert")


def reference() -> cb.Result:
    """The bed with P1, which the other levels are compared with."""
    return cb.run(cb.load(HERE / "p1.toml"))


def table(results: dict[str, cb.Result]) -> Table:
    """Named results of all runs, one column for each."""
    rows = [
        [key, *(each.qoi[key] for each in results.values())]
        for key in next(iter(results.values())).qoi
    ]
    return Table({"result": "", **dict.fromkeys(results, ".7g")}, rows)


def compute() -> Tables:
    """All levels with their CPU; P1 with other corrections for the packing of
    particles.
    """
    scenes = {name: cb.load(HERE / f"{name}.toml") for name in LEVELS}
    results = {
        name: reference() if name == "p1" else cb.run(scene)
        for name, scene in scenes.items()
    }
    times = gallery.in_turn(
        {
            name: lambda s=scene: BubblingProblem(cb.plan(s)).solve()
            for name, scene in scenes.items()
        }
    )
    results_table = table(results)
    results_table.rows.append(
        ("cpu_s", *(f"{times[name].seconds:.2f}" for name in LEVELS))
    )
    p1 = {"independent": results["p1"]}
    p1["close_packed"] = cb.run(
        cb.load(HERE / "p1.toml", {"radiation.correction": "close_packed"})
    )
    p1["backward"] = cb.run(cb.load(HERE / "p1.toml", {"radiation.anisotropy": -4 / 9}))
    rows = [
        (name, *row)
        for name, result in results.items()
        for row in zip(
            *(
                result.profiles[key]
                for key in ("z [m]", *(f"T_{s} [K]" for s in SPECIES))
            ),
            strict=True,
        )
    ]
    columns = {
        "level": "",
        "z [m]": ".5g",
        **{f"T_{name} [K]": ".7g" for name in SPECIES},
    }
    return {
        "results": results_table,
        "packing": table(p1),
        "profiles": Table(columns, rows[::8]),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures of the species over the height, and that of the inert less that
    with P1.
    """
    figure, axes = gallery.figure(1, 4, size=(11, 4.6))
    profiles = {name: tables["profiles"].where({"level": name}) for name in LEVELS}
    for name, (text, colour) in LEVELS.items():
        found = profiles[name]
        for panel, which in zip(axes, SPECIES, strict=False):
            if name != "none":
                panel.plot(
                    found[f"T_{which} [K]"], found["z [m]"], color=colour, label=text
                )
        if name not in ("none", "p1"):
            z, T = profiles["p1"]["z [m]"], profiles["p1"]["T_inert [K]"]
            axes[3].plot(
                np.interp(z, found["z [m]"], found["T_inert [K]"]) - T, z, color=colour
            )
    for panel, which in zip(axes, SPECIES, strict=False):
        panel.set(title=which, xlabel="temperature [K]", ylim=(0, 0.9))
    axes[0].set_ylabel("height above the distributor [m]")
    axes[3].set(title="inert less that with P1", xlabel="difference [K]", ylim=(0, 0.9))
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4
    )
    return {"profiles": figure}
