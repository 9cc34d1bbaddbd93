"""Kernels of the implicit solids pressure: what compaction does to the solids flux within a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.compiled import Array, kernel
from contbed.two_fluid.fv.gradient import neighbour_weight
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.linear.cg import System

# stiffness [m2/s2] of particles that do not touch, so that its inverse exists
SOFT = 1e-12
# change of eps_s [-] by the pressure that a tangent may miss before it is taken elsewhere
# (test_slug_thrown_on_a_wall_packs_and_stays)
TANGENT_ERROR = 1e-3
# steps in which the fraction of a tangent is found (test_slug_thrown_on_a_wall_packs_and_stays)
BISECTIONS = 40
# solids fraction [-] below which a cloud is not pushed within a step, as it would fly off
# (test_slug_thrown_on_a_wall_packs_and_stays)
FAINT = 1e-4
# share of the packing limit [-] from which on particles keep none of the velocity of compaction
LOOSE = 0.6


class FrictionTable(NamedTuple):
    """Frictional pressure over rho_s [m2/s2] at the solids fractions start, start + spacing, ..."""

    start: float
    spacing: float
    values: Array


class Solids(NamedTuple):
    """Solids at the start of a step.

    Fraction (nc,), K = beta/eps_s (nc,) [kg/m3/s] and stiffness d p_solid/d eps_s/rho_s (nc,) [m2/s2]; density [kg/m3].
    """

    eps_s: Array
    drag: Array
    stiffness: Array
    rho: float


@kernel
def assemble_compaction(g: Geometry, dt: float, solids: Solids, flux: Array, source: Array, system: System) -> None:
    """Assemble V y/c - sum of coef (y_neighbour - y) = rhs for the change y of p_solid/rho_s in a step.

    The change of eps_s is y/c with the stiffness c; `flux` (nf,) [m3/s] is that without y, `source` (nc,) [1/s].
    """
    ni, s, drag = len(g.right), solids.eps_s, solids.drag
    coef, content, rhs = system.coef, system.content, system.rhs
    for c in range(len(drag)):
        content[c, 0] = g.volume[c] / (solids.stiffness[c] + SOFT)
        rhs[c, 0] = dt * g.volume[c] * source[c]
    for f in range(len(g.left)):
        rhs[g.left[f], 0] -= dt * flux[f]
        coef[f, 0] = 0.0
        if f >= ni:
            continue
        left, right = g.left[f], g.right[f]
        rhs[right, 0] += dt * flux[f]
        w = g.weight[f]
        hold = 1.0 + dt * (w * drag[left] + (1.0 - w) * drag[right]) / solids.rho
        coef[f, 0] = dt * dt * g.area[f] / g.distance[f] / hold
        if g.skewed and flux[f] != 0.0:
            # few particles that sink into many, from a cell that the surface hardly cuts, are not thrown back
            coef[f, 0] *= neighbour_weight(s[left], s[right]) if flux[f] > 0.0 else neighbour_weight(s[right], s[left])


@kernel
def add_compaction_flux(g: Geometry, dt: float, system: System, y: Array, flux: Array, velocity: Array) -> None:
    """Add the flux that the change y (nc, 1) of p_solid/rho_s drives.

    velocity (nf,) [m/s] is the part of it, per area, that the particles keep. Without, the next step has the new
    pressure push them, and a wave passes without loss; where sound crosses cells within a step, it would ring.
    """
    coef, content = system.coef, system.content
    velocity[:] = 0.0
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        change = -coef[f, 0] * (y[right, 0] - y[left, 0]) / dt
        flux[f] += change
        # squared number of cells that sound crosses in a step
        crossed = coef[f, 0] / min(content[left, 0], content[right, 0])
        velocity[f] = change / g.area[f] * crossed / (1.0 + crossed)


@kernel
def add_compaction_velocity(g: Geometry, velocity: Array, eps_max: float, s: Array, u: Array) -> None:
    """Add to the velocity u (nc, dim) of the particles what compaction gives them.

    `velocity` (nf,) is that of `add_compaction_flux`; the cells of a face share it by mass. Not to a faint cloud, and
    less and less towards packing, where a limit or friction may stop what was pushed.
    """
    ni, dim = len(g.right), len(g.axes)
    change, out = np.zeros(u.shape), np.empty(dim)
    for f in range(ni):
        left, right, w = g.left[f], g.right[f], g.weight[f]
        mean = (1.0 - w) * s[left] + w * s[right]
        loose = 1.0 - (max(s[left], s[right]) / (LOOSE * eps_max)) ** 4
        speed = g.face_size[f] * velocity[f] / max(mean, FAINT) * min(1.0, mean / FAINT) * max(0.0, loose)
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
    return values[j] + slope * (min(s, first + spacing * (len(values) - 1)) - first - spacing * j), slope


@kernel
def move_tangents(
    g: Geometry, table: FrictionTable, solids: Solids, links: Array, y: Array, system: System, shift: Array
) -> bool:
    """Take the tangent of friction where it is needed; return whether any was moved.

    Cells that a step packs, or sets free, feel far more than the tangent at their old fraction says, and would be
    thrown apart. In such cells the tangent is taken at the fraction that the cell would have if its neighbours kept
    their y (a nonlinear Jacobi iteration for one cell, by bisection).

    links (nc, 1) : sum of the links of a cell; shift (nc,) : what the tangents so far have added to the right-hand side
    """
    content, rhs = system.content, system.rhs
    found = False
    for c in range(len(solids.eps_s)):
        volume, old = g.volume[c], solids.eps_s[c]
        predicted = old + (content[c, 0] * y[c, 0] - shift[c]) / volume
        if max(old, predicted) <= table.start:
            continue
        before, slope = frictional_pressure(table, old)
        kinetic = max(0.0, solids.stiffness[c] - slope) + SOFT
        missed = kinetic * (predicted - old) + frictional_pressure(table, predicted)[0] - before - y[c, 0]
        if missed * links[c, 0] <= TANGENT_ERROR * volume:
            continue
        found = True
        most = volume * (predicted - old) + links[c, 0] * y[c, 0]
        low, high = predicted - links[c, 0] * missed / volume, predicted
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            pushed = kinetic * (middle - old) + frictional_pressure(table, middle)[0] - before
            if volume * (middle - old) + links[c, 0] * pushed < most:
                low = middle
            else:
                high = middle
        pushed, steep = frictional_pressure(table, low)
        pushed += kinetic * (low - old) - before
        content[c, 0] = volume / (kinetic + steep)
        rhs[c, 0] -= shift[c]
        shift[c] = content[c, 0] * pushed - volume * (low - old)
        rhs[c, 0] += shift[c]
    return found
