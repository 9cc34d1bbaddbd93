"""Tables of numbers in CSV files, each column with its unit in the header: measured
data, schedules, profiles.

    # lines that begin with # are comments
    t [h],T_inlet [degC]
    0,396
    0.5,390.5

Mistakes are reported with file, line and column.
"""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from contbed.errors import SceneError
from contbed.scene.names import nearest
from contbed.scene.stamp import Stamp, stamp_of
from contbed.scene.units import QUANTITIES, factor_and_offset

OTHER_MARKS = {
    ";": "semicolons",
    "\t": "tabs",
}  # between columns, as spreadsheets write them where commas are in numbers
# of a file that may hold anything, nothing is quoted
_NO_DATA = "; no column has a unit"
_HEADER = re.compile(r"\s*(.+?)\s*\[(.+)\]\s*")


@dataclass(frozen=True)
class DataTable:
    """The columns of a CSV file.

    names, units : of the columns; "" is the unit of a column without brackets, whose
        cells are texts
    cells : texts, row by row; lines : line of each row in the file
    """

    path: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    header_line: int

    def name_in(self, unit: str) -> str:
        """Return the name of the first column whose unit measures the same as `unit`.

        Raises
        ------
        SceneError : there is none
        """
        for name, given in zip(self.names, self.units, strict=True):
            if given and factor_and_offset(given, unit) is not None:
                return name
        wanted = QUANTITIES.get(unit, "quantity")
        raise self.error(
            self.header_line,
            f"no column with a {wanted}, such as 'name [{unit}]'{self._found()}",
        )

    def column(self, name: str, unit: str, gaps: bool = False) -> NDArray[np.float64]:
        """Return the values of a column in the SI unit `unit`, shape (rows,); with
        `gaps` an empty cell is not a number.

        Raises
        ------
        SceneError : no such column, another kind of quantity, or a cell that is no
            finite number
        """
        index = self._place(name)
        scale = factor_and_offset(self.units[index] or "1", unit)
        if scale is None:
            found = (
                f"'{name} [{self.units[index]}]'"
                if self.units[index]
                else f"'{name}' without a unit"
            )
            raise self.error(
                self.header_line,
                f"expected a {QUANTITIES.get(unit, 'quantity')} in {unit}, found "
                f"{found}",
            )
        values = np.empty(len(self.cells))
        for row, (cells, line) in enumerate(zip(self.cells, self.lines, strict=True)):
            if gaps and not cells[index].strip():
                values[row] = np.nan
                continue
            try:
                values[row] = float(cells[index])
            except ValueError:
                raise self.error(
                    line,
                    f"column '{name}': expected a number, found '{cells[index][:40]}'",
                ) from None
            if not isfinite(values[row]):
                raise self.error(line, f"column '{name}': not a finite number")
        factor, offset = scale
        return values * factor + offset

    def texts(self, name: str) -> tuple[str, ...]:
        """Return the cells of a column as they are written."""
        index = self._place(name)
        return tuple(cells[index] for cells in self.cells)

    def optional(self, name: str | None, unit: str) -> NDArray[np.float64]:
        """Return the values of a column, not a number where it has no name."""
        if name is None:
            return np.full(len(self.cells), np.nan)
        return self.column(name, unit)

    def rows_with(self, texts: Mapping[str, str]) -> NDArray[np.bool_]:
        """Return which rows have these texts in the columns of these names, (rows,)."""
        found = np.ones(len(self.cells), dtype=bool)
        for name, text in texts.items():
            found &= np.array(self.texts(name)) == text
        return found

    def error(self, line: int, text: str) -> SceneError:
        """Return a mistake of this file at a line."""
        return SceneError(f"{self.path.name}:{line}: {text}")

    def _found(self) -> str:
        names = (
            f"'{name} [{unit}]'" if unit else f"'{name}'"
            for name, unit in zip(self.names, self.units, strict=True)
        )
        return f"; found {', '.join(names)}" if any(self.units) else _NO_DATA

    def _place(self, name: str) -> int:
        """Return the number of a column.

        Raises
        ------
        SceneError : there is none of this name
        """
        if name in self.names:
            return self.names.index(name)
        known = list(self.names)
        hint = f"; {nearest(name, known)}" if any(self.units) else _NO_DATA
        raise self.error(self.header_line, f"no column '{name}'{hint}")


def read_table(path: Path) -> DataTable:
    """Read a CSV file with one header line.

    Raises
    ------
    SceneError : the file cannot be read, is empty, or a line has too few or too many
        cells
    """
    try:
        stamp = stamp_of(path)
    except OSError:
        raise SceneError(f"no such file; looked for {path.absolute()}") from None
    return _read(path, stamp)


def decoded(data: bytes) -> str:
    """Return the text of a file in UTF-8, with or without a byte order mark, in UTF-16
    with one, or in Windows-1252, as spreadsheets write it.

    Raises
    ------
    UnicodeDecodeError : it is no text
    """
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in data:
            raise
        return data.decode("cp1252")


@lru_cache(maxsize=64)
def _read(path: Path, stamp: Stamp) -> DataTable:
    try:
        text = decoded(path.read_bytes())
    except OSError as error:
        raise SceneError(f"{path.name}: cannot be read: {error}") from None
    except UnicodeDecodeError:
        raise SceneError(
            f"{path.name}: not a text file; export a spreadsheet as CSV"
        ) from None
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    header_line, cells, lines = 0, [], []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            row = tuple(cell.strip() for cell in next(csv.reader([line])))
        except csv.Error as error:
            raise SceneError(
                f"{path.name}:{number}: no line of a table: {error}"
            ) from None
        if not header_line:
            if len(row) == 1 and (
                other := next((mark for mark in OTHER_MARKS if mark in line), "")
            ):
                advice = (
                    "commas between columns and points in numbers are read; "
                    "export the table so"
                )
                raise SceneError(
                    f"{path.name}:{number}: columns are separated by "
                    f"{OTHER_MARKS[other]}; {advice}"
                )
            parts = [_HEADER.fullmatch(cell) for cell in row]
            names = tuple(
                part[1] if part else cell for part, cell in zip(parts, row, strict=True)
            )
            units = tuple(part[2] if part else "" for part in parts)
            header_line = number
            if twice := [name for name in names if names.count(name) > 1]:
                raise SceneError(
                    f"{path.name}:{number}: column '{twice[0]}' is there twice"
                )
        elif len(row) != len(names):
            raise SceneError(
                f"{path.name}:{number}: {len(row)} cells, the header in line "
                f"{header_line} has {len(names)}"
            )
        else:
            cells.append(row)
            lines.append(number)
    if not cells:
        raise SceneError(
            f"{path.name}: a table needs a header line and at least one line of numbers"
        )
    return DataTable(path, names, units, tuple(cells), tuple(lines), header_line)
