"""The report of a calibration: its keys, what the data see of them, warnings and pictures."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from contbed.errors import ContbedError
from contbed.output.folder import SUMMARY
from contbed.report import page

PICTURES = {"fit": "Measured and predicted", "residuals": "Residuals", "keys": "Keys"}
ENDS = ("low", "high", "low of profile", "high of profile", "low of posterior", "high of posterior")


def is_calibration(folder: Path) -> bool:
    """Return whether a folder holds a calibration."""
    try:
        content = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and "calibration" in content


def of_calibration(folder: Path) -> str:
    """Return the report of a calibration.

    Raises
    ------
    ContbedError : a file of it is missing
    """
    found = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    title = str(found["title"] or f"Calibration {Path(found['calibration']).stem}")
    data = found["data"]
    text = (
        f"{data['fitted']} fitted values, chi-square {page.number(data['chi_square'])} of "
        f"{page.number(data['degrees of freedom'])} degrees of freedom; {found['runs']['kept']} runs, "
        f"{found['runs']['failed']} failed; contbed {found['versions'].get('contbed', '?')}"
    )
    if data["kept back"]:
        text += f"; {data['kept back inside of the band']} of {data['kept back']} values kept back are in the band"
    warnings = "".join(f"<li>{escape(warning)}</li>" for warning in found["warnings"])
    parts = [
        f"<header><h1>{escape(title)}</h1><p class=quiet>{escape(text)}</p></header>",
        page.section("Warnings", f'<ul class="warnings">{warnings}</ul>' if warnings else "", "warnings"),
        page.section("Fitted keys, intervals of 90 %", _keys(found["keys"]), "keys"),
        page.section("What the data see", _combinations(found), "combinations"),
        *(page.section(name, _picture(folder / f"{file}.png"), file) for file, name in PICTURES.items()),
    ]
    return page.page(title, parts, [])


def _keys(keys: Mapping[str, Any]) -> str:
    head = ["key", "unit", "prior", "fitted", "standard error", *ENDS]
    rows = [
        [escape(name), escape(about["unit"]), escape(about["prior"]), *(page.number(about[key]) for key in head[3:])]
        for name, about in keys.items()
    ]
    return page.table(head, rows, range(3, len(head)))


def _combinations(found: Mapping[str, Any]) -> str:
    rows = [
        [escape(one["combination"]), page.number(one["singular value"]), "yes" if one["seen"] else "no"]
        for one in found["combinations"]
    ]
    return page.table(["combination, in standard deviations of the priors", "times better known", "seen"], rows, [1])


def _picture(file: Path) -> str:
    try:
        data = b64encode(file.read_bytes()).decode("ascii")
    except OSError as error:
        raise ContbedError(f"{file}: cannot be read: {error.strerror}; run the calibration again") from error
    return f'<img style="max-width:100%" alt="{escape(file.stem)}" src="data:image/png;base64,{data}">'
