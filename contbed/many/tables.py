"""What studies write alike: tables of mixed columns, tables for a terminal, scenes
with other values.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.output.files import atomic
from contbed.output.toml_text import toml_text
from contbed.scene.inputs import named_files
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import KeyPath, parse_key, read

Row = Sequence[Any]
SAME = 1e-9  # relative difference of two times or positions that are the same


def exact(value: Any) -> Any:
    """Return the cell of a value: all digits of a number, lists and tables as JSON."""
    return json.dumps(value) if isinstance(value, list | dict) else value


def write_rows(
    path: Path, head: Row, rows: Iterable[Row], cell: Callable[[Any], Any] = exact
) -> None:
    """Write a table as CSV, whole or not at all; `cell` gives the cell of each
    value.
    """
    with (
        atomic(path) as temporary,
        open(temporary, "w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        for row in rows:
            writer.writerow([cell(value) for value in row])


def aligned(rows: Sequence[Sequence[str]], left: Collection[int]) -> list[str]:
    """Return rows of texts, head first, as lines with columns of equal width; those
    in `left` begin at the left.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = zip(row, widths, strict=True)
        padded = [
            cell.ljust(width) if k in left else cell.rjust(width)
            for k, (cell, width) in enumerate(cells)
        ]
        lines.append("  ".join(padded).rstrip())
    return lines


def row_at(*columns: tuple[Array, float]) -> tuple[int, bool]:
    """Return the row of a table that is nearest to a value in each of some columns,
    and whether it has them but for rounding.
    """
    distance = np.zeros(len(columns[0][0]))
    for values, wanted in columns:
        distance += np.abs(values - wanted) / max(float(np.abs(values).max()), SAME)
    row = int(np.argmin(distance))
    return row, bool(distance[row] <= SAME)


def scene_text(
    file: Path, scene: SceneBase, changes: Mapping[str, Any], folder: Path
) -> str:
    """Return the text of a scene's file with values changed by key; files that it names
    are found from `folder`.

    Parameters
    ----------
    file : of the scene
    scene : as it is loaded, for the files that it names
    changes : values by dotted key
    folder : where the text will be written
    """
    values, origin = read(file)
    for path, name in named_files(scene):
        if (origin.base / name).is_file() and not Path(name).is_absolute():
            _put(values, path, os.path.relpath(origin.base / name, folder))
    for key, value in changes.items():
        _put(values, parse_key(key), value)
    return toml_text(values)


def _put(values: Any, path: KeyPath, value: Any) -> None:
    """Put a value into nested tables and lists, making tables on the way."""
    table: Any = values
    for step in path[:-1]:
        table = table[step] if isinstance(step, int) else table.setdefault(step, {})
    table[path[-1]] = value
