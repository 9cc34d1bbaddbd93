"""The report of a search for an optimum: the point and its results, what each
constraint costs, the way to it.
"""

from __future__ import annotations

from html import escape
from pathlib import Path

from contbed.report import page
from contbed.report.linked import (
    Column,
    linked,
    read_columns,
    require_numbers,
    table_of,
)
from contbed.report.study import Content, Found, Study, has

OBJECTIVE = ": objective"  # ending of a header of table.csv
TEXTS = ("run", "problem", "gradient")  # columns of table.csv


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
        page.section("The way to it", page.picture(folder / "convergence.png"), "way"),
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
    keys = page.records(
        {"key": page.code(name), **key} for name, key in found["keys"].items()
    )
    expected = found["surrogate"] or {}
    surrogate = page.records(
        {"by the surrogate": name, **each}
        for name, each in expected.items()
        if isinstance(each, dict)
    )
    return (
        f'<p class="verdict">{"".join(lines)}</p><p>{answer}; '
        f"{held}</p>{keys}{surrogate}"
    )


def _constraints(found: Found) -> str:
    shown = page.records(
        {key: value for key, value in one.items() if key != "gradient"}
        for one in found["constraints"]
    )
    costs = "".join(f"<li>{escape(text)}</li>" for text in found["costs"])
    return shown + (f"<ul>{costs}</ul>" if costs else "")


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
        [name, page.code(key), slope, f"{unit} per {found['keys'][key]['unit']}"]
        for name, unit, slopes in functions
        for key, slope in (slopes or {}).items()
    ]
    return page.table(["of", "by", "derivative", "unit"], rows)


OPTIMUM = Study("search for an optimum", "optimise", _content, has("design"))
