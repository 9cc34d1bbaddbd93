"""Particles of a table: text with commas, with or without a header, and points of a VTU
file.

A header names the columns: x,y,z, and radius or diameter and vx,vy,vz where they are
known, with a unit or without one, as in x [m]. ParaView's names, Points:0 and
velocity:0, are taken as well. A VTU file is one that contbed wrote, or another one
whose points have `radius` and `velocity`.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.dem.dumps import Lines
from contbed.errors import SceneError

Array = NDArray[np.float64]

_COLUMN = re.compile(r"(?P<name>[^\[(]+?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?")
_UNITS = {
    "x": "m",
    "y": "m",
    "z": "m",
    "radius": "m",
    "diameter": "m",
    "vx": "m/s",
    "vy": "m/s",
    "vz": "m/s",
}
_ALIASES = {f"points:{k}": name for k, name in enumerate("xyz")} | {
    f"velocity:{k}": f"v{name}" for k, name in enumerate("xyz")
}
_REMEDY = (
    "write a header such as x,y,z,radius, then a line with commas for each "
    "particle, in metres"
)


class ParticleTable(NamedTuple):
    """Centres (n, 3) [m]; radii (n,) [m] and velocities (n, 3) [m/s] where the table
    has them.
    """

    x: Array
    radius: Array | None
    velocity: Array | None


def read_table(path: Path) -> ParticleTable:
    """Read the particles of a table.

    Raises
    ------
    SceneError : with file and line, where the table cannot be used
    """
    table = _read_vtu(path) if is_vtu(path) else _read_text(path)
    if not len(table.x):
        raise SceneError(f"{path}:1: no particle in this file")
    if table.radius is not None and not (table.radius > 0.0).all():
        raise SceneError(
            f"{path}:1: the radius of particle {int(np.argmin(table.radius)) + 1} is "
            "not above 0"
        )
    return table


def is_vtu(path: Path) -> bool:
    """Whether a file is a VTU file, by its name."""
    return path.suffix.lower() == ".vtu"


def has_radii(path: Path) -> bool:
    """Whether a table of text has a column of radii or diameters; a VTU file is
    taken to have them.
    """
    if is_vtu(path):
        return True
    lines = Lines(path)
    names = _header(_first(lines), lines)
    return names is not None and bool({"radius", "diameter"} & set(names))


def _first(lines: Lines) -> str:
    """Return the first line that is neither empty nor a comment."""
    while (line := lines.next_or_none()) is not None:
        if line.strip() and not line.lstrip().startswith("#"):
            return line
    return ""


def _header(line: str, lines: Lines) -> list[str] | None:
    """Return the names of the columns; None where the line holds numbers.

    Raises
    ------
    SceneError : no x, y and z, or a unit other than that of SI
    """
    words = [word.strip().strip('"') for word in line.split(",")]
    try:
        [float(word) for word in words]
    except ValueError:
        pass
    else:
        return None
    names = []
    for word in words:
        found = _COLUMN.fullmatch(word)
        name = found["name"].lower() if found else word
        name = _ALIASES.get(name, name)
        names.append(name)
        if (
            found
            and found["unit"] is not None
            and name in _UNITS
            and found["unit"] != _UNITS[name]
        ):
            raise lines.error(
                f"{name} is in [{found['unit']}]; convert it to {_UNITS[name]}"
            )
    if missing := [name for name in "xyz" if name not in names]:
        raise lines.error(
            f"neither three numbers nor a header with {', '.join(missing)}; {_REMEDY}"
        )
    return names


def _read_text(path: Path) -> ParticleTable:
    lines = Lines(path)
    line = _first(lines)
    names = _header(line, lines) if line else None
    rows = []
    if names is None:
        names = ["x", "y", "z"]
        if line:
            rows.append(lines.numbers(line, len(names), ","))
    while (row := lines.next_or_none()) is not None:
        if row.strip() and not row.lstrip().startswith("#"):
            rows.append(lines.numbers(row, len(names), ","))
    columns = dict(zip(names, np.array(rows).reshape(-1, len(names)).T, strict=True))
    radius = columns.get(
        "radius", 0.5 * columns["diameter"] if "diameter" in columns else None
    )
    speeds = [columns[name] for name in ("vx", "vy", "vz") if name in columns]
    x = np.stack([columns[name] for name in "xyz"], axis=1)
    return ParticleTable(
        x, radius, np.stack(speeds, axis=1) if len(speeds) == 3 else None
    )


def _read_vtu(path: Path) -> ParticleTable:
    import meshio

    try:
        grid = meshio.read(path)
    except FileNotFoundError:
        raise SceneError(f"{path}:1: no such file") from None
    # meshio raises what its parsers raise, and ends the process for some faults
    except (Exception, SystemExit) as error:
        raise SceneError(
            f"{path}:1: no VTU file that can be read: {error or type(error).__name__}"
        ) from None
    x = np.asarray(grid.points, dtype=np.float64)
    given = {
        name: np.asarray(grid.point_data[name], np.float64)
        for name in ("radius", "velocity")
        if name in grid.point_data
    }
    if not all(np.isfinite(values).all() for values in (x, *given.values())):
        raise SceneError(
            f"{path}:1: a position, radius or velocity is not a finite number"
        )
    return ParticleTable(x, given.get("radius"), given.get("velocity"))
