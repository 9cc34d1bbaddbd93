"""Kernel of conduction."""

from __future__ import annotations

from contbed.two_fluid.compiled import Array, kernel
from contbed.two_fluid.fv.grid import Geometry


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
