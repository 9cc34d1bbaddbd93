"""Tables as CSV: one header line `name [unit]`, 12 significant digits."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from contbed.arrays import Array, Integers
from contbed.errors import ContbedError
from contbed.fields import name_of
from contbed.output.files import atomic

COORDINATES = ("x", "y", "z", "r", "height", "frequency")
REMEDY = "run the command that wrote it again"


def write_table(path: Path | str, columns: Mapping[str, ArrayLike]) -> None:
    """Write columns of equal length under their headers."""
    data = [np.asarray(column, dtype=float) for column in columns.values()]
    shapes = {
        header: column.shape for header, column in zip(columns, data, strict=True)
    }
    if not data or data[0].ndim != 1 or len(set(shapes.values())) > 1:
        raise ValueError(f"{path}: a table needs columns of one length, found {shapes}")
    with (
        atomic(path) as temporary,
        open(temporary, "w", encoding="utf-8", newline="") as file,
    ):
        csv.writer(file, lineterminator="\n").writerow(columns)
        np.savetxt(file, np.column_stack(data), fmt="%.12g", delimiter=",")


def read_cells(path: Path | str) -> tuple[list[str], list[list[str]]]:
    """Read the headers of a table, and its rows as texts.

    Raises
    ------
    ContbedError : the file cannot be read, has no header or the same one twice, or rows
        that do not fit it
    """
    try:
        with open(path, encoding="utf-8", newline="") as file:
            headers, *rows = [*csv.reader(file)] or [[]]
    except OSError as error:
        raise ContbedError(f"cannot read {path}: {error.strerror}; {REMEDY}") from error
    except (ValueError, csv.Error) as error:
        raise _damaged(path, str(error)) from error
    if not headers or len(set(headers)) != len(headers):
        raise _damaged(path, "it has no header, or the same one twice")
    for line, row in enumerate(rows, start=2):
        if len(row) != len(headers):
            raise _damaged(
                f"{path}:{line}", f"{len(row)} values under {len(headers)} headers"
            )
    return headers, rows


def read_table(path: Path | str) -> dict[str, Array]:
    """Read the columns of a table of numbers by header.

    Raises
    ------
    ContbedError : the file cannot be read or is not a table of numbers
    """
    headers, rows = read_cells(path)
    data = np.empty((len(rows), len(headers)))
    for line, (row, values) in enumerate(zip(rows, data, strict=True), start=2):
        try:
            values[:] = [float(item) for item in row]
        except ValueError:
            header, item = next(
                pair
                for pair in zip(headers, row, strict=True)
                if not is_number(pair[1])
            )
            raise _damaged(
                f"{path}:{line}", f"{header} is {item!r}, which is no number"
            ) from None
    return dict(zip(headers, data.T.copy(), strict=True))


def axis_of(
    tables: Sequence[Mapping[str, ArrayLike]],
) -> tuple[str | None, str | None]:
    """Return the header of the column along the axis of tables that are alike, and
    that of the time where each time has several rows.
    """
    names = {name_of(header): header for columns in tables for header in columns}
    time = names.get("t")
    once = all(
        len(np.unique(columns[time])) == np.size(columns[time])
        for columns in tables
        if time is not None and time in columns
    )
    place = next((names[name] for name in COORDINATES if name in names), None)
    if place is None or (time is not None and once):
        return time or next(iter(names.values()), None), None
    return place, time


def evenly(count: int, most: int) -> Integers:
    """Return the numbers of at most `most` of `count` items, evenly among all, both
    ends included.
    """
    numbers = np.linspace(0, count - 1, min(count, most)).round()
    return np.unique(numbers.astype(np.int64))


def is_number(cell: str) -> bool:
    """Return whether a cell of a table is a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _damaged(place: Path | str, why: str) -> ContbedError:
    return ContbedError(f"{place}: not a table with one header line: {why}; {REMEDY}")
