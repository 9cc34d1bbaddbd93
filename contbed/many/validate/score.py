"""Prediction of a measured bed, its uncertainty, and its distance from what was
measured.

The deviation of a point is E = predicted - measured. Uncertainties of inputs are
propagated to the prediction to first order, each input moved by its standard
uncertainty to both sides: u_p^2 = sum ((p+ - p-)/2)^2, and so are closures. With the
standard uncertainty u_d of a measured point the deviations are within the uncertainty
if RMS(E) <= 2 RMS(sqrt(u_d^2 + u_p^2)), a coverage of 95 % for normal deviations (ASME
V&V 20-2009). Numerical errors are far below both.
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.closures.binding import scaled
from contbed.errors import SceneError
from contbed.fields import header, name_of
from contbed.many.tables import row_at
from contbed.many.validate import levels, signal
from contbed.many.validate.case import Case
from contbed.many.validate.deviations import Compared, score
from contbed.result import Result
from contbed.runner import run
from contbed.scene.names import nearest


@dataclass(frozen=True)
class Validated:
    """A case that was run; cpu [s]."""

    case: Case
    compared: Compared
    cpu: float
    result: Result

    def to_dict(self) -> dict[str, Any]:
        """Return what summary.json says of the case."""
        settings = self.case.settings
        return {
            "title": settings.title,
            "source": settings.source,
            "licence": settings.licence,
            "quantity": settings.quantity,
            "unit": self.case.unit,
            "scores": [
                asdict(score) | {"within": score.within}
                for score in self.compared.scores
            ],
            "influence": self.compared.influence,
            "qoi": self.compared.reported,
            "cpu_s": self.cpu,
        }


def validate(case: Case, out: Path | None = None) -> Validated:
    """Run a case and its variations; the files of the run itself go to `out`.

    Raises
    ------
    SceneError, ConvergenceError : of the runs
    """
    begin = clock.process_time()
    result = run(case.scene(), out)
    compare = {
        "profiles": profiles,
        "history": profiles,
        "signal": signal.compare,
        "levels": levels.compare,
    }[case.settings.compare]
    compared = compare(case, result)
    return Validated(case, compared, clock.process_time() - begin, result)


def profiles(case: Case, result: Result) -> Compared:
    """Compare a field at measured times and positions, or one value at times;
    uncertainties of inputs are propagated.

    Raises
    ------
    SceneError, ConvergenceError : of the runs
    """
    points, report = case.points, case.settings.report
    predicted = at(case, result, points.t, points.x)
    squares, influence = np.zeros_like(predicted), {}
    for name, runs in _variations(case):
        low, high = (at(case, one, points.t, points.x) for one in runs)
        change = 0.5 * (high - low)
        squares += change**2
        influence[name] = float(np.sqrt(np.mean(change**2)))
    reported: dict[str, Any] = {}
    symbol = case.settings.quantity.partition("_")[0]
    whole = case.settings.compare == "history"
    for x in (np.nan,) if whole else report.positions:
        for t in report.times:
            place = "" if whole else f"_{x:g}m"
            unit = "" if case.unit == "1" else f"_{case.unit.replace('/', '_')}"
            name = f"{symbol}{place}_{t:g}s{unit}"
            reported[name] = float(at(case, result, np.array([t]), np.array([x]))[0])
    band = np.sqrt(squares)
    by_time = case.settings.each == "time"
    of, unit = (points.t, "s") if by_time else (points.x, "m")
    groups = [(f"{value:g} {unit}", of == value) for value in np.unique(of)]
    if whole or (by_time and len(groups) > len(points.value) / 3):
        groups = []  # a time of its own for nearly each point is no group
    scores = [
        score(
            name,
            (predicted - points.value)[chosen],
            case.uncertainty,
            band[chosen],
            case.unit,
        )
        for name, chosen in [*groups, ("all", np.ones(len(of), dtype=bool))]
    ]
    return Compared(predicted, band, scores, reported, influence)


def _variations(case: Case) -> Iterator[tuple[str, list[Result]]]:
    """Yield the name of each uncertain input and closure, and the runs with it one
    standard uncertainty below and above.
    """
    sides = (-1.0, 1.0)
    for key, value, spread in case.uncertain():
        ends = [case.scene(**{key: value + side * spread}) for side in sides]
        yield key, [run(scene) for scene in ends]
    for kind, spread in case.uncertain_closures():
        runs = []
        for side in sides:
            with scaled({kind: 1.0 + side * spread}):
                runs.append(run(case.scene()))
        yield f"closure of kind {kind}", runs


def at(case: Case, result: Result, t: Array, x: Array) -> Array:
    """Return the predicted quantity at times [s] and positions [m] at which the run
    has output, shape (points,).

    Raises
    ------
    SceneError : the run has no profile of the quantity
    """
    profiles, quantity = result.profiles, case.settings.quantity
    values = profiles.get(header(quantity))
    if values is None:
        known = nearest(quantity, [name_of(name) for name in profiles])
        where = case.origin.at(("quantity",))
        raise SceneError(f"{where}: quantity: the run has no '{quantity}'; {known}")
    if case.settings.compare == "history":
        history: Array = np.interp(t, profiles[header("t")], values)
        return history
    axis = profiles[header(getattr(result.plan, "coordinate", "x"))]
    return looked_up(values, profiles[header("t")], axis, t, x)


def looked_up(values: Array, times: Array, axis: Array, t: Array, x: Array) -> Array:
    """Return values of a table at times [s] and positions [m] that are among its
    rows, shape (points,).
    """
    out = np.empty(len(t))
    for k, (moment, place) in enumerate(zip(t, x, strict=True)):
        row, is_there = row_at((times, moment), (axis, place))
        assert is_there, "the scene of a case has output at all its points"
        out[k] = values[row]
    return out
