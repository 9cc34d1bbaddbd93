"""The data sheet of a closure, put together from its decorator, its docstring and
`arguments`.

The docstring holds what only the closure itself can say:

    Author (year): what it is for.

        the equation

    name : [unit] a constant of this law, or an argument that means something special in
        it

    Result: what it returns, where this differs from others of its kind
    Fitted to: the data behind it
    Limits: its values at the ends
    Source: remarks on the source, which stands in the decorator

    an example that doctest runs
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from contbed.closures.arguments import RESULTS, argument

_ROW = re.compile(r"(\w+) : (\[.+?\].*)")
_KEY = re.compile(r"(Result|Fitted to|Limits|Source): (.*)")


class Interval(NamedTuple):
    """Values that a parameter may have; written "[0, 1)", where a round bracket
    leaves the bound out.
    """

    text: str
    low: float
    high: float
    closed: tuple[bool, bool]

    @classmethod
    def read(cls, text: str) -> Interval:
        """Return the interval written as `text`; ValueError if it is none."""
        found = re.fullmatch(r"([\[(])(\S+), (\S+)([\])])", text)
        if found is None or not float(found[2]) < float(found[3]):
            raise ValueError(f"{text!r} is no interval such as '[0, 1)'")
        return cls(
            text, float(found[2]), float(found[3]), (found[1] == "[", found[4] == "]")
        )

    def __contains__(self, value: object) -> bool:
        assert isinstance(value, (int, float))
        above = value >= self.low if self.closed[0] else value > self.low
        return above and (value <= self.high if self.closed[1] else value < self.high)


@dataclass(frozen=True)
class Sheet:
    """The data sheet of one closure. `options` are the arguments that have a
    default.
    """

    name: str
    kind: str
    unit: str
    arguments: tuple[str, ...]
    options: Mapping[str, Any]
    ranges: Mapping[str, tuple[float, float]]
    source: str
    summary: str
    equation: str
    text: str
    bounds: Mapping[str, Interval]


class Docstring(NamedTuple):
    """The parts of a closure's docstring."""

    summary: str
    equation: str
    rows: dict[str, list[str]]
    sections: dict[str, list[str]]
    example: list[str]

    @classmethod
    def read(cls, text: str) -> Docstring:
        """Take a docstring, without its indentation, apart."""
        first, _, rest = text.partition("\n\n")
        summary = " ".join(first.split())
        equation: list[str] = []
        rows: dict[str, list[str]] = {}
        sections: dict[str, list[str]] = {}
        example: list[str] = []
        part = equation
        for line in rest.splitlines():
            if line.startswith(">>> "):
                part = example
            if part is not example:
                if row := _ROW.fullmatch(line):
                    part = rows[row[1]] = [line]
                    continue
                if key := _KEY.fullmatch(line):
                    part = sections[key[1]] = [key[2]]
                    continue
                if not line.strip() and part is not equation:
                    continue
            part.append(
                line.strip() if part is not equation and part is not example else line
            )
        return cls(
            summary, "\n".join(equation).strip("\n").rstrip(), rows, sections, example
        )


def assembled(
    doc: Docstring,
    kind: str,
    unit: str,
    parameters: tuple[str, ...],
    ranges: Mapping[str, tuple[float, float]],
    bounds: Mapping[str, Interval],
    source: str,
) -> str:
    """Return the text of a data sheet, a docstring in numpy's convention."""
    rows = [
        line for name in parameters for line in doc.rows.get(name) or _row(name, kind)
    ]
    result = doc.sections.get("Result") or [RESULTS.get(kind, kind.replace("_", " "))]
    sections = {
        "Parameters": rows,
        "Returns": [f"[{unit}] {result[0]}", *result[1:]],
        "Range": [
            f"{key} : {_number(low)} to {_number(high)}"
            for key, (low, high) in ranges.items()
        ],
        "Bounds": [f"{key} : {interval.text}" for key, interval in bounds.items()],
        "Fitted to": doc.sections.get("Fitted to", []),
        "Limits": doc.sections.get("Limits", []),
        "Example": doc.example,
        "Source": [f"{source}.", *doc.sections.get("Source", [])],
    }
    head = [doc.summary, "", doc.equation] if doc.equation else [doc.summary]
    body = [
        line
        for title, lines in sections.items()
        if lines
        for line in ("", title, "-" * len(title), *lines)
    ]
    return "\n".join([*head, *body])


def _row(name: str, kind: str) -> list[str]:
    known = argument(name, kind)
    return [] if known is None else [f"{name} : [{known.unit}] {known.meaning}"]


def _number(value: float) -> str:
    """As short as it is exact: 8500, 1e5, 0.35."""
    if value and math.isfinite(value):
        power = math.floor(math.log10(abs(value)))
        if not -4 < power < 4 or (power == 4 and value % 1e4 == 0):
            return f"{value / 10.0**power:.10g}e{power}"
    return f"{value:.10g}"
