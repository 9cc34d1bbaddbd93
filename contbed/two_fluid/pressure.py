"""Pressure projection: face velocities without the pressure, the pressure equation,
corrected fluxes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid import boundary
from contbed.two_fluid.cell_velocities import FaceVelocities
from contbed.two_fluid.compiled import Array, Flags
from contbed.two_fluid.face_velocities import (
    Cells,
    FaceFractions,
    FaceGradients,
    FacePredictor,
    Velocities,
    damp_buoyancy_waves,
)
from contbed.two_fluid.fv.gradient import gradient_rest_potential
from contbed.two_fluid.fv.reconstruction import Reconstruction
from contbed.two_fluid.model import Model
from contbed.two_fluid.operators import gradient, predictor_half_step
from contbed.two_fluid.properties import density_ratio
from contbed.two_fluid.state import Energy, Fluxes, ForceGradients, Properties, State
from contbed.two_fluid.timing import timed


class Projection(NamedTuple):
    """What the pressure equation gives.

    p (nc,) [Pa]; faces : velocities of both phases; fluxes : `moved` is still that of
    the last step
    cells, velocities, gradients : what acted in cells and on faces
    rate_eps_s (nc, 1) [1/s] : rate of change of eps_s without convection, for the next
    step
    """

    p: Array
    faces: FaceVelocities
    fluxes: Fluxes
    cells: Cells
    velocities: Velocities
    gradients: FaceGradients
    rate_eps_s: Array


@timed("pressure")
def project(
    state: State,
    eps_s: Array,
    rate_eps_s: Array,
    predicted: tuple[Array, Array, Array, Array],
    properties: Properties,
    energy: Energy | None,
    dt: float,
    model: Model,
) -> Projection:
    """Find forces, drag and pressure on faces.

    predicted : H (nc, dim) of gas and solids, and the gradients (nc, dim, dim) of both
        velocities before
    """
    g, kernels, edge, materials = (
        model.grid.geometry,
        model.kernels,
        model.edge,
        model.materials,
    )
    h_gas, h_solid, grad_gas, grad_solid = predicted
    kinetic = properties.rheology.pressure * state.theta
    forces, resting = state.memory.gradients, model.no_cells
    if g.skewed:
        forces, resting = force_gradients(state, kinetic, properties, forces, model)
        grad_gas = grad_gas + zero_slope_gradient(h_gas - state.u_gas, None, model)
        grad_solid = grad_solid + zero_slope_gradient(
            h_solid - state.u_solid, eps_s, model
        )
    rho_gas = materials.rho_gas * density_ratio(energy) * np.ones(len(eps_s))
    friction = properties.rheology.potential
    acting = properties.drag, kinetic, friction, state.p
    cells = Cells(
        rho_gas,
        eps_s,
        *acting,
        resting,
        model.open_faces,
        materials.rho_solid,
        model.gravity,
    )
    velocities = Velocities(h_gas, h_solid, state.u_gas, state.u_solid)
    gradients = FaceGradients(grad_gas, grad_solid, forces, state.memory.face_residual)
    nf = len(g.left)
    predictor = FacePredictor(*(np.empty(nf) for _ in FacePredictor._fields))
    kernels.predict_on_faces(edge, dt, cells, velocities, gradients, predictor)

    field = _half_step_fraction(state, eps_s, rate_eps_s, dt, model)
    fractions = FaceFractions(np.empty(nf), np.empty(nf))
    kernels.reconstruct_fractions(edge, field, predictor, fractions)
    if model.closed:
        damp_buoyancy_waves(g, dt, cells, fractions, predictor)

    coef, rhs = np.empty(nf), g.volume * (model.sources.solid + model.sources.gas)
    if energy is not None:
        rhs += g.volume * energy.expansion
    kernels.assemble_pressure(edge, fractions, predictor, coef, rhs)
    p = model.pressure_solver.solve(coef, rhs, state.p)
    faces = FaceVelocities(
        np.empty(nf), np.empty(nf), predictor.h_gas, predictor.h_solid, fractions.solid
    )
    fluxes = Fluxes(
        np.empty(nf),
        np.empty(nf),
        state.fluxes.moved,
        np.empty_like(p),
        np.empty_like(p),
    )
    kernels.correct_fluxes(edge, p, fractions, predictor, faces, fluxes)
    if model.closed:
        # with the convected rate of the faces, buoyancy waves of N dt of about 1 would
        # grow
        rate_eps_s = rate_eps_s - 2.0 / dt * field.half_step
    else:
        convected = np.empty_like(p)
        kernels.divergence(faces.solid * g.area, fractions.solid, eps_s, convected)
        rate_eps_s = -(convected / g.volume)[:, None]
    return Projection(p, faces, fluxes, cells, velocities, gradients, rate_eps_s)


def _half_step_fraction(
    state: State, eps_s: Array, rate: Array, dt: float, model: Model
) -> Reconstruction:
    """Solids fraction with its gradient and its change in half a step."""
    edge = model.edge
    column, nb = eps_s.reshape(-1, 1), len(model.boundary_cells)
    given = np.where(
        edge.solid.kind == boundary.GIVEN, edge.eps_s, eps_s[model.boundary_cells]
    ).reshape(nb, 1)
    grad = gradient(model, column, given)
    half_step = predictor_half_step(model, dt, column, grad, state.u_solid, rate)
    return Reconstruction(
        column, grad, half_step, given, model.no_cells, model.options.limited
    )


def zero_slope_gradient(u: Array, eps_s: Array | None, model: Model) -> Array:
    """Gradient (nc, dim, dim) of u (nc, dim) with the values of the cells at
    boundaries; of the solids with `eps_s`.
    """
    return gradient(model, u, u[model.boundary_cells], eps_s)


def force_gradients(
    state: State,
    kinetic: Array,
    properties: Properties,
    last: ForceGradients,
    model: Model,
) -> tuple[ForceGradients, Flags]:
    """Gradients of p [Pa], kinetic pressure and potential at rest [m2/s2], for skewed
    grids; cells at rest.

    The `last` gradients extend p and kinetic pressure to the walls. Drag acts on
    particles at rest as in the last step.
    """
    g, edge, cells, p = model.grid.geometry, model.edge, model.boundary_cells, state.p
    arm = g.arm_left[model.grid.interior :]
    values, slopes = (
        np.stack((p, kinetic), axis=1),
        np.stack((last.p, last.kinetic), axis=1),
    )
    given = values[cells] + np.einsum("bkd,bd->bk", slopes[cells], arm)
    outlet = edge.gas.kind == boundary.OUTLET
    given[outlet, 0] = edge.p[outlet]
    grad, rest = (
        gradient(model, values, given),
        np.empty((len(values), 1, arm.shape[1])),
    )
    resting = np.zeros(len(p), dtype=np.bool_)
    potential, rho_s = properties.rheology.potential, model.materials.rho_solid
    drag = properties.drag[:, None] / rho_s * (state.u_gas - state.u_solid)
    gradient_rest_potential(g, potential, p / rho_s, model.gravity, drag, rest, resting)
    model.grid.halo.exchange(rest, resting)
    parts = (
        np.ascontiguousarray(part) for part in (grad[:, 0], grad[:, 1], rest[:, 0])
    )
    return ForceGradients(*parts), resting
