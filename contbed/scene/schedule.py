"""The time series of a scene together: when they jump or bend, so that no time step crosses such a moment."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from contbed.scene.series import SAME, Samples
from contbed.scene.toml_lines import KeyPath

# distance of two cuts below which they are one, over that of jumps; a value before a cut is so before both
MERGED = 0.5


@dataclass(frozen=True)
class SeriesByKey:
    """The series of a scene by key; empty for a scene in which nothing changes."""

    samples: dict[KeyPath, Samples]

    def __bool__(self) -> bool:
        return bool(self.samples)

    def cuts(self, end: float) -> list[float]:
        """Return the times from 0 to `end` between which all is linear in time; of jumps that are one the last [s]."""
        times = sorted({0.0, end, *(t for values in self.samples.values() for t in values.breaks(end))})
        return [a for a, b in pairwise([*times, 2.0 * end]) if b - a > MERGED * SAME * b]

    def jumps(self, time: float, among: str = "", since: float = 0.0) -> bool:
        """Return whether a value jumps at a time; `among` names the table that is looked at, empty for all.

        `since` is the last cut before it [s].
        """
        return any(
            (values.at(time) != values.at(time, before=True, since=since)).any()
            for path, values in self.samples.items()
            if not among or path[0] == among
        )
