"""The report of `contbed sensitivities`: the derivatives of each result, the largest
first, as bars and as a table.
"""

from __future__ import annotations

from pathlib import Path

from contbed.many.derivatives.sensitivities import FILE, HOW
from contbed.output.folder import SUMMARY
from contbed.report import page
from contbed.report.linked import read_columns, table_of
from contbed.report.study import Content, Found, Study

NUMBERS = ("value", "derivative", "relative", "standard error")  # columns of the table


def _is_in(folder: Path) -> bool:
    """Return whether a folder holds derivatives, and no run beside them."""
    return (folder / f"{FILE}.json").is_file() and not (folder / SUMMARY).exists()


def _content(folder: Path, found: Found, made: page.Charts) -> Content:
    columns = read_columns(folder / f"{FILE}.csv", ("result", "key"), NUMBERS)
    sections = [
        page.section(
            "Results",
            page.found({name: each["value"] for name, each in found["qoi"].items()}),
            "qoi",
        ),
        page.warnings(found["notes"]),
        page.section(
            "Percent of the result for one percent of the key",
            page.picture(folder / f"{FILE}.png"),
            "bars",
        ),
        page.section("All derivatives", table_of(columns.values()), "derivatives"),
    ]
    title = str(found["title"] or f"Derivatives of {', '.join(found['qoi'])}")
    return Content(title, f"derivatives {HOW[found['method']]}", sections)


DERIVATIVES = Study(
    "table of derivatives", "sensitivities", _content, _is_in, f"{FILE}.json"
)
