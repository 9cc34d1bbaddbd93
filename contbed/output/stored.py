"""Fields as a run stored them: files of a series; one file each, or pieces of ranks,
joined where they meet.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array, Integers
from contbed.errors import ContbedError

# of files that are not as they were written
_DAMAGE = (OSError, ValueError, KeyError, ElementTree.ParseError)
# distance of nodes of two pieces that are one and the same, over the extent: rounding
SAME = 1e-9


def read_series(path: Path) -> list[tuple[float, Path]]:
    """Return the times [s] and files that a .pvd lists, of those that are there.

    Raises
    ------
    ContbedError : it is damaged
    """
    try:
        listed = [
            (float(entry.attrib["timestep"]), path.parent / entry.attrib["file"])
            for entry in ElementTree.parse(path).iter("DataSet")
        ]
    except _DAMAGE as error:
        raise _damaged(path, error) from error
    return [(time, file) for time, file in listed if file.is_file()]


def read_fields(path: Path) -> Any:
    """Read a .vtu, or the pieces that a .pvtu names, as one meshio.Mesh; cells stay in
    the order of the pieces.

    Raises
    ------
    ContbedError : a piece is not there, or a file is damaged
    """
    import meshio

    if path.suffix != ".pvtu":
        return _read(path)
    try:
        files = [
            path.with_name(item.attrib["Source"])
            for item in ElementTree.parse(path).getroot().iter("Piece")
        ]
    except _DAMAGE as error:
        raise _damaged(path, error) from error
    if lost := [file.name for file in files if not file.is_file()]:
        raise ContbedError(
            f"{path}: {', '.join(lost)} not found; a .pvtu needs its pieces beside it"
        )
    pieces = [_read(file) for file in files]
    points = np.concatenate([piece.points for piece in pieces])
    first, number = _joined(points)
    starts = np.cumsum([0, *(len(piece.points) for piece in pieces)])
    cells = np.concatenate(
        [
            number[piece.cells[0].data + n]
            for piece, n in zip(pieces, starts, strict=False)
        ]
    )
    one = pieces[0]
    return meshio.Mesh(
        points[first],
        [(one.cells[0].type, cells)],
        {
            name: np.concatenate([piece.point_data[name] for piece in pieces])[first]
            for name in one.point_data
        },
        {
            name: [np.concatenate([piece.cell_data[name][0] for piece in pieces])]
            for name in one.cell_data
        },
    )


def _read(path: Path) -> Any:
    """Read a .vtu; meshio lets any error of its parser through, or prints it and
    ends the process.
    """
    import meshio

    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            mesh = meshio.read(path)
        largest = max(
            (int(block.data.max(initial=-1)) for block in mesh.cells), default=-1
        )
        if largest >= len(mesh.points):
            raise ValueError(f"a cell names point {largest} of {len(mesh.points)}")
    except (Exception, SystemExit) as error:
        raise _damaged(path, error) from error
    return mesh


def _damaged(path: Path, error: BaseException) -> ContbedError:
    reason = " ".join(str(error).split())
    why = f" ({reason})" if reason and not isinstance(error, SystemExit) else ""
    return ContbedError(
        f"{path}: a damaged file of fields{why}; remove it, or run the scene again"
    )


def _joined(points: Array) -> tuple[Integers, Integers]:
    """Return the first of each group of points that are the same, and the number of
    the group of each point.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(
        SAME * float(np.ptp(points, axis=0).max()), output_type="ndarray"
    )
    graph = coo_matrix(
        (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (len(points), len(points))
    )
    _, number = connected_components(graph, directed=False)
    _, first = np.unique(number, return_index=True)
    return first, number.astype(np.int64)
