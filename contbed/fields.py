"""Every quantity that a run writes: fields, columns of tables, and named results, each
with unit and meaning.

Output, plots, sweeps and the manual read names, symbols and units here and nowhere
else. A part in capitals is chosen by the scene: NAME is a boundary, a solid phase, a
gas or a surface; PHASE is fluid, solid, emulsion or bubble. Headers of columns are
"name [unit]", "T_fluid [K]"; a dimensionless quantity has the unit 1.

Their rows stand in `fields.csv` and `results.csv` beside this file.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path


@dataclass(frozen=True)
class Field:
    """One quantity in SI. `symbol` is mathtext; `lower` is an open bound; unit "1"
    is dimensionless.
    """

    name: str
    symbol: str
    unit: str
    description: str
    lower: float

    @property
    def header(self) -> str:
        """Column header, "T_fluid [K]"."""
        return f"{self.name} [{self.unit}]"

    @property
    def label(self) -> str:
        """Axis label with symbol and unit; a dimensionless quantity shows none."""
        return labelled(f"${self.symbol}$", self.unit)


def _read(table: str) -> dict[str, Field]:
    """Return the rows of a table beside this file by their names."""
    text = Path(__file__).with_name(table).read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    found = {}
    for name, symbol, unit, lower, description in list(csv.reader(lines))[1:]:
        bound = float(lower or "-inf")
        found[name] = Field(name, symbol, unit, description, bound)
    return found


CHOSEN = re.compile("NAME|PHASE|PLACE")  # parts of names that the scene chooses
# coordinates and fields, in profiles, tables and field files
FIELDS = _read("fields.csv")
# named results, the keys of `qoi`; most end with their unit
RESULTS = _read("results.csv")


def field(name: str) -> Field | None:
    """Find the field of a column by its name without unit; None if there is none.

    "T_sand" is found by "T_NAME" and has its own symbol, "wall p" of a probe by "p".
    """
    return _find(name.rpartition(" ")[2], "fields")


def result(key: str) -> Field | None:
    """Find the entry of a named result by its key, "heat_left_W" by "heat_NAME_W";
    None if there is none.
    """
    return _find(key, "results")


def header(name: str) -> str:
    """Return the column header of a field: `header("T_fluid")` is "T_fluid [K]"."""
    return f"{name} [{require(name).unit}]"


def require(name: str) -> Field:
    """Return the field of a column that is known to have one.

    Raises
    ------
    KeyError : it has none
    """
    found = field(name)
    if found is None:
        raise KeyError(name)
    return found


def name_of(header: str) -> str:
    """Return the name in a column header; the inverse of `header`."""
    return header.split(" [")[0]


def behind(unit: str | None) -> str:
    """Return a unit as it stands behind a number; nothing for a plain number."""
    return "" if unit in (None, "", "1", "-") else f" {unit}"


def labelled(name: str, unit: str | None) -> str:
    """Return a name with its unit in brackets, "T [K]", where it has one."""
    return f"{name} [{unit}]" if behind(unit) else name


def unit_in(header: str) -> str:
    """Return the unit in a column header; empty where it has none."""
    return header.partition(" [")[2].removesuffix("]")


def unit_of(name: str) -> str | None:
    """Return the unit of a field or a named result ("u_gas_centre" is in m/s); None
    if the name is not known.
    """
    found = result(name) or field(name_of(name))
    return found.unit if found else None


@cache
def _find(name: str, table: str) -> Field | None:
    known = {"fields": FIELDS, "results": RESULTS}[table]
    if name in known:
        return known[name]
    for pattern, entry in _patterns(table):
        found = pattern.fullmatch(name)
        if found is not None:
            return _with_symbol(entry, found.groups())
    return None


def _with_symbol(entry: Field, chosen: tuple[str, ...]) -> Field:
    """Return an entry whose symbol has the parts that a scene chose."""
    parts = [part.replace("_", r"\_") for part in chosen]
    symbol = CHOSEN.sub(lambda _: parts.pop(0), entry.symbol)
    return replace(entry, symbol=symbol)


@cache
def _patterns(table: str) -> list[tuple[re.Pattern[str], Field]]:
    """Return names with a part in capitals as patterns, the longest (most specific)
    first.
    """
    entries: Iterable[Field] = {"fields": FIELDS, "results": RESULTS}[table].values()
    chosen = [entry for entry in entries if CHOSEN.search(entry.name)]
    chosen.sort(key=lambda entry: -len(entry.name))
    parts = ((CHOSEN.split(entry.name), entry) for entry in chosen)
    return [
        (re.compile("(.+)".join(map(re.escape, part))), entry) for part, entry in parts
    ]


def span(ends: Iterable[float | None], style: str = ".3g") -> str:
    """Return a range in words; None is no bound.

    >>> span((1.0, None)), span((0.5, 2.0)), span((2.0, 2.0))
    ('at least 1', '0.5 to 2', '2')
    """
    low, high = ends
    if low is None or high is None:
        bounds = (("at least", low), ("at most", high))
        words = [f"{word} {end:{style}}" for word, end in bounds if end is not None]
        return words[0] if words else "any"
    return f"{low:{style}}" if low == high else f"{low:{style}} to {high:{style}}"


def distinct(found: float, allowed: float) -> tuple[str, str]:
    """Return two numbers with two digits, or as many as show which is larger.

    >>> distinct(1.3e-5, 1e-5), distinct(1.0004e-5, 1e-5)
    (('1.3e-05', '1e-05'), ('1.0004e-05', '1e-05'))
    """
    pairs = ((f"{found:.{n}g}", f"{allowed:.{n}g}") for n in range(2, 18))
    unlike = (pair for pair in pairs if pair[0] != pair[1])
    return next(unlike, (f"{found:g}", f"{allowed:g}"))
