"""The neighbour list on a GPU: particles sorted by cell, all neighbours of each,
histories carried from list to list.

What threads do in no certain order, such as to count the particles of cells, is brought
into order at once, so that a run gives the same bits each time. Particles of a cell
keep the order that they had; neighbours ascend.

Source: Allen and Tildesley (2017), Computer Simulation of Liquids, sections 5.3.1
    (Verlet list) and 5.3.2 (cells).
"""

from __future__ import annotations

from math import floor

from numba import int64

from contbed.dem.gpu.arrays import (
    CULPRIT,
    NEEDED,
    RADIUS,
    Bodies,
    Cells,
    DeviceArray,
    Grid,
    Lists,
    X,
    Y,
    Z,
    cuda,
)
from contbed.dem.neighbours import BITS, CLOSED, MASK, wall_distance
from contbed.dem.ordering import place_of

# particles, or cells, that one thread goes through where parts are summed up on the
# host
SHARE = 256


@cuda.jit
def wrap(
    row: DeviceArray,
    lower: DeviceArray,
    upper: DeviceArray,
    periodic: DeviceArray,
    control: DeviceArray,
) -> None:
    """Bring particles into the periodic sides; report one that is outside of the
    other sides.
    """
    i = cuda.grid(1)
    if i >= row.shape[0]:
        return
    for axis in range(3):
        x = row[i, X + axis]
        if periodic[axis]:
            length = upper[axis] - lower[axis]
            row[i, X + axis] = x - length * floor((x - lower[axis]) / length)
        elif not (lower[axis] <= x <= upper[axis]):
            cuda.atomic.min(control, CULPRIT, i)


@cuda.jit
def find_corners(row: DeviceArray, corners: DeviceArray) -> None:
    """Find lower and upper corner [m] of every SHARE particles, shape (parts, 6)."""
    part = cuda.grid(1)
    if part >= corners.shape[0]:
        return
    first = part * SHARE
    for axis in range(3):
        low = row[first, X + axis]
        high = low
        for i in range(first + 1, min(first + SHARE, row.shape[0])):
            low, high = min(low, row[i, X + axis]), max(high, row[i, X + axis])
        corners[part, axis], corners[part, 3 + axis] = low, high


@cuda.jit(device=True)
def _number(grid, x, y, z):
    return (z * grid.along[1] + y) * grid.along[0] + x


@cuda.jit
def clear(first: DeviceArray) -> None:
    """Set the numbers of particles of cells to zero."""
    c = cuda.grid(1)
    if c < first.shape[0]:
        first[c] = 0


@cuda.jit
def count_cells(row: DeviceArray, grid: Grid, cells: Cells) -> None:
    """Find the cell of each particle and its slot there; `first` becomes the number
    of particles of each cell.
    """
    i = cuda.grid(1)
    if i >= row.shape[0]:
        return
    c = _number(
        grid,
        place_of(grid, row[i, X], 0),
        place_of(grid, row[i, Y], 1),
        place_of(grid, row[i, Z], 2),
    )
    cells.cell[i] = c
    cells.slot[i] = cuda.atomic.add(cells.first, c, 1)


@cuda.jit
def sum_shares(first: DeviceArray, sums: DeviceArray) -> None:
    """Sum the numbers of every SHARE cells."""
    part = cuda.grid(1)
    if part >= sums.shape[0]:
        return
    total = 0
    for c in range(part * SHARE, min((part + 1) * SHARE, first.shape[0])):
        total += first[c]
    sums[part] = total


@cuda.jit
def add_up(first: DeviceArray, sums: DeviceArray) -> None:
    """Turn the numbers of cells into the first particle of each, from the first of
    every SHARE cells in `sums`.
    """
    part = cuda.grid(1)
    if part >= sums.shape[0]:
        return
    total = sums[part]
    for c in range(part * SHARE, min((part + 1) * SHARE, first.shape[0])):
        number = first[c]
        first[c] = total
        total += number


@cuda.jit
def scatter(cells: Cells) -> None:
    """Put each particle into its cell."""
    i = cuda.grid(1)
    if i < cells.cell.shape[0]:
        cells.order[cells.first[cells.cell[i]] + cells.slot[i]] = i


@cuda.jit
def order_cells(cells: Cells) -> None:
    """Sort the particles of each cell as they were."""
    c = cuda.grid(1)
    if c >= cells.first.shape[0] - 1:
        return
    order, begin, end = cells.order, cells.first[c], cells.first[c + 1]
    for k in range(begin, end):
        i, m = order[k], k
        while m > begin and order[m - 1] > i:
            order[m] = order[m - 1]
            m -= 1
        order[m] = i
    for k in range(begin, end):
        cells.place[order[k]] = k


@cuda.jit
def reorder(
    row: DeviceArray,
    new_row: DeviceArray,
    old: Bodies,
    new: Bodies,
    listed: DeviceArray,
    cells: Cells,
) -> None:
    """Copy the particles into the new order."""
    i = cuda.grid(1)
    if i >= row.shape[0]:
        return
    k = cells.order[i]
    for a in range(12):
        new_row[i, a] = row[k, a]
    for a in range(6):
        new.half[i, a] = old.half[k, a]
    for a in range(3):
        new.pushed[i, a] = old.pushed[k, a]
        listed[i, a] = row[k, X + a]
    new.heat[i, 0], new.heat[i, 1] = old.heat[k, 0], old.heat[k, 1]
    new.user[i], new.material[i] = old.user[k], old.material[k]


@cuda.jit
def find_neighbours(
    row: DeviceArray,
    lists: Lists,
    grid: Grid,
    first: DeviceArray,
    image: DeviceArray,
    skin: float,
    control: DeviceArray,
) -> None:
    """List the neighbours of each particle, ascending; report how many places were
    needed.
    """
    i = cuda.grid(1)
    if i >= row.shape[0]:
        return
    entry, room, count = lists.entry, lists.entry.shape[0], 0
    x = place_of(grid, row[i, X], 0)
    y = place_of(grid, row[i, Y], 1)
    z = place_of(grid, row[i, Z], 2)
    for step in range(27):
        px, py, pz = x + step % 3 - 1, y + step // 3 % 3 - 1, z + step // 9 - 1
        px, turn_x = _inside(grid, px, 0)
        py, turn_y = _inside(grid, py, 1)
        pz, turn_z = _inside(grid, pz, 2)
        if turn_x < 0 or turn_y < 0 or turn_z < 0:
            continue
        shift = turn_x + 3 * turn_y + 9 * turn_z
        cell = _number(grid, px, py, pz)
        for j in range(first[cell], first[cell + 1]):
            dx = row[i, X] - row[j, X] - image[shift, 0]
            dy = row[i, Y] - row[j, Y] - image[shift, 1]
            dz = row[i, Z] - row[j, Z] - image[shift, 2]
            reach = row[i, RADIUS] + row[j, RADIUS] + skin
            if j != i and dx * dx + dy * dy + dz * dz < reach * reach:
                if count < room:
                    m, value = count, j | (shift << BITS)
                    while m > 0 and entry[m - 1, i] > value:
                        entry[m, i] = entry[m - 1, i]
                        m -= 1
                    entry[m, i] = value
                count += 1
    lists.neighbours[i] = min(count, room)
    cuda.atomic.max(control, NEEDED, count)


@cuda.jit(device=True)
def _inside(grid, place, axis):
    """Return the place of a cell along an axis and the digit of its image; -1 where
    there is none.
    """
    if 0 <= place < grid.along[axis]:
        return place, 0
    if not grid.periodic[axis]:
        return place, -1
    if place < 0:
        return place + grid.along[axis], 2
    return place - grid.along[axis], 1


@cuda.jit
def carry(old: Lists, new: Lists, cells: Cells) -> None:
    """Copy the histories of closed contacts to the new list of each particle, and those
    with walls.

    A spring is that of the particle of lower index: its sign changes where the two
    change places.
    """
    i = cuda.grid(1)
    if i >= cells.order.shape[0]:
        return
    k = cells.order[i]
    for m in range(old.neighbours[k]):
        e = old.entry[m, k]
        if e < CLOSED:
            continue
        other = int64(e & MASK)
        j, sign = cells.place[other], 1.0
        if (k < other) != (i < j):
            sign = -1.0
        for to in range(new.neighbours[i]):
            if new.entry[to, i] & MASK == j:
                new.entry[to, i] |= CLOSED
                for a in range(3):
                    new.spring[to, a, i] = sign * old.spring[m, a, k]
                new.onset[to, 0, i] = old.onset[m, 0, k]
                new.onset[to, 1, i] = old.onset[m, 1, k]
                break
    for w in range(old.wall_onset.shape[0]):
        for a in range(3):
            new.wall_spring[w, a, i] = old.wall_spring[w, a, k]
        new.wall_onset[w, 0, i] = old.wall_onset[w, 0, k]
        new.wall_onset[w, 1, i] = old.wall_onset[w, 1, k]


@cuda.jit
def find_beyond(row: DeviceArray, walls: DeviceArray, control: DeviceArray) -> None:
    """Report a particle that is beyond a wall."""
    i = cuda.grid(1)
    if i >= row.shape[0]:
        return
    for w in range(len(walls)):
        gap, _, _, _ = wall_distance(row[i, X], row[i, Y], row[i, Z], walls[w])
        if not gap > 0.0:
            cuda.atomic.min(control, CULPRIT, i)


@cuda.jit
def find_moved(row: DeviceArray, listed: DeviceArray, moved2: DeviceArray) -> None:
    """Find the largest distance squared [m2] from where the list was made, of every
    SHARE particles.
    """
    part = cuda.grid(1)
    if part >= moved2.shape[0]:
        return
    top = 0.0
    for i in range(part * SHARE, min((part + 1) * SHARE, row.shape[0])):
        dx = row[i, X] - listed[i, 0]
        dy = row[i, Y] - listed[i, 1]
        dz = row[i, Z] - listed[i, 2]
        top = max(top, dx * dx + dy * dy + dz * dz)
    moved2[part] = top


@cuda.jit
def load(to: DeviceArray, first: int, user: DeviceArray, given: DeviceArray) -> None:
    """Copy vectors, shape (n, columns), from the user's order to columns from `first`
    on.
    """
    i = cuda.grid(1)
    if i >= user.shape[0]:
        return
    for a in range(given.shape[1]):
        to[i, first + a] = given[user[i], a]


@cuda.jit
def store(row: DeviceArray, first: int, user: DeviceArray, wanted: DeviceArray) -> None:
    """Copy columns from `first` on to vectors in the user's order."""
    i = cuda.grid(1)
    if i >= user.shape[0]:
        return
    for a in range(wanted.shape[1]):
        wanted[user[i], a] = row[i, first + a]
