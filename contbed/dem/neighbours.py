"""Neighbours: a half list of pairs (i < j) from a grid of cells, one skin wide, and the histories that move with it.

Row i of the list is `mates[start[i]:start[i + 1]]`. An entry holds the index of j and, above it, which periodic image
of j is meant. Positions are wrapped into the periodic sides only when the list is made: images stay valid in between.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from contbed.dem.contact import HISTORY, SINCE

BITS = 26  # of an entry for the index of j; the image is above
MASK = (1 << BITS) - 1


@njit(cache=True)
def shifts(lower, upper, periodic):
    """Vectors (27, 3) [m] to be added to j, by number of the image; 0 is j itself."""
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


@njit
def wrap(x, lower, upper, periodic):
    """Bring positions into the periodic sides; index of a particle outside the other sides, or -1."""
    lost = -1
    for i in range(len(x)):
        for axis in range(3):
            if periodic[axis]:
                length = upper[axis] - lower[axis]
                x[i, axis] -= length * np.floor((x[i, axis] - lower[axis]) / length)
            elif not (lower[axis] <= x[i, axis] <= upper[axis]):
                lost = i
    return lost


@njit
def _grid(x, lower, upper, periodic, width):
    """Origin, size and number of the cells; not many more cells than particles."""
    origin, size = np.empty(3), np.empty(3)
    count = np.ones(3, np.int64)
    extent = np.empty(3)
    for axis in range(3):
        if periodic[axis]:
            origin[axis], extent[axis] = lower[axis], upper[axis] - lower[axis]
        else:
            origin[axis] = x[:, axis].min()
            extent[axis] = x[:, axis].max() - origin[axis]
    while True:
        for axis in range(3):
            least = 3 if periodic[axis] else 1
            count[axis] = max(least, int(min(extent[axis] / width, 1e6)))
            size[axis] = max(extent[axis] / count[axis], width * 1e-3)
        if count[0] * count[1] * count[2] <= 4 * len(x) + 27:
            return origin, size, count
        width *= 1.25


@njit(cache=True)
def half_list(x, radius, lower, upper, periodic, skin):
    """Rows of the half list, `start` and `mates`: pairs whose surfaces are closer than `skin` [m]."""
    n = len(x)
    origin, size, count = _grid(x, lower, upper, periodic, 2.0 * radius.max() + skin)
    cell = np.empty((n, 3), np.int64)
    first = np.zeros(count[0] * count[1] * count[2] + 1, np.int64)
    for i in range(n):
        for axis in range(3):
            cell[i, axis] = min(int((x[i, axis] - origin[axis]) / size[axis]), count[axis] - 1)
        first[(cell[i, 0] * count[1] + cell[i, 1]) * count[2] + cell[i, 2] + 1] += 1
    first = np.cumsum(first)
    filled = first[:-1].copy()
    member = np.empty(n, np.int64)
    for i in range(n):
        home = (cell[i, 0] * count[1] + cell[i, 1]) * count[2] + cell[i, 2]
        member[filled[home]] = i
        filled[home] += 1
    table = shifts(lower, upper, periodic)
    start = np.zeros(n + 1, np.int64)
    mates = np.empty(8 * n + 64, np.int32)
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
                    if total == len(mates):
                        longer = np.empty(2 * total, np.int32)
                        longer[:total] = mates
                        mates = longer
                    mates[total] = j | (image << BITS)
                    total += 1
        start[i + 1] = total
    return start, mates[:total].copy()


@njit
def carry_over(start, mates, past, new_start, new_mates):
    """Histories of the closed contacts of one list, in the rows of a new one."""
    new = np.zeros((len(new_mates), HISTORY))
    new[:, SINCE] = -1.0
    for i in range(len(start) - 1):
        for k in range(start[i], start[i + 1]):
            if past[k, SINCE] >= 0.0:
                for m in range(new_start[i], new_start[i + 1]):
                    if new_mates[m] & MASK == mates[k] & MASK:
                        new[m] = past[k]
                        break
    return new


@njit
def wall_list(x, radius, walls, skin):
    """Rows (particle, wall) of those closer than `skin` [m], and a particle beyond a wall or -1."""
    found = np.empty((len(x) * len(walls), 2), np.int32)
    total, lost = 0, -1
    for i in range(len(x)):
        for w in range(len(walls)):
            gap, _, _, _ = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls[w])
            if not gap > 0.0:
                lost = i
            if gap < radius[i] + skin:
                found[total, 0], found[total, 1] = i, w
                total += 1
    return found[:total].copy(), lost


@njit(error_model="numpy", forceinline=True)
def wall_distance(x, y, z, wall):
    """Distance [m] of a point from a wall, positive in the bed, and the unit normal into the bed.

    `wall` holds kind (0 plane, 1 bed inside a cylinder, -1 bed outside), point (3), direction (3), radius.
    """
    dx, dy, dz = x - wall[1], y - wall[2], z - wall[3]
    along = dx * wall[4] + dy * wall[5] + dz * wall[6]
    if wall[0] == 0.0:
        return along, wall[4], wall[5], wall[6]
    dx, dy, dz = dx - along * wall[4], dy - along * wall[5], dz - along * wall[6]
    off = np.sqrt(dx * dx + dy * dy + dz * dz)
    if off == 0.0:
        return wall[0] * wall[7], 0.0, 0.0, 0.0
    side = -wall[0] / off
    return wall[0] * (wall[7] - off), side * dx, side * dy, side * dz


@njit(cache=True)
def wall_gaps(x, walls):
    """Distances [m] of all points from all walls, shape (w, n)."""
    gaps = np.empty((len(walls), len(x)))
    for w in range(len(walls)):
        for i in range(len(x)):
            gaps[w, i] = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls[w])[0]
    return gaps
