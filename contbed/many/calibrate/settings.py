"""The file of a calibration: which keys are fitted, to which measured values, and what
is predicted.

    title = "Thermocline, first hour"

    [keys]                                     # keys of the scene and what is known of them before
    solids.rock.conductivity = { median = "5 W/m/K", factor = 1.5 }
    boundary.right.gas.velocity = { mean = 5.28e-4, deviation = 1e-5 }
    packed_bed.porosity = { from = 0.2, to = 0.3 }

    [[experiment]]
    name = "discharge"                         # by default the name of the scene's file
    scene = "scene.toml"
    set = { "solids.rock.density" = 2600 }           # keys of the scene in this experiment
    file = "measured.csv"
    where = { kind = "exp" }                   # rows with these texts only
    time = "time"                              # columns with time and place of a measured value, with their units
    position = "z"
    until = "1 h"                              # later values are not fitted; they are compared with the prediction
    values = [{ quantity = "T_fluid", column = "T_fluid", error = "3 K" }]
    predict = { times = ["2 h"], positions = [0.5, 1.0], results = ["T_fluid_out_K"] }

    [[experiment]]                             # a run for each row
    scene = "drop.toml"
    file = "drops.csv"
    keys = { "boundary.left.gas.velocity" = "u" }           # keys of the scene that columns give
    values = [{ quantity = "pressure_drop_Pa", column = "dp", error_column = "dp_error" }]

    [posterior]                                # sampled only if this table is there
    walkers = 20
    steps = 500

`error` is the standard error of a measured value, "3 K", a number in SI, or a share of
the value, "5 %"; `error_column` is a column of the table with those of each row.
Distributions are those of samples, see `contbed.many.value_sets`. A quantity with a
time or a position is one of the profiles, any other a named result of the run.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field

from contbed.fields import labelled
from contbed.many import value_sets
from contbed.many.distributions import Distribution
from contbed.many.study_file import StudyFile, unit_in
from contbed.scene.quantities import Instant, Position, Switch, Table
from contbed.scene.reactions import Parameter
from contbed.scene.toml_lines import Origin


class Value(Table):
    """A measured column and what of the model it is compared with."""

    quantity: str
    """result of the run that is compared"""
    column: str
    """column of measured values"""
    error: Parameter | None = None
    """standard error: "3 K", a number in SI, or "5 %" of the measured value"""
    error_column: str | None = None
    """column with the standard error of each row"""


class Predict(Table):
    """What is predicted besides the measured values."""

    times: tuple[Instant, ...] = ()
    """times of the prediction"""
    positions: tuple[Position, ...] = ()
    """positions of the prediction"""
    results: tuple[str, ...] = ()
    """results that are predicted"""


class ExperimentSettings(Table):
    """One experiment: its scene and its table."""

    name: str | None = None
    """name of the experiment in tables and plots"""
    scene: str
    """scene file of the experiment, path relative to this file"""
    set: dict[str, Any] = Field(default_factory=dict)
    """values of scene keys in this experiment"""
    file: str
    """table of measured values, path relative to this file"""
    where: dict[str, str] = Field(default_factory=dict)
    """values of columns that select rows"""
    time: str | None = None
    """column of times"""
    position: str | None = None
    """column of positions along the bed, as in profiles.csv"""
    keys: dict[str, str] = Field(default_factory=dict)
    """keys of the scene that columns give, row by row"""
    until: Instant | None = None
    """last time that is fitted; later rows are kept for comparison"""
    values: tuple[Value, ...] = Field(min_length=1)
    """measured columns and the results that they are compared with"""
    predict: Predict = Predict()
    """results that are predicted with bands"""


class Posterior(Table):
    """Sampling of the posterior distribution."""

    walkers: int = Field(20, ge=4, le=1000)
    """number of walkers"""
    steps: int = Field(500, ge=10, le=1_000_000)
    """steps of each walker"""
    seed: int = Field(0, ge=0)
    """seed of the sampling"""


class Settings(Table):
    """The file of a calibration."""

    kind: ClassVar[str] = "calibration"

    title: str = ""
    """title of the study, shown in plots and reports"""
    keys: dict[str, Any]
    """keys of the scene that are fitted, each with its prior"""
    experiment: tuple[ExperimentSettings, ...] = Field(min_length=1)
    """experiments with scene, table and measured columns"""
    posterior: Posterior | None = None
    """sampling of the posterior by Markov chains; absent: linearised intervals only"""
    profiles: Switch = True
    """intervals by profile likelihood, which need further runs"""


@dataclass(frozen=True)
class FittedKey:
    """A key that is fitted: its name in the scene, SI unit, prior, and where the
    file says so.
    """

    name: str
    unit: str
    prior: Distribution
    at: str

    @property
    def label(self) -> str:
        """Name and unit."""
        return labelled(self.name, self.unit)


@dataclass(frozen=True)
class CalibrationFile:
    """The content of the file of a calibration."""

    path: Path
    settings: Settings
    keys: tuple[FittedKey, ...]
    origin: Origin


def read_file(path: str | Path) -> CalibrationFile:
    """Read the file of a calibration, without its scenes and tables.

    Raises
    ------
    SceneError : all its mistakes, with file and line
    """
    file = StudyFile(path, Settings)
    settings, origin = file.settings, file.origin
    keys = tuple(_keys(file))
    if not keys and not file.problems:
        file.say(
            ("keys",),
            "empty; give what is fitted, solid.conductivity = { median = 5.0, factor = "
            "1.5 }",
        )
    for k in range(len(settings.experiment)):
        _check(file, k, [key.name for key in keys])
    if settings.posterior is not None and settings.posterior.walkers < 2 * len(keys):
        file.say(
            ("posterior", "walkers"),
            f"at least twice the number of keys is needed, {2 * len(keys)}",
        )
    names = experiment_names(settings)
    for k, name in enumerate(names):
        if name in names[:k]:
            file.say(
                ("experiment", k),
                f'"{name}" is the name of an earlier one; give it another',
            )
    file.stop()
    return CalibrationFile(file.path, settings, keys, origin)


def experiment_names(settings: Settings) -> list[str]:
    """Return the names of the experiments."""
    return [each.name or Path(each.scene).stem for each in settings.experiment]


def _keys(file: StudyFile[Settings]) -> Iterator[FittedKey]:
    scenes = [file.origin.base / each.scene for each in file.settings.experiment]
    for name, path, entry in file.entries(
        ("keys",), file.settings.keys, value_sets.is_distribution, {}
    ):
        unit = unit_in(scenes, name)
        prior = value_sets.distribution(entry, unit, file.say_below(path, name))
        if prior is not None:
            yield FittedKey(name, unit or "1", prior, file.origin.at(path))


def _check(file: StudyFile[Settings], k: int, keys: list[str]) -> None:
    """Note the mistakes of an experiment."""
    at, experiment = ("experiment", k), file.settings.experiment[k]
    file.file((*at, "scene"), experiment.scene)
    file.file((*at, "file"), experiment.file)
    for key in (*experiment.set, *experiment.keys):
        if key in keys:
            place = "set" if key in experiment.set else "keys"
            file.say(
                (*at, place, key),
                "is fitted under [keys], it cannot be given here as well",
                key,
            )
    if experiment.keys and (experiment.time or experiment.position):
        text = (
            "rows with keys of their own are runs of their own, without time or "
            "position"
        )
        file.say((*at, "keys"), text, "keys")
    if experiment.until is not None and experiment.time is None:
        file.say((*at, "until"), "needs the column of the times, time", "until")
    for j, value in enumerate(experiment.values):
        if (value.error is None) == (value.error_column is None):
            text = (
                'give the standard error of the measured values, error = "3 K" or '
                '"5 %", or else error_column'
            )
            file.say((*at, "values", j), text, f"values of {value.quantity}")
