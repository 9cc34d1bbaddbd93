"""Cell fields, and averages of them, as VTU files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import skfem

from contbed.output.files import atomic
from contbed.two_fluid.averages import Averages
from contbed.two_fluid.simulation import Simulation

_NAMES = {
    "RefLine": "line",
    "RefTri": "triangle",
    "RefQuad": "quad",
    "RefTet": "tetra",
    "RefHex": "hexahedron",
}
_HEXAHEDRON = [0, 1, 4, 2, 3, 5, 7, 6]  # scikit-fem's corners in VTK's order


def write(
    path: Path, mesh: skfem.Mesh, bed: Simulation, averages: Averages | None
) -> str:
    """Write the fields of a bed on a mesh; return the name of the file to open."""
    cells, fields = bed.model.grid.cells, {}
    for name, values in fields_of(
        bed, None if averages is None else averages.whole()
    ).items():
        fields[name] = np.empty_like(values, order="C")
        fields[name][cells] = values
    write_cells(path, *corners_of(mesh), mesh.p.T, fields)
    return path.name


def fields_of(bed: Simulation, averages: Averages | None) -> dict[str, np.ndarray]:
    """Return the fields of own cells, and their means if there are some, by the
    names that files give them.
    """
    own = bed.model.grid.halo.cells
    found = {name: values[own] for name, values in bed.state.fields().items()}
    if averages is not None and averages.weight.any():
        found |= {f"{name}_mean": values for name, values in averages.means().items()}
    return found


def corners_of(mesh: skfem.Mesh) -> tuple[str, np.ndarray]:
    """Return the name of the cells of a mesh and their nodes (ncells, corners), as
    VTK has them.
    """
    return _NAMES[mesh.elem.refdom.__name__], in_order_of_vtk(mesh.t.T)


def in_order_of_vtk(corners: np.ndarray) -> np.ndarray:
    """Return the nodes (ncells, corners) of cells of scikit-fem as VTK has them."""
    return corners[:, _HEXAHEDRON] if corners.shape[1] == len(_HEXAHEDRON) else corners


def write_cells(
    path: Path,
    kind: str,
    corners: np.ndarray,
    points: np.ndarray,
    fields: Mapping[str, np.ndarray],
) -> None:
    """Write fields (nc,) or (nc, dim) of cells with `corners` (nc, n) among `points`
    (np, dim).
    """
    import meshio

    data = {
        name: [values if values.ndim == 1 else _padded(values)]
        for name, values in fields.items()
    }
    with atomic(path) as temporary:
        meshio.Mesh(_padded(points), [(kind, corners)], cell_data=data).write(
            temporary, file_format="vtu"
        )


def _padded(rows: np.ndarray) -> np.ndarray:
    """Return rows (n, dim) with zeros for the directions that are not there, (n, 3)."""
    out = np.zeros((len(rows), 3))
    out[:, : rows.shape[1]] = rows
    return out
