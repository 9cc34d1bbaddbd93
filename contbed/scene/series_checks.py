"""Checks of one series of values over time, whatever it belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.errors import SceneError
from contbed.scene.checking import Mistakes, See
from contbed.scene.series import Series, series_of
from contbed.scene.toml_lines import KeyPath, Origin

# by which the number of periods of a series in a cycle may miss a whole one
WHOLE = 1e-9
# jumps and kinks of one series in a run; each takes some milliseconds
MOST_CUTS = 100_000


def series_is_usable(
    path: KeyPath, series: Series, time: Any, see: See, origin: Origin
) -> Mistakes:
    """Check that a series can be read and lasts as long as the run; `time` is the
    table of that name, or None.
    """
    if time is None:
        yield (
            path,
            "changes with time, and the scene is steady; add a [time] table, or give "
            "one number; a profile over position cannot be given",
        )
        return
    try:
        samples = series.samples(origin.base)
    except SceneError as error:
        yield path, str(error)
        return
    if not samples.reaches(time.end):
        last = (
            f"ends at {samples.times[-1]:g} s, before the run; give a later value, "
            "or a period"
        )
        yield path, f"{last}; see {see('time.end')}"
    if (
        samples.period is not None
        and time.end / samples.period * len(samples.times) > MOST_CUTS
    ):
        yield (
            path,
            f"repeats more than {MOST_CUTS / len(samples.times):.0f} times until "
            f"{see('time.end')}",
        )


def series_are_usable(
    boundary: Mapping[str, Any], time: Any | None, see: See, origin: Origin
) -> Mistakes:
    """Check that series can be read, begin at 0 and last as long as the run."""
    for path, series in series_of(boundary, ("boundary",)):
        yield from series_is_usable(path, series, time, see, origin)


def output_times_lie_in_the_run(time: Any, see: See) -> Mistakes:
    """Check that no output time is after the end."""
    for index, instant in enumerate(time.times):
        if instant > time.end:
            yield (
                ("time", "times", index),
                f"{instant:g} s is after the end; see {see('time.end')}",
            )


def a_cycle_fits_its_series(
    boundary: Mapping[str, Any], time: Any, what: str, see: See
) -> Mistakes:
    """Check that something changes within a cycle, which is an integer number of
    periods of each series.

    `what` says which values may change.
    """
    if time is None or time.cycle is None:
        return
    series = list(series_of(boundary, ("boundary",)))
    if not series:
        yield (
            ("time", "cycle"),
            f"a cycle needs {what} that changes with time: a table with times and "
            "values",
        )
    for path, each in series:
        count = 1.0 if each.period is None else time.end / each.period
        if abs(count - max(round(count), 1)) > WHOLE * count:
            yield (
                path,
                f"its period of {each.period:g} s fits {count:.6g} times into the "
                "cycle, which is one run; give it a "
                f"length that is a multiple of the period, see {see('time.end')}",
            )
