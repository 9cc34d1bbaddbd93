"""Verlet list with a skin from sorted cells, every pair once (i < j in memory), and the
contact histories kept with it.

An entry holds the index of j in its lower BITS, above them which periodic image of j is
meant, and the highest bit is set while the contact is closed. Positions are wrapped
into the periodic sides only when the list is made: images stay valid in between.
Particles are sorted by cell (`ordering`), so that those of a cell follow each other in
memory, and only cells with higher numbers are searched.

Source: Allen and Tildesley (2017), Computer Simulation of Liquids, sections 5.3.1
    (Verlet list) and 5.3.2 (cells).
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from contbed.compiled.functions import entry, inner
from contbed.dem.kernel_arrays import (
    BLOCK,
    Array,
    Box,
    Crossing,
    Entries,
    Indices,
    NearWalls,
    Pairs,
    Row,
    Table,
)
from contbed.dem.ordering import Cells, number_of, place_of

BITS = np.uint32(26)  # of an entry for the index of j; the image is above
MASK = np.uint32((1 << 26) - 1)
IMAGE = np.uint32(31)  # of 27 images, in five bits
IMAGES = 27
CLOSED = np.uint32(1 << 31)


@entry(cache=True)
def image_shifts(box: Box) -> Array:
    """Find the vectors (27, 3) [m] to be added to j, by number of the image; 0 is j
    itself.
    """
    lower, upper, periodic = box.lower, box.upper, box.periodic
    table = np.zeros((IMAGES, 3))
    for image in range(IMAGES):
        digit = image
        for axis in range(3):
            side = digit % 3
            digit //= 3
            if side and periodic[axis]:
                length = upper[axis] - lower[axis]
                table[image, axis] = length if side == 1 else -length
    return table


@inner(nogil=True)
def find_pairs(
    block: int,
    x: Array,
    radius: Array,
    pairs: Pairs,
    cells: Cells,
    first: Entries,
    box: Box,
    skin: float,
) -> tuple[int, int]:
    """Fill the rows of a block; return how many places it needs within the block and
    across blocks.

    Where that is more than there is room for, the list is not complete.
    """
    begin = block * BLOCK
    end = min((block + 1) * BLOCK, len(x))
    image = image_shifts(box)
    base, count = np.empty(2, np.int64), np.zeros(2, np.int64)
    base[0] = block * (pairs.room[0] + pairs.room[1])
    base[1] = base[0] + pairs.room[0]
    # first and last particle of each cell around, and its image
    near = np.empty((28, 3), np.int64)
    home, groups = -1, 0
    for i in range(begin, end):
        for zone in range(2):
            pairs.start[zone, i] = base[zone] + min(count[zone], pairs.room[zone])
        at = (
            place_of(cells, x[i, 0], 0),
            place_of(cells, x[i, 1], 1),
            place_of(cells, x[i, 2], 2),
        )
        number = number_of(cells, at[0], at[1], at[2])
        if number != home:
            home = number
            groups = _cells_after(home, at, cells, first, box, near)
        for g in range(groups):
            shift = near[g, 2]
            sx = x[i, 0] - image[shift, 0]
            sy = x[i, 1] - image[shift, 1]
            sz = x[i, 2] - image[shift, 2]
            for j in range(max(near[g, 0], i + 1), near[g, 1]):
                dx, dy, dz = sx - x[j, 0], sy - x[j, 1], sz - x[j, 2]
                reach = radius[i] + radius[j] + skin
                if dx * dx + dy * dy + dz * dz < reach * reach:
                    zone = 0 if j < end else 1
                    if count[zone] < pairs.room[zone]:
                        m = base[zone] + count[zone]
                        pairs.row[m], pairs.entry[m] = i, j | (shift << 26)
                    count[zone] += 1
        for zone in range(2):
            pairs.stop[zone, i] = base[zone] + min(count[zone], pairs.room[zone])
    for zone in range(2):
        pairs.used[zone, block] = min(count[zone], pairs.room[zone])
    return count[0], count[1]


@inner(nogil=True)
def _cells_after(
    home: int,
    at: tuple[int, int, int],
    cells: Cells,
    first: Entries,
    box: Box,
    near: Indices,
) -> int:
    """Find the particles in the cell `home` and in those around with a higher
    number; return the number of cells.
    """
    groups = 0
    place = np.empty(3, np.int64)
    for step in range(27):
        image, power, inside, digit = 0, 1, True, step
        for axis in range(3):
            place[axis] = at[axis] + digit % 3 - 1
            digit //= 3
            if place[axis] < 0:
                inside = inside and box.periodic[axis]
                place[axis] += cells.along[axis]
                image += 2 * power
            elif place[axis] >= cells.along[axis]:
                inside = inside and box.periodic[axis]
                place[axis] -= cells.along[axis]
                image += power
            power *= 3
        if not inside:
            continue
        number = number_of(cells, place[0], place[1], place[2])
        if number >= home and first[number] < first[number + 1]:
            near[groups, 0] = first[number]
            near[groups, 1] = first[number + 1]
            near[groups, 2] = image
            groups += 1
    return groups


@entry(nogil=True, cache=True)
def find_incoming(pairs: Pairs, crossing: Crossing) -> None:
    """List for every particle the pairs across blocks in which it is j, in ascending
    order; nothing is carried yet.
    """
    start, slot, n = crossing.start, crossing.slot, len(crossing.start) - 1
    inner, across = pairs.room
    for i in range(n + 1):
        start[i] = 0
    for turn in range(2):
        for block in range(pairs.used.shape[1]):
            for m in range(pairs.used[1, block]):
                j = pairs.entry[block * (inner + across) + inner + m] & MASK
                if turn == 0:
                    start[j + 1] += 1
                    for a in range(7):
                        crossing.carried[block * across + m, a] = 0.0
                else:
                    slot[start[j]] = block * across + m
                    start[j] += 1
        if turn == 0:
            for i in range(n):
                start[i + 1] += start[i]
    for i in range(n, 0, -1):
        start[i] = start[i - 1]
    start[0] = 0


@inner(nogil=True)
def carry_pairs(block: int, old: Pairs, new: Pairs, place: Entries) -> None:
    """Copy the histories of closed contacts of a block of the old order to the new
    list.

    The spring is the displacement of i against j: its sign changes where i and j change
    places.
    """
    for zone in range(2):
        base = block * (old.room[0] + old.room[1]) + zone * old.room[0]
        for k in range(base, base + old.used[zone, block]):
            if old.entry[k] < CLOSED:
                continue
            row, other, sign = place[old.row[k]], place[old.entry[k] & MASK], 1.0
            if row > other:
                row, other, sign = other, row, -1.0
            to = 0 if row // BLOCK == other // BLOCK else 1
            for m in range(new.start[to, row], new.stop[to, row]):
                if new.entry[m] & MASK == other:
                    new.entry[m] |= CLOSED
                    for axis in range(3):
                        new.spring[m, axis] = sign * old.spring[k, axis]
                    new.onset[m, 0], new.onset[m, 1] = old.onset[k, 0], old.onset[k, 1]
                    break


@inner(nogil=True)
def find_near_walls(
    block: int, x: Array, radius: Array, near: NearWalls, walls: Table, skin: float
) -> tuple[int, int]:
    """List the particles of a block near to walls; return how many there are, and
    one beyond a wall or -1.
    """
    room = len(near.wall) // len(near.used)
    total, lost, base = 0, -1, block * room
    for i in range(block * BLOCK, min((block + 1) * BLOCK, len(x))):
        for w in range(len(walls)):
            gap, _, _, _ = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls[w])
            if not gap > 0.0:
                lost = i
            if gap < radius[i] + skin:
                if total < room:
                    near.particle[base + total], near.wall[base + total] = i, w
                    near.onset[base + total, 0], near.onset[base + total, 1] = -1.0, 0.0
                    for axis in range(3):
                        near.spring[base + total, axis] = 0.0
                total += 1
    near.used[block] = min(total, room)
    return total, lost


@inner(nogil=True)
def carry_walls(block: int, old: NearWalls, new: NearWalls, place: Entries) -> None:
    """Copy the histories of closed contacts with walls of a block of the old order
    to the new list.
    """
    room, room_new = len(old.wall) // len(old.used), len(new.wall) // len(new.used)
    for k in range(block * room, block * room + old.used[block]):
        if old.onset[k, 0] < 0.0:
            continue
        i = place[old.particle[k]]
        base = i // BLOCK * room_new
        low, high = base, base + new.used[i // BLOCK]
        while low < high:  # particles ascend
            middle = (low + high) // 2
            if new.particle[middle] < i:
                low = middle + 1
            else:
                high = middle
        while low < base + new.used[i // BLOCK] and new.particle[low] == i:
            if new.wall[low] == old.wall[k]:
                for axis in range(3):
                    new.spring[low, axis] = old.spring[k, axis]
                new.onset[low, 0], new.onset[low, 1] = old.onset[k, 0], old.onset[k, 1]
            low += 1


@inner(error_model="numpy", forceinline=True, nogil=True)
def wall_distance(
    x: float, y: float, z: float, wall: Row
) -> tuple[float, float, float, float]:
    """Find the distance [m] of a point from a wall, positive in the bed, and the unit
    normal into the bed.

    `wall` is a row of `kernel_arrays.WALL`.
    """
    dx, dy, dz = x - wall.x, y - wall.y, z - wall.z
    along = dx * wall.unit_x + dy * wall.unit_y + dz * wall.unit_z
    if wall.curvature == 0.0:
        return along, wall.unit_x, wall.unit_y, wall.unit_z
    dx = dx - along * wall.unit_x
    dy = dy - along * wall.unit_y
    dz = dz - along * wall.unit_z
    off = sqrt(dx * dx + dy * dy + dz * dz)
    if off == 0.0:
        return wall.curvature * wall.radius, 0.0, 0.0, 0.0
    side = -wall.curvature / off
    return wall.curvature * (wall.radius - off), side * dx, side * dy, side * dz


@entry(cache=True)
def wall_gaps(x: Array, walls: Table) -> Array:
    """Find the distances [m] of all points from all walls, shape (w, n)."""
    gaps = np.empty((len(walls), len(x)))
    for w in range(len(walls)):
        for i in range(len(x)):
            gaps[w, i] = wall_distance(x[i, 0], x[i, 1], x[i, 2], walls[w])[0]
    return gaps
