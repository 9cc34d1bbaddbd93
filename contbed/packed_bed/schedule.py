"""What changes in the course of a run: temperatures and heat fluxes of boundaries, and velocities, as time series.

A run is cut at every jump and kink of its series, so that no time step crosses one. Between two cuts temperatures and
fluxes change linearly and velocities are constant; a scene `frozen` at a time has numbers in place of all series.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from contbed.packed_bed import scene as s
from contbed.scene.schedule import SeriesByKey
from contbed.scene.series import ProfileFile, Series
from contbed.scene.toml_lines import KeyPath

VELOCITIES = ("velocity", "velocity_solid")
VALUES = ("fixed", "inflow", "flux", "ambient")
PHASES = ("fluid", "solid")


def series_of(flow: s.Flow | None, boundary: dict[str, s.Boundary]) -> Iterator[tuple[KeyPath, Series]]:
    """Yield key and series of everything that changes with time."""
    for key in VELOCITIES:
        if flow is not None and isinstance(series := getattr(flow, key), Series):
            yield ("flow", key), series
    for name, table in boundary.items():
        for phase in PHASES:
            condition = getattr(table, phase)
            for key in VALUES:
                if condition is not None and isinstance(series := getattr(condition, key), Series):
                    yield ("boundary", name, phase, key), series


@dataclass(frozen=True)
class Piece:
    """A part of a run in which temperatures and fluxes of boundaries are linear in time, velocities constant.

    start, end : [s]; first, last : the scene frozen just after the start and just before the end
    temperatures : all that the series of the run hold [K]
    jumps : whether a value jumps at the start; flow_since : when the velocities took their values [s]
    """

    start: float
    end: float
    first: s.Scene
    last: s.Scene
    temperatures: tuple[float, ...]
    jumps: bool
    flow_since: float

    @property
    def changes(self) -> bool:
        """Whether anything changes between the cuts."""
        return self.first.boundary != self.last.boundary

    def condition(self, boundary: str, phase: str, time: float) -> s.PhaseCondition | None:
        """Return the thermal condition of one phase on one boundary at a time [s]."""
        first, last = (getattr(scene.boundary.get(boundary), phase, None) for scene in (self.first, self.last))
        if first is None or last is None or first == last:
            return first
        share = (time - self.start) / (self.end - self.start)
        values = {
            key: getattr(first, key) + share * (getattr(last, key) - getattr(first, key))
            for key in VALUES
            if getattr(first, key) is not None
        }
        changed: s.PhaseCondition = first.model_copy(update=values)
        return changed


@dataclass(frozen=True)
class Schedule(SeriesByKey):
    """The series of a packed bed."""

    @classmethod
    def of(cls, flow: s.Flow | None, boundary: dict[str, s.Boundary], base: Path) -> Schedule:
        """Read the series of a scene in the folder `base`.

        Raises
        ------
        SceneError : a series cannot be used
        """
        return cls({path: series.samples(base) for path, series in series_of(flow, boundary)})

    @cached_property
    def flows(self) -> bool:
        """Whether a velocity changes."""
        return any(path[0] == "flow" for path in self.samples)

    def frozen_flow(self, flow: s.Flow, time: float, before: bool = False) -> s.Flow:
        """Return the [flow] table at a time, just after or `before` a jump."""
        found = {str(path[1]): _velocity(v.at(time, before)) for path, v in self.samples.items() if path[0] == "flow"}
        return flow.model_copy(update=found) if found else flow

    def frozen_boundary(self, boundary: dict[str, s.Boundary], time: float, before: bool = False) -> Any:
        """Return the [boundary] tables at a time, just after or `before` a jump."""
        found = dict(boundary)
        for path, values in self.samples.items():
            if path[0] == "boundary":
                _, name, phase, key = (str(part) for part in path)
                condition = getattr(found[name], phase).model_copy(update={key: float(values.at(time, before))})
                found[name] = found[name].model_copy(update={phase: condition})
        return found

    def frozen(self, scene: s.Scene, time: float, before: bool = False) -> s.Scene:
        """Return the scene with the values at a time, just after or `before` a jump."""
        if not self:
            return scene
        return scene.model_copy(
            update={
                "flow": self.frozen_flow(scene.flow, time, before),
                "boundary": self.frozen_boundary(scene.boundary, time, before),
            }
        )

    def temperatures(self) -> list[float]:
        """Return all temperatures of the series [K]."""
        found = (values.values for path, values in self.samples.items() if path[-1] in ("fixed", "inflow", "ambient"))
        return [float(T) for values in found for T in values]


def _velocity(value: Any) -> Any:
    return tuple(value.tolist()) if getattr(value, "ndim", 0) else float(value)


def initial_range(value: float | ProfileFile, phase: str, base: Path) -> tuple[float, float]:
    """Return the lowest and highest temperature at the start [K]."""
    if not isinstance(value, ProfileFile):
        return value, value
    T = value.samples(base, f"T_{phase}")[1]
    return float(T.min()), float(T.max())
