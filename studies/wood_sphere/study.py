"""Wood sphere in a furnace at six temperatures: mass that is left and temperature in
the centre, over the time.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
# furnace [K] and the label of its mass loss in the source, which calls the two coldest
# by other numbers
FURNACES = {638: 633, 688: 683, 736: 736, 783: 783, 831: 831, 879: 879}
# whose measured mass loss fitted five constants, with temperatures at 638 and 688 K
CALIBRATED = (638, 736, 831)
STEP, END = 10.0, 1200.0  # [s] of output, and end of the measured temperatures
# constants as published, surface held at the measured temperature
PUBLISHED = {
    "solids.wood.conductivity": 0.2046,
    "solids.wood.conductivity_product": 0.0936,
    "gas.heat_capacity": 0.0,
    "reactions.tar.heat": 1.1e5,
    "reactions.char.heat": -2.1e5,
}
COLUMNS = ("mass_fraction [1]", "T_centre [K]", "T_surface [K]")


def reference(furnace: int) -> dict[str, Any]:
    """Measured times [s] and what is measured there: mass, or temperatures [K]; only
    what is given.
    """
    found: dict[str, Any] = {}
    masses = Table.read(HERE / "data" / "mass.csv")
    name = f"m {FURNACES[furnace]} K [-]"
    if name in masses.columns:
        given = np.isfinite(masses[name])
        found["mass"] = masses["time [s]"][given], masses[name][given]
    rows = Table.read(HERE / "data" / "temperatures.csv")
    here = rows["furnace_K"] == furnace
    if here.any():
        found["surface"] = rows["time_s"][here], rows["T_surface_K"][here]
        found["centre"] = rows["time_s"][here], rows["T_centre_K"][here]
    return found


def variant(furnace: int, **changes: Any) -> cb.Scene:
    """The sphere in a furnace of this temperature."""
    times = np.arange(0.0, END + STEP / 2, STEP).tolist()
    return cb.load(
        HERE / "wood.toml",
        {
            "boundary.surface.ambient": float(furnace),
            "time.end": END,
            "time.times": times,
            **changes,
        },
    )


def held(furnace: int) -> cb.Scene:
    """The sphere with published constants, its surface held at the measured
    temperature.
    """
    t, T = reference(furnace)["surface"]
    surface = {"times": t.tolist(), "values": T.tolist()}
    tables = tomllib.loads((HERE / "wood.toml").read_text(encoding="utf-8"))
    tables["boundary"] = {"surface": {"fixed_temperature": surface}}
    for key, value in PUBLISHED.items():
        *path, last = key.split(".")
        table = tables
        for part in path:
            table = table[part]
        table[last] = value
    tables["time"] = {
        "end": END,
        "times": np.arange(0.0, END + STEP / 2, STEP).tolist(),
        "tolerance": 1e-3,
    }
    return cb.load(tables)


def rows(furnace: int, how: str, result: cb.Result) -> Iterator[list[Any]]:
    """Rows of profiles.csv of one run."""
    columns = result.profiles
    for k, t in enumerate(columns["t [s]"]):
        yield [
            furnace,
            FURNACES[furnace],
            how,
            t,
            *(columns[name][k] for name in COLUMNS),
        ]


def compute() -> Tables:
    """All furnaces by radiation and convection, and two with their measured surface."""
    profiles, scores = [], []
    runs = [(furnace, "furnace", variant(furnace)) for furnace in FURNACES]
    runs += [
        (furnace, "surface", held(furnace))
        for furnace in FURNACES
        if "surface" in reference(furnace)
    ]
    for furnace, how, scene in runs:
        result = cb.run(scene)
        profiles += list(rows(furnace, how, result))
        measured = reference(furnace)
        score: list[Any] = [
            furnace,
            how,
            "fitted" if furnace in CALIBRATED and how == "furnace" else "predicted",
        ]
        for key, name in (
            ("mass", COLUMNS[0]),
            ("centre", COLUMNS[1]),
            ("surface", COLUMNS[2]),
        ):
            if key not in measured:
                score.append(None)
                continue
            t, values = measured[key]
            found = np.interp(t, result.profiles["t [s]"], result.profiles[name])
            score.append(float(np.sqrt(np.mean((found - values) ** 2))))
        scores.append(
            [*score, result.qoi["half_time_s"], result.qoi["mass_fraction_end"]]
        )
    form = {
        "furnace [K]": "d",
        "label of the mass loss [K]": "d",
        "condition": "",
        "t [s]": ".6g",
    }
    named = {"furnace [K]": "d", "condition": "", "constants": ""}
    errors = {
        "RMS of mass [1]": ".3g",
        "RMS of T_centre [K]": ".3g",
        "RMS of T_surface [K]": ".3g",
    }
    return {
        "profiles": Table(form | dict.fromkeys(COLUMNS, ".6g"), profiles),
        "results": Table(
            named | errors | {"half_time_s": ".4g", "mass_fraction_end": ".4g"}, scores
        ),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Mass and temperature in the centre over the time; points are measured."""
    profiles = tables["profiles"]
    figure, (mass, centre) = gallery.figure(1, 2)
    furnaces, how = profiles["furnace [K]"], profiles["condition"]
    for k, furnace in enumerate(FURNACES):
        here = (furnaces == furnace) & (how == "furnace")
        colour = gallery.PALETTE[k % len(gallery.PALETTE)]
        for axes, name, key in (
            (mass, COLUMNS[0], "mass"),
            (centre, COLUMNS[1], "centre"),
        ):
            axes.plot(
                profiles["t [s]"][here],
                profiles[name][here],
                color=colour,
                label=f"{furnace} K",
            )
            if key in (measured := reference(furnace)):
                axes.plot(*measured[key], "o", markersize=2.5, color=colour)
    mass.set(xlabel="time [s]", ylabel="mass that is left")
    centre.set(xlabel="time [s]", ylabel="temperature in the centre [K]")
    mass.legend(fontsize=7)
    return {"profiles": figure}
