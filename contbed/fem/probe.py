"""Values of finite-element fields at given points, and along the axis of a bed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from contbed.fem.elements import Space, lagrange
from contbed.mesh.mesh import Mesh

SAMPLES = 12  # points in a cell of a line


class Probe:
    """Interpolation at points (dim, n) of a mesh; the caller makes sure that all points lie inside."""

    def __init__(self, mesh: Mesh, points: Any):
        grid = mesh.skfem
        if grid.dim() == 1:
            nodes = grid.p[0, grid.t]
            order = np.argsort(nodes.min(axis=0))
            low = nodes.min(axis=0)[order]
            at = order[np.clip(np.searchsorted(low, points[0], side="right") - 1, 0, len(order) - 1)]
            first, second = nodes[0, at], nodes[1, at]
            self.cells, self.local = at, ((points[0] - first) / (second - first))[None, :]
        else:
            # scikit-fem splits quadrilaterals to search, and would look up every named facet in the result one by one
            self.cells = replace(grid, _boundaries=None, _subdomains=None).element_finder()(*points)
            mapping = grid._mapping()
            self.local = mapping.invF(points[:, :, None], tind=self.cells)[:, :, 0]

    def __call__(self, space: Space, values: Any) -> Any:
        """Return the values (n,) of a nodal field (size,)."""
        table = space.element.table(self.local)
        return (table * values[space.dofs[:, self.cells]]).sum(axis=0)

    def slope(self, space: Space, values: Any, axis: int) -> Any:
        """Return the derivative (n,) of a nodal field along a coordinate; one-sided between cells."""
        grid, element = space.mesh, space.element
        corners = grid.p[:, grid.t[:, self.cells]]
        geometry = lagrange(element.refdom, 1)
        tables = [geometry.table(self.local, a) for a in range(element.dim)]
        jacobian = np.array([np.einsum("ikn,kn->in", corners, table) for table in tables])
        inverse = np.linalg.inv(np.moveaxis(jacobian, 2, 0))
        local = values[space.dofs[:, self.cells]]
        slopes = np.array([(element.table(self.local, a) * local).sum(axis=0) for a in range(element.dim)])
        return np.einsum("nka,an->kn", inverse, slopes)[axis]


def axis_points(mesh: Mesh, wanted: Sequence[float] = ()) -> tuple[Any, Any]:
    """Return positions along the bed axis [m] and the points (dim, n) on its centre line.

    Positions are those that are `wanted`, in ascending order. Without any, a line is sampled at `SAMPLES` points in
    each cell and other meshes at 401 equally spaced points. The centre line is that of the bounding box of the mesh.
    """
    grid = mesh.skfem
    positions: Any = np.unique(wanted)
    if not len(wanted):
        if grid.dim() == 1:
            nodes = np.unique(grid.p[0])
            fractions = np.arange(SAMPLES) / SAMPLES
            positions = np.append((nodes[:-1, None] + np.diff(nodes)[:, None] * fractions).ravel(), nodes[-1])
        else:
            positions = np.linspace(grid.p[mesh.axis].min(), grid.p[mesh.axis].max(), 401)
    points = np.empty((grid.dim(), len(positions)))
    for k in range(grid.dim()):
        low, high = grid.p[k].min(), grid.p[k].max()
        points[k] = low if mesh.axisymmetric and k == 0 else 0.5 * (low + high)
    points[mesh.axis] = positions
    return positions, points
