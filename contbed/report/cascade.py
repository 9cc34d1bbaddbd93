"""The report of a cascade: each result with its band, the shares of packing, fit,
laws, data and mesh in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from contbed.fields import unit_of
from contbed.many.cascade.band import BAND
from contbed.many.quantities import result
from contbed.output.colours import COLOURS
from contbed.output.shapes import Number, Pair, Shape
from contbed.report import page
from contbed.report.linked import Column, linked, read_columns
from contbed.report.study import Content, Found, Study, has

POINTS = ("t", "position", "measured", "best", "low", "high")  # columns of measured.csv


class Band(Shape):
    """Band of a result and its moments."""

    probability: float
    low: Number
    high: Number
    mean: Number
    standard_deviation: Number


class Part(Shape):
    """A part of the uncertainty: the standard deviation of each result by it."""

    name: str
    standard_deviation: dict[str, float]


class Measured(Shape):
    """Measured points and what of them lies in the bands."""

    case: str
    quantity: str
    unit: str
    uncertainty: Number
    points: int
    inside: float = Field(alias="share in the band")
    inside_measured: float = Field(alias="share in the band of a measurement")
    shares: dict[str, float] = Field(alias="shares of the parts")


class Runs(Shape):
    """Numbers of runs."""

    asked: int


class CascadeSummary(Shape):
    """summary.json of a cascade."""

    cascade: str
    title: str | None = None
    versions: dict[str, Any]
    qoi: dict[str, Number]
    band: dict[str, Band]
    parts: list[Part]
    measured: Measured | None = None
    visited: dict[str, Pair]
    porosities: Annotated[list[float], Field(min_length=1)]
    laws: str
    runs: Runs
    warnings: list[str]


def _content(folder: Path, found: Found, made: page.Charts) -> Content:
    samples = read_columns(
        folder / "samples.csv", numbers=[result(name).name for name in found["qoi"]]
    )
    count = len(next(iter(samples.values())).values)
    about = (
        f"{len(found['porosities'])} packings, {count} runs with everything uncertain "
        "at once; "
        f"{found['runs']['asked']} runs in all"
    )
    charts = [
        chart
        for name in found["qoi"]
        for chart in (_samples(found, samples, name), _bars(found, name))
    ]
    rows = [f"run {k + 1}" for k in range(count)]
    sections = [
        page.section("What was found", _answer(found), "results"),
        page.warnings(found["warnings"]),
        page.section("What the bands come from", _parts(found), "parts"),
        page.section(
            "Measured points",
            _measured(found) + made.grid(_points(folder, found)),
            "measured",
        ),
        page.section("Bands and shares", made.grid(charts), "bands"),
        linked(list(samples.values()), rows).section(
            "Linked plots of the runs with everything uncertain", made.place
        ),
        page.section(
            "What the bed visits and the packings have", _visited(found), "visited"
        ),
    ]
    return Content(
        str(found.get("title") or f"Cascade of {found['cascade']}"), about, sections
    )


def _answer(found: Found) -> str:
    """Return each result at the best values, its band, and mean and standard
    deviation of the runs.
    """
    if not found["qoi"]:
        return ""
    rows = []
    for name, value in found["qoi"].items():
        band, unit = found["band"][name], unit_of(name)
        cells = (
            value,
            band["low"],
            band["high"],
            band["mean"],
            band["standard_deviation"],
        )
        rows.append([page.code(name), *map(page.number, cells), page.unit(unit)])
    share = next(iter(found["band"].values()))["probability"]
    head = [
        "result",
        "at the best values",
        f"{share:.0%} from",
        "to",
        "mean",
        "standard deviation",
        "unit",
    ]
    return page.table(head, rows, range(1, 6))


def _shares(found: Found, name: str) -> dict[str, tuple[float, float]]:
    """Return standard deviation and share in the sum of the variances of each part,
    the largest first.
    """
    deviations = {
        part["name"]: float(part["standard_deviation"][name]) for part in found["parts"]
    }
    total = sum(value**2 for value in deviations.values()) or 1.0
    order = sorted(deviations, key=lambda part: -deviations[part])
    return {part: (deviations[part], deviations[part] ** 2 / total) for part in order}


def _parts(found: Found) -> str:
    rows = [
        [
            page.code(name),
            escape(part),
            page.number(deviation),
            escape(unit_of(name) or ""),
            f"{share:.1%}",
        ]
        for name in found["qoi"]
        for part, (deviation, share) in _shares(found, name).items()
    ]
    if not rows:
        return ""
    head = [
        "result",
        "part",
        "standard deviation",
        "unit",
        "share of the sum of the variances",
    ]
    return (
        page.table(head, rows, (2, 4))
        + f"<p class=quiet>Laws of one particle: {escape(found['laws'])}.</p>"
    )


def _measured(found: Found) -> str:
    """Return how many of the measured points the bands hold, and the shares of the
    parts at them.
    """
    about = found.get("measured")
    if not about:
        return ""
    text = (
        f"{about['case']}, {about['points']} points of {about['quantity']}: "
        f"{about['share in the band']:.1%} are in "
        f"the band of {BAND:.0%}, {about['share in the band of a measurement']:.1%} "
        "with their own scatter of "
        f"{page.number(about['uncertainty'])} {about['unit']}"
    )
    order = sorted(about["shares of the parts"].items(), key=lambda item: -item[1])
    rows = [[escape(part), f"{share:.1%}"] for part, share in order]
    return f"<p>{escape(text)}.</p>" + page.table(
        ["part", "share of the variances at all points"], rows, (1,)
    )


def _points(folder: Path, found: Found) -> list[dict[str, Any]]:
    """Return measured and predicted values over time with the band, a chart for each
    position.
    """
    about = found.get("measured")
    if not about:
        return []
    columns = read_columns(folder / "measured.csv", numbers=POINTS)
    t, x = columns["t"].values, columns["position"].values
    charts = []
    for place in sorted({value for value in x if value is not None}):
        here = [k for k, value in enumerate(x) if value == place and t[k] is not None]
        here.sort(key=lambda k: t[k])
        take = {name: [columns[name].values[k] for k in here] for name in columns}
        line = {"type": "scatter", "x": take["t"]}
        traces = [
            line | {"mode": "lines", "name": "low", "y": take["low"], "line": {"color": COLOURS[5], "width": 1}},
            line | {"mode": "lines", "name": "high", "y": take["high"], "line": {"color": COLOURS[5], "width": 1},
                    "fill": "tonexty"},
            line | {"mode": "lines", "name": "best values", "y": take["best"], "line": {"color": COLOURS[1]}},
            line | {"mode": "markers", "name": "measured", "y": take["measured"], "marker": {"color": COLOURS[6]}},
        ]  # fmt: skip
        layout = page.axes("t [s]", f"{about['quantity']} [{about['unit']}]")
        charts.append(
            {
                "kind": "curves",
                "title": f"at {place:g} m",
                "data": traces,
                "layout": layout,
            }
        )
    return charts


def _samples(found: Found, samples: Mapping[str, Column], name: str) -> dict[str, Any]:
    """Return the histogram of a result with its band and the result at the best
    values.
    """
    about = result(name)
    band, column = found["band"][name], samples[about.name]
    shapes = [
        {"type": "rect", "yref": "paper", "x0": band["low"], "x1": band["high"], "y0": 0, "y1": 1, "layer": "below",
         "fillcolor": COLOURS[5], "opacity": 0.3, "line": {"width": 0}},
        {"type": "line", "yref": "paper", "x0": found["qoi"][name], "x1": found["qoi"][name], "y0": 0, "y1": 1,
         "line": {"color": COLOURS[1]}},
    ]  # fmt: skip
    bars = {
        "type": "histogram",
        "x": list(column.values),
        "marker": {"color": COLOURS[0]},
        "name": "runs",
    }
    layout = page.axes(column.label, "runs", shapes=shapes)
    title = (
        f"{about.name}: runs, band of {band['probability']:.0%} (blue) and best "
        "values (line)"
    )
    return {"kind": "bars", "title": title, "data": [bars], "layout": layout}


def _bars(found: Found, name: str) -> dict[str, Any]:
    shares = {part: 100.0 * share for part, (_, share) in _shares(found, name).items()}
    title = f"{result(name).name}: what the band comes from"
    return page.bars(title, shares, "share of the variance [%]", range=[0, 100])


def _visited(found: Found) -> str:
    rows = [
        [escape(name), page.number(low), page.number(high)]
        for name, (low, high) in found["visited"].items()
    ]
    rows.append(
        [
            "porosity of the packings",
            page.number(min(found["porosities"])),
            page.number(max(found["porosities"])),
        ]
    )
    return page.table(["", "from", "to"], rows, (1, 2))


CASCADE = Study(
    "cascade",
    "cascade",
    CascadeSummary,
    _content,
    "the summary of a cascade",
    has("cascade"),
)
