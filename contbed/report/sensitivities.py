"""The report of `contbed sensitivities`: the derivatives of each result, the largest
first, as bars and as a table.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from contbed.many.derivatives.sensitivities import FILE, HOW, MOST_BARS
from contbed.output.colours import COLOURS
from contbed.output.folder import SUMMARY
from contbed.output.shapes import Number, Shape
from contbed.report import page
from contbed.report.linked import Column, read_columns, table_of
from contbed.report.study import Content, Found, Study

ROW = 24  # height of a bar [pixels]
AXIS = 100  # height of axis and title [pixels]
NUMBERS = ("value", "derivative", "relative", "standard error")  # columns of the table


class Valued(Shape):
    """A result or key: its value and unit."""

    value: Number
    unit: str


class Derivatives(Shape):
    """sensitivities.json."""

    title: str | None
    method: str
    versions: dict[str, Any]
    notes: list[str]
    qoi: dict[str, Valued]


def _is_in(folder: Path) -> bool:
    """Return whether a folder holds derivatives, and no run beside them."""
    return (folder / f"{FILE}.json").is_file() and not (folder / SUMMARY).exists()


def _content(folder: Path, found: Found, made: page.Charts) -> Content:
    columns = read_columns(folder / f"{FILE}.csv", ("result", "key"), NUMBERS)
    bars = [_bars(columns, name) for name in found["qoi"]]
    sections = [
        page.section(
            "Results",
            page.found({name: each["value"] for name, each in found["qoi"].items()}),
            "qoi",
        ),
        page.warnings(found["notes"]),
        page.section(
            "Percent of the result for one percent of the key", made.grid(bars), "bars"
        ),
        page.section("All derivatives", table_of(columns.values()), "derivatives"),
    ]
    title = str(found["title"] or f"Derivatives of {', '.join(found['qoi'])}")
    return Content(title, f"derivatives {HOW[found['method']]}", sections)


def _bars(columns: Mapping[str, Column], result: str) -> dict[str, Any]:
    """Return the relative derivatives of one result as bars, the largest on top."""
    keys, relative = (columns[name].values for name in ("key", "relative"))
    shown = [
        k
        for k, name in enumerate(columns["result"].values)
        if name == result and relative[k] is not None
    ][:MOST_BARS]
    colours = [COLOURS[0] if relative[k] >= 0.0 else COLOURS[1] for k in shown]
    chart = page.bars(
        result, {keys[k]: relative[k] for k in shown}, f"d ln {result} / d ln key"
    )
    trace = chart["data"][0]
    trace |= {"name": result, "marker": {"color": colours}, "showlegend": False}
    errors = [_relative_error(columns, k) for k in shown]
    if any(error is not None for error in errors):
        trace["error_x"] = {"type": "data", "array": errors}
    return chart | {"height": AXIS + ROW * len(shown)}


def _relative_error(columns: Mapping[str, Column], k: int) -> float | None:
    """Return the standard error of a relative derivative."""
    error, derivative, relative = (
        columns[name].values[k] for name in ("standard error", "derivative", "relative")
    )
    return (
        None if not derivative or error is None else abs(error / derivative * relative)
    )


DERIVATIVES = Study(
    "table of derivatives",
    "sensitivities",
    Derivatives,
    _content,
    "a table of derivatives",
    _is_in,
    f"{FILE}.json",
)
