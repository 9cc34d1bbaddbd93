"""Fill-reducing order of unknowns by nested dissection on the geometry of the mesh.

Cells are halved by a plane across their longest extent until few are left. An unknown belongs to the smallest block
that holds all its cells, and a block is eliminated after the two halves that it separates. In 2-D this halves the fill
of minimum degree, in 3-D it gains more, and it is found once for a mesh instead of with each factorisation.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

LEAF = 16  # cells that are not divided further


def nested_dissection(centres: Any, numbering: Iterable[Any], size: int) -> Any:
    """Order of elimination (size,) for cells with `centres` (dim, ncells).

    `numbering` holds arrays (n, ncells) with the unknowns that each cell couples.
    """
    blocks = [np.arange(centres.shape[1])]
    while len(blocks[0]) > LEAF:
        blocks = [half for block in blocks for half in _halves(centres[:, block], block)]
    code = np.empty(centres.shape[1], dtype=np.int64)
    for position, block in enumerate(blocks):
        code[block] = position
    low, high = np.full(size, len(blocks), dtype=np.int64), np.full(size, -1, dtype=np.int64)
    for unknowns in numbering:
        codes = np.broadcast_to(code, unknowns.shape)
        np.minimum.at(low, unknowns, codes)
        np.maximum.at(high, unknowns, codes)
    # the block that holds all codes between low and high has their common leading bits
    height = np.ceil(np.log2((low ^ high) + 1.0)).astype(np.int64)
    end = ((low >> height) + 1) << height
    return np.lexsort((height, end))


def _halves(centres: Any, block: Any) -> tuple[Any, Any]:
    axis = int(np.argmax(np.ptp(centres, axis=1)))
    half = len(block) // 2
    order = np.argpartition(centres[axis], half)
    return block[order[:half]], block[order[half:]]
