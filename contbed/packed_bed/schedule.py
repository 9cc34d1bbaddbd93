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

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.packed_bed import scene as s
from contbed.scene.boundary import conditions_of
from contbed.scene.schedule import SeriesByKey
from contbed.scene.series import SAME, ProfileFile, Samples, Series
from contbed.scene.toml_lines import KeyPath
from contbed.scene.values import with_value

Array = NDArray[np.float64]

VELOCITY = "velocity"
VALUES = ("fixed_temperature", "temperature", "heat_flux", "ambient")
KELVIN = ("fixed_temperature", "temperature", "ambient")  # those that are temperatures
PHASES = ("fluid", "solid")


def series_of(boundary: Mapping[str, s.Boundary]) -> Iterator[tuple[KeyPath, Series]]:
    """Yield key and series of everything that changes with time."""
    for path, _, condition in conditions_of(boundary):
        for key in (VELOCITY, *VALUES):
            if isinstance(series := getattr(condition, key), Series):
                yield (*path, key), series


@dataclass(frozen=True)
class Piece:
    """A part of a run in which velocities are constant.

    start, end : [s]; first : the scene frozen just after the start
    others : scenes of which `shares` of a time are added to it, as values less those of
        the first: the scene just before the end where all is linear in time, else for
        each series that changes the scene with another value of it
    ways : of each of these series its key, its samples, the value at the start and the
        other one; none if all is linear
    small : sizes of kinks that a step may pass by key, where there are some
    temperatures : all that the series of the run hold [K]
    jumps : whether a value jumps at the start; flow_since : when the velocities took
        their values [s]
    """

    start: float
    end: float
    first: s.Scene
    others: tuple[s.Scene, ...]
    temperatures: tuple[float, ...]
    jumps: bool
    flow_since: float
    ways: tuple[tuple[KeyPath, Samples, float, float], ...] = ()
    small: Mapping[KeyPath, float] = field(default_factory=dict)

    @property
    def changes(self) -> bool:
        """Whether anything changes between the cuts."""
        return any(self.first.boundary != other.boundary for other in self.others)

    @property
    def sees(self) -> Callable[[float, float], bool] | None:
        """Whether a step between two times [s] misses less than is small; None where
        all is linear in time.
        """
        if not self.ways:
            return None
        from contbed.solvers.timestep import STAGES  # a steady run has no steps

        bent = SeriesByKey({path: samples for path, samples, *_ in self.ways})
        return lambda start, end: bent.sees(start, end, STAGES, self.small)

    def shares(self, time: float) -> Array:
        """Return how far values at a time [s] have come from the first to the others
        (len(others),).
        """
        if not self.ways:
            return np.array([(time - self.start) / (self.end - self.start)])
        return np.array(
            [
                (samples.at(time, True, self.start) - first) / (other - first)
                for _, samples, first, other in self.ways
            ]
        )

    def condition(
        self, boundary: str, phase: str, shares: Array
    ) -> s.PhaseCondition | None:
        """Return the thermal condition of one phase on one boundary at shares of the
        others.
        """
        first, *others = (
            _thermal(each, boundary, phase) for each in (self.first, *self.others)
        )
        changed = [
            (share, other)
            for share, other in zip(shares, others, strict=True)
            if other != first
        ]
        if first is None or not changed:
            return first
        values = {
            key: start
            + sum(
                float(share) * (getattr(other, key) - start) for share, other in changed
            )
            for key in VALUES
            if (start := getattr(first, key)) is not None
        }
        found: s.PhaseCondition = first.model_copy(update=values)
        return found


def _thermal(scene: s.Scene, boundary: str, phase: str) -> s.PhaseCondition | None:
    table = scene.boundary.get(boundary)
    return None if table is None else table.thermal(phase)


@dataclass(frozen=True)
class Schedule(SeriesByKey):
    """The series of a packed bed."""

    @classmethod
    def of(cls, boundary: Mapping[str, s.Boundary], base: Path) -> Schedule:
        """Read the series of a scene in the folder `base`.

        Raises
        ------
        SceneError : a series cannot be used
        """
        return cls({path: series.samples(base) for path, series in series_of(boundary)})

    def small(self, scene: s.Scene) -> dict[KeyPath, float] | None:
        """Return the sizes of kinks that a step may pass in a transient scene, None for
        none of them.

        What errors refer to is here the range of the temperatures that change, with
        those at the start, and the largest heat flux.
        """
        time, base = scene.time, scene.origin.base
        if time is None or time.step is not None or time.cycle is not None:
            return None
        starts = [
            T
            for phase in PHASES
            for T in initial_range(scene.initial.given(phase), phase, base)
        ]
        span = float(np.ptp([*self.temperatures(), *starts]))
        sizes = {
            path: float(np.abs(values.values).max())
            for path, values in self.samples.items()
        }
        sizes |= {path: span for path in sizes if path[-1] in KELVIN}
        return self.passed(sizes, time.tolerance)

    def ways(
        self, start: float, end: float, cuts: Sequence[float]
    ) -> list[tuple[KeyPath, Samples, float, float]]:
        """Return the series that bend between two cuts, see `Piece`; `cuts` are all
        jumps and kinks [s].
        """
        inner = cuts[
            bisect_right(cuts, start * (1.0 + SAME)) : bisect_left(
                cuts, end * (1.0 - SAME)
            )
        ]
        found: list[tuple[KeyPath, Samples, float, float]] = []
        for path, samples in self.samples.items() if inner else ():
            first = samples.at(start)
            values = np.array([samples.at(time, True, start) for time in (*inner, end)])
            if path[-1] != VELOCITY and np.any(values != first):
                found.append(
                    (
                        path,
                        samples,
                        float(first),
                        float(values[np.abs(values - first).argmax()]),
                    )
                )
        return found

    @cached_property
    def flows(self) -> bool:
        """Whether a velocity changes."""
        return any(path[-1] == VELOCITY for path in self.samples)

    def frozen_boundary(
        self, boundary: dict[str, s.Boundary], time: float, before: bool = False
    ) -> Any:
        """Return the [boundary] tables at a time, just after or `before` a jump."""
        found: Any = dict(boundary)
        for path, values in self.samples.items():
            found = with_value(found, path[1:], _plain(values.at(time, before)))
        return found

    def frozen(self, scene: s.Scene, time: float, before: bool = False) -> s.Scene:
        """Return the scene with the values at a time, just after or `before` a jump."""
        if not self:
            return scene
        return scene.model_copy(
            update={"boundary": self.frozen_boundary(scene.boundary, time, before)}
        )

    def temperatures(self) -> list[float]:
        """Return all temperatures of the series [K]."""
        found = (
            values.values for path, values in self.samples.items() if path[-1] in KELVIN
        )
        return [float(T) for values in found for T in values]


def _plain(value: Any) -> Any:
    """Return a value of a series as a number, a velocity with components as a tuple."""
    return tuple(value.tolist()) if getattr(value, "ndim", 0) else float(value)


def initial_range(
    value: float | ProfileFile, phase: str, base: Path
) -> tuple[float, float]:
    """Return the lowest and highest temperature at the start [K]."""
    if not isinstance(value, ProfileFile):
        return value, value
    T = value.samples(base, f"T_{phase}")[1]
    return float(T.min()), float(T.max())


def initial_values(value: float | ProfileFile, phase: str, base: Path, x: Array) -> Any:
    """Return the initial temperature of a phase, a number or one for each position
    (n,) [m] along the bed [K].
    """
    if not isinstance(value, ProfileFile):
        return value
    positions, T = value.samples(base, f"T_{phase}")
    return np.interp(x, positions, T)
