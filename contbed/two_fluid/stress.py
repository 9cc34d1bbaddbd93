"""Kernels of the viscous stress of a phase; `g` is the Geometry of grid.py, fields are (nc, dim)."""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import OUTLET, WALL
from contbed.two_fluid.compiled import kernel
from contbed.two_fluid.fv.gradient import heard


@kernel
def stress(g, side, slip, eps, mu, bulk, u, grad, edge, out, coef, work):
    """Adds the force of the full stress mu (grad u + grad u^T) + (bulk - 2/3 mu) div u I on each cell to `out` [N].

    `coef` (nf, m) gets the part of it that goes with the jump of each component across a face, for the implicit
    solution. At the face mu and bulk are harmonic means: where there are no particles no stress passes. By how much the
    linear mean of mu is larger only rubs, with the jump of the velocity: so the loose top of a bed rests on the bed. A
    wall takes the shear that `slip` leaves and the normal stress; an outlet takes none. `work` (nc,) gets the work [W]
    of the stress on the velocities in each cell, which the mean motion loses, but for what rubs.
    """
    ni, dim = len(g.right), len(g.axes)
    local = np.empty((dim, dim))
    for f in range(len(g.left)):
        left = g.left[f]
        if f < ni:
            right = g.right[f]
            m = 2.0 * mu[left] * mu[right] / (mu[left] + mu[right] + 1e-300)
            lam = 2.0 * bulk[left] * bulk[right] / (bulk[left] + bulk[right] + 1e-300)
            w, area, near = g.share[f], g.area[f], 1.0 / g.distance[f]
            rub = w * mu[left] + (1.0 - w) * mu[right] - m
            rub *= min(heard(eps[left], eps[right]), heard(eps[right], eps[left])) * near
            divergence = 0.0
            for k in range(dim):
                missing = u[right, k] - u[left, k]
                for d in range(dim):
                    local[k, d] = w * grad[left, k, d] + (1.0 - w) * grad[right, k, d]
                    missing -= local[k, d] * (g.arm_left[f, d] - g.arm_right[f, d])
                for d in range(dim):
                    local[k, d] += missing * near * g.normal[f, d]
                divergence += local[k, k]
            if g.radius[left] > 0.0:
                divergence += (w * u[left, 0] + (1.0 - w) * u[right, 0]) / (g.radius[left] + g.arm_left[f, 0])
            lost_left = lost_right = 0.0
            for k in range(dim):
                n, here, there = g.normal[f, k], u[left, k], u[right, k]
                traction = (lam - 2.0 / 3.0 * m) * divergence * n
                middle = w * here + (1.0 - w) * there
                for d in range(dim):
                    traction += m * (local[k, d] + local[d, k]) * g.normal[f, d]
                    middle += local[k, d] * g.skew[f, d]
                lost_left += area * traction * (middle - here)
                lost_right += area * traction * (there - middle)
                pull = area * (traction + rub * (there - here))
                out[left, k] += pull
                out[right, k] -= pull
                # twice what rubs: a loose cell that follows a stiff one feeds back through its explicit shear
                coef[f, k] = area * (near * (m + (m / 3.0 + lam) * n * n) + 2.0 * rub)
            work[left] += lost_left
            work[right] += lost_right
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
                pull = scale * (m * (1.0 - slip[b]) * along + (4.0 / 3.0 * m + lam) * away * n)
                out[left, k] -= pull
                work[left] += pull * ((1.0 - slip[b]) * along + away * n)
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
                work[left] += g.area[f] * traction * (edge[b, k] - u[left, k])
                coef[f, k] = scale * (m + (m / 3.0 + lam) * g.normal[f, k] ** 2)


@kernel
def hoop_stress(g, mu, bulk, u, grad, out, diagonal, work):
    """The stress around the axis, which pulls inwards: adds its force to `out` and its part in u_r to `diagonal`."""
    for c in range(u.shape[0]):
        r = g.radius[c]
        divergence = grad[c, 0, 0] + grad[c, 1, 1] + u[c, 0] / r
        ring = 2.0 * mu[c] * u[c, 0] / r + (bulk[c] - 2.0 / 3.0 * mu[c]) * divergence
        out[c, 0] -= g.volume[c] * ring / r
        work[c] += g.volume[c] * ring * u[c, 0] / r
        diagonal[c, 0] += g.volume[c] * (4.0 / 3.0 * mu[c] + bulk[c]) / r**2
