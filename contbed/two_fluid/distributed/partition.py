"""Parts of a grid for ranks: own cells, LAYERS layers of ghost cells behind them, and the faces between all of these.

A part has faces in the order and direction of the whole grid. A cell whose faces are all there then adds the same
numbers in the same order on every rank that has it, so that what two ranks compute for one face has the same bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import skfem

from contbed.errors import EngineError
from contbed.two_fluid.compiled import Flags, Indices
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
    """Yield the part of each rank, one after the other, as each is as large as its share of the grid."""
    layers = [_layers(grid, owner, rank) for rank in range(size)]
    ghosts = [np.concatenate(found[1:]) for found in layers]
    numbers = np.full(len(owner), -1, dtype=np.int64)
    for rank in range(size):
        part = _part(grid, mesh, owner, rank, layers[rank])
        numbers[part.cells] = np.arange(len(part.cells))
        for other in range(size):
            # symmetric: a rank in whose layers own cells of another lie has its own cells in that one's
            needed = ghosts[other][owner[ghosts[other]] == rank]
            if len(needed):
                part.sent[other] = numbers[needed]
        yield part


def _layers(grid: Grid, owner: Indices, rank: int) -> list[Indices]:
    """Own cells of a rank, and those of each layer behind them."""
    inside = owner == rank
    layers = [np.flatnonzero(inside)]
    for _ in range(LAYERS):
        beside = _with_neighbours(grid, inside) & ~inside
        layers.append(np.flatnonzero(beside))
        inside |= beside
    return layers


def _with_neighbours(grid: Grid, cells: Flags) -> Flags:
    """Mark cells that are marked, and their neighbours."""
    left, right, found = grid.geometry.left[: grid.interior], grid.geometry.right, cells.copy()
    found[right[cells[left]]] = True
    found[left[cells[right]]] = True
    return found


def _part(grid: Grid, mesh: skfem.Mesh, owner: Indices, rank: int, layers: list[Indices]) -> Part:
    g, ni = grid.geometry, grid.interior
    left, right, inside = g.left[:ni], g.right, np.zeros(len(owner), dtype=np.bool_)
    cells = np.concatenate(layers)
    inside[cells] = True
    numbers = np.full(len(owner), -1, dtype=np.int64)
    numbers[cells] = np.arange(len(cells))
    interior = np.flatnonzero(inside[left] & inside[right])
    edge = ni + np.flatnonzero(inside[g.left[ni:]])
    faces = np.concatenate((interior, edge))
    ghosts = cells[len(layers[0]) :]
    taken = _of_faces(g, faces, interior)
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


def _of_faces(g: Geometry, faces: Indices, interior: Indices) -> dict[str, Any]:
    """Return what `Geometry` lists by face, of some faces and of those that are interior."""
    return {name: getattr(g, name)[faces] for name in OF_FACES} | {
        name: getattr(g, name)[interior] for name in OF_INTERIOR
    }


@dataclass(frozen=True, eq=False)
class Outline(Grid):
    """What the root rank has of a grid that ranks share; it takes no steps, which would need rows.

    It has places and volumes of all cells, the boundary faces, and those beside and behind boundary cells, from which
    the pressure reaches floor and roof; for each axis the outermost faces, so that the bed has its extent.
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


def outline(grid: Grid) -> Outline:
    """Return the outline of a grid."""
    g, ni, count = grid.geometry, grid.interior, len(grid.geometry.left)
    near = np.zeros(len(grid.cells), dtype=np.bool_)
    near[g.left[ni:]] = True
    near = _with_neighbours(grid, near)
    kept = near[g.left[:ni]] | near[g.right]
    outermost = np.concatenate((grid.middles.argmin(axis=0), grid.middles.argmax(axis=0)))
    kept[outermost[outermost < ni]] = True
    interior = np.flatnonzero(kept)
    faces, first = np.concatenate((interior, np.arange(ni, count))), len(interior)
    geometry = g._replace(
        left=g.left[faces],
        right=g.right[interior],
        gradient_inverse=g.gradient_inverse[:0],
        moment_inverse=g.moment_inverse[:0],
        edge_from=first,
        edge_to=len(faces),
        **_of_faces(g, faces, interior),
    )
    return Outline(
        geometry,
        grid.cells,
        grid.centres,
        grid.middles[faces],
        {name: numbers - ni + first for name, numbers in grid.boundaries.items()},
        grid.regions,
        grid.axisymmetric,
        grid.bandwidth,
        grid.rectangular,
        None,
        all_faces=count,
    )
