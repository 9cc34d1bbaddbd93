"""Reduction of fine ore in a small fluidized bed: one run fits two constants, two
runs are predicted.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from contbed.chemistry.laws import three_interfaces as three
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies.iron_ore_bed.model import Fitted, Ore, Run, reduce

HERE = Path(__file__).parent
OFFSET = 450.0  # [s], of the recorder's time of R1 when the gas was switched
STEP, END = 20.0, 4500.0  # [s] of the output
GASES = {  # mass fractions
    "R1": {"CO": 0.392, "CO2": 0.233, "H2": 0.010, "H2O": 0.023, "N2": 0.342},
    "R2": {"CO": 0.3802, "CO2": 0.4376, "H2": 0.01166, "H2O": 0.0445, "N2": 0.1261},
    "R3": {"CO": 0.230, "CO2": 0.493, "H2": 0.009, "H2O": 0.042, "N2": 0.226},
}
# R1 begins as wustite, R2 as magnetite, R3 as hematite
RUNS = {
    "R1": Run(993.15, GASES["R1"], (0.0, 0.0, 1.0)),
    "R2": Run(1023.15, GASES["R2"], (0.0, 1.0, 1.0)),
    "R3": Run(753.15, GASES["R3"], (1.0, 1.0, 1.0)),
}
# where the gas of a run stops, by stoichiometry: magnetite 1/9, wustite 1/3
PLATEAU = {"R2": 100.0 / 3.0, "R3": 100.0 / 9.0}
PUBLISHED = Ore()
# rate constants of pellets [cm/s] in m/s
PELLETS = replace(
    PUBLISHED,
    rate={
        gas: tuple((1e-2 * np.exp(a), 1e3 * E) for a, E in three.TAKAHASHI[gas].rate)
        for gas in ("CO", "H2")
    },
)
MOMENTS = (120.0, 300.0, 600.0)  # [s]
# means of the measured points of the predicted runs at these times [percent], which
# enter no fit
MEASURED = {"R2": (21.3, 27.1, 32.4), "R3": (5.6, 10.2, 12.2)}
TIMES = np.arange(0.0, END + STEP / 2, STEP)


def reference(run: str) -> tuple[Any, Any]:
    """Measured times [s] after the switch of gas and reduction [percent]; R1 only."""
    table = Table.read(HERE / "data" / f"{run}.csv")
    t = table["time [s]"] - OFFSET
    return t[t >= 0.0], table["fractional_reduction [percent]"][t >= 0.0]


def fitted(ore: Ore) -> Fitted:
    """The factor of the rate constants that fits R1."""
    t, measured = reference("R1")

    def errors(p: Any) -> Any:
        return (
            np.interp(
                t,
                TIMES,
                100.0 * reduce(RUNS["R1"], ore, Fitted(float(np.exp(p[0]))), TIMES),
            )
            - measured
        )

    found = least_squares(
        errors, [0.0 if ore is PUBLISHED else np.log(0.07)], diff_step=1e-2, max_nfev=8
    )
    return Fitted(float(np.exp(found.x[0])))


def with_hematite_of(ore: Ore, other: Ore, factor: float) -> Ore:
    """Rate constants of one set, that of hematite from another, times a factor."""
    rate = {}
    for gas, (_, *rest) in ore.rate.items():
        k, E = other.rate[gas][0]
        rate[gas] = ((factor * k, E), *rest)
    return replace(ore, rate=rate)  # type: ignore[arg-type]


def what_if(ore: Ore, own: Fitted) -> Table:
    """R2 and R3 with one condition of the model changed at a time, beside what was
    measured.
    """
    finer, open_layers = (
        replace(ore, radii=tuple(0.5 * r for r in ore.radii)),
        replace(ore, tortuosity=0.1 * ore.tortuosity),
    )
    fast = replace(own, rate=100.0 * own.rate)
    rows: list[list[Any]] = []
    for name in ("R2", "R3"):
        run = RUNS[name]
        hotter, more = (
            replace(run, temperature=run.temperature + 30.0),
            replace(run, velocity=2.0 * run.velocity),
        )
        cases = {
            "as predicted": (run, ore, own),
            "30 K hotter": (hotter, ore, own),
            "particles of half the size": (run, finer, own),
            "diffusion in layers x 10": (run, open_layers, own),
            "film x 10": (run, replace(ore, film=10.0), own),
            "rate constants x 3": (run, ore, replace(own, rate=3.0 * own.rate)),
            "rate constants x 8": (run, ore, replace(own, rate=8.0 * own.rate)),
            "twice the gas": (more, ore, own),
            "supply of gas alone limits": (run, open_layers, fast),
        }
        times = np.array([0.0, *MOMENTS])
        for what, (changed, material, factor) in cases.items():
            rows.append(
                [name, what, *(100.0 * reduce(changed, material, factor, times))[1:]]
            )
        rows.append([name, "measured", *MEASURED[name]])
    return Table(
        {
            "run": "",
            "what": "",
            **{f"{moment:g} s [percent]": ".4g" for moment in MOMENTS},
        },
        rows,
    )


def compute() -> Tables:
    """Fit to R1, predict R2 and R3; beside it with the published constants of all
    steps.
    """
    own, pellets = fitted(PUBLISHED), fitted(PELLETS)
    ore = with_hematite_of(PUBLISHED, PELLETS, pellets.rate / own.rate)
    rows, scores = [], []
    for name, run in RUNS.items():
        chosen = 100.0 * reduce(run, ore, own, TIMES)
        published = 100.0 * reduce(run, PUBLISHED, own, TIMES)
        rows += [
            [name, t, a, b] for t, a, b in zip(TIMES, chosen, published, strict=True)
        ]
        errors: list[Any] = [None, None]
        if name == "R1":
            t, measured = reference(name)
            error = np.interp(t, TIMES, chosen) - measured
            errors = [float(np.sqrt(np.mean(error**2))), float(error.mean())]
        levels = [
            float(np.interp(moment, TIMES, chosen))
            for moment in (120.0, 300.0, 600.0, 1600.0, 4000.0)
        ]
        scores.append(
            [
                name,
                "fitted" if name == "R1" else "predicted",
                own.rate,
                pellets.rate,
                *errors,
                *levels,
            ]
        )
    columns = {
        "run": "",
        "t [s]": ".6g",
        "fractional_reduction [percent]": ".5g",
        "published constants [percent]": ".5g",
    }
    named = {
        "run": "",
        "constants": "",
        "factor": ".4g",
        "factor of hematite": ".4g",
        "RMS [percent]": ".3g",
    }
    levels = {f"{moment} s [percent]": ".4g" for moment in (120, 300, 600, 1600, 4000)}
    return {
        "what_if": what_if(ore, own),
        "profiles": Table(columns, rows),
        "results": Table(named | {"bias [percent]": ".2g"} | levels, scores),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Reduction over the time; points are measured."""
    profiles = tables["profiles"]
    figure, axes = gallery.figure()
    for name, colour in zip(
        RUNS, (gallery.VERMILION, gallery.BLUE, gallery.GREEN), strict=True
    ):
        here = profiles["run"] == name
        axes.plot(
            profiles["t [s]"][here],
            profiles["fractional_reduction [percent]"][here],
            color=colour,
            label=name,
        )
        axes.plot(
            profiles["t [s]"][here],
            profiles["published constants [percent]"][here],
            "--",
            color=colour,
        )
        if name in PLATEAU:
            axes.axhline(PLATEAU[name], color=gallery.GREY, linewidth=0.6)
    axes.plot(*reference("R1"), "o", markersize=2, color=gallery.VERMILION)
    axes.set(xlabel="time since the gas was switched [s]", ylabel="reduction [%]")
    axes.legend()
    return {"profiles": figure}
