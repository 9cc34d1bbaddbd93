"""The verification table: exact solutions, with the largest error that a committed table of a study holds."""

from __future__ import annotations

import csv
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markdown_text import code, page, table

ROOT = Path(__file__).parents[2]
ABOUT = (
    "What each model is compared with where the answer is known: closed forms, integrals, characteristics, or another "
    "method for the same equations. The errors are the largest in the committed table of the study, which its command "
    "computes anew. Of relative quantities they are relative, of dimensionless ones absolute."
)


@dataclass(frozen=True)
class Case:
    """A row of the table: its texts, the largest error that was found, the allowed one and why."""

    model: str
    against: str
    quantity: str
    study: str
    error: float
    allowed: float
    reason: str


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
    pairs = [(row[name], reference[name]) for row in others for name in reference if name != entry["rows"]]
    return [_difference(float(first), float(second)) for first, second in pairs]


def cases(studies: Path = ROOT / "studies") -> list[Case]:
    """Return the rows of docs/verification.toml with the numbers of the studies' tables.

    Raises
    ------
    ValueError : an entry finds no number
    """
    found = []
    for entry in tomllib.loads((ROOT / "docs" / "verification.toml").read_text(encoding="utf-8"))["case"]:
        file = studies / entry["study"] / entry.get("file", "results.csv")
        with file.open(encoding="utf-8", newline="") as stream:
            wanted = entry.get("where", {})
            rows = [row for row in csv.DictReader(stream) if all(row[key] == wanted[key] for key in wanted)]
        errors = _errors(rows, entry) if rows else []
        if not errors:
            raise ValueError(f"docs/verification.toml: {entry['against']!r} finds no number in {file}")
        if not all(math.isfinite(error) for error in errors):  # max() passes over a NaN that is not the first
            raise ValueError(f"docs/verification.toml: {entry['against']!r} finds an infinite number or NaN in {file}")
        texts = (entry[name] for name in ("model", "against", "quantity", "study"))
        found.append(Case(*texts, max(errors), entry["allowed"], entry["reason"]))
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
            f"[{case.study}](../gallery/{case.study}.md)",
            code(f"python -m studies run {case.study}"),
        ]
        for case in cases()
    ]
    head = ["model", "exact solution", "quantity", "largest error", "allowed", "study", "command"]
    page(file, "Compared with exact solutions", ABOUT, table(head, rows))
