"""Gradients and convection of fields on any grid, by the kernels that suit it."""

from __future__ import annotations

import numpy as np

from contbed.compiled.threads import parallel
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.fv import gradient as faces
from contbed.two_fluid.fv import reconstruction
from contbed.two_fluid.fv.grid import Grid, over_rows
from contbed.two_fluid.fv.reconstruction import Reconstruction
from contbed.two_fluid.rectangular import fields


def gradient(grid: Grid, values: Array, edge: Array, eps_s: Array | None = None) -> Array:
    """Gradients (nc, m, dim) of `values` (nc, m) with boundary values `edge` (nb, m).

    Of a field of the particles with their fraction eps_s (nc,).
    """
    out = np.empty((*values.shape, grid.dimension), order=grid.order)
    if grid.rows is None:
        if eps_s is None:
            faces.gradient(grid.geometry, values, edge, out)
        else:
            faces.gradient_solid(grid.geometry, eps_s, values, edge, out)
        grid.halo.exchange(out)
    elif eps_s is None:
        over_rows(grid, fields.gradient, values.T, edge, out.T)
    else:
        over_rows(grid, fields.gradient_solid, eps_s, values.T, edge, out.T)
    return out


def predictor_half_step(grid: Grid, dt: float, u: Array, grad: Array, carrier: Array, rate: Array) -> Array:
    """Change (nc, m) of u in half a step, convected by `carrier` (nc, dim), with its `rate` without convection."""
    out = np.empty_like(u)
    if grid.rows is None:
        reconstruction.predictor_half_step(dt, u, grad, carrier, rate, out)
    else:
        parallel(fields.predictor_half_step, len(u), dt, u.T, grad.T, carrier.T, rate.T, out.T)
    return out


def convect(grid: Grid, flux: Array, field: Reconstruction, out: Array) -> None:
    """Add -sum over faces of flux (u_face - u_cell) [m3/s times u] to `out` (nc, m)."""
    if grid.rows is None:
        reconstruction.convect(grid.geometry, flux, field, out)
    else:
        over_rows(grid, fields.convect, flux, transposed(field), out.T)


def transposed(field: Reconstruction) -> Reconstruction:
    """Return the field by component, for kernels over rows."""
    return field._replace(values=field.values.T, gradient=field.gradient.T, half_step=field.half_step.T)
