"""Parts of a grid for ranks: own cells, LAYERS layers of ghost cells behind them, and
the faces between all of these.

A part has faces in the order and direction of the whole grid. A cell whose faces are
all there then adds the same numbers in the same order on every rank that has it, so
that what two ranks compute for one face has the same bits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from contbed.ranks.two_fluid.halo import Neighbour, RankHalo
from contbed.two_fluid.compiled import Indices
from contbed.two_fluid.fv.connections import Links, offsets
from contbed.two_fluid.fv.grid import Grid, faces_of, geometry

# of ghost cells: gradients on skewed grids take neighbours of neighbours; what reaches
# farther is exchanged on the way
LAYERS = 2
# more layers of cells from which the geometry of the others is made, on skewed grids
# both
REACH = 2


@dataclass(eq=False)
class Part:
    """What one rank has of a grid.

    cells : of the whole grid, own ones first, then layer by layer, each in the order of
        the whole grid
    owned, near : number of own cells, and of those and the first layer
    interior, edge : faces of the whole grid; own_faces (nf,), own_edges (nb,) mark
        those of own cells on the left
    grid : of these cells and faces, without exchange
    sent, received : for each neighbouring rank the own cells that it needs and the
        ghost cells that it owns
    """

    rank: int
    cells: Indices
    owned: int
    near: int
    interior: Indices
    edge: Indices
    grid: Grid
    own_faces: np.ndarray
    own_edges: np.ndarray
    received: dict[int, Indices]
    sent: dict[int, Indices]

    @property
    def faces(self) -> Indices:
        """Faces (nf,) of the whole grid."""
        return np.concatenate((self.interior, self.edge))

    def shared_grid(self, comm: Any) -> Grid:
        """Return the grid that exchanges its ghost cells with other ranks."""
        others = [
            Neighbour(rank, self.sent[rank], self.received[rank])
            for rank in sorted(self.sent)
        ]
        halo = RankHalo(
            comm, self.owned, self.near, self.own_faces, self.own_edges, others
        )
        return replace(self.grid, halo=halo)


class Share(NamedTuple):
    """What rank 0 gives another one for its part, whose geometry that one makes.

    Cells are own ones first, then layer by layer, LAYERS + REACH of them, each in the
    order of the whole grid; those of the outer REACH layers have a say in the geometry
    of the others only.

    ends : number of own cells, and of those and the first one, two, ... layers
    faces (nf,) : of the whole grid; of the edges the boundary faces
    links : cells and faces by their numbers here
    owner (nc,) : rank of each cell
    sent : for each neighbouring rank the own cells that it needs, by their numbers here
    """

    rank: int
    cells: Indices
    ends: Indices
    faces: Indices
    links: Links
    owner: Indices
    sent: dict[int, Indices]
    grid_cells: Indices
    bandwidth: int
    axisymmetric: bool
    skewed: bool

    def part(self) -> Part:
        """Make the part: the lists of its own cells, of LAYERS ghost layers and of
        the faces of these.
        """
        owned, near, last = (int(self.ends[k]) for k in (0, 1, LAYERS))
        links, ni = self.links, len(self.links.right)
        inner, edge = faces_of(links, last)
        made = geometry(links, offsets(links), self.axisymmetric, self.skewed, last)
        grid = Grid(
            made,
            self.grid_cells,
            links.centres[:last],
            links.middles[np.concatenate((inner, edge))],
            {},
            self.axisymmetric,
            self.bandwidth,
            False,
            None,
            np.empty((0, 2)),
        )
        own, ghosts = made.left < owned, self.owner[owned:last]
        return Part(
            self.rank,
            self.cells[:last],
            owned,
            near,
            self.faces[:ni][inner],
            self.faces[ni:][edge],
            grid,
            own,
            own[len(made.right) :],
            {int(k): owned + np.flatnonzero(ghosts == k) for k in np.unique(ghosts)},
            self.sent,
        )
