"""Rows of a table along a bed, in the order of their positions, at one time of a file
that has several.

Mistakes are reported with file and line.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes, See
from contbed.scene.toml_lines import KeyPath

if TYPE_CHECKING:
    from contbed.scene.data_table import DataTable

# share of the length without values at an end, as between a wall and a thermocouple
MOST_BEYOND = 0.05
# share of the length by which positions in a file may lie outside of the bed, for their
# rounding
LENGTH_SLACK = 1e-6
# relative distance below which two times are the same: tables have 12 digits
SAME = 1e-9
MOST_TIMES = 6  # that a message lists


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of a table: `where` are their positions in increasing order [m], `index`
    their places in the table.
    """

    table: DataTable
    index: NDArray[np.intp]
    where: Array
    time: float | None  # [s] of a table with times

    @property
    def place(self) -> str:
        """Name of the column of positions."""
        return self.table.name_in("m")

    def column(self, name: str, unit: str) -> Array:
        """Return the values of a column in an SI unit.

        Raises
        ------
        SceneError : no such column, another kind of quantity, or a cell that is no
            finite number
        """
        found: Array = self.table.column(name, unit)[self.index]
        return found

    def error(self, row: int, text: str) -> SceneError:
        """Return a mistake in a row."""
        return self.table.error(self.table.lines[int(self.index[row])], text)


def rows_along(path: Path, time: float | None = None) -> Rows:
    """Return the rows of a file at a time [s]; None for the last if it has several.

    Raises
    ------
    SceneError : the file cannot be used, has no such time, or a position twice
    """
    from contbed.scene.data_table import read_table  # with it the conversion of units

    table = read_table(path)
    where, index = table.column(table.name_in("m"), "m"), np.arange(len(table.cells))
    if "t" in table.names:
        times = table.column("t", "s")
        time = float(times.max()) if time is None else _nearest(table, times, time)
        index = np.flatnonzero(times == time)
    elif time is not None:
        raise table.error(
            table.header_line,
            "no column of times, such as 't [s]'; remove the time of its rows",
        )
    index = index[np.argsort(where[index], kind="stable")]
    rows = Rows(table, index, where[index], time)
    if (twice := np.flatnonzero(np.diff(rows.where) == 0.0)).size:
        raise rows.error(
            int(twice[0]) + 1, f"the position {rows.where[twice[0]]:g} m is given twice"
        )
    return rows


def _nearest(table: DataTable, times: Array, time: float) -> float:
    found = float(times[np.abs(times - time).argmin()])
    if abs(found - time) <= SAME * abs(time):
        return found
    known = np.unique(times)
    shown = ", ".join(f"{t:g}" for t in known[:MOST_TIMES]) + (
        f" to {known[-1]:g}" if len(known) > MOST_TIMES else ""
    )
    raise table.error(
        table.header_line, f"no rows at t = {time:g} s; the file has t = {shown} s"
    )


def outside_of_the_bed(path: KeyPath, rows: Rows, length: float, see: See) -> Mistakes:
    """Check that the rows of a file lie within a bed."""
    first, last = rows.where[0], rows.where[-1]
    for row, x in ((0, first), (-1, last)):
        if not -LENGTH_SLACK * length <= x <= (1.0 + LENGTH_SLACK) * length:
            text = (
                f"positions from {first:g} to {last:g} m, the bed is {length:g} m "
                f"long; see {see('mesh.length')}"
            )
            yield path, str(rows.error(row, f"column '{rows.place}': {text}"))
            return


def short_of_an_end(
    path: KeyPath, rows: Rows, length: float, what: str, see: See
) -> Iterator[tuple[KeyPath, str]]:
    """Look for rows that leave much of a bed at what the first or last of them has."""
    first, last = rows.where[0], rows.where[-1]
    if max(first, length - last) > MOST_BEYOND * length:
        yield (
            path,
            f"positions from {first:g} to {last:g} m, the bed is {length:g} m long: "
            "beyond them the bed begins with "
            f"the {what} of the nearest; see {see('mesh.length')}",
        )
