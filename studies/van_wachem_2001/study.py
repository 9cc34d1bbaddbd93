"""Bubbling and slugging bed of van Wachem et al. (2001): pressure at 45 mm, by
particles in a gas and by two fluids.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.many.validate import signal
from contbed.many.validate.case import Case, read_case
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
BED = "van_wachem_2001"
NOT_COMPARED = ("CPU [s]",)
PRESSURE, HEIGHTS = "middle p [Pa]", ("height [m]", "height_max [m]")
START = 2.0  # s, from when on statistics are taken
SHOWN = (3.0, 6.0)  # s, of the measured trace
COLOURS = {
    "measured": gallery.BLACK,
    "particles": gallery.BLUE,
    "particles, drag of Gidaspow": gallery.GREEN,
    "two fluids": gallery.VERMILION,
}
# keys of two_fluid.toml that each of these models changes
TWO_FLUID: dict[str, dict[str, str]] = {
    "two fluids": {},
    "two fluids, newtonian friction": {
        "closures.friction_viscosity": "friction_viscosity_newtonian"
    },
    "two fluids, drag of Beetstra": {"closures.drag": "drag_beetstra"},
}
PARTICLES: dict[str, dict[str, str]] = {  # and of the scene of the case
    "particles": {},
    "particles, drag of Gidaspow": {"gas.drag": "gidaspow"},
}
MODELS = (*PARTICLES, *TWO_FLUID)


def scene_of(model: str) -> cb.Scene:
    """Scene of a model: that of the case, or of this folder."""
    if model in PARTICLES:
        return read_case(BED).scene(**PARTICLES[model])
    return cb.load(HERE / "two_fluid.toml", TWO_FLUID[model])


def reference() -> Case:
    """The measured bed with its points."""
    return read_case(BED)


def compute(cases: Sequence[str] = MODELS) -> Tables:
    """Run the models; statistics of their pressure and height, and the traces;
    committed rows of others are kept.
    """
    runs, cpu = {}, {}
    for model in cases:
        timed = gallery.cpu(lambda model=model: cb.run(scene_of(model)), samples=1)
        runs[model], cpu[model] = timed.result.profiles, timed.seconds
    return gallery.updated(
        HERE,
        tables_of(runs, cpu),
        {name: ["model"] for name in ("statistics", "traces", "spectra")},
    )


def tables_of(
    runs: Mapping[str, Mapping[str, Any]], cpu: Mapping[str, float]
) -> Tables:
    """Tables of the profiles over time of each model, and of its processor time [s]."""
    points = reference().points
    record = points.t[-1] - points.t[0]
    measured = signal.statistics(*signal.resampled(points.t, points.value), record)
    rows = [_row("measured", (points.t[0], points.t[-1]), measured)]
    traces = [
        ("measured", t, p, None, None)
        for t, p in zip(points.t, points.value, strict=True)
    ]
    spectra = [
        ("measured", *pair) for pair in _spectrum(points.t, points.value, record)
    ]
    for model, columns in runs.items():
        late = columns["t [s]"] >= START
        t, p = columns["t [s]"][late], columns[PRESSURE][late]
        found = _row(
            model, (t[0], t[-1]), signal.statistics(*signal.resampled(t, p), record)
        )
        heights = [columns[name][late] if name in columns else None for name in HEIGHTS]
        for name, height in zip(HEIGHTS, heights, strict=True):
            if height is not None:
                found |= {
                    f"mean of {name}": height.mean(),
                    f"deviation of {name}": height.std(),
                }
        rows.append(found | {"CPU [s]": cpu.get(model)})
        shown = (t >= SHOWN[0]) & (t <= SHOWN[1])
        mean, high = (
            height if height is not None else np.full(len(t), None)
            for height in heights
        )
        traces += [
            (model, *row)
            for row in zip(
                t[shown], (p - p.mean())[shown], mean[shown], high[shown], strict=True
            )
        ]
        spectra += [(model, *pair) for pair in _spectrum(t, p, record)]
    return {
        "statistics": Table.of(rows, ".3g"),
        "traces": Table(
            dict.fromkeys(("model", "t [s]", "p [Pa]", *HEIGHTS), ".5g"), traces
        ),
        "spectra": Table(
            dict.fromkeys(("model", "frequency [Hz]", "power [Pa2 s]"), ".4g"), spectra
        ),
    }


def _row(
    model: str, window: tuple[float, float], found: signal.Statistics
) -> dict[str, Any]:
    row: dict[str, Any] = {"model": model, "from [s]": window[0], "to [s]": window[1]}
    for name, value, spread, unit in zip(
        signal.NAMES, found.value, found.uncertainty, ("Pa", "Hz", "Hz"), strict=True
    ):
        row |= {f"{name} [{unit}]": value, f"uncertainty of {name} [{unit}]": spread}
    return row


def _spectrum(t: Any, p: Any, record: float) -> Any:
    return zip(*signal.spectrum(*signal.resampled(t, p), record), strict=True)


def plot(tables: Tables) -> dict[str, Any]:
    """Traces of pressure and height, and spectra, measured and of both models."""
    figure, panels = gallery.figure(1, 3, size=(13.0, 4.2))
    for model, colour in COLOURS.items():
        if model not in tables["traces"].values("model"):
            continue
        trace, power = (
            tables[name].where({"model": model}) for name in ("traces", "spectra")
        )
        style = {"marker": "o", "ms": 2, "lw": 0.8} if model == "measured" else {}
        panels[0].plot(
            trace["t [s]"], trace["p [Pa]"], color=colour, label=model, **style
        )
        panels[2].loglog(power["frequency [Hz]"], power["power [Pa2 s]"], color=colour)
        if model == "particles":
            panels[1].plot(
                trace["t [s]"],
                trace["height [m]"],
                color=colour,
                label="mean of the surface",
            )
            panels[1].plot(
                trace["t [s]"],
                trace["height_max [m]"],
                color=gallery.SKY,
                label="highest particle",
            )
    panels[0].set(xlabel="$t$ [s]", ylabel="$p$ at 45 mm over its mean [Pa]")
    panels[1].set(xlabel="$t$ [s]", ylabel="height of the bed, particles [m]")
    panels[2].set(
        xlabel="frequency [Hz]",
        ylabel="power [Pa$^2$ s]",
        xlim=(None, 30.0),
        ylim=(1e-1, None),
    )
    panels[1].legend()
    figure.legend(
        *panels[0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=len(COLOURS),
    )
    return {"van_wachem": figure}
