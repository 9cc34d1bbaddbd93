"""What changes in the course of a run of a reacting bed: streams that enter and
surroundings of the wall.

A run is cut at every jump of its series and at kinks that are larger than the error of
a step allows, so that no time step crosses one; each stage of a step takes the values
of its own time. A scene `frozen` at a time has numbers in place of all series.
"""

from __future__ import annotations

from itertools import pairwise

from contbed.course.schedule import Schedule
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.streams import INWARD, Boundaries, gas_sign, velocity_of
from contbed.scene.toml_lines import KeyPath


def kinks_passed(schedule: Schedule, scene: s.ReactingScene) -> dict[KeyPath, float]:
    """Return the sizes of kinks of the series that a step may pass."""
    assert scene.time is not None
    start = list(scene.initial.temperatures.values())
    return schedule.small(scene.time.tolerance, start)


def shortest_interval(
    schedule: Schedule, scene: s.ReactingScene, together: float
) -> float:
    """Return the shortest time between changes in a run; those that lie `together`
    count as one [s].
    """
    assert scene.time is not None
    apart, end = [0.0], scene.time.end
    for cut in schedule.cuts(end, kinks_passed(schedule, scene)):
        if cut - apart[-1] > together:
            apart.append(cut)
    return min((b - a for a, b in pairwise(apart)), default=end)


def entering(boundary: Boundaries) -> Boundaries:
    """Return the conditions without temperatures and compositions of streams that do
    not enter.
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
