"""Fields of a large mesh as one VTU piece for each rank, written at the same time,
and a .pvtu that names them.
"""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from contbed.fem.elements import Space
from contbed.output.files import announce, atomic
from contbed.output.vtu import write_fields
from contbed.ranks.group import RankGroup, rank_group
from contbed.ranks.system import Partition

WHOLE = 100_000  # cells up to which rank 0 writes one file


def write(path: Path, mesh: Any, nodal: Mapping[str, tuple[Space, Any]]) -> str:
    """Write fields of rank 0's mesh, see `output.vtu.write_fields`; returns the name
    of the file to open.
    """
    all_ranks = rank_group()
    if all_ranks.comm.size == 1 or mesh.nelements <= WHOLE:
        return write_fields(path, mesh, nodal)
    partition = Partition.of(all_ranks, mesh)
    names = [*(mesh.subdomains or {})] if len(mesh.subdomains or {}) > 1 else []
    region = np.full((mesh.nelements, 1), -1, dtype=np.int64)
    for k, name in enumerate(names):
        region[mesh.subdomains[name], 0] = k
    fields = {
        name: (
            space.degree,
            np.atleast_2d(values).shape[0] if np.ndim(values) > 1 else 0,
        )
        for name, (space, values) in nodal.items()
    }
    corners = mesh.p[:, mesh.t].transpose(2, 0, 1).reshape(mesh.nelements, -1)
    by_cell = [
        row[space.dofs.T]
        for space, values in nodal.values()
        for row in np.atleast_2d(values)
    ]
    root = [partition.split(table) for table in (mesh.t.T, corners, region, *by_cell)]
    folder = path.parent.resolve()
    for rank in range(all_ranks.comm.size):
        announce(path.with_name(name_of(path.stem, rank)))
    all_ranks.run_on_all(
        write_piece,
        type(mesh),
        mesh.dim(),
        fields,
        names,
        str(folder),
        path.stem,
        root=root,
    )
    points = {
        name: ("Float64", 3 if ncomponents else 1)
        for name, (_, ncomponents) in fields.items()
    }
    return write_header(
        path, points, {"region": ("Int32", 1)} if names else {}, all_ranks.comm.size
    )


def write_header(
    path: Path,
    points: Mapping[str, tuple[str, int]],
    cells: Mapping[str, tuple[str, int]],
    count: int,
) -> str:
    """Write the .pvtu beside the pieces of `path`, after them; return its name.

    Parameters
    ----------
    path : of the .vtu that the pieces stand for
    points, cells : VTK's type and number of components of each array
    count : number of pieces
    """

    def array(name: str, kind: str, ncomponents: int) -> str:
        return (
            f'      <PDataArray type="{kind}" Name="{escape(name)}" '
            f'NumberOfComponents="{ncomponents}"/>'
        )

    text = "\n".join(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="PUnstructuredGrid" version="0.1">',
            "  <PUnstructuredGrid>",
            "    <PPointData>",
            *(array(name, *what) for name, what in points.items()),
            "    </PPointData>",
            "    <PCellData>",
            *(array(name, *what) for name, what in cells.items()),
            "    </PCellData>",
            "    <PPoints>",
            array("Points", "Float64", 3),
            "    </PPoints>",
            *(
                f'    <Piece Source="{escape(name_of(path.stem, rank))}"/>'
                for rank in range(count)
            ),
            "  </PUnstructuredGrid>",
            "</VTKFile>",
            "",
        ]
    )
    header = path.with_suffix(".pvtu")
    with atomic(header) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return header.name


def name_of(stem: str, rank: int) -> str:
    """Return the name of the piece of a rank."""
    return f"{stem}_p{rank:05d}.vtu"


def write_piece(
    all_ranks: RankGroup,
    root: Any,
    kind: Any,
    dim: int,
    fields: dict[str, tuple[int, int]],
    names: list[str],
    folder: str,
    stem: str,
) -> None:
    """Write the cells of this rank as one file; runs on all ranks."""
    tables = iter(root or ())

    def share(width: int, dtype: Any) -> Any:
        values, counts = next(tables, (None, None))
        return all_ranks.scatter(values, counts, width, dtype)

    shape = kind.elem.refdom
    cells = share(shape.nnodes, np.int64)
    corners = share(dim * shape.nnodes, float).reshape(len(cells), dim, shape.nnodes)
    region = share(1, np.int64)[:, 0]
    vertices, local = np.unique(cells, return_inverse=True)
    t = local.reshape(cells.shape).T
    points = np.empty((dim, len(vertices)))
    points[:, t] = corners.transpose(1, 2, 0)
    mesh = kind(points, t)
    nodal = {}
    for name, (degree, ncomponents) in fields.items():
        space = Space(mesh, degree)
        values = np.empty((max(ncomponents, 1), space.size))
        for row in values:
            row[space.dofs.T] = share(len(space.element.nodes), float)
        nodal[name] = (space, values if ncomponents else values[0])
    if names:
        mesh = mesh.with_subdomains(
            {name: np.flatnonzero(region == k) for k, name in enumerate(names)}
        )
    write_fields(Path(folder) / name_of(stem, all_ranks.comm.rank), mesh, nodal)
    all_ranks.comm.Barrier()  # what names the pieces is written when all are there
