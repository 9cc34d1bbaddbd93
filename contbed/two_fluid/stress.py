"""Viscous stress of a phase, mu (grad u + grad u^T) + (bulk - 2/3 mu) div u I; `g`
is the Geometry of grid.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.boundary import OUTLET, WALL, Side, speed_through
from contbed.two_fluid.compiled import SMALLEST, Array, inner, kernel
from contbed.two_fluid.fv.gradient import neighbour_weight
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.linear.cg import System

# implicit over explicit coefficient [-] of the excess of viscosity: a cell of low
# viscosity follows a viscous neighbour, and its shear acts back on that one in the next
# step (test_excess_of_viscosity_is_over_relaxed)
EXCESS_IMPLICIT_FACTOR = 2.0


class Viscosities(NamedTuple):
    """Fraction of a phase, its viscosity and bulk viscosity [Pa s], each (nc,)."""

    eps: Array
    mu: Array
    bulk: Array


class Motion(NamedTuple):
    """Motion of a phase.

    Velocity (nc, dim), its gradient (nc, dim, dim), its boundary values (nb, dim), and
    the share (nb,) of the tangential velocity that walls leave.
    """

    u: Array
    gradient: Array
    edge: Array
    slip: Array

    @property
    def T(self) -> Motion:
        """The motion by component, for kernels over rows."""
        return self._replace(u=self.u.T, gradient=self.gradient.T)


@inner
def face_viscosity(left: float, right: float) -> float:
    """Viscosity of a face: the harmonic mean, so that where there are no particles
    no stress passes.
    """
    return 2.0 * left * right / (left + right + SMALLEST)


@inner
def excess_viscosity(
    w: float, left: float, right: float, to_left: float, to_right: float
) -> float:
    """Excess of the linear mean of the viscosities of two cells over the harmonic
    one, by `neighbour_weight`.
    """
    excess = w * left + (1.0 - w) * right - face_viscosity(left, right)
    return float(excess * min(to_left, to_right))


@inner
def traction(m: float, lam: float, divergence: float, n: float, shear: float) -> float:
    """Component of the stress on a face [Pa]; n of its normal, `shear` of (grad
    u + grad u^T) n.
    """
    return (lam - 2.0 / 3.0 * m) * divergence * n + m * shear


@inner
def stress_link(
    m: float, lam: float, excess: float, n: float, inverse_distance: float
) -> float:
    """Link [Pa s/m] of one velocity component across a face, n of its normal."""
    return inverse_distance * (
        m + (m / 3.0 + lam) * n * n + EXCESS_IMPLICIT_FACTOR * excess
    )


@kernel
def add_stress(
    g: Geometry,
    side: Side,
    viscosities: Viscosities,
    motion: Motion,
    system: System,
    work: Array,
) -> None:
    """Add the force [N] of the stress on each cell to the right-hand side, and its
    links to the coefficients.

    The links are the part that goes with the jump of each component across a face. At
    the face mu and bulk are harmonic means. The excess of the linear mean of mu over
    the harmonic one acts on the jump of the velocity alone: so the bed carries its
    loose top layer. A wall takes the shear that `slip` leaves and the normal stress; an
    outlet takes none. `work` (nc,) gets the work [W] of the stress on the velocities in
    each cell (shear production), without that of the excess.
    """
    dim = len(g.axes)
    mu, bulk, eps = viscosities.mu, viscosities.bulk, viscosities.eps
    u, grad, out, coef = motion.u, motion.gradient, system.rhs, system.coef
    local = np.empty((dim, dim))
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        m, lam = (
            face_viscosity(mu[left], mu[right]),
            face_viscosity(bulk[left], bulk[right]),
        )
        w, area, inverse_distance = g.weight[f], g.area[f], 1.0 / g.distance[f]
        to_left, to_right = (
            neighbour_weight(eps[right], eps[left]),
            neighbour_weight(eps[left], eps[right]),
        )
        excess = excess_viscosity(w, mu[left], mu[right], to_left, to_right)
        divergence = 0.0
        for k in range(dim):
            missing = u[right, k] - u[left, k]
            for d in range(dim):
                local[k, d] = w * grad[left, k, d] + (1.0 - w) * grad[right, k, d]
                missing -= local[k, d] * (g.arm_left[f, d] - g.arm_right[f, d])
            for d in range(dim):
                local[k, d] += missing * inverse_distance * g.normal[f, d]
            divergence += local[k, k]
        if g.radius[left] > 0.0:
            divergence += (w * u[left, 0] + (1.0 - w) * u[right, 0]) / (
                g.radius[left] + g.arm_left[f, 0]
            )
        lost_left = lost_right = 0.0
        for k in range(dim):
            n, here, there = g.normal[f, k], u[left, k], u[right, k]
            shear, middle = 0.0, w * here + (1.0 - w) * there
            for d in range(dim):
                shear += (local[k, d] + local[d, k]) * g.normal[f, d]
                middle += local[k, d] * g.skew[f, d]
            stress = traction(m, lam, divergence, n, shear)
            lost_left += area * stress * (middle - here)
            lost_right += area * stress * (there - middle)
            force = area * (stress + excess * inverse_distance * (there - here))
            out[left, k] += force
            out[right, k] -= force
            coef[f, k] = area * stress_link(m, lam, excess, n, inverse_distance)
        work[left] += lost_left
        work[right] += lost_right
    add_boundary_stress(g, side, viscosities, motion, system, work)


@inner
def add_boundary_stress(
    g: Geometry,
    side: Side,
    viscosities: Viscosities,
    motion: Motion,
    system: System,
    work: Array,
) -> None:
    """Add the stress on boundary faces, see `add_stress`."""
    ni, dim = len(g.right), len(g.axes)
    u, grad, edge, slip = motion.u, motion.gradient, motion.edge, motion.slip
    out, coef = system.rhs, system.coef
    local = np.empty((dim, dim))
    for f in range(g.edge_from, g.edge_to):
        b, left = f - ni, g.left[f]
        m, lam = viscosities.mu[left], viscosities.bulk[left]
        scale = g.area[f] / g.distance[f]
        if side.kind[b] == OUTLET:
            for k in range(dim):
                coef[f, k] = 0.0
        elif side.kind[b] == WALL:
            away = speed_through(g, side, b, u)
            for k in range(dim):
                n = g.normal[f, k]
                along = u[left, k] - side.u[b, k] - away * n
                force = scale * (
                    m * (1.0 - slip[b]) * along + (4.0 / 3.0 * m + lam) * away * n
                )
                out[left, k] -= force
                work[left] += force * ((1.0 - slip[b]) * along + away * n)
                coef[f, k] = scale * (
                    m * (1.0 - slip[b]) * (1.0 - n * n) + (4.0 / 3.0 * m + lam) * n * n
                )
        else:
            divergence = 0.0
            for k in range(dim):
                missing = edge[b, k] - u[left, k]
                for d in range(dim):
                    missing -= grad[left, k, d] * g.arm_left[f, d]
                for d in range(dim):
                    local[k, d] = (
                        grad[left, k, d] + missing * g.normal[f, d] / g.distance[f]
                    )
                divergence += local[k, k]
            if g.radius[left] > 0.0:
                divergence += edge[b, 0] / (g.radius[left] + g.arm_left[f, 0])
            for k in range(dim):
                shear = 0.0
                for d in range(dim):
                    shear += (local[k, d] + local[d, k]) * g.normal[f, d]
                stress = traction(m, lam, divergence, g.normal[f, k], shear)
                out[left, k] += g.area[f] * stress
                work[left] += g.area[f] * stress * (edge[b, k] - u[left, k])
                coef[f, k] = g.area[f] * stress_link(
                    m, lam, 0.0, g.normal[f, k], 1.0 / g.distance[f]
                )


@kernel
def add_hoop_stress(
    g: Geometry, viscosities: Viscosities, motion: Motion, system: System, work: Array
) -> None:
    """Add the force of the stress around the axis, which pulls inwards, and its
    links to the given u_r = 0 there.
    """
    mu, bulk, u, grad = viscosities.mu, viscosities.bulk, motion.u, motion.gradient
    out, diagonal = system.rhs, system.links
    for c in range(u.shape[0]):
        r = g.radius[c]
        divergence = grad[c, 0, 0] + grad[c, 1, 1] + u[c, 0] / r
        ring = 2.0 * mu[c] * u[c, 0] / r + (bulk[c] - 2.0 / 3.0 * mu[c]) * divergence
        out[c, 0] -= g.volume[c] * ring / r
        work[c] += g.volume[c] * ring * u[c, 0] / r
        diagonal[c, 0] += g.volume[c] * (4.0 / 3.0 * mu[c] + bulk[c]) / r**2
