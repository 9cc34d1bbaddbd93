"""Built-in meshes by the coordinates along their axes alone: any nodes and cells of
them, without the others.

Ranks make their shares of a mesh with this, in the numbering that `mesh.build` gives
the whole one (scikit-fem's `init_tensor`): nodes run along y first, then x, then z; so
do the rectangles or bricks that cells are or are cut from.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import skfem
from numpy.typing import NDArray

from contbed.arrays import Array, Flags

Indices = NDArray[np.int64]

AT_ONCE = 100_000  # cells that are compared at a time
# of the axes by dimension, the one first along which numbers run first
ORDERS = {1: (0,), 2: (1, 0), 3: (1, 0, 2)}
# corners of a brick as steps along x, y, z, in scikit-fem's order
BRICK = (
    (0, 0, 0),
    (0, 1, 0),
    (1, 0, 0),
    (0, 0, 1),
    (1, 1, 0),
    (0, 1, 1),
    (1, 0, 1),
    (1, 1, 1),
)
CORNERS = {1: ((0,), (1,)), 2: ((0, 0), (0, 1), (1, 1), (1, 0)), 3: BRICK}
TETRAHEDRA = (
    (0, 1, 5, 7),
    (0, 1, 4, 7),
    (0, 2, 4, 7),
    (0, 3, 5, 7),
    (0, 2, 6, 7),
    (0, 3, 6, 7),
)
# triangles of a rectangle whose diagonal leaves its first corner
HALVES = ((0, 1, 2), (0, 2, 3))


@dataclass(frozen=True, eq=False)
class Tensor:
    """A mesh of cells of a `kind` of scikit-fem on `axes`: increasing
    coordinates [m] along each.
    """

    kind: type[skfem.Mesh]
    axes: tuple[Array, ...]

    @cached_property
    def shape(self) -> Indices:
        """Number of nodes along each axis (dim,)."""
        return np.array([len(x) for x in self.axes])

    @property
    def order(self) -> tuple[int, ...]:
        """Axes, the one first along which numbers run first."""
        return ORDERS[len(self.axes)]

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return int(np.prod(self.shape))

    @property
    def bricks(self) -> int:
        """Number of intervals, rectangles or bricks."""
        return int(np.prod(self.shape - 1))

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.bricks * {
            skfem.MeshTri1: len(HALVES),
            skfem.MeshTet1: len(TETRAHEDRA),
        }.get(self.kind, 1)

    def points(self, nodes: Indices) -> Array:
        """Coordinates (n, dim) [m] of some nodes."""
        at = places(nodes, self.shape, self.order)
        return np.stack([x[at[:, d]] for d, x in enumerate(self.axes)], axis=1)

    def corners(self, cells: Indices) -> Indices:
        """Nodes (n, corners) of some cells, in scikit-fem's order."""
        part, brick = np.divmod(cells, self.bricks)
        at = places(brick, self.shape - 1, self.order)
        steps = np.array(CORNERS[len(self.axes)]) @ strides(self.shape, self.order)
        found: Indices = (at @ strides(self.shape, self.order))[:, None] + steps
        if self.kind is skfem.MeshTet1:
            return np.take_along_axis(found, np.array(TETRAHEDRA)[part], axis=1)
        if self.kind is skfem.MeshTri1:
            found = np.where(
                self._rising(at)[:, None], found, np.roll(found, -1, axis=1)
            )
            return np.sort(
                np.take_along_axis(found, np.array(HALVES)[part], axis=1), axis=1
            )
        return found

    def _rising(self, at: Indices) -> Flags:
        """Whether the diagonal of the rectangles at (n, 2) rises along x; see
        `mesh.build`.
        """
        low = [
            0.5 * (x[k] + x[k + 1]) < x[(len(x) - 1) // 2]
            for x, k in zip(self.axes, at.T, strict=True)
        ]
        found: Flags = low[0] == low[1]
        return found


def strides(shape: Indices, order: tuple[int, ...]) -> Indices:
    """Step (dim,) of the number from one item to the next along each axis, for
    `shape` items along the axes.
    """
    found = np.empty(len(shape), dtype=np.int64)
    found[list(order)] = np.cumprod([1, *shape[list(order)][:-1]])
    return found


def places(numbers: Indices, shape: Indices, order: tuple[int, ...]) -> Indices:
    """Places (n, dim) of numbered items, of which there are `shape` along the axes."""
    found: Indices = np.asarray(numbers)[:, None] // strides(shape, order) % shape
    return found


def tensor_of(mesh: Any) -> Tensor | None:
    """Return what describes a mesh of scikit-fem if its nodes and cells are numbered
    so, else None.
    """
    kinds = (
        skfem.MeshLine1,
        skfem.MeshTri1,
        skfem.MeshQuad1,
        skfem.MeshTet1,
        skfem.MeshHex1,
    )
    kind = next((kind for kind in kinds if type(mesh) is kind), None)
    if kind is None:
        return None
    found = Tensor(kind, tuple(np.unique(x) for x in mesh.p))
    if (found.nodes, found.cells) != (mesh.p.shape[1], mesh.nelements):
        return None
    for count, rows, make in (
        (found.nodes, mesh.p, found.points),
        (found.cells, mesh.t, found.corners),
    ):
        for first in range(0, count, AT_ONCE):
            some = np.arange(first, min(first + AT_ONCE, count))
            if not np.array_equal(make(some), rows[:, some].T):
                return None
    return found
