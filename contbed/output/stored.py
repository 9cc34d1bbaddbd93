"""Fields as a run stored them, and the files of a series."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

from contbed.errors import ContbedError

# of files that are not as they were written
_DAMAGE = (OSError, ValueError, KeyError, ElementTree.ParseError)


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
    """Read a .vtu as a meshio.Mesh.

    meshio lets any error of its parser through, or prints it and ends the process.

    Raises
    ------
    ContbedError : the file is damaged
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
