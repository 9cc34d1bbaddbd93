"""Swings of the temperature beside fronts that the cells of a bed do not resolve.

    swing of a cell = max_c T - largest mean of the cell and its neighbours

and the same below, where the jump at an end of the cell is as large as counts; beside
the cell at the inlet is the gas that enters. A peak
that is resolved has no jumps, and a jump of flat cells is no swing. Sums over a cell are
right whatever swings.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contbed.arrays import Array
from contbed.reacting_bed.equations.unknowns import TEMPERATURES, Role
from contbed.reacting_bed.problem import Problem

LARGE = 0.03  # of the span of the temperature, above which a swing and a jump count
LEAST_SPAN = 10.0  # [K], so that small differences swing as they like


class Swing(NamedTuple):
    """The largest swing of a state [K], where [m] and when [s] it is."""

    size: float = 0.0
    x: float = 0.0
    time: float = math.nan


def largest_swing(problem: Problem, u: Array, time: float = math.nan) -> Swing:
    """Return the largest swing of the temperatures of a state that counts."""
    rows, line = problem.rows(*TEMPERATURES), problem.line
    T = u[rows]
    if not T.size:
        return Swing()
    mean, shown = T @ line.weights, T @ line.sampled.T
    beside = np.pad(mean, ((0, 0), (1, 1)), mode="edge")
    of_gas = np.isin(rows, problem.rows(*_with_the_gas(problem)))
    first = 0 if problem.streams.ahead else -1
    beside[of_gas, first] = problem.streams.T_gas
    around = np.stack([beside[:, :-2], mean, beside[:, 2:]])
    beyond = np.maximum(
        shown.max(axis=2) - around.max(axis=0), around.min(axis=0) - shown.min(axis=2)
    )
    jumps = np.abs(shown[:, 1:, 0] - shown[:, :-1, -1])
    at_ends = np.pad(jumps, ((0, 0), (1, 1)))
    at_ends[of_gas, first] = np.abs(shown[of_gas, first, first] - problem.streams.T_gas)
    jump = np.maximum(at_ends[:, :-1], at_ends[:, 1:])
    counts = np.minimum(beyond, jump) > LARGE * max(float(np.ptp(mean)), LEAST_SPAN)
    swing = np.where(counts, beyond, 0.0).max(axis=0)
    cell = int(swing.argmax())
    return Swing(float(swing[cell]), float(line.points[cell].mean()), time)


def _with_the_gas(problem: Problem) -> tuple[Role, ...]:
    """Return the temperatures that enter with the gas."""
    if problem.bed.velocity_solid:
        return (Role.T_GAS,)
    return (Role.T, Role.T_GAS)


def unresolved_front(problem: Problem, found: Swing) -> list[str]:
    """Return the warning about a swing, none where there is none."""
    if not found.size:
        return []
    when = "" if math.isnan(found.time) else f" at t = {found.time:.4g} s"
    return [
        f"temperatures swing by {found.size:.2g} K at x = {found.x:.4g} m{when}, beside "
        f"a front that {problem.line.cells} cells do not resolve, so that local values "
        "may lie beyond all that enters: use more mesh.cells, or solver.adapt = 10, "
        "with which cells follow the front"
    ]
