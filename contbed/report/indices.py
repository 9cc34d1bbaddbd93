"""What the report of a sweep says of the uncertainty of its results: spreads by each estimator, and indices."""

from __future__ import annotations

import json
from html import escape
from pathlib import Path
from typing import Any

from contbed.report import page

FILE = "uncertainty.json"
SPREAD = ("estimator", "runs", "mean", "mean_error", "deviation", "low", "high")
HEADS = ("estimator", "runs", "mean", "standard error of the mean", "standard deviation", "5 %", "95 %")


def uncertainty(folder: Path) -> str:
    """Return the tables of spreads and of indices; nothing where the sweep has none."""
    try:
        found = json.loads((folder / FILE).read_text(encoding="utf-8"))["results"]
    except (OSError, ValueError, KeyError):
        return ""
    spreads = [
        [escape(name), escape(about["unit"] or ""), *(page.number(each[key]) for key in SPREAD)]
        for name, about in found.items()
        for each in about["spreads"]
    ]
    text = page.table(["result", "unit", *HEADS], spreads, range(3, 9))
    rows, heads = _indices(found)
    return text + (page.table(["result", "parameter", *heads], rows, range(2, 2 + len(heads))) if rows else "")


def _indices(found: dict[str, Any]) -> tuple[list[list[str]], list[str]]:
    """Return a row for each result and parameter, and the heads of its numbers."""
    columns: dict[tuple[str, str], dict[str, float]] = {}
    for name, about in found.items():
        tables = {"share by gradients": about["shares by gradients"], **(about["indices"] or {})}
        for head, values in tables.items():
            if isinstance(values, dict):
                for parameter, value in values.items():
                    columns.setdefault((name, parameter), {})[head] = value
    heads = list(dict.fromkeys(head for values in columns.values() for head in values))
    return [
        [escape(name), escape(parameter), *(page.number(values.get(head)) for head in heads)]
        for (name, parameter), values in columns.items()
    ], heads
