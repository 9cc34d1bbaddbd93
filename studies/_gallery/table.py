"""Tables of a study: text as it stands in a CSV file, numbers on demand."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Tables = dict[str, "Table"]


class Table:
    """A table with one header line.

    Parameters
    ----------
    columns : header, `name [unit]`, -> format of its numbers, such as ".6g"
    rows : one value for each column; texts stay as they are, None is an empty cell

    Raises
    ------
    ValueError : a row has another length than the columns
    """

    def __init__(self, columns: Mapping[str, str], rows: Iterable[Sequence[Any]] = ()):
        self.columns = tuple(columns)
        formats = tuple(columns.values())
        self.rows = [
            tuple(_text(value, form) for value, form in zip(row, formats, strict=True))
            for row in rows
        ]

    @classmethod
    def of(cls, records: Sequence[Mapping[str, Any]], form: str = "") -> Table:
        """Table of dictionaries, with columns in the order in which they first
        occur.
        """
        names = tuple(dict.fromkeys(name for record in records for name in record))
        return cls(
            dict.fromkeys(names, form),
            [[record.get(name) for name in names] for record in records],
        )

    @classmethod
    def from_columns(
        cls, columns: Mapping[str, Sequence[Any] | NDArray[Any]], form: str = ".6g"
    ) -> Table:
        """Table of columns of equal length."""
        return cls(dict.fromkeys(columns, form), zip(*columns.values(), strict=True))

    @classmethod
    def read(cls, path: Path) -> Table:
        """Read a CSV file with one header line."""
        with open(path, newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        return cls(dict.fromkeys(header, ""), rows)

    def write(self, path: Path) -> None:
        """Write as CSV."""
        path.write_text(str(self), encoding="utf-8")

    def __str__(self) -> str:
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows([self.columns, *self.rows])
        return out.getvalue()

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, str]]:
        return (dict(zip(self.columns, row, strict=True)) for row in self.rows)

    def __getitem__(self, column: str) -> NDArray[Any]:
        """A column: numbers, nan where a cell is empty, or texts where one of them
        is not a number.
        """
        i = self.columns.index(column)
        values = [row[i] for row in self.rows]
        try:
            return np.array([float(value) if value else math.nan for value in values])
        except ValueError:
            return np.array(values)

    def where(self, chosen: Mapping[str, Any]) -> Table:
        """The rows whose columns have these values; numbers are compared as numbers."""
        places = {self.columns.index(name): value for name, value in chosen.items()}
        rows = [
            row
            for row in self.rows
            if all(_same(row[i], value) for i, value in places.items())
        ]
        return Table(dict.fromkeys(self.columns, ""), rows)

    def values(self, column: str) -> list[str]:
        """Texts of a column without repetition, in the order of the rows."""
        i = self.columns.index(column)
        return list(dict.fromkeys(row[i] for row in self.rows))

    def row(self, name: str) -> dict[str, float]:
        """Numbers of the first row whose first cell is `name`, by column."""
        found = next(row for row in self.rows if row[0] == name)
        return {
            column: float(value)
            for column, value in zip(self.columns[1:], found[1:], strict=True)
            if value
        }

    def updated(self, new: Table, by: Sequence[str]) -> Table:
        """This table with the rows of `new` in place of those with equal values in the
        columns `by`, or at its end.

        A new table with other columns takes its place.
        """
        if new.columns != self.columns:
            return new
        keys = [self.columns.index(name) for name in by]
        fresh: dict[tuple[str, ...], list[Any]] = {}
        for row in new.rows:
            fresh.setdefault(tuple(row[i] for i in keys), []).append(row)
        rows: list[Any] = []
        left = dict(fresh)
        for row in self.rows:
            key = tuple(row[i] for i in keys)
            rows += left.pop(key, []) if key in fresh else [row]
        return Table(
            dict.fromkeys(self.columns, ""),
            [*rows, *(row for group in left.values() for row in group)],
        )

    def markdown(self) -> str:
        """As a table of a README."""
        rule = ("---",) * len(self.columns)
        return "\n".join(
            f"| {' | '.join(row)} |" for row in (self.columns, rule, *self.rows)
        )

    def differences(
        self, other: Table, tolerance: float, skip: Sequence[str] = ()
    ) -> list[str]:
        """What differs from another table beyond a relative tolerance and the last
        digit that is written.

        Numbers below the tolerance are compared to its square; columns and rows named
        in `skip` are not compared.
        """
        if self.columns != other.columns or len(self) != len(other):
            return [
                f"{len(self)} rows of {self.columns}, expected {len(other)} of "
                f"{other.columns}"
            ]
        out = []
        for number, (mine, theirs) in enumerate(
            zip(self.rows, other.rows, strict=True), start=2
        ):
            for column, a, b in zip(self.columns, mine, theirs, strict=True):
                if (
                    column not in skip
                    and mine[0] not in skip
                    and not _close(a, b, tolerance)
                ):
                    out.append(f"line {number}, {column}: {a}, committed {b}")
        return out


def updated(folder: Path, new: Tables, by: Mapping[str, Sequence[str]]) -> Tables:
    """The new tables; those that `by` names as kept in the folder, see
    `Table.updated`, with the new rows.
    """
    return {
        name: Table.read(folder / f"{name}.csv").updated(table, by[name])
        if name in by
        else table
        for name, table in new.items()
    }


def _text(value: Any, form: str) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    if isinstance(value, bool | np.bool_):
        return str(bool(value))
    return format(value, form)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _same(text: str, value: Any) -> bool:
    if isinstance(value, str):
        return text == value
    number = _number(text)
    return number is not None and math.isclose(number, float(value), rel_tol=1e-9)


def _last_digit(text: str) -> float:
    """One unit of the last digit of a number, "1.20e-5" -> 1e-7."""
    mantissa, _, exponent = text.lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - digits)


def _close(a: str, b: str, tolerance: float) -> bool:
    x, y = _number(a), _number(b)
    if x is None or y is None:
        return a == b
    if math.isnan(x) and math.isnan(y):
        return True
    allowed = tolerance * max(abs(x), abs(y), tolerance) + max(
        _last_digit(a), _last_digit(b)
    ) * (1 + 1e-9)
    return abs(x - y) <= allowed
