"""Files of a search: table.csv of its evaluations, summary.json, optimum.toml,
convergence.png.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.many.optimise.constrained_search import FIRST_ORDER
from contbed.many.optimise.evaluations import Evaluation, Evaluations, named_values
from contbed.many.optimise.found import Found, costs
from contbed.many.optimise.problem import Constraint, Design
from contbed.many.quantities import parameter, result
from contbed.many.tables import scene_text, write_rows
from contbed.output.files import write_text
from contbed.output.summary import write_json
from contbed.output.versions import versions


def write(folder: Path, design: Design, found: Found, evaluations: Evaluations) -> None:
    """Write all files."""
    from contbed.many.optimise.plots import plot

    write_table(folder, design, evaluations.rows)
    write_json(folder / "summary.json", summary(design, found, evaluations))
    about = (
        f"# {found.status} of {design.file.name}: "
        f"{'maximise' if design.maximise else 'minimise'} "
    )
    values = {
        key.name: int(value) if key.whole else float(f"{value:.14g}")
        for key, value in zip(design.keys, found.evaluation.point, strict=True)
    }
    scene = scene_text(
        design.scene_file, design.scene_at(found.evaluation.point), values, folder
    )
    write_text(folder / "optimum.toml", f"{about}{design.objective.text}\n{scene}")
    plot(folder / "convergence.png", design, found, evaluations.rows)


def write_table(folder: Path, design: Design, rows: Sequence[Evaluation]) -> None:
    """Write table.csv, one line for each evaluation."""
    keys = [parameter(key.name, ()).header for key in design.keys]
    results = [result(name, design.scene).header for name in design.results]
    excess = [
        f"{one.text}: missed by [{_unit(one.left.unit)}]" for one in design.constraints
    ]
    objective = f"{design.objective.text}: objective [{_unit(design.objective.unit)}]"
    head = [
        "number",
        *keys,
        *results,
        objective,
        *excess,
        "gradient",
        "run",
        "exit code",
        "problem",
    ]
    signs = np.array([design.sign, *np.ones(len(design.constraints))])
    cells = []
    for number, row in enumerate(rows, 1):
        values = (
            [None] * len(signs)
            if row.functions is None
            else (row.functions * signs).tolist()
        )
        point = [
            round(v) if key.whole else float(v)
            for key, v in zip(design.keys, row.point, strict=True)
        ]
        named = map(row.qoi.get, design.results)
        state = [
            "yes" if row.differentiated else "",
            row.run,
            row.exit_code,
            row.problem,
        ]
        cells.append([number, *point, *named, *values, *state])
    write_rows(folder / "table.csv", head, cells)


def _unit(unit: str) -> str:
    return "-" if unit == "1" else unit


def summary(design: Design, found: Found, evaluations: Evaluations) -> dict[str, Any]:
    """Return the content of summary.json."""
    at, rows = found.evaluation, evaluations.rows
    values = named_values(design, at.point, at.qoi)
    slopes = found.slopes
    names = [key.name for key in design.keys]
    return {
        "status": found.status,
        "verdict": found.why,
        "versions": versions(),
        "title": design.title,
        "design": design.file.name,
        "objective": {
            "formula": design.objective.text,
            "aim": "maximise" if design.maximise else "minimise",
            "value": design.objective(values),
            "unit": design.objective.unit,
            "gradient": None
            if slopes is None
            else dict(zip(names, slopes[0].tolist(), strict=True)),
        },
        "keys": {
            key.name: {
                "value": int(value) if key.whole else float(value),
                "unit": key.unit,
                "from": key.low,
                "to": key.high,
                "price_of_bound": float(price),
            }
            for key, value, price in zip(
                design.keys, at.point, found.bound_prices, strict=True
            )
        },
        "constraints": [
            _constraint(design, found, k, values)
            for k in range(len(design.constraints))
        ],
        "costs": list(costs(design, found)),
        "first_order": {"residual": found.residual, "allowed": FIRST_ORDER},
        "qoi": dict(at.qoi),
        "run": at.run,
        "method": design.method,
        "gradients": evaluations.method,
        "surrogate": _expected(design, found),
        "runs": {
            "evaluated": len(rows),
            "before": evaluations.before,
            "failed": sum(r.functions is None for r in rows),
        },
        "warnings": list(found.remarks),
    }


def _expected(design: Design, found: Found) -> dict[str, Any] | None:
    """Return what the surrogate expects at the point, with standard errors; None
    with gradients.
    """
    if found.expected is None or found.errors is None:
        return None
    names = [
        design.objective.text,
        *(f"{one.text}: missed by" for one in design.constraints),
    ]
    return {
        name: {"expected": float(value), "standard_error": float(error)}
        for name, value, error in zip(names, found.expected, found.errors, strict=True)
    } | {"runs_at_a_point": design.repeats}


def _constraint(
    design: Design, found: Found, k: int, values: dict[str, float]
) -> dict[str, Any]:
    one: Constraint = design.constraints[k]
    names = [key.name for key in design.keys]
    slopes = (
        None
        if found.slopes is None
        else found.slopes[1 + k] * (-1.0 if one.sign == ">=" else 1.0)
    )
    return {
        "constraint": one.text,
        "value": one.left(values),
        "bound": one.bound(values),
        "unit": one.left.unit,
        "missed_by": one.excess(values),
        "active": bool(found.active[k]),
        "price": float(found.prices[k]),
        "price_unit": f"{design.objective.unit} per {one.left.unit}",
        "gradient": None
        if slopes is None
        else dict(zip(names, slopes.tolist(), strict=True)),
    }
