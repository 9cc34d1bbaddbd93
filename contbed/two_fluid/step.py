"""One step of the two-fluid model, of first order in time; the equations are in
equations.py.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from contbed.compiled.interrupts import deferred_interrupt
from contbed.two_fluid import continuity, granular_temperature, momentum, pressure
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.continuity import Moved
from contbed.two_fluid.model import Model
from contbed.two_fluid.properties import evaluate_closures
from contbed.two_fluid.state import Memory, State

if TYPE_CHECKING:
    from contbed.two_fluid.state import Energy

# iterations in which the gradients of the initial forces converge, whose boundary
# values they extrapolate themselves (test_uniform_suspension_hangs_in_the_gas)
WALL_EXTRAPOLATION_ROUNDS = 60


@deferred_interrupt()
def step(state: State, dt: float, model: Model) -> State:
    """Advance by dt [s]: continuity, energy, closures, momentum, pressure, cell
    velocities, granular temperature.
    """
    moved = continuity.advance(state, dt, model)  # bounded, conservative
    energy, gas_flux = energy_step(state, moved, dt, model)  # nothing without [heat]
    properties = evaluate_closures(state, moved.eps_s, energy, model)  # drag, rheology
    gas, solid = momentum.predict(state, moved, gas_flux, properties, energy, dt, model)
    predicted = gas.h, solid.h, gas.gradient, solid.gradient
    faces = pressure.project(
        state, moved.eps_s, moved.rate_eps_s, predicted, properties, energy, dt, model
    )
    u = momentum.reconstruct(faces, dt, model)
    granular = granular_temperature.advance(
        state, moved, solid, faces.faces, u.solid, properties, dt, model
    )
    memory = Memory(
        (u.gas - state.u_gas) / dt - gas.convected,
        (u.solid - state.u_solid) / dt - solid.convected,
        faces.rate_eps_s,
        granular.rate,
        u.force_gas,
        u.force_solid,
        u.face_residual,
        faces.gradients.forces,
        granular.heating_rate,
    )
    model.grid.halo.exchange(
        memory.rate_gas, memory.rate_solid, memory.rate_eps_s, memory.rate_theta
    )
    return replace(
        state,
        eps_s=moved.eps_s,
        u_gas=u.gas,
        u_solid=u.solid,
        theta=granular.theta,
        p=faces.p,
        fluxes=faces.fluxes._replace(moved=moved.flux),
        memory=memory,
        properties=properties,
        energy=energy,
        wall_force_gas=gas.wall_force,
        wall_force_solid=solid.wall_force,
        counters=granular.counters,
    )


def energy_step(
    state: State, moved: Moved, dt: float, model: Model
) -> tuple[Energy | None, Array]:
    """Temperatures, and the flux (nf,) [m3/s] of the gas at its usual density."""
    if state.energy is None or model.heat is None:
        return None, moved.flux_gas
    from contbed.two_fluid.heat.equations import advance

    return advance(state, state.energy, moved, model.heat, dt, model)


@deferred_interrupt()
def initial_fluxes(state: State, dt: float, model: Model) -> State:
    """Fluxes and pressure that belong to the fields, as after a step of `dt` [s]
    without convection and forces.
    """
    properties, memory = (
        evaluate_closures(state, state.eps_s, state.energy, model),
        state.memory,
    )
    if model.grid.skewed:
        kinetic, forces = properties.rheology.pressure * state.theta, memory.gradients
        for _ in range(WALL_EXTRAPOLATION_ROUNDS):
            forces, _ = pressure.force_gradients(
                state, kinetic, properties, forces, model
            )
        state = replace(state, memory=memory._replace(gradients=forces))
    flat = np.zeros((*state.u_gas.shape, model.grid.dimension), order=model.grid.order)
    predicted = state.u_gas, state.u_solid, flat, flat
    found = pressure.project(
        state,
        state.eps_s,
        memory.rate_eps_s,
        predicted,
        properties,
        state.energy,
        dt,
        model,
    )
    memory = memory._replace(
        rate_eps_s=found.rate_eps_s,
        gradients=found.gradients.forces,
        force_gas=np.zeros_like(state.u_gas),
        force_solid=np.zeros_like(state.u_solid),
        face_residual=np.zeros_like(memory.face_residual),
    )
    return replace(
        state, p=found.p, fluxes=found.fluxes, memory=memory, properties=properties
    )
