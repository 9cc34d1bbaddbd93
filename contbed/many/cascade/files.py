"""Files of a cascade: closures, table.csv of the parts, samples.csv, summary.json,
band.png.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contbed.dem.extract import Fit
from contbed.fields import header
from contbed.many.cascade.band import BAND, PACKING
from contbed.many.cascade.measured import Held
from contbed.many.cascade.outcome import Outcome
from contbed.many.quantities import parameter, result
from contbed.many.tables import write_rows
from contbed.many.validate.case import Case
from contbed.output.plots import styled_figure
from contbed.output.summary import write_json
from contbed.output.tables import write_table
from contbed.output.versions import versions

_BLUE, _GREY = "#0072B2", "0.75"

NAMES = (
    *("conductivity.toml", "nusselt.toml", "table.csv", "samples.csv"),
    *("measured.csv", "summary.json", "band.png"),
)


def write(found: Outcome, fits: Mapping[str, Fit]) -> None:
    """Write all files; the closures that were fitted to all packings under their
    kind.
    """
    folder = found.folder
    for fit in fits.values():
        provenance = {
            "scene": found.cascade.path.name,
            "packings": str(len(found.porosities)),
        }
        fit.write(folder / f"{fit.content['kind']}.toml", provenance)
    names = list(found.base)
    at_points = (
        {}
        if found.held is None
        else {"share at the measured points": found.held.shares}
    )
    shares = {f"share in {name}": found.shares(name) for name in names} | at_points
    write_rows(
        folder / "table.csv",
        ["part", *(f"deviation of {result(name).header}" for name in names), *shares],
        (
            [
                part.name,
                *(part.deviation[name] for name in names),
                *(of[part.name] for of in shares.values()),
            ]
            for part in found.parts
        ),
    )
    write_rows(
        folder / "samples.csv",
        [
            *(
                parameter(name, values).header if name != PACKING else name
                for name, values in found.drawn.items()
            ),
            *(result(name).header for name in names),
        ],
        zip(
            *found.drawn.values(),
            *(found.samples[name].tolist() for name in names),
            strict=True,
        ),
    )
    if found.held is not None:
        points = found.held.points
        columns = {
            header("t"): points.t, "position [m]": points.x, "measured": points.value, "best": found.held.best,
            "low": found.held.low, "high": found.held.high,
            "low of a measurement": found.held.low_measured, "high of a measurement": found.held.high_measured,
        }  # fmt: skip
        write_table(folder / "measured.csv", columns)
    write_json(folder / "summary.json", _summary(found))
    _plot(folder / "band.png", found)


def _summary(found: Outcome) -> dict[str, Any]:
    return {
        "status": "ok",
        "versions": versions(),
        "title": found.cascade.settings.title,
        "cascade": found.cascade.path.name,
        "qoi": found.base,
        "band": {
            name: {
                "probability": BAND,
                "low": found.band(name)[0],
                "high": found.band(name)[1],
                "mean": float(found.samples[name].mean()),
                "standard_deviation": float(found.samples[name].std(ddof=1)),
            }
            for name in found.base
        },
        "parts": [
            {"name": part.name, "standard_deviation": dict(part.deviation)}
            for part in found.parts
        ],
        "measured": _measured(found),
        "visited": {name: list(ends) for name, ends in found.ranges.items()},
        "porosities": found.porosities.tolist(),
        "laws": "equally probable: a choice among models, no measured uncertainty",
        "runs": {"asked": found.runs, "before": found.before},
        "warnings": list(found.warnings),
    }


def _measured(found: Outcome) -> dict[str, Any] | None:
    case, held = found.cascade.measured, found.held
    if case is None or held is None:
        return None
    return {
        "case": case.name,
        "quantity": case.settings.quantity,
        "unit": case.unit,
        "uncertainty": case.uncertainty,
        "points": len(held.best),
        "share in the band": held.inside,
        "share in the band of a measurement": held.inside_measured,
        "shares of the parts": dict(held.shares),
    }


def _plot(path: Path, found: Outcome) -> None:
    """Draw the samples of each result with its band, measured points with theirs,
    and the parts of the uncertainty.
    """
    names, rows = list(found.base), len(found.base) + (found.held is not None)
    with styled_figure(path, 2.6 * rows + 0.5, found.cascade.settings.title) as figure:
        panels = figure.subplots(rows, 2, squeeze=False)
        for (left, right), name in zip(panels, names, strict=False):
            left.hist(found.samples[name], bins="auto", color=_GREY)
            low, high = found.band(name)
            left.axvspan(
                low, high, color=_BLUE, alpha=0.15, label=f"{BAND:.0%} of the runs"
            )
            left.axvline(found.base[name], color=_BLUE, label="best values")
            left.set(xlabel=result(name).header, ylabel="runs")
            left.legend(fontsize=8)
            _bars(right, found.shares(name))
        if found.held is not None and found.cascade.measured is not None:
            left, right = panels[-1]
            _points(left, found.cascade.measured, found.held)
            _bars(right, found.held.shares)


def _bars(axes: Any, shares: Mapping[str, float]) -> None:
    order = sorted(shares, key=lambda part: shares[part])
    axes.barh(order, [100.0 * shares[part] for part in order], color=_BLUE)
    axes.set(xlabel="share of the variance [%]", xlim=(0.0, 100.0))


def _points(axes: Any, case: Case, held: Held) -> None:
    """Draw measured values and the band of the prediction over time, a colour for
    each position.
    """
    for k, x in enumerate(np.unique(held.points.x)):
        here = np.flatnonzero(held.points.x == x)
        here = here[np.argsort(held.points.t[here])]
        colour = f"C{k}"
        axes.fill_between(
            held.points.t[here],
            held.low[here],
            held.high[here],
            color=colour,
            alpha=0.2,
            lw=0,
        )
        axes.plot(held.points.t[here], held.best[here], color=colour, label=f"{x:g} m")
        axes.plot(
            held.points.t[here],
            held.points.value[here],
            ".",
            color=colour,
            markersize=3,
        )
    axes.set(xlabel="t [s]", ylabel=f"{case.settings.quantity} [{case.unit}]")
    axes.legend(fontsize=8)
