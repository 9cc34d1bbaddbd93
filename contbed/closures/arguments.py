"""Arguments and results of closures: symbol, unit and meaning, each stated once.

A data sheet takes its rows from `arguments.csv` beside this file; a row with a kind is
what the argument means in the closures of that kind alone. `kinds.csv` says what the
closures of a kind return. Constants of a single law,
and an argument that means something special in one law, stand in the docstring of that
closure.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple


class Argument(NamedTuple):
    """Unit and meaning of an argument, and the values that a scene may give it."""

    unit: str
    meaning: str
    bounds: str


def _rows(table: str) -> Iterator[list[str]]:
    """Yield the rows of a table beside this file."""
    text = Path(__file__).with_name(table).read_text(encoding="utf-8")
    yield from list(csv.reader(text.splitlines()))[1:]


_OF_KIND = {
    (name, kind): Argument(unit, meaning, bounds)
    for name, kind, unit, bounds, meaning in _rows("arguments.csv")
}

ARGUMENTS = {name: found for (name, kind), found in _OF_KIND.items() if not kind}
"""Unit and meaning of an argument in every kind of closure."""

_KINDS = list(_rows("kinds.csv"))

UNITS = {kind: unit for kind, unit, _ in _KINDS if unit}
"""Unit of what the closures of a kind return; a kind of several units has none."""

RESULTS = {kind: result for kind, _, result in _KINDS if result}
"""What the closures of a kind return."""


def argument(name: str, kind: str) -> Argument | None:
    """Return unit and meaning of an argument in a closure of a kind, None where only
    the closure itself can say it.
    """
    return _OF_KIND.get((name, kind)) or ARGUMENTS.get(name)
