"""What carries a bed: the integral of both vertical momentum equations over the vessel.

    pressure + particles + walls + inflow = weight + change of momentum

The pressure of the gas, and that of the particles, are those of the cells at floor and
roof, so that the weight is what lies between the middles of these cells; an outlet has
the pressure outside. Walls pull by the shear of both phases, the floor also by the
viscous stress along its normal. What is missing is the error of the discretization:
friction acts by a potential, which keeps a bed at rest. The force of a face, mean of
eps_s times jump of h, is the jump of the frictional pressure to second order between
cells that rub. Beside a cell without friction, at the surface or a bubble, it is less
(0.6 of it where eps_s is 0.55 and 0.1): 1.2 % of the weight of a bubbling bed in 16 by
64 cells between slip walls, 4 % of that of 8 rows at rest. By the jump of the pressure
itself, over eps_s of the opposite cells, the bubbling bed misses 0.06 % but that at
rest 5 %, as the upper half of its last row hangs: its upper face has no particles and
counts for nothing in the velocity of the row.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import OUTLET, boundary_velocity
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.properties import density_ratio
from contbed.two_fluid.simulation import Simulation

SHARES = ("pressure", "particles", "walls", "inflow", "change")


def momentum(bed: Simulation) -> float:
    """Upward momentum of both phases [kg m/s]; in a plane per metre of depth, on a
    line per square metre.
    """
    state, materials, halo = bed.state, bed.model.materials, bed.model.grid.halo
    s, rho_g, rho_s = (
        state.eps_s,
        materials.rho_gas * density_ratio(state.energy),
        materials.rho_solid,
    )
    gas, solid = (
        np.stack((rho_g * (1.0 - s), rho_s * s)) * bed.model.grid.geometry.volume
    )
    own = halo.cells
    return float(
        *halo.sum(
            float(gas[own] @ state.u_gas[own, -1] + solid[own] @ state.u_solid[own, -1])
        )
    )


def forces(bed: Simulation, before: float) -> Array:
    """Return the SHARES and the weight [N] in the last step.

    before : momentum [kg m/s] at the start of the step, per metre or square metre as in
        `momentum`
    """
    state, model = bed.state, bed.model
    g, first, edge, s, halo = (
        model.grid.geometry,
        model.grid.interior,
        model.edge,
        state.eps_s,
        model.grid.halo,
    )
    own, inside = halo.edges, halo.cells
    cells, area, n = (
        model.boundary_cells[own],
        g.area[first:][own],
        g.normal[first:, -1][own],
    )
    rho_g, rho_s = (
        model.materials.rho_gas * density_ratio(state.energy),
        model.materials.rho_solid,
    )
    outlet, rheology = edge.gas.kind[own] == OUTLET, state.properties.rheology
    pressure = np.where(outlet, edge.p[own], state.p[cells])
    particles = rho_s * rheology.pressure * state.theta + rheology.p_friction
    on_walls = np.where(outlet, 0.0, particles[cells])
    density = rho_g * (1.0 - s) + rho_s * s
    beyond = area * n * np.where(outlet, 0.0, g.arm_left[first:, -1][own])
    weight = -model.gravity[-1] * (
        density[inside] @ g.volume[inside] - density[cells] @ beyond
    )
    outwards = slice(model.grid.face_count - len(edge.p), None)
    solid = state.fluxes.moved[outwards][own]
    fluxes = (
        (state.fluxes.total[outwards][own] - solid)
        * np.broadcast_to(rho_g, s.shape)[cells],
        solid * rho_s,
    )
    inflow = 0.0
    sides, velocities, fractions = (
        (edge.gas, edge.solid),
        (state.u_gas, state.u_solid),
        (1.0 - s, s),
    )
    for side, u, eps, flux in zip(sides, velocities, fractions, fluxes, strict=True):
        given = np.empty_like(side.u)
        boundary_velocity(g, side, np.abs(side.slip), u, eps, given)
        inflow -= float(flux @ given[own, -1])
    change = (momentum(bed) - before) / state.dt
    walls = state.wall_force_gas + state.wall_force_solid
    on_ends = halo.sum(
        float(-area * n @ pressure), float(-area * n @ on_walls), inflow, float(weight)
    )
    return np.array([*on_ends[:2], walls, on_ends[2], change, on_ends[3]])


def shares(mean: Array) -> dict[str, float]:
    """Return the SHARES of averaged `forces`, and what is missing, over the weight."""
    *parts, weight = mean
    *carriers, change = parts
    named = {
        f"weight_{name}": float(value / weight)
        for name, value in zip(SHARES, parts, strict=True)
    }
    return named | {"weight_missing": float((weight + change - sum(carriers)) / weight)}
