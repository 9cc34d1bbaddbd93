"""Files of a cascade: closures, table.csv of the parts, samples.csv, summary.json, band.png."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from contbed.dem.extract import Fit
from contbed.design.cascade.band import BAND, PACKING
from contbed.design.cascade.outcome import Outcome
from contbed.output.files import atomic
from contbed.output.plots import styled_figure
from contbed.output.summary import write_json
from contbed.sweep.table import parameter, result
from contbed.versions import versions

_BLUE, _GREY = "#0072B2", "0.75"


def write(found: Outcome, fits: Mapping[str, Fit]) -> None:
    """Write all files; the closures that were fitted to all packings under their kind."""
    folder = found.folder
    for fit in fits.values():
        provenance = {"scene": found.cascade.path.name, "packings": str(len(found.porosities))}
        fit.write(folder / f"{fit.content['kind']}.toml", provenance)
    names = list(found.base)
    _table(
        folder / "table.csv",
        [
            "part",
            *(f"deviation of {result(name).header}" for name in names),
            *(f"share in {n}" for n in names),
        ],
        (
            [part.name, *(part.deviation[name] for name in names), *(found.shares(name)[part.name] for name in names)]
            for part in found.parts
        ),
    )
    _table(
        folder / "samples.csv",
        [
            *(parameter(name, values).header if name != PACKING else name for name, values in found.drawn.items()),
            *(result(name).header for name in names),
        ],
        zip(*found.drawn.values(), *(found.samples[name].tolist() for name in names), strict=True),
    )
    write_json(folder / "summary.json", _summary(found))
    _plot(folder / "band.png", found)


def _table(path: Path, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([[repr(v) if isinstance(v, float) else v for v in row] for row in rows])
    with atomic(path) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8")


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
        "parts": [{"name": part.name, "standard_deviation": dict(part.deviation)} for part in found.parts],
        "visited": {name: list(ends) for name, ends in found.ranges.items()},
        "porosities": found.porosities.tolist(),
        "laws": "equally probable: a choice among models, no measured uncertainty",
        "runs": {"asked": found.runs, "before": found.before},
        "warnings": list(found.warnings),
    }


def _plot(path: Path, found: Outcome) -> None:
    """Draw the samples of each result with its band, and the parts of its uncertainty."""
    names = list(found.base)
    with styled_figure(path, 2.6 * len(names) + 0.5, found.cascade.settings.title) as figure:
        panels = figure.subplots(len(names), 2, squeeze=False)
        for (left, right), name in zip(panels, names, strict=True):
            left.hist(found.samples[name], bins="auto", color=_GREY)
            low, high = found.band(name)
            left.axvspan(low, high, color=_BLUE, alpha=0.15, label=f"{BAND:.0%} of the runs")
            left.axvline(found.base[name], color=_BLUE, label="best values")
            left.set(xlabel=result(name).header, ylabel="runs")
            left.legend(fontsize=8)
            shares = found.shares(name)
            order = sorted(shares, key=lambda part: shares[part])
            right.barh(order, [100.0 * shares[part] for part in order], color=_BLUE)
            right.set(xlabel="share of the variance [%]", xlim=(0.0, 100.0))
