"""Cells of a grid that other ranks own, and sums and maxima over all ranks; one rank
alone has neither.

A rank has its own cells and, behind them, layers of ghost cells: copies of cells of
other ranks. Kernels compute all cells of a rank. Those of the outer ghost layers lack
faces, so what is computed there is meaningless until `exchange` takes it from the
owner. Every stage of a step whose stencil reaches neighbours ends with an exchange, and
what counts, adds or compares cells takes the own ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contbed.two_fluid.compiled import Flags, Indices

Selection = slice | Flags


class Halo:
    """The halo of a grid that one rank has as a whole: every cell is its own, and
    nothing is exchanged.

    Attributes
    ----------
    distributed : whether a rank has only a part of the cells
    cells : own ones
    near : number of cells whose faces are all there; None for all
    faces, edges : own ones of all faces, and of the boundary faces alone; each face
        belongs to one rank
    """

    distributed = False
    cells: slice = slice(None)
    near: int | None = None
    faces: Selection = slice(None)
    edges: Selection = slice(None)

    def exchange(self, *fields: np.ndarray) -> None:
        """Set the ghost cells of fields (nc, ...) to the values of their owners, in
        place.
        """

    def of_numbered(self, number: Indices) -> Halo:
        """Return the halo of the cells with a `number` (nc,), not -1, by that
        number; own ones come first.
        """
        return self

    def max(self, value: float) -> float:
        """Return the largest value of all ranks."""
        return value

    def any(self, found: bool) -> bool:
        """Return whether any rank has found something."""
        return found

    def sum(self, *values: float) -> Sequence[float]:
        """Return the sum over all ranks of each value."""
        return values

    def first(self, message: str) -> str:
        """Return the message of the lowest rank that has one; empty if none has."""
        return message


WHOLE = Halo()
