"""Tables in CSV files: of numbers in tests/data, a row by its name, or of text."""

import csv
from pathlib import Path


def rows_of(file):
    """Return the numbers of each row by the name in its first column; None where a
    cell is empty.
    """
    text = (Path(__file__).parent / "data" / file).read_text(encoding="utf-8")
    return {
        name: tuple(float(cell) if cell else None for cell in cells)
        for name, *cells in list(csv.reader(text.splitlines()))[1:]
    }


def table_of(path):
    """Return the rows of a CSV file as dictionaries of text."""
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
