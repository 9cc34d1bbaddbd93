"""Salt thermocline fitted to its first hour: what the data tell about the bed, and
what they predict for the second.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from contbed.many.calibrate.calibrate import calibrate
from contbed.many.calibrate.found import Calibrated
from contbed.many.calibrate.write import key_rows
from contbed.many.validate.case import read_case
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
DATA = HERE / "data" / "calibration.toml"
HOUR = 3600.0
# they amplify rounding
NOT_COMPARED = (
    "low of posterior",
    "high of posterior",
    "singular value",
    "combination",
)
FITTED = (0.5, 1.0)  # [h]
KEYS = {
    "key": "",
    "unit": "",
    "fitted": ".5g",
    "standard error": ".3g",
} | dict.fromkeys(
    (
        "low",
        "high",
        "low of profile",
        "high of profile",
        "low of posterior",
        "high of posterior",
    ),
    ".5g",
)


def compute() -> Tables:
    """Fit the first hour, predict the second."""
    with TemporaryDirectory() as out:
        found = calibrate(DATA, out)
    return tables(found)


def reference(hour: float) -> np.ndarray:
    """Measured temperatures [K] at a time, in the order of the file."""
    points = read_case("pacheco_2002").points
    return points.value[np.isclose(points.t, hour * HOUR)]


def tables(found: Calibrated) -> Tables:
    """Keys, combinations, measured points with their predictions, and predictions of
    the second hour.
    """
    p, points = found.prediction, found.points
    form = {
        "t [h]": ".3g",
        "z [m]": ".5g",
        "measured [K]": ".5g",
        "predicted [K]": ".6g",
    } | dict.fromkeys(
        (
            "low [K]",
            "high [K]",
            "low of a measurement [K]",
            "high of a measurement [K]",
        ),
        ".5g",
    )
    rows = [
        [points[k].t / HOUR, points[k].x, None if np.isnan(points[k].value) else points[k].value, p.value[k],
         p.low[k], p.high[k], p.low_measured[k], p.high_measured[k]]
        for k in np.lexsort(([point.x for point in points], [point.t for point in points]))
        if points[k].in_profiles
    ]  # fmt: skip
    names = [key.name for key in found.keys]
    fit = found.fit
    values = np.array([point.value if point.fitted else np.nan for point in points])
    there = np.isfinite(values)
    inside = (p.low_measured[there] <= values[there]) & (
        values[there] <= p.high_measured[there]
    )
    facts = {
        "fitted values": len(found.data.value),
        "chi-square": fit.chi_square,
        "degrees of freedom": fit.freedom,
        "factor of the stated errors": fit.scatter,
        "correlation of neighbours": fit.alike,
        "share of fitted values in the band of a measurement": float(np.mean(inside)),
    }
    for hour in FITTED:
        here = np.array([point.fitted and point.t == hour * HOUR for point in points])
        deviation = p.value[here] - reference(hour)
        facts[f"RMS of the deviations at {hour:g} h [K]"] = float(
            np.sqrt(np.mean(deviation**2))
        )
    return {
        "keys": Table(KEYS, [(row[0], row[1], *row[3:]) for row in key_rows(found)]),
        "combinations": Table(
            {"singular value": ".3g", "combination": ""},
            [[each.singular, each.named(names)] for each in found.combinations],
        ),
        "facts": Table({"quantity": "", "value": ".5g"}, list(facts.items())),
        "points": Table(form, rows),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Fitted and predicted profiles with bands, and the intervals of the keys over
    their priors.
    """
    figure, (profiles, keys) = gallery.figure(
        1, 2, size=(11.0, 4.4), width_ratios=(1.7, 1.0)
    )
    points = tables["points"]
    for k, hour in enumerate(np.unique(points["t [h]"])):
        here = points["t [h]"] == hour
        z, colour = points["z [m]"][here], gallery.PALETTE[k]
        fitted = np.isfinite(points["measured [K]"][here]).any()
        label = f"{hour:g} h" if fitted else f"{hour:g} h, predicted"
        profiles.plot(
            z,
            points["predicted [K]"][here],
            "-" if fitted else "--",
            color=colour,
            label=label,
        )
        for names, alpha in ((("low of a measurement [K]", "high of a measurement [K]"), 0.12),
                             (("low [K]", "high [K]"), 0.3)):  # fmt: skip
            profiles.fill_between(
                z,
                *(points[name][here] for name in names),
                color=colour,
                alpha=alpha,
                lw=0,
            )
        profiles.plot(z, points["measured [K]"][here], "o", ms=3, color=colour)
    profiles.set(xlabel="height [m]", ylabel="temperature of the salt [K]")
    profiles.legend(
        title="bands of 90 %: prediction, measurement",
        title_fontsize=8,
        loc="lower right",
    )
    table = tables["keys"]
    rows = np.arange(len(table))
    for shift, (low, high), label in (
        (-0.2, ("low", "high"), "covariance"),
        (0.0, ("low of profile", "high of profile"), "profile"),
        (0.2, ("low of posterior", "high of posterior"), "posterior"),
    ):
        ends = [table[name] / table["fitted"] for name in (low, high)]
        keys.hlines(
            rows + shift,
            *ends,
            lw=2.5,
            color=gallery.PALETTE[int(5 * (shift + 0.2))],
            label=label,
        )
    keys.plot(np.ones(len(table)), rows, "o", color=gallery.BLACK)
    keys.set_yticks(rows, [str(name) for name in table["key"]])
    keys.set(xlabel="interval of 90 % over the fitted value")
    keys.set_ylim(len(table) - 0.3, -1.2)
    keys.legend(ncols=3, loc="upper center")
    return {"pacheco_calibration": figure}
