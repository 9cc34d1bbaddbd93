"""Bricks of a rectangular grid, one for each rank: its part with ghost cells, and
the outline of the whole grid.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contbed.errors import EngineError
from contbed.mesh.tensor import places
from contbed.ranks.two_fluid.division import Outline
from contbed.ranks.two_fluid.lattice import Lattice, joined, positions
from contbed.ranks.two_fluid.partition import LAYERS, Part
from contbed.two_fluid.compiled import Indices
from contbed.two_fluid.files import in_order_of_vtk


@dataclass(frozen=True, eq=False)
class Bricks:
    """The cells of a lattice in bricks, so many `along` each axis (dim,), with
    equally many cells or one more.
    """

    lattice: Lattice
    along: Indices

    @cached_property
    def starts(self) -> list[Indices]:
        """First cell of each brick along each axis, and the end."""
        return [
            np.linspace(0, cells, n + 1).astype(np.int64)
            for cells, n in zip(self.lattice.count, self.along, strict=True)
        ]

    def box(self, rank: int) -> tuple[Indices, Indices]:
        """First places (dim,) of the cells of a rank, and the ends."""
        at = places(np.array([rank]), self.along, tuple(range(len(self.along))))[0]
        low, high = zip(
            *(
                (start[k], start[k + 1])
                for start, k in zip(self.starts, at, strict=True)
            ),
            strict=True,
        )
        return np.array(low), np.array(high)

    def owner(self, place: Indices) -> Indices:
        """Ranks (n,) of the cells at places (n, dim)."""
        found, stride = np.zeros(len(place), dtype=np.int64), 1
        for start, n, at in zip(self.starts, self.along, place.T, strict=True):
            found += stride * (np.searchsorted(start, at, side="right") - 1)
            stride *= int(n)
        return found

    def cells(self, rank: int) -> tuple[Indices, Indices]:
        """Cells of a rank, own ones first, then layer by layer, each in ascending
        order; and the layer of each.
        """
        lattice, (low, high) = self.lattice, self.box(rank)
        spans = []
        for d, lent in enumerate(lattice.lends):
            span = np.arange(low[d] - LAYERS, high[d] + LAYERS)
            spans.append(
                span
                if lent is not None
                else span[(span >= 0) & (span < lattice.count[d])]
            )
        place = np.stack(
            [x.ravel() for x in np.meshgrid(*spans, indexing="ij")], axis=1
        )
        layer = np.maximum(np.maximum(low - place, place - high + 1), 0).sum(axis=1)
        near = layer <= LAYERS
        number, layer = lattice.numbers(place[near] % lattice.count), layer[near]
        # around a closed axis a cell may be met on both sides
        order = np.lexsort((layer, number))
        number, first = np.unique(number[order], return_index=True)
        layer = layer[order][first]
        order = np.lexsort((number, layer))
        return number[order], layer[order]

    def part(self, rank: int) -> Part:
        """Return the part of a rank; its faces are in the order of the whole grid."""
        lattice = self.lattice
        cells, layer = self.cells(rank)
        owned, near = np.searchsorted(layer, [1, 2])
        place = lattice.places(cells)
        inner = joined(lattice.after(axis, place) for axis in range(len(lattice.count)))
        inner = inner.take(
            np.flatnonzero(np.isin(lattice.numbers(lattice.next(inner)), cells))
        )
        inner = inner.take(np.argsort(inner.number))
        edge = lattice.edges.take(
            np.flatnonzero(np.isin(lattice.numbers(lattice.edges.place), cells))
        )
        geometry, centres, middles = lattice.geometry(cells, inner, edge)
        own = geometry.left < owned
        received = self._by_owner(cells[owned:])
        sent = {other: self._needed(other, rank) for other in received}
        in_mesh = lattice.of_mesh(place)
        nodes, corners = np.unique(
            in_order_of_vtk(lattice.tensor.corners(in_mesh)), return_inverse=True
        )
        return Part(
            rank,
            cells,
            int(owned),
            int(near),
            inner.number,
            edge.number,
            geometry,
            in_mesh,
            lattice.tensor.points(nodes),
            corners.reshape(len(cells), -1),
            centres,
            middles,
            own,
            own[len(inner.axis) :],
            {other: positions(cells, ghosts) for other, ghosts in received.items()},
            {other: positions(cells, needed) for other, needed in sent.items()},
            lattice.bandwidth,
            lattice.axisymmetric,
        )

    def _by_owner(self, ghosts: Indices) -> dict[int, Indices]:
        owner = self.owner(self.lattice.places(ghosts))
        return {int(rank): ghosts[owner == rank] for rank in np.unique(owner)}

    def _needed(self, other: int, rank: int) -> Indices:
        """Cells of a rank that are ghosts of another one, in its order."""
        cells, layer = self.cells(other)
        ghosts = cells[layer > 0]
        return self._by_owner(ghosts)[rank]


def bricks_of(lattice: Lattice, size: int) -> Bricks:
    """Return so many bricks, with the fewest faces between them.

    Raises
    ------
    EngineError : the cells along the axes cannot be shared among so many ranks
    """
    count = lattice.count
    fitting = [
        along
        for along in _products(size, len(count))
        if (np.array(along) <= count).all()
    ]
    if not fitting:
        cells, few = (
            " x ".join(map(str, count)),
            "each rank needs one; " if lattice.tensor.bricks < size else "",
        )
        raise EngineError(
            f"{size} ranks for a mesh of {cells} cells: {few}start fewer ranks or "
            "refine the mesh"
        )
    return Bricks(
        lattice,
        np.array(
            min(fitting, key=lambda along: float(np.sum((np.array(along) - 1) / count)))
        ),
    )


def outline(lattice: Lattice, boundaries: Mapping[str, Indices]) -> Outline:
    """Return the outline of a rectangular grid; `boundaries` are numbers of faces.

    Like that of `Division.outline` it has the faces of cells that have a boundary face
    or are beside one that has, and of the first and the last cell, which have the
    outermost ones.
    """
    place = lattice.places(np.array([0, lattice.tensor.bricks - 1]))
    place = np.concatenate((place, lattice.edges.place))
    axes = range(len(lattice.count))
    around = joined(faces for axis in axes for faces in lattice.beside(axis, place))
    near = np.concatenate((place, around.place, lattice.next(around)))
    near = lattice.places(np.unique(lattice.numbers(near)))
    inner = joined(faces for axis in axes for faces in lattice.beside(axis, near))
    inner = inner.take(np.unique(inner.number, return_index=True)[1])
    geometry, centres, middles = lattice.geometry(None, inner, lattice.edges)
    moved = len(inner.axis) - lattice.interior
    return Outline(
        geometry,
        lattice.of_mesh(lattice.places(np.arange(lattice.tensor.bricks))),
        centres,
        middles,
        {name: numbers + moved for name, numbers in boundaries.items()},
        {},
        lattice.axisymmetric,
        lattice.bandwidth,
        True,
        None,
        all_faces=lattice.interior + len(lattice.edges.axis),
    )


def _products(size: int, factors: int) -> Iterator[tuple[int, ...]]:
    """All ways to write `size` as a product of so many factors."""
    if factors == 1:
        yield (size,)
        return
    for first in range(1, size + 1):
        if size % first == 0:
            for rest in _products(size // first, factors - 1):
                yield (first, *rest)
