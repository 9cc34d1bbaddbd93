"""The file summary.json, and its digest on the terminal."""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Iterable, Mapping
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import labelled, name_of, span, unit_in, unit_of
from contbed.output.files import write_text

KEYS = (
    "status",
    "versions",
    "scene",
    "dofs",
    "timings",
    "balances",
    "closures",
    "skipped",
    "warnings",
    "qoi",
)


def write_json(path: Path | str, content: Mapping[str, Any]) -> None:
    """Write strict JSON: the summary's keys in their order, then others; nan and inf
    become null.
    """
    ordered = {key: content[key] for key in KEYS if key in content} | dict(content)
    text = json.dumps(plain(ordered), indent=2, ensure_ascii=False, allow_nan=False)
    write_text(path, text + "\n")


def plain(value: Any) -> Any:
    """Return the value in JSON's own types; nan and inf, which JSON lacks, become
    None.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"JSON cannot hold {type(value).__name__}")


def table(summary: Mapping[str, Any], width: int | None = None) -> str:
    """Return the result of a run as a table: coloured on a terminal, plain text
    elsewhere.

    Parameters
    ----------
    summary : content of summary.json; keys that are absent are left out
    width : characters in a line; that of the terminal if absent, 100 where there is
        none
    """
    from rich.console import Console

    terminal = sys.stdout is not None and sys.stdout.isatty()
    if width is None:
        width = shutil.get_terminal_size().columns if terminal else 100
    out = StringIO()
    console = Console(
        file=out,
        width=width,
        force_terminal=terminal,
        color_system="auto" if terminal else None,
        highlight=False,
    )
    for part in _parts(summary):
        console.print(part)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines())


def _parts(summary: Mapping[str, Any]) -> Iterable[Any]:
    from rich.text import Text

    yield _grid("", [], _head(summary))
    if balances := summary.get("balances"):
        parts = ("in", "out", "source", "stored")
        rows = [
            [
                labelled(name, item.get("unit")),
                *(number_text(item.get(key)) for key in parts),
                number_text(item.get("relative_residual"), ".1e"),
            ]
            for name, item in balances.items()
        ]
        yield _grid("balance", [*parts, "relative residual"], rows)
    if closures := summary.get("closures"):
        yield _grid(
            "closure", ["argument", "used", "range", "outside"], _closure_rows(closures)
        )
    if qoi := summary.get("qoi"):
        units = summary.get("units") or {}
        rows = [
            [
                labelled(name_of(key), _unit(key, units.get(key))),
                number_text(value, ".6g"),
            ]
            for key, value in qoi.items()
        ]
        yield _grid("result", [""], rows)
    for warning in summary.get("warnings") or []:
        yield Text(f"warning: {warning}", style="yellow")


def _head(summary: Mapping[str, Any]) -> list[list[str]]:
    rows = []
    if "status" in summary:
        rows.append(["status", str(summary["status"])])
    dofs = summary.get("dofs")
    if isinstance(dofs, Mapping) and dofs:
        rows.append(
            [
                "unknowns",
                ", ".join(
                    f"{part} {number_text(count, ',')}" for part, count in dofs.items()
                ),
            ]
        )
    elif isinstance(dofs, int | float):
        rows.append(["unknowns", number_text(dofs, ",")])
    if timings := summary.get("timings"):
        phases = (
            f"{phase} {number_text(value, '.3g')} s" for phase, value in timings.items()
        )
        rows.append(["wall time", ", ".join(phases)])
    return rows


def _closure_rows(closures: Iterable[Mapping[str, Any]]) -> list[list[str]]:
    rows = []
    for closure in closures:
        name = closure["name"]
        for argument, use in closure.get("ranges", {}).items():
            share = use["share_outside"]
            outside = f"! {100 * share:.3g} %" if share else "0"
            rows.append(
                [name, argument, span(use["used"]), span(use["declared"]), outside]
            )
            name = ""
        if name:
            rows.append([name, "", "", "", ""])
    return rows


def _grid(title: str, columns: list[str], rows: list[list[str]]) -> Any:
    """Return a table without lines; text is folded rather than cut, and a flagged
    cell is red.
    """
    from rich.table import Table
    from rich.text import Text

    grid = Table(
        box=None,
        pad_edge=False,
        padding=(0, 2, 0, 0),
        show_header=bool(title),
        header_style="bold",
    )
    for k, name in enumerate([title, *(columns or [""])]):
        text = k == 0 or name in ("", "argument")
        grid.add_column(name, justify="left" if text else "right", overflow="fold")
    for row in rows:
        grid.add_row(
            *(
                Text(cell, style="bold red" if cell.startswith("!") else "")
                for cell in row
            )
        )
    return grid


def _unit(key: str, own: str | None) -> str | None:
    """Return the unit in a name, "power [W]", its `own` in a run, J/m2 on a line, or
    that of its field; None where the unit ends the name.
    """
    unit = own or unit_of(key)
    return unit_in(key) or (None if key.endswith(f"_{unit}") else unit)


def number_text(value: Any, style: str = ".4g") -> str:
    """Return a number or a list of numbers as text; a missing one is a dash, and
    anything else is shown as it is.
    """
    if value is None:
        return "-"
    if isinstance(value, list):
        shown = ", ".join(number_text(item, style) for item in value[:8])
        return f"{shown}, ... ({len(value)} values)" if len(value) > 8 else shown
    return (
        format(value, style)
        if isinstance(value, int | float | np.number)
        else str(value)
    )
