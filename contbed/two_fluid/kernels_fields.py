"""Kernels on cell fields: gradients, values at boundaries, convection, stress, symmetric systems.

Fields are (nc, m) with m components; `g` is the Geometry of grid.py. Face by face, what leaves the left cell enters the
right one.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from contbed.two_fluid.boundary import GIVEN, OUTLET, WALL


@njit(cache=True)
def gradient(g, values, edge, out):
    """Least-squares gradients (nc, m, dim) of `values` with boundary values `edge` (nb, m)."""
    ni, dim = len(g.right), len(g.axes)
    out[:] = 0.0
    for f in range(len(g.left)):
        left = g.left[f]
        for k in range(values.shape[1]):
            if f < ni:
                right = g.right[f]
                jump = values[right, k] - values[left, k]
                for d in range(dim):
                    out[right, k, d] += g.slope_right[f, d] * jump
            else:
                jump = edge[f - ni, k] - values[left, k]
            for d in range(dim):
                out[left, k, d] += g.slope_left[f, d] * jump


@njit(cache=True)
def edge_velocity(g, side, slip, u, eps, out):
    """Velocity of a phase at the boundary (nb, dim): what walls leave of the cell's, what inlets give."""
    ni, dim = len(g.right), len(g.axes)
    for b in range(len(side.kind)):
        f = ni + b
        c = g.left[f]
        if side.kind[b] == WALL:
            away = 0.0
            for k in range(dim):
                away += (u[c, k] - side.u[b, k]) * g.normal[f, k]
            for k in range(dim):
                along = u[c, k] - side.u[b, k] - away * g.normal[f, k]
                out[b, k] = side.u[b, k] + slip[b] * along
        elif side.kind[b] == GIVEN:
            for k in range(dim):
                out[b, k] = side.flux[b] / eps[c] * g.normal[f, k] if side.pores[b] > 0 else side.u[b, k]
        else:
            for k in range(dim):
                out[b, k] = u[c, k]


@njit(cache=True)
def increment(slope, along, jump, ahead, limited):
    """Value at a face minus the value of the upwind cell: second order, limited to monotonized central differences.

    `slope` and `along` are the gradient times the way to the face and to the other cell, `jump` the difference to the
    other cell, `ahead` the change of the cell's value in half a step.
    """
    if not limited:
        return slope + ahead
    behind = 2.0 * along - jump
    if behind * jump <= 0.0:
        return 0.0
    size = abs(along)
    part = min(1.0, 2.0 * abs(behind) / size, 2.0 * abs(jump) / size) * (slope + ahead)
    aside = abs(slope - 0.5 * along)  # the middle of the face may lie off the line between the centres
    return min(max(part, min(0.0, jump) - aside), max(0.0, jump) + aside)


@njit(cache=True)
def advance_rate(u, grad, carrier, out):
    """carrier . grad u (nc, m)."""
    for c in range(u.shape[0]):
        for k in range(u.shape[1]):
            total = 0.0
            for d in range(carrier.shape[1]):
                total += carrier[c, d] * grad[c, k, d]
            out[c, k] = total


@njit(cache=True)
def convect(g, flux, u, grad, ahead, edge, limited, low, out):
    """Adds -sum over faces of flux (u_face - u_cell) [m3/s times u] to `out`; `flux` (nf,) is a volume flux. Cells
    marked in `low` give their own value to all their faces.
    """
    ni, dim = len(g.right), len(g.axes)
    for f in range(len(g.left)):
        rate = flux[f]
        left = g.left[f]
        inner = f < ni
        right = g.right[f] if inner else left
        forward = rate >= 0.0
        c = left if forward else right
        for k in range(u.shape[1]):
            if inner:
                slope = along = 0.0
                for d in range(dim):
                    if forward:
                        slope += grad[c, k, d] * g.arm_left[f, d]
                        along += grad[c, k, d] * (g.arm_left[f, d] - g.arm_right[f, d])
                    else:
                        slope += grad[c, k, d] * g.arm_right[f, d]
                        along += grad[c, k, d] * (g.arm_right[f, d] - g.arm_left[f, d])
                jump = (u[right, k] - u[left, k]) if forward else (u[left, k] - u[right, k])
                value = u[c, k]
                if not low[c]:
                    value += increment(slope, along, jump, ahead[c, k], limited)
                out[right, k] += rate * (value - u[right, k])
            elif forward:
                slope = 0.0
                for d in range(dim):
                    slope += grad[c, k, d] * g.arm_left[f, d]
                jump = edge[f - ni, k] - u[c, k]
                part = slope + ahead[c, k] if not low[c] else 0.0
                value = u[c, k] + (min(max(part, min(0.0, jump)), max(0.0, jump)) if limited else part)
            else:
                value = edge[f - ni, k]
            out[left, k] -= rate * (value - u[left, k])


@njit(cache=True)
def stress(g, side, slip, mu, bulk, u, grad, edge, out, coef):
    """Adds the force of the full stress mu (grad u + grad u^T) + (bulk - 2/3 mu) div u I on each cell to `out` [N].

    `coef` (nf, m) gets the part of it that goes with the jump of each component across a face, for the implicit
    solution. At the face mu and bulk are harmonic means: where there are no particles no stress passes. A wall takes
    the shear that `slip` leaves and the normal stress; an outlet takes none.
    """
    ni, dim = len(g.right), len(g.axes)
    local = np.empty((dim, dim))
    for f in range(len(g.left)):
        left = g.left[f]
        if f < ni:
            right = g.right[f]
            m = 2.0 * mu[left] * mu[right] / (mu[left] + mu[right] + 1e-300)
            lam = 2.0 * bulk[left] * bulk[right] / (bulk[left] + bulk[right] + 1e-300)
            w = g.share[f]
            divergence = 0.0
            for k in range(dim):
                missing = u[right, k] - u[left, k]
                for d in range(dim):
                    local[k, d] = w * grad[left, k, d] + (1.0 - w) * grad[right, k, d]
                    missing -= local[k, d] * (g.arm_left[f, d] - g.arm_right[f, d])
                for d in range(dim):
                    local[k, d] += missing * g.normal[f, d] / g.distance[f]
                divergence += local[k, k]
            if g.radius[left] > 0.0:
                divergence += (w * u[left, 0] + (1.0 - w) * u[right, 0]) / (g.radius[left] + g.arm_left[f, 0])
            for k in range(dim):
                traction = (lam - 2.0 / 3.0 * m) * divergence * g.normal[f, k]
                for d in range(dim):
                    traction += m * (local[k, d] + local[d, k]) * g.normal[f, d]
                out[left, k] += g.area[f] * traction
                out[right, k] -= g.area[f] * traction
                coef[f, k] = g.area[f] / g.distance[f] * (m + (m / 3.0 + lam) * g.normal[f, k] ** 2)
            continue
        b = f - ni
        m, lam = mu[left], bulk[left]
        scale = g.area[f] / g.distance[f]
        if side.kind[b] == OUTLET:
            for k in range(dim):
                coef[f, k] = 0.0
        elif side.kind[b] == WALL:
            away = 0.0
            for k in range(dim):
                away += (u[left, k] - side.u[b, k]) * g.normal[f, k]
            for k in range(dim):
                n = g.normal[f, k]
                along = u[left, k] - side.u[b, k] - away * n
                out[left, k] -= scale * (m * (1.0 - slip[b]) * along + (4.0 / 3.0 * m + lam) * away * n)
                coef[f, k] = scale * (m * (1.0 - slip[b]) * (1.0 - n * n) + (4.0 / 3.0 * m + lam) * n * n)
        else:
            divergence = 0.0
            for k in range(dim):
                missing = edge[b, k] - u[left, k]
                for d in range(dim):
                    missing -= grad[left, k, d] * g.arm_left[f, d]
                for d in range(dim):
                    local[k, d] = grad[left, k, d] + missing * g.normal[f, d] / g.distance[f]
                divergence += local[k, k]
            if g.radius[left] > 0.0:
                divergence += edge[b, 0] / (g.radius[left] + g.arm_left[f, 0])
            for k in range(dim):
                traction = (lam - 2.0 / 3.0 * m) * divergence * g.normal[f, k]
                for d in range(dim):
                    traction += m * (local[k, d] + local[d, k]) * g.normal[f, d]
                out[left, k] += g.area[f] * traction
                coef[f, k] = scale * (m + (m / 3.0 + lam) * g.normal[f, k] ** 2)


@njit(cache=True)
def hoop_stress(g, mu, bulk, u, grad, out, diagonal):
    """The stress around the axis, which pulls inwards: adds its force to `out` and its part in u_r to `diagonal`."""
    for c in range(u.shape[0]):
        r = g.radius[c]
        divergence = grad[c, 0, 0] + grad[c, 1, 1] + u[c, 0] / r
        ring = 2.0 * mu[c] * u[c, 0] / r + (bulk[c] - 2.0 / 3.0 * mu[c]) * divergence
        out[c, 0] -= g.volume[c] * ring / r
        diagonal[c, 0] += g.volume[c] * (4.0 / 3.0 * mu[c] + bulk[c]) / r**2


@njit(cache=True)
def add_links(g, coef, diagonal):
    """Adds to `diagonal` (nc, m) what `coef` (nf, m) couples a cell with; boundary faces couple with given values."""
    ni = len(g.right)
    for f in range(coef.shape[0]):
        for k in range(coef.shape[1]):
            diagonal[g.left[f], k] += coef[f, k]
            if f < ni:
                diagonal[g.right[f], k] += coef[f, k]


@njit(cache=True)
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


@njit(cache=True)
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
