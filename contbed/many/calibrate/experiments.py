"""Measured values and the runs that predict them: each value with place, time, error
and line of its file.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contbed.arrays import Array, Integers
from contbed.errors import SceneError
from contbed.fields import FIELDS, field, require
from contbed.loading import load
from contbed.many.calibrate.settings import (
    CalibrationFile,
    ExperimentSettings,
    Value,
    experiment_names,
)
from contbed.many.quantities import unit_of_result, why_unknown
from contbed.many.study_file import unit_in
from contbed.many.value_sets import MAGNITUDE, tidy
from contbed.scene.data_table import DataTable, read_table
from contbed.scene.names import nearest_of
from contbed.scene.tables import SceneBase
from contbed.scene.uncertain import share_of
from contbed.scene.units import factor_and_offset, to_si

OUTPUT_POSITION = re.compile(r"output\.positions\[(\d+)\]")
NONE = math.nan


@dataclass(frozen=True)
class Point:
    """A value that a run predicts, in SI.

    t, x : time [s] and position [m] in the profiles; not a number where there is none
    value, error : measured, and its standard error; not a number where nothing was
        measured
    line : "file:line" of the measured value, or of what is predicted
    fitted : it takes part in the fit
    """

    experiment: str
    quantity: str
    unit: str
    t: float = NONE
    x: float = NONE
    value: float = NONE
    error: float = NONE
    line: str = ""
    fitted: bool = False

    @property
    def in_profiles(self) -> bool:
        """Whether the value is one of the profiles, not a named result."""
        return not (math.isnan(self.t) and math.isnan(self.x))


@dataclass(frozen=True)
class Job:
    """One scene that is run for each set of the fitted keys: its file, what loads it
    with other values, the keys set in it, and what it predicts.
    """

    experiment: str
    scene: Path
    make: Callable[[Mapping[str, Any]], SceneBase]
    changes: Mapping[str, Any]
    points: tuple[Point, ...]

    def load(self, keys: Mapping[str, float]) -> SceneBase:
        """Return the scene with these values of the fitted keys.

        Raises
        ------
        SceneError : the scene does not take them
        """
        return self.make({**self.changes, **keys})


class Places(NamedTuple):
    """Rows of a table of measured values that count, with their times [s] and
    positions [m].
    """

    table: DataTable
    rows: Integers
    t: Array
    x: Array


def read_jobs(
    file: CalibrationFile, trust: bool = False, allow_large: bool = False
) -> list[Job]:
    """Read tables and scenes; a job for each scene, those of rows with keys of their
    own one by one.

    Parameters
    ----------
    file : of the calibration
    trust, allow_large : as in `contbed.loading.load`

    Raises
    ------
    SceneError : all mistakes of tables and scenes, with file, line and column
    """
    jobs: list[Job] = []
    problems: list[str] = []
    start = {key.name: tidy(float(key.prior.value(0.0))) for key in file.keys}
    for k, (name, settings) in enumerate(
        zip(experiment_names(file.settings), file.settings.experiment, strict=True)
    ):
        try:
            scene = file.origin.base / settings.scene
            make = partial(load, scene, trust=trust, allow_large=allow_large)
            job_of = partial(Job, name, scene, make)
            base = _loaded(make, {**settings.set, **start})
            for number, job in enumerate(_jobs(file, k, name, settings, base, job_of)):
                _check(file, k, job, start, ends=number == 0)
                jobs.append(job)
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError(problems)
    fitted = sum(point.fitted for job in jobs for point in job.points)
    if fitted < len(file.keys):
        raise SceneError(
            f"{file.origin.at(('keys',))}: {len(file.keys)} keys are to be fitted to "
            f"{fitted} measured values; "
            "leave out keys, or give more data"
        )
    return jobs


def _loaded(make: Callable[[Any], SceneBase], values: Any) -> SceneBase | None:
    """Return a scene; None where mistakes, which are reported with the jobs, or keys
    that rows give keep it from being made.
    """
    try:
        return make(values)
    except SceneError:
        return None


def _jobs(
    file: CalibrationFile,
    k: int,
    name: str,
    settings: ExperimentSettings,
    scene: SceneBase | None,
    job_of: Callable[..., Job],
) -> Iterator[Job]:
    origin = file.origin
    table = read_table(origin.base / settings.file)
    predict_at = origin.at(("experiment", k, "predict"))
    t = table.optional(settings.time, "s")
    x = table.optional(settings.position, "m")
    # a run begins with what is at 0 s
    rows = np.flatnonzero(table.rows_with(settings.where) & ~(t <= 0.0))
    if not len(rows):
        raise SceneError(
            f"{origin.at(('experiment', k, 'where'))}: where: no row of "
            f"{settings.file} fits after 0 s"
        )
    places = Places(table, rows, t, x)
    points = [
        _points(
            name,
            settings,
            value,
            scene,
            places,
            file.origin.at(("experiment", k, "values", j)),
        )
        for j, value in enumerate(settings.values)
    ]
    if settings.keys:
        scenes = [origin.base / settings.scene]
        columns = {
            key: table.column(column, unit_in(scenes, key) or "1")
            for key, column in settings.keys.items()
        }
        extra = tuple(_predicted(name, settings, scene, t, x, predict_at))
        for index, row in enumerate(rows):
            own = {key: float(column[row]) for key, column in columns.items()}
            here = (each[index] for each in points if each[index] is not None)
            yield job_of({**settings.set, **own}, (*here, *extra))
        return
    found = (
        *(point for each in points for point in each if point is not None),
        *_predicted(name, settings, scene, t, x, predict_at),
    )
    changes = dict(settings.set)
    if times := sorted({point.t for point in found if not math.isnan(point.t)}):
        changes["time.times"] = times
    if positions := sorted({point.x for point in found if not math.isnan(point.x)}):
        changes["output.positions"] = positions
    yield job_of(changes, found)


def _points(
    name: str,
    settings: ExperimentSettings,
    value: Value,
    scene: SceneBase | None,
    places: Places,
    where: str,
) -> list[Point | None]:
    """Return the measured values of a column; None in a row where its cell is empty."""
    table, rows, t, x = places
    in_profiles = settings.time is not None or settings.position is not None
    if in_profiles and field(value.quantity) is None:
        hint = nearest_of(value.quantity, list(FIELDS))
        raise SceneError(
            f"{where}: quantity: no profiles have a column '{value.quantity}'; {hint}"
        )
    if not in_profiles:
        _require_result(value.quantity, f"{where}: quantity")
    unit = (
        require(value.quantity).unit
        if in_profiles
        else unit_of_result(value.quantity, scene) or "1"
    )
    measured = table.column(value.column, unit, gaps=True)
    errors = _errors(value, table, measured, unit, where)
    end = settings.until if settings.until is not None else math.inf
    found: list[Point | None] = []
    for row in rows:
        if math.isnan(measured[row]):
            found.append(None)
            continue
        line = f"{table.path.name}:{table.lines[row]}"
        if not errors[row] > 0.0:
            raise SceneError(
                f"{line}: the standard error of '{value.column}' is {errors[row]:g}; "
                "allowed: a number > 0"
            )
        found.append(
            Point(
                name, value.quantity, unit, float(t[row]), float(x[row]), float(measured[row]), float(errors[row]),
                line, not t[row] > end,
            )
        )  # fmt: skip
    return found


def _errors(
    value: Value, table: DataTable, measured: Array, unit: str, where: str
) -> Array:
    """Return standard errors in SI, shape (rows,); differences of temperatures do
    not move with the zero of a scale.
    """
    if value.error_column is not None:
        given = table.column(value.error_column, unit, gaps=True)
        header = table.units[table.names.index(value.error_column)] or "1"
        scale = factor_and_offset(header, unit)
        return given - (scale[1] if scale else 0.0)
    assert value.error is not None, "checked when the file was read"
    if not isinstance(value.error, str):
        return np.full(len(measured), value.error)
    share = share_of(value.error)
    if share is not None:
        return share * np.abs(measured)
    try:
        error = to_si(value.error, unit) - to_si(MAGNITUDE.sub("0 ", value.error), unit)
    except ValueError as wrong:
        raise SceneError(
            f"{where}: error: {wrong}, or a share of the measured value like '5 %'"
        ) from None
    return np.full(len(measured), error)


def _predicted(
    name: str,
    settings: ExperimentSettings,
    scene: SceneBase | None,
    t: Array,
    x: Array,
    at: str,
) -> Iterator[Point]:
    """Yield what is predicted besides the measured values."""
    wanted = settings.predict
    for key in wanted.results:
        _require_result(key, f"{at}: predict")
        yield Point(name, key, unit_of_result(key, scene) or "1", line=at)
    if not wanted.times and not wanted.positions:
        return
    for value in dict.fromkeys(value.quantity for value in settings.values):
        for moment in wanted.times or (
            sorted({float(v) for v in t}) if settings.time else (NONE,)
        ):
            for place in wanted.positions or (
                sorted({float(v) for v in x}) if settings.position else (NONE,)
            ):
                yield Point(name, value, require(value).unit, moment, place, line=at)


def _require_result(name: str, where: str) -> None:
    """Raise SceneError for a name that no run of any scene reports."""
    if why := why_unknown(name):
        raise SceneError(f"{where}: {why}")


def _check(
    file: CalibrationFile, k: int, job: Job, start: Mapping[str, float], ends: bool
) -> None:
    """Raise SceneError for values that the scene does not reach, keys that it does
    not take, `ends` of priors too.
    """
    static = {
        key: value
        for key, value in job.changes.items()
        if key not in ("time.times", "output.positions")
    }
    try:
        scene: Any = job.make({**static, **start})
    except SceneError as error:
        raise SceneError(
            [_relocated(file, k, text) for text in error.problems]
        ) from None
    if ends:
        _check_ends(file, job, static, start)
    time = getattr(scene, "time", None)
    problems = []
    for point in job.points:
        if math.isnan(point.t):
            continue
        if time is None:
            problems.append(
                f"{point.line}: the scene {job.scene.name} is steady; leave out time, "
                "or give it a [time] table"
            )
            break
        if point.t > time.end:
            problems.append(
                f"{point.line}: {point.t:g} s is after the end of the run, time.end = "
                f"{time.end:g} s in "
                f"{job.scene.name}; let the scene run longer, or leave out these rows "
                "with where"
            )
    if problems:
        raise SceneError(problems)
    try:
        job.load(start)
    except SceneError as error:
        raise SceneError(
            [_outside(file, k, job, text) for text in error.problems]
        ) from None


def _check_ends(
    file: CalibrationFile,
    job: Job,
    static: Mapping[str, Any],
    start: Mapping[str, float],
) -> None:
    """Raise SceneError for an even prior with an end that the scene does not take."""
    problems = []
    for key in file.keys:
        if not key.prior.even:
            continue
        for end in (key.prior.low, key.prior.high):
            try:
                job.make({**static, **start, key.name: end})
            except SceneError as error:
                text = error.problems[0].removeprefix("override: ")
                problems.append(
                    f"{key.at}: the prior reaches to values that the scene does not "
                    f"take: {text}"
                )
    if problems:
        raise SceneError(problems)


def _relocated(file: CalibrationFile, k: int, text: str) -> str:
    """Replace an override of a scene in a message by the line of the file of the
    calibration.
    """
    told = text.removeprefix("override: ")
    if told == text:
        return text
    for key in sorted(file.keys, key=lambda key: -len(key.name)):
        if told.startswith(key.name):
            return f"{key.at}: {told}; in the middle of its prior"
    for place in ("set", "keys"):
        for name in getattr(file.settings.experiment[k], place):
            if told.startswith(name):
                return f"{file.origin.at(('experiment', k, place, name))}: {told}"
    return f"{file.origin.at(('experiment', k))}: {told}"


def _outside(file: CalibrationFile, k: int, job: Job, text: str) -> str:
    """Replace a position of the output in a message by the line of the measured
    value.
    """
    found = OUTPUT_POSITION.search(text)
    if found is None:
        return _relocated(file, k, text)
    place = job.changes["output.positions"][int(found[1])]
    point = next(point for point in job.points if point.x == place)
    reason = text.rpartition(": ")[2]
    return (
        f"{point.line}: position {place:g} m: {reason}; leave out these rows with where"
    )
