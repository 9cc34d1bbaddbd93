"""Verlet list with a skin from linked cells, every pair once (i < j), and the contact histories that move with it.

Row i of the list is `entry[start[i]:start[i + 1]]`. An entry holds the index of j in its lower BITS and, above them,
which periodic image of j is meant. Positions are wrapped into the periodic sides only when the list is made: images
stay valid in between.

Source: Allen and Tildesley (2017), Computer Simulation of Liquids, sections 5.3.1 (Verlet list) and 5.3.2 (cells).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from contbed.dem.kernel_arrays import HISTORY, NEAR_WALL, Array, Box, Entries, Indices, Neighbours, Row, Table

BITS = 26  # of an entry for the index of j; the image is above
MASK = (1 << BITS) - 1


@njit(cache=True)
def image_shifts(box: Box) -> Array:
    """Find the vectors (27, 3) [m] to be added to j, by number of the image; 0 is j itself."""
    lower, upper, periodic = box.lower, box.upper, box.periodic
    table = np.zeros((27, 3))
    for image in range(27):
        digit = image
        for axis in range(3):
            side = digit % 3
            digit //= 3
            if side and periodic[axis]:
                length = upper[axis] - lower[axis]
                table[image, axis] = length if side == 1 else -length
    return table


@njit()
def wrap(x: Array, box: Box) -> int:
    """Bring positions into the periodic sides; return a particle outside the other sides, or -1."""
    lower, upper, periodic = box.lower, box.upper, box.periodic
    lost = -1
    for i in range(len(x)):
        for axis in range(3):
            if periodic[axis]:
                length = upper[axis] - lower[axis]
                x[i, axis] -= length * np.floor((x[i, axis] - lower[axis]) / length)
            elif not (lower[axis] <= x[i, axis] <= upper[axis]):
                lost = i
    return lost


@njit()
def _grid(x: Array, box: Box, width: float) -> tuple[Array, Array, Indices]:
    """Choose origin, size and number of the cells; not many more cells than particles."""
    lower, upper, periodic = box.lower, box.upper, box.periodic
    origin, size = np.empty(3), np.empty(3)
    count = np.ones(3, np.int64)
    extent = np.empty(3)
    for axis in range(3):
        if periodic[axis]:
            origin[axis], extent[axis] = lower[axis], upper[axis] - lower[axis]
        else:
            low, high = x[0, axis], x[0, axis]
            for i in range(len(x)):
                low, high = min(low, x[i, axis]), max(high, x[i, axis])
            origin[axis], extent[axis] = low, high - low
    while True:
        for axis in range(3):
            least = 3 if periodic[axis] else 1
            count[axis] = max(least, int(min(extent[axis] / width, 1e6)))
            size[axis] = max(extent[axis] / count[axis], width * 1e-3)
        if count[0] * count[1] * count[2] <= 4 * len(x) + 27:
            return origin, size, count
        width *= 1.25


@njit(cache=True)
def half_list(x: Array, radius: Array, box: Box, skin: float) -> tuple[Indices, Entries]:
    """Make the Verlet list, `start` and `entry`: pairs whose surfaces are closer than `skin` [m]."""
    n, periodic = len(x), box.periodic
    origin, size, count = _grid(x, box, 2.0 * radius.max() + skin)
    cell = np.empty((n, 3), np.int64)
    first = np.zeros(count[0] * count[1] * count[2] + 1, np.int64)
    for i in range(n):
        for axis in range(3):
            cell[i, axis] = min(int((x[i, axis] - origin[axis]) / size[axis]), count[axis] - 1)
        first[(cell[i, 0] * count[1] + cell[i, 1]) * count[2] + cell[i, 2] + 1] += 1
    filled = np.empty_like(first)
    for home in range(len(first)):
        if home > 0:
            first[home] += first[home - 1]
        filled[home] = first[home]
    member = np.empty(n, np.int64)
    for i in range(n):
        home = (cell[i, 0] * count[1] + cell[i, 1]) * count[2] + cell[i, 2]
        member[filled[home]] = i
        filled[home] += 1
    table = image_shifts(box)
    start = np.zeros(n + 1, np.int64)
    entry = np.empty(8 * n + 64, np.int32)
    total = 0
    at = np.empty(3, np.int64)
    for i in range(n):
        for step in range(27):
            image, power, inside, digit = 0, 1, True, step
            for axis in range(3):
                at[axis] = cell[i, axis] + digit % 3 - 1
                digit //= 3
                if at[axis] < 0:
                    inside = inside and periodic[axis]
                    at[axis] += count[axis]
                    image += 2 * power
                elif at[axis] >= count[axis]:
                    inside = inside and periodic[axis]
                    at[axis] -= count[axis]
                    image += power
                power *= 3
            if not inside:
                continue
            home = (at[0] * count[1] + at[1]) * count[2] + at[2]
            for slot in range(first[home], first[home + 1]):
                j = member[slot]
                if j <= i:
                    continue
                dx = x[i, 0] - x[j, 0] - table[image, 0]
                dy = x[i, 1] - x[j, 1] - table[image, 1]
                dz = x[i, 2] - x[j, 2] - table[image, 2]
                reach = radius[i] + radius[j] + skin
                if dx * dx + dy * dy + dz * dz < reach * reach:
                    if total == len(entry):
                        entry = _resized(entry, total, 2 * total)
                    entry[total] = j | (image << BITS)
                    total += 1
        start[i + 1] = total
    return start, _resized(entry, total, total)


@njit()
def _resized(entry: Entries, used: int, length: int) -> Entries:
    """Copy the first `used` entries to an array of another length; loops compile much faster than slices."""
    out = np.empty(length, entry.dtype)
    for k in range(used):
        out[k] = entry[k]
    return out


@njit(error_model="numpy", forceinline=True)
def open_contact(history: Row) -> None:
    """Forget the history of a contact that has opened."""
    history.spring_x, history.spring_y, history.spring_z = 0.0, 0.0, 0.0
    history.first_step, history.impact_speed = -1.0, 0.0


@njit()
def carry_over(old: Neighbours, start: Indices, entry: Entries) -> Table:
    """Copy the histories of closed contacts of an old list to the entries of a new one."""
    new = np.empty(len(entry), HISTORY)
    for k in range(len(entry)):
        open_contact(new[k])
    for i in range(len(start) - 1):
        for k in range(old.start[i], old.start[i + 1]):
            if old.history[k].first_step >= 0.0:
                for m in range(start[i], start[i + 1]):
                    if entry[m] & MASK == old.entry[k] & MASK:
                        new[m] = old.history[k]
                        break
    return new


@njit()
def wall_list(x: Array, radius: Array, walls: Table, skin: float) -> tuple[Table, int]:
    """Find particles closer to walls than `skin` [m], and a particle beyond a wall or -1."""
    found = np.empty(len(x) * len(walls), NEAR_WALL)
    total, lost = 0, -1
    for i in range(len(x)):
        for w in range(len(walls)):
            gap, _, _, _ = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls[w])
            if not gap > 0.0:
                lost = i
            if gap < radius[i] + skin:
                found[total].particle, found[total].wall = i, w
                total += 1
    return found[:total].copy(), lost


@njit(error_model="numpy", forceinline=True)
def wall_distance(x: float, y: float, z: float, wall: Row) -> tuple[float, float, float, float]:
    """Find the distance [m] of a point from a wall, positive in the bed, and the unit normal into the bed.

    `wall` is a row of `kernel_arrays.WALL`.
    """
    dx, dy, dz = x - wall.x, y - wall.y, z - wall.z
    along = dx * wall.unit_x + dy * wall.unit_y + dz * wall.unit_z
    if wall.curvature == 0.0:
        return along, wall.unit_x, wall.unit_y, wall.unit_z
    dx, dy, dz = dx - along * wall.unit_x, dy - along * wall.unit_y, dz - along * wall.unit_z
    off = np.sqrt(dx * dx + dy * dy + dz * dz)
    if off == 0.0:
        return wall.curvature * wall.radius, 0.0, 0.0, 0.0
    side = -wall.curvature / off
    return wall.curvature * (wall.radius - off), side * dx, side * dy, side * dz


@njit(cache=True)
def wall_gaps(x: Array, walls: Table) -> Array:
    """Find the distances [m] of all points from all walls, shape (w, n)."""
    gaps = np.empty((len(walls), len(x)))
    for w in range(len(walls)):
        for i in range(len(x)):
            gaps[w, i] = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls[w])[0]
    return gaps
