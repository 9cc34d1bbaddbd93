"""The grid of a bed that ranks share: each has its part, rank 0 an outline of the
whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import skfem

from contbed.ranks.group import RankGroup, rank_group
from contbed.ranks.two_fluid.bricks import Bricks, bricks_of
from contbed.ranks.two_fluid.division import Division
from contbed.ranks.two_fluid.lattice import Lattice
from contbed.ranks.two_fluid.partition import Share
from contbed.two_fluid.compiled import Indices
from contbed.two_fluid.fv.grid import Grid


class SharedGrid:
    """The parts of all ranks, released with the last bed on them; nothing here refers
    to a grid that was shared out.

    Attributes
    ----------
    outline : rank 0's grid from now on
    edges : boundary faces of each rank
    """

    def __init__(self, outline: Grid):
        self.ranks = rank_group()
        self.key, self.outline = self.ranks.new_key(), outline
        self.edges: list[Indices] = []

    @classmethod
    def of_division(
        cls, division: Division, mesh: skfem.Mesh, outline: Grid
    ) -> SharedGrid:
        """Share out the cells of a mesh and have each rank make its part of the grid.

        Raises
        ------
        EngineError : fewer cells than ranks
        """
        shared = cls(outline)
        size = shared.ranks.comm.size
        return shared._made(
            take_part, root=division.split(mesh, division.owners(size), size)
        )

    @classmethod
    def of_lattice(cls, lattice: Lattice, outline: Grid) -> SharedGrid:
        """Have each rank make its part of a rectangular grid.

        Raises
        ------
        EngineError : the cells cannot be shared among so many ranks
        """
        shared = cls(outline)
        return shared._made(make_part, bricks_of(lattice, shared.ranks.comm.size))

    def _made(
        self, function: Any, *arguments: Any, root: Iterator[Share] | None = None
    ) -> SharedGrid:
        edges = len(self.outline.geometry.left) - self.outline.interior
        numbers = self.ranks.run_on_all(function, self.key, *arguments, root=root)
        self.edges = [mine - (self.outline.face_count - edges) for mine in numbers]
        return self

    def __del__(self) -> None:
        self.ranks.released.append(self.key)


def take_part(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Make the part of this rank from its share as object `key`; root yields those of
    all ranks, one after the other.

    Rank 0 gets the boundary faces of each.
    """
    if not all_ranks.is_root:
        return _kept(all_ranks, key, all_ranks.comm.recv(source=0).part())
    mine = next(root)
    for share in root:
        all_ranks.comm.send(share, share.rank)
    return _kept(all_ranks, key, mine.part())


def make_part(all_ranks: RankGroup, root: Any, key: int, bricks: Bricks) -> Any:
    """Make the part of this rank as object `key`; rank 0 gets the boundary faces of
    each.
    """
    return _kept(all_ranks, key, bricks.part(all_ranks.comm.rank))


def _kept(all_ranks: RankGroup, key: int, part: Any) -> Any:
    all_ranks.objects[key] = part
    return all_ranks.comm.gather(part.edge)
