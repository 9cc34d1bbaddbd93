"""What changes in the course of a run: temperatures and heat fluxes of boundaries, and
velocities, as time series.

A run is cut at every jump of its series and at kinks that are larger than the error of
a step allows, so that no time step crosses one. Between two cuts velocities are
constant, and temperatures and fluxes change linearly or with kinks so small that steps
pass them; a scene `frozen` at a time has numbers in place of all series. Where steps
have one given length, or one run is a cycle whose parts charge and discharge the bed,
it is cut at every kink.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.course.schedule import Schedule
from contbed.packed_bed import scene as s
from contbed.scene.series import ProfileFile
from contbed.scene.toml_lines import KeyPath
from contbed.scene.values import with_value

VELOCITY = "velocity"

KELVIN = ("fixed_temperature", "temperature", "ambient")  # those that are temperatures
PHASES = ("fluid", "solid")


@dataclass(frozen=True)
class ScheduleInterval:
    """A part of a run in which velocities are constant.

    start, end : [s]; scene : frozen just after the start
    schedule : the series of temperatures and fluxes that change in it
    small : sizes of kinks that a step may pass by key; none where all is linear in time
    temperatures : all of the series of the run [K]
    jumps : whether a value jumps at the start
    """

    start: float
    end: float
    scene: s.Scene
    schedule: Schedule
    small: Mapping[KeyPath, float]
    temperatures: tuple[float, ...]
    jumps: bool

    def resolves(self, start: float, end: float, stages: tuple[float, ...]) -> bool:
        """Return whether a step between two times [s] misses less than is small."""
        return not self.small or self.schedule.sees(start, end, stages, self.small)

    @cached_property
    def first(self) -> dict[KeyPath, float]:
        """Values at the start, by key."""
        samples = self.schedule.samples.items()
        return {path: float(each.at(self.start)) for path, each in samples}

    def interpolation_weights(self, time: float) -> Array:
        """Return by how much each series differs at a time [s] from its first value,
        over its largest.
        """
        changes = [
            (samples.at(time, True, self.start) - self.first[path]) / samples.size
            for path, samples in self.schedule.samples.items()
        ]
        return np.array(changes)

    def boundary(self, weights: Array) -> Mapping[str, s.Boundary]:
        """Return the [boundary] tables with values at interpolation weights."""
        found: Any = dict(self.scene.boundary)
        series = self.schedule.samples.items()
        for (path, samples), weight in zip(series, weights, strict=True):
            value = self.first[path] + float(weight) * samples.size
            found = with_value(found, path[1:], value)
        return found  # type: ignore[no-any-return]


def changing(
    schedule: Schedule, start: float, end: float, inner: Sequence[float]
) -> Schedule:
    """Return the series of temperatures and fluxes that change between two cuts; `inner`
    are the kinks between [s].
    """
    return Schedule(
        {
            path: samples
            for path, samples in schedule.samples.items()
            if path[-1] != VELOCITY
            and any(
                samples.at(time, True, start) != samples.at(start)
                for time in (*inner, end)
            )
        }
    )


def kinks_passed(schedule: Schedule, scene: s.Scene) -> dict[KeyPath, float] | None:
    """Return the sizes of kinks that a step may pass in a transient scene, None for
    none of them.
    """
    time = scene.time
    if time is None or time.step is not None or time.cycle is not None:
        return None
    return schedule.small(time.tolerance, initial_temperatures(scene))


def flow_changes(schedule: Schedule) -> bool:
    """Return whether a velocity changes."""
    return any(path[-1] == VELOCITY for path in schedule.samples)


def initial_temperatures(scene: s.Scene, phases: Iterable[str] = PHASES) -> list[float]:
    """Return the lowest and highest temperature of phases at the start [K]; none of a
    steady scene.
    """
    found: list[float] = []
    for phase in phases if scene.time is not None else ():
        value = scene.initial.given(phase)
        if isinstance(value, ProfileFile):
            T = value.samples(scene.origin.base, f"T_{phase}")[1]
            found += [float(T.min()), float(T.max())]
        else:
            found += [value, value]
    return found


def initial_values(scene: s.Scene, phase: str, x: Array) -> Any:
    """Return the initial temperature of a phase, a number or one for each position
    (n,) [m] along the bed [K].
    """
    value = scene.initial.given(phase)
    if not isinstance(value, ProfileFile):
        return value
    positions, T = value.samples(scene.origin.base, f"T_{phase}")
    return np.interp(x, positions, T)


def thermal_conditions(
    tables: Iterable[s.Boundary], phases: Iterable[str] = PHASES
) -> list[s.PhaseCondition]:
    """Return the thermal conditions of phases on boundaries."""
    found = [table.thermal(phase) for table in tables for phase in phases]
    return [condition for condition in found if condition is not None]


def temperatures_given(scene: s.Scene) -> list[Any]:
    """Return all temperatures that the boundaries and the start of a scene give [K]."""
    found = [
        getattr(condition, key)
        for condition in thermal_conditions(scene.boundary.values())
        for key in KELVIN
    ]
    return [T for T in found if T is not None] + initial_temperatures(scene)
