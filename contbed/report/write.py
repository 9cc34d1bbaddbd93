"""`contbed report DIR...`: reads runs, or the folder of a command that makes many, and writes report.html."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import Any

from contbed.errors import ContbedError
from contbed.output.files import atomic
from contbed.output.folder import SUMMARY, read_summary
from contbed.output.summary import write_json
from contbed.report import charts, page
from contbed.report.calibration import is_calibration, of_calibration
from contbed.report.cascade import is_cascade, of_cascade
from contbed.report.fields import pictures
from contbed.report.indices import uncertainty
from contbed.report.linked import Column, linked, text_of
from contbed.report.optimum import is_optimum, of_optimum
from contbed.report.read import Run, is_sweep, read_run, read_sweep
from contbed.report.sensitivities import is_sensitivities, of_sensitivities

FILE = "report.html"


def write(folders: Sequence[Path], file: Path | None = None) -> Path:
    """Write the report of one or several runs, or of one other command that makes many, and return its file.

    Parameters
    ----------
    folders : of runs, or one of a sweep, an optimum, a calibration, a cascade or derivatives
    file : where to write; report.html in the first folder if None

    Raises
    ------
    ContbedError : a folder holds no run, plotly is not installed, or the file cannot be written
    """
    target = file or folders[0] / FILE
    for what, is_one, of in WHOLE:
        if any(map(is_one, folders)):
            if len(folders) > 1:
                raise ContbedError(f"{folders[0]}: a report shows one {what}, or runs; give one folder of a {what}")
            text = of(folders[0])
            break
    else:
        text = of_runs([read_run(folder, name) for folder, name in zip(folders, _names(folders), strict=True)])
    with atomic(target) as temporary:
        temporary.write_text(text, encoding="utf-8")
    _list(target)
    return target


def _list(file: Path) -> None:
    """Add a report to the files of the run in its folder, which the next run there removes."""
    summary = read_summary(file.parent)
    listed = summary.get("files")
    if listed is not None and file.name not in listed:
        write_json(file.parent / SUMMARY, {**summary, "files": sorted([*listed, file.name])})


def _names(folders: Sequence[Path]) -> list[str]:
    """Return short names of the folders, longer ones where they would be the same."""
    short = [folder.resolve().name for folder in folders]
    return short if len(set(short)) == len(short) else [str(folder) for folder in folders]


def of_runs(runs: Sequence[Run]) -> str:
    """Return the report of one run, or of several side by side."""
    several = len(runs) > 1
    made = charts.curves(runs)
    curves = list(range(len(made)))
    made += [charts.picture(run, item, several) for run in runs for item in pictures(run)]
    fields = list(range(len(curves), len(made)))
    made.append(charts.cost(runs))
    title = runs[0].title if not several else f"Comparison of {', '.join(run.name for run in runs)}"
    heads = "".join(
        (f"<h3>{escape(run.name)}: {escape(run.title)}</h3>" if several else "") + page.verdict(run) for run in runs
    )
    parts = [
        f"<header><h1>{escape(title)}</h1><p class=quiet>report of contbed {escape(_version(runs))}</p>",
        f"{_links(fields, several)}</header>",
        page.section("What was found", heads + page.results(runs), "results"),
        page.section("Where the scenes differ", page.differences(runs) if several else "", "differences"),
        page.section("Curves", _grid(curves, made), "curves"),
        page.section("Fields", _grid(fields, made), "fields"),
        page.section("Balances", _each(runs, page.balances), "balances"),
        page.section("Closures", _each(runs, page.closures), "closures"),
        page.section("Scene", _each(runs, lambda run: page.scene(run.scene_keys())), "scene"),
        page.section("What was built and what was left out", _each(runs, page.built), "built"),
        page.section("Cost and origin", _grid([len(made) - 1], made) + _each(runs, page.provenance), "cost"),
    ]
    return page.page(title, parts, made)


def of_sweep(folder: Path) -> str:
    """Return the report of a sweep: its table and linked charts."""
    found = read_sweep(folder)
    made = page.Charts()
    names = {**found["parameters"], **found["qoi"]}
    head = ["run", *(Column(name, about.get("unit") or "", ()).label for name, about in names.items())]
    rows = []
    for run in found["runs"]:
        values = {**run["parameters"], **run["qoi"]}
        if run["exit_code"]:
            values = {
                **run["parameters"],
                next(iter(found["qoi"]), "problem"): f"exit code {run['exit_code']}: {run['problem']}",
            }
        rows.append([f"<code>{escape(run['run'][:8])}</code>", *(_cell(values.get(name)) for name in names)])
    failed = sum(bool(run["exit_code"]) for run in found["runs"])
    text = f"{found['ended']} of {found['cases']} runs have ended, {failed} of them failed"
    title = f"Sweep {Path(str(found.get('study', folder.name))).stem}"
    good = [run for run in found["runs"] if not run["exit_code"]]
    columns = [
        Column(name, about.get("unit") or "", tuple(run[group].get(name) for run in good))
        for group in ("parameters", "qoi")
        for name, about in found[group].items()
    ]
    parts = [
        page.header(title, text),
        page.warnings(found.get("warnings", [])),
        page.section("Uncertainty", uncertainty(folder), "uncertainty"),
        linked(columns, [run["run"] for run in good]).section("Linked plots", made.place),
        page.section("All runs", page.table(head, rows, range(1, len(head))), "runs"),
    ]
    return page.page(title, parts, made)


def _cell(value: Any) -> str:
    """Return a value of a table; a closure by its name and parameters."""
    return escape(text_of(value)) if isinstance(value, dict) else page.number(value)


WHOLE: tuple[tuple[str, Callable[[Path], bool], Callable[[Path], str]], ...] = (
    ("calibration", is_calibration, of_calibration),
    ("search for an optimum", is_optimum, of_optimum),
    ("cascade", is_cascade, of_cascade),
    ("sweep", is_sweep, of_sweep),
    ("table of derivatives", is_sensitivities, of_sensitivities),
)
"""What has a report of its own: its name, whether a folder holds it, and the report of the folder."""


def _version(runs: Sequence[Run]) -> str:
    return ", ".join(dict.fromkeys(str(run.summary.get("versions", {}).get("contbed", "?")) for run in runs))


def _links(fields: Sequence[int], several: bool) -> str:
    names = [
        "results",
        *(["differences"] if several else []),
        "curves",
        *(["fields"] if fields else []),
        "balances",
        "closures",
    ]
    return "<nav>" + "".join(f'<a href="#{name}">{name}</a>' for name in [*names, "scene", "built", "cost"]) + "</nav>"


def _grid(numbers: Sequence[int], made: Sequence[dict[str, Any]]) -> str:
    body = "".join(page.place(number, made[number]) for number in numbers)
    return f'<div class="charts">{body}</div>' if body else ""


def _each(runs: Sequence[Run], of: Any) -> str:
    """Return a part for each run, under its name where there are several."""
    parts = [(run, of(run)) for run in runs]
    return "".join((f"<h3>{escape(run.name)}</h3>" if len(runs) > 1 else "") + text for run, text in parts if text)
