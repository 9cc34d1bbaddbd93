"""Momentum of both phases: convection and stress before the pressure projection,
cell velocities after it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.compiled.threads import parallel
from contbed.two_fluid import boundary
from contbed.two_fluid.boundary import Particles, Side, boundary_velocity, wall_slip
from contbed.two_fluid.cell_velocities import (
    Gathered,
    add_reconstruction_remainder,
    gather_gas,
    gather_solid,
)
from contbed.two_fluid.compiled import Array, Flags
from contbed.two_fluid.continuity import Moved
from contbed.two_fluid.fv.gradient import NO_PARTICLES
from contbed.two_fluid.fv.reconstruction import Reconstruction
from contbed.two_fluid.implicit import solve_system
from contbed.two_fluid.linear.cg import empty_system
from contbed.two_fluid.model import Model
from contbed.two_fluid.operators import gradient, predictor_half_step
from contbed.two_fluid.pressure import Projection, zero_slope_gradient
from contbed.two_fluid.properties import density_ratio
from contbed.two_fluid.state import Energy, Properties, State, fastest_gas
from contbed.two_fluid.stress import Motion, Viscosities, add_hoop_stress
from contbed.two_fluid.timing import timed

# subcycles of the convection of the gas in a step; more would cost more than shorter
# steps
MAX_SUBCYCLES = 4
# share of a cell that the gas crosses in a subcycle [-] (test_a_wave_travels)
SUBCYCLE_COURANT = 0.9


class Phase(NamedTuple):
    """One phase before its momentum is advanced.

    name : of its velocity
    rho [kg/m3], rho_ratio : density, and the density of the cells over it
    viscosities : and the fraction; flux (nf,) [m3/s]; subcycles : of convection
    side, slip : conditions at the boundary, and the share of the tangential velocity
        that walls leave
    u, rate, force, source (nc, dim) : velocity, its rate without convection,
        accelerations of the last step and given
    first_order (nc,) : cells that give their own value to all faces
    """

    name: str
    rho: float
    rho_ratio: float | Array
    viscosities: Viscosities
    flux: Array
    subcycles: int
    side: Side
    slip: Array
    u: Array
    rate: Array
    force: Array
    source: Array
    first_order: Flags


class Predicted(NamedTuple):
    """One phase after convection and stress.

    h (nc, dim) [m/s] : H, the velocity after convection and stress, without pressure,
        drag and gravity
    gradient (nc, dim, dim) [1/s] : of the velocity at the start of the step
    convected (nc, dim) [m/s2] : rate of change by convection
    shear_production (nc,) [W] : production of granular energy by the stress
    slip (nb,) : share of the tangential velocity that walls leave
    wall_force [N] : of the walls along the last axis
    """

    h: Array
    gradient: Array
    convected: Array
    shear_production: Array
    slip: Array
    wall_force: float


class Velocity(NamedTuple):
    """Cell velocities (nc, dim) [m/s] of both phases, their accelerations by forces,
    and the memory of faces.
    """

    gas: Array
    solid: Array
    force_gas: Array
    force_solid: Array
    face_residual: Array


def convect_in_subcycles(
    one: Phase,
    field: Reconstruction,
    dt: float,
    volume: Array,
    out: Array,
    model: Model,
) -> None:
    """Set `out` (nc, dim) [m3/s times u] to the mean convection of the subcycles of a
    step.

    The velocity of each subcycle is reconstructed anew. `volume` (nc, 1) [m3] is that
    of the phase, times its relative density; `field` is the velocity at the start,
    without a half step.
    """
    part, out[:] = dt / one.subcycles, 0.0
    for n in range(one.subcycles):
        now, slopes = field.values, field.gradient
        if n > 0:
            # the last forces go along, so that a steady flow stays as it is
            now = now + part * (out / volume + n * (one.source + one.force))
            model.grid.halo.exchange(now)
            slopes = gradient(model, now, field.edge)
        half_step = predictor_half_step(model, part, now, slopes, now, one.rate)
        reconstructed = field._replace(values=now, gradient=slopes, half_step=half_step)
        model.kernels.convect(one.flux, reconstructed, out)
    if one.subcycles > 1:
        out /= one.subcycles


@timed("momentum")
def predict(
    state: State,
    moved: Moved,
    gas_flux: Array,
    properties: Properties,
    energy: Energy | None,
    dt: float,
    model: Model,
) -> tuple[Predicted, Predicted]:
    """Gas and solids after convection and stress, without pressure, drag and
    gravity.
    """
    materials, edge, r, eps_s = (
        model.materials,
        model.edge,
        properties.rheology,
        moved.eps_s,
    )
    mu_solid, slip = r.mu + properties.mu_friction, np.empty(len(model.boundary_cells))
    particles = Particles(
        materials.rho_solid, materials.eps_max, eps_s, state.theta, r.g0
    )
    wall_slip(
        model.grid.geometry,
        edge,
        particles,
        mu_solid,
        r.p_friction,
        state.u_solid,
        slip,
    )
    halo = model.grid.halo
    crossed = dt * fastest_gas(state, halo) / SUBCYCLE_COURANT
    gas = Phase(
        "u_gas",
        materials.rho_gas,
        density_ratio(energy),
        Viscosities(1.0 - eps_s, model.gas_viscosity, model.gas_bulk_viscosity),
        gas_flux,
        max(1, int(np.ceil(crossed * (1.0 - 1e-9)))),
        edge.gas,
        edge.gas.slip,
        state.u_gas,
        state.memory.rate_gas,
        state.memory.force_gas,
        model.sources.force_gas,
        model.no_cells,
    )
    solid = Phase(
        "u_solid",
        materials.rho_solid,
        1.0,
        Viscosities(eps_s, mu_solid, r.bulk),
        moved.flux,
        1,
        edge.solid,
        slip,
        state.u_solid,
        state.memory.rate_solid,
        state.memory.force_solid,
        model.sources.force_solid,
        moved.upwind_cells,
    )
    predicted_gas, predicted_solid = (
        _advance(gas, state, dt, model),
        _advance(solid, state, dt, model),
    )
    model.kernels.add_compaction_velocity(
        moved.compaction_velocity, materials.eps_max, eps_s, predicted_solid.h
    )
    halo.exchange(predicted_solid.h)
    return predicted_gas, predicted_solid


def _advance(one: Phase, state: State, dt: float, model: Model) -> Predicted:
    """Convection (MUSCL, sub-cycled) and implicit stress of one phase."""
    g, u, side, eps = model.grid.geometry, one.u, one.side, one.viscosities.eps
    given = np.empty_like(side.u)
    boundary_velocity(g, side, one.slip, u, eps, given)
    grad = gradient(model, u, given, None if one.name == "u_gas" else eps)
    system = empty_system(g, u.shape[1], model.grid.order)
    # a cell without the phase keeps its velocity
    volume = ((eps * one.rho_ratio + NO_PARTICLES) * g.volume)[:, None]
    field = Reconstruction(u, grad, u, given, one.first_order, model.options.limited)
    convect_in_subcycles(one, field, dt, volume, system.rhs, model)
    convected = system.rhs / volume
    system.content[:] = one.rho / dt * volume
    # with the last forces the change vanishes in a steady state, which the implicit
    # part then leaves alone
    given_forces = one.rho * volume * (one.source + one.force)
    system.rhs[:] = one.rho * system.rhs + given_forces
    work, motion = np.zeros(len(eps)), Motion(u, grad, given, one.slip)
    model.kernels.add_stress(side, one.viscosities, motion, system, work)
    if model.grid.axisymmetric:
        add_hoop_stress(g, one.viscosities, motion, system, work)
    change = solve_system(state, one.name, system, model)
    at_walls = side.u[:, -1] - (
        u[model.boundary_cells, -1] + change[model.boundary_cells, -1]
    )
    own, forces = (
        model.grid.halo.edges,
        system.coef[model.grid.interior :, -1] * at_walls,
    )
    (wall_force,) = model.grid.halo.sum(
        float(np.sum(forces[own], where=(side.kind == boundary.WALL)[own]))
    )
    # without what the last forces gave in the step
    h = u + change - dt * one.force
    return Predicted(h, grad, convected, work, one.slip, wall_force)


@timed("reconstruction")
def reconstruct(projection: Projection, dt: float, model: Model) -> Velocity:
    """Cell velocities by least squares from the normal velocities of faces, plus the
    remainder of H that these lose.
    """
    g, faces = model.grid.geometry, projection.faces
    cells, velocities = projection.cells, projection.velocities
    h_gas, h_solid, s = velocities.h_gas, velocities.h_solid, cells.eps_s
    grad_gas, grad_solid = projection.gradients.h_gas, projection.gradients.h_solid
    gathered = Gathered(*(np.empty_like(h_gas) for _ in Gathered._fields))
    model.kernels.gather(faces, s, grad_gas, grad_solid, gathered)
    model.grid.halo.exchange(*gathered)
    force_gas, force_solid, residual = (
        np.empty_like(h_gas),
        np.empty_like(h_solid),
        np.empty(len(g.left)),
    )

    def add_remainder() -> None:
        parallel(
            add_reconstruction_remainder,
            len(s),
            dt,
            cells,
            velocities,
            gathered,
            force_gas,
            force_solid,
        )

    if g.skewed:
        # second pass, exact for linear fields: corrected with the gradients of H and of
        # the first result
        add_remainder()
        change_gas = zero_slope_gradient(gathered.gas - h_gas, None, model)
        change_solid = zero_slope_gradient(gathered.solid - h_solid, s, model)
        gather_gas(g, faces, grad_gas + change_gas, grad_gas, True, gathered)
        gather_solid(g, faces, s, grad_solid + change_solid, grad_solid, True, gathered)
        model.grid.halo.exchange(*gathered)
        grad_gas = grad_gas + zero_slope_gradient(gathered.gas - h_gas, None, model)
    model.kernels.face_residual(model.edge, faces.gas, gathered.gas, grad_gas, residual)
    add_remainder()
    return Velocity(gathered.gas, gathered.solid, force_gas, force_solid, residual)
