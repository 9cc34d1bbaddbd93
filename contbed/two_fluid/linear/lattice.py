"""Lattices of a rectangular grid and of coarser ones, on which its symmetric systems
are loaded for iterations.

A place (i, j, k) counts from 0 along the axes, the longest axis first. Its number is
first + i + s (j + n k), and the numbers before and after a lattice are places without
links, so that every place has neighbours in memory and one loop runs over all. Places
without a cell (obstacles) have no links either.

Kernels that take a `Crew` run in all its threads at once. Threads share the places of a
lattice by blocks of a fixed length, and its rows where two become one, so that the
numbers do not depend on how many threads there are; a small lattice is left to the
first of them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contbed.compiled.barrier import Crew, wait
from contbed.two_fluid.compiled import Array, Indices, inner, kernel
from contbed.two_fluid.fv.grid import Grid

# longest over shortest distance of places up to which an axis is coarsened with the
# shortest one; smoothing does not even out what differs along a longer one
MAX_ASPECT = 1.5
BLOCK = 2048  # places that one thread takes without a pause, about 3 us of work
# of a lattice that threads share; on a smaller one a barrier costs more than it saves
MIN_BLOCKS = 4
FINEST = np.int64(0)  # lattice; numba would compile functions again for a Python 0
Index = int | np.int64
# a coarse link spans twice the distance of the links that it is the sum of (Braess
# 1995)
COARSE_LINK = 0.5


class Levels(NamedTuple):
    """All lattices of a grid, nl of them, one after the other in memory.

    first (nl,) : number of the first place;
    size (nl, 3) : places along the axes;
    by (nl, 3) : 2 where two become one
    of_cell (nc,) : place of each cell of the grid
    faces (3, 2) : first interior face across each axis, and the one after the last
    place (ni,) : first place of each interior face
    joined (3, n) : 1 where there is a face between a place and the next one along an
        axis, on the first lattice
    axes : dim zeros; a tuple, so that its length is known to the compiler
    """

    first: Indices
    size: Indices
    by: Indices
    of_cell: Indices
    faces: Indices
    place: Indices
    joined: Array
    axes: tuple[int, ...]


class Stencil(NamedTuple):
    """Symmetric system on all lattices: diagonal x - sum of links times the neighbours.

    fast, middle, slow (total,) : links from each place to the next one along the first,
    second and third axis diagonal (total,) and its inverse, 0 where there is no cell
    """

    fast: Array
    middle: Array
    slow: Array
    diagonal: Array
    inverse: Array


def build_levels(grid: Grid) -> Levels | None:
    """Lattices of a grid; None where it is not rectangular, or where a periodic pair
    closes it.
    """
    if grid.places is None or grid.dimension == 1:
        return None
    order = np.argsort(-grid.places.max(axis=0), kind="stable")
    place = grid.places[:, order]
    n = np.ones(3, dtype=np.int64)
    n[: grid.dimension] = place.max(axis=0) + 1
    spacing = np.full(3, np.inf)
    spacing[: grid.dimension] = np.ptp(grid.centres, axis=0)[order] / np.maximum(
        n[: grid.dimension] - 1, 1
    )
    spacing[n == 1] = np.inf
    first, sizes, halved, at = [], [], [], 0
    while True:
        around = n[0] * (n[1] if grid.dimension > 2 else 1)
        first.append(at + around)
        sizes.append(n.copy())
        at += around + int(np.prod(n)) + around
        by = np.where((n > 1) & (spacing <= MAX_ASPECT * spacing.min()), 2, 1)
        halved.append(by)
        if (n == 1).all():
            break
        n, spacing = -(-n // by), spacing * by
        spacing[n == 1] = np.inf
    strides = np.array([1, sizes[0][0], sizes[0][0] * sizes[0][1]])
    index = first[0] + place @ strides[: grid.dimension]
    g, joined = grid.geometry, np.zeros((3, at))
    across = np.argmax(np.abs(g.normal[: grid.interior]), axis=1)
    axis = np.argsort(order)[across]
    start = index[g.left[: grid.interior]]
    joined[axis, start] = 1.0
    faces = np.zeros((3, 2), dtype=np.int64)
    for a in np.unique(axis):
        of_axis = np.flatnonzero(axis == a)
        faces[a] = of_axis[0], of_axis[-1] + 1
    return Levels(
        np.array(first),
        np.array(sizes),
        np.array(halved),
        index,
        faces,
        start,
        joined,
        (0,) * grid.dimension,
    )


def empty_stencil(levels: Levels) -> Stencil:
    """Make a system without links."""
    total = levels.joined.shape[1]
    return Stencil(*(np.zeros(total) for _ in Stencil._fields))


@inner
def shared(levels: Levels, level: Index) -> bool:
    """Whether threads share a lattice."""
    return blocks(levels, level) >= MIN_BLOCKS


@inner
def blocks(levels: Levels, level: Index) -> int:
    """Return the number of blocks of a lattice."""
    nx, ny, nz = levels.size[level]
    return int((nx * ny * nz + BLOCK - 1) // BLOCK)


@inner
def share(crew: Crew, levels: Levels, level: Index, count: int) -> tuple[int, int]:
    """Which of `count` equal pieces of a lattice a thread takes: the first, and the
    one after the last.
    """
    if shared(levels, level):
        return count * crew.number // crew.size, count * (crew.number + 1) // crew.size
    return 0, count if crew.number == 0 else 0


@inner
def span(levels: Levels, level: Index) -> tuple[Any, Any, Any, Any]:
    """First place of a lattice, the one after its last, and the distances of places
    along the second and third axis.
    """
    begin, s1 = np.uint64(levels.first[level]), np.uint64(levels.size[level, 0])
    s2 = np.uint64(levels.size[level, 0] * levels.size[level, 1])
    return begin, begin + s2 * np.uint64(levels.size[level, 2]), s1, s2


@inner
def block(levels: Levels, level: Index, number: int) -> tuple[Any, Any]:
    """First place of a block of a lattice, and the one after its last."""
    begin, end, _, _ = span(levels, level)
    first = begin + np.uint64(number * BLOCK)
    return first, min(end, first + np.uint64(BLOCK))


@inner
def load_links(crew: Crew, levels: Levels, coef: Array, out: Stencil) -> None:
    """Set the links of the first lattice to those of the interior faces, `coef`
    (nf,).
    """
    place = levels.place
    for axis in range(len(levels.axes)):
        first, count = (
            levels.faces[axis, 0],
            levels.faces[axis, 1] - levels.faces[axis, 0],
        )
        lowest, highest = share(crew, levels, FINEST, count)
        for f in range(first + lowest, first + highest):
            if axis == 0:
                out.fast[place[f]] = coef[f]
            elif axis == 1:
                out.middle[place[f]] = coef[f]
            else:
                out.slow[place[f]] = coef[f]


@kernel
def set_up_pressure(
    crew: Crew,
    levels: Levels,
    coef: Array,
    rest: Array,
    floating: bool,
    out: Stencil,
    work: Array,
) -> None:
    """Set the systems of all lattices to links `coef` (nf,) and to the `rest` (nc,) of
    the diagonal of each cell.

    The diagonal of the first cell counts twice where the system is `floating`. `work`
    (total,) is a workspace.
    """
    load_links(crew, levels, coef, out)
    first, last = share(crew, levels, FINEST, len(rest))
    for c in range(first, last):
        out.diagonal[levels.of_cell[c]] = rest[c]
    wait(crew)
    _add_links(crew, levels, FINEST, out)
    wait(crew)
    if floating and crew.number == 0:
        out.diagonal[levels.of_cell[0]] *= 2.0
        out.inverse[levels.of_cell[0]] *= 0.5
    wait(crew)
    _coarsen(crew, levels, out, work)


@kernel
def add_neighbours(levels: Levels, stiff: Array, solved: Array) -> None:
    """Set `solved` to 1 in stiff cells and their neighbours."""
    begin, end, s1, s2 = span(levels, FINEST)
    one, joined = np.uint64(1), levels.joined
    for p in range(begin, end):
        near = max(
            stiff[p],
            max(joined[0, p] * stiff[p + one], joined[0, p - one] * stiff[p - one]),
        )
        near = max(
            near, max(joined[1, p] * stiff[p + s1], joined[1, p - s1] * stiff[p - s1])
        )
        if len(levels.axes) > 2:
            near = max(
                near,
                max(joined[2, p] * stiff[p + s2], joined[2, p - s2] * stiff[p - s2]),
            )
        solved[p] = near


class Exchange(NamedTuple):
    """One component of a system: links (nf,) of faces, content (nc,), rest (nc,) of
    links of each cell to given values.

    solved (total,) : 1 in the places that are solved for; stiff : whether iterations
    use multigrid
    """

    coef: Array
    content: Array
    rest: Array
    solved: Array
    stiff: bool


@kernel
def set_up_exchange(
    crew: Crew, levels: Levels, exchange: Exchange, out: Stencil, work: Array
) -> None:
    """Keep the links between cells that are solved for; set the diagonal to the content
    and all links that stay.

    `work` (total,) is a workspace.
    """
    one, fast, middle, slow = np.uint64(1), out.fast, out.middle, out.slow
    solved, content, rest = exchange.solved, exchange.content, exchange.rest
    _, _, s1, s2 = span(levels, FINEST)
    load_links(crew, levels, exchange.coef, out)
    wait(crew)
    first, last = share(crew, levels, FINEST, blocks(levels, FINEST))
    for number in range(first, last):
        begin, end = block(levels, FINEST, number)
        for p in range(begin, end):
            fast[p] *= solved[p] * solved[p + one]
        for p in range(begin, end):
            middle[p] *= solved[p] * solved[p + s1]
        if len(levels.axes) > 2:
            for p in range(begin, end):
                slow[p] *= solved[p] * solved[p + s2]
    first, last = share(crew, levels, FINEST, len(content))
    for c in range(first, last):
        out.diagonal[levels.of_cell[c]] = (
            content[c] + solved[levels.of_cell[c]] * rest[c]
        )
    wait(crew)
    _add_links(crew, levels, FINEST, out)
    wait(crew)
    if exchange.stiff:
        _coarsen(crew, levels, out, work)


@inner
def _add_links(crew: Crew, levels: Levels, level: Index, out: Stencil) -> None:
    """Add the links of each place of a lattice to the diagonal, and set its inverse."""
    _, _, s1, s2 = span(levels, level)
    one = np.uint64(1)
    fast, middle, slow, diagonal, inverse = (
        out.fast,
        out.middle,
        out.slow,
        out.diagonal,
        out.inverse,
    )
    first, last = share(crew, levels, level, blocks(levels, level))
    for number in range(first, last):
        begin, end = block(levels, level, number)
        for p in range(begin, end):
            total = diagonal[p] + fast[p] + fast[p - one] + middle[p] + middle[p - s1]
            if len(levels.axes) > 2:
                total += slow[p] + slow[p - s2]
            diagonal[p] = total
            inverse[p] = 1.0 / total if total > 0.0 else 0.0


@inner
def _coarsen(crew: Crew, levels: Levels, out: Stencil, rest: Array) -> None:
    """Set the systems of all coarser lattices from that of the first one; `rest`
    (total,) is a workspace.

    A coarse place has the sum of what its places have besides links, and of the links
    that lead out of it.
    """
    for level in range(len(levels.first) - 1):
        if shared(levels, level) or crew.number == 0:
            _, by, bz = levels.by[level]
            _, ny, nz = levels.size[level]
            _, cy, cz = levels.size[level + 1]
            first, last = share(crew, levels, level, cy * cz)
            for row in range(first, last):
                _empty_row(levels, level + 1, row, out)
                for k in range(row // cy * bz, min(nz, (row // cy + 1) * bz)):
                    for j in range(row % cy * by, min(ny, (row % cy + 1) * by)):
                        _coarsen_row(levels, level, j, k, out, rest)
            if shared(levels, level):
                wait(crew)
            _add_links(crew, levels, level + 1, out)
            if shared(levels, level):
                wait(crew)


@inner
def _empty_row(levels: Levels, level: Index, row: int, out: Stencil) -> None:
    """Set the system of a row of a lattice to zero."""
    nx = levels.size[level, 0]
    start = levels.first[level] + nx * row
    for p in range(start, start + nx):
        out.fast[p] = out.middle[p] = out.diagonal[p] = 0.0
    if len(levels.axes) > 2:
        for p in range(start, start + nx):
            out.slow[p] = 0.0


@inner
def _coarsen_row(
    levels: Levels, level: Index, j: int, k: int, out: Stencil, rest: Array
) -> None:
    """Add the row (j, k) of a lattice to its row on the next one."""
    dim = len(levels.axes)
    nx, ny, _ = levels.size[level]
    bx, by, bz = levels.by[level]
    cx, cy, _ = levels.size[level + 1]
    row, to = (
        levels.first[level] + nx * (j + ny * k),
        levels.first[level + 1] + cx * (j // by + cy * (k // bz)),
    )
    for p in range(row, row + nx):
        total = (
            out.diagonal[p]
            - out.fast[p]
            - out.fast[p - 1]
            - out.middle[p]
            - out.middle[p - nx]
        )
        if dim > 2:
            total -= out.slow[p] + out.slow[p - nx * ny]
        rest[p] = max(total, 0.0)
    along = COARSE_LINK if bx > 1 else 1.0
    aside = COARSE_LINK if by > 1 else 1.0
    across = COARSE_LINK if bz > 1 else 1.0
    for b in range(bx):
        for i in range((nx - b + bx - 1) // bx):
            out.diagonal[to + i] += rest[row + bx * i + b]
        if j % by == by - 1:
            for i in range((nx - b + bx - 1) // bx):
                out.middle[to + i] += aside * out.middle[row + bx * i + b]
        if dim > 2 and k % bz == bz - 1:
            for i in range((nx - b + bx - 1) // bx):
                out.slow[to + i] += across * out.slow[row + bx * i + b]
    for i in range(nx // bx):
        out.fast[to + i] += along * out.fast[row + bx * i + bx - 1]
