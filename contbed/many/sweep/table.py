"""The table of a sweep: parameters and named results of every run that has ended, as CSV and as JSON."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contbed.explain import sheets
from contbed.fields import FIELDS, name_of, unit_of
from contbed.many.sweep.study import Study
from contbed.many.tables import write_rows
from contbed.output.summary import write_json
from contbed.scene.toml_lines import parse_key


@dataclass(frozen=True)
class Row:
    """One run that has ended: name, parameters in SI, and named results, or exit code and problem."""

    name: str
    parameters: Mapping[str, Any]
    qoi: Mapping[str, Any]
    exit_code: int = 0
    problem: str = ""


@dataclass(frozen=True)
class Quantity:
    """A parameter or result: its key in scene or summary, its name and its unit; None for no number."""

    key: str
    name: str
    unit: str | None

    @property
    def header(self) -> str:
        """Column header, "T_fluid_out [K]"; a plain number has "-"."""
        return self.name if self.unit is None else f"{self.name} [{'-' if self.unit == '1' else self.unit}]"

    @property
    def label(self) -> str:
        """Axis label, with the symbol of the field that a result is named after."""
        field, rest = self.name, ""
        while field and field not in FIELDS:
            field, _, end = field.rpartition("_")
            rest = f" {end}{rest}"
        words = self.name if "." in self.name else self.name.replace("_", " ")
        text = f"${FIELDS[field].symbol}${rest}" if field else words
        return text if self.unit in (None, "1") else f"{text} [{self.unit}]"


def parameter(key: str, values: Iterable[Any]) -> Quantity:
    """Return a key of the scene; names and tables have no unit."""
    named = any(isinstance(value, str | dict) for value in values)
    return Quantity(key, key, None if named else sheets.unit(parse_key(key)))


def result(key: str) -> Quantity:
    """Return a named result; the unit is that in its key ("k_eff [W/m/K]", "T_fluid_out_K") or of its field ("u_max").

    >>> [result(key).header for key in ("T_fluid_out_K", "k_eff [W/m/K]", "u_max", "porosity")]
    ['T_fluid_out [K]', 'k_eff [W/m/K]', 'u_max [m/s]', 'porosity [-]']
    """
    unit = unit_of(key) or "1"
    ending = re.sub(r"\W+", "_", unit)
    return Quantity(key, name_of(key).removesuffix(f"_{ending}").removesuffix(f"_{unit}"), unit)


def write(out: Path, study: Study, rows: list[Row]) -> None:
    """Write table.csv and table.json."""
    parameters, results = columns(study, rows)
    head = [*(q.header for q in parameters), *(q.header for q in results), "run", "exit code", "problem"]
    write_rows(out / "table.csv", head, (_cells(parameters, results, row) for row in rows))
    described = {
        "parameters": {q.key: {"unit": q.unit} for q in parameters},
        "qoi": {q.key: {"unit": q.unit} for q in results},
    }
    runs = [
        {
            "run": row.name,
            "exit_code": row.exit_code,
            "problem": row.problem,
            "parameters": row.parameters,
            "qoi": row.qoi,
        }
        for row in rows
    ]
    counts = {"cases": len(study.cases), "ended": len(rows), "failed": sum(bool(row.exit_code) for row in rows)}
    write_json(
        out / "table.json", {"study": study.file.name, **counts, "warnings": study.warnings, **described, "runs": runs}
    )


def columns(study: Study, rows: list[Row]) -> tuple[list[Quantity], list[Quantity]]:
    """Return the parameters, and the results that any run has."""
    keys = dict.fromkeys(key for row in rows for key in row.qoi)
    parameters = [parameter(key, (row.parameters[key] for row in rows)) for key in study.parameters]
    return parameters, [result(key) for key in keys]


def _cells(parameters: list[Quantity], results: list[Quantity], row: Row) -> list[Any]:
    values = [row.parameters[q.key] for q in parameters] + [row.qoi.get(q.key) for q in results]
    return [*values, row.name, row.exit_code, row.problem]
