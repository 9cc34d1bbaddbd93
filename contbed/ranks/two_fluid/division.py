"""A grid of any cells before ranks share it: who gets which cells, the share of each,
and the outline of the whole.

Rank 0 has the connections, places and sizes of all cells and facets; ranks make the
lists of their parts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from contbed.errors import EngineError
from contbed.ranks.two_fluid.partition import LAYERS, REACH, Share
from contbed.solvers.aggregation import neighbours_by_cell
from contbed.two_fluid.compiled import Indices
from contbed.two_fluid.fv.connections import SKEWED, Connections, Links, offsets
from contbed.two_fluid.fv.grid import Grid, faces_of, geometry

# fields of `Geometry` by what they list
OF_INTERIOR = ("weight", "skew", "arm_right", "slope_right")
OF_FACES = (
    "area",
    "face_size",
    "normal",
    "distance",
    "non_orthogonal",
    "arm_left",
    "slope_left",
)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Neighbours of cell c and the faces to them from start[c] to start[c + 1];
    `alone` are faces that lead to none.
    """

    start: Indices
    beside: Indices
    faces: Indices
    alone_start: Indices
    alone: Indices

    @classmethod
    def of(cls, whole: Connections) -> Surroundings:
        """Return what is around the cells of a grid."""
        count, ni = len(whole.cells), whole.interior
        alone = np.append(
            np.flatnonzero(whole.left[:ni] == whole.right),
            np.arange(ni, len(whole.left)),
        )
        alone = alone[np.argsort(whole.left[alone], kind="stable")]
        start = np.searchsorted(whole.left[alone], np.arange(count + 1))
        return cls(
            *neighbours_by_cell(whole.left[:ni], whole.right, count), start, alone
        )

    def cells(self, of: Indices) -> Indices:
        """Return the neighbours of some cells, in ascending order."""
        return np.unique(_joined(self.start, self.beside, of))

    def faces_of(self, cells: Indices) -> Indices:
        """Return the faces of some cells, in ascending order."""
        shared, alone = (
            _joined(self.start, self.faces, cells),
            _joined(self.alone_start, self.alone, cells),
        )
        return np.unique(np.concatenate((shared, alone)))


@dataclass(frozen=True, eq=False)
class Outline(Grid):
    """What rank 0 has of a grid that ranks share; it takes no steps, which would need
    rows.

    It has places and volumes of all cells, the boundary faces, and those beside and
    behind boundary cells, from which the pressure reaches floor and roof; for each axis
    the outermost faces, so that the bed has its extent.
    """

    all_faces: int = 0

    @property
    def order(self) -> Literal["C", "F"]:
        """Order in memory of vectors (nc, dim): that of the parts."""
        return "C"

    @property
    def face_count(self) -> int:
        """Number of faces of the whole grid."""
        return self.all_faces


@dataclass(frozen=True, eq=False)
class Division:
    """A grid that ranks will share, of which no rank makes the whole: the parts of
    ranks, and the outline.
    """

    whole: Connections
    around: Surroundings
    skewed: bool

    @classmethod
    def of(cls, whole: Connections) -> Division:
        """Return what is needed to divide a grid.

        Raises
        ------
        SceneError : a face that its cells do not face
        """
        return cls(whole, Surroundings.of(whole), whole.skewness() > SKEWED)

    def owners(self, size: int) -> Indices:
        """Return the rank (nc,) of each cell, by PETSc's partitioner of the graph of
        cells and faces.

        Raises
        ------
        EngineError : fewer cells than ranks
        """
        around, count = self.around, len(self.whole.cells)
        if count < size:
            raise EngineError(
                f"{size} ranks for a mesh of {count} cells: each rank needs one; start "
                "fewer ranks or refine the mesh"
            )
        if size == 1:
            return np.zeros(count, dtype=np.int64)
        from petsc4py import PETSc

        csr = (
            around.start.astype(np.int32),
            around.beside.astype(np.int32),
            np.ones(len(around.beside)),
        )
        graph = PETSc.Mat().createAIJ((count, count), csr=csr, comm=PETSc.COMM_SELF)
        adjacency = graph.convert("mpiadj", PETSc.Mat())
        partitioning, found = (
            PETSc.MatPartitioning().create(PETSc.COMM_SELF),
            PETSc.IS().create(PETSc.COMM_SELF),
        )
        partitioning.setOptionsPrefix("contbed_cells_")
        partitioning.setAdjacency(adjacency)
        PETSc.Options("contbed_cells_")["mat_partitioning_nparts"] = size
        partitioning.setFromOptions()
        partitioning.apply(found)
        ranks = np.array(found.getIndices(), dtype=np.int64)
        for thing in (found, partitioning, adjacency, graph):
            thing.destroy()
        if len(np.unique(ranks)) < size:
            raise EngineError(
                f"{size} ranks for a mesh of {count} cells: one would have no cell; "
                "start fewer ranks"
            )
        return ranks

    def split(self, owner: Indices, size: int) -> Iterator[Share]:
        """Yield the share of each rank, one after the other, as each is as large as
        its part of the grid.
        """
        whole, around = self.whole, self.around
        own = np.split(
            np.argsort(owner, kind="stable"),
            np.cumsum(np.bincount(owner, minlength=size))[:-1],
        )
        numbers = np.full(len(owner), -1, dtype=np.int64)
        ghosts = []
        for mine in own:
            behind = np.concatenate(_layers(around, mine, LAYERS, numbers)[1:])
            ghosts.append(
                {int(k): behind[owner[behind] == k] for k in np.unique(owner[behind])}
            )
        for rank in range(size):
            layers = _layers(around, own[rank], LAYERS + REACH, numbers)
            ends = np.cumsum([len(layer) for layer in layers])
            cells = np.concatenate(layers)
            faces, links = _links(whole, around, cells, numbers)
            # symmetric: a rank in whose layers own cells of another lie has its own
            # cells in that one's
            sent = {
                other: np.searchsorted(own[rank], ghosts[other][rank])
                for other in ghosts[rank]
            }
            yield Share(
                rank,
                cells,
                ends,
                faces,
                links,
                owner[cells],
                sent,
                whole.cells[cells[: ends[LAYERS]]],
                whole.bandwidth,
                whole.axisymmetric,
                self.skewed,
            )

    def outline(self) -> Outline:
        """Return the outline of a grid."""
        whole, around = self.whole, self.around
        ni, count = whole.interior, len(whole.left)
        near = np.unique(whole.left[ni:])
        middles = whole.middles[whole.facets(np.arange(count))]
        outermost = np.concatenate((middles.argmin(axis=0), middles.argmax(axis=0)))
        kept = np.union1d(
            around.faces_of(np.union1d(near, around.cells(near))), outermost
        )
        complete = np.union1d(whole.left[kept], whole.right[kept[kept < ni]])
        scratch = np.full(len(whole.cells), -1, dtype=np.int64)
        cells = np.concatenate(_layers(around, complete, REACH, scratch))
        faces, links = _links(whole, around, cells, scratch)
        made = geometry(
            links, offsets(links), whole.axisymmetric, self.skewed, len(complete)
        )
        faces = faces[np.concatenate(faces_of(links, len(complete)))]
        taken = np.flatnonzero(np.isin(faces, kept))
        interior = taken[faces[taken] < ni]
        first = len(interior)
        lists = made._replace(
            left=complete[made.left[taken]],
            right=complete[made.right[interior]],
            gradient_inverse=made.gradient_inverse[:0],
            moment_inverse=made.moment_inverse[:0],
            volume=whole.volume,
            radius=whole.centres[:, 0].copy()
            if whole.axisymmetric
            else np.zeros(len(whole.cells)),
            edge_from=first,
            edge_to=len(taken),
            **{name: getattr(made, name)[taken] for name in OF_FACES},
            **{name: getattr(made, name)[interior] for name in OF_INTERIOR},
        )
        return Outline(
            lists,
            whole.cells,
            whole.centres,
            middles[faces[taken]],
            {name: numbers - ni + first for name, numbers in whole.boundaries.items()},
            whole.axisymmetric,
            whole.bandwidth,
            whole.place is not None,
            None,
            whole.spans,
            all_faces=count,
        )


def _joined(start: Indices, values: Indices, of: Indices) -> Indices:
    """Return the values from start[c] to start[c + 1] of some cells, one after the
    other.
    """
    number = start[of + 1] - start[of]
    shift = np.repeat(start[of] - (np.cumsum(number) - number), number)
    found: Indices = values[np.arange(len(shift)) + shift]
    return found


def _layers(
    around: Surroundings, cells: Indices, number: int, scratch: Indices
) -> list[Indices]:
    """Return some cells and so many layers behind them; `scratch` (nc,) has -1
    before and after.
    """
    layers = [cells]
    scratch[cells] = 0
    for _ in range(number):
        behind = around.cells(layers[-1])
        layers.append(behind[scratch[behind] < 0])
        scratch[layers[-1]] = 0
    scratch[np.concatenate(layers)] = -1
    return layers


def _links(
    whole: Connections, around: Surroundings, cells: Indices, scratch: Indices
) -> tuple[Indices, Links]:
    """Return the faces between and beside some cells, and both by their numbers
    among these.
    """
    faces, ni = around.faces_of(cells), whole.interior
    scratch[cells] = np.arange(len(cells))
    inner = faces[faces < ni]
    inside = (scratch[whole.left[inner]] >= 0) & (scratch[whole.right[inner]] >= 0)
    faces = np.concatenate((inner[inside], faces[len(inner) :]))
    links = whole.links(faces)
    links = links._replace(
        centres=links.centres[cells],
        volume=links.volume[cells],
        left=scratch[links.left],
        right=scratch[links.right],
    )
    scratch[cells] = -1
    return faces, links
