"""The HTML of a report: text and tables by themselves, charts by plotly, whose code
is packed into the file.
"""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from contbed import fields as quantities
from contbed.errors import ContbedError
from contbed.many.store import key_of
from contbed.output.summary import plain
from contbed.output.tables import REMEDY
from contbed.report.read import Key, Run

MARK = '<script type="text/plain" id="charts">'  # of all reports


def page(title: str, parts: Iterable[str], charts: Sequence[dict[str, Any]]) -> str:
    """Return the file: `parts` are the sections, in which `place` puts a chart by
    its number.
    """
    data = json.dumps(
        plain(list(charts)), ensure_ascii=False, separators=(",", ":"), allow_nan=False
    )
    style, script = (
        files("contbed.report").joinpath(name).read_text(encoding="utf-8")
        for name in ("report.css", "report.js")
    )
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en">',
            '<head><meta charset="utf-8"><meta name="viewport" '
            'content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)}</title><style>{style}</style></head>",
            f"<body><main>{''.join(parts)}</main>",
            '<script type="text/plain" '
            f'id="plotly">{_plotly() if charts else ""}</script>',
            f"{MARK}{_compressed(data)}</script>",
            f"<script>{script}</script></body></html>",
            "",
        ]
    )


def _compressed(text: str) -> str:
    return b64encode(
        gzip.compress(text.encode("utf-8"), compresslevel=9, mtime=0)
    ).decode("ascii")


def _plotly() -> str:
    try:
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise ContbedError(
            "a report needs plotly: pip install 'contbed[report]'"
        ) from error
    return _compressed(get_plotlyjs())


class Charts(list[dict[str, Any]]):
    """The charts of a page in their order."""

    def place(self, chart: dict[str, Any]) -> str:
        """Add a chart to the page and return where it stands."""
        self.append(chart)
        return place(len(self) - 1, chart)

    def grid(self, charts: Iterable[dict[str, Any]]) -> str:
        """Add charts side by side; nothing where there are none."""
        body = "".join(self.place(chart) for chart in charts)
        return f'<div class="charts">{body}</div>' if body else ""


def header(title: str, text: str) -> str:
    """Return the head of a page: what it shows, and one line about it."""
    return f"<header><h1>{escape(title)}</h1><p class=quiet>{escape(text)}</p></header>"


class Html(str):
    """A text that is HTML already."""


class Number(Html):
    """A number in a cell, at its right."""


def code(text: str) -> Html:
    """Return a name of contbed in a cell or sentence."""
    return Html(f"<code>{escape(text)}</code>")


def unit(text: str | None) -> str:
    """Return a unit in a cell; nothing for a plain number."""
    return quantities.behind(text).strip()


def picture(file: Path) -> str:
    """Return a picture that a command wrote.

    Raises
    ------
    ContbedError : the file cannot be read
    """
    try:
        data = b64encode(file.read_bytes()).decode("ascii")
    except OSError as error:
        raise ContbedError(
            f"{file}: cannot be read: {error.strerror}; {REMEDY}"
        ) from error
    return (
        f'<img style="max-width:100%" alt="{escape(file.stem)}" '
        f'src="data:image/png;base64,{data}">'
    )


def warnings(texts: Iterable[str]) -> str:
    """Return the section of warnings; nothing where there are none."""
    return section("Warnings", _listed(texts), "warnings")


def _listed(warnings: Iterable[str]) -> str:
    items = "".join(f"<li>{escape(text)}</li>" for text in warnings)
    return f'<ul class="warnings">{items}</ul>' if items else ""


def place(number: int, chart: dict[str, Any]) -> str:
    """Return the place of a chart, with a slider where it has several times."""
    times = chart.get("times") or []
    slider = ""
    if len(times) > 1:
        last = len(times) - 1
        slider = (
            f'<label class="time">t = <output>{times[-1]:.5g} s</output>'
            f'<input type="range" min="0" max="{last}" value="{last}" '
            f'data-chart="{number}" aria-label="time"></label>'
        )
    wide = " wide" if chart.get("wide") else ""
    caption = f"<figcaption>{escape(chart['title'])}</figcaption>"
    return (
        f'<figure class="chart{wide}">{caption}<div '
        f'id="chart{number}"></div>{slider}</figure>'
    )


def section(title: str, body: str, anchor: str) -> str:
    """Return a section with its heading; nothing where it has no content."""
    return (
        f'<section id="{anchor}"><h2>{escape(title)}</h2>{body}</section>'
        if body
        else ""
    )


def table(head: Sequence[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return a table of values; nothing where it has no rows."""
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in rows)
    if not body:
        return ""
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    return f'<div class="scroll"><table><thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table></div>'


def records(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return a table of entries with the same keys, which are its head."""
    rows = list(rows)
    head = [key.replace("_", " ") for key in (rows[0] if rows else ())]
    return table(head, (row.values() for row in rows))


def _cell(value: Any) -> str:
    shown = number(value)
    alignment = " class=number" if isinstance(shown, Number) else ""
    return f"<td{alignment}>{shown}</td>"


def number(value: Any) -> Html:
    """Return a value as text, six digits of a number."""
    if isinstance(value, Html):
        return value
    if isinstance(value, bool) or value is None:
        return Number({True: "yes", False: "no", None: "–"}[value])
    if isinstance(value, int | float):
        return Number(f"{value:.6g}")
    if isinstance(value, list | tuple):
        shown = ", ".join(number(item) for item in value[:8])
        more = f", ... ({len(value)} values)" if len(value) > 8 else ""
        return Number(shown + more)
    return Html(escape(str(value)))


def found(values: Mapping[str, Any]) -> str:
    """Return named results with their units and meanings as a table."""
    rows = (
        _result(name, [value], quantities.unit_of(name))
        for name, value in values.items()
    )
    return table(["result", "value", "unit", "meaning"], rows)


def _result(name: str, cells: Sequence[Any], own_unit: str | None) -> list[Any]:
    """Return the row of a named result with its values in some runs."""
    entry = quantities.result(name)
    meaning = entry.description if entry else ""
    return [code(quantities.name_of(name)), *cells, unit(own_unit), meaning]


def results(runs: Sequence[Run]) -> str:
    """Return the named results of the runs side by side, with the difference to the
    first.
    """
    names = list(
        dict.fromkeys(key for run in runs for key in run.summary.get("qoi", {}))
    )
    rows = []
    for name in names:
        units = (run.summary.get("units", {}).get(name) for run in runs)
        own_unit = next(filter(None, units), "1")
        values = [run.summary.get("qoi", {}).get(name) for run in runs]
        cells = [number(values[0])]
        for value in values[1:]:
            cells.append(Number(number(value) + _difference(value, values[0])))
        rows.append(_result(name, cells, own_unit))
    head = [
        "result",
        *((run.name for run in runs) if len(runs) > 1 else ["value"]),
        "unit",
        "meaning",
    ]
    return table(head, rows)


def _difference(value: Any, first: Any) -> str:
    if (
        not isinstance(value, int | float)
        or not isinstance(first, int | float)
        or not first
        or value == first
    ):
        return ""
    return f' <span class="quiet">{100.0 * (value - first) / abs(first):+.3g} %</span>'


def verdict(run: Run) -> str:
    """Return status, balances, closures out of their range and warnings of a run as
    short lines.
    """
    summary = run.summary
    good = summary.get("status") == "ok"
    lines = [
        f'<span class="{"good" if good else "bad"}">{escape(str(summary.get("status", "unknown")))}</span>'
    ]
    for name, balance in summary.get("balances", {}).items():
        residual = balance.get("relative_residual")
        text = (
            f"balance of {escape(name)} closes to {residual:.2g}"
            if residual is not None
            else f"{escape(name)}: no balance"
        )
        lines.append(f'<span class="good">{text}</span>')
    closures = summary.get("closures", [])
    beyond = [closure for closure in closures if closure.get("share_outside")]
    for closure in beyond:
        share = 100.0 * closure["share_outside"]
        lines.append(
            f'<span class="bad">{escape(closure["name"])} out of its range on '
            f"{share:.3g} %</span>"
        )
    if closures and not beyond:
        lines.append('<span class="good">each closure within its range</span>')
    body = f'<p class="verdict">{" ".join(lines)}</p>'
    return body + _listed(summary.get("warnings", []))


def balances(run: Run) -> str:
    """Return the balances of a run as a table."""
    parts = ("in", "out", "source", "stored", "relative_residual")
    rows = [
        [
            f"{name} [{item['unit']}]" if item.get("unit") else name,
            *map(item.get, parts),
        ]
        for name, item in run.summary.get("balances", {}).items()
    ]
    head = ["balance", *(part.replace("_", " ") for part in parts)]
    return table(head, rows)


def closures(run: Run) -> str:
    """Return the closures of a run with used and declared ranges as a table."""
    rows = []
    for closure in run.summary.get("closures", []):
        for argument, use in closure.get("ranges", {}).items() or [("", None)]:
            used = "" if use is None else quantities.span(use["used"], ".6g")
            declared = "" if use is None else quantities.span(use["declared"], ".6g")
            beyond = use["share_outside"] if use is not None else 0.0
            outside = Html(
                f'<span class="bad">{100 * beyond:.3g} %</span>' if beyond else "none"
            )
            source = closure.get("source", "")
            row = [code(closure["name"]), argument, used, declared, outside, source]
            rows.append(row)
    return table(["closure", "argument", "used", "range", "outside", "source"], rows)


def scene(keys: Sequence[Key]) -> str:
    """Return what a scene gives as a table, and what was left at its defaults below
    it.
    """
    given, left = (
        [
            [code(key.name), Html(number(key.value)), key.unit]
            for key in keys
            if key.default == default
        ]
        for default in (False, True)
    )
    head = ["key", "value in SI", "unit"]
    text = table(head, given)
    if left:
        text += (
            f"<details><summary>{len(left)} keys at their "
            f"defaults</summary>{table(head, left)}</details>"
        )
    return text


def differences(runs: Sequence[Run]) -> str:
    """Return the keys of the scenes that differ between the runs."""
    every = [{key.name: key for key in run.scene_keys()} for run in runs]
    names = list(dict.fromkeys(name for keys in every for name in keys))
    rows = []
    for name in names:
        found = [keys.get(name) for keys in every]
        if (
            len(
                {
                    json.dumps(key.value if key else None, sort_keys=True)
                    for key in found
                }
            )
            > 1
        ):
            own_unit = next((key.unit for key in found if key and key.unit), "")
            cells = [key.value if key else None for key in found]
            rows.append([code(name), *cells, own_unit])
    head = ["key", *(run.name for run in runs), "unit"]
    return table(head, rows)


def built(run: Run) -> str:
    """Return what the run built and left out, with the reasons."""
    rows = [
        [name, item["what"], item["why"]]
        for key, name in (("built", "built"), ("skipped", "left out"))
        for item in run.summary.get(key, [])
    ]
    return table(["", "what", "why"], rows)


def provenance(run: Run) -> str:
    """Return versions, unknowns, machine and hash of a run."""
    summary = run.summary
    versions, unknowns = summary.get("versions", {}), summary.get("dofs") or {}
    rows = {
        **{f"version of {name}": version for name, version in versions.items()},
        **{f"unknowns of {name}": count for name, count in unknowns.items()},
        "machine": summary.get("host"),
        "begun (UTC)": summary.get("begun"),
        "hash of the scene": key_of(summary.get("scene", {})),
        "wall time [s]": summary.get("timings", {}).get("total"),
        "folder": run.folder,
        "files": summary.get("files", []),
    }
    known = (
        (name, Html(number(value))) for name, value in rows.items() if value is not None
    )
    return table(["", ""], known)
