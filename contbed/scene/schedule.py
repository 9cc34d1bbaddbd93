"""The time series of a scene together: when they jump or bend, so that no time step
crosses such a moment.

A kink that is small beside the error that a step may make need not be met: a step
passes it that looks at the series closely enough, so that what lies between its stages
is as small (`sees`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from contbed.scene.series import SAME, Samples
from contbed.scene.toml_lines import KeyPath

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
class SeriesByKey:
    """The series of a scene by key; empty for a scene in which nothing changes."""

    samples: dict[KeyPath, Samples]

    def __bool__(self) -> bool:
        return bool(self.samples)

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

    def passed(
        self, sizes: Mapping[KeyPath, float], tolerance: float
    ) -> dict[KeyPath, float]:
        """Return the sizes of kinks that a step may pass; `sizes` are what errors of
        each series refer to.
        """
        return {path: PASSED * tolerance * sizes[path] for path in self.samples}

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

    def jumps(self, time: float, among: str = "", since: float = 0.0) -> bool:
        """Return whether a value jumps at a time; `among` is the table or the last key
        of those that are looked at.

        `since` is the last cut before it [s]. Values on both sides of a kink may differ
        by rounding.
        """
        return any(
            np.any(
                np.abs(values.at(time) - values.at(time, True, since))
                > _rounding(values)
            )
            for path, values in self.samples.items()
            if not among or among in (path[0], path[-1])
        )


def _rounding(values: Samples) -> float:
    """Return by how much both sides of a moment without a jump may differ."""
    return 0.0 if values.form == "step" else ROUNDED * float(np.ptp(values.values))
