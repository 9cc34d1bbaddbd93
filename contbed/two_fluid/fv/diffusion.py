"""Conduction between cells, by harmonic means; `g` is the `Geometry` of grid.py."""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.compiled import SMALLEST, Array, kernel
from contbed.two_fluid.fv.grid import Geometry


@kernel
def conduct(
    g: Geometry,
    k: Array,
    values: Array,
    given: Array,
    grad: Array,
    out: Array,
    coef: Array,
) -> None:
    """Add the conducted k grad values . n area [W] of all faces to `out` (nc, 1), set
    its links `coef` (nf, 1).

    k (nc,) is taken by harmonic means. `given` (nb,) are boundary values, not a number
    where nothing is conducted; `grad` (nc, 1, dim) corrects on skewed grids.
    """
    ni = len(g.right)
    for f in range(len(g.left)):
        left = g.left[f]
        coef[f, 0] = 0.0
        if f < ni:
            right = g.right[f]
            mean = 2.0 * k[left] * k[right] / (k[left] + k[right] + SMALLEST)
            coef[f, 0] = mean * g.area[f] / g.distance[f]
            rate = coef[f, 0] * (values[right] - values[left])
            if g.skewed:
                for d in range(len(g.axes)):
                    both = (
                        g.weight[f] * grad[left, 0, d]
                        + (1.0 - g.weight[f]) * grad[right, 0, d]
                    )
                    rate += mean * g.area[f] * g.non_orthogonal[f, d] * both
            out[left, 0] += rate
            out[right, 0] -= rate
        elif not np.isnan(given[f - ni]):
            coef[f, 0] = k[left] * g.area[f] / g.distance[f]
            out[left, 0] += coef[f, 0] * (given[f - ni] - values[left])
            if g.skewed:
                for d in range(len(g.axes)):
                    out[left, 0] += (
                        k[left] * g.area[f] * g.non_orthogonal[f, d] * grad[left, 0, d]
                    )


@kernel
def conducted_out(g: Geometry, coef: Array, x: Array, out: Array) -> None:
    """Set out (nc, m) = sum over faces of coef (nf, m) times x less x of the
    neighbour, or less 0 at boundaries.
    """
    ni = len(g.right)
    out[:] = 0.0
    for f in range(len(g.left)):
        left = g.left[f]
        for k in range(x.shape[1]):
            if f < ni:
                right = g.right[f]
                rate = coef[f, k] * (x[left, k] - x[right, k])
                out[right, k] -= rate
            else:
                rate = coef[f, k] * x[left, k]
            out[left, k] += rate
