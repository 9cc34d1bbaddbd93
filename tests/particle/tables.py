"""Tables of exact values in tests/data: comment lines begin with #, then names, then
numbers or words.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from contbed.chemistry.effectiveness import effectiveness_of

DATA = Path(__file__).parent.parent / "data"


def rows(name: str) -> list[dict[str, float | str]]:
    """Return the rows of a table by column; what is no number stays text."""

    def value(text: str) -> float | str:
        try:
            return float(text)
        except ValueError:
            return text

    with open(DATA / name, encoding="utf-8") as lines:
        found = csv.DictReader(line for line in lines if not line.startswith("#"))
        return [{key: value(text) for key, text in row.items()} for row in found]


def sphere(phi: Any) -> Any:
    """Return the effectiveness of a sphere by its Thiele modulus."""
    return effectiveness_of(1.0, phi * phi, 1.0)


def overall(eta: Any, phi: Any, biot: Any) -> Any:
    """Return the effectiveness over the rate at the state of the gas, with a film in
    series around a sphere.
    """
    return eta / (1.0 + eta * phi * phi / (3.0 * biot))
