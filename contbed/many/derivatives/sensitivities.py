"""The command `contbed sensitivities`: derivatives of named results as a table, as CSV
and JSON, and as a picture.

Derivatives stand in the unit of the result over the SI unit of the key. The relative
derivative d ln result/d ln key is the change of the result in percent for one percent
of the key; rows are in the order of its size.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.fields import behind
from contbed.many.derivatives.gradients import Gradient, gradient, require_known
from contbed.many.derivatives.keys import continuous, key
from contbed.many.quantities import unit_of_result
from contbed.many.tables import aligned, write_rows
from contbed.output.plots import styled_figure
from contbed.output.summary import write_json
from contbed.output.versions import versions
from contbed.scene.names import several
from contbed.scene.tables import SceneBase

MOST_BARS = 12  # of a panel
SMALLEST_BAR = 1e-3  # of the largest; smaller ones cannot be seen
BAR = 0.24  # inches
DIGITS = 5
# name of the table, of the data and of the picture in the folder
FILE = "sensitivities"
HOW = {
    "tangent": "by the tangent of the solution, mesh and discretisation kept",
    "differences": "by differences of runs",
}


def sensitivities(
    scene: SceneBase,
    qoi: str | Sequence[str],
    keys: str | Sequence[str] = (),
    engine: str = "skfem",
) -> tuple[Gradient, dict[str, Any]] | None:
    """Return the gradient of a scene, and the same as plain data with units; None on
    all ranks but the first.

    Parameters
    ----------
    qoi : named results
    keys : keys of the scene; all continuous ones that it gives if empty, which leaves
        out defaults and settings of the numerical method
    engine : as of `contbed.run`

    Raises
    ------
    SceneError : see `contbed.many.derivatives.gradients.gradient`; or the scene gives
        no continuous key
    """
    results = several(qoi)
    require_known(results)
    names = several(keys) or several(one.name for one in continuous(scene))
    if not names:
        raise SceneError(
            f"{scene.origin.name}: the scene gives no continuous key; name one by --to"
        )
    found = gradient(scene, results, names, engine)
    if found is None:
        return None
    units = [key(scene, name).unit for name in found.keys]
    return found, {
        "title": scene.title,
        "versions": versions(),
        "method": found.method,
        "qoi": {
            name: {"value": value, "unit": unit_of_result(name, scene) or "1"}
            for name, value in zip(found.qoi, found.values, strict=True)
        },
        "keys": {
            name: {"value": value, "unit": unit}
            for name, value, unit in zip(found.keys, found.at, units, strict=True)
        },
        "derivatives": found.derivatives,
        "relative": found.logarithmic,
        "standard_errors": found.standard_errors,
        "notes": list(found.notes),
    }


def order(found: Gradient, result: int) -> list[int]:
    """Return the numbers of the keys by the size of their relative derivative, those
    without one last.
    """
    weights = np.abs(found.logarithmic[result])
    return sorted(
        range(len(found.keys)),
        key=lambda k: (not np.isfinite(weights[k]), -np.nan_to_num(weights[k]), k),
    )


def table(found: Gradient, about: dict[str, Any]) -> str:
    """Return the derivatives as a table for each result, and the notes."""
    lines = []
    for i, name in enumerate(found.qoi):
        unit = about["qoi"][name]["unit"]
        rows = []
        for _, key_name, value, below, slope, own, relative, error in _rows(
            found, about, i
        ):
            shown = value and relative is not None
            row = [
                key_name,
                f"{value:.{DIGITS}g}{behind(below)}",
                f"{slope:.{DIGITS}g}{behind(own)}",
                f"{relative:.{DIGITS - 2}g}" if shown else "-",
            ]
            rows.append(row if error is None else [*row, f"{error:.2g}"])
        head = ["key", "value", f"d {name}/d key", "relative"]
        head += ["standard error"] if found.standard_errors is not None else []
        lines.append(f"{name} = {found.values[i]:.{DIGITS}g}{behind(unit)}")
        lines += [f"  {line}" for line in aligned([head, *rows], left=range(len(head)))]
        lines.append("")
    lines.append(
        f"derivatives {HOW[found.method]}; relative: percent of the result for one "
        "percent of the key"
    )
    return "\n".join([*lines, *(f"note: {note}" for note in found.notes)])


def quotient(above: str, below: str) -> str:
    """Return the unit of a derivative.

    >>> quotient("K", "m/s"), quotient("1", "m"), quotient("Pa", "1"), quotient("K", "K")
    ('K/(m/s)', '1/m', 'Pa', '1')
    """
    if above == below:
        return "1"
    if below == "1":
        return above
    return (
        f"{above}/({below})"
        if any(sign in below for sign in "/*")
        else f"{above}/{below}"
    )


def write(found: Gradient, about: dict[str, Any], out: Path, title: str) -> None:
    """Write sensitivities.csv, sensitivities.json and sensitivities.png."""
    write_json(out / f"{FILE}.json", about)
    head = (
        "result",
        "key",
        "value",
        "unit",
        "derivative",
        "unit of derivative",
        "relative",
        "standard error",
    )
    rows = [row for i in range(len(found.qoi)) for row in _rows(found, about, i)]
    write_rows(out / f"{FILE}.csv", head, rows)
    tornado(out / f"{FILE}.png", found, title)


def _rows(found: Gradient, about: dict[str, Any], i: int) -> Iterator[list[Any]]:
    """Yield the rows of the table of one result."""
    name, errors = found.qoi[i], found.standard_errors
    for j in order(found, i):
        unit = about["keys"][found.keys[j]]["unit"]
        own = quotient(about["qoi"][name]["unit"], unit)
        relative = float(found.logarithmic[i, j])
        row = [name, found.keys[j], found.at[j], unit, found.derivatives[i, j], own]
        yield [
            *row,
            relative if np.isfinite(relative) else None,
            None if errors is None else errors[i, j],
        ]


def tornado(path: Path, found: Gradient, title: str) -> None:
    """Draw the relative derivatives as bars, the largest on top, a panel for each
    result.
    """
    weights = np.nan_to_num(np.abs(found.logarithmic))
    shown = [
        [
            j
            for j in order(found, i)[:MOST_BARS]
            if weights[i, j] > SMALLEST_BAR * weights[i].max()
        ]
        for i in range(len(found.qoi))
    ]
    heights = [max(len(keys), 1) * BAR + 0.9 for keys in shown]
    with styled_figure(path, sum(heights) + 0.3, title) as figure:
        panels = figure.subplots(len(shown), 1, squeeze=False, height_ratios=heights)[
            :, 0
        ]
        for i, (panel, keys) in enumerate(zip(panels, shown, strict=True)):
            values = np.nan_to_num(found.logarithmic[i, keys])
            errors = None
            if found.standard_errors is not None:
                relative = found.standard_errors[i] * found.at / found.values[i]
                errors = np.where(np.isfinite(relative), np.abs(relative), 0.0)[keys]
            colours = ["#0072B2" if value >= 0.0 else "#D55E00" for value in values]
            panel.barh(range(len(keys)), values, color=colours, height=0.7, xerr=errors)
            panel.set_yticks(range(len(keys)), [found.keys[j] for j in keys])
            panel.invert_yaxis()
            panel.axvline(0.0, color="black", linewidth=0.6)
            panel.set_xlabel(f"d ln {found.qoi[i]} / d ln key")
