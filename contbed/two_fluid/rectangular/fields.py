"""Gradients, reconstruction and convection of fields on rectangular grids, see
fv/gradient.py and reconstruction.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.two_fluid.compiled import ZERO, Array, inner, kernel
from contbed.two_fluid.fv.gradient import add_boundary_gradient, neighbour_weight
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.fv.reconstruction import (
    Reconstruction,
    convect_at_boundary,
    limited_increment,
)
from contbed.two_fluid.fv.rows import Rows


@kernel
def gradient(g: Geometry, rows: Rows, values: Array, edge: Array, out: Array) -> None:
    """Gradients `out` (dim, m, nc) of `values` (m, nc) with boundary values `edge`
    (nb, m).
    """
    _set_gradient(rows, values, rows.slope_left, rows.slope_right, out)
    add_boundary_gradient(g, values.T, edge, out.T)


@inner
def _set_gradient(
    rows: Rows, values: Array, slope_left: Array, slope_right: Array, out: Array
) -> None:
    """Set `out` (dim, m, nc) to the sums of jumps of `values` (m, nc) across interior
    faces, with the slopes (ni,) of their left and right cells.
    """
    out[:, :, rows.begin : rows.end] = 0.0
    for r in range(len(rows.length)):
        d, face, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
        for k in range(values.shape[0]):
            for i in range(rows.left_from[r], rows.left_to[r]):
                jump = values[k, right + i] - values[k, left + i]
                out[d, k, left + i] += slope_left[face + i] * jump
            for i in range(rows.right_from[r], rows.right_to[r]):
                jump = values[k, right + i] - values[k, left + i]
                out[d, k, right + i] += slope_right[face + i] * jump


@inner
def weigh_neighbours(rows: Rows, s: Array, to_left: Array, to_right: Array) -> None:
    """Weights (ni,) of the right cell for particles of the left one, and of the left
    cell for those of the right one.

    See `neighbour_weight`; s (nc,) is the solids fraction.
    """
    for r in range(len(rows.length)):
        face, left, right = rows.face[r], rows.left[r], rows.right[r]
        for i in range(ZERO, rows.length[r]):
            to_left[face + i] = neighbour_weight(s[right + i], s[left + i])
        for i in range(ZERO, rows.length[r]):
            to_right[face + i] = neighbour_weight(s[left + i], s[right + i])


@kernel
def gradient_solid(
    g: Geometry, rows: Rows, s: Array, values: Array, edge: Array, out: Array
) -> None:
    """Gradients `out` (dim, m, nc) of a field of the particles; neighbours with few
    particles have less weight.
    """
    to_left, to_right = np.empty(len(g.right)), np.empty(len(g.right))
    weigh_neighbours(rows, s, to_left, to_right)
    for r in range(len(rows.length)):
        face = rows.face[r]
        for i in range(ZERO, rows.length[r]):
            to_left[face + i] *= rows.slope_left[face + i]
            to_right[face + i] *= rows.slope_right[face + i]
    _set_gradient(rows, values, to_left, to_right, out)
    add_boundary_gradient(g, values.T, edge, out.T)


@kernel
def predictor_half_step(
    g: Geometry,
    rows: Rows,
    dt: float,
    u: Array,
    grad: Array,
    carrier: Array,
    rate: Array,
    out: Array,
) -> None:
    """Set the change `out` (m, nc) in half a step, by convection with `carrier`
    (dim, nc) and by `rate` (m, nc).
    """
    for k in range(u.shape[0]):
        for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
            out[k, c] = 0.5 * dt * rate[k, c]
        for d in range(carrier.shape[0]):
            for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
                out[k, c] -= 0.5 * dt * carrier[d, c] * grad[d, k, c]


@inner
def upwind_values(
    rows: Rows,
    k: int,
    r: int,
    start: Any,
    stop: Any,
    flow: Array,
    field: Reconstruction,
    out: Array,
) -> None:
    """Set `out` (ni,) on the faces start to stop of row r to component k of the field.

    It is reconstructed in the cell that `flow` (nf,) comes from.
    """
    u, grad, half_step, first_order = (
        field.values,
        field.gradient,
        field.half_step,
        field.first_order,
    )
    arm_left, arm_right, limited = rows.arm_left, rows.arm_right, field.limited
    d, face, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
    for i in range(start, stop):
        here, there, forward = u[k, left + i], u[k, right + i], flow[face + i] >= 0.0
        before, behind = arm_left[face + i], arm_right[face + i]
        grad_left, grad_right = grad[d, k, left + i], grad[d, k, right + i]
        half_left, half_right = half_step[k, left + i], half_step[k, right + i]
        own_left, own_right = first_order[left + i], first_order[right + i]
        slope = grad_left * before if forward else -grad_right * behind
        along = (grad_left if forward else -grad_right) * (before + behind)
        jump = there - here if forward else here - there
        increment = limited_increment(
            slope, along, jump, half_left if forward else half_right, limited
        )
        own = own_left if forward else own_right
        out[face + i] = (here if forward else there) + (0.0 if own else increment)


@kernel
def convect(
    g: Geometry, rows: Rows, flux: Array, field: Reconstruction, out: Array
) -> None:
    """Add -sum over faces of flux (u_face - u_cell) [m3/s times u] to `out` (m, nc)."""
    u, face_value = field.values, np.empty(len(g.right))
    for r in range(len(rows.length)):
        face, left, right = rows.face[r], rows.left[r], rows.right[r]
        for k in range(u.shape[0]):
            upwind_values(rows, k, r, ZERO, rows.length[r], flux, field, face_value)
            for i in range(rows.left_from[r], rows.left_to[r]):
                out[k, left + i] -= flux[face + i] * (
                    face_value[face + i] - u[k, left + i]
                )
            for i in range(rows.right_from[r], rows.right_to[r]):
                out[k, right + i] += flux[face + i] * (
                    face_value[face + i] - u[k, right + i]
                )
    by_cell = Reconstruction(
        u.T,
        field.gradient.T,
        field.half_step.T,
        field.edge,
        field.first_order,
        field.limited,
    )
    convect_at_boundary(g, flux, by_cell, out.T)
