"""Velocities, fractions and fluxes on the faces of rectangular grids, see
face_velocities.py and pressure.py.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import Edge
from contbed.two_fluid.cell_velocities import FaceVelocities
from contbed.two_fluid.compiled import ZERO, Array, kernel
from contbed.two_fluid.face_velocities import (
    Cells,
    FaceFractions,
    FaceGradients,
    FacePredictor,
    Velocities,
    carried_fraction,
    drag_numbers,
    eliminate_drag,
    kept_residual,
    mobilities,
    of_both,
    particle_force,
    predict_on_boundary,
    reconstruct_boundary_fractions,
    set_on_face,
)
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.fv.reconstruction import Reconstruction
from contbed.two_fluid.fv.rows import Rows
from contbed.two_fluid.pressure_equation import (
    assemble_boundary_pressure,
    correct_boundary_fluxes,
    flux_and_link,
)
from contbed.two_fluid.rectangular.fields import upwind_values
from contbed.two_fluid.state import Fluxes


@kernel
def predict_on_faces(
    g: Geometry,
    rows: Rows,
    edge: Edge,
    dt: float,
    cells: Cells,
    velocities: Velocities,
    gradients: FaceGradients,
    out: FacePredictor,
) -> None:
    """Set the face velocities `out` without the pressure gradient."""
    s, drag, kinetic, friction, p = (
        cells.eps_s,
        cells.drag,
        cells.kinetic,
        cells.friction,
        cells.p,
    )
    rho_gas, rho_s, residual = cells.rho_gas, cells.rho_solid, gradients.residual
    for r in range(len(rows.length)):
        d, face, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
        h_g, h_s, weight = (
            velocities.h_gas.T[d],
            velocities.h_solid.T[d],
            cells.gravity[d],
        )
        for i in range(rows.left_from[r], rows.left_to[r]):
            f, a, b = face + i, left + i, right + i
            w, distance, s_a, s_b = g.weight[f], g.distance[f], s[a], s[b]
            hg, hs = w * h_g[a] + (1.0 - w) * h_g[b], w * h_s[a] + (1.0 - w) * h_s[b]
            rho_g = rho_gas[a] + (1.0 - w) * (rho_gas[b] - rho_gas[a])
            steep, opposite_mean = (
                (kinetic[b] - kinetic[a]) / distance,
                (1.0 - w) * s_a + w * s_b,
            )
            force = particle_force(
                weight, steep, opposite_mean, (friction[b] - friction[a]) / distance
            )
            upwind = s_a if hs + dt * force >= 0.0 else s_b
            mean, k_face = w * s_a + (1.0 - w) * s_b, w * drag[a] + (1.0 - w) * drag[b]
            a_g, a_s = drag_numbers(dt, k_face, mean, upwind, rho_g, rho_s)
            hg += kept_residual(dt, hg, a_g, distance) * residual[f]
            move_g, move_s = mobilities(dt, a_g, a_s, rho_g, rho_s)
            u_g, u_s = eliminate_drag(hg + dt * weight, hs + dt * force, a_g, a_s)
            drop = (p[b] - p[a]) / distance
            set_on_face(out, f, (hg, hs), (u_g, u_s), (move_g, move_s), drop)
    predict_on_boundary(g, edge, dt, cells, velocities, gradients, out)


@kernel
def reconstruct_fractions(
    g: Geometry,
    rows: Rows,
    edge: Edge,
    field: Reconstruction,
    predictor: FacePredictor,
    out: FaceFractions,
) -> None:
    """Set the fractions `out` of both phases on faces; `field` by component."""
    s, limited = field.values, field.limited
    for r in range(len(rows.length)):
        face, left, right, start, stop = (
            rows.face[r],
            rows.left[r],
            rows.right[r],
            rows.left_from[r],
            rows.left_to[r],
        )
        upwind_values(rows, 0, r, start, stop, predictor.upwind_gas, field, out.gas)
        upwind_values(rows, 0, r, start, stop, predictor.upwind_solid, field, out.solid)
        for i in range(start, stop):
            out.gas[face + i] = 1.0 - out.gas[face + i]
        for i in range(start, stop):
            here, there = s[0, left + i], s[0, right + i]
            upwind = here if predictor.upwind_solid[face + i] >= 0.0 else there
            out.solid[face + i] = carried_fraction(out.solid[face + i], upwind, limited)
    by_cell = Reconstruction(
        s.T, field.gradient.T, field.half_step.T, field.edge, field.first_order, limited
    )
    reconstruct_boundary_fractions(g, edge, by_cell, predictor, out)


@kernel
def assemble_pressure(
    g: Geometry,
    rows: Rows,
    edge: Edge,
    fractions: FaceFractions,
    predictor: FacePredictor,
    coef: Array,
    rhs: Array,
) -> None:
    """Assemble sum of coef (nf,) (p - p_neighbour) = rhs (nc,) from the sum of both
    fluxes; `rhs` holds the sources.
    """
    flux = np.empty(len(g.right))
    for r in range(len(rows.length)):
        face, left, right = rows.face[r], rows.left[r], rows.right[r]
        for i in range(ZERO, rows.length[r]):
            f = face + i
            flux[f], _ = flux_and_link(g, f, fractions, predictor)
        for i in range(rows.left_from[r], rows.left_to[r]):
            _, coef[face + i] = flux_and_link(g, face + i, fractions, predictor)
        for i in range(rows.left_from[r], rows.left_to[r]):
            rhs[left + i] -= flux[face + i]
        for i in range(rows.right_from[r], rows.right_to[r]):
            rhs[right + i] += flux[face + i]
    assemble_boundary_pressure(g, edge, fractions, predictor, coef, rhs)


@kernel
def correct_fluxes(
    g: Geometry,
    rows: Rows,
    edge: Edge,
    p: Array,
    fractions: FaceFractions,
    predictor: FacePredictor,
    faces: FaceVelocities,
    fluxes: Fluxes,
) -> None:
    """Set the velocities of `faces` with the pressure p (nc,), and the `fluxes` but
    for `moved`.
    """
    area, outflow_gas, outflow_solid = g.area, fluxes.outflow_gas, fluxes.outflow_solid
    u_gas, u_solid = np.empty(len(g.right)), np.empty(len(g.right))
    for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
        outflow_gas[c] = outflow_solid[c] = 0.0
    for r in range(len(rows.length)):
        face, left, right = rows.face[r], rows.left[r], rows.right[r]
        for i in range(ZERO, rows.length[r]):
            f, drop = face + i, (p[right + i] - p[left + i]) / g.distance[face + i]
            u_gas[f] = predictor.star_gas[f] - predictor.mobility_gas[f] * drop
            u_solid[f] = predictor.star_solid[f] - predictor.mobility_solid[f] * drop
        for i in range(rows.left_from[r], rows.left_to[r]):
            f = face + i
            faces.gas[f], faces.solid[f] = u_gas[f], u_solid[f]
            fluxes.solid[f] = area[f] * (fractions.solid[f] * u_solid[f])
            fluxes.total[f] = area[f] * of_both(fractions, f, u_gas[f], u_solid[f])
        for i in range(rows.left_from[r], rows.left_to[r]):
            outflow_gas[left + i] += max(0.0, area[face + i] * u_gas[face + i])
            outflow_solid[left + i] += max(0.0, area[face + i] * u_solid[face + i])
        for i in range(rows.right_from[r], rows.right_to[r]):
            outflow_gas[right + i] -= min(0.0, area[face + i] * u_gas[face + i])
            outflow_solid[right + i] -= min(0.0, area[face + i] * u_solid[face + i])
    correct_boundary_fluxes(g, edge, p, fractions, predictor, faces, fluxes)
    for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
        outflow_gas[c] /= g.volume[c]
        outflow_solid[c] /= g.volume[c]
