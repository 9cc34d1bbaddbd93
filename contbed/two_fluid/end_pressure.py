"""Pressure on floor and roof: from the cells there by their gradient, which is exact
where it is linear.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.boundary import MIN_UPRIGHT, OUTLET, Edge
from contbed.two_fluid.compiled import Array, Indices
from contbed.two_fluid.fv.grid import Grid

# share of the height of the bed by which faces of one end may lie lower or higher
LEVEL = 1e-6


class EndPressure(NamedTuple):
    """Mean pressure of an end as weights @ p + outside, with weights (nc,) of the
    cells and the outlets' part [Pa].
    """

    weights: Array
    outside: float

    def mean(self, p: Array) -> float:
        """Pressure [Pa] of the end where the cells have p (nc,) [Pa]."""
        return float(self.weights @ p) + self.outside


def end_pressure(grid: Grid, edge: Edge, side: int) -> EndPressure:
    """Mean over the area of the bottom (side -1) or the top (1), zero where these are
    periodic.

    An outlet has the pressure outside. On other faces the pressure of the cell is
    extended by its gradient, the least squares over its neighbours with weights
    1/distance^2, on skewed grids also over theirs.
    """
    g, first, end = grid.geometry, grid.interior, end_faces(grid, side)
    weights, outside = np.zeros(len(grid.cells)), 0.0
    share = g.area[first + end] / max(g.area[first + end].sum(), np.finfo(float).tiny)
    reach = _steps_to_neighbours(grid) if len(end) else None
    for b, part in zip(end, share, strict=True):
        if edge.gas.kind[b] == OUTLET:
            outside += part * edge.p[b]
            continue
        assert reach is not None
        cell = g.left[first + b]
        around, steps = _patch(cell, grid.skewed, *reach)
        slopes = (
            np.linalg.pinv(steps / (length := np.linalg.norm(steps, axis=1))[:, None])
            / length
        )
        jumps = g.arm_left[first + b] @ slopes
        weights[cell] += part * (1.0 - jumps.sum())
        np.add.at(weights, around, part * jumps)
    return EndPressure(weights, outside)


def end_faces(grid: Grid, side: int) -> Indices:
    """Return the boundary faces of the bottom (side -1) or the top (1), counted from
    the first one; none where these are periodic.
    """
    height = side * grid.middles[grid.interior :, -1]
    near = height.max(initial=-np.inf) - LEVEL * np.ptp(grid.centres[:, -1])
    upright = side * grid.geometry.normal[grid.interior :, -1] > MIN_UPRIGHT
    return np.flatnonzero((height >= near) & upright)


def _steps_to_neighbours(grid: Grid) -> tuple[Indices, Indices, Array]:
    """Neighbours of all cells: where those of each begin, their cells and the steps
    (n, dim) [m] to their centres.
    """
    g, ni = grid.geometry, grid.interior
    here, there = (
        np.concatenate((g.left[:ni], g.right)),
        np.concatenate((g.right, g.left[:ni])),
    )
    step = g.arm_left[:ni] - g.arm_right
    order = np.argsort(here, kind="stable")
    begin = np.searchsorted(here[order], np.arange(len(grid.cells) + 1))
    return begin, there[order], np.concatenate((step, -step))[order]


def _patch(
    cell: int, wide: bool, begin: Indices, there: Indices, steps: Array
) -> tuple[Indices, Array]:
    """Cells around a cell and the steps to their centres; a wide patch has the
    neighbours of neighbours.
    """
    near = slice(begin[cell], begin[cell + 1])
    cells, ways = [there[near]], [steps[near]]
    for middle, way in zip(there[near], steps[near], strict=True) if wide else ():
        more = slice(begin[middle], begin[middle + 1])
        other = there[more] != cell
        cells.append(there[more][other])
        ways.append(way + steps[more][other])
    return np.concatenate(cells), np.concatenate(ways)
