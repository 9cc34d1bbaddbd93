"""Kernels of heat that moves with a phase or is conducted: values on faces, and what they change in cells."""

from __future__ import annotations

from contbed.two_fluid.compiled import kernel
from contbed.two_fluid.fv.gradient import on_face


@kernel
def carried(g, flux, values, grad, ahead, given, low, out):
    """Values (nf,) that `flux` (nf,) carries, limited to second order; `given` (nb,) is what enters. Cells marked in
    `low` give their own value, as do all at boundaries.
    """
    ni = len(g.right)
    for f in range(len(flux)):
        forward = flux[f] >= 0.0
        if f >= ni:
            out[f] = values[g.left[f]] if forward else given[f - ni]
            continue
        c = g.left[f] if forward else g.right[f]
        out[f] = values[c] if low[c] else on_face(g, f, forward, values, grad, ahead, True)


@kernel
def conducted(g, coef, x, out):
    """out (nc, m) = sum over faces of coef (nf, m) times x less x of the neighbour, or less 0 at boundaries."""
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
