"""Viscous stress of a phase on rectangular grids, see stress.py of the step."""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import Side
from contbed.two_fluid.compiled import ZERO, Array, inner, kernel
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.fv.rows import Rows
from contbed.two_fluid.linear.cg import System
from contbed.two_fluid.rectangular.fields import weigh_neighbours
from contbed.two_fluid.stress import (
    Motion,
    Viscosities,
    add_boundary_stress,
    excess_viscosity,
    face_viscosity,
    stress_link,
    traction,
)


@inner
def _face_divergence(
    g: Geometry, rows: Rows, r: int, motion: Motion, out: Array
) -> None:
    """Divergence (ni,) [1/s] of the velocity on the faces of row r."""
    d, face, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
    u, grad, dim = motion.u, motion.gradient, len(g.axes)
    for i in range(ZERO, rows.length[r]):
        out[face + i] = (u[d, right + i] - u[d, left + i]) / g.distance[face + i]
    for other in range(1, dim):
        e = (d + other) % dim
        for i in range(ZERO, rows.length[r]):
            w = g.weight[face + i]
            out[face + i] += (
                w * grad[e, e, left + i] + (1.0 - w) * grad[e, e, right + i]
            )
    if g.radius[0] > 0.0:
        for i in range(ZERO, rows.length[r]):
            w, radius = g.weight[face + i], g.radius[left + i]
            if d == 0:
                radius += rows.arm_left[face + i]
            out[face + i] += (w * u[0, left + i] + (1.0 - w) * u[0, right + i]) / radius


@kernel
def add_stress(
    g: Geometry,
    rows: Rows,
    side: Side,
    viscosities: Viscosities,
    motion: Motion,
    system: System,
    work: Array,
) -> None:
    """Add the force of the stress and its links, and its work; arrays of `motion`
    and `system` by component.
    """
    ni, dim = len(g.right), len(g.axes)
    mu, bulk, u, grad, out, coef = (
        viscosities.mu,
        viscosities.bulk,
        motion.u,
        motion.gradient,
        system.rhs,
        system.coef,
    )
    to_left, to_right, divergence, m, lam, excess, force, stress = [
        np.empty(ni) for _ in range(8)
    ]
    weigh_neighbours(rows, viscosities.eps, to_left, to_right)
    for r in range(len(rows.length)):
        d, face, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
        _face_divergence(g, rows, r, motion, divergence)
        for i in range(ZERO, rows.length[r]):
            m[face + i] = face_viscosity(mu[left + i], mu[right + i])
        for i in range(ZERO, rows.length[r]):
            lam[face + i] = face_viscosity(bulk[left + i], bulk[right + i])
        for i in range(ZERO, rows.length[r]):
            f = face + i
            excess[f] = excess_viscosity(
                g.weight[f], mu[left + i], mu[right + i], to_left[f], to_right[f]
            )
        for k in range(dim):
            n = 1.0 if k == d else 0.0
            for i in range(ZERO, rows.length[r]):
                f, w = face + i, g.weight[face + i]
                across = (u[k, right + i] - u[k, left + i]) / g.distance[f]
                along = w * grad[k, d, left + i] + (1.0 - w) * grad[k, d, right + i]
                stress[f] = traction(
                    m[f],
                    lam[f],
                    divergence[f],
                    n,
                    across + (across if k == d else along),
                )
            for i in range(ZERO, rows.length[r]):
                f = face + i
                jump = u[k, right + i] - u[k, left + i]
                force[f] = g.area[f] * (stress[f] + excess[f] / g.distance[f] * jump)
            for i in range(rows.left_from[r], rows.left_to[r]):
                f = face + i
                coef[k, f] = g.area[f] * stress_link(
                    m[f], lam[f], excess[f], n, 1.0 / g.distance[f]
                )
            for i in range(rows.left_from[r], rows.left_to[r]):
                out[k, left + i] += force[face + i]
            for i in range(rows.right_from[r], rows.right_to[r]):
                out[k, right + i] -= force[face + i]
            for i in range(rows.left_from[r], rows.left_to[r]):
                f, jump = face + i, u[k, right + i] - u[k, left + i]
                work[left + i] += g.area[f] * stress[f] * (1.0 - g.weight[f]) * jump
            for i in range(rows.right_from[r], rows.right_to[r]):
                f, jump = face + i, u[k, right + i] - u[k, left + i]
                work[right + i] += g.area[f] * stress[f] * g.weight[f] * jump
    by_cell = Motion(u.T, grad.T, motion.edge, motion.slip)
    add_boundary_stress(
        g,
        side,
        viscosities,
        by_cell,
        System(coef.T, system.links.T, system.content.T, out.T),
        work,
    )
