"""Files of a calibration: tables of keys, points, combinations, profiles and
samples, summary, calibrated scenes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fields import labelled
from contbed.many.calibrate.fit import COVERAGE
from contbed.many.calibrate.found import Calibrated
from contbed.many.calibrate.settings import experiment_names
from contbed.many.tables import Row, aligned, scene_text, write_rows
from contbed.output.files import write_text
from contbed.output.summary import write_json
from contbed.output.tables import write_table
from contbed.output.versions import versions

NAMES = (
    *("keys.csv", "points.csv", "combinations.csv", "posterior.csv", "summary.json"),
    *("profiles/*.csv", "calibrated*.toml", "fit.png", "residuals.png", "keys.png"),
)


def write(found: Calibrated, out: Path) -> None:
    """Write all files but the plots."""
    write_rows(
        out / "keys.csv",
        _HEAD,
        key_rows(found),
        _cell,
    )
    write_rows(out / "points.csv", POINTS, point_rows(found), _cell)
    names = [key.name for key in found.keys]
    write_rows(
        out / "combinations.csv",
        ("singular value", "seen", "combination", *names),
        (
            [each.singular, each.seen, each.named(names), *each.weights]
            for each in found.combinations
        ),
        _cell,
    )
    for key in found.keys:
        if key.name in found.intervals:
            curve = found.intervals[key.name].curve
            columns = {
                key.label: key.prior.value(curve[:, 0]),
                "rise of chi-square [1]": curve[:, 1],
            }
            write_table(out / "profiles" / f"{key.name}.csv", columns)
    if found.samples is not None:
        each = {
            key.label: key.prior.value(found.samples.z[:, k])
            for k, key in enumerate(found.keys)
        }
        write_table(out / "posterior.csv", each)
    for name, text in scenes(found, out).items():
        write_text(out / name, text)
    write_json(out / "summary.json", summary(found))


_HEAD = (
    "key",
    "unit",
    "prior",
    "fitted",
    "standard error",
    "low",
    "high",
    "low of profile",
    "high of profile",
    "low of posterior",
    "high of posterior",
)
POINTS = (
    "experiment", "line", "quantity", "unit", "t [s]", "x [m]", "fitted", "measured", "error", "predicted",
    "standard error", "low", "high", "low of a measurement", "high of a measurement", "deviation over error",
)  # fmt: skip


def key_rows(found: Calibrated) -> list[Row]:
    """Return a row for each key, in SI: fitted value, standard error, ends of the
    intervals; open ends are empty.
    """
    rows: list[Row] = []
    for k, key in enumerate(found.keys):
        z, prior = float(found.fit.z[k]), key.prior
        error = math.sqrt(found.fit.covariance[k, k])
        half = found.fit.quantile * error
        ends = [
            float(prior.value(float(np.clip(z + side * half, *prior.bounds))))
            for side in (-1.0, 1.0)
        ]
        interval = found.intervals.get(key.name)
        profile: list[float | None] = [None, None]
        if interval is not None:
            profile = [
                None if interval.open_low else float(prior.value(interval.low)),
                None if interval.open_high else float(prior.value(interval.high)),
            ]
        posterior: list[float | None] = [None, None]
        if found.samples is not None:
            tail = 0.5 * (1.0 - COVERAGE)
            posterior = [
                float(prior.value(q))
                for q in np.quantile(found.samples.z[:, k], (tail, 1.0 - tail))
            ]
        ordered = [_sorted(pair, prior.slope(z)) for pair in (ends, profile, posterior)]
        rows.append(
            (key.name, key.unit, str(prior), float(prior.value(z)), abs(prior.slope(z)) * error,
             *(end for pair in ordered for end in pair))
        )  # fmt: skip
    return rows


def _sorted(pair: Sequence[float | None], slope: float) -> list[float | None]:
    """Return the ends from below; a negative key falls where its scaled one rises."""
    return list(pair) if slope > 0.0 else list(pair)[::-1]


def point_rows(found: Calibrated) -> Iterable[Row]:
    """Yield a row for each predicted value, in SI."""
    p = found.prediction
    for k, point in enumerate(found.points):
        yield (
            point.experiment, point.line, point.quantity, point.unit, point.t, point.x, point.fitted, point.value,
            point.error, p.value[k], p.deviation[k], p.low[k], p.high[k], p.low_measured[k], p.high_measured[k],
            (p.value[k] - point.value) / point.error,
        )  # fmt: skip


def summary(found: Calibrated) -> dict[str, Any]:
    """Return the content of summary.json."""
    names = [key.name for key in found.keys]
    slopes = np.array(
        [
            key.prior.slope(float(z))
            for key, z in zip(found.keys, found.fit.z, strict=True)
        ]
    )
    kept = [
        k
        for k, point in enumerate(found.points)
        if not point.fitted and not math.isnan(point.value)
    ]
    p = found.prediction
    inside = [
        p.low_measured[k] <= found.points[k].value <= p.high_measured[k] for k in kept
    ]
    return {
        "status": "ok" if found.fit.converged else "not converged",
        "versions": versions(),
        "calibration": found.file.path.name,
        "title": found.file.settings.title,
        "warnings": found.warnings,
        "keys": {
            row[0]: dict(zip(_HEAD[1:], row[1:], strict=True))
            for row in key_rows(found)
        },
        "coverage": COVERAGE,
        "covariance": {
            "keys": names,
            "matrix": found.fit.covariance * np.outer(slopes, slopes),
        },
        "correlation": found.fit.correlation,
        "combinations": [
            {
                "singular value": each.singular,
                "seen": each.seen,
                "combination": each.named(names),
            }
            for each in found.combinations
        ],
        "data": {
            "fitted": len(found.data.value),
            "chi_square": found.fit.chi_square,
            "degrees of freedom": found.fit.freedom,
            "factor of the stated errors": found.fit.scatter,
            "correlation of neighbours": found.fit.alike,
            "kept back": len(kept),
            "kept back inside of the band": int(sum(inside)),
        },
        "posterior": None
        if found.samples is None
        else {
            "samples": len(found.samples.z),
            "acceptance": found.samples.acceptance,
            "autocorrelation in steps": found.samples.autocorrelation,
        },
        "runs": {
            "kept": found.runs,
            "before": found.before,
            "failed": len(found.failed),
        },
        "failed": [
            {"exit_code": each["exit_code"], "problem": each["problem"]}
            for each in found.failed
        ],
    }


def scenes(found: Calibrated, out: Path) -> dict[str, str]:
    """Return the text of the scene of each experiment with its fitted keys, by the
    name of its file.
    """
    first = {job.experiment: job for job in reversed(found.jobs)}
    texts = {}
    for name, settings in zip(
        experiment_names(found.file.settings),
        found.file.settings.experiment,
        strict=True,
    ):
        job = first[name]
        file = "calibrated.toml" if len(first) == 1 else f"calibrated_{name}.toml"
        texts[file] = scene_text(
            job.scene, job.load(found.values), {**settings.set, **found.values}, out
        )
    return texts


def table(found: Calibrated) -> str:
    """Return the fitted keys as a table for a terminal."""
    head = ("key", "fitted", "standard error", "90 % from", "to", "prior")
    rows = [head]
    for name, unit, prior, value, error, low, high, *_ in key_rows(found):
        rows.append(
            (
                labelled(name, unit),
                *(f"{number:.5g}" for number in (value, error, low, high)),
                prior,
            )
        )
    lines = aligned(rows, left=(0, 5))
    names = [key.name for key in found.keys]
    fit = found.fit
    lines += [
        "",
        f"{len(found.data.value)} values, chi-square {fit.chi_square:.4g} of "
        f"{fit.freedom:.4g} degrees of freedom",
    ]
    for each in found.combinations:
        told = (
            f"known {each.singular:.3g} times better than by the prior"
            if each.seen
            else "not seen by the data"
        )
        lines.append(f"{told}: {each.named(names)}")
    kept = summary(found)["data"]
    if kept["kept back"]:
        share = f"{kept['kept back inside of the band']} of {kept['kept back']}"
        lines.append(
            f"{share} values that were not fitted are in the 90 % band of a measurement"
        )
    return "\n".join(lines)


def _cell(value: Any) -> Any:
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.12g}"
    return "" if value is None else value
