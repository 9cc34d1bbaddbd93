"""What carries a bed: the integral of both vertical momentum equations over the vessel.

    pressure + particles + walls + inflow = weight + change of momentum

The pressure of the gas, and that of the particles, are those of the cells at floor and roof, so that the weight is what
lies between the middles of these cells; an outlet has the pressure outside. Walls pull by the shear of both phases,
the floor also by the viscous stress along its normal. What is missing is the error of the discretization: friction acts
by a potential, which keeps a bed at rest but sums to the pressure on the floor only for fine cells.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import OUTLET
from contbed.two_fluid.fv import gradient as kc
from contbed.two_fluid.simulation import TwoFluid

SHARES = ("pressure", "particles", "walls", "inflow", "change")


def momentum(bed: TwoFluid) -> float:
    """Upward momentum of both phases [kg m/s]; in a plane per metre of depth, on a line per square metre."""
    s, rho_g, rho_s = bed.eps_s, bed.rho[0] * bed.dense, bed.rho[1]
    density = np.stack((rho_g * (1.0 - s), rho_s * s)) * bed.grid.geometry.volume
    return float(density[0] @ bed.u_gas[:, -1] + density[1] @ bed.u_solid[:, -1])


def forces(bed: TwoFluid, before: float) -> np.ndarray:
    """The SHARES and the weight [N] in the last step; `before` it the momentum was that."""
    g, first, edge, s = bed.grid.geometry, bed.grid.interior, bed.edge, bed.eps_s
    near, area, n = g.left[first:], g.area[first:], g.normal[first:, -1]
    rho_g, rho_s = bed.rho[0] * bed.dense, bed.rho[1]
    outlet = edge.gas.kind == OUTLET
    pressure = np.where(outlet, edge.p, bed.p[near])
    particles = rho_s * bed.rheology.pressure * bed.theta + bed.rheology.p_friction
    pushed = np.where(outlet, 0.0, particles[near])
    density = rho_g * (1.0 - s) + rho_s * s
    beyond = area * n * np.where(outlet, 0.0, g.arm_left[first:, -1])
    weight = -bed.gravity[-1] * (density @ g.volume - density[near] @ beyond)
    solid = bed.moved[first:]
    fluxes = (bed.flux_total[first:] - solid) * np.broadcast_to(rho_g, s.shape)[near], solid * rho_s
    inflow = 0.0
    for side, u, eps, flux in zip((edge.gas, edge.solid), (bed.u_gas, bed.u_solid), (1.0 - s, s), fluxes, strict=True):
        given = np.empty_like(side.u)
        kc.edge_velocity(g, side, np.abs(side.slip), u, eps, given)
        inflow -= float(flux @ given[:, -1])
    change = (momentum(bed) - before) / bed.dt
    return np.array([-area * n @ pressure, -area * n @ pushed, bed.pull.sum(), inflow, change, weight])


def shares(mean: np.ndarray) -> dict[str, float]:
    """The SHARES of averaged `forces`, and what is missing, over the weight."""
    *parts, weight = mean
    *carriers, change = parts
    named = {f"weight_{name}": float(value / weight) for name, value in zip(SHARES, parts, strict=True)}
    return named | {"weight_missing": float((weight + change - sum(carriers)) / weight)}
