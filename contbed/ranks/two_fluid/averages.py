"""Averages of a bed on ranks: each takes those of its own cells, which rank 0 puts
together to read them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.ranks.group import RankGroup
from contbed.ranks.two_fluid.bed import SharedSimulation
from contbed.two_fluid import momentum_budget
from contbed.two_fluid.averages import OF_BED, Averages
from contbed.two_fluid.compiled import Indices
from contbed.two_fluid.simulation import Simulation


class SharedAverages(Averages):
    """Averages on rank 0, which has those of the whole bed after `whole`."""

    def __init__(self, bed: SharedSimulation, start: float, end: float):
        super().__init__(start, end)
        self.shared, self._behind = bed.shared, True
        bed.tell()
        self.shared.run(begin, start, end)

    def add(self, bed: Simulation) -> None:
        """Take the last step of the bed into account, on all ranks."""
        if not self.open_later(bed):
            self.shared.run(add)
            self._behind = True

    def whole(self) -> Averages:
        """Return the averages of the whole bed, put together where steps have been
        added.
        """
        if self._behind:
            self._gather()
        return self

    def resume(self, arrays: dict[str, np.ndarray]) -> None:
        """Back to what `arrays` gave, on all ranks."""
        super().resume(arrays)
        mine = self.arrays()
        self.shared.run(
            resume, root=[_of_cells(mine, cells) for cells in self.shared.own_cells()]
        )
        self._behind = False

    def _gather(self) -> None:
        gathered = self.shared.run(own_arrays)
        first = gathered[0]
        places = self.shared.own_cells()
        whole = dict(first)
        for name in first.keys() - set(OF_BED):
            shape = first[name].shape
            whole[name] = np.empty((shape[0], sum(map(len, places)), *shape[2:]))
            for arrays, cells in zip(gathered, places, strict=True):
                whole[name][:, cells] = arrays[name]
        super().resume(whole)
        self._behind = False


def _of_cells(arrays: dict[str, np.ndarray], cells: Indices) -> dict[str, np.ndarray]:
    return {
        name: value if name in OF_BED else value[:, cells]
        for name, value in arrays.items()
    }


def begin(all_ranks: RankGroup, root: Any, key: int, start: float, end: float) -> None:
    """Begin the averages of all parts."""
    here = all_ranks.objects[key]
    with np.errstate(all="ignore"):  # outer ghost cells hold meaningless numbers
        here.averages = Averages(
            start, end, momentum=momentum_budget.momentum(here.simulation)
        )


def add(all_ranks: RankGroup, root: Any, key: int) -> None:
    """Take the last step of all parts into account."""
    here = all_ranks.objects[key]
    with np.errstate(all="ignore"):
        here.averages.add(here.simulation)


def own_arrays(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Return on rank 0 the averages of the own cells of each rank."""
    return all_ranks.comm.gather(all_ranks.objects[key].averages.arrays())


def resume(all_ranks: RankGroup, root: Any, key: int) -> None:
    """Set the averages of all parts; root has those of each."""
    all_ranks.objects[key].averages.resume(all_ranks.comm.scatter(root))
