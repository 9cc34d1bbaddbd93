"""`contbed report DIR...`: reads runs, or the folder of a command that makes many,
and writes report.html.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from contbed.errors import ContbedError
from contbed.models import kind_of
from contbed.output.files import write_text
from contbed.output.folder import list_file, require_own
from contbed.output.sketch import sketch, text_of
from contbed.report import charts, page
from contbed.report.calibration import CALIBRATION
from contbed.report.cascade import CASCADE
from contbed.report.fields import pictures
from contbed.report.optimum import OPTIMUM
from contbed.report.read import Run, read_run
from contbed.report.sensitivities import DERIVATIVES
from contbed.report.sweep import SWEEP
from contbed.report.words import words

FILE = "report.html"


def write(
    folders: str | Path | Sequence[str | Path], file: str | Path | None = None
) -> Path:
    """Write the report of one or several runs, or of one other command that makes many,
    and return its file.

    Parameters
    ----------
    folders : of runs, or one of a sweep, an optimum, a calibration, a cascade or
        derivatives
    file : where to write; report.html in the first folder if None

    Raises
    ------
    ContbedError : a folder holds no run, plotly is not installed, the file cannot be
        written, or another one that is no report stands in its place
    """
    given = [folders] if isinstance(folders, str | Path) else folders
    places = [Path(folder) for folder in given]
    target = Path(file) if file else places[0] / FILE
    require_place(target)
    for study in STUDIES:
        if any(map(study.is_in, places)):
            if len(places) > 1:
                what = study.name
                raise ContbedError(
                    f"{places[0]}: a report shows one {what}, or runs; give one "
                    f"folder of a {what}"
                )
            text = study.report(places[0])
            break
    else:
        text = of_runs(
            [
                read_run(folder, name)
                for folder, name in zip(places, _names(places), strict=True)
            ]
        )
    write_text(target, text)
    list_file(target)
    return target


def require_place(file: Path) -> None:
    """Refuse to write a report in the place of a file that is none."""
    require_own(file, page.MARK)


def _names(folders: Sequence[Path]) -> list[str]:
    """Return short names of the folders, longer ones where they would be the same."""
    short = [folder.resolve().name for folder in folders]
    return (
        short if len(set(short)) == len(short) else [str(folder) for folder in folders]
    )


def of_runs(runs: Sequence[Run]) -> str:
    """Return the report of one run, or of several side by side."""
    several = len(runs) > 1
    made = page.Charts()
    curves = made.grid(charts.curves(runs))
    fields = made.grid(
        charts.picture(run, item, several) for run in runs for item in pictures(run)
    )
    cost = made.grid([charts.cost(runs)])
    title = (
        runs[0].title
        if not several
        else f"Comparison of {', '.join(run.name for run in runs)}"
    )
    heads = "".join(
        (f"<h3>{escape(run.name)}: {escape(run.title)}</h3>" if several else "")
        + _opening(run)
        for run in runs
    )
    parts = [
        f"<header><h1>{escape(title)}</h1><p class=quiet>report of contbed "
        f"{escape(_version(runs))}</p>",
        f"{_links(bool(fields), several)}</header>",
        page.section("What was found", heads + page.results(runs), "results"),
        page.section(
            "Where the scenes differ",
            page.differences(runs) if several else "",
            "differences",
        ),
        page.section("Curves", curves, "curves"),
        page.section("Fields", fields, "fields"),
        page.section("Balances", _each(runs, page.balances), "balances"),
        page.section("Closures", _each(runs, page.closures), "closures"),
        page.section(
            "Scene", _each(runs, lambda run: page.scene(run.scene_keys())), "scene"
        ),
        page.section(
            "What was built and what was left out", _each(runs, page.built), "built"
        ),
        page.section("Cost and origin", cost + _each(runs, page.provenance), "cost"),
    ]
    return page.page(title, parts, made)


def _opening(run: Run) -> str:
    """Return the sketch of a run's bed, its words and its verdict."""
    scene = run.summary.get("scene", {})
    bed = sketch(kind_of(scene), scene, run.summary.get("qoi")) if scene else None
    drawing = f'<pre class="sketch">{escape(text_of(bed))}</pre>' if bed else ""
    text = f'<div class="words">{words(run)}{page.verdict(run)}</div>'
    return f'<div class="opening">{text}{drawing}</div>'


STUDIES = (CALIBRATION, OPTIMUM, CASCADE, SWEEP, DERIVATIVES)


def _version(runs: Sequence[Run]) -> str:
    return ", ".join(
        dict.fromkeys(
            str(run.summary.get("versions", {}).get("contbed", "?")) for run in runs
        )
    )


def _links(fields: bool, several: bool) -> str:
    names = [
        "results",
        *(["differences"] if several else []),
        "curves",
        *(["fields"] if fields else []),
        "balances",
        "closures",
    ]
    return (
        "<nav>"
        + "".join(
            f'<a href="#{name}">{name}</a>'
            for name in [*names, "scene", "built", "cost"]
        )
        + "</nav>"
    )


def _each(runs: Sequence[Run], of: Any) -> str:
    """Return a part for each run, under its name where there are several."""
    parts = [(run, of(run)) for run in runs]
    return "".join(
        (f"<h3>{escape(run.name)}</h3>" if len(runs) > 1 else "") + text
        for run, text in parts
        if text
    )
