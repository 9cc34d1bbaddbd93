"""Particles of files: those that a scene names, and points of a VTU file for
ParaView's glyphs.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contbed.arrays import Array
from contbed.dem import dumps
from contbed.dem.particle_tables import has_radii, read_table
from contbed.errors import SceneError
from contbed.fields import field
from contbed.output.files import atomic
from contbed.scene.stamp import Stamp, stamp_of


class FileParticles(NamedTuple):
    """Spheres of a file: centres (n, 3) [m], radii (n,) [m], velocities (n, 3) [m/s] or
    None.

    `low`, `high` [m] are the corners of the box and `periodic` its closed axes; None
    and open for a table of positions. Centres are inside of the periodic sides.
    """

    x: Array
    radius: Array
    velocity: Array | None = None
    low: Array | None = None
    high: Array | None = None
    periodic: tuple[bool, ...] = (False, False, False)

    @property
    def box(self) -> tuple[Array, Array]:
        """Corners of the box, of a table of positions that of the spheres [m]."""
        if self.low is not None and self.high is not None:
            return self.low, self.high
        return (self.x - self.radius[:, None]).min(axis=0), (
            self.x + self.radius[:, None]
        ).max(axis=0)


def read_particles(path: Path, radius: float | None = None) -> FileParticles:
    """Read the particles of a table, or of the last step of a dump.

    Parameters
    ----------
    path : dump of LIGGGHTS or LAMMPS, a table with commas, or a VTU file of contbed;
        .gz of text is unpacked
    radius : of all spheres [m]; None: as the file says

    Raises
    ------
    SceneError : with file and line, where the file cannot be used
    """
    try:
        stamp = stamp_of(path)
    except OSError:
        raise SceneError(f"{path}:1: no such file") from None
    return _read(path, radius, stamp)


@lru_cache(maxsize=2)
def _read(path: Path, radius: float | None, stamp: Stamp) -> FileParticles:
    """Read a file and keep it for the checks of a scene and its plan, until `stamp`
    changes.
    """
    if not dumps.is_dump(path):
        table = read_table(path)
        given = table.radius if radius is None else np.full(len(table.x), radius)
        if given is None:
            raise SceneError(
                f"{path}:1: no radius; set solids.NAME.diameter, or add a column radius"
            )
        return FileParticles(table.x, given, table.velocity)
    frame = dumps.read_dump(path)[-1]
    frame.require_usable(path)
    speeds = [frame.columns.get(name) for name in ("vx", "vy", "vz")]
    known = [speed for speed in speeds if speed is not None]
    velocity = np.stack(known, axis=1) if len(known) == 3 else None
    radii = frame.radius if radius is None else np.full(len(frame.x), radius)
    return FileParticles(
        wrapped(frame.x, frame.low, frame.high, frame.periodic),
        radii,
        velocity,
        frame.low,
        frame.high,
        frame.periodic,
    )


def tells_radii(path: Path) -> bool:
    """Whether a file of particles has their radii, so that the scene need not give
    one.
    """
    return dumps.is_dump(path) or has_radii(path)


def wrapped(x: Array, low: Any, high: Any, periodic: Any) -> Array:
    """Bring centres x (n, d) into the periodic sides; those that are inside stay as
    they are.
    """
    turns = np.floor((x - low) / (high - low))
    return np.where((turns != 0.0) & np.array(periodic), x - turns * (high - low), x)


def write_particles(path: Path | str, x: Array, columns: Mapping[str, Array]) -> None:
    """Write centres and columns of particles, in SI, as points of a VTU file.

    Parameters
    ----------
    path : the file
    x : centres (n, 3) [m]
    columns : values (n,) or (n, 3) by the name of a field; `contbed.fields` says unit
        and meaning

    Raises
    ------
    ValueError : a column is no field
    """
    import meshio

    for name in columns:
        if field(name) is None:
            raise ValueError(f"{path}: column {name!r} is not listed in contbed.fields")
    grid = meshio.Mesh(x, [("vertex", np.arange(len(x))[:, None])], dict(columns))
    with atomic(path) as temporary:
        meshio.write(temporary, grid, file_format="vtu")
