"""Kernels of symmetric systems diagonal x - sum of coef times the neighbours = rhs, with m unknowns in each cell."""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.compiled import kernel


@kernel
def add_links(g, coef, diagonal):
    """Adds to `diagonal` (nc, m) what `coef` (nf, m) couples a cell with; boundary faces couple with given values."""
    ni = len(g.right)
    for f in range(coef.shape[0]):
        for k in range(coef.shape[1]):
            diagonal[g.left[f], k] += coef[f, k]
            if f < ni:
                diagonal[g.right[f], k] += coef[f, k]


@kernel
def product(g, coef, diagonal, x, out):
    """out = diagonal x - sum of coef times the neighbours; returns x . out."""
    ni = len(g.right)
    for c in range(x.shape[0]):
        for k in range(x.shape[1]):
            out[c, k] = diagonal[c, k] * x[c, k]
    for f in range(ni):
        left, right = g.left[f], g.right[f]
        for k in range(x.shape[1]):
            out[left, k] -= coef[f, k] * x[right, k]
            out[right, k] -= coef[f, k] * x[left, k]
    total = 0.0
    for c in range(x.shape[0]):
        for k in range(x.shape[1]):
            total += x[c, k] * out[c, k]
    return total


@kernel
def conjugate(g, coef, diagonal, rhs, x, tolerance, most):
    """Jacobi-preconditioned conjugate gradients from x = rhs/diagonal; returns the iterations, -1 if too many.

    `tolerance` is relative in the norm of the inverse diagonal.
    """
    size = rhs.shape
    r, z, p, q = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    first = 0.0
    for c in range(size[0]):
        for k in range(size[1]):
            x[c, k] = rhs[c, k] / diagonal[c, k]
            first += rhs[c, k] * x[c, k]
    if first == 0.0:
        return 0
    product(g, coef, diagonal, x, q)
    rho = 0.0
    for c in range(size[0]):
        for k in range(size[1]):
            r[c, k] = rhs[c, k] - q[c, k]
            z[c, k] = r[c, k] / diagonal[c, k]
            p[c, k] = z[c, k]
            rho += r[c, k] * z[c, k]
    for iteration in range(most):
        if rho <= tolerance**2 * first:
            return iteration
        alpha = rho / product(g, coef, diagonal, p, q)
        after = 0.0
        for c in range(size[0]):
            for k in range(size[1]):
                x[c, k] += alpha * p[c, k]
                r[c, k] -= alpha * q[c, k]
                z[c, k] = r[c, k] / diagonal[c, k]
                after += r[c, k] * z[c, k]
        beta = after / rho
        rho = after
        for c in range(size[0]):
            for k in range(size[1]):
                p[c, k] = z[c, k] + beta * p[c, k]
    return -1 if rho > tolerance**2 * first else most
