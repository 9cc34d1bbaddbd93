"""The table of a sweep: parameters and named results of every run that has ended, as
CSV and as JSON.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.many.quantities import Quantity, parameter, result
from contbed.many.sweep.study import Study
from contbed.many.tables import write_rows
from contbed.output.summary import write_json

# range of a result over its size above which it varies, by more than by rounding
VARIES = 1e-9


@dataclass(frozen=True)
class Row:
    """One run that has ended: name, parameters in SI, and named results, or exit
    code and problem.
    """

    run: str
    parameters: Mapping[str, Any]
    qoi: Mapping[str, Any]
    exit_code: int = 0
    problem: str = ""


def write(out: Path, study: Study, rows: list[Row]) -> None:
    """Write table.csv and table.json."""
    parameters, results = columns(study, rows)
    head = [
        *(q.header for q in parameters),
        *(q.header for q in results),
        "run",
        "exit code",
        "problem",
    ]
    write_rows(
        out / "table.csv", head, (_cells(parameters, results, row) for row in rows)
    )
    described = {
        "parameters": {q.key: {"unit": q.unit} for q in parameters},
        "qoi": {q.key: {"unit": q.unit} for q in results},
    }
    counts = {
        "cases": len(study.cases),
        "ended": len(rows),
        "failed": sum(bool(row.exit_code) for row in rows),
    }
    write_json(
        out / "table.json",
        {
            "study": study.file.name,
            **counts,
            "warnings": study.warnings,
            **described,
            "runs": [vars(row) for row in rows],
        },
    )


def columns(study: Study, rows: Sequence[Row]) -> tuple[list[Quantity], list[Quantity]]:
    """Return the parameters, and the results that any run has."""
    keys = dict.fromkeys(key for row in rows for key in row.qoi)
    parameters = [
        parameter(key, (row.parameters[key] for row in rows))
        for key in study.parameters
    ]
    scene = study.cases[0].scene if study.cases else None
    return parameters, [result(key, scene) for key in keys]


def chosen(study: Study, rows: Sequence[Row]) -> list[tuple[Quantity, Array]]:
    """Return the results that a study asks for, else all that vary, with their values
    (rows,); nan where a run has no such number.
    """
    found = []
    for quantity in columns(study, rows)[1]:
        given = [row.qoi.get(quantity.key) for row in rows]
        numbers = [
            value if isinstance(value, int | float) else np.nan for value in given
        ]
        values = np.array(numbers, dtype=float)
        there = values[np.isfinite(values)]
        varies = len(there) > 1 and np.ptp(there) > VARIES * np.abs(there).max()
        if quantity.key in study.qoi or (not study.qoi and varies):
            found.append((quantity, values))
    return found


def _cells(parameters: list[Quantity], results: list[Quantity], row: Row) -> list[Any]:
    given = [row.parameters[q.key] for q in parameters]
    found = [row.qoi.get(q.key) for q in results]
    return [*given, *found, row.run, row.exit_code, row.problem]
