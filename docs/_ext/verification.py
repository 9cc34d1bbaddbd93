"""The verification table: exact solutions, with the largest error and the order that
tables of studies hold.
"""

from __future__ import annotations

import csv
import math
import statistics
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markdown_text import code, page, table

ROOT = Path(__file__).parents[2]
ABOUT = (
    "What each model is compared with where the answer is known: closed forms, "
    "integrals, characteristics, or another "
    "method for the same equations. The errors are the largest in the committed table "
    "of the study, which its command "
    "computes anew. Of relative quantities they are relative, of dimensionless ones "
    "absolute. The observed order p is "
    "the slope of the logarithm of the errors, e ~ n^-p for n cells or e ~ tol^p for a "
    "tolerance, by least squares "
    "over all meshes of a series; of more than three series the lowest and the highest."
)


@dataclass(frozen=True)
class Case:
    """A row of the table: its texts, the largest error that was found, the allowed one
    and why, the observed order.

    Without a table of several meshes `order` is the reason.
    """

    model: str
    against: str
    quantity: str
    study: str
    error: float
    allowed: float
    reason: str
    order: str


def _difference(first: float, second: float) -> float:
    return abs(first - second) / max(abs(first), abs(second), 1e-300)


def _errors(rows: list[dict[str, str]], entry: dict[str, Any]) -> list[float]:
    """Return the sizes of all errors that an entry names in rows of a table.

    Raises
    ------
    ValueError : a cell that should be a number is none
    KeyError : a column is missing
    """
    if "errors" in entry:
        return [abs(float(row[name])) for row in rows for name in entry["errors"]]
    if "pair" in entry:
        first, second = entry["pair"]
        return [_difference(float(row[first]), float(row[second])) for row in rows]
    reference, *others = rows
    pairs = [
        (row[name], reference[name])
        for row in others
        for name in reference
        if name != entry["rows"]
    ]
    return [_difference(float(first), float(second)) for first, second in pairs]


def orders(rows: list[dict[str, str]], entry: dict[str, Any]) -> list[float]:
    """Return the slope of the logarithm of the errors over that of `over`, for each
    series and kind of error.

    Parameters
    ----------
    rows : of a table of convergence
    entry : `over`, the column of cells or tolerances; `errors`, columns; `series`, the
        columns that distinguish series, none if absent; `least`, below which errors are
        left out, as rounding or printed digits of the exact solution make them;
        `tolerance`, true where errors fall with `over`

    Raises
    ------
    ValueError : a series has errors of fewer than three meshes
    """
    series: dict[tuple[str, ...], list[dict[str, str]]] = {}
    for row in rows:
        series.setdefault(
            tuple(row[name] for name in entry.get("series", [])), []
        ).append(row)
    found = []
    for name, of in series.items():
        for error in entry["errors"]:
            points = [(float(row[entry["over"]]), abs(float(row[error]))) for row in of]
            kept = [
                (math.log(n), math.log(e))
                for n, e in points
                if e >= entry.get("least", 1e-300)
            ]
            if len({n for n, _ in kept}) < 3:
                raise ValueError(
                    "docs/verification.toml: fewer than three meshes for the order of "
                    f"{error!r} in {name}"
                )
            slope = statistics.linear_regression(*zip(*kept, strict=True)).slope
            found.append(slope if entry.get("tolerance") else -slope)
    return found


def _order(studies: Path, entry: dict[str, Any]) -> str:
    """Return the observed order as text, or the reason why there is none."""
    if "order" not in entry:
        return str(entry["no_order"])
    about = entry["order"]
    found = orders(_rows(studies, entry | about), about)
    few = len(found) <= 3
    shown = (
        ", ".join(f"{p:.1f}" for p in found)
        if few
        else f"{min(found):.1f} to {max(found):.1f}"
    )
    with_what = (
        "with the tolerance" if about.get("tolerance") else f"with {about['over']}"
    )
    return f"{shown} {with_what}; expected {about['expected']}"


def _rows(studies: Path, entry: dict[str, Any]) -> list[dict[str, str]]:
    """Return the rows of the table of an entry that have the values `where`."""
    with (studies / entry["study"] / entry.get("file", "results.csv")).open(
        encoding="utf-8", newline=""
    ) as stream:
        wanted = entry.get("where", {})
        return [
            row
            for row in csv.DictReader(stream)
            if all(row[key] == wanted[key] for key in wanted)
        ]


def cases(studies: Path = ROOT / "studies") -> list[Case]:
    """Return the rows of docs/verification.toml with the numbers of the studies'
    tables.

    Raises
    ------
    ValueError : an entry finds no number
    """
    found = []
    for entry in tomllib.loads(
        (ROOT / "docs" / "verification.toml").read_text(encoding="utf-8")
    )["case"]:
        file = studies / entry["study"] / entry.get("file", "results.csv")
        rows = _rows(studies, entry)
        errors = _errors(rows, entry) if rows else []
        if not errors:
            raise ValueError(
                f"docs/verification.toml: {entry['against']!r} finds no number in "
                f"{file}"
            )
        # max() passes over a NaN that is not the first
        if not all(math.isfinite(error) for error in errors):
            raise ValueError(
                f"docs/verification.toml: {entry['against']!r} finds an infinite "
                f"number or NaN in {file}"
            )
        texts = (entry[name] for name in ("model", "against", "quantity", "study"))
        found.append(
            Case(
                *texts,
                max(errors),
                entry["allowed"],
                entry["reason"],
                _order(studies, entry),
            )
        )
    return found


def write_page(file: Path) -> None:
    """Write the page of the table."""
    rows = [
        [
            case.model,
            case.against,
            case.quantity,
            f"{case.error:.1e}" if case.error else "0 in all printed digits",
            f"{case.allowed:g}: {case.reason}",
            case.order,
            f"[{case.study}](../gallery/{case.study}.md)",
            code(f"python -m studies run {case.study}"),
        ]
        for case in cases()
    ]
    head = [
        "model",
        "exact solution",
        "quantity",
        "largest error",
        "allowed",
        "observed order",
        "study",
        "command",
    ]
    page(file, "Compared with exact solutions", ABOUT, table(head, rows))
