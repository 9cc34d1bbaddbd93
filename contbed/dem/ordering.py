"""The order of particles in memory: by cells along a Morton curve, so that neighbours
in space are near in memory.

Cells are as wide as a contact reaches. Up to 8 x 8 x 8 of them form a cube; cells in a
cube, and cubes, are numbered by interleaving the bits of their places along x, y and z.
Particles are sorted by the number of their cell each time that the Verlet list is made
anew: a bed that mixes stays in order, and the list needs the sorted particles anyway.

Source: Morton (1966), A computer oriented geodetic data base, IBM.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contbed.compiled.functions import inner
from contbed.dem.kernel_arrays import BLOCK, Array, Box, Entries, Indices, Side, Sorting

CUBE = 3  # bits of a cell's place in its cube, along each axis
MOST_CELLS = 5  # times the number of particles, and as many as a cube has


class Cells(NamedTuple):
    """Cells of a box: origin and size [m], number `along` each axis (3,); what numbers
    them.

    inner : (3, 2^CUBE) bits that the place in a cube gives to the number
    cube : (cubes,) number of each cube along the curve, in row-major order
    cubes : (3,) number of cubes along each axis
    bits : of the number of a cell in its cube
    """

    origin: Array
    size: Array
    along: Indices
    inner: Indices
    cube: Indices
    cubes: Indices
    bits: int | np.int64


@inner(nogil=True)
def cells_around(corners: Array, box: Box, width: float, n: int) -> Cells:
    """Choose cells at least `width` [m] wide around n particles, not many more cells
    than particles.
    """
    origin = np.empty(3)
    size = np.empty(3)
    extent = np.empty(3)
    count = np.ones(3, np.int64)
    for axis in range(3):
        low, high = box.lower[axis], box.upper[axis]
        if not box.periodic[axis]:
            low, high = corners[0, axis], corners[0, 3 + axis]
            for b in range(1, len(corners)):
                low, high = min(low, corners[b, axis]), max(high, corners[b, 3 + axis])
        origin[axis], extent[axis] = low, high - low
    while True:
        # a plain 0 has a type of its own, for which `_numbered` would be compiled again
        total, bits = 1, np.int64(0)
        for axis in range(3):
            least = 3 if box.periodic[axis] else 1
            count[axis] = max(least, int(min(extent[axis] / width, 1e6)))
            size[axis] = max(extent[axis] / count[axis], width * 1e-3)
            deep = _bits(count[axis])
            total *= ((count[axis] - 1) >> deep) + 1
            bits += deep
        if total << bits <= MOST_CELLS * n + (1 << (3 * CUBE)):
            return _numbered(origin, size, count, bits)
        width *= 1.25


@inner(nogil=True)
def _bits(count: int) -> int:
    """Find the bits that the place in a cube needs."""
    bits = 0
    while bits < CUBE and (1 << bits) < count:
        bits += 1
    return bits


@inner(nogil=True)
def _numbered(
    origin: Array, size: Array, count: Indices, bits: int | np.int64
) -> Cells:
    """Give numbers to the cells of a cube, and to the cubes, along Morton curves."""
    inner, cubes = np.zeros((3, 1 << CUBE), np.int64), np.empty(3, np.int64)
    place = 0
    for bit in range(CUBE):
        for axis in range(3):
            if bit < _bits(count[axis]):
                for k in range(1 << CUBE):
                    inner[axis, k] += ((k >> bit) & 1) << place
                place += 1
    widest = 0
    for axis in range(3):
        cubes[axis] = ((count[axis] - 1) >> _bits(count[axis])) + 1
        widest = max(widest, cubes[axis])
    levels = 0
    while (1 << levels) < widest:
        levels += 1
    cube, number = np.zeros(cubes[0] * cubes[1] * cubes[2], np.int64), 0
    at = np.empty(3, np.int64)
    for code in range(np.int64(1) << (3 * levels)):
        at[0], at[1], at[2] = 0, 0, 0
        for bit in range(levels):
            for axis in range(3):
                at[axis] += ((code >> (3 * bit + axis)) & 1) << bit
        if at[0] < cubes[0] and at[1] < cubes[1] and at[2] < cubes[2]:
            cube[(at[0] * cubes[1] + at[1]) * cubes[2] + at[2]] = number
            number += 1
    return Cells(origin, size, count, inner, cube, cubes, bits)


@inner(nogil=True)
def number_of(cells: Cells, x: int, y: int, z: int) -> int:
    """Return the number of the cell at a place."""
    # an axis of few cells has cubes of fewer, so that the shift cannot be the constant
    # CUBE
    sx, sy, sz = _bits(cells.along[0]), _bits(cells.along[1]), _bits(cells.along[2])
    cube = cells.cube[
        ((x >> sx) * cells.cubes[1] + (y >> sy)) * cells.cubes[2] + (z >> sz)
    ]
    inside = cells.inner[0, x & ((1 << sx) - 1)] + cells.inner[1, y & ((1 << sy) - 1)]
    return int((cube << cells.bits) + inside + cells.inner[2, z & ((1 << sz) - 1)])


@inner(nogil=True)
def place_of(cells: Any, position: float, axis: int) -> int:
    """Return the place of a position [m] along an axis, from 0; of `Cells`, or
    others with origin, size and along.
    """
    return int(
        min(
            int((position - cells.origin[axis]) / cells.size[axis]),
            cells.along[axis] - 1,
        )
    )


@inner(nogil=True)
def find_cells(block: int, x: Array, cells: Cells, cell: Entries) -> None:
    """Find the number of the cell of each particle of a block."""
    for i in range(block * BLOCK, min((block + 1) * BLOCK, len(x))):
        cell[i] = number_of(
            cells,
            place_of(cells, x[i, 0], 0),
            place_of(cells, x[i, 1], 1),
            place_of(cells, x[i, 2], 2),
        )


@inner(nogil=True)
def sort(sorting: Sorting, cells: Cells) -> None:
    """Sort the particles by cell, those of a cell as they were (a counting sort)."""
    cell, order, place, first = sorting
    total = len(cells.cube) << cells.bits
    for c in range(total + 1):
        first[c] = 0
    for i in range(len(cell)):
        first[cell[i] + 1] += 1
    for c in range(total):
        first[c + 1] += first[c]
    for i in range(len(cell)):
        order[first[cell[i]]] = i
        place[i] = first[cell[i]]
        first[cell[i]] += 1
    # each has become the first of the next cell
    for c in range(total, 0, -1):
        first[c] = first[c - 1]
    first[0] = 0


@inner(nogil=True)
def reorder(block: int, old: Side, new: Side, order: Entries) -> None:
    """Copy the particles of a block of the new order from the old one."""
    a = old.bodies
    b = new.bodies
    is_warm = len(old.heat.T) > 0
    is_mixed = not old.spheres.equal
    for i in range(block * BLOCK, min((block + 1) * BLOCK, len(order))):
        k = order[i]
        b.user[i] = a.user[k]
        for axis in range(3):
            b.position[i, axis] = a.position[k, axis]
            new.pairs.listed[i, axis] = a.position[k, axis]
            b.pushed[i, axis] = a.pushed[k, axis]
        for m in range(6):
            b.motion[i, m], b.half[i, m] = a.motion[k, m], a.half[k, m]
        if is_mixed:
            new.spheres.radius[i] = old.spheres.radius[k]
            new.spheres.mass[i] = old.spheres.mass[k]
            new.spheres.inertia[i] = old.spheres.inertia[k]
            new.spheres.material[i] = old.spheres.material[k]
        if is_warm:
            new.heat.T[i], new.heat.source[i] = old.heat.T[k], old.heat.source[k]
            new.heat.inverse_capacity[i] = old.heat.inverse_capacity[k]


@inner(nogil=True)
def wrap(block: int, x: Array, box: Box, culprits: Indices, corners: Array) -> None:
    """Bring particles of a block into the periodic sides; note its corners, and one
    outside of the other sides.
    """
    lower, upper, periodic = box.lower, box.upper, box.periodic
    culprits[block] = -1
    begin, end = block * BLOCK, min((block + 1) * BLOCK, len(x))
    for axis in range(3):
        low, high = np.inf, -np.inf
        for i in range(begin, end):
            if periodic[axis]:
                length = upper[axis] - lower[axis]
                x[i, axis] -= length * np.floor((x[i, axis] - lower[axis]) / length)
            elif not (lower[axis] <= x[i, axis] <= upper[axis]):
                culprits[block] = i
            low, high = min(low, x[i, axis]), max(high, x[i, axis])
        corners[block, axis], corners[block, 3 + axis] = low, high
