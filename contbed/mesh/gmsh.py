"""Gmsh meshes (.msh, read with meshio) and geometries (.geo, meshed by gmsh) as checked
scikit-fem meshes.

Physical groups of the mesh's dimension name its regions, those of one dimension less
its boundaries. Only a .geo imports gmsh.
"""

from __future__ import annotations

import contextlib
import io
import re
import subprocess
import sys
import tempfile
import warnings
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import skfem

from contbed.errors import SceneError
from contbed.mesh.check import Cells, assemble
from contbed.scene.mesh import MeshFile

_NAMES = re.compile(rb"\$PhysicalNames(.*?)\$EndPhysicalNames", re.DOTALL)
LONGEST = 600.0  # [s] that gmsh may take for a geometry
SYSTEM_LIBRARIES = "libglu1-mesa libgl1 libxcursor1 libxft2 libxinerama1 libgomp1"


def read(settings: MeshFile, base: str = ".") -> skfem.Mesh:
    """Return the mesh of a `type = "file"` table in m, with `boundaries` and
    `subdomains`.

    Groups of facets between two regions are left out of `boundaries`.

    Raises
    ------
    SceneError : one line for each problem, each starting with the file's name
    """
    path = Path(base) / settings.file
    try:
        path.open().close()
    except OSError as error:
        reason = error.strerror or error
        raise SceneError(
            f"{settings.file}: cannot be read ({reason}); looked for {path.absolute()}"
        ) from None
    if path.suffix == ".geo":
        with tempfile.TemporaryDirectory() as folder:
            mesh = Path(folder) / "mesh.msh"
            _run_gmsh(settings, path, mesh)
            points, cells = _load(settings, mesh)
    elif path.suffix == ".msh":
        points, cells = _load(settings, path)
    else:
        found = (
            f"a mesh file ends in .msh or .geo, found {path.suffix or 'no ending'!r}"
        )
        raise SceneError(f"{settings.file}: {found}; export it as gmsh 2.2 or 4.1")
    return assemble(settings, points, cells)


def _run_gmsh(settings: MeshFile, source: Path, target: Path) -> None:
    """Mesh the geometry `source` into `target`."""
    file = settings.file
    try:
        import gmsh  # noqa: F401
    except ImportError as error:
        raise SceneError(
            f"{file}: meshing a .geo needs gmsh ({error}); pip install gmsh, or give a "
            ".msh"
        ) from None
    except OSError as error:
        library = str(error).split(":")[0]
        remedy = f"on Debian or Ubuntu: apt install {SYSTEM_LIBRARIES}; or give a .msh"
        raise SceneError(
            f"{file}: gmsh needs the system library {library}, which is missing; "
            f"{remedy}"
        ) from None
    size = 0.0 if settings.size is None else settings.size / settings.scale
    command = [sys.executable, "-P", "-m", "contbed.mesh.geometry"]
    command += [str(source), str(target), str(settings.dimension), repr(size)]
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=LONGEST,
        )
    except subprocess.TimeoutExpired:
        raise SceneError(
            f"{file}: gmsh has not meshed it in {LONGEST:g} s; if that is no endless "
            "loop, mesh it with gmsh and give the .msh"
        ) from None
    if done.returncode or not target.is_file():
        lines = done.stderr.strip().splitlines()
        reason = lines[-1] if lines else f"its process ended with {done.returncode}"
        hint = f"run gmsh -{settings.dimension} on it"
        raise SceneError(f"{file}: gmsh cannot mesh it: {reason}; {hint}")


def _as_utf8(data: bytes) -> tuple[bytes, bool]:
    """Return a mesh with its names in UTF-8 without a byte order mark, and whether
    that has changed it.

    Names of other editors are taken as Windows-1252.
    """
    start = data.removeprefix(b"\xef\xbb\xbf")
    names = _NAMES.search(start)
    if names is not None:
        try:
            names[1].decode("utf-8")
        except UnicodeDecodeError:
            text = names[1].decode("cp1252", errors="replace").encode("utf-8")
            start = start[: names.start(1)] + text + start[names.end(1) :]
    return start, start is not data


def _read(path: Path, data: bytes) -> Any:
    """Read a mesh from bytes that differ from those of its file."""
    import meshio

    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        copy.write_bytes(data)
        return meshio.gmsh.read(copy)


def _one_line(text: object) -> str:
    return " ".join(str(text).split())


def _load(settings: MeshFile, path: Path) -> tuple[np.ndarray, dict[int, Cells]]:
    """Points (n, 3) and cells by dimension of a .msh file."""
    file, data = settings.file, path.read_bytes()
    if b"$MeshFormat" not in data[:10000]:
        raise SceneError(
            f"{file}: not a gmsh mesh (no $MeshFormat); export it from gmsh as version "
            "2.2 or 4.1"
        )
    missing = [
        name for name in ("Nodes", "Elements") if f"$End{name}".encode() not in data
    ]
    if missing:
        ends = " and ".join(f"$End{name}" for name in missing)
        raise SceneError(
            f"{file}: truncated or empty mesh, {ends} missing in {len(data)} bytes; "
            "write it again"
        )
    import meshio

    data, encoded = _as_utf8(data)
    try:
        with (
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()),
            warnings.catch_warnings(),
        ):
            # numpy's warning that a block of numbers ends early
            warnings.filterwarnings(
                "error",
                message="string or file could not be read",
                category=DeprecationWarning,
            )
            mesh = _read(path, data) if encoded else meshio.gmsh.read(path)
    # meshio lets any error of its parser through
    except (Exception, SystemExit) as error:
        reason = _one_line(error) or "meshio gives no reason"
        hint = "write it again with gmsh, Mesh.SaveAll = 0 and Mesh.SaveParametric = 0"
        raise SceneError(
            f"{file}: broken or unsupported mesh ({type(error).__name__}: {reason}); "
            f"{hint}"
        ) from None

    section = _NAMES.search(data)
    lines = re.findall(rb'(\d+)\s+(\d+)\s+"(.*?)"', section[1]) if section else []
    names = {
        (int(dim), int(tag)): name.decode(errors="replace") for dim, tag, name in lines
    }
    cells: dict[int, Cells] = defaultdict(Cells)
    counts: dict[tuple[int, str], int] = defaultdict(int)
    for i, block in enumerate(mesh.cells):
        here, start = cells[block.dim], counts[block.dim, block.type]
        here.nodes[block.type].append(np.asarray(block.data))
        counts[block.dim, block.type] += len(block.data)
        physical = mesh.cell_data.get("gmsh:physical")
        # negative: reversed
        tags = np.abs(physical[i]) if physical is not None else np.array([], dtype=int)
        for tag in np.unique(tags[tags != 0]):
            unnamed = (
                f"{'region' if block.dim == settings.dimension else 'boundary'}_{tag}"
            )
            here.groups[names.get((block.dim, int(tag)), unnamed)].append(
                start + np.flatnonzero(tags == tag)
            )
        # 4.1: meshio keeps further groups of the same entity here
        for name, rows in mesh.cell_sets.items():
            if (
                name in mesh.field_data
                and mesh.field_data[name][1] == block.dim
                and len(rows[i])
            ):
                here.groups[name].append(start + np.asarray(rows[i], dtype=int))
    for (dim, _), name in names.items():
        cells[dim].groups.setdefault(name, [])
    return np.asarray(mesh.points, dtype=float), cells
