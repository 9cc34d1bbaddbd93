"""Velocities of both phases on faces: forces, implicit drag, fractions by upwinding.

With intrinsic velocities, K = beta/eps_s, a_g = dt beta/(eps_g rho_g) and a_s = dt
K/rho_s, the normal velocities on a face obey

    (1 + a_g) u_g - a_g u_s = H_g + dt (g - grad p/rho_g)
    (1 + a_s) u_s - a_s u_g = H_s + dt (g - grad p/rho_s - grad P/eps_s - grad h)

where H are the velocities after convection and stress, rho_s P is the kinetic and
collisional pressure of the particles and h(eps_s) = integral of d p_friction/(rho_s
eps_s): a bed at rest has h + z g constant, on any mesh. Both equations are solved
together on each face (partial elimination of drag, Spalding 1980, in Numerical
Computation of Multi-Phase Fluid Flow, PCH). The residual of the last step, added to the
interpolation of H, is a Rhie-Chow type correction (Rhie and Chow 1983, AIAA J. 21,
1525-1532).
"""

from __future__ import annotations

from typing import NamedTuple, TypeVar

from contbed.two_fluid.boundary import GIVEN, OUTLET, Edge
from contbed.two_fluid.compiled import SMALLEST, Array, Flags, inner, kernel
from contbed.two_fluid.fv.gradient import neighbour_weight
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.fv.reconstruction import (
    Reconstruction,
    face_value,
    value_that_leaves,
)
from contbed.two_fluid.state import ForceGradients

Value = TypeVar("Value", float, Array)

# solids fraction on a face over that of its upwind cell [-]
# (test_level_bed_on_triangles_calms_down)
MAX_OVERSHOOT = 2.0
# (N dt)^2 [-] of a buoyancy wave of frequency N up to which the step follows it: 60
# steps a period, at a Courant number of 0.5 waves 5 cells high; faster ones grow from
# rounding (test_fronts_stay_level_at_half_a_cell_a_step)
WAVE_RESOLVED = 0.01


class Cells(NamedTuple):
    """What acts in the cells (nc,).

    rho_gas [kg/m3], eps_s, drag K = beta/eps_s [kg/m3/s], kinetic P [m2/s2], friction
    h [m2/s2], p [Pa]
    resting : whether particles rest in or beside a cell
    open (nb,) : 1 at outlets through which friction pushes particles out
    rho_solid [kg/m3], gravity (dim,) [m/s2] : of all cells
    """

    rho_gas: Array
    eps_s: Array
    drag: Array
    kinetic: Array
    friction: Array
    p: Array
    resting: Flags
    open: Array
    rho_solid: float
    gravity: Array


class Velocities(NamedTuple):
    """H (nc, dim) of both phases after convection and stress, and the velocities
    (nc, dim) before [m/s].
    """

    h_gas: Array
    h_solid: Array
    old_gas: Array
    old_solid: Array


class FaceGradients(NamedTuple):
    """What interpolation to faces needs besides two cell values.

    Gradients (nc, dim, dim) of H and of the forces, used on skewed grids, and the
    Rhie-Chow residual (nf,) [m/s] of the gas from the last step.
    """

    h_gas: Array
    h_solid: Array
    forces: ForceGradients
    residual: Array


class FacePredictor(NamedTuple):
    """Normal velocities (nf,) [m/s] without the pressure, with the last pressure, and
    without any force; mobilities.

    star_gas, star_solid : without the pressure gradient
    mobility_gas, mobility_solid [m3 s/kg] : velocity per pressure gradient
    upwind_gas, upwind_solid : with the last pressure, which choose the cell that
        fractions come from
    h_gas, h_solid : normal H
    """

    star_gas: Array
    star_solid: Array
    mobility_gas: Array
    mobility_solid: Array
    upwind_gas: Array
    upwind_solid: Array
    h_gas: Array
    h_solid: Array


class FaceFractions(NamedTuple):
    """Fractions (nf,) of gas and solids that the flux carries."""

    gas: Array
    solid: Array


@inner
def of_both(fractions: FaceFractions, f: int, gas: float, solid: float) -> float:
    """Sum over the phases of what each has on a face times its fraction."""
    return float(fractions.gas[f] * gas + fractions.solid[f] * solid)


@kernel
def eliminate_drag(
    first: Value, second: Value, a_g: Value, a_s: Value
) -> tuple[Value, Value]:
    """Both velocities, or temperatures, after implicit exchange with the
    coefficients a.
    """
    scale = 1.0 / (1.0 + a_g + a_s)
    return scale * ((1.0 + a_s) * first + a_g * second), scale * (
        a_s * first + (1.0 + a_g) * second
    )


@inner
def particle_force(
    weight: float, steep: float, opposite_mean: float, friction: float
) -> float:
    """Acceleration of particles by gravity and by their own pressure.

    `steep` is the gradient of the kinetic pressure P, `friction` that of h. With the
    mean of eps_s whose weights are those of the opposite cells, the force of P on both
    cells together is its jump, as momentum needs.
    """
    return weight - steep / (opposite_mean + SMALLEST) - friction


@inner
def drag_numbers(
    dt: float, drag: float, mean: float, upwind: float, rho_gas: float, rho_solid: float
) -> tuple[float, float]:
    """a_g and a_s of a face with the mean of eps_s; drag acts on the gas as far as
    particles follow from upwind.
    """
    a_g = dt * drag * mean * neighbour_weight(upwind, mean) / ((1.0 - mean) * rho_gas)
    return a_g, dt * drag / rho_solid


@inner
def kept_residual(dt: float, hg: float, a_g: float, distance: float) -> float:
    """Share of the Rhie-Chow residual that is left after a step.

    It decays over the time in which gas crosses a cell, more slowly with drag.
    """
    return (1.0 + a_g) / (1.0 + a_g + dt * abs(hg) / distance)


@inner
def mobilities(
    dt: float, a_g: float, a_s: float, rho_gas: float, rho_solid: float
) -> tuple[float, float]:
    """Velocity of both phases per pressure gradient [m3 s/kg], with implicit drag."""
    scale = dt / (1.0 + a_g + a_s)
    return scale * ((1.0 + a_s) / rho_gas + a_g / rho_solid), scale * (
        a_s / rho_gas + (1.0 + a_g) / rho_solid
    )


@inner
def set_on_face(
    out: FacePredictor,
    f: int,
    h: tuple[float, float],
    star: tuple[float, float],
    mobility: tuple[float, float],
    drop: float,
) -> None:
    """Set what a face has; gas and solids with H, the velocity without pressure and the
    mobility of each, and the `drop` [Pa/m] of the last pressure.
    """
    out.h_gas[f], out.h_solid[f] = h
    out.star_gas[f], out.star_solid[f] = star
    out.mobility_gas[f], out.mobility_solid[f] = mobility
    out.upwind_gas[f] = star[0] - mobility[0] * drop
    out.upwind_solid[f] = star[1] - mobility[1] * drop


@kernel
def predict_on_faces(
    g: Geometry,
    edge: Edge,
    dt: float,
    cells: Cells,
    velocities: Velocities,
    gradients: FaceGradients,
    out: FacePredictor,
) -> None:
    """Set the face velocities `out` without the pressure gradient.

    Without the Rhie-Chow residual of the last step p would have noise that grows as the
    steps become small.
    """
    s, drag, kinetic, friction, p = (
        cells.eps_s,
        cells.drag,
        cells.kinetic,
        cells.friction,
        cells.p,
    )
    h_g, h_s = velocities.h_gas, velocities.h_solid
    grad_p, grad_kinetic, grad_rest = (
        gradients.forces.p,
        gradients.forces.kinetic,
        gradients.forces.rest,
    )
    rho_gas, rho_s, resting = cells.rho_gas, cells.rho_solid, cells.resting
    grad_h_gas, grad_h_solid, residual = (
        gradients.h_gas,
        gradients.h_solid,
        gradients.residual,
    )
    dim = len(g.axes)
    for f in range(len(g.right)):
        left, right, w, distance = g.left[f], g.right[f], g.weight[f], g.distance[f]
        hg = hs = weight = cross_p = cross_kinetic = cross_rest = cross_solid = 0.0
        for k in range(dim):
            n = g.normal[f, k]
            hg += n * (w * h_g[left, k] + (1.0 - w) * h_g[right, k])
            hs += n * (w * h_s[left, k] + (1.0 - w) * h_s[right, k])
            weight += n * cells.gravity[k]
        if g.skewed:
            for d in range(dim):
                for k in range(dim):
                    along = g.normal[f, k] * g.skew[f, d]
                    hg += along * (
                        w * grad_h_gas[left, k, d] + (1.0 - w) * grad_h_gas[right, k, d]
                    )
                    hs += along * (
                        w * grad_h_solid[left, k, d]
                        + (1.0 - w) * grad_h_solid[right, k, d]
                    )
                cross = g.non_orthogonal[f, d]
                cross_p += cross * (w * grad_p[left, d] + (1.0 - w) * grad_p[right, d])
                cross_kinetic += cross * (
                    w * grad_kinetic[left, d] + (1.0 - w) * grad_kinetic[right, d]
                )
                cross_rest += cross * (
                    w * grad_rest[left, d] + (1.0 - w) * grad_rest[right, d]
                )
            # a cell with few particles, which fall, must not pull others out of a cell
            # where they rest
            here, there = (left, right) if hs >= 0.0 else (right, left)
            own, share = 0.0, neighbour_weight(s[there], s[here])
            for k in range(dim):
                own += g.normal[f, k] * h_s[here, k]
            hs = own + share * (hs - own)
            # the gradients of cells around must not push where there are no particles
            most = (kinetic[left] + kinetic[right]) / distance
            cross_kinetic = min(max(cross_kinetic, -most), most)
            cross_solid = cross_p / rho_s
            if resting[left] or resting[right]:
                # between two centres the forces have a potential, and particles come to
                # rest where it is level
                most = 2.0 * min(friction[left], friction[right]) / distance
                cross_solid = min(max(cross_rest, -most), most)
                for k in range(dim):
                    cross_solid += g.non_orthogonal[f, k] * cells.gravity[k]
        rho_g = rho_gas[left] + (1.0 - w) * (rho_gas[right] - rho_gas[left])
        mean = w * s[left] + (1.0 - w) * s[right]
        steep = (kinetic[right] - kinetic[left]) / distance + cross_kinetic
        opposite_mean = (1.0 - w) * s[left] + w * s[right]
        force = particle_force(
            weight, steep, opposite_mean, (friction[right] - friction[left]) / distance
        )
        upwind = s[left] if hs + dt * force >= 0.0 else s[right]
        a_g, a_s = drag_numbers(
            dt, w * drag[left] + (1.0 - w) * drag[right], mean, upwind, rho_g, rho_s
        )
        hg += kept_residual(dt, hg, a_g, distance) * residual[f]
        move_g, move_s = mobilities(dt, a_g, a_s, rho_g, rho_s)
        u_g, u_s = eliminate_drag(
            hg + dt * (weight - cross_p / rho_g),
            hs + dt * (force - cross_solid),
            a_g,
            a_s,
        )
        drop = (p[right] - p[left]) / distance
        set_on_face(out, f, (hg, hs), (u_g, u_s), (move_g, move_s), drop)
    predict_on_boundary(g, edge, dt, cells, velocities, gradients, out)


@inner
def predict_on_boundary(
    g: Geometry,
    edge: Edge,
    dt: float,
    cells: Cells,
    velocities: Velocities,
    gradients: FaceGradients,
    out: FacePredictor,
) -> None:
    """Set the velocities of boundary faces, see `predict_on_faces`; forces act on
    outlets alone.
    """
    h_g, h_s, gas, solid, rho_s = (
        velocities.h_gas,
        velocities.h_solid,
        edge.gas,
        edge.solid,
        cells.rho_solid,
    )
    ni, dim = len(g.right), len(g.axes)
    for f in range(g.edge_from, g.edge_to):
        b, c, distance = f - ni, g.left[f], g.distance[f]
        s, rho_g = cells.eps_s[c], cells.rho_gas[c]
        if gas.kind[b] != OUTLET:
            eps = edge.eps_s[b] if solid.kind[b] == GIVEN else s
            hg, hs = (
                gas.flux[b] / (1.0 - eps),
                solid.flux[b] / eps if solid.flux[b] != 0.0 else 0.0,
            )
            out.star_gas[f], out.star_solid[f] = hg, hs
            out.mobility_gas[f] = out.mobility_solid[f] = 0.0
            # where velocities are given, the force is the one that keeps them so; at a
            # wall there is none
            for k in range(dim):
                if gas.kind[b] == GIVEN:
                    hg += g.normal[f, k] * (h_g[c, k] - velocities.old_gas[c, k])
                if solid.kind[b] == GIVEN:
                    hs += g.normal[f, k] * (h_s[c, k] - velocities.old_solid[c, k])
            out.h_gas[f], out.h_solid[f] = hg, hs
            continue
        hg = hs = weight = cross_p = 0.0
        for k in range(dim):
            hg += g.normal[f, k] * h_g[c, k]
            hs += g.normal[f, k] * h_s[c, k]
            weight += g.normal[f, k] * cells.gravity[k]
            if g.skewed:
                cross_p += g.non_orthogonal[f, k] * gradients.forces.p[c, k]
        push = weight + cells.open[b] * cells.friction[c] / distance
        a_g, a_s = drag_numbers(dt, cells.drag[c], s, s, rho_g, rho_s)
        hg += kept_residual(dt, hg, a_g, distance) * gradients.residual[f]
        move_g, move_s = mobilities(dt, a_g, a_s, rho_g, rho_s)
        u_g, u_s = eliminate_drag(
            hg + dt * (weight - cross_p / rho_g),
            hs + dt * (push - cross_p / rho_s),
            a_g,
            a_s,
        )
        drop = (edge.p[b] - cells.p[c]) / distance
        if u_s - move_s * drop < 0.0:
            # no particles come back: those of the cell are held as by a sieve, and gas
            # passes them
            hs = u_s = move_s = 0.0
            u_g, move_g = (
                (hg + dt * (weight - cross_p / rho_g)) / (1.0 + a_g),
                dt / (1.0 + a_g) / rho_g,
            )
        set_on_face(out, f, (hg, hs), (u_g, u_s), (move_g, move_s), drop)


@kernel
def reconstruct_fractions(
    g: Geometry,
    edge: Edge,
    field: Reconstruction,
    predictor: FacePredictor,
    out: FaceFractions,
) -> None:
    """Set the fractions `out` of both phases on faces, each from the cell that its
    velocity comes from.
    """
    s, grad, half_step, limited = (
        field.values,
        field.gradient,
        field.half_step,
        field.limited,
    )
    for f in range(len(g.right)):
        out.gas[f] = 1.0 - face_value(
            g, f, 0, predictor.upwind_gas[f] >= 0.0, s, grad, half_step, limited
        )
        forward = predictor.upwind_solid[f] >= 0.0
        found = face_value(g, f, 0, forward, s, grad, half_step, limited)
        out.solid[f] = carried_fraction(
            found, s[g.left[f], 0] if forward else s[g.right[f], 0], limited
        )
    reconstruct_boundary_fractions(g, edge, field, predictor, out)


@inner
def carried_fraction(found: float, upwind: float, limited: bool) -> float:
    """Solids fraction `found` on a face within bounds: an empty cell gives nothing,
    whatever its slope is.
    """
    return min(max(0.0, found), MAX_OVERSHOOT * upwind) if limited else max(0.0, found)


@inner
def reconstruct_boundary_fractions(
    g: Geometry,
    edge: Edge,
    field: Reconstruction,
    predictor: FacePredictor,
    out: FaceFractions,
) -> None:
    """Set the fractions of boundary faces, see `reconstruct_fractions`."""
    ni, s, grad, half_step, limited = (
        len(g.right),
        field.values,
        field.gradient,
        field.half_step,
        field.limited,
    )
    for f in range(g.edge_from, g.edge_to):
        b, left = f - ni, g.left[f]
        if edge.gas.kind[b] == OUTLET:
            # gas may come back, without particles
            out.gas[f] = 1.0 - s[left, 0] if predictor.upwind_gas[f] > 0.0 else 1.0
            out.solid[f] = s[left, 0] if predictor.upwind_solid[f] > 0.0 else 0.0
        else:
            eps = edge.eps_s[b] if edge.solid.kind[b] == GIVEN else s[left, 0]
            out.gas[f] = 1.0 - eps
            if edge.solid.flux[b] > 0.0:
                # what leaves has the fraction of the cell
                eps = value_that_leaves(g, f, 0, s, grad, half_step, eps, limited)
            out.solid[f] = eps


@kernel
def damp_buoyancy_waves(
    g: Geometry, dt: float, cells: Cells, fractions: FaceFractions, out: FacePredictor
) -> None:
    """Reduce the volume flux where lighter lies on denser in a closed vessel.

    Gravity acts on the layers as the volume flux will have moved them, as far as a step
    does not resolve their buoyancy wave. Explicit, a wave of frequency N grows where N
    dt > 1.
    """
    s, rho_s = cells.eps_s, cells.rho_solid
    for f in range(len(g.right)):
        left, right, w = g.left[f], g.right[f], g.weight[f]
        weight = 0.0
        for k in range(len(g.axes)):
            weight += g.normal[f, k] * cells.gravity[k]
        gas = w * cells.rho_gas[left] + (1.0 - w) * cells.rho_gas[right]
        mean = w * s[left] + (1.0 - w) * s[right]
        steep = dt * dt * weight * (rho_s - gas) * (s[right] - s[left]) / g.distance[f]
        least = WAVE_RESOLVED * (gas + mean * (rho_s - gas))
        if steep > least:
            # both phases are slowed alike; fractions that come from two cells do not
            # sum to one
            slower = (1.0 - least / steep) / (fractions.gas[f] + fractions.solid[f])
            flux = slower * of_both(fractions, f, out.star_gas[f], out.star_solid[f])
            move_g, move_s = out.mobility_gas[f], out.mobility_solid[f]
            mobility = slower * of_both(fractions, f, move_g, move_s)
            out.star_gas[f] -= flux
            out.star_solid[f] -= flux
            out.mobility_gas[f] -= mobility
            out.mobility_solid[f] -= mobility
