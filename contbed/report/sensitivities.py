"""The report of `contbed sensitivities`: the derivatives of each result, the largest first, as bars and as a table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from contbed.many.derivatives.sensitivities import FILE, HOW, MOST_BARS, quotient
from contbed.output.folder import SUMMARY
from contbed.output.shapes import Number, Shape, fitting, read_json
from contbed.report import page
from contbed.report.charts import COLOURS

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


def is_sensitivities(folder: Path) -> bool:
    """Return whether a folder holds derivatives, and no run beside them."""
    return (folder / f"{FILE}.json").is_file() and not (folder / SUMMARY).exists()


def of_sensitivities(folder: Path) -> str:
    """Return the report of derivatives.

    Raises
    ------
    ContbedError : their file is damaged
    """
    file = folder / f"{FILE}.json"
    what, remedy = "a table of derivatives", "run contbed sensitivities again"
    found = read_json(file, Derivatives, what, remedy)
    with fitting(file, what, remedy):
        title, made = str(found["title"] or f"Derivatives of {', '.join(found['qoi'])}"), page.Charts()
        text = f"derivatives {HOW[found['method']]}; contbed {found['versions'].get('contbed', '?')}"
        bars = [_bars(found, i) for i in range(len(found["qoi"]))]
        parts = [
            page.header(title, text),
            page.section("Results", page.found({name: each["value"] for name, each in found["qoi"].items()}), "qoi"),
            page.warnings(found["notes"]),
            page.section("Percent of the result for one percent of the key", made.grid(bars), "bars"),
            page.section("All derivatives", _table(found), "derivatives"),
        ]
    return page.page(title, parts, made)


def _order(relative: Sequence[float | None]) -> list[int]:
    """Return the numbers of the keys by the size of the relative derivative, those without one last."""
    return sorted(range(len(relative)), key=lambda k: -1.0 if (value := relative[k]) is None else -abs(value) - 1.0)


def _bars(found: Mapping[str, Any], i: int) -> dict[str, Any]:
    """Return the relative derivatives of one result as bars, the largest on top."""
    relative, keys, result = found["relative"][i], list(found["keys"]), list(found["qoi"])[i]
    shown = [k for k in _order(relative) if relative[k] is not None][:MOST_BARS]
    colours = [COLOURS[0] if relative[k] >= 0.0 else COLOURS[1] for k in shown]
    trace = {"type": "bar", "orientation": "h", "name": result, "y": [keys[k] for k in shown],
             "x": [relative[k] for k in shown], "marker": {"color": colours}, "showlegend": False}  # fmt: skip
    if found["standard_errors"] is not None and found["qoi"][result]["value"]:
        trace["error_x"] = {"type": "data", "array": [_relative_error(found, i, k) for k in shown]}
    layout = {
        "xaxis": {"title": {"text": f"d ln {result} / d ln key"}},
        "yaxis": {"autorange": "reversed", "automargin": True},
    }
    return {"kind": "bars", "title": result, "data": [trace], "layout": layout, "height": AXIS + ROW * len(shown)}


def _relative_error(found: Mapping[str, Any], i: int, k: int) -> float | None:
    """Return the standard error of a relative derivative."""
    result, key = (list(found[group].values())[at]["value"] for group, at in (("qoi", i), ("keys", k)))
    error = found["standard_errors"][i][k]
    return None if error is None or key is None else math.fabs(error * key / result)


def _table(found: Mapping[str, Any]) -> str:
    keys = list(found["keys"].items())
    errors = found["standard_errors"]
    rows = []
    for i, (result, about) in enumerate(found["qoi"].items()):
        for k in _order(found["relative"][i]):
            name, key = keys[k]
            unit = "" if key["unit"] == "1" else escape(key["unit"])
            own = quotient(about["unit"], key["unit"])
            row = [f"<code>{escape(result)}</code>", f"<code>{escape(name)}</code>", page.number(key["value"]), unit,
                   page.number(found["derivatives"][i][k]), "" if own == "1" else escape(own),
                   page.number(found["relative"][i][k])]  # fmt: skip
            rows.append(row if errors is None else [*row, page.number(errors[i][k])])
    head = ["result", "key", "value", "unit", "derivative", "unit of derivative", "relative"]
    return page.table(head if errors is None else [*head, "standard error"], rows, (2, 4, 6, 7))
