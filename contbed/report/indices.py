"""What the report of a sweep says of the uncertainty of its results: spreads by each
estimator, and indices.
"""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from pydantic import Field

from contbed.output.shapes import Number, Shape, read_json
from contbed.report import page

FILE = "uncertainty.json"
SPREAD = ("estimator", "runs", "mean", "mean_error", "deviation", "low", "high")
HEADS = (
    "estimator",
    "runs",
    "mean",
    "standard error of the mean",
    "standard deviation",
    "5 %",
    "95 %",
)


class Spread(Shape):
    """Mean, deviation and band of a result by one estimator."""

    estimator: str
    runs: int
    mean: Number
    mean_error: Number
    deviation: Number
    low: Number
    high: Number


class OfResult(Shape):
    """What is known of one result."""

    unit: str | None
    spreads: list[Spread]
    shares: dict[str, Number] | None = Field(alias="shares by gradients")
    indices: dict[str, Any] | None


class UncertaintyFile(Shape):
    """uncertainty.json of a sweep."""

    results: dict[str, OfResult]


def uncertainty(folder: Path) -> str:
    """Return the tables of spreads and of indices; nothing where the sweep has none.

    Raises
    ------
    ContbedError : the file is damaged
    """
    if not (folder / FILE).is_file():
        return ""
    found = read_json(
        folder / FILE,
        UncertaintyFile,
        "the uncertainty of a sweep",
        "run the sweep again",
    )["results"]
    spreads = [
        [
            escape(name),
            escape(about["unit"] or ""),
            *(page.number(each[key]) for key in SPREAD),
        ]
        for name, about in found.items()
        for each in about["spreads"]
    ]
    text = page.table(["result", "unit", *HEADS], spreads, range(3, 9))
    rows, heads = _indices(found)
    return text + (
        page.table(["result", "parameter", *heads], rows, range(2, 2 + len(heads)))
        if rows
        else ""
    )


def _indices(found: dict[str, Any]) -> tuple[list[list[str]], list[str]]:
    """Return a row for each result and parameter, and the heads of its numbers."""
    columns: dict[tuple[str, str], dict[str, float]] = {}
    for name, about in found.items():
        tables = {
            "share by gradients": about["shares by gradients"],
            **(about["indices"] or {}),
        }
        for head, values in tables.items():
            if isinstance(values, dict):
                for parameter, value in values.items():
                    columns.setdefault((name, parameter), {})[head] = value
    heads = list(dict.fromkeys(head for values in columns.values() for head in values))
    return [
        [
            escape(name),
            escape(parameter),
            *(page.number(values.get(head)) for head in heads),
        ]
        for (name, parameter), values in columns.items()
    ], heads
