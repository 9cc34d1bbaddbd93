"""The conjugate gradients of cg.py on a grid that ranks share: the same iterations, so the same result to rounding.

All components go on together, so that an iteration costs one exchange of ghost cells and two sums over the ranks,
whatever the number of components. A component that has converged stays as it is.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.compiled import Array, Flags, Indices, kernel
from contbed.two_fluid.fv.grid import Geometry, Grid
from contbed.two_fluid.linear.cg import System


@kernel
def _add_links(g: Geometry, system: System) -> None:
    """Add the links of faces to those of their cells."""
    coef, links, ni = system.coef, system.links, len(g.right)
    for f in range(len(g.left)):
        for k in range(coef.shape[1]):
            links[g.left[f], k] += coef[f, k]
            if f < ni:
                links[g.right[f], k] += coef[f, k]


@kernel
def _solved_cells(g: Geometry, stiff: Flags, solved: Flags) -> None:
    """Mark stiff cells and their neighbours."""
    for c in range(len(stiff)):
        solved[c] = stiff[c]
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        if stiff[left]:
            solved[right] = True
        if stiff[right]:
            solved[left] = True


@kernel
def _diagonal(g: Geometry, system: System, solved: Flags, out: Array) -> None:
    """Set the diagonal (nc, m) of the solved cells; a link to another cell is not solved for."""
    coef = system.coef
    for c in range(len(out)):
        for k in range(out.shape[1]):
            out[c, k] = system.content[c, k] + system.links[c, k]
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        for k in range(out.shape[1]):
            if solved[left] and not solved[right]:
                out[left, k] -= coef[f, k]
            elif solved[right] and not solved[left]:
                out[right, k] -= coef[f, k]


@kernel
def _product(g: Geometry, faces: Indices, coef: Array, scale: Array, p: Array, q: Array) -> None:
    """Set q (nc, m) to the matrix with a diagonal of ones times p (nc, m)."""
    q[:] = p
    for f in faces:
        left, right = g.left[f], g.right[f]
        if left != right:
            for k in range(p.shape[1]):
                link = coef[f, k] * scale[left, k] * scale[right, k]
                q[left, k] -= link * p[right, k]
                q[right, k] -= link * p[left, k]


def solve_on_ranks(grid: Grid, system: System, explicit: float, tolerance: float, most: int, x: Array) -> int:
    """Solve for `x` (nc, m), ghost cells included; return the number of iterations, -1 if too many.

    explicit : links of a cell over its content above which it is stiff
    tolerance : of the residual, relative in the norm of the inverse diagonal
    """
    g, halo, own = grid.geometry, grid.halo, grid.halo.cells
    coef, links, content, rhs = system.coef, system.links, system.content, system.rhs
    _add_links(g, system)
    x[:] = rhs / content
    stiff: Flags = np.asarray((links > explicit * content).any(axis=1))
    if not halo.any(bool(stiff[own].any())):
        halo.exchange(x)
        return 0
    halo.exchange(stiff)
    solved, diagonal = np.empty_like(stiff), np.empty(x.shape)
    _solved_cells(g, stiff, solved)
    halo.exchange(solved)
    _diagonal(g, system, solved, diagonal)
    scale = np.where(solved[:, None], 1.0 / np.sqrt(diagonal), 0.0)
    halo.exchange(scale)
    faces = np.flatnonzero(solved[g.left[: grid.interior]] & solved[g.right])

    def dot(one: Array, other: Array) -> Array:
        return np.array(halo.sum(*np.einsum("ck,ck->k", one[own], other[own])))

    target = np.where(solved[:, None], scale * rhs, 0.0)
    halo.exchange(target)
    y, q = target.copy(), np.empty(x.shape)
    _product(g, faces, coef, scale, y, q)
    r = target - q
    first, rho = dot(target, target), dot(r, r)
    p = r.copy()
    iterations = 0
    while (going := rho > tolerance**2 * first).any():
        if iterations == most:
            return -1
        iterations += 1
        halo.exchange(p)
        _product(g, faces, coef, scale, p, q)
        curvature = dot(p, q)
        alpha = np.where(going, rho / np.where(going, curvature, 1.0), 0.0)
        y += alpha * p
        r -= alpha * q
        before, rho = rho, np.where(going, dot(r, r), rho)
        p = np.where(going, r + rho / np.where(going, before, 1.0) * p, p)
    x[solved] = (scale * y)[solved]
    halo.exchange(x)
    return iterations
