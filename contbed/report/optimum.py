"""The report of a search for an optimum: the point and its results, what each
constraint costs, the way to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from pydantic import Field

from contbed.many.optimise.constrained_search import FEASIBLE
from contbed.output.colours import COLOURS
from contbed.output.shapes import Number, Shape
from contbed.report import page
from contbed.report.linked import (
    Column,
    linked,
    read_columns,
    require_numbers,
    table_of,
)
from contbed.report.study import Content, Found, Study, has

OBJECTIVE, MISSED = ": objective", ": missed by"  # endings of headers of table.csv
TEXTS = ("run", "problem", "gradient")  # columns of table.csv


class Objective(Shape):
    """What was sought."""

    formula: str
    aim: str
    value: Number
    unit: str
    gradient: dict[str, Number] | None


class Key(Shape):
    """A key at the point that was found."""

    value: Number
    unit: str
    low: Number = Field(alias="from")
    high: Number = Field(alias="to")
    price_of_bound: Number


class Constraint(Shape):
    """A constraint at the point."""

    constraint: str
    value: Number
    bound: Number
    unit: str
    missed_by: Number
    active: bool
    price: Number
    price_unit: str
    gradient: dict[str, Number] | None


class Runs(Shape):
    """Numbers of runs."""

    evaluated: int
    failed: int


class OptimumSummary(Shape):
    """summary.json of a search."""

    status: str
    verdict: str
    versions: dict[str, Any]
    title: str | None = None
    design: str
    objective: Objective
    keys: dict[str, Key]
    constraints: list[Constraint]
    costs: list[str]
    qoi: dict[str, Any]
    gradients: str
    surrogate: dict[str, Any] | None
    runs: Runs
    warnings: list[str]


def _content(folder: Path, found: Found, made: page.Charts) -> Content:
    file = folder / "table.csv"
    columns = read_columns(file, ("number", "exit code", *TEXTS))
    require_numbers(file, columns, [name for name in columns if name not in TEXTS])
    runs = found["runs"]
    about = (
        f"{runs['evaluated']} evaluations, {runs['failed']} of them failed; "
        f"derivatives: {found['gradients']}"
    )
    names = list(columns.values())
    numbers = [
        c
        for c in names
        if c.name not in ("number", "run", "exit code", "problem", "gradient")
    ]
    ended = [k for k, code in enumerate(columns["exit code"].values) if not code]
    here = [Column(c.name, c.unit, tuple(c.values[k] for k in ended)) for c in numbers]
    run_names = [str(columns["run"].values[k]) for k in ended]
    sections = [
        page.section("What was found", _answer(found), "results"),
        page.warnings(found["warnings"]),
        page.section("What the constraints cost", _constraints(found), "constraints"),
        page.section("Gradient at the point", _gradient(found), "gradient"),
        page.section("Results at the point", page.found(found["qoi"]), "qoi"),
        page.section("The way to it", made.grid(_way(found, columns)), "way"),
        linked(here, run_names, f"{found['objective']['formula']}{OBJECTIVE}").section(
            "Linked plots", made.place
        ),
        page.section("All evaluations", table_of(names), "runs"),
    ]
    return Content(
        str(found.get("title") or f"Optimum of {found['design']}"), about, sections
    )


def _answer(found: Found) -> str:
    """Return verdict, objective, and the keys with their bounds."""
    aim = found["objective"]
    good = "good" if found["status"] in ("optimum", "settled") else "bad"
    lines = [
        f'<span class="{good}">{escape(found["status"])}</span> '
        f"{escape(found['verdict'])}"
    ]
    answer = (
        f"{aim['aim']} {page.code(aim['formula'])}: {page.number(aim['value'])} "
        f"{page.unit(aim['unit'])}"
    )
    active = [one["constraint"] for one in found["constraints"] if one["active"]]
    held = (
        f"active constraints: {escape(', '.join(active))}"
        if active
        else "no constraint is active"
    )
    rows = []
    for name, key in found["keys"].items():
        price = key["price_of_bound"]
        per = escape(f"{aim['unit']} per {key['unit']}") if price else ""
        ends = (page.number(key[end]) for end in ("value", "from", "to"))
        rows.append([page.code(name), *ends, page.unit(key["unit"]),
                     page.number(price) if price else "inside of its bounds", per])  # fmt: skip
    keys = page.table(
        [
            "key",
            "value",
            "from",
            "to",
            "unit",
            "price of its bound",
            "unit of the price",
        ],
        rows,
        (1, 2, 3, 5),
    )
    expected = found["surrogate"] or {}
    told = [
        [
            escape(name),
            page.number(each["expected"]),
            page.number(each["standard_error"]),
        ]
        for name, each in expected.items()
        if isinstance(each, dict)
    ]
    head = ["by the surrogate", "expected", "standard error"]
    surrogate = page.table(head, told, (1, 2))
    return (
        f'<p class="verdict">{"".join(lines)}</p><p>{answer}; '
        f"{held}</p>{keys}{surrogate}"
    )


def _constraints(found: Found) -> str:
    rows = [
        [page.code(one["constraint"]), page.number(one["value"]), page.number(one["bound"]),
         page.unit(one["unit"]), page.number(one["missed_by"]), page.number(one["active"]), page.number(one["price"]),
         escape(one["price_unit"])]
        for one in found["constraints"]
    ]  # fmt: skip
    head = [
        "constraint",
        "value",
        "bound",
        "unit",
        "missed by",
        "active",
        "price",
        "unit of the price",
    ]
    costs = "".join(f"<li>{escape(text)}</li>" for text in found["costs"])
    return page.table(head, rows, (1, 2, 4, 6)) + (f"<ul>{costs}</ul>" if costs else "")


def _gradient(found: Found) -> str:
    """Return the derivatives of objective and constraints by each key, in the units
    of both.
    """
    aim = found["objective"]
    functions = [(aim["formula"], aim["unit"], aim["gradient"])]
    functions += [
        (one["constraint"], one["unit"], one["gradient"])
        for one in found["constraints"]
    ]
    rows = [
        [
            escape(name),
            page.code(key),
            page.number(slope),
            escape(f"{unit} per {found['keys'][key]['unit']}"),
        ]
        for name, unit, slopes in functions
        for key, slope in (slopes or {}).items()
    ]
    return page.table(["of", "by", "derivative", "unit"], rows, (2,))


def _way(found: Found, columns: Mapping[str, Column]) -> list[dict[str, Any]]:
    """Return the objective over the evaluations with the best so far, and by how
    much constraints were missed.
    """
    aim = found["objective"]
    objective = next(
        (c for name, c in columns.items() if name.endswith(OBJECTIVE)), None
    )
    if objective is None:
        return []
    number = list(columns["number"].values)
    excess = [column for name, column in columns.items() if name.endswith(MISSED)]
    best = _best(aim["aim"] == "maximise", objective, excess)
    line = {"type": "scatter", "x": number}
    traces = [
        line | {"mode": "markers", "name": "evaluations", "y": list(objective.values), "marker": {"color": COLOURS[0]}},
        line | {"mode": "lines", "name": "best that holds all constraints", "y": best,
                "line": {"shape": "hv", "color": COLOURS[1]}},
    ]  # fmt: skip
    charts = [_chart("Objective over the evaluations", traces, objective)]
    for column in excess:
        missed = [
            line
            | {"mode": "lines+markers", "name": column.name, "y": list(column.values)}
        ]
        charts.append(
            _chart(f"{column.name}; held where it is not above zero", missed, column)
        )
    return charts


def _best(
    maximise: bool, objective: Column, excess: Sequence[Column]
) -> list[float | None]:
    """Return the best objective up to each evaluation of those that hold all
    constraints; None before the first.
    """
    better = max if maximise else min
    by = [
        [abs(v) if v is not None and "==" in column.name else v for v in column.values]
        for column in excess
    ]  # an equality is missed on both sides
    allowed = [
        FEASIBLE * max((abs(v) for v in values if v is not None), default=0.0)
        for values in by
    ]
    best: list[float | None] = []
    for k, value in enumerate(objective.values):
        held = value is not None and all(
            _is_held(values[k], most) for values, most in zip(by, allowed, strict=True)
        )
        former = best[-1] if best else None
        best.append(
            value
            if held and former is None
            else better(value, former)
            if held
            else former
        )
    return best


def _is_held(missed: float | None, most: float) -> bool:
    return missed is not None and missed <= most


def _chart(
    title: str, traces: Sequence[dict[str, Any]], column: Column
) -> dict[str, Any]:
    label = Column(column.name.partition(": ")[0], column.unit, ()).label
    layout = page.axes("evaluation", label)
    return {"kind": "curves", "title": title, "data": list(traces), "layout": layout}


OPTIMUM = Study(
    "search for an optimum",
    "optimise",
    OptimumSummary,
    _content,
    "the summary of a search for an optimum",
    has("design"),
)
