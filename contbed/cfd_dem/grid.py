"""Coarse staggered grid under the particles: cells, faces, who is next to whom, and the
particles' shares in both.

Scalars live in cells, velocities on faces. Faces and cells are numbered through, so
that periodic sides, walls and blocked cells are entries of tables and no kernel knows
an axis by name.

A sphere is in a cell with the part of its volume that planes cut off, the product over
the axes of

    F(b) - F(a),  F(s) = (2 + 3 s - s^3)/4 for s = (plane - x)/R in [-1, 1]

and what lies beyond a wall counts in the cell at the wall, so that no solid leaves the
bed through it. The top is open: what lies above it is not in the gas, and the shares,
which sum to 1, are those of the part within. On faces a particle has trilinear weights,
over the faces on which a velocity is solved for, normalised.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array, Flags, Integers
from contbed.compiled import threads
from contbed.compiled.functions import entry
from contbed.errors import SceneError

INNER, INLET, OUTLET, WALL = range(4)  # what a face is
# points along each axis of a cell for the volumes of faces; exact without blocked cells
SAMPLES = 4


class Tables(NamedTuple):
    """A grid as kernels read it: the tables of `Grid`, `size` (3,) [m] of a cell,
    `shape` in cells.
    """

    size: Array
    cell_face: Integers
    face_cell: Integers
    face_next: Integers
    face_axis: Integers
    face_kind: Integers
    active: Flags
    open_cells: Flags
    shape: tuple[int, int, int]


class Box(NamedTuple):
    """Cells of a grid as kernels count them: lower corner [m], size [m], number and
    periodic sides, each (3,).
    """

    lower: Array
    size: Array
    number: Integers
    periodic: Flags


class Shares(NamedTuple):
    """Cells (n, k) around each sphere, shares (n, k) in them, and the part (n,) of
    the sphere below the top.
    """

    cells: NDArray[np.int32]
    share: Array
    inside: Array


@dataclass(eq=False)
class Grid:
    """Cells from `lower`, of `size` [m], `count` along each axis; z points up, inlet
    below, outlet above.

    `periodic` sides in x and y, otherwise walls. `blocked` cells (count) hold no gas,
    such as those inside of a tube.

    Tables: `cell_face` (c, 6) faces of a cell, low and high in x, y, z; `face_cell` (f,
        2) cells of a face or -1;
    `face_next` (f, 6) faces beside a face or -1; `face_axis`, `face_kind` (f,);
    `face_volume` (f,) [m3], the volume whose particles belong to a face.
    """

    lower: Array
    size: Array
    count: tuple[int, int, int]
    periodic: tuple[bool, bool] = (False, False)
    blocked: Flags | None = None

    def __post_init__(self) -> None:
        self.lower = np.array(self.lower, dtype=float)
        self.size = np.array(self.size, dtype=float)
        if not (self.size > 0.0).all() or min(self.count) < 1:
            raise SceneError(
                f"gas: {self.count} cells of {self.size} m; numbers and sizes must be "
                "positive"
            )
        opened = np.ones(self.count, bool)
        if self.blocked is not None:
            opened = ~np.asarray(self.blocked, dtype=bool)
        if opened.shape != tuple(self.count):
            raise SceneError(
                f"gas: blocked cells of shape {opened.shape}, the grid has {self.count}"
            )
        self.open_cells: Flags = opened.ravel()
        self._connect()
        self.face_volume = self._volumes()
        nx, ny, nz = (int(n) for n in self.count)
        names = (name for name in Tables._fields if name != "shape")
        tables = {name: np.ascontiguousarray(getattr(self, name)) for name in names}
        self.tables = Tables(shape=(nx, ny, nz), **tables)

    @property
    def cells(self) -> int:
        """Number of cells."""
        return int(np.prod(self.count))

    @property
    def volume(self) -> float:
        """Volume of a cell [m3]."""
        return float(np.prod(self.size))

    @property
    def area(self) -> Array:
        """Areas of the faces across x, y, z [m2]."""
        return self.volume / self.size

    @property
    def sides(self) -> Flags:
        """Periodic or not, for each axis."""
        return np.array([*self.periodic, False])

    @property
    def active(self) -> Flags:
        """Faces on which the velocity is solved for."""
        return np.asarray((self.face_kind == INNER) | (self.face_kind == OUTLET))

    @property
    def bottom(self) -> Integers:
        """The inlet faces, shape (nx, ny)."""
        return self.cell_face[:, 4].reshape(self.count)[:, :, 0]

    @property
    def centres(self) -> Array:
        """Centres of all cells [m], (c, 3)."""
        axes = [
            low + (np.arange(n) + 0.5) * s
            for low, n, s in zip(self.lower, self.count, self.size, strict=True)
        ]
        return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)

    @property
    def _box(self) -> Box:
        return Box(self.lower, self.size, np.array(self.count), self.sides)

    def shares(self, x: Array, reach: Array) -> Shares:
        """Find the cells (n, k) around spheres of radius `reach` [m], shares in them
        and the part below the top (n,).

        The shares are those of that part; a sphere above the top has shares of the
        uppermost cells and no such part.
        """
        width = int(np.ceil(2.0 * reach.max() / self.size.min())) + 1
        shape = len(x), width**3
        out = Shares(np.empty(shape, np.int32), np.empty(shape), np.ones(len(x)))
        threads.parallel(
            _cell_shares, len(x), x, reach, self._box, self.open_cells, width, out
        )
        return out

    def weights(self, x: Array) -> tuple[NDArray[np.int32], Array]:
        """Find the faces (n, 3, 8) across x, y, z around each point, and its weights
        on them.
        """
        shape = len(x), 3, 8
        faces, weight = np.empty(shape, np.int32), np.empty(shape)
        threads.parallel(
            _face_weights,
            len(x),
            x,
            self._box,
            self.face_first,
            self.active,
            faces,
            weight,
        )
        return faces, weight

    def _connect(self) -> None:
        """Give the faces numbers, those across x first, and find what is beside each."""
        count, sides = np.array(self.count), self.sides
        number = np.arange(self.cells).reshape(self.count)
        self.cell_face: Integers = np.empty((self.cells, 6), np.int64)
        cells, nexts, axes, kinds, first = [], [], [], [], [0]
        for a in range(3):
            shape = count.copy()
            shape[a] += not sides[a]
            faces = first[-1] + np.arange(shape.prod()).reshape(shape)
            for end in range(2):
                of_cells = _along(faces, np.arange(count[a]) + end, a, sides[a])
                self.cell_face[:, 2 * a + end] = of_cells
            places = (np.arange(shape[a]) + step for step in (-1, 0))
            around = [_along(number, place, a, sides[a]) for place in places]
            beside = [
                _along(faces, np.arange(shape[b]) + step, b, sides[b])
                for b in range(3)
                for step in (-1, 1)
            ]
            cells.append(np.stack(around, axis=1))
            nexts.append(np.stack(beside, axis=1))
            axes.append(np.full(faces.size, a))
            kinds.append(self._kinds(cells[-1], a))
            first.append(first[-1] + faces.size)
        self.face_cell: Integers = np.concatenate(cells)
        self.face_next: Integers = np.concatenate(nexts)
        self.face_axis: Integers = np.concatenate(axes)
        self.face_kind: Integers = np.concatenate(kinds)
        self.face_first: Integers = np.array(first[:3])

    def _kinds(self, around: Integers, axis: int) -> Integers:
        """Return what faces across an axis are, by the cells (n, 2) around them."""
        kind: Integers = np.full(len(around), INNER)
        kind[around[:, 0] < 0] = INLET if axis == 2 else WALL
        kind[around[:, 1] < 0] = OUTLET if axis == 2 else WALL
        kind[((around >= 0) & ~self.open_cells[around]).any(axis=1)] = WALL
        return kind

    def _volumes(self) -> Array:
        offsets = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
        inner = (
            np.stack(np.meshgrid(offsets, offsets, offsets, indexing="ij"), -1).reshape(
                -1, 3
            )
            * self.size
        )
        volume = np.zeros(len(self.face_kind))
        centres = self.centres[self.open_cells]
        for offset in inner:
            faces, weights = self.weights(centres + offset)
            volume += np.bincount(faces.ravel(), weights.ravel(), len(volume))
        return volume * self.volume / len(inner)


def _along(numbers: Integers, place: Integers, axis: int, periodic: bool) -> Integers:
    """Return the numbers (n,) at places along an axis; -1 beyond an open end."""
    size = numbers.shape[axis]
    found = numbers.take(place % size, axis)
    if not periodic:
        np.moveaxis(found, axis, 0)[(place < 0) | (place >= size)] = -1
    return np.asarray(found.ravel())


@entry(nogil=True, cache=True)
def _cell_shares(
    begin: int,
    end: int,
    x: Array,
    reach: Array,
    box: Box,
    opened: Flags,
    width: int,
    out: Shares,
) -> None:
    """Set the shares `out` of spheres in cells; `width` is the most cells that a
    sphere spans along an axis.
    """
    lower, size, count, periodic = box
    cells, share, inside = out
    at, part = np.empty((3, width), np.int64), np.empty((3, width))
    for i in range(begin, end):
        for a in range(3):
            first = int(np.floor((x[i, a] - reach[i] - lower[a]) / size[a]))
            below = 0.0
            for s in range(width):
                t = (lower[a] + (first + s + 1) * size[a] - x[i, a]) / reach[i]
                t = min(max(t, -1.0), 1.0)
                filled = 1.0 if s == width - 1 else 0.25 * (2.0 + 3.0 * t - t * t * t)
                part[a, s] = filled - below
                below = filled
                k = first + s
                at[a, s] = k % count[a] if periodic[a] else min(max(k, 0), count[a] - 1)
                if a == 2 and k == count[a] - 1:
                    inside[i] = filled
                elif a == 2 and k >= count[a]:
                    if s == 0:
                        inside[i] = 0.0
                    elif inside[i] > 0.0:
                        part[a, s] = 0.0
        k, total = 0, 0.0
        for p in range(width):
            for q in range(width):
                for r in range(width):
                    c = (at[0, p] * count[1] + at[1, q]) * count[2] + at[2, r]
                    cells[i, k] = c
                    share[i, k] = (
                        part[0, p] * part[1, q] * part[2, r] if opened[c] else 0.0
                    )
                    total += share[i, k]
                    k += 1
        if total > 0.0 and total != 1.0:
            # one by one: for a slice numba would compile the message of shapes that
            # differ, 1.4 s
            for k in range(width**3):
                share[i, k] /= total


@entry(nogil=True, cache=True, error_model="numpy")
def _face_weights(
    begin: int,
    end: int,
    x: Array,
    box: Box,
    first: Integers,
    active: Flags,
    faces: NDArray[np.int32],
    weight: Array,
) -> None:
    """Set the `faces` (n, 3, 8) around each point and its `weight` on them."""
    lower, size, count, periodic = box
    # along each axis the two faces (0) and the two centres (1) around a point, as
    # numbers along it, and its parts
    at, part = np.empty((2, 3, 2), np.int64), np.empty((2, 3, 2))
    many = np.empty((2, 3), np.int64)
    for b in range(3):
        many[0, b], many[1, b] = count[b] + (0 if periodic[b] else 1), count[b]
    for i in range(begin, end):
        for b in range(3):
            place = (x[i, b] - lower[b]) / size[b]
            for kind in range(2):
                s, last = place - 0.5 * kind, many[kind, b] - 1
                k = int(np.floor(s))
                part[kind, b, 1] = s - k
                part[kind, b, 0] = 1.0 - part[kind, b, 1]
                if 0 <= k < last:
                    at[kind, b, 0], at[kind, b, 1] = k, k + 1
                elif periodic[b]:
                    at[kind, b, 0] = k % (last + 1)
                    at[kind, b, 1] = (k + 1) % (last + 1)
                else:
                    at[kind, b, 0] = min(max(k, 0), last)
                    at[kind, b, 1] = min(max(k + 1, 0), last)
        for a in range(3):
            kx = 0 if a == 0 else 1
            ky = 0 if a == 1 else 1
            kz = 0 if a == 2 else 1
            total, corner = 0.0, 0
            for p in range(2):
                for q in range(2):
                    row = (
                        first[a]
                        + (at[kx, 0, p] * many[ky, 1] + at[ky, 1, q]) * many[kz, 2]
                    )
                    both = part[kx, 0, p] * part[ky, 1, q]
                    for r in range(2):
                        f = row + at[kz, 2, r]
                        w = both * part[kz, 2, r] if active[f] else 0.0
                        faces[i, a, corner], weight[i, a, corner] = f, w
                        total += w
                        corner += 1
            if total > 0.0:
                for corner in range(8):
                    weight[i, a, corner] /= total
