"""Kernels of the implicit solids pressure: what compaction does to the solids flux
within a step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.compiled import Array, inner, kernel
from contbed.two_fluid.fv.gradient import neighbour_weight
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.linear.cg import System

# least stiffness d p_solid/d eps_s/rho_s [m2/s2]: cold particles have none, and its
# inverse must exist (test_cold_particles_have_hardly_any_stiffness)
MIN_STIFFNESS = 1e-12
# change of eps_s [-] by the pressure that a tangent may miss before it is taken
# elsewhere (test_slug_thrown_on_a_wall_packs_and_stays)
TANGENT_ERROR = 1e-3
# steps by Newton's method, or halvings where it leaves the interval, in which the
# fraction of a tangent is found; few are needed, as the pressure is a chain of straight
# lines (test_slug_thrown_on_a_wall_packs_and_stays)
MAX_TANGENT_STEPS = 40
# change of the solids fraction [-] at which they end
TANGENT_RESOLVED = 1e-15
# solids fraction [-] below which the compaction velocity of a cell fades: so few
# particles would be thrown away (test_slug_thrown_on_a_wall_packs_and_stays)
MIN_PUSHED_FRACTION = 1e-4
# eps_s/eps_max [-] from which on particles keep none of the compaction velocity:
# friction may stop them at once (test_compaction_velocity_fades_towards_packing)
COMPACTION_VELOCITY_LIMIT = 0.6


class FrictionTable(NamedTuple):
    """Frictional pressure over rho_s [m2/s2] at the solids fractions start,
    start + spacing, ...
    """

    start: float
    spacing: float
    values: Array


class Solids(NamedTuple):
    """Solids at the start of a step.

    Fraction (nc,), K = beta/eps_s (nc,) [kg/m3/s] and stiffness d p_solid/d eps_s/rho_s
    (nc,) [m2/s2]; density [kg/m3]; `open` (nb,), 1 at boundary faces through which
    friction pushes particles out.
    """

    eps_s: Array
    drag: Array
    stiffness: Array
    rho: float
    open: Array


@inner
def compaction_link(
    dt: float, drag: float, rho: float, area: float, distance: float
) -> float:
    """Link of two cells by the pressure of the solids, which drag holds back."""
    return dt * dt * area / distance / (1.0 + dt * drag / rho)


@inner
def link_outlets(g: Geometry, dt: float, solids: Solids, coef: Array) -> None:
    """Set the links `coef` (nf,) of boundary faces: of open ones with the pressure
    outside, which does not change.
    """
    for f in range(g.edge_from, g.edge_to):
        c = g.left[f]
        coef[f] = solids.open[f - len(g.right)] * compaction_link(
            dt, solids.drag[c], solids.rho, g.area[f], g.distance[f]
        )


@inner
def push_out(g: Geometry, dt: float, coef: Array, y: Array, flux: Array) -> None:
    """Add the flux that the change y (nc,) of p_solid/rho_s drives through outlets;
    nothing comes back.
    """
    for f in range(g.edge_from, g.edge_to):
        if coef[f] > 0.0:
            flux[f] = max(0.0, flux[f] + coef[f] * y[g.left[f]] / dt)


@inner
def sound_share(coef: float, content_left: float, content_right: float) -> float:
    """Share of the compaction flux that becomes velocity, from the squared number of
    cells that sound crosses.
    """
    crossed = coef / min(content_left, content_right)
    return crossed / (1.0 + crossed)


@inner
def compaction_stiffness(stiffness: float) -> float:
    """Stiffness [m2/s2] that compaction takes: none where the pressure of clusters
    falls with the solids fraction.

    What such a pressure pulls together stays explicit, in the momentum of the
    particles; a negative stiffness would leave the equation of compaction without a
    unique solution.
    """
    return max(stiffness, 0.0) + MIN_STIFFNESS


@inner
def kept_compaction(
    mean: float, s_left: float, s_right: float, eps_max: float
) -> float:
    """Compaction velocity over the flux per area; `mean` of eps_s on the face.

    Very dilute cells get less of it, and dense cells too, because the limiter or
    friction may stop what was pushed.
    """
    kept = 1.0 - (max(s_left, s_right) / (COMPACTION_VELOCITY_LIMIT * eps_max)) ** 4
    return (
        min(1.0, mean / MIN_PUSHED_FRACTION)
        * max(0.0, kept)
        / max(mean, MIN_PUSHED_FRACTION)
    )


@kernel
def assemble_compaction(
    g: Geometry, dt: float, solids: Solids, flux: Array, source: Array, system: System
) -> None:
    """Assemble V y/c - sum of coef (y_neighbour - y) = rhs for the change y of
    p_solid/rho_s in a step.

    The change of eps_s is y/c with the stiffness c; `flux` (nf,) [m3/s] is that without
    y, `source` (nc,) [1/s].
    """
    ni, s, drag = len(g.right), solids.eps_s, solids.drag
    coef, content, rhs = system.coef, system.content, system.rhs
    for c in range(len(drag)):
        content[c, 0] = g.volume[c] / compaction_stiffness(solids.stiffness[c])
        rhs[c, 0] = dt * g.volume[c] * source[c]
    for f in range(len(g.left)):
        rhs[g.left[f], 0] -= dt * flux[f]
        if f >= ni:
            continue
        left, right = g.left[f], g.right[f]
        rhs[right, 0] += dt * flux[f]
        w = g.weight[f]
        mean_drag = w * drag[left] + (1.0 - w) * drag[right]
        coef[f, 0] = compaction_link(
            dt, mean_drag, solids.rho, g.area[f], g.distance[f]
        )
        if g.skewed and flux[f] != 0.0:
            # few particles that sink into many, from a cell that the surface hardly
            # cuts, are not thrown back
            coef[f, 0] *= (
                neighbour_weight(s[left], s[right])
                if flux[f] > 0.0
                else neighbour_weight(s[right], s[left])
            )
    link_outlets(g, dt, solids, coef[:, 0])


@kernel
def add_compaction_flux(
    g: Geometry, dt: float, system: System, y: Array, flux: Array, velocity: Array
) -> None:
    """Add the flux that the change y (nc, 1) of p_solid/rho_s drives.

    velocity (nf,) [m/s] : the part of this flux, per area, that becomes velocity of the
    particles. It is negligible while a step resolves the sound of the particles: the
    new pressure then accelerates them in the next step. Where sound crosses cells
    within a step, that explicit acceleration alone would oscillate.
    """
    coef, content = system.coef, system.content
    velocity[:] = 0.0
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        change = -coef[f, 0] * (y[right, 0] - y[left, 0]) / dt
        flux[f] += change
        velocity[f] = (
            change
            / g.area[f]
            * sound_share(coef[f, 0], content[left, 0], content[right, 0])
        )
    push_out(g, dt, coef[:, 0], y[:, 0], flux)


@kernel
def add_compaction_velocity(
    g: Geometry, velocity: Array, eps_max: float, s: Array, u: Array
) -> None:
    """Add the compaction velocity of the faces to the velocity u (nc, dim) [m/s] of the
    particles.

    `velocity` (nf,) [m/s] is that of `add_compaction_flux`. Each cell gets the
    least-squares vector of its faces.
    """
    ni, dim = len(g.right), len(g.axes)
    change, out = np.zeros(u.shape), np.empty(dim)
    for f in range(ni):
        left, right, w = g.left[f], g.right[f], g.weight[f]
        mean = (1.0 - w) * s[left] + w * s[right]
        speed = (
            g.face_size[f]
            * velocity[f]
            * kept_compaction(mean, s[left], s[right], eps_max)
        )
        for k in range(dim):
            change[left, k] += speed * g.normal[f, k]
            change[right, k] += speed * g.normal[f, k]
    for c in range(len(s)):
        for k in range(dim):
            out[k] = 0.0
            for d in range(dim):
                out[k] += g.moment_inverse[c, k, d] * change[c, d]
        for k in range(dim):
            u[c, k] += out[k]


@kernel
def frictional_pressure(table: FrictionTable, s: float) -> tuple[float, float]:
    """p_friction/rho_s [m2/s2] at the solids fraction s, and its slope."""
    first, spacing, values = table.start, table.spacing, table.values
    if s <= first:
        return 0.0, 0.0
    j = min(int((s - first) / spacing), len(values) - 2)
    slope = (values[j + 1] - values[j]) / spacing
    return values[j] + slope * (
        min(s, first + spacing * (len(values) - 1)) - first - spacing * j
    ), slope


@kernel
def move_tangents(
    begin: int,
    end: int,
    volumes: Array,
    table: FrictionTable,
    solids: Solids,
    y: Array,
    system: System,
    shift: Array,
) -> bool:
    """Linearize the frictional pressure anew where the tangent misses it; return
    whether that was so in any cell.

    Where a step packs or loosens a cell, the frictional pressure differs much from its
    tangent at the old solids fraction. There the tangent is taken at the fraction that
    the cell has if its neighbours keep their y (one nonlinear Jacobi iteration for one
    cell, solved by Newton's method within bounds).

    volumes (nc,) [m3]; system : its links (nc, 1) are the sums over all faces of a cell
    shift (nc,) : what the tangents so far have added to the right-hand side
    """
    links, content, rhs = system.links, system.content, system.rhs
    found = False
    for c in range(begin, end):
        volume, old = volumes[c], solids.eps_s[c]
        predicted = old + (content[c, 0] * y[c, 0] - shift[c]) / volume
        if max(old, predicted) <= table.start:
            continue
        before, slope = frictional_pressure(table, old)
        kinetic = max(0.0, solids.stiffness[c] - slope) + MIN_STIFFNESS
        missed = (
            kinetic * (predicted - old)
            + frictional_pressure(table, predicted)[0]
            - before
            - y[c, 0]
        )
        if missed * links[c, 0] <= TANGENT_ERROR * volume:
            continue
        found = True
        most = volume * (predicted - old) + links[c, 0] * y[c, 0]
        low, high = predicted - links[c, 0] * missed / volume, predicted
        middle = high
        for _ in range(MAX_TANGENT_STEPS):
            pushed, steep = frictional_pressure(table, middle)
            pushed += kinetic * (middle - old) - before
            over = volume * (middle - old) + links[c, 0] * pushed - most
            if over < 0.0:
                low = middle
            else:
                high = middle
            last, middle = (
                middle,
                middle - over / (volume + links[c, 0] * (kinetic + steep)),
            )
            if not low <= middle <= high:
                middle = 0.5 * (low + high)
            if abs(middle - last) <= TANGENT_RESOLVED:
                break
        low = middle
        pushed, steep = frictional_pressure(table, low)
        pushed += kinetic * (low - old) - before
        content[c, 0] = volume / (kinetic + steep)
        rhs[c, 0] -= shift[c]
        shift[c] = content[c, 0] * pushed - volume * (low - old)
        rhs[c, 0] += shift[c]
    return found
