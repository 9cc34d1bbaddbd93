"""Gradients of fields, and their change in half a step, by the kernels that suit the
grid.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.compiled import Array
from contbed.two_fluid.model import Model


def gradient(
    model: Model, values: Array, edge: Array, eps_s: Array | None = None
) -> Array:
    """Gradients (nc, m, dim) of `values` (nc, m) with boundary values `edge` (nb, m).

    Of a field of the particles with their fraction eps_s (nc,).
    """
    grid = model.grid
    out = np.empty((*values.shape, grid.dimension), order=grid.order)
    if eps_s is None:
        model.kernels.gradient(values, edge, out)
    else:
        model.kernels.gradient_solid(eps_s, values, edge, out)
    grid.halo.exchange(out)
    return out


def predictor_half_step(
    model: Model, dt: float, u: Array, grad: Array, carrier: Array, rate: Array
) -> Array:
    """Change (nc, m) of u in half a step, convected by `carrier` (nc, dim), with its
    `rate` without convection.
    """
    out = np.empty_like(u)
    model.kernels.predictor_half_step(dt, u, grad, carrier, rate, out)
    return out
