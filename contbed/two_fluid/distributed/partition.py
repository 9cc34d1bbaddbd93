"""Parts of a grid for ranks: own cells, LAYERS layers of ghost cells behind them, and the faces between all of these.

A part has faces in the order and direction of the whole grid. A cell whose faces are all there then adds the same
numbers in the same order on every rank that has it, so that what two ranks compute for one face has the same bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import skfem

from contbed.errors import EngineError
from contbed.two_fluid.compiled import Indices
from contbed.two_fluid.files import corners_of
from contbed.two_fluid.fv.grid import Geometry, Grid, neighbours

# of ghost cells: gradients on skewed grids take neighbours of neighbours; what reaches farther is exchanged on the way
LAYERS = 2
# fields of `Geometry` by what they list; those that are in neither are the same in all parts
OF_CELLS = ("gradient_inverse", "volume", "moment_inverse", "radius")
OF_INTERIOR = ("weight", "skew", "arm_right", "slope_right")
OF_FACES = ("area", "face_size", "normal", "distance", "non_orthogonal", "arm_left", "slope_left")


@dataclass(eq=False)
class Part:
    """What one rank has of a grid.

    cells : of the whole grid, own ones first, then layer by layer, each in the order of the whole grid
    owned, near : number of own cells, and of those and the first layer
    interior, edge : faces of the whole grid; own_faces (nf,), own_edges (nb,) mark those of own cells on the left
    points (np, dim) [m], corners (nc, n) : nodes of the cells, and those of each cell in VTK's order
    sent, received : for each neighbouring rank the own cells that it needs and the ghost cells that it owns
    """

    rank: int
    cells: Indices
    owned: int
    near: int
    interior: Indices
    edge: Indices
    geometry: Geometry
    grid_cells: Indices
    points: np.ndarray
    corners: Indices
    centres: np.ndarray
    middles: np.ndarray
    own_faces: np.ndarray
    own_edges: np.ndarray
    received: dict[int, Indices]
    sent: dict[int, Indices]
    bandwidth: int
    axisymmetric: bool

    @property
    def faces(self) -> Indices:
        """Faces (nf,) of the whole grid."""
        return np.concatenate((self.interior, self.edge))


def owners(grid: Grid, size: int) -> Indices:
    """Return the rank (nc,) of each cell, by PETSc's partitioner of the graph of cells and faces.

    Raises
    ------
    EngineError : fewer cells than ranks
    """
    count = len(grid.cells)
    if count < size:
        raise EngineError(
            f"{size} ranks for a mesh of {count} cells: each rank needs one; start fewer ranks or refine the mesh"
        )
    if size == 1:
        return np.zeros(count, dtype=np.int64)
    from petsc4py import PETSc

    start, beside, _ = neighbours(grid)
    csr = start.astype(np.int32), beside.astype(np.int32), np.ones(len(beside))
    graph = PETSc.Mat().createAIJ((count, count), csr=csr, comm=PETSc.COMM_SELF)
    adjacency = graph.convert("mpiadj", PETSc.Mat())
    partitioning, found = PETSc.MatPartitioning().create(PETSc.COMM_SELF), PETSc.IS().create(PETSc.COMM_SELF)
    partitioning.setOptionsPrefix("contbed_cells_")
    partitioning.setAdjacency(adjacency)
    PETSc.Options("contbed_cells_")["mat_partitioning_nparts"] = size
    partitioning.setFromOptions()
    partitioning.apply(found)
    ranks = np.array(found.getIndices(), dtype=np.int64)
    for thing in (found, partitioning, adjacency, graph):
        thing.destroy()
    if len(np.unique(ranks)) < size:
        raise EngineError(f"{size} ranks for a mesh of {count} cells: one would have no cell; start fewer ranks")
    return ranks


def split(grid: Grid, mesh: skfem.Mesh, owner: Indices, size: int) -> Iterator[Part]:
    """Yield the part of each rank."""
    parts = [_part(grid, mesh, owner, rank) for rank in range(size)]
    numbers = np.full(len(owner), -1, dtype=np.int64)
    for part in parts:
        numbers[part.cells] = np.arange(len(part.cells))
        for other in parts:
            # symmetric: a rank in whose layers own cells of another lie has its own cells in that one's
            needed = other.cells[other.owned :]
            needed = needed[owner[needed] == part.rank]
            if len(needed):
                part.sent[other.rank] = numbers[needed]
        yield part


def _part(grid: Grid, mesh: skfem.Mesh, owner: Indices, rank: int) -> Part:
    g, ni = grid.geometry, grid.interior
    left, right, inside = g.left[:ni], g.right, owner == rank
    layers = [np.flatnonzero(inside)]
    for _ in range(LAYERS):
        beside = np.zeros(len(owner), dtype=np.bool_)
        beside[right[inside[left]]] = True
        beside[left[inside[right]]] = True
        beside &= ~inside
        layers.append(np.flatnonzero(beside))
        inside |= beside
    cells = np.concatenate(layers)
    numbers = np.full(len(owner), -1, dtype=np.int64)
    numbers[cells] = np.arange(len(cells))
    interior = np.flatnonzero(inside[left] & inside[right])
    edge = ni + np.flatnonzero(inside[g.left[ni:]])
    faces = np.concatenate((interior, edge))
    ghosts = cells[len(layers[0]) :]
    taken: dict[str, Any] = {name: getattr(g, name)[faces] for name in OF_FACES}
    taken |= {name: getattr(g, name)[interior] for name in OF_INTERIOR}
    taken |= {name: value[cells] if len(value := getattr(g, name)) else value for name in OF_CELLS}
    own = owner[g.left[faces]] == rank
    nodes, corners = np.unique(corners_of(mesh)[1][grid.cells[cells]], return_inverse=True)
    return Part(
        rank,
        cells,
        len(layers[0]),
        len(layers[0]) + len(layers[1]),
        interior,
        edge,
        g._replace(
            left=numbers[g.left[faces]],
            right=numbers[right[interior]],
            edge_from=len(interior),
            edge_to=len(faces),
            **taken,
        ),
        grid.cells[cells],
        mesh.p.T[nodes],
        corners.reshape(len(cells), -1),
        grid.centres[cells],
        grid.middles[faces],
        own,
        own[len(interior) :],
        {int(k): numbers[ghosts[owner[ghosts] == k]] for k in np.unique(owner[ghosts])},
        {},
        grid.bandwidth,
        grid.axisymmetric,
    )
