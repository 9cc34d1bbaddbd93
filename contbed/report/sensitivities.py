"""The report of `contbed sensitivities`: the derivatives of each result, the largest
first, as bars and as a table.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from contbed.many.derivatives.sensitivities import FILE, HOW, MOST_BARS, quotient
from contbed.output.colours import COLOURS
from contbed.output.folder import SUMMARY
from contbed.output.shapes import Number, Shape
from contbed.report import page
from contbed.report.study import Content, Found, Study

ROW = 24  # height of a bar [pixels]
AXIS = 100  # height of axis and title [pixels]


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
    keys: dict[str, Valued]
    derivatives: list[list[Number]]
    relative: list[list[Number]]
    standard_errors: list[list[Number]] | None


def _is_in(folder: Path) -> bool:
    """Return whether a folder holds derivatives, and no run beside them."""
    return (folder / f"{FILE}.json").is_file() and not (folder / SUMMARY).exists()


def _content(folder: Path, found: Found, made: page.Charts) -> Content:
    bars = [_bars(found, i) for i in range(len(found["qoi"]))]
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
        page.section("All derivatives", _table(found), "derivatives"),
    ]
    title = str(found["title"] or f"Derivatives of {', '.join(found['qoi'])}")
    return Content(title, f"derivatives {HOW[found['method']]}", sections)


def _order(relative: Sequence[float | None]) -> list[int]:
    """Return the numbers of the keys by the size of the relative derivative, those
    without one last.
    """
    return sorted(
        range(len(relative)),
        key=lambda k: -1.0 if (value := relative[k]) is None else -abs(value) - 1.0,
    )


def _bars(found: Found, i: int) -> dict[str, Any]:
    """Return the relative derivatives of one result as bars, the largest on top."""
    relative, keys, result = (
        found["relative"][i],
        list(found["keys"]),
        list(found["qoi"])[i],
    )
    shown = [k for k in _order(relative) if relative[k] is not None][:MOST_BARS]
    colours = [COLOURS[0] if relative[k] >= 0.0 else COLOURS[1] for k in shown]
    chart = page.bars(
        result, {keys[k]: relative[k] for k in shown}, f"d ln {result} / d ln key"
    )
    trace = chart["data"][0]
    trace |= {"name": result, "marker": {"color": colours}, "showlegend": False}
    if found["standard_errors"] is not None and found["qoi"][result]["value"]:
        trace["error_x"] = {
            "type": "data",
            "array": [_relative_error(found, i, k) for k in shown],
        }
    return chart | {"height": AXIS + ROW * len(shown)}


def _relative_error(found: Found, i: int, k: int) -> float | None:
    """Return the standard error of a relative derivative."""
    result, key = (
        list(found[group].values())[at]["value"]
        for group, at in (("qoi", i), ("keys", k))
    )
    error = found["standard_errors"][i][k]
    return None if error is None or key is None else math.fabs(error * key / result)


def _table(found: Found) -> str:
    keys = list(found["keys"].items())
    errors = found["standard_errors"]
    rows = []
    for i, (result, about) in enumerate(found["qoi"].items()):
        for k in _order(found["relative"][i]):
            name, key = keys[k]
            own = quotient(about["unit"], key["unit"])
            row = [page.code(result), page.code(name), page.number(key["value"]), page.unit(key["unit"]),
                   page.number(found["derivatives"][i][k]), page.unit(own),
                   page.number(found["relative"][i][k])]  # fmt: skip
            rows.append(row if errors is None else [*row, page.number(errors[i][k])])
    head = [
        "result",
        "key",
        "value",
        "unit",
        "derivative",
        "unit of derivative",
        "relative",
    ]
    return page.table(
        head if errors is None else [*head, "standard error"], rows, (2, 4, 6, 7)
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
