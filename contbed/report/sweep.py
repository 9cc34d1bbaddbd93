"""The report of a sweep: its table, linked charts, and the uncertainty of a sample."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contbed.report import page
from contbed.report.linked import Column, linked, read_columns, table_of, text_of
from contbed.report.study import Content, Found, Study

TABLE = "table.json"
# columns of numbers in the tables of a sample
NUMBERS = {
    "uncertainty.csv": ("mean", "standard deviation", "low", "high"),
    "indices.csv": ("share by gradients",),
}


def _content(folder: Path, found: Found, made: page.Charts) -> Content:
    units = {
        name: about.get("unit") or ""
        for group in ("parameters", "qoi")
        for name, about in found[group].items()
    }
    head = ["run", *(Column(name, unit, ()).label for name, unit in units.items())]
    good = [run for run in found["runs"] if not run["exit_code"]]
    columns = [
        Column(name, units[name], tuple(run[group].get(name) for run in good))
        for group in ("parameters", "qoi")
        for name in found[group]
    ]
    rows = [_row(found, run, units) for run in found["runs"]]
    about = (
        f"{found['ended']} of {found['cases']} runs have ended, "
        f"{len(found['runs']) - len(good)} of them failed"
    )
    sections = [
        page.warnings(found.get("warnings", [])),
        page.section("Uncertainty", _uncertainty(folder), "uncertainty"),
        linked(columns, [run["run"] for run in good]).section(
            "Linked plots", made.place
        ),
        page.section("All runs", page.table(head, rows), "runs"),
    ]
    return Content(
        f"Sweep {Path(str(found.get('study', folder.name))).stem}", about, sections
    )


def _uncertainty(folder: Path) -> str:
    """Return spreads and indices of the results; nothing where the sweep has none."""
    tables = [
        read_columns(folder / file, ("result",), numbers)
        for file, numbers in NUMBERS.items()
        if (folder / file).is_file()
    ]
    return "".join(table_of(table.values()) for table in tables)


def _row(found: Found, run: dict[str, Any], names: dict[str, str]) -> list[Any]:
    """Return the cells of a run; of one that failed the problem stands under the
    first result.
    """
    values = {**run["parameters"], **run["qoi"]}
    if run["exit_code"]:
        problem = f"exit code {run['exit_code']}: {run['problem']}"
        values = {**run["parameters"], next(iter(found["qoi"]), "problem"): problem}
    cells = (
        text_of(value) if isinstance(value, dict) else value
        for value in map(values.get, names)
    )
    return [page.code(run["run"][:8]), *cells]


def _is_in(folder: Path) -> bool:
    return (folder / TABLE).is_file()


SWEEP = Study("sweep", "sweep", _content, _is_in, TABLE)
