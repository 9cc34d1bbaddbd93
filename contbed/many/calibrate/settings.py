"""The file of a calibration: which keys are fitted, to which measured values, and what is predicted.

    title = "Thermocline, first hour"

    [keys]                                     # keys of the scene and what is known of them before
    solid.conductivity = { median = "5 W/m/K", factor = 1.5 }
    flow.velocity = { mean = 5.28e-4, deviation = 1e-5 }
    bed.porosity = { from = 0.2, to = 0.3 }

    [[experiment]]
    name = "discharge"                         # by default the name of the scene's file
    scene = "scene.toml"
    set = { "solid.density" = 2600 }           # keys of the scene in this experiment
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
    keys = { "flow.velocity" = "u" }           # keys of the scene that columns give
    values = [{ quantity = "pressure_drop_Pa", column = "dp", error_column = "dp_error" }]

    [posterior]                                # sampled only if this table is there
    walkers = 20
    steps = 500

`error` is the standard error of a measured value, in its unit or as a share of it, "3 K" or "5 %"; `error_column` is a
column of the table with those of each row. Distributions are those of samples, see `contbed.many.value_sets`. A
quantity with a time or a position is one of the profiles, any other a named result of the run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field

from contbed.errors import SceneError
from contbed.explain import sheets
from contbed.loading import table_of
from contbed.many import value_sets
from contbed.many.distributions import Distribution
from contbed.scene.quantities import Instant, Position, Switch, Table
from contbed.scene.toml_lines import KeyPath, Origin, one_line, parse_key, read


class Value(Table):
    """A measured column and what of the model it is compared with."""

    quantity: str
    column: str
    error: str | None = Field(None, description="standard error, in the unit of the quantity or as a share")
    error_column: str | None = Field(None, description="column with the standard error of each row")


class Predict(Table):
    """What is predicted besides the measured values."""

    times: tuple[Instant, ...] = ()
    positions: tuple[Position, ...] = ()
    results: tuple[str, ...] = ()


class ExperimentSettings(Table):
    """One experiment: its scene and its table."""

    name: str | None = None
    scene: str
    set: dict[str, Any] = Field(default_factory=dict)
    file: str
    where: dict[str, str] = Field(default_factory=dict)
    time: str | None = None
    position: str | None = None
    keys: dict[str, str] = Field(default_factory=dict, description="keys of the scene that columns give, row by row")
    until: Instant | None = None
    values: tuple[Value, ...] = Field(min_length=1)
    predict: Predict = Predict()


class Posterior(Table):
    """Sampling of the posterior distribution."""

    walkers: int = Field(20, ge=4, le=1000)
    steps: int = Field(500, ge=10, le=1_000_000)
    seed: int = Field(0, ge=0)


class Settings(Table):
    """The file of a calibration."""

    kind: ClassVar[str] = "calibration"

    title: str = ""
    keys: dict[str, Any]
    experiment: tuple[ExperimentSettings, ...] = Field(min_length=1)
    posterior: Posterior | None = None
    profiles: Switch = Field(True, description="intervals by profile likelihood, which need further runs")


@dataclass(frozen=True)
class FittedKey:
    """A key that is fitted: its name in the scene, SI unit, prior, and where the file says so."""

    name: str
    unit: str
    prior: Distribution
    at: str

    @property
    def label(self) -> str:
        """Name and unit."""
        return self.name if self.unit == "1" else f"{self.name} [{self.unit}]"


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
    path = Path(path)
    values, origin = read(path)
    settings = table_of(Settings, values, origin)
    problems: list[str] = []

    def say(path: KeyPath, text: str) -> None:
        problems.append(one_line(f"{origin.at(path)}: {text}"))

    keys = tuple(_keys(settings.keys, origin, say))
    if not keys and not problems:
        say(("keys",), "keys: empty; give what is fitted, solid.conductivity = { median = 5.0, factor = 1.5 }")
    for k, experiment in enumerate(settings.experiment):
        _check(k, experiment, origin, [key.name for key in keys], say)
    if settings.posterior is not None and settings.posterior.walkers < 2 * len(keys):
        say(
            ("posterior", "walkers"), f"posterior.walkers: at least twice the number of keys is needed, {2 * len(keys)}"
        )
    names = experiment_names(settings)
    for k, name in enumerate(names):
        if name in names[:k]:
            say(("experiment", k), f'experiment {k + 1} is called "{name}" like an earlier one; give it a name')
    if problems:
        raise SceneError(list(dict.fromkeys(problems)))
    return CalibrationFile(path, settings, keys, origin)


def experiment_names(settings: Settings) -> list[str]:
    """Return the names of the experiments."""
    return [each.name or Path(each.scene).stem for each in settings.experiment]


def _keys(table: Mapping[str, Any], origin: Origin, say: Any, above: KeyPath = ()) -> Iterator[FittedKey]:
    for name, entry in table.items():
        path = (*above, name)
        if not value_sets.is_distribution(entry):
            yield from _keys(entry, origin, say, path)
            continue
        key, where = ".".join(map(str, path)), ("keys", *path)
        unit = _unit(key)
        prior = value_sets.distribution(entry, unit, partial(_say_below, say, where, key))
        if prior is not None:
            yield FittedKey(key, unit or "1", prior, origin.at(where))


def _say_below(say: Any, where: KeyPath, key: str, below: KeyPath, text: str) -> None:
    say((*where, *below), f"{key}: {text}")


def _unit(key: str) -> str | None:
    try:
        return sheets.unit(parse_key(key))
    except ValueError:  # the scene reports what is wrong with the key
        return None


def _check(k: int, experiment: ExperimentSettings, origin: Origin, keys: list[str], say: Any) -> None:
    at = ("experiment", k)
    for key, name in (("scene", experiment.scene), ("file", experiment.file)):
        if not (origin.base / name).is_file():
            say((*at, key), f'{key}: no such file: "{name}", looked for beside this file')
    for key in (*experiment.set, *experiment.keys):
        if key in keys:
            place = "set" if key in experiment.set else "keys"
            say((*at, place, key), f"{key}: is fitted under [keys], it cannot be given here as well")
    if experiment.keys and (experiment.time or experiment.position):
        say((*at, "keys"), "keys: rows with keys of their own are runs of their own, without time or position")
    if experiment.until is not None and experiment.time is None:
        say((*at, "until"), "until: needs the column of the times, time")
    for j, value in enumerate(experiment.values):
        if (value.error is None) == (value.error_column is None):
            text = 'give the standard error of the measured values, error = "3 K" or "5 %", or else error_column'
            say((*at, "values", j), f"values of {value.quantity}: {text}")
