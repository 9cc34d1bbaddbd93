"""Linked plots of a table whose rows are runs: parallel axes, and every number against
every other.

A column of text has a category for each text. A column that cannot be drawn is left
out, and the report says which and why: `Linked.left_out`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contbed.errors import ContbedError
from contbed.fields import labelled
from contbed.output.tables import REMEDY, is_number, read_cells
from contbed.report import page

Chart = dict[str, Any]

# columns that are drawn against each other; more make panels too small to read
MAX_PAIRS = 7
MAX_CATEGORIES = 12  # texts of a column; the ticks of more overlap
SAME = 1e-6  # relative spread of numbers that count as one
GREY = "#d5dade"  # of rows that are not chosen
GREY_SHARE = 0.02  # of the scale of colours, below the lowest value
VIRIDIS = (
    "#440154",
    "#482878",
    "#3e4989",
    "#31688e",
    "#26828e",
    "#1f9e89",
    "#35b779",
    "#6ece58",
    "#b5de2b",
    "#fde725",
)
PARALLEL = "drag along an axis to choose runs, which the panels below mark"
MATRIX = (
    "draw a frame in one panel to choose runs: they are marked in all, and keep "
    "their colour on the axes above"
)


@dataclass(frozen=True)
class Column:
    """A column of a table: name, unit ("1" or "" for none), and its value in each
    row; None where there is none.
    """

    name: str
    unit: str
    values: tuple[Any, ...]

    @property
    def label(self) -> str:
        """Name with the unit."""
        return labelled(self.name, self.unit)

    @property
    def is_number(self) -> bool:
        """Whether all values that there are are numbers."""
        there = [value for value in self.values if value is not None]
        return bool(there) and all(
            isinstance(v, int | float) and not isinstance(v, bool) for v in there
        )


@dataclass(frozen=True)
class Linked:
    """Charts of a table, and the columns that are in none of them, or in one only,
    each with the reason.
    """

    charts: tuple[Chart, ...]
    left_out: tuple[tuple[str, str], ...]

    def section(
        self, title: str, place: Callable[[Chart], str], anchor: str = "plots"
    ) -> str:
        """Return the section of a report; `place` adds a chart to the page and
        returns where it stands.
        """
        body = "".join(place(chart) for chart in self.charts)
        text = f'<div class="charts">{body}</div>' if body else ""
        if self.left_out:
            shown = page.table(["column", "why"], self.left_out)
            text += (
                f"<details><summary>{len(self.left_out)} columns are left out of "
                f"plots</summary>{shown}</details>"
            )
        return page.section(title, text, anchor)


def linked(
    columns: Sequence[Column], rows: Sequence[str], coloured: str = ""
) -> Linked:
    """Return the linked charts of a table.

    Parameters
    ----------
    columns : in the order of the axes
    rows : name of each row, shown at its points
    coloured : name of the column that gives the colour; the last that is drawn if empty
        or not drawn
    """
    drawn = [column for column in columns if not _reason(column)]
    left_out = [
        (column.label, reason) for column in columns if (reason := _reason(column))
    ]
    if not drawn:
        return Linked((), tuple(left_out))
    colour = next((column for column in drawn if column.name == coloured), drawn[-1])
    pairs = drawn[:MAX_PAIRS]
    left_out += [
        (
            column.label,
            "on the parallel axes only: the panels of pairs show the first "
            f"{MAX_PAIRS} columns",
        )
        for column in drawn[MAX_PAIRS:]
    ]
    scale = _scale(colour)
    parallel = {
        "type": "parcoords",
        "dimensions": [_axis(column) for column in drawn],
        "line": scale | {"showscale": True},
        "labelangle": -15,
        "labelside": "bottom",
    }
    matrix = {
        "type": "splom",
        "dimensions": [_panel(column) for column in pairs],
        "text": list(rows),
        "marker": scale | {"size": 6, "showscale": False},
        "diagonal": {"visible": False},
        "showupperhalf": False,
    }
    found = [
        {"kind": "parallel", "title": f"Coloured by {colour.name}: {PARALLEL}", "data": [parallel], "layout": {},
         "wide": True, "height": 460},
    ]  # fmt: skip
    if len(pairs) > 1:
        found.append(
            {"kind": "matrix", "title": f"Pairs: {MATRIX}", "data": [matrix], "layout": {"dragmode": "select"},
             "wide": True, "height": max(420, 150 * len(pairs))}
        )  # fmt: skip
    return Linked(tuple(found), tuple(left_out))


def _reason(column: Column) -> str:
    """Return why a column cannot be drawn; nothing if it can."""
    there = [value for value in column.values if value is not None]
    if not there:
        return "no run has a value"
    if column.is_number:
        if len(there) < len(column.values):
            return (
                f"{len(column.values) - len(there)} of {len(column.values)} runs "
                "have no value"
            )
        low, high = min(there), max(there)
        if high - low <= SAME * max(abs(low), abs(high)):
            return f"the same in all runs: {there[0]:.6g}"
        return ""
    texts = list(dict.fromkeys(map(text_of, column.values)))
    if len(texts) == 1:
        return f"the same in all runs: {texts[0]}"
    return (
        f"{len(texts)} different texts, more than an axis shows"
        if len(texts) > MAX_CATEGORIES
        else ""
    )


def text_of(value: Any) -> str:
    """Return a value as a category: a closure by its name and parameters.

    >>> text_of({"name": "power", "a": 1.2}), text_of(None), text_of(True)
    ('power, a = 1.2', 'none', 'yes')
    """
    if value is None:
        return "none"
    if isinstance(value, dict):
        return ", ".join(
            text_of(item) if key == "name" else f"{key} = {text_of(item)}"
            for key, item in value.items()
        )
    return (
        ", ".join(map(text_of, value))
        if isinstance(value, list | tuple)
        else str(_plain(value))
    )


def _plain(value: Any) -> Any:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, int | float) else value


def _numbers(column: Column) -> tuple[list[float], list[str]]:
    """Return six digits of each value, or the number of its category, and the
    categories.
    """
    if column.is_number:
        return [float(f"{value:.6g}") for value in column.values], []
    texts = [text_of(value) for value in column.values]
    categories = list(dict.fromkeys(texts))
    return [float(categories.index(text)) for text in texts], categories


def _axis(column: Column) -> Chart:
    """Return a parallel axis."""
    values, categories = _numbers(column)
    axis: Chart = {"label": _broken(column.label), "values": values}
    if categories:
        return axis | {"tickvals": list(range(len(categories))), "ticktext": categories}
    return axis | {"tickformat": ".4~g"}


def _panel(column: Column) -> Chart:
    """Return a row and column of the panels of pairs."""
    values, categories = _numbers(column)
    if categories:
        return {
            "label": _broken(column.label),
            "values": [categories[int(value)] for value in values],
            "axis": {"type": "category"},
        }
    return {"label": _broken(column.label), "values": values}


def _scale(column: Column) -> Chart:
    """Return the colour of each row, on a scale that is grey below the lowest value:
    `cmin` greys a row.
    """
    values, categories = _numbers(column)
    low, high = min(values), max(values)
    bar: Chart = {"title": {"text": ""}}
    if categories:
        bar |= {"tickvals": list(range(len(categories))), "ticktext": categories}
    upper = [
        GREY_SHARE + (1.0 - GREY_SHARE) * k / (len(VIRIDIS) - 1)
        for k in range(len(VIRIDIS))
    ]
    # the step from grey lies in the middle of the share, so that rounding of colours
    # reaches neither side
    colours = [[0.0, GREY], [0.5 * GREY_SHARE, GREY], [0.5 * GREY_SHARE, VIRIDIS[0]]]
    return {
        "color": values,
        "cmin": low - (high - low) * GREY_SHARE / (1.0 - GREY_SHARE),
        "cmax": high,
        "colorscale": colours
        + [[share, colour] for share, colour in zip(upper, VIRIDIS, strict=True)],
        "colorbar": bar,
    }


def _broken(label: str) -> str:
    """Return a long label in two lines."""
    return (
        label.replace(".", "<br>", 1).replace(" [", "<br>[")
        if len(label) > 18
        else label
    )


def read_columns(
    file: Path, texts: Sequence[str] = (), numbers: Sequence[str] = ()
) -> dict[str, Column]:
    """Read a table of numbers and texts by the names in its header; an empty cell or
    nan is no value.

    Raises
    ------
    ContbedError : the file cannot be read, its rows do not fit the header, one of the
        columns `texts` and `numbers` is not there, or one of `numbers` holds a text
    """
    head, rows = read_cells(file)
    found = {}
    for k, header in enumerate(head):
        name, _, unit = (
            header.rpartition(" [") if header.endswith("]") else (header, "", "")
        )
        found[name] = Column(name, unit.rstrip("]"), _values([row[k] for row in rows]))
    if missing := [name for name in (*texts, *numbers) if name not in found]:
        raise ContbedError(f"{file}: has no column {missing[0]!r}; {REMEDY}")
    require_numbers(file, found, numbers)
    return found


def require_numbers(
    file: Path, columns: Mapping[str, Column], names: Iterable[str]
) -> None:
    """Look for texts in columns of numbers.

    Raises
    ------
    ContbedError : a cell of one of the columns `names` is neither empty nor a number
    """
    for name in names:
        for line, value in enumerate(columns[name].values, 2):
            if isinstance(value, str) and not is_number(value):
                raise ContbedError(
                    f"{file}:{line}: {name} is {value!r}, which is no number; {REMEDY}"
                )


def table_of(columns: Iterable[Column]) -> str:
    """Return columns as the table of a page; those without a value are left out."""
    shown = [
        column
        for column in columns
        if any(value is not None for value in column.values)
    ]
    labels = [column.label for column in shown]
    return page.table(labels, zip(*(column.values for column in shown), strict=True))


def _values(cells: Sequence[str]) -> tuple[Any, ...]:
    """Return the cells of a column as numbers where all of them are."""
    try:
        numbers = [float(cell) if cell else None for cell in cells]
    except ValueError:
        return tuple(cell or None for cell in cells)
    return tuple(
        number if number is not None and math.isfinite(number) else None
        for number in numbers
    )
