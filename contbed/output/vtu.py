"""Fields as VTU files with quadratic cells, and time series of them, for ParaView
and meshio.
"""

from __future__ import annotations

import sys
import zlib
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from skfem.refdom import RefHex, RefLine, RefQuad, RefTet, RefTri

from contbed.arrays import Array, Integers
from contbed.fem.elements import Space, lagrange
from contbed.output.files import atomic, write_text

if TYPE_CHECKING:
    import skfem


_VTK_TYPES = {
    "line3": 21,
    "triangle6": 22,
    "quad9": 28,
    "tetra10": 24,
    "hexahedron27": 29,
}
_KINDS = {"f": "Float", "i": "Int", "u": "UInt"}
_BYTE_ORDER = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
_BLOCK = 32_768  # bytes that are compressed together, as VTK does

# triangles of the nodes of VTK's cells
TRIANGLES = {
    "triangle": [(0, 1, 2)],
    "triangle6": [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)],
    "quad": [(0, 1, 2), (0, 2, 3)],
    "quad9": [
        (0, 4, 8),
        (0, 8, 7),
        (4, 1, 5),
        (4, 5, 8),
        (8, 5, 2),
        (8, 2, 6),
        (7, 8, 6),
        (7, 6, 3),
    ],
}

_SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
_CUBE = [(*corner, z) for z in (0, 1) for corner in _SQUARE]
_CUBE_EDGES = [
    (0, 1),
    (1, 2),
    (2, 3),
    (3, 0),
    (4, 5),
    (5, 6),
    (6, 7),
    (7, 4),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
]
# VTK's cells: name, corners, edges, then the remaining nodes (faces and centre), on the
# unit reference cell
_CELLS: dict[type, tuple[str, list[Any], list[Any], list[Any]]] = {
    RefLine: ("line3", [(0,), (1,)], [(0, 1)], []),
    RefTri: ("triangle6", [(0, 0), (1, 0), (0, 1)], [(0, 1), (1, 2), (2, 0)], []),
    RefQuad: ("quad9", _SQUARE, [(0, 1), (1, 2), (2, 3), (3, 0)], [(0.5, 0.5)]),
    RefTet: (
        "tetra10",
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
        [],
    ),
    RefHex: (
        "hexahedron27",
        _CUBE,
        _CUBE_EDGES,
        [
            (0, 0.5, 0.5),
            (1, 0.5, 0.5),
            (0.5, 0, 0.5),
            (0.5, 1, 0.5),
            (0.5, 0.5, 0),
            (0.5, 0.5, 1),
            (0.5, 0.5, 0.5),
        ],
    ),
}


def _order(refdom: type, mirrored: bool) -> Integers:
    """Return the local node of the quadratic element at each VTK position;
    `mirrored` swaps the first two axes.
    """
    _, corners, edges, others = _CELLS[refdom]
    vertices = np.array(corners, dtype=float)
    nodes = np.vstack(
        [vertices, *(vertices[[a, b]].mean(axis=0) for a, b in edges), *others]
    )
    if mirrored:
        nodes[:, [0, 1]] = nodes[:, [1, 0]]
    distance = np.abs(nodes[:, None] - lagrange(refdom, 2).nodes).sum(axis=2)
    order: Integers = distance.argmin(axis=1)
    return order


def quadratic_cells(space: Space) -> tuple[str, Integers]:
    """Return name and nodes (ncells, n) of VTK's quadratic cells on a space of
    degree 2, all positive.
    """
    mesh = space.mesh
    refdom: Any = space.element.refdom
    cells = space.dofs[_order(refdom, False)].T.astype(np.int64)
    if mesh.dim() > 1:
        corner = refdom.p.mean(axis=1, keepdims=True)
        slopes = [
            lagrange(refdom, 1).table(corner, axis)[:, 0] for axis in range(mesh.dim())
        ]
        jacobian = np.einsum("ikc,ak->cia", mesh.p[:, mesh.t], slopes)
        negative = np.linalg.det(jacobian) < 0
        cells[negative] = space.dofs[_order(refdom, True)].T[negative]
    return _CELLS[refdom][0], cells


def at_nodes(space: Space, values: Array, target: Space) -> Array:
    """Interpolate a field (size,) or (ncomponents, size) to the nodes of another
    space on the same mesh.
    """
    values = np.asarray(values, dtype=float)
    if values.shape[-1] != space.size:
        raise ValueError(f"{values.shape[-1]} values on a space of {space.size} nodes")
    if space.degree == target.degree:
        return values
    table = space.element.table(target.element.nodes.T)
    out = np.empty((*values.shape[:-1], target.size))
    out[..., target.dofs] = np.einsum("...kc,kn->...nc", values[..., space.dofs], table)
    return out


def write_fields(
    path: Path,
    mesh: skfem.Mesh,
    nodal: Mapping[str, tuple[Space, Array]],
) -> str:
    """Write fields on Lagrange spaces of degree 1 to 3 as one .vtu with quadratic
    cells; return its name.

    Parameters
    ----------
    path : the file
    mesh : mesh of all spaces
    nodal : space and values, (size,) or (ncomponents, size), of each field; names ASCII
        without spaces

    Where there is more than one region, `region` numbers those of the cells in the order
    of `mesh.subdomains`.
    """
    quadratic = Space(mesh, 2)
    name, cells = quadratic_cells(quadratic)
    data = {}
    for field, (space, values) in nodal.items():
        if not field.isascii() or not field.isprintable() or " " in field:
            raise ValueError(
                f"{path}: field name {field!r} is not plain ASCII without spaces"
            )
        sampled = at_nodes(space, values, quadratic)
        data[field] = sampled if sampled.ndim == 1 else _padded(sampled)
    subdomains = mesh.subdomains or {}
    cell_data: dict[str, NDArray[Any]] = {}
    if len(subdomains) > 1:
        number = np.full(mesh.nelements, -1, dtype=np.int32)
        for k, members in enumerate(subdomains.values()):
            number[members] = k
        cell_data["region"] = number
    ncells, corners = cells.shape
    arrays: dict[str, dict[str, NDArray[Any]]] = {
        "Points": {"Points": _padded(quadratic.points)},
        "Cells": {
            "connectivity": cells.ravel(),
            "offsets": np.arange(1, ncells + 1) * corners,
            "types": np.full(ncells, _VTK_TYPES[name], dtype=np.uint8),
        },
        "PointData": {**data},
        "CellData": cell_data,
    }
    with atomic(path) as temporary, open(temporary, "w", encoding="ascii") as file:
        file.writelines(_unstructured_grid(len(quadratic.points.T), ncells, arrays))
    return path.name


def _unstructured_grid(
    npoints: int, ncells: int, arrays: Mapping[str, Mapping[str, NDArray[Any]]]
) -> Iterator[str]:
    """Yield the pieces of a file of VTK's XML format, the arrays of each section
    compressed and in base64.
    """
    yield (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" '
        f'byte_order="{_BYTE_ORDER}" '
        'header_type="UInt32" compressor="vtkZLibDataCompressor">\n'
        "<UnstructuredGrid>\n"
        f'<Piece NumberOfPoints="{npoints}" NumberOfCells="{ncells}">\n'
    )
    for section, members in arrays.items():
        if members:
            yield f"<{section}>\n"
            for name, values in members.items():
                kind = f"{_KINDS[values.dtype.kind]}{8 * values.itemsize}"
                ncomponents = (
                    f'NumberOfComponents="{values.shape[1]}" '
                    if values.ndim == 2
                    else ""
                )
                yield f'<DataArray type="{kind}" Name="{escape(name)}" {ncomponents}format="binary">\n'
                yield f"{_compressed(values.tobytes())}\n</DataArray>\n"
            yield f"</{section}>\n"
    yield "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"


def _compressed(content: bytes) -> str:
    """Return bytes as VTK reads them: number of blocks, size of each, of the last,
    compressed sizes; the blocks.
    """
    blocks = [content[k : k + _BLOCK] for k in range(0, len(content), _BLOCK)]
    packed = [zlib.compress(block) for block in blocks]
    last = len(content) % _BLOCK  # 0: the last one is full
    sizes = np.array([len(blocks), _BLOCK, last, *map(len, packed)], dtype=np.uint32)
    return (b64encode(sizes.tobytes()) + b64encode(b"".join(packed))).decode("ascii")


def _padded(rows: Array) -> Array:
    """Pad components with zeros, (ncomponents, n) -> (n, 3)."""
    out = np.zeros((rows.shape[1], 3))
    out[:, : len(rows)] = rows.T
    return out


def write_series(path: Path | str, files: Sequence[tuple[float, str]]) -> None:
    """Write a .pvd that lists (time [s], file name relative to it)."""
    lines = [
        f'    <DataSet timestep="{time:.17g}" part="0" file="{escape(name)}"/>'
        for time, name in files
    ]
    head = [
        '<?xml version="1.0"?>',
        '<VTKFile type="Collection" version="0.1">',
        "  <Collection>",
    ]
    text = "\n".join([*head, *lines, "  </Collection>", "</VTKFile>", ""])
    write_text(path, text)
