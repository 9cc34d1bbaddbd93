"""The report of a calibration: its keys, what the data see of them, warnings and
pictures.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from contbed.report import page
from contbed.report.linked import Column, Linked, linked, read_columns, table_of
from contbed.report.study import Content, Found, Study, has

PICTURES = {"fit": "Measured and predicted", "residuals": "Residuals", "keys": "Keys"}
MOST_SAMPLES = 2000  # of a posterior in linked plots, which more make slow
# columns of points.csv
NUMBERS = ("t", "x", "measured", "predicted", "low", "high", "deviation over error")
TEXTS = ("experiment", "line", "quantity", "unit", "fitted")


def _content(folder: Path, found: Found, made: page.Charts) -> Content:
    points = read_columns(folder / "points.csv", TEXTS, NUMBERS)
    keys = read_columns(folder / "keys.csv", ("key", "unit"))
    combinations = read_columns(folder / "combinations.csv")
    data = found["data"]
    about = (
        f"{data['fitted']} fitted values, chi-square {page.number(data['chi_square'])} "
        "of "
        f"{page.number(data['degrees of freedom'])} degrees of freedom; "
        f"{found['runs']['kept']} runs, "
        f"{found['runs']['failed']} failed"
    )
    if data["kept back"]:
        about += (
            f"; {data['kept back inside of the band']} of {data['kept back']} "
            "values kept back are in the band"
        )
    sections = [
        page.warnings(found["warnings"]),
        page.section("Fitted keys, intervals of 90 %", table_of(keys.values()), "keys"),
        page.section(
            "Covariance of the keys, and correlation",
            _covariance(found, keys),
            "covariance",
        ),
        page.section(
            "What the data see: combinations in standard deviations of the priors",
            table_of(combinations.values()),
            "combinations",
        ),
        *(
            page.section(name, page.picture(folder / f"{file}.png"), file)
            for file, name in PICTURES.items()
        ),
        _compared(points).section("Linked plots", made.place),
        *_posterior(folder / "posterior.csv", found, made),
        page.section(
            "All predicted values, in SI, bands of 90 %",
            table_of(points.values()),
            "points",
        ),
    ]
    title = found["title"] or f"Calibration {Path(found['calibration']).stem}"
    return Content(str(title), about, sections)


def _covariance(found: Found, keys: Mapping[str, Column]) -> str:
    """Return covariance in the units of the keys, and correlation, as two tables."""
    names = found["covariance"]["keys"]
    units = dict(zip(keys["key"].values, keys["unit"].values, strict=True))
    labels = [Column(name, units[name], ()).label for name in names]
    both = (
        ("covariance", found["covariance"]["matrix"]),
        ("correlation", found["correlation"]),
    )
    return "".join(
        page.table(
            [what, *labels],
            ([label, *row] for label, row in zip(labels, matrix, strict=True)),
        )
        for what, matrix in both
    )


def _names(points: Mapping[str, Column]) -> list[str]:
    """Return experiment and line of each value."""
    pairs = zip(points["experiment"].values, points["line"].values, strict=True)
    return [f"{experiment}, {line}" for experiment, line in pairs]


def _compared(points: Mapping[str, Column]) -> Linked:
    """Return linked plots of the measured values; their standard errors and bands
    are in the table.
    """
    shown = (
        "experiment",
        "quantity",
        "t",
        "x",
        "fitted",
        "measured",
        "predicted",
        "deviation over error",
    )
    there = [
        k for k, value in enumerate(points["measured"].values) if value is not None
    ]
    columns = [
        Column(name, points[name].unit, tuple(points[name].values[k] for k in there))
        for name in shown
    ]
    names = _names(points)
    return linked(columns, [names[k] for k in there])


def _posterior(file: Path, found: Found, made: page.Charts) -> list[str]:
    """Return the section of the samples of the keys where there is a posterior."""
    if found["posterior"] is None:
        return []
    columns = list(read_columns(file).values())
    count = len(columns[0].values)
    every = range(0, count, max(1, math.ceil(count / MOST_SAMPLES)))
    drawn = [Column(c.name, c.unit, tuple(c.values[k] for k in every)) for c in columns]
    title = f"Samples of the posterior, {len(every)} of {count}"
    return [
        linked(drawn, [f"sample {k + 1}" for k in every]).section(
            title, made.place, "posterior"
        )
    ]


CALIBRATION = Study("calibration", "calibrate", _content, has("calibration"))
