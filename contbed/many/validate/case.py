"""A measured bed: a folder with the scene, the measured table and case.toml, which says
what is compared with what.

title = "Molten-salt thermocline, discharge"
source = "Pacheco, Showalter & Kolb (2002), doi:10.1115/1.1464123"
licence = "numbers read from a published figure"
scene = "scene.toml"
quantity = "T_fluid"                    # column of the profiles, and first part of the names of what is reported
uncertainty = "3 K"                     # standard uncertainty of a measured point
each = "time"                           # a score for each "time" or each "position"
compare = "profiles"                    # or "history" of one value, "signal" with a [signal], "levels"
[measured]
file = "measured.csv"
column = "T_fluid"                      # with its unit in the header; so are the next two
time = "time"
position = "z"                          # the coordinate of the scene along the bed
where = { kind = "exp" }                # rows with these texts only
[report]                                # predictions that are reported by name: T_0.073m_1000s_K
positions = [0.073]
times = [1000, 2000]
[uncertain]                             # standard uncertainty of inputs of the scene, in SI or as a share
packed_bed.porosity = 0.01
solid.conductivity = "20 %"
[uncertain_closures]                    # that of the closures of a kind, as a share of their value
conductivity = "9 %"
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field

from contbed.arrays import Array
from contbed.closures import registry
from contbed.errors import SceneError
from contbed.fields import FIELDS, field, require
from contbed.loading import load
from contbed.many.study_file import StudyFile
from contbed.scene.data_table import read_table
from contbed.scene.identity import resolved
from contbed.scene.names import nearest
from contbed.scene.quantities import Instant, Position, Switch, Table
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import Origin
from contbed.scene.uncertain import share_of, uncertain_numbers
from contbed.scene.units import to_si

SHIPPED = Path(__file__).parent / "cases"


class Measured(Table):
    """The measured table."""

    file: str
    """table of measured values, path relative to this file"""
    column: str
    """column of measured values"""
    time: str | None = None
    """column of times"""
    position: str | None = None
    """column of positions"""
    height: str | None = None
    """of levels"""
    where: dict[str, str] = Field(default_factory=dict)
    """rows with these texts in these columns only"""


class Report(Table):
    """Positions and times at which the prediction is reported by name."""

    positions: tuple[Position, ...] = ()
    """positions of the reported profiles"""
    times: tuple[Instant, ...] = ()
    """times of the reported profiles"""


class Signal(Table):
    """A column of profiles.csv over time whose statistics are compared."""

    column: str
    """column of the signal"""
    start: Instant = 0.0
    """from when on"""
    report: tuple[str, ...] = ()
    """columns whose mean and standard deviation are reported"""


class Settings(Table):
    """case.toml."""

    kind: ClassVar[str] = "case"

    title: str
    """title of the study, shown in plots and reports"""
    source: str
    """publication of the measured data"""
    licence: str
    """licence of the measured data"""
    scene: str
    """scene file, path relative to this file"""
    quantity: str
    """result of the run that is compared"""
    uncertainty: str
    """uncertainty of the measured values"""
    each: Literal["time", "position"] = "time"
    """whether deviations are taken at each time or each position"""
    compare: Literal["profiles", "history", "signal", "levels"] = "profiles"
    """what is compared: profiles, a history, a signal or levels"""
    measured: Measured
    """the measured table and its columns"""
    report: Report = Report()
    """times and positions that are reported"""
    signal: Signal | None = None
    """evaluation of a fluctuating signal"""
    uncertain: dict[str, Any] = Field(default_factory=dict)
    """uncertain keys of the scene, each with its distribution"""
    uncertain_closures: dict[str, str] = Field(default_factory=dict)
    """closures that may be exchanged, by key"""
    long: Switch = False
    """more than a minute; run with --long"""


@dataclass(frozen=True)
class Points:
    """Measured points: times [s], positions [m], values in SI and heights [m], all of
    shape (points,).

    What the comparison has no use for is not a number.
    """

    t: Array
    x: Array
    value: Array
    height: Array


@dataclass(frozen=True)
class Case:
    """A measured bed.

    uncertainty : standard uncertainty of a measured point in the unit of the quantity
    unit : of the quantity
    """

    folder: Path
    settings: Settings
    origin: Origin
    unit: str
    uncertainty: float

    @property
    def name(self) -> str:
        """Name of the folder."""
        return self.folder.name

    @cached_property
    def points(self) -> Points:
        """The measured points, those at the start of the run left out, as the scene
        begins with them.

        Raises
        ------
        SceneError : the table cannot be used, or none of its rows is asked for
        """
        wanted = self.settings.measured
        table = read_table(self.folder / wanted.file)
        t = table.optional(wanted.time, "s")
        x = table.optional(wanted.position, "m")
        height = table.optional(wanted.height, "m")
        keep = table.rows_with(wanted.where) & ~(t <= 0.0)
        if not keep.any():
            raise SceneError(
                f"{self.origin.at(('measured',))}: no row of {wanted.file} fits "
                "measured.where after 0 s"
            )
        return Points(
            t[keep], x[keep], table.column(wanted.column, self.unit)[keep], height[keep]
        )

    def scene(self, **changes: Any) -> SceneBase:
        """Return the scene, that of profiles with outputs where something is measured
        or reported.

        Parameters
        ----------
        changes : values by key of the scene in place of its own
        """
        path = self.folder / self.settings.scene
        if self.settings.compare not in ("profiles", "history"):
            return load(path, changes)
        report = self.settings.report
        times = sorted({*self.points.t.tolist(), *report.times})
        if self.settings.compare == "history":
            return load(path, {"time.end": times[-1], "time.times": times, **changes})
        positions = sorted({*self.points.x.tolist(), *report.positions})
        outputs = {
            "time.end": times[-1],
            "time.times": times,
            "output.positions": positions,
        }
        return load(path, {**outputs, **changes})

    def uncertain(self) -> Iterator[tuple[str, float, float]]:
        """Yield key, value and standard uncertainty in SI of the inputs that are not
        known exactly.

        Raises
        ------
        SceneError : a key that the scene does not have as a number, or an uncertainty
            that is none
        """
        yield from uncertain_numbers(
            self.settings.uncertain, resolved(self.scene()), self.origin
        )

    def uncertain_closures(self) -> Iterator[tuple[str, float]]:
        """Yield the kinds of closures whose values are not known exactly, with their
        relative standard uncertainty.

        Raises
        ------
        SceneError : no such kind, or an uncertainty that is no share
        """
        kinds = {registry.sheet(name).kind for name in registry.names()}
        for kind, given in self.settings.uncertain_closures.items():
            where = self.origin.at(("uncertain_closures", kind))
            if kind not in kinds:
                known = nearest(kind, sorted(kinds))
                raise SceneError(
                    f"{where}: uncertain_closures.{kind}: no such kind of closure; "
                    f"{known}"
                )
            share = share_of(given)
            if share is None or not 0.0 < share < 1.0:
                raise SceneError(
                    f'{where}: uncertain_closures.{kind}: expected a share like "9 %", '
                    f'found "{given}"'
                )
            yield kind, share


def names() -> list[str]:
    """Return the names of the cases that are part of contbed."""
    return sorted(path.parent.name for path in SHIPPED.glob("*/case.toml"))


def read_case(name: str) -> Case:
    """Return a case by its name, or by the path of its folder.

    Raises
    ------
    SceneError : there is none, or a mistake in its case.toml, with file and line
    """
    folder = SHIPPED / name if name in names() else Path(name)
    if not (folder / "case.toml").is_file():
        raise SceneError(
            f"'{name}' is neither a folder with a case.toml nor a measured bed; "
            f"{nearest(name, names())}"
        )
    file = StudyFile(folder / "case.toml", Settings)
    settings = file.settings
    needed = {
        "profiles": ("time", "position"),
        "history": ("time",),
        "signal": ("time",),
        "levels": ("position", "height"),
    }[settings.compare]
    absent = [
        f"measured.{key}" for key in needed if getattr(settings.measured, key) is None
    ]
    absent += (
        ["signal"] if settings.compare == "signal" and settings.signal is None else []
    )
    for key in absent:
        file.say(
            ("measured",), f'missing; compare = "{settings.compare}" needs it', key
        )
    if field(settings.quantity) is None:
        file.fail(
            ("quantity",), f"no such quantity; {nearest(settings.quantity, [*FIELDS])}"
        )
    unit = require(settings.quantity).unit
    try:
        uncertainty = to_si(settings.uncertainty, unit)
    except ValueError as error:
        file.fail(("uncertainty",), str(error))
    file.stop()
    return Case(folder, settings, file.origin, unit, uncertainty)
