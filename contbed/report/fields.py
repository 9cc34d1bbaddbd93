"""Fields of a run on a regular grid for the pictures of a report: planes as they are,
boxes in their middle plane.

Cells of first and second order become triangles, on which values at nodes are linear
and values of cells constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import ContbedError
from contbed.output.nearest import Nearest
from contbed.output.stored import read_fields
from contbed.output.tables import evenly
from contbed.output.vtu import TRIANGLES
from contbed.report.read import Run, Snapshot

LONG_SIDE = 140  # points of a picture along its longer side
MAX_FRAMES = 25  # times of a transient
# values of all pictures of one run together, which take 2.7 bytes each
MAX_SAMPLES = 1_500_000


@dataclass(frozen=True)
class Pictures:
    """One field over a plane at several times.

    `frames` (times, ny, nx) has nan outside of the bed; `x` and `y` [m] are the points,
    `axes` their names; `remark` says where a box is cut, `times` [s] is empty in a
    steady run.
    """

    field: str
    axes: tuple[str, str]
    x: Array
    y: Array
    frames: Array
    times: tuple[float, ...]
    remark: str


@dataclass(frozen=True)
class Cloud:
    """Particles at several times, seen from the side: x, z and radius [m], and one
    value of each for its colour.
    """

    field: str
    frames: tuple[tuple[Array, Array, Array, Array], ...]
    times: tuple[float, ...]
    remark: str

    def box(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the intervals of x and z [m] that hold all particles at all times."""
        x, z, radius = (
            np.concatenate([frame[k] for frame in self.frames]) for k in range(3)
        )
        across, along = (
            (float((at - radius).min()), float((at + radius).max())) for at in (x, z)
        )
        return across, along


def pictures(run: Run) -> list[Pictures | Cloud]:
    """Return the pictures of all fields of a run at `MAX_FRAMES` times at most; none without
    fields or on a line.

    Raises
    ------
    ContbedError : a file is damaged, or has other fields than the others
    """
    if not run.snapshots:
        return []
    chosen = [run.snapshots[k] for k in evenly(len(run.snapshots), MAX_FRAMES)]
    meshes = [read_fields(snapshot.file) for snapshot in chosen]
    _require_alike(meshes, chosen)
    times = tuple(snapshot.time for snapshot in chosen if snapshot.time is not None)
    kinds = {block.type for block in meshes[0].cells}
    if kinds == {"vertex"}:
        return [_cloud(meshes, times)]
    points = meshes[0].points
    flat = [k for k in range(3) if np.ptp(points[:, k]) == 0.0]
    if len(flat) == 1 and kinds <= set(TRIANGLES):
        return _planes(meshes, times, flat[0], run)
    if not flat:
        return _slices(meshes, times)
    return []


def _require_alike(meshes: Sequence[Any], chosen: Sequence[Snapshot]) -> None:
    """Raise ContbedError where a file has other cells or fields than the first one,
    or particles without a size.
    """
    first = _contents(meshes[0])
    for mesh, snapshot in zip(meshes, chosen, strict=True):
        kinds, names = _contents(mesh)
        advice = "remove it, or run the scene again"
        if (kinds, names) != first:
            one = min((kinds ^ first[0]) or (names ^ first[1]))
            raise ContbedError(
                f"{snapshot.file}: its fields are not those of {chosen[0].file.name} "
                f"({one}); {advice}"
            )
        if kinds == {"vertex"} and "radius" not in names:
            raise ContbedError(
                f"{snapshot.file}: particles without their radius; {advice}"
            )


def _contents(mesh: Any) -> tuple[set[str], set[str]]:
    """Return the types of the cells and the names of the fields."""
    return {block.type for block in mesh.cells}, set(_scalars(mesh))


def _scalars(mesh: Any) -> dict[str, tuple[Array, bool]]:
    """Return the fields by name, magnitudes of vectors, and whether they are of
    cells.
    """
    found = {}
    for name, values in mesh.point_data.items():
        found[name] = (np.asarray(values, dtype=float), False)
    for name, blocks in mesh.cell_data.items():
        if name != "region":
            found[name] = (
                np.concatenate([np.asarray(block, dtype=float) for block in blocks]),
                True,
            )
    return {
        f"|{name}|" if values.ndim > 1 else name: (
            np.linalg.norm(values, axis=1) if values.ndim > 1 else values,
            cells,
        )
        for name, (values, cells) in found.items()
    }


def _grid(points: Array, axes: tuple[int, int], count: int) -> tuple[Array, Array]:
    """Return the points of a picture along its two axes, at the middle of equal
    parts.
    """
    low, high = points[:, axes].min(axis=0), points[:, axes].max(axis=0)
    size = high - low
    numbers = np.maximum(2, np.round(LONG_SIDE * size / size.max())).astype(int)
    if count:  # fewer where there are many pictures
        scale = min(1.0, np.sqrt(MAX_SAMPLES / (count * numbers.prod())))
        numbers = np.maximum(2, (numbers * scale).astype(int))
    x, y = (low[k] + size[k] * (np.arange(n) + 0.5) / n for k, n in enumerate(numbers))
    return x, y


def _planes(
    meshes: list[Any], times: tuple[float, ...], flat: int, run: Run
) -> list[Pictures | Cloud]:
    from matplotlib.tri import LinearTriInterpolator, Triangulation

    axes = tuple(k for k in range(3) if k != flat)
    names = _axis_names(run, axes)
    first = meshes[0]
    x, y = _grid(first.points, (axes[0], axes[1]), len(meshes) * len(_scalars(first)))
    found: dict[str, list[Array]] = {}
    X, Y = np.meshgrid(x, y)
    for mesh in meshes:
        triangles, owners = [], []
        start = 0
        for block in mesh.cells:
            for corners in TRIANGLES[block.type]:
                triangles.append(block.data[:, corners])
                owners.append(start + np.arange(len(block.data)))
            start += len(block.data)
        plane = Triangulation(
            mesh.points[:, axes[0]], mesh.points[:, axes[1]], np.concatenate(triangles)
        )
        finder = plane.get_trifinder()
        where = np.asarray(finder(X, Y))
        owner = np.concatenate(owners)
        for name, (values, cells) in _scalars(mesh).items():
            if cells:
                sampled = np.where(where >= 0, values[owner[where]], np.nan)
            else:
                sampled = np.ma.filled(
                    LinearTriInterpolator(plane, values, finder)(X, Y), np.nan
                )
            found.setdefault(name, []).append(sampled)
    return [
        Pictures(name, names, x, y, np.array(frames), times, "")
        for name, frames in found.items()
    ]


def _slices(meshes: list[Any], times: tuple[float, ...]) -> list[Pictures | Cloud]:
    """Return the fields of a box in the plane through the middle of its shortest
    side.
    """
    points = meshes[0].points
    normal = int(np.argmin(np.ptp(points, axis=0)))
    axes = tuple(k for k in range(3) if k != normal)
    x, y = _grid(points, (axes[0], axes[1]), len(meshes) * len(_scalars(meshes[0])))
    middle = 0.5 * (points[:, normal].min() + points[:, normal].max())
    X, Y = np.meshgrid(x, y)
    wanted = np.empty((X.size, 3))
    wanted[:, axes[0]] = X.ravel()
    wanted[:, axes[1]] = Y.ravel()
    wanted[:, normal] = middle
    found: dict[str, list[Array]] = {}
    for mesh in meshes:
        centres = np.concatenate(
            [mesh.points[block.data].mean(axis=1) for block in mesh.cells]
        )
        fields = _scalars(mesh)
        kinds = {cells for _, cells in fields.values()}
        nearest = {
            cells: Nearest.of(centres if cells else mesh.points, wanted)
            for cells in kinds
        }
        for name, (values, cells) in fields.items():
            found.setdefault(name, []).append(nearest[cells](values).reshape(X.shape))
    remark = f"plane {'xyz'[normal]} = {middle:.4g} m"
    names = ("xyz"[axes[0]], "xyz"[axes[1]])
    return [
        Pictures(name, names, x, y, np.array(frames), times, remark)
        for name, frames in found.items()
    ]


def _cloud(meshes: list[Any], times: tuple[float, ...]) -> Cloud:
    """Return particles from the side, coloured by temperature where there is one,
    else by speed.
    """
    first = _scalars(meshes[0])
    field = next(
        (name for name in ("T", "T_solid", "|velocity|") if name in first),
        next(iter(first)),
    )
    frames = []
    for mesh in meshes:
        known = _scalars(mesh)
        nearest_last = np.argsort(-mesh.points[:, 1])
        x, _, z = mesh.points[nearest_last].T
        frames.append(
            (x, z, known["radius"][0][nearest_last], known[field][0][nearest_last])
        )
    return Cloud(field, tuple(frames), times, "all particles, seen along y")


def _axis_names(run: Run, axes: tuple[int, ...]) -> tuple[str, str]:
    """Return the names of the axes of a plane; r and z where the mesh is
    axisymmetric.
    """
    headers = {
        header.split(" ")[0] for table in run.tables.values() for header in table
    }
    if (
        "axisymmetric" in str(run.summary.get("scene", {}).get("mesh", {}))
        or "r" in headers
    ):
        return "r", "z"
    return "xyz"[axes[0]], "xyz"[axes[1]]
