"""Thermocline storage in its daily cycle: what comes back of the heat, over the size
of the stones and the hours.
"""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

import contbed as cb
from contbed.models import plan
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
DIAMETERS = (0.015, 0.05, 0.10)  # [m]
HOURS = (4.0, 6.0, 8.0)  # of charge and of discharge
SHOWN = (6.0, 12.0, 18.0, 24.0)  # [h] of the profiles
LEVELS = ("lumped", "effective", "interior")
HOUR = 3600.0
NOT_COMPARED = ("CPU [s]", "cycle_change_K")


def variant(diameter: float, hours: float, level: str = "auto") -> cb.Scene:
    """The day with other stones, and other hours of charge and discharge, each
    before a standby of the rest of 12 h.
    """
    times = [0.0, hours * HOUR, 12.0 * HOUR, (12.0 + hours) * HOUR]
    changes = {
        "boundary.left.gas.velocity.times": times,
        "solids.quartzite.diameter": diameter,
        "solids.quartzite.inside.heat": level,
    }
    return cb.load(HERE / "day.toml", changes)


def reference(scene: cb.Scene) -> float:
    """Heat that a bed could hold between both inlet temperatures [J/m2]."""
    fluid, solid, eps = scene.gas, scene.solid, scene.packed_bed.porosity
    content = (
        eps * fluid.density * fluid.heat_capacity
        + (1.0 - eps) * solid.density * solid.heat_capacity
    )
    return float(content * scene.mesh.length * 100.0)


def compute() -> Tables:
    """Cyclic steady states over diameter and hours, by three levels of the inside of
    the stones; profiles of one.
    """
    rows = []
    for diameter, hours in product(DIAMETERS, HOURS):
        for level in LEVELS:
            scene = variant(diameter, hours, level)
            start = process_time()
            result = cb.run(scene)
            seconds = process_time() - start
            q = result.qoi
            biot = dict((*plan(scene).built, *plan(scene).skipped))[
                "intraparticle conduction"
            ]
            rows.append(
                [1e3 * diameter, hours, level, float(re.split("[;,)]", biot.split("Bi = ")[1])[0]),
                 q["storage_efficiency"], q["effectiveness_discharge"], q["heat_discharged_J"] / reference(scene),
                 q["cycle_periods"], q["cycle_change_K"], seconds]
            )  # fmt: skip
    result = cb.run(variant(0.05, 6.0))
    columns = result.profiles
    form = {
        "diameter [mm]": ".3g",
        "hours of charge [h]": ".3g",
        "inside": "",
        "Bi": ".3g",
    }
    form |= {
        "storage_efficiency": ".5f",
        "effectiveness_discharge": ".5f",
        "share of the capacity": ".5f",
    }
    form |= {"periods": "d", "cycle_change_K": ".1e", "CPU [s]": ".2f"}
    names = ("t [s]", "x [m]", "T_fluid [K]", "T_solid [K]")
    return {
        "results": Table(form, rows),
        "profiles": Table.from_columns({name: columns[name][::4] for name in names}),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures over the height at four times, and what is used of the heat over
    the hours of charge.
    """
    figure, (profiles, used) = gallery.figure(1, 2)
    table, results = tables["profiles"], tables["results"]
    for k, hour in enumerate(SHOWN):
        here = np.isclose(table["t [s]"], hour * HOUR)
        profiles.plot(
            table["T_fluid [K]"][here],
            table["x [m]"][here],
            color=gallery.PALETTE[k],
            label=f"{hour:g} h",
        )
    profiles.set(xlabel="temperature of the salt [K]", ylabel="height [m]")
    profiles.legend()
    for k, diameter in enumerate(DIAMETERS):
        for level, line in (("lumped", ":"), ("interior", "-")):
            here = np.isclose(results["diameter [mm]"], 1e3 * diameter) & (
                results["inside"] == level
            )
            label = f"{1e3 * diameter:g} mm" if level == "interior" else None
            x, y = (
                results["hours of charge [h]"][here],
                results["effectiveness_discharge"][here],
            )
            used.plot(x, y, line, color=gallery.PALETTE[k], label=label)
    used.set(
        xlabel="hours of charge and discharge", ylabel="effectiveness of the discharge"
    )
    used.legend()
    return {"thermocline": figure}
