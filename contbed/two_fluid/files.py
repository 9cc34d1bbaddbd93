"""Cell fields as VTU files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import skfem

from contbed.output.files import atomic

_NAMES = {"RefLine": "line", "RefTri": "triangle", "RefQuad": "quad", "RefTet": "tetra", "RefHex": "hexahedron"}
_HEXAHEDRON = [0, 1, 4, 2, 3, 5, 7, 6]  # scikit-fem's corners in VTK's order


def write_cells(path: Path, mesh: skfem.Mesh, cells: np.ndarray, fields: Mapping[str, np.ndarray]) -> None:
    """Write fields (nc,) or (nc, dim), value k of which belongs to cell cells[k] of the mesh."""
    import meshio

    corners = mesh.t.T
    kind = _NAMES[mesh.elem.refdom.__name__]
    if kind == "hexahedron":
        corners = corners[:, _HEXAHEDRON]
    data = {}
    for name, values in fields.items():
        out = np.zeros((len(cells), 3) if values.ndim > 1 else len(cells))
        if values.ndim > 1:
            out[cells, : values.shape[1]] = values
        else:
            out[cells] = values
        data[name] = [out]
    points = np.zeros((mesh.p.shape[1], 3))
    points[:, : mesh.dim()] = mesh.p.T
    with atomic(path) as temporary:
        meshio.Mesh(points, [(kind, corners)], cell_data=data).write(temporary, file_format="vtu")
