"""Cell velocities from the faces of rectangular grids, see cell_velocities.py.

Each cell has two faces of equal size across each axis: least squares are means of their
two velocities.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import OUTLET, Edge
from contbed.two_fluid.cell_velocities import (
    MIN_MOMENT_WEIGHT,
    FaceVelocities,
    Gathered,
    solid_face_weight,
)
from contbed.two_fluid.compiled import Array, kernel
from contbed.two_fluid.fv.gradient import neighbour_weight
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.fv.rows import Rows


@kernel
def gather(
    g: Geometry,
    rows: Rows,
    faces: FaceVelocities,
    s: Array,
    grad_gas: Array,
    grad_solid: Array,
    out: Gathered,
) -> None:
    """Cell vectors (dim, nc) of both phases from the normal u and H of the faces;
    gradients are not needed here.

    A face with far fewer particles than the cell has less weight for those of the
    particles.
    """
    ni, total = len(g.right), np.empty((len(g.axes), len(s)))
    gas, solid, h_gas, h_solid = out.gas, out.solid, out.h_gas, out.h_solid
    for d in range(len(g.axes)):
        for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
            gas[d, c] = solid[d, c] = h_gas[d, c] = h_solid[d, c] = 0.0
            total[d, c] = 2.0 * MIN_MOMENT_WEIGHT
    for r in range(len(rows.length)):
        d, face, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
        of_left, of_right = (
            (left, rows.left_from[r], rows.left_to[r]),
            (right, rows.right_from[r], rows.right_to[r]),
        )
        for cell, start, stop in (of_left, of_right):
            for i in range(start, stop):
                gas[d, cell + i] += 0.5 * faces.gas[face + i]
                h_gas[d, cell + i] += 0.5 * faces.h_gas[face + i]
            for i in range(start, stop):
                weight = solid_face_weight(faces.eps_s[face + i], s[cell + i])
                solid[d, cell + i] += weight * faces.solid[face + i]
                h_solid[d, cell + i] += weight * faces.h_solid[face + i]
                total[d, cell + i] += weight
    for f in range(g.edge_from, g.edge_to):
        d, sign, c = rows.edge_axis[f - ni], rows.edge_sign[f - ni], g.left[f]
        weight = solid_face_weight(faces.eps_s[f], s[c])
        gas[d, c] += 0.5 * sign * faces.gas[f]
        h_gas[d, c] += 0.5 * sign * faces.h_gas[f]
        solid[d, c] += weight * sign * faces.solid[f]
        h_solid[d, c] += weight * sign * faces.h_solid[f]
        total[d, c] += weight
    for d in range(len(g.axes)):
        for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
            solid[d, c] /= total[d, c]
            h_solid[d, c] /= total[d, c]


@kernel
def divergence_solid(
    g: Geometry, rows: Rows, faces: FaceVelocities, s: Array, u: Array, out: Array
) -> None:
    """Divergence (nc,) [1/s] of the velocity u (dim, nc) of the solids."""
    ni = len(g.right)
    for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
        out[c] = u[0, c] / g.radius[c] if g.radius[c] > 0.0 else 0.0
    for r in range(len(rows.length)):
        d, face, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
        of_left = left, rows.left_from[r], rows.left_to[r], 1.0
        of_right = right, rows.right_from[r], rows.right_to[r], -1.0
        for cell, start, stop, sign in (of_left, of_right):
            for i in range(start, stop):
                weight = (
                    neighbour_weight(faces.eps_s[face + i], s[cell + i])
                    * g.area[face + i]
                    / g.volume[cell + i]
                )
                out[cell + i] += (
                    sign * weight * (faces.solid[face + i] - u[d, cell + i])
                )
    for f in range(g.edge_from, g.edge_to):
        d, sign, c = rows.edge_axis[f - ni], rows.edge_sign[f - ni], g.left[f]
        weight = neighbour_weight(faces.eps_s[f], s[c]) * g.area[f] / g.volume[c]
        out[c] += weight * (faces.solid[f] - sign * u[d, c])


@kernel
def face_residual(
    g: Geometry, rows: Rows, edge: Edge, face: Array, u: Array, grad: Array, out: Array
) -> None:
    """Set the Rhie-Chow residual `out` (nf,) [m/s]: normal gas velocity less that
    interpolated from u (dim, nc).

    `grad` is not needed here.
    """
    ni = len(g.right)
    for r in range(len(rows.length)):
        d, first, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
        for i in range(rows.left_from[r], rows.left_to[r]):
            w = g.weight[first + i]
            out[first + i] = face[first + i] - (
                w * u[d, left + i] + (1.0 - w) * u[d, right + i]
            )
    for f in range(g.edge_from, g.edge_to):
        sign, at_cell = rows.edge_sign[f - ni], u[rows.edge_axis[f - ni], g.left[f]]
        out[f] = face[f] - sign * at_cell if edge.gas.kind[f - ni] == OUTLET else 0.0
