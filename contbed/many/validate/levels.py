"""Profiles across a bed at several heights, averaged over time, against those of a
run (levels.csv).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.fields import header, name_of
from contbed.many.validate.case import Case
from contbed.many.validate.deviations import Compared, score
from contbed.result import Result

SAME = 1e-6  # relative difference of two heights that are the same


def compare(case: Case, result: Result) -> Compared:
    """Score the profiles of each height, and report those of all heights of the run at
    the measured places.

    `L1` is the sum of the deviations' magnitudes over that of the measured values.

    Raises
    ------
    SceneError : the run has no profile at a measured height
    """
    points, unit = case.points, case.unit
    predicted = np.empty(len(points.value))
    heights = np.unique(points.height)
    groups = [(f"{height:g} m", points.height == height) for height in heights]
    for height, (_, chosen) in zip(heights, groups, strict=True):
        predicted[chosen] = at(case, result, float(height), points.x[chosen])
    band = np.zeros(len(predicted))
    scores, reported = [], dict[str, Any]()
    for name, chosen in [*groups, ("all", np.ones(len(predicted), bool))]:
        deviation = (predicted - points.value)[chosen]
        scores.append(score(name, deviation, case.uncertainty, band[chosen], unit))
        reported[f"L1 of {name}"] = float(
            np.abs(deviation).sum() / np.abs(points.value[chosen]).sum()
        )
    places = np.unique(points.x[groups[0][1]])
    reported["x [m]"] = places.tolist()
    for height in np.unique(result.tables["levels"]["height [m]"]):
        key = f"{case.settings.quantity} at {height:g} m [{unit}]"
        reported[key] = at(case, result, float(height), places).tolist()
    return Compared(predicted, band, scores, reported)


def at(case: Case, result: Result, height: float, x: Array) -> Array:
    """Interpolate the quantity at a height [m] and places [m] across the bed, shape
    (places,).

    Raises
    ------
    SceneError : the scene has no such level
    """
    table = result.tables.get("levels", {})
    quantity = header(case.settings.quantity)
    levels = np.asarray(table.get("height [m]", []))
    row = np.abs(levels - height) <= SAME * max(abs(height), SAME)
    if not row.any() or quantity not in table:
        key = f"output.levels of {case.settings.scene}"
        raise SceneError(
            f"{case.origin.at(('scene',))}: {key}: no profile of {name_of(quantity)} "
            f"at {height:g} m"
        )
    place = np.asarray(table["x [m]"])[row]
    found: Array = np.interp(x, place, np.asarray(table[quantity])[row])
    return found
