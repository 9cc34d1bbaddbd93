"""Granular temperature of one step.

    3/2 rho_s (d(eps_s theta)/dt + div(F theta)) = -p_s div u_s + P + div(k grad theta) - gamma - 3 beta theta

F [m/s] is the volume flux of the solids that the step moves, P [W/m3] the shear
production without that of friction, which does not agitate particles. Convection is
explicit and limited, the rest implicit but for the heat of compression and of shear,
which binds the step. Dissipation and drag alone cool the particles as their closed form
says, in any step (Haff 1983, J. Fluid Mech. 134, 401-430); the heat binds the step
because near packing that of compression makes sound up to six times as
stiff as at constant theta, and few particles, whose viscosity does not vanish with
their fraction, are heated much by shear. "algebraic" balances production and
dissipation, and neither moves nor conducts (Syamlal, Rogers and O'Brien 1993, MFIX
Documentation: Theory Guide, DOE/METC-94/1004); below the balance theta rises as fast as
    P alone heats the particles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.compiled.threads import parallel
from contbed.two_fluid import boundary
from contbed.two_fluid.boundary import WALL, Edge, Particles, speed_through
from contbed.two_fluid.cell_velocities import FaceVelocities
from contbed.two_fluid.compiled import SMALLEST, UNDERFLOW, Array, Flags, inner, kernel
from contbed.two_fluid.continuity import Moved
from contbed.two_fluid.fv.gradient import MIN_BINDING_FRACTION, NO_PARTICLES
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.fv.reconstruction import Reconstruction
from contbed.two_fluid.implicit import solve_system
from contbed.two_fluid.linear.cg import System, empty_system
from contbed.two_fluid.model import Model
from contbed.two_fluid.momentum import Predicted
from contbed.two_fluid.operators import gradient, predictor_half_step
from contbed.two_fluid.state import Counters, Properties, State
from contbed.two_fluid.timing import timed

# drag of a step below which (1 - exp(-drag/2))/drag is 1/2 to rounding [-]
SMALLEST_DRAG = 1e-15
SMALLEST_ROOT = 1e-150  # [m/s] whose square is not subnormal


class Granular(NamedTuple):
    """Result of a step.

    theta (nc,) [m2/s2], its rate (nc, 1) [m2/s3] without convection, and 1 over the
    longest stable step with the heat of compression and shear [1/s].
    """

    theta: Array
    rate: Array
    heating_rate: float
    counters: Counters


class GranularTerms(NamedTuple):
    """Terms of granular energy (nc,).

    dissipation/theta and 3 beta [W s2/m5], p_solid/theta [kg/m3], divergence of the
    solids [1/s] and source [W/m3].
    """

    dissipation: Array
    drag: Array
    pressure: Array
    divergence: Array
    source: Array


@inner
def closed_cooling(collisions: float, drag: float) -> float:
    """Factor of theta - theta_old with which one step of theta' = -a theta^1.5 - b theta
    is exact: factor (theta - theta_old) = -(collisions + drag) theta_old.

    collisions = a sqrt(theta_old) dt and drag = b dt [-]. sqrt(theta) obeys an equation
    of Bernoulli: sqrt(theta/theta_old) = (1 - m drag)/(1 + m collisions) with m =
    (1 - exp(-drag/2))/drag. The factor is 1 + 3/4 collisions + 1/2 drag for short
    steps, collisions + drag for long ones.
    """
    m = 0.5 if drag < SMALLEST_DRAG else -np.expm1(-0.5 * drag) / drag
    slowed = 1.0 + m * collisions
    return slowed**2 / (m * (1.0 + slowed - m * drag))


@kernel
def assemble_theta(
    g: Geometry,
    edge: Edge,
    dt: float,
    particles: Particles,
    terms: GranularTerms,
    slip: Array,
    u: Array,
    system: System,
) -> None:
    """Complete the system for the change of theta, whose right-hand side holds what is
    convected [W].

    Sinks are exact by themselves, sources explicit (Patankar 1980, Numerical Heat
    Transfer and Fluid Flow). Sinks are linear where theta leaves a cell by convection
    or heat balances them: what leaves is no longer there to dissipate, so that theta
    stays positive, and less damping of heat makes shocks unstable. Walls produce and
    dissipate by Johnson and Jackson (1987, J. Fluid Mech. 176, 67-93) with `slip` (nb,)
    and the velocity u (nc, dim).
    """
    content, rhs, solid = system.content, system.rhs, edge.solid
    s, old, source = particles.eps_s, particles.theta, terms.source
    ni = len(g.right)
    for c in range(len(s)):
        content[c, 0] = g.volume[c] * terms.dissipation[c]
    for b in range(len(slip)):
        if solid.slip[b] >= 0.0 or solid.kind[b] != WALL:
            continue
        f = ni + b
        c = g.left[f]
        agitation = (
            g.area[f]
            * np.pi
            * np.sqrt(3.0)
            * particles.rho
            * s[c]
            * particles.g0[c]
            * np.sqrt(old[c])
        )
        common = agitation / particles.eps_max
        slide, away = 0.0, speed_through(g, solid, b, u)
        for k in range(len(g.axes)):
            slide += (slip[b] * (u[c, k] - solid.u[b, k] - away * g.normal[f, k])) ** 2
        loss = common * (1.0 - edge.restitution[b] ** 2) / 4.0
        rhs[c, 0] += common * edge.specularity[b] * slide / 6.0
        content[c, 0] += loss
    for c in range(len(s)):
        collisions, drag = content[c, 0], g.volume[c] * terms.drag[c]
        compress = g.volume[c] * terms.pressure[c] * terms.divergence[c]
        mass = 1.5 * particles.rho * (s[c] + NO_PARTICLES) * g.volume[c] / dt
        sinks = (collisions + drag) * old[c]
        leaving = max(0.0, -rhs[c, 0]) / (mass * old[c] + SMALLEST)
        heat = max(0.0, rhs[c, 0]) + g.volume[c] * max(0.0, source[c])
        heat += max(0.0, -compress) * old[c]
        linear = min(1.0, max(leaving, heat / (sinks + SMALLEST)))
        factor = closed_cooling(collisions / mass, drag / mass)
        factor += linear * (1.0 + (collisions + drag) / mass - factor)
        rhs[c, 0] += g.volume[c] * source[c] - sinks - compress * old[c]
        content[c, 0] = mass * factor + max(0.0, compress)
        if source[c] < 0.0:
            content[c, 0] -= g.volume[c] * source[c] / (old[c] + SMALLEST)


@kernel
def max_heating_rate(
    begin: int,
    end: int,
    links: Array,
    particles: Particles,
    theta: Array,
    terms: GranularTerms,
    drag: Array,
    mu: Array,
) -> float:
    """Largest 1/dt [1/s] at which motion that drives itself by the heat of compression
    and shear does not grow.

    The step follows a compression by its heat, and that by the velocity that it drives,
    so that K dt^2 < (2 + d dt)(2 + b dt) with the rates K of both, d of dissipation and
    b of drag. A change S' of the shear S changes the production P = 2 mu S:S by up to 2
    (2 mu P)^(1/2) |S'|, which adds to p_s: K = 2/3 (p_s/theta) (p_s + 2 (2 mu P)^(1/2))
    k^2/(rho_s eps_s)^2, k^2 = 2 `links` for cells that take turns. Viscosity acts
    before the velocity that heat drives and damps it in the next step only: it is left
    out.

    links (nc,) [1/m2] : sum of area over distance of the interior faces of a cell, over
        its volume
    theta (nc,) : new granular temperature;
    mu (nc,) : kinetic viscosity [Pa s]
    """
    s, rho_s = particles.eps_s, particles.rho
    fastest = 0.0
    for c in range(begin, end):
        if s[c] > MIN_BINDING_FRACTION:
            stress = terms.pressure[c] * theta[c] + 2.0 * np.sqrt(
                2.0 * mu[c] * max(0.0, terms.source[c])
            )
            both = (
                4.0 / 3.0 * terms.pressure[c] * stress / (rho_s * s[c]) ** 2 * links[c]
            )
            sink = terms.dissipation[c] + terms.drag[c]
            d, b = sink / (1.5 * rho_s * s[c]), drag[c] / rho_s
            fastest = max(fastest, 0.25 * (np.sqrt((d - b) ** 2 + 4.0 * both) - d - b))
    return fastest


@kernel
def mark_negative(
    g: Geometry, dt: float, s: Array, old: Array, rhs: Array, first_order: Flags
) -> bool:
    """Mark the cells where convection alone would make theta negative, and their
    neighbours.

    Return whether any was not marked before.
    """
    found = False
    for f in range(len(g.left)):
        left = g.left[f]
        right = g.right[f] if f < len(g.right) else left
        for c, other in ((left, right), (right, left)):
            if s[c] * g.volume[c] * old[c] + dt * rhs[c, 0] < 0.0 and not (
                first_order[c] and first_order[other]
            ):
                first_order[c] = first_order[other] = True
                found = True
    return found


@timed("granular temperature")
def advance(
    state: State,
    moved: Moved,
    solid: Predicted,
    faces: FaceVelocities,
    u_solid: Array,
    properties: Properties,
    dt: float,
    model: Model,
) -> Granular:
    """Granular temperature after `dt` [s], by the option of the model."""
    memory = state.memory
    if model.options.theta == "frozen":
        return Granular(
            state.theta, memory.rate_theta, memory.heating_rate, moved.counters
        )
    r, divergence = properties.rheology, np.empty_like(state.theta)
    model.kernels.divergence_solid(faces, moved.eps_s, u_solid, divergence)
    kinetic_share = (
        solid.shear_production
        / model.grid.geometry.volume
        * r.mu
        / (r.mu + properties.mu_friction + SMALLEST)
    )
    production = kinetic_share + model.sources.theta
    if model.options.theta == "algebraic":
        theta = _balanced(
            state.theta, moved.eps_s, production, divergence, properties, dt, model
        )
        model.grid.halo.exchange(theta)
        return Granular(theta, memory.rate_theta, memory.heating_rate, moved.counters)
    rho_s = model.materials.rho_solid
    dissipation = r.dissipation * np.sqrt(state.theta)
    drag = 3.0 * properties.drag * moved.eps_s
    terms = GranularTerms(dissipation, drag, rho_s * r.pressure, divergence, production)
    return _transport(state, moved, terms, solid.slip, u_solid, properties, dt, model)


def _transport(
    state: State,
    moved: Moved,
    terms: GranularTerms,
    slip: Array,
    u_solid: Array,
    properties: Properties,
    dt: float,
    model: Model,
) -> Granular:
    """Convected with the solids flux, conducted, produced, dissipated."""
    g, edge, r, s = model.grid.geometry, model.edge, properties.rheology, moved.eps_s
    rho_s, old, counters = model.materials.rho_solid, state.theta, moved.counters
    column, entering = old.reshape(-1, 1), edge.solid.kind == boundary.GIVEN
    given = np.where(entering, edge.theta, old[model.boundary_cells]).reshape(-1, 1)
    grad = gradient(model, column, given)
    half_step = predictor_half_step(
        model, dt, column, grad, u_solid, state.memory.rate_theta
    )
    system, first_order, halo = (
        empty_system(g, 1),
        moved.upwind_cells.copy(),
        model.grid.halo,
    )
    rhs, own = system.rhs, halo.cells
    while True:
        rhs[:] = 0.0
        field = Reconstruction(
            column, grad, half_step, given, first_order, model.options.limited
        )
        model.kernels.convect(moved.flux, field, rhs)
        if not _mark_negative(dt, s, old, rhs, first_order, model):
            break
    marked = int(first_order[own].sum()) - int(moved.upwind_cells[own].sum())
    convected = rhs / ((s + NO_PARTICLES) * g.volume)[:, None]
    rhs *= 1.5 * rho_s
    outside = np.where(entering, edge.theta, np.nan)
    particles = Particles(rho_s, model.materials.eps_max, s, old, r.g0)
    assemble_theta(g, edge, dt, particles, terms, slip, u_solid, system)
    model.kernels.conduct(r.conductivity, old, outside, grad, rhs, system.coef)
    theta = old + solve_system(state, "theta", system, model)[:, 0]
    clipped = 0
    if (low := theta < UNDERFLOW).any():
        clipped = int((theta[own] < 0.0).sum())
        theta[low] = 0.0
    rate = (theta.reshape(-1, 1) - column) / dt - convected
    links, number = model.grid.links, len(s[own])
    rates = parallel(
        max_heating_rate, number, links, particles, theta, terms, properties.drag, r.mu
    )
    marked, clipped = (int(number) for number in halo.sum(marked, clipped))
    counters = counters.add(theta_upwind_cells=marked, theta_clipped_cells=clipped)
    return Granular(theta, rate, halo.max(max(rates)), counters)


def _mark_negative(
    dt: float, s: Array, old: Array, rhs: Array, first_order: Flags, model: Model
) -> bool:
    """Mark cells as `mark_negative`, on all ranks."""
    halo, before = model.grid.halo, first_order[model.grid.halo.cells].copy()
    found = mark_negative(model.grid.geometry, dt, s, old, rhs, first_order)
    if halo.distributed:
        # what is found beside the outer ghost cells is not known here
        halo.exchange(first_order)
        found = halo.any(bool((first_order[halo.cells] != before).any()))
    return found


def _balanced(
    theta: Array,
    s: Array,
    production: Array,
    divergence: Array,
    properties: Properties,
    dt: float,
    model: Model,
) -> Array:
    """Granular temperature at which production balances dissipation, a quadratic for
    its square root.

    Compression is left aside: few particles would need theta as 1/eps_s^2 to lose what
    it gives. They also take longer than `dt` [s] to come to the balance, and gain no
    more than the work of the shear in the step, 3/2 rho_s eps_s
    (theta - theta_old) <= P dt: the balance alone gives them energy that the flow has
    not lost, which their pressure then gives to the flow.
    """
    r, root = properties.rheology, np.sqrt(theta)
    factor = np.where(
        root > 0, np.maximum(production, 0.0) / np.maximum(root, SMALLEST_ROOT), 0.0
    )
    linear = (
        model.materials.rho_solid * r.pressure * np.maximum(divergence, 0.0)
        + 3.0 * properties.drag * s
    )
    y: Array = (
        2.0
        * factor
        / (linear + np.sqrt(linear**2 + 4.0 * r.dissipation * factor) + SMALLEST)
    )
    fed = (
        np.maximum(production, 0.0)
        * dt
        / (1.5 * model.materials.rho_solid * (s + NO_PARTICLES))
    )
    return np.minimum(y**2, theta + fed)
