"""What a run predicts at the measured times and positions, and its named results."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from contbed.errors import SceneError
from contbed.fields import header, name_of
from contbed.many.calibrate.experiments import Point
from contbed.many.quantities import number_of
from contbed.many.tables import row_at
from contbed.result import Result
from contbed.scene.names import nearest

COORDINATES = ("x", "z", "r", "y")  # along the bed, the first that the profiles have


def observe(result: Result, points: Sequence[Point]) -> list[float]:
    """Return the predicted values of points, in SI.

    Raises
    ------
    SceneError : the run has no such result, column, time or position
    """
    return [
        _in_profiles(result, point)
        if point.in_profiles
        else number_of(result.qoi, point.quantity, point.line)
        for point in points
    ]


def _in_profiles(result: Result, point: Point) -> float:
    profiles = result.profiles
    values = profiles.get(header(point.quantity))
    place = point.line
    if values is None:
        known = [name_of(name) for name in profiles]
        raise SceneError(
            f'{place}: the profiles have no "{point.quantity}"; '
            f"{nearest(point.quantity, known)}"
        )
    axis = next(
        (profiles[header(name)] for name in COORDINATES if header(name) in profiles),
        None,
    )
    times = profiles.get(header("t"))
    if math.isnan(point.x) and axis is not None:
        raise SceneError(
            f"{place}: the profiles have positions; give position, the column of the "
            "measured positions"
        )
    if math.isnan(point.x):
        if times is None:
            raise SceneError(f"{place}: the profiles have no times; leave out time")
        return float(np.interp(point.t, times, values))
    if axis is None:
        raise SceneError(
            f"{place}: the profiles of this scene have no positions; leave out position"
        )
    wanted = [(axis, point.x)]
    if not math.isnan(point.t):
        if times is None:
            raise SceneError(f"{place}: the profiles have no times; leave out time")
        wanted.append((times, point.t))
    row, is_there = row_at(*wanted)
    if not is_there:
        raise SceneError(
            f"{place}: the run has no output there; {float(axis[row]):g} m is the "
            "nearest position"
        )
    return float(np.asarray(values)[row])
