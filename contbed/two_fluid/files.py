"""Cell fields, and averages of them, as VTU files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import skfem
from skfem.refdom import RefHex, RefLine, RefQuad, RefTet, RefTri

from contbed.output.files import atomic
from contbed.two_fluid.averages import Averages
from contbed.two_fluid.simulation import Simulation

# names of VTK, and the corners of scikit-fem in VTK's order
_CELLS = {
    RefLine: ("line", [0, 1]),
    RefTri: ("triangle", [0, 1, 2]),
    RefQuad: ("quad", [0, 1, 2, 3]),
    RefTet: ("tetra", [0, 1, 2, 3]),
    RefHex: ("hexahedron", [0, 1, 4, 2, 3, 5, 7, 6]),
}


def write(
    path: Path, mesh: skfem.Mesh, bed: Simulation, averages: Averages | None
) -> None:
    """Write the fields of a bed on a mesh, and their means if there are some."""
    import meshio

    fields = bed.state.fields()
    if averages is not None and averages.weight.any():
        fields |= {f"{name}_mean": values for name, values in averages.means().items()}
    data = {}
    for name, values in fields.items():
        by_cell = np.empty_like(values, order="C")
        by_cell[bed.model.grid.cells] = values
        data[name] = [by_cell if values.ndim == 1 else _padded(by_cell)]
    kind, order = _CELLS[mesh.elem.refdom]
    cells = [(kind, mesh.t[order].T)]
    with atomic(path) as temporary:
        made = meshio.Mesh(_padded(mesh.p.T), cells, cell_data=data)
        made.write(temporary, file_format="vtu")


def _padded(rows: np.ndarray) -> np.ndarray:
    """Return rows (n, dim) with zeros for the directions that are not there, (n, 3)."""
    out = np.zeros((len(rows), 3))
    out[:, : rows.shape[1]] = rows
    return out
