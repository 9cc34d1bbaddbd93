"""The time series of a scene together: what they say at a time, and when they jump or
bend, so that no time step crosses such a moment.

A kink that is small beside the error that a step may make need not be met: a step
passes it that looks at the series closely enough, so that what lies between its stages
is as small (`sees`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.scene.series import SAME, Samples, series_of
from contbed.scene.toml_lines import KeyPath, Origin
from contbed.scene.values import with_value

# distance of two cuts below which they are one, over that of jumps; a value before a
# cut is so before both
MERGED = 0.5
# size of kinks that steps pass, and of what they miss between their stages, over the
# error that they may make
PASSED = 0.5
# of the range of a series, below which a change at a moment is that of times that are
# one
ROUNDED = 1e-6


@dataclass(frozen=True)
class Schedule:
    """The series of a scene by key; empty for a scene in which nothing changes."""

    samples: dict[KeyPath, Samples]

    def __bool__(self) -> bool:
        return bool(self.samples)

    @classmethod
    def of(cls, boundary: Mapping[str, Any], base: Path) -> Schedule:
        """Read the series of [boundary] tables in the folder `base`.

        Raises
        ------
        SceneError : a series cannot be used
        """
        found = series_of(boundary, ("boundary",))
        return cls({path: series.samples(base) for path, series in found})

    def boundary_at(
        self,
        boundary: Mapping[str, Any],
        time: float,
        before: bool = False,
        since: float = 0.0,
    ) -> dict[str, Any]:
        """Return the [boundary] tables with the values at a time, just after or
        `before` a jump, `since` an earlier one.
        """
        found: Any = dict(boundary)
        for path, samples in self.samples.items():
            value = samples.plain(samples.at(time, before, since))
            found = with_value(found, path[1:], value)
        return dict(found)

    def frozen(
        self, scene: Any, time: float, before: bool = False, since: float = 0.0
    ) -> Any:
        """Return the scene with numbers in place of all series, see `boundary_at`."""
        if not self:
            return scene
        boundary = self.boundary_at(scene.boundary, time, before, since)
        return scene.model_copy(update={"boundary": boundary})

    def moments(self) -> list[float]:
        """Return all times of the series [s]."""
        times = np.concatenate([[], *(each.times for each in self.samples.values())])
        return np.unique(times).tolist()  # type: ignore[no-any-return]

    def temperatures(self) -> list[float]:
        """Return all temperatures of the series [K]."""
        kelvin = (each for each in self.samples.values() if each.quantity == "K")
        return [float(T) for samples in kelvin for T in samples.values]

    def cuts(
        self, end: float, small: Mapping[KeyPath, Any] | None = None
    ) -> list[float]:
        """Return the times from 0 to `end` between which all is linear in time; of
        jumps that are one the last [s].

        `small` are sizes of kinks of the series by key; kinks that are not larger are
        passed.
        """
        times = sorted(
            {
                *(0.0, end),
                *(
                    time
                    for path, values in self.samples.items()
                    for time in values.breaks(end)
                    if small is None or np.any(values.kink(time) > small[path])
                ),
            }
        )
        return [
            a for a, b in pairwise([*times, 2.0 * end]) if b - a > MERGED * SAME * b
        ]

    def small(self, tolerance: float, starts: Sequence[float]) -> dict[KeyPath, float]:
        """Return the sizes of kinks that a step with a tolerance may pass, by key.

        Errors refer to the range of all temperatures that change, with those at the
        start [K]; to one for mole fractions; to the largest value of others.
        """
        known = [*self.temperatures(), *starts]
        span = float(np.ptp(known)) if known else 0.0
        sizes = {
            path: span if samples.quantity == "K" else samples.size
            for path, samples in self.samples.items()
        }
        return {path: PASSED * tolerance * size for path, size in sizes.items()}

    def sees(
        self,
        start: float,
        end: float,
        stages: Sequence[float],
        small: Mapping[KeyPath, Any],
    ) -> bool:
        """Return whether a step between two cuts [s], which looks at its `stages`,
        misses less than is `small`.
        """
        return not any(
            np.any(values.unseen(start, end, stages) > small[path])
            for path, values in self.samples.items()
        )

    def jumps(self, time: float) -> bool:
        """Return whether a value jumps at a time; values on both sides of a kink may
        differ by rounding.
        """
        return any(
            np.any(np.abs(values.at(time) - values.at(time, True)) > _rounding(values))
            for values in self.samples.values()
        )


def boundaries_in_time(
    boundary: Mapping[str, Any],
    origin: Origin,
    entering: Callable[[Any], Any],
) -> Iterator[Any]:
    """Yield the conditions at each time of their series; nothing where a series cannot
    be used.

    `entering` returns them without the state of streams that do not enter.
    """
    try:
        schedule = Schedule.of(boundary, origin.base)
    except SceneError:
        return  # `series_are_usable` reports it
    if not schedule:
        yield boundary
    for moment in schedule.moments():
        yield entering(schedule.boundary_at(boundary, moment))


def _rounding(values: Samples) -> float:
    """Return by how much both sides of a moment without a jump may differ."""
    return 0.0 if values.form == "step" else ROUNDED * float(np.ptp(values.values))
