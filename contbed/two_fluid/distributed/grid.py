"""The grid of a bed that ranks share: each has its part, the root rank an outline and who has which cells and faces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import skfem

from contbed.fem.ranks import RankGroup, rank_group
from contbed.two_fluid.compiled import Indices
from contbed.two_fluid.distributed.partition import Part, outline, owners, split
from contbed.two_fluid.fv.grid import Grid


class SharedGrid:
    """The parts of all ranks, released with the last bed on them; nothing here refers to the grid that was shared out.

    Attributes
    ----------
    outline : the root rank's grid from now on
    all, own : cells and faces of each rank, with ghosts and without; edges : its boundary faces
    """

    def __init__(self, grid: Grid, mesh: skfem.Mesh):
        self.ranks = rank_group()
        self.key, self.outline = self.ranks.new_key(), outline(grid)
        owner = owners(grid, self.ranks.comm.size)
        self.all: list[tuple[Indices, Indices]] = []
        self.own: list[tuple[Indices, Indices]] = []
        self.edges: list[Indices] = []
        self.ranks.run_on_all(take_part, self.key, root=self._noted(grid, mesh, owner))

    def _noted(self, grid: Grid, mesh: skfem.Mesh, owner: Indices) -> Iterator[Part]:
        for part in split(grid, mesh, owner, self.ranks.comm.size):
            faces = part.faces
            self.all.append((part.cells, faces))
            self.own.append((part.cells[: part.owned], faces[part.own_faces]))
            self.edges.append(part.edge - grid.interior)
            yield part

    def __del__(self) -> None:
        self.ranks.released.append(self.key)


def take_part(all_ranks: RankGroup, root: Any, key: int) -> None:
    """Keep the part of this rank as object `key`; root yields those of all ranks, each sent before the next is made."""
    if not all_ranks.is_root:
        all_ranks.objects[key] = all_ranks.comm.recv(source=0)
        return
    for part in root:
        if part.rank == 0:
            all_ranks.objects[key] = part
        else:
            all_ranks.comm.send(part, part.rank)
