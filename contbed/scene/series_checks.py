"""Checks of one series of values over time, whatever it belongs to."""

from __future__ import annotations

from typing import Any

from contbed.errors import SceneError
from contbed.scene.checking import Mistakes, See
from contbed.scene.series import Series
from contbed.scene.toml_lines import KeyPath, Origin

MOST_CUTS = 100_000  # jumps and kinks of one series in a run; each takes some milliseconds


def series_is_usable(path: KeyPath, series: Series, time: Any, see: See, origin: Origin) -> Mistakes:
    """Check that a series can be read and lasts as long as the run; `time` is the table of that name, or None."""
    if time is None:
        yield path, "changes with time, and the scene is steady; add a [time] table, or give one number"
        return
    try:
        samples = series.samples(origin.base)
    except SceneError as error:
        yield path, str(error)
        return
    if not samples.reaches(time.end):
        last = f"ends at {samples.times[-1]:g} s, before the run; give a later value, or a period"
        yield path, f"{last}; see {see('time.end')}"
    if samples.period is not None and time.end / samples.period * len(samples.times) > MOST_CUTS:
        yield path, f"repeats more than {MOST_CUTS / len(samples.times):.0f} times until {see('time.end')}"
