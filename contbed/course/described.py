"""What a plan says of the time steps of a run."""

from __future__ import annotations

from itertools import pairwise
from math import ceil
from typing import Any

from contbed.course.cycle import MOST
from contbed.course.history import SAME, output_times
from contbed.course.schedule import Schedule


def described_steps(time: Any, schedule: Schedule) -> str:
    """Return how many steps a run takes, or why that is not known before it.

    Parameters
    ----------
    time : table of the scene, see `scene.tables.RunInTime`
    schedule : its series
    """
    jumps = [at for at in schedule.cuts(time.end) if schedule.jumps(at)]
    stops = sorted({0.0, *jumps, *output_times(time)})
    lengths = [end - start for start, end in pairwise(stops)]
    if (step := getattr(time, "step", None)) is not None:
        number = sum(max(1, ceil(length / step * (1.0 - SAME))) for length in lengths)
        text = f"about {number} of {step:g} s"
    else:
        text = (
            f"as many as errors of time.tolerance = {time.tolerance:g} need, which is "
            f"known only from the run; at least {len(lengths)}, to meet output times and "
            "jumps"
        )
    if time.cycle is None:
        return text
    return f"{text}; as many in each period of the cycle's search, up to {MOST} periods"
