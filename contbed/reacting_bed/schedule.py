"""What changes in the course of a run of a reacting bed: streams that enter and
surroundings of the wall.

A run is cut at every jump of its series and at kinks that are larger than the error of
a step allows, so that no time step crosses one; each stage of a step takes the values
of its own time. A scene `frozen` at a time has numbers in place of all series.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import CompositionSeries
from contbed.reacting_bed.streams import INWARD, Boundaries, gas_sign, velocity_of
from contbed.scene.quantities import Table
from contbed.scene.schedule import SeriesByKey
from contbed.scene.series import Series
from contbed.scene.toml_lines import KeyPath, Origin
from contbed.scene.values import with_value


def series_of(part: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Series]]:
    """Yield key and series of everything in the tables of a scene that changes with
    time.
    """
    if isinstance(part, Series):
        yield path, part
    elif isinstance(part, Mapping):
        for name, item in part.items():
            yield from series_of(item, (*path, name))
    elif isinstance(part, Table):
        for name in type(part).model_fields:
            yield from series_of(getattr(part, name), (*path, name))


def tables_of(scene: s.ReactingScene) -> dict[str, Any]:
    """Return the tables of a scene that may hold series."""
    return {"boundary": scene.boundary}


@dataclass(frozen=True)
class Schedule(SeriesByKey):
    """The series of a scene.

    `species` are the columns of the series of compositions by key, `temperatures` the
    keys of the series of temperatures.
    """

    species: dict[KeyPath, tuple[str, ...]]
    temperatures: frozenset[KeyPath]

    @classmethod
    def of(cls, tables: Mapping[str, Any], base: Path) -> Schedule:
        """Read the series of the tables of a scene in the folder `base`.

        Raises
        ------
        SceneError : a series cannot be used
        """
        found = dict(series_of(tables))
        names = {
            path: item.fractions(base)[0]
            for path, item in found.items()
            if isinstance(item, CompositionSeries)
        }
        kelvin = frozenset(path for path, item in found.items() if item.quantity == "K")
        return cls(
            {path: item.samples(base) for path, item in found.items()}, names, kelvin
        )

    def small(self, scene: s.ReactingScene) -> dict[KeyPath, float]:
        """Return the sizes of kinks that a step may pass: of temperatures, mole
        fractions and flows.

        What errors refer to is here the range of all temperatures that change, with
        that at the start; one; the largest flow.
        """
        assert scene.time is not None
        known = [self.samples[path].values for path in self.temperatures]
        if scene.initial.temperature is not None:
            known.append(np.array([scene.initial.temperature]))
        sizes = {path: 1.0 if path in self.species else float(np.abs(self.samples[path].values).max())
                 for path in self.samples}  # fmt: skip
        if known:
            sizes |= dict.fromkeys(
                self.temperatures, float(np.ptp(np.concatenate(known)))
            )
        return self.passed(sizes, scene.time.tolerance)

    def at(
        self,
        tables: Mapping[str, Any],
        time: float,
        before: bool = False,
        since: float = 0.0,
    ) -> dict[str, Any]:
        """Return the tables with the values at a time, just after or `before` a
        jump, `since` an earlier one.
        """
        found: Any = dict(tables)
        for path, samples in self.samples.items():
            value = samples.at(time, before, since)
            names = self.species.get(path)
            found = with_value(
                found, path, float(value) if names is None else _text(names, value)
            )
        return dict(found)

    def frozen(
        self,
        scene: s.ReactingScene,
        time: float,
        before: bool = False,
        since: float = 0.0,
    ) -> s.ReactingScene:
        """Return the scene with the values at a time, just after or `before` a jump,
        `since` an earlier one.
        """
        if not self:
            return scene
        return scene.model_copy(update=self.at(tables_of(scene), time, before, since))

    def moments(self) -> list[float]:
        """Return all times of the series [s]."""
        return sorted(
            {float(t) for samples in self.samples.values() for t in samples.times}
        )

    def shortest(self, scene: s.ReactingScene, together: float) -> float:
        """Return the shortest time between changes in a run; those that lie
        `together` count as one [s].
        """
        assert scene.time is not None
        apart, end = [0.0], scene.time.end
        for cut in self.cuts(end, self.small(scene)):
            if cut - apart[-1] > together:
                apart.append(cut)
        return min((b - a for a, b in pairwise(apart)), default=end)


def _text(names: tuple[str, ...], fractions: Any) -> str:
    return ", ".join(
        f"{name}:{float(x)!r}" for name, x in zip(names, fractions, strict=True)
    )


def boundaries_in_time(boundary: Boundaries, origin: Origin) -> Iterator[Boundaries]:
    """Yield the conditions at each time of their series, streams that do not enter then
    without a state.

    Nothing is yielded where a series cannot be used.
    """
    tables = {"boundary": boundary}
    try:
        schedule = Schedule.of(tables, origin.base)
    except SceneError:
        return  # `series_are_usable` says so
    if not schedule:
        yield boundary
    for moment in schedule.moments():
        yield _of_streams_that_enter(schedule.at(tables, moment)["boundary"])


def _of_streams_that_enter(boundary: Boundaries) -> Boundaries:
    """Return the conditions without temperatures and compositions of streams that do
    not enter at the moment.
    """
    gas, found = gas_sign(boundary), dict(boundary)
    for end, into in INWARD.items():
        if end not in found:
            continue
        table = found[end]
        if table.gas is not None and gas * into <= 0.0:
            idle = {"temperature": None, "fixed_temperature": None, "composition": None}
            table = table.model_copy(update={"gas": table.gas.model_copy(update=idle)})
        solids = {
            phase: each
            if velocity_of(boundary, phase) * into > 0.0
            else each.model_copy(update={"temperature": None})
            for phase, each in table.solids.items()
        }
        found[end] = table.model_copy(update={"solids": solids})
    return found
