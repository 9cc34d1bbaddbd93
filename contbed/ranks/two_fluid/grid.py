"""The grid of a bed that ranks share: each has its part, rank 0 an outline of the
whole.
"""

from __future__ import annotations

from typing import Any

from contbed.ranks.group import RankGroup, rank_group
from contbed.ranks.two_fluid.division import Division
from contbed.two_fluid.compiled import Indices
from contbed.two_fluid.fv.grid import Grid


class SharedGrid:
    """The parts of all ranks, which each makes of its share; they are released with
    the last bed on them.

    Attributes
    ----------
    edges : boundary faces of each rank

    Raises
    ------
    EngineError : fewer cells than ranks
    """

    def __init__(self, division: Division, outline: Grid):
        self.ranks = rank_group()
        self.key = self.ranks.new_key()
        size = self.ranks.comm.size
        shares = division.split(division.owners(size), size)
        numbers = self.ranks.run_on_all(take_part, self.key, root=shares)
        edges = len(outline.geometry.left) - outline.interior
        first = outline.face_count - edges
        self.edges: list[Indices] = [mine - first for mine in numbers]

    def __del__(self) -> None:
        self.ranks.released.append(self.key)


def take_part(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Make the part of this rank from its share as object `key`; root yields those of
    all ranks, one after the other.

    Rank 0 gets the boundary faces of each.
    """
    if all_ranks.is_root:
        mine = next(root)
        for share in root:
            all_ranks.comm.send(share, share.rank)
    else:
        mine = all_ranks.comm.recv(source=0)
    all_ranks.objects[key] = part = mine.part()
    return all_ranks.comm.gather(part.edge)
