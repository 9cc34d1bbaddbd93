"""Errors of fields on tensor-product meshes, direction by direction, and coordinates
that make them equal.

On a line of nodes a polynomial of degree p interpolates a smooth function with the
error c_p h^(p+1) |d^(p+1)T|. The pth derivative is constant in a cell and exact at its
middle for polynomials of degree p + 1, so that its difference between neighbours gives
the next derivative also where cells grow. Averages of the gradient between cells
(Zienkiewicz & Zhu 1987) do not see this error at even degrees: the gradient is wrong by
the same amount on both sides of a node (Babuska & Yu 1987, doi:10.1137/0724027).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

import numpy as np
import scipy.sparse as sp

from contbed.arrays import Array, Integers
from contbed.fem.elements import Space, lagrange
from contbed.mesh.grading import growing, of_density

# max |(x - 0)(x - 1/p)...(x - 1)| / (p + 1)! on [0, 1]: error of interpolation over
# h^(p+1) |d^(p+1)T|
INTERPOLATION = {1: 1.0 / 8.0, 2: 3.0**0.5 / 216.0, 3: 1.0 / 1944.0}
SAME = 1e-13  # share of the extent within which coordinates of nodes are equal
# change of the cell size over the distance, at most: neighbours differ by a factor of
# about 1.5
GROWTH = 0.4
SMALLEST = 2.0**-16  # factor by which a cell at an end may shrink in one round
COARSER = 1.5  # factor by which cells may grow in one round
STEEPEST = 10.0  # growth of a derivative over the cell at a boundary, at most
FINER = 16.0  # factor by which they may shrink


@dataclass(frozen=True)
class TensorGrid:
    """Nodes of a tensor-product mesh: `vertices` in each direction [m], and the
    place of each node in the grid.
    """

    vertices: tuple[Array, ...]
    degree: int
    place: Integers

    @classmethod
    def of(cls, space: Space) -> TensorGrid | None:
        """Return the grid of the nodes of a space; None where its mesh is no tensor
        product.
        """
        points, degree = space.points, space.degree
        vertices, indices, shape = [], [], []
        for x, corners in zip(points, space.mesh.p, strict=True):
            ends = _distinct(corners)
            nodes = _subdivided(ends, degree)
            index = np.clip(
                np.searchsorted(0.5 * (nodes[1:] + nodes[:-1]), x), 0, len(nodes) - 1
            )
            if np.abs(nodes[index] - x).max() > SAME * (nodes[-1] - nodes[0]):
                return None
            vertices.append(ends)
            indices.append(index)
            shape.append(len(nodes))
        if np.prod(shape) != space.size:
            return None
        return cls(tuple(vertices), degree, np.ravel_multi_index(indices, shape))

    @property
    def cells(self) -> int:
        """Number of cells."""
        return int(np.prod([len(ends) - 1 for ends in self.vertices]))

    @property
    def coordinates(self) -> list[Array]:
        """Coordinates of the nodes in each direction [m]."""
        return [_subdivided(ends, self.degree) for ends in self.vertices]

    def values(self, field: Array) -> Array:
        """Return a nodal field (size,) as an array with one axis for each direction."""
        out = np.empty(len(field))
        out[self.place] = field
        return out.reshape([len(x) for x in self.coordinates])

    def nodal(self, values: Array) -> Array:
        """Return the nodal field (size,) of an array in the shape of `values`."""
        return np.asarray(values.ravel()[self.place])

    def errors(self, values: Array, weight: Array) -> list[Array]:
        """Estimate the largest error in each interval of each direction, in the unit of
        the field.

        Parameters
        ----------
        values : nodal values in the shape of `values`
        weight : factors on the error (same shape)
        """
        return [
            _line_errors(
                np.moveaxis(values, k, -1),
                np.moveaxis(weight, k, -1),
                np.diff(ends),
                self.degree,
            )
            for k, ends in enumerate(self.vertices)
        ]

    def interpolated(self, values: Array, where: Sequence[Array]) -> Array:
        """Return a field of this grid, in the shape of `values`, at the coordinates
        of another grid.
        """
        for k, x in enumerate(where):
            matrix = _interpolation(self.vertices[k], self.degree, x)
            flat = np.moveaxis(values, k, 0)
            values = np.moveaxis(
                (matrix @ flat.reshape(len(flat), -1)).reshape(len(x), *flat.shape[1:]),
                0,
                k,
            )
        return values


def _distinct(x: Array) -> Array:
    found = np.unique(x)
    return found[
        np.concatenate(([True], np.diff(found) > SAME * (found[-1] - found[0])))
    ]


def _subdivided(ends: Array, degree: int) -> Array:
    inner = ends[:-1, None] + np.diff(ends)[:, None] * np.arange(degree) / degree
    return np.append(inner.ravel(), ends[-1])


def _line_errors(values: Array, weight: Array, h: Array, degree: int) -> Array:
    """Return the largest estimate over all lines (..., nodes) in each of their
    intervals (n,).
    """
    count = len(h)
    start = degree * np.arange(count)
    highest = sum(
        (-1) ** (degree - j) * comb(degree, j) * values[..., start + j]
        for j in range(degree + 1)
    )
    highest = highest / (h / degree) ** degree
    if count == 1:  # nothing shows how it changes: as much as it is
        following = np.abs(highest) / h
    else:
        following = np.abs(np.diff(highest, axis=-1)) / (0.5 * (h[1:] + h[:-1]))
        first, last = _continued(following[..., :2]), _continued(following[..., :-3:-1])
        following = np.maximum(
            np.concatenate((first, following), axis=-1),
            np.concatenate((following, last), axis=-1),
        )
    heavy = np.max([weight[..., start + j] for j in range(degree + 1)], axis=0)
    error: Array = (heavy * following).reshape(-1, count).max(axis=0)
    return np.asarray(INTERPOLATION[degree] * h ** (degree + 1) * error)


def _continued(following: Array) -> Array:
    """Return a derivative at a boundary (..., 1), which may grow towards it, from
    those at the two nearest nodes.
    """
    nearest = following[..., :1]
    before = np.maximum(following[..., -1:], nearest / STEEPEST)
    return nearest * np.maximum(1.0, nearest / np.maximum(before, 1e-300))


def _interpolation(ends: Array, degree: int, x: Array) -> sp.csr_matrix:
    from skfem.refdom import RefLine

    cell = np.clip(np.searchsorted(ends, x, side="right") - 1, 0, len(ends) - 2)
    local = (x - ends[cell]) / (ends[cell + 1] - ends[cell])
    element = lagrange(RefLine, degree)
    table = element.table(local[None, :])
    place = np.rint(degree * element.nodes[:, 0]).astype(int)
    rows = np.broadcast_to(np.arange(len(x)), table.shape)
    columns = degree * cell[None, :] + place[:, None]
    shape = (len(x), degree * (len(ends) - 1) + 1)
    return sp.csr_matrix((table.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


def balanced(ends: Array, factor: Array, tips: Array) -> Array:
    """Return vertices of a line whose intervals are about `factor` (n,) times as long
    as those between `ends` (n + 1,).

    The ends of the line [m] stay. A cell shrinks at most by `FINER` and grows at most
    by `COARSER`, and the size changes at most by `GROWTH` over the distance. `tips`
    (2,) are the factors on the first and the last cell; these may shrink to `SMALLEST`
    of their size, as towards a corner at which derivatives grow without bound.
    """
    h = np.diff(ends)
    size = h * np.clip(factor, 1.0 / FINER, COARSER)
    tip = h[[0, -1]] * np.clip(tips, SMALLEST, COARSER)
    halvings = 0.5 ** np.arange(1.0, -np.log2(SMALLEST))
    fine = np.unique(
        np.concatenate((ends, ends[0] + h[0] * halvings, ends[-1] - h[-1] * halvings))
    )
    middle, h = 0.5 * (fine[1:] + fine[:-1]), np.diff(fine)
    size = size[np.searchsorted(ends, middle) - 1]
    size[[0, -1]] = np.minimum(size[[0, -1]], tip)
    steps = GROWTH * h
    size = growing(size, steps[1:], steps[:-1])
    return of_density(fine, 1.0 / size, least=2)
