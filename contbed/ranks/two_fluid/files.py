"""Fields of a bed on ranks: of a small mesh one file by rank 0, of a large one a
piece by each rank.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import skfem

from contbed.output.files import announce
from contbed.ranks import pieces
from contbed.ranks.group import RankGroup
from contbed.ranks.two_fluid.bed import SharedSimulation
from contbed.two_fluid import files
from contbed.two_fluid.averages import Averages
from contbed.two_fluid.simulation import Simulation


def write(
    path: Path, mesh: skfem.Mesh, bed: Simulation, averages: Averages | None
) -> str:
    """Write the fields of a bed that ranks share; return the name of the file to
    open.
    """
    assert isinstance(bed, SharedSimulation)
    size = bed.shared.ranks.comm.size
    if size == 1 or mesh.nelements <= pieces.WHOLE:
        return files.write(path, mesh, bed, averages)
    bed.tell()
    for rank in range(size):
        announce(path.with_name(pieces.name_of(path.stem, rank)))
    widths = bed.shared.run(
        write_piece, str(path.parent.resolve()), path.stem, files.corners_of(mesh)[0]
    )
    declared = {name: ("Float64", width) for name, width in widths.items()}
    return pieces.write_header(path, {}, declared, size)


def write_piece(
    all_ranks: RankGroup, root: Any, key: int, folder: str, stem: str, kind: str
) -> dict[str, int]:
    """Write the own cells of this rank as one file; return the number of components
    of each field.
    """
    here = all_ranks.objects[key]
    fields = files.fields_of(here.simulation, here.averages)
    nodes, corners = np.unique(
        here.part.corners[: here.part.owned], return_inverse=True
    )
    corners = corners.reshape(-1, here.part.corners.shape[1])
    path = Path(folder) / pieces.name_of(stem, all_ranks.comm.rank)
    files.write_cells(path, kind, corners, here.part.points[nodes], fields)
    all_ranks.comm.Barrier()  # what names the pieces is written when all are there
    return {name: 3 if values.ndim > 1 else 1 for name, values in fields.items()}
