"""Kernels for what only the particles have: compaction, granular temperature, Johnson and Jackson's wall."""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import GIVEN, WALL
from contbed.two_fluid.compiled import kernel
from contbed.two_fluid.fv.gradient import heard

TINY = 1e-300
SOFT = 1e-12  # [m2/s2] stiffness of particles that do not touch, so that its inverse exists
MISSED = 1e-3  # change of eps_s by the pressure that a tangent misses, above which the tangent moves
HALVINGS = 40
FAINT, LOOSE = 1e-4, 0.6  # fraction below which a cloud is not pushed within a step; share of packing, above which
EMPTY = 1e-30  # a cell with a smaller fraction keeps its velocity and granular temperature


@kernel
def slip_speed(u_gas, u_solid, out):
    """|u_gas - u_solid| of each cell."""
    for c in range(len(out)):
        total = 0.0
        for k in range(u_gas.shape[1]):
            total += (u_gas[c, k] - u_solid[c, k]) ** 2
        out[c] = np.sqrt(total)


@kernel
def compaction(g, dt, rho_s, stiffness, drag, s, flux, source, coef, content, rhs):
    """The implicit part of the solids pressure: V y/c - sum of coef (y_neighbour - y) = rhs for the change y of
    p_solid/rho_s, with the change y/c of eps_s where c is the `stiffness` (nc,) dp_solid/deps_s/rho_s [m2/s2].
    """
    ni = len(g.right)
    for c in range(len(drag)):
        content[c, 0] = g.volume[c] / (stiffness[c] + SOFT)
        rhs[c, 0] = dt * g.volume[c] * source[c]
    for f in range(len(g.left)):
        rhs[g.left[f], 0] -= dt * flux[f]
        coef[f, 0] = 0.0
        if f >= ni:
            continue
        left, right = g.left[f], g.right[f]
        rhs[right, 0] += dt * flux[f]
        w = g.share[f]
        hold = 1.0 + dt * (w * drag[left] + (1.0 - w) * drag[right]) / rho_s
        coef[f, 0] = dt * dt * g.area[f] / g.distance[f] / hold
        if g.wide and flux[f] != 0.0:
            # few particles that sink into many, from a cell that the surface hardly cuts, are not thrown back
            coef[f, 0] *= heard(s[left], s[right]) if flux[f] > 0.0 else heard(s[right], s[left])


@kernel
def compact(g, dt, coef, content, y, flux, push):
    """Adds the flux that the change y of p_solid/rho_s drives; push (nf,) [m/s] is the part of it, per area, that the
    particles keep as velocity. Without, the next step has the new pressure push them, and a wave passes without loss;
    where sound crosses cells within a step, it would ring.
    """
    push[:] = 0.0
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        change = -coef[f, 0] * (y[right, 0] - y[left, 0]) / dt
        flux[f] += change
        crossed = coef[f, 0] / min(content[left, 0], content[right, 0])  # squared, in cells
        push[f] = change / g.area[f] * crossed / (1.0 + crossed)


@kernel
def recoil(g, push, eps_max, s, u):
    """Adds to the velocity u (nc, dim) of the particles what `push` gives them; the cells of a face share it by mass.
    Not to a faint cloud, and less and less towards packing, where a limit or friction may stop what was pushed.
    """
    ni, dim = len(g.right), len(g.axes)
    change, out = np.zeros(u.shape), np.empty(dim)
    for f in range(ni):
        left, right, w = g.left[f], g.right[f], g.share[f]
        carried = (1.0 - w) * s[left] + w * s[right]
        loose = 1.0 - (max(s[left], s[right]) / (LOOSE * eps_max)) ** 4
        speed = g.flat[f] * push[f] / max(carried, FAINT) * min(1.0, carried / FAINT) * max(0.0, loose)
        for k in range(dim):
            change[left, k] += speed * g.normal[f, k]
            change[right, k] += speed * g.normal[f, k]
    for c in range(len(s)):
        for k in range(dim):
            out[k] = 0.0
            for d in range(dim):
                out[k] += g.inverse[c, k, d] * change[c, d]
        for k in range(dim):
            u[c, k] += out[k]


@kernel
def friction(packing, s):
    """p_friction/rho_s [m2/s2] at the fraction s, and its slope, from the table `packing`."""
    first, spacing, table = packing
    if s <= first:
        return 0.0, 0.0
    j = min(int((s - first) / spacing), len(table) - 2)
    slope = (table[j + 1] - table[j]) / spacing
    return table[j] + slope * (min(s, first + spacing * (len(table) - 1)) - first - spacing * j), slope


@kernel
def repack(g, packing, s, stiffness, near, y, content, rhs, shift):
    """Puts the tangent of friction where it is needed: cells that a step packs, or sets free, feel far more than the
    tangent at their old fraction says, and would be thrown apart. In such cells the tangent is taken at the fraction
    that the cell would have if its neighbours kept their y. Returns whether there was any.

    near (nc, 1) : sum of the links of a cell; shift (nc,) : what the tangents so far have added to `rhs`
    """
    found = False
    for c in range(len(s)):
        volume, old = g.volume[c], s[c]
        predicted = old + (content[c, 0] * y[c, 0] - shift[c]) / volume
        if max(old, predicted) <= packing[0]:
            continue
        before, slope = friction(packing, old)
        kinetic = max(0.0, stiffness[c] - slope) + SOFT
        missed = kinetic * (predicted - old) + friction(packing, predicted)[0] - before - y[c, 0]
        if missed * near[c, 0] <= MISSED * volume:
            continue
        found = True
        most = volume * (predicted - old) + near[c, 0] * y[c, 0]
        low, high = predicted - near[c, 0] * missed / volume, predicted
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            pushed = kinetic * (middle - old) + friction(packing, middle)[0] - before
            if volume * (middle - old) + near[c, 0] * pushed < most:
                low = middle
            else:
                high = middle
        pushed, steep = friction(packing, low)
        pushed += kinetic * (low - old) - before
        content[c, 0] = volume / (kinetic + steep)
        rhs[c, 0] -= shift[c]
        shift[c] = content[c, 0] * pushed - volume * (low - old)
        rhs[c, 0] += shift[c]
    return found


@kernel
def wall_slip(g, solid, edge, eps_max, rho_s, s, theta, g0, mu, slip):
    """Share of the cell's tangential velocity that particles keep at the wall: Johnson and Jackson's law, where the
    shear (pi/6) sqrt(3) specularity rho_s eps_s g0 sqrt(theta) u/eps_max equals mu (u_cell - u)/distance.
    """
    ni = len(g.right)
    for b in range(len(slip)):
        slip[b] = solid.slip[b]
        if slip[b] < 0.0:
            c = g.left[ni + b]
            rub = np.pi * np.sqrt(3.0 * theta[c]) * edge.specularity[b] * rho_s * s[c] * g0[c] / (6.0 * eps_max)
            slide = mu[c] / g.distance[ni + b]
            slip[b] = slide / (slide + rub + TINY) if rub > 0.0 else 1.0


@kernel
def conduct(g, solid, edge, k, theta, grad, corrections, out, coef):
    """Adds the conducted k grad theta . n area [W] of all faces to `out`, its links to `coef`; none through walls."""
    ni = len(g.right)
    for f in range(len(g.left)):
        left = g.left[f]
        coef[f, 0] = 0.0
        if f < ni:
            right = g.right[f]
            mean = 2.0 * k[left] * k[right] / (k[left] + k[right] + TINY)
            coef[f, 0] = mean * g.area[f] / g.distance[f]
            rate = coef[f, 0] * (theta[right] - theta[left])
            if corrections:
                for d in range(len(g.axes)):
                    both = g.share[f] * grad[left, 0, d] + (1.0 - g.share[f]) * grad[right, 0, d]
                    rate += mean * g.area[f] * g.cross[f, d] * both
            out[left, 0] += rate
            out[right, 0] -= rate
        elif solid.kind[f - ni] == GIVEN:
            coef[f, 0] = k[left] * g.area[f] / g.distance[f]
            out[left, 0] += coef[f, 0] * (edge.theta[f - ni] - theta[left])
            if corrections:
                for d in range(len(g.axes)):
                    out[left, 0] += k[left] * g.area[f] * g.cross[f, d] * grad[left, 0, d]


@kernel
def theta_system(
    g, edge, solid, slip, dt, rho_s, eps_max, s, old, g0, sink, pressure, divergence, source, u, rhs, content
):
    """Completes the system for the change of theta: `rhs` holds what is convected and conducted [W].

    sink (nc,) [W s2/m5] : (dissipation + 3 beta theta)/theta; pressure (nc,) [kg/m3] : p_solid/theta; source [W/m3]
    """
    ni = len(g.right)
    for c in range(len(s)):
        compress = pressure[c] * divergence[c]
        rhs[c, 0] += g.volume[c] * (source[c] - (sink[c] + compress) * old[c])
        mass = 1.5 * rho_s * (s[c] + EMPTY) / dt
        content[c, 0] = g.volume[c] * (mass + sink[c] + max(0.0, compress))
        if source[c] < 0.0:
            content[c, 0] -= g.volume[c] * source[c] / (old[c] + TINY)
    for b in range(len(slip)):
        if solid.slip[b] >= 0.0 or solid.kind[b] != WALL:
            continue
        f = ni + b
        c = g.left[f]
        common = g.area[f] * np.pi * np.sqrt(3.0) * rho_s * s[c] * g0[c] * np.sqrt(old[c]) / eps_max
        slide = away = 0.0
        for k in range(len(g.axes)):
            away += (u[c, k] - solid.u[b, k]) * g.normal[f, k]
        for k in range(len(g.axes)):
            slide += (slip[b] * (u[c, k] - solid.u[b, k] - away * g.normal[f, k])) ** 2
        loss = common * (1.0 - edge.restitution[b] ** 2) / 4.0
        rhs[c, 0] += common * edge.specularity[b] * slide / 6.0 - loss * old[c]
        content[c, 0] += loss


@kernel
def adiabatic(g, rho_s, s, theta, pressure, sink, drag):
    """Largest 1/dt [1/s] at which the part of sound that warmer particles make grows: the step follows a compression
    by its heat, and that by the velocity that it drives, so that K dt^2 < (2 + d dt)(2 + b dt) with the rates K of
    both, d of dissipation and b of drag. pressure (nc,) : p_solid/(rho_s theta); sink as in `theta_system`
    """
    links, fastest = np.zeros(len(s)), 0.0
    for f in range(len(g.right)):
        link = g.area[f] / g.distance[f]
        links[g.left[f]] += link
        links[g.right[f]] += link
    for c in range(len(s)):
        if s[c] > FAINT:
            both = 4.0 / 3.0 * theta[c] * (pressure[c] / s[c]) ** 2 * links[c] / g.volume[c]
            d, b = sink[c] / (1.5 * rho_s * s[c]), drag[c] / rho_s
            fastest = max(fastest, 0.25 * (np.sqrt((d - b) ** 2 + 4.0 * both) - d - b))
    return fastest


@kernel
def starved(g, dt, s, old, rhs, low):
    """Marks in `low` the cells where convection alone would make theta negative, and their neighbours; returns whether
    any was not marked before.
    """
    found = False
    for f in range(len(g.left)):
        left = g.left[f]
        right = g.right[f] if f < len(g.right) else left
        for c, other in ((left, right), (right, left)):
            if s[c] * g.volume[c] * old[c] + dt * rhs[c, 0] < 0.0 and not (low[c] and low[other]):
                low[c] = low[other] = True
                found = True
    return found
