"""Values of a scene that change with time or along the bed: pairs in the scene, or a
column of a CSV file.

temperature = {times = ["0 h", "6 h"], values = ["290 degC", "390 degC"], form = "step",
period = "24 h"} ambient = {file = "weather.csv", column = "T_ambient"}
initial.solids.pebbles.temperature = {file = "results/charge/profiles.csv"}
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.scene.quantities import (
    FiniteFloat,
    HeatFlux,
    Instant,
    Seconds,
    Table,
    Temperature,
    Velocity,
    in_unit,
)
from contbed.scene.toml_lines import KeyPath
from contbed.scene.values import tables

if TYPE_CHECKING:
    from contbed.scene.profile import Rows

TINY = 1e-12  # of the time, below which two times are the same
SAME = 1e-9  # of the time, below which two jumps are one
# times the largest mole fraction of a trace, what errors of it refer to
OF_A_TRACE = 10.0


class Series(Table):
    """A value as a function of time."""

    quantity: ClassVar[str] = "1"

    times: tuple[Instant, ...] = ()
    """when the values hold; the first is 0"""
    values: tuple[Any, ...] = ()
    """one for each time"""
    file: str | None = None
    """CSV file instead, path relative to the scene"""
    column: str | None = None
    """of the file; absent: the first column with the right kind of unit"""
    form: Literal["linear", "step"] = "linear"
    """between the times; step holds until the next"""
    period: Seconds | None = None
    """the series repeats after this time"""

    @model_validator(mode="after")
    def _pairs_or_file(self) -> Self:
        if (self.file is None) == (not self.times):
            raise ValueError("give times and values, or a file")
        if self.file is not None and self.values:
            raise ValueError("a file has the values already; remove values")
        if self.file is None and len(self.times) != len(self.values):
            raise ValueError(
                f"{len(self.times)} times and {len(self.values)} values; each time "
                "needs one value"
            )
        if self.file is None and self.column is not None:
            raise ValueError("column is for a file")
        return self

    def samples(self, base: Path) -> Samples:
        """Return times and values, from a file if there is one.

        Raises
        ------
        SceneError : the file cannot be used, or times that do not increase from 0
        """
        if self.file is None:
            times = np.array(self.times)
            values = np.array(self.values, dtype=float)
            where = [""] * len(self.times)
        else:
            # with it the conversion of units
            from contbed.scene.data_table import read_table

            table = read_table(base / self.file)
            times = table.column(table.name_in("s"), "s")
            values = table.column(
                self.column or table.name_in(self.quantity), self.quantity
            )
            where = [f"{table.path.name}:{line}: " for line in table.lines]
        if self.quantity == "K" and np.min(values, initial=1.0) <= 0.0:
            raise SceneError(
                f"{where[int(np.argmin(values.ravel()))]}a temperature of "
                f"{values.min():g} K; it must be > 0"
            )
        return self.checked(times, values, where)

    def checked(self, times: Array, values: Array, where: list[str]) -> Samples:
        """Return times and values that were read; `where` begins the message about each
        time.

        Raises
        ------
        SceneError : times do not increase from 0, or lie beyond the period
        """
        if times[0] != 0.0:
            raise SceneError(
                f"{where[0]}the first time is {times[0]:g} s; a series begins at 0 s"
            )
        late = np.flatnonzero(np.diff(times) <= 0.0)
        if len(late):
            k = int(late[0]) + 1
            raise SceneError(
                f"{where[k]}times must increase: {times[k]:g} s comes after "
                f"{times[k - 1]:g} s"
            )
        if self.period is not None and times[-1] > self.period:
            raise SceneError(
                f"{where[-1]}{times[-1]:g} s lies beyond the period of {self.period:g} "
                "s"
            )
        return Samples(times, values, self.form, self.period, self.quantity)


class TemperatureSeries(Series):
    """A temperature that changes with time."""

    quantity: ClassVar[str] = "K"
    values: tuple[Temperature, ...] = ()
    """one for each time"""


class HeatFluxSeries(Series):
    """A heat flux that changes with time."""

    quantity: ClassVar[str] = "W/m**2"
    values: tuple[HeatFlux, ...] = ()
    """one for each time"""


def series_of(part: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Series]]:
    """Yield key and series of everything in a table that changes with time."""
    for where, found in tables(part, path):
        if isinstance(found, Series):
            yield where, found


class VelocitySeries(Series):
    """A velocity that changes in steps; the flow may start, stop and reverse."""

    quantity: ClassVar[str] = "m/s"
    values: tuple[Velocity, ...] = ()
    """one for each time"""
    form: Literal["step"] = "step"
    """a velocity holds until the next time"""


@dataclass(frozen=True)
class Samples:
    """Times [s] and values in SI of a series, the first time 0; values (times,) or
    (times, dimension).

    `quantity` is the unit; `species` are the columns of a series of compositions.
    """

    times: Array
    values: Array
    form: str
    period: float | None
    quantity: str = "1"
    species: tuple[str, ...] = ()

    @property
    def size(self) -> Any:
        """Largest value; of each mole fraction what its errors refer to."""
        if not self.species:
            return float(np.abs(self.values).max())
        return np.minimum(OF_A_TRACE * self.values.max(axis=0), 1.0)

    def plain(self, value: Any) -> Any:
        """Return one value as a scene writes it: a number, a vector or a composition."""
        if self.species:
            pairs = zip(self.species, value.tolist(), strict=True)
            return ", ".join(f"{name}:{x!r}" for name, x in pairs)
        return tuple(value.tolist()) if np.ndim(value) else float(value)

    def at(self, time: float, before: bool = False, since: float = 0.0) -> Any:
        """Return the value at a time, at a jump that after it, or `before` it and those
        that are one with it.

        What holds before a time holds `since` an earlier jump [s], which may be as near
        as those that are one.
        """
        moment = (
            max(time * (1.0 - SAME), since * (1.0 + TINY))
            if before
            else time * (1.0 + TINY)
        )
        start = self._begun(moment)
        local = max(time - start, 0.0)
        k = max(int(np.searchsorted(self.times, moment - start, side="right")) - 1, 0)
        if self.form == "step":
            return self.values[k]
        if k + 1 < len(self.times):
            end, value = self.times[k + 1], self.values[k + 1]
        elif self.period is not None and self.times[-1] < self.period:
            end, value = self.period, self.values[0]
        else:
            return self.values[-1]
        share = (local - self.times[k]) / (end - self.times[k])
        return self.values[k] + share * (value - self.values[k])

    def _begun(self, time: float) -> float:
        """Return when the period of a time began [s]."""
        period = self.period
        return 0.0 if period is None else float(np.floor(time / period) * period)

    def breaks(self, end: float) -> Iterator[float]:
        """Yield the times in (0, end) at which the value jumps or its slope
        changes [s].
        """
        start = 0.0
        while start < end:
            for time in self.times:
                if 0.0 < start + time < end * (1.0 - TINY):
                    yield float(start + time)
            if self.period is None:
                return
            start += self.period

    def kink(self, time: float) -> Any:
        """Return how far the value at a break lies off the line between its
        neighbours; inf where it may jump.
        """
        start = self._begun(time * (1.0 + TINY))
        k = int(np.abs(self.times - (time - start)).argmin())
        if self.form == "step" or not 0 < k < len(self.times) - 1:
            return np.full_like(self.values[0], np.inf)
        share = (self.times[k] - self.times[k - 1]) / (
            self.times[k + 1] - self.times[k - 1]
        )
        return np.abs(
            self.values[k]
            - self.values[k - 1]
            - share * (self.values[k + 1] - self.values[k - 1])
        )

    def unseen(self, start: float, end: float, stages: Sequence[float]) -> Any:
        """Return how far values between two times without a jump lie off the polynomial
        through those at stages.

        Parameters
        ----------
        start, end : of a time step [s]
        stages : where a step looks at the series, shares of its length
        """
        offset = self._begun(start * (1.0 + TINY))
        first = int(
            np.searchsorted(self.times, start * (1.0 + SAME) - offset, side="right")
        )
        last = int(
            np.searchsorted(self.times, end * (1.0 - SAME) - offset, side="left")
        )
        if first >= last:
            return np.zeros_like(self.values[0])
        shares = (self.times[first:last] + offset - start) / (end - start)
        nodes = np.array(stages)
        known = np.array(
            [self.at(start + share * (end - start), True, start) for share in stages]
        )
        basis = [
            np.prod([(shares - b) / (a - b) for b in nodes if b != a], axis=0)
            for a in nodes
        ]
        return np.abs(
            self.values[first:last] - np.tensordot(np.array(basis), known, (0, 0))
        ).max(axis=0)

    def reaches(self, end: float) -> bool:
        """Return whether the series says what holds until `end`; the last step holds
        for ever.
        """
        return (
            self.period is not None
            or self.form == "step"
            or self.times[-1] >= end * (1.0 - TINY)
        )


class ProfileFile(Table):
    """Temperatures along the bed from a CSV file, such as the profiles.csv of an
    earlier run.
    """

    file: str
    """CSV file with a column of positions and one of temperatures, relative to the
    scene"""
    column: str | None = None
    """absent: T_fluid or T_solid, or the first with a temperature"""

    def samples(self, base: Path, name: str) -> tuple[Array, Array]:
        """Return positions [m] in increasing order and temperatures [K]; at the last
        time if the file has several.

        Parameters
        ----------
        base : folder of the scene
        name : the column to take if the scene names none and the file has it

        Raises
        ------
        SceneError : the file cannot be used, positions that are given twice, a
            temperature not above 0 K
        """
        rows = self.rows(base)
        chosen = self.column or (
            name if name in rows.table.names else rows.table.name_in("K")
        )
        values = rows.column(chosen, "K")
        if values.min() <= 0.0:
            raise rows.error(
                int(np.argmin(values)),
                f"a temperature of {values.min():g} K; it must be above 0",
            )
        return rows.where, values

    def rows(self, base: Path) -> Rows:
        """Return the rows of the file at its last time.

        Raises
        ------
        SceneError : the file cannot be used, or positions that are given twice
        """
        from contbed.scene.profile import rows_along

        return rows_along(base / self.file)


def how_written(value: Any) -> str:
    """Return "series" for a table, "list" for a list, else "number", the tags of the
    unions below.
    """
    if isinstance(value, (dict, Table)):
        return "series"
    return "list" if isinstance(value, (list, tuple)) else "number"


Quantity = TypeVar("Quantity")
Changing = TypeVar("Changing")
# a number of a quantity, or a table by which it changes
OrSeries = Annotated[
    Annotated[Quantity, Tag("number")] | Annotated[Changing, Tag("series")],
    Discriminator(how_written),
]
TemperatureOrSeries = OrSeries[Temperature, TemperatureSeries]
HeatFluxOrSeries = OrSeries[HeatFlux, HeatFluxSeries]
VelocityOrSeries = Annotated[
    Annotated[FiniteFloat, Tag("number")]
    | Annotated[tuple[FiniteFloat, ...], Tag("list")]
    | Annotated[VelocitySeries, Tag("series")],
    Field(json_schema_extra={"unit": "m/s"}),
    Discriminator(how_written),
    in_unit("m/s"),
]
TemperatureOrProfile = OrSeries[Temperature, ProfileFile]
