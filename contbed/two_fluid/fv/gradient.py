"""Kernels on cell fields: gradients, values at boundaries, reconstruction on faces, convection.

Fields are (nc, m) with m components; `g` is the Geometry of grid.py. Face by face, what leaves the left cell enters the
right one.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import GIVEN, OUTLET, WALL
from contbed.two_fluid.compiled import kernel

FEW, NEVER = 1e-2, 1e-30  # share of the particles of a cell that is few


@kernel
def heard(there, here):
    """How much particles of fraction `here` notice those of fraction `there`: fully, unless those are few."""
    return min(1.0, (there + NEVER) / (FEW * here + NEVER))


@kernel
def widen(g, s, out):
    """Turns the sums of slope times jump in `out` into gradients: each cell solves with its neighbours' jumps, too."""
    own = out.copy()
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        to_left, to_right = heard(s[right], s[left]), heard(s[left], s[right])
        for k in range(out.shape[1]):
            for d in range(out.shape[2]):
                out[left, k, d] += to_left * own[right, k, d]
                out[right, k, d] += to_right * own[left, k, d]
    for c in range(out.shape[0]):
        for k in range(out.shape[1]):
            for d in range(out.shape[2]):
                own[c, k, d] = 0.0
                for e in range(out.shape[2]):
                    own[c, k, d] += g.spread[c, d, e] * out[c, k, e]
    out[:] = own


@kernel
def gradient(g, values, edge, out):
    """Least-squares gradients (nc, m, dim) of `values` with boundary values `edge` (nb, m)."""
    ni, dim = len(g.right), len(g.axes)
    out[:] = 0.0
    for f in range(len(g.left)):
        left = g.left[f]
        for k in range(values.shape[1]):
            if f < ni:
                right = g.right[f]
                jump = values[right, k] - values[left, k]
                for d in range(dim):
                    out[right, k, d] += g.slope_right[f, d] * jump
            else:
                jump = edge[f - ni, k] - values[left, k]
            for d in range(dim):
                out[left, k, d] += g.slope_left[f, d] * jump
    if g.wide:
        widen(g, np.ones(len(values)), out)


@kernel
def gradient_solid(g, s, values, edge, out):
    """The same for a field of the particles: a neighbour with few of them counts as level."""
    ni, dim = len(g.right), len(g.axes)
    out[:] = 0.0
    for f in range(len(g.left)):
        left = g.left[f]
        if f < ni:
            right = g.right[f]
            to_left, to_right = heard(s[right], s[left]), heard(s[left], s[right])
            for k in range(values.shape[1]):
                jump = values[right, k] - values[left, k]
                for d in range(dim):
                    out[left, k, d] += to_left * jump * g.slope_left[f, d]
                    out[right, k, d] += to_right * jump * g.slope_right[f, d]
        else:
            for k in range(values.shape[1]):
                for d in range(dim):
                    out[left, k, d] += (edge[f - ni, k] - values[left, k]) * g.slope_left[f, d]
    if g.wide:
        widen(g, s, out)


@kernel
def gradient_drive(g, h, q, gravity, out, resting):
    """Gradient (nc, 1, dim) of h + q - gravity . x with q = p/rho_s, which is level where particles rest on each other;
    a neighbour without friction, h = 0, counts as level. `resting` (nc,) marks cells that rub, or lie beside one.
    """
    dim = len(g.axes)
    out[:] = 0.0
    for c in range(len(h)):
        resting[c] = h[c] > 0.0
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        resting[left] |= h[right] > 0.0
        resting[right] |= h[left] > 0.0
        if h[left] > 0.0 and h[right] > 0.0:
            jump = h[right] + q[right] - h[left] - q[left]
            for d in range(dim):
                jump -= gravity[d] * (g.arm_left[f, d] - g.arm_right[f, d])
            for d in range(dim):
                out[left, 0, d] += jump * g.slope_left[f, d]
                out[right, 0, d] += jump * g.slope_right[f, d]
    if g.wide:
        widen(g, np.ones(len(h)), out)


@kernel
def edge_velocity(g, side, slip, u, eps, out):
    """Velocity of a phase at the boundary (nb, dim): what walls leave of the cell's, what inlets give."""
    ni, dim = len(g.right), len(g.axes)
    for b in range(len(side.kind)):
        f = ni + b
        c = g.left[f]
        if side.kind[b] == WALL:
            away = 0.0
            for k in range(dim):
                away += (u[c, k] - side.u[b, k]) * g.normal[f, k]
            for k in range(dim):
                along = u[c, k] - side.u[b, k] - away * g.normal[f, k]
                out[b, k] = side.u[b, k] + slip[b] * along
        elif side.kind[b] == GIVEN:
            for k in range(dim):
                out[b, k] = side.flux[b] / eps[c] * g.normal[f, k] if side.pores[b] > 0 else side.u[b, k]
        else:
            for k in range(dim):
                out[b, k] = u[c, k]


@kernel
def increment(slope, along, jump, ahead, limited):
    """Value at a face minus the value of the upwind cell: second order, limited to monotonized central differences.

    `slope` and `along` are the gradient times the way to the face and to the other cell, `jump` the difference to the
    other cell, `ahead` the change of the cell's value in half a step.
    """
    if not limited:
        return slope + ahead
    behind = 2.0 * along - jump
    if behind * jump <= 0.0:
        return 0.0
    part, size, least = slope + ahead, abs(along), 2.0 * min(abs(behind), abs(jump))
    if least < size:
        part *= least / size
    aside = abs(slope - 0.5 * along)  # the middle of the face may lie off the line between the centres
    return min(max(part, min(0.0, jump) - aside), max(0.0, jump) + aside)


@kernel
def half_ahead(dt, u, grad, carrier, lag, out):
    """Change of u (nc, m) in half a step: what is carried now, and the rest `lag` of the last rate of change."""
    for c in range(u.shape[0]):
        for k in range(u.shape[1]):
            rate = lag[c, k]
            for d in range(carrier.shape[1]):
                rate -= carrier[c, d] * grad[c, k, d]
            out[c, k] = 0.5 * dt * rate


@kernel
def momentum(dt, rho, mass, source, force, rhs, content):
    """Turns what is convected, `rhs` (nc, m) [m3/s times u], into forces with the accelerations `source` and `force`.

    mass (nc,) : of the phase over the step [kg/s], which each component gets as its `content`
    """
    for c in range(rhs.shape[0]):
        for k in range(rhs.shape[1]):
            content[c, k] = mass[c]
            rhs[c, k] = rho * rhs[c, k] + dt * mass[c] * (source[c, k] + force[c, k])


@kernel
def convect(g, flux, u, grad, ahead, edge, limited, low, out):
    """Adds -sum over faces of flux (u_face - u_cell) [m3/s times u] to `out`; `flux` (nf,) is a volume flux. Cells
    marked in `low` give their own value to all their faces.
    """
    ni, dim = len(g.right), len(g.axes)
    for f in range(len(g.left)):
        rate = flux[f]
        left = g.left[f]
        inner = f < ni
        right = g.right[f] if inner else left
        forward = rate >= 0.0
        c = left if forward else right
        for k in range(u.shape[1]):
            if inner:
                slope = along = 0.0
                for d in range(dim):
                    if forward:
                        slope += grad[c, k, d] * g.arm_left[f, d]
                        along += grad[c, k, d] * (g.arm_left[f, d] - g.arm_right[f, d])
                    else:
                        slope += grad[c, k, d] * g.arm_right[f, d]
                        along += grad[c, k, d] * (g.arm_right[f, d] - g.arm_left[f, d])
                jump = (u[right, k] - u[left, k]) if forward else (u[left, k] - u[right, k])
                value = u[c, k]
                if not low[c]:
                    value += increment(slope, along, jump, ahead[c, k], limited)
                out[right, k] += rate * (value - u[right, k])
            elif forward:
                slope = 0.0
                for d in range(dim):
                    slope += grad[c, k, d] * g.arm_left[f, d]
                jump = edge[f - ni, k] - u[c, k]
                part = slope + ahead[c, k] if not low[c] else 0.0
                value = u[c, k] + (min(max(part, min(0.0, jump)), max(0.0, jump)) if limited else part)
            else:
                value = edge[f - ni, k]
            out[left, k] -= rate * (value - u[left, k])


@kernel
def spread(g, flux, face, values, net, out):
    """net (nc,) = what leaves by `flux`, and out (nc,) = -sum over faces of flux (face - value)."""
    ni = len(g.right)
    net[:] = 0.0
    out[:] = 0.0
    for f in range(len(flux)):
        left = g.left[f]
        net[left] += flux[f]
        out[left] -= flux[f] * (face[f] - values[left])
        if f < ni:
            right = g.right[f]
            net[right] -= flux[f]
            out[right] += flux[f] * (face[f] - values[right])


@kernel
def on_face(g, f, forward, s, grad, ahead, limited):
    """Solid fraction on an interior face, reconstructed in the cell that the phase comes from."""
    left, right = g.left[f], g.right[f]
    slope = along = 0.0
    if forward:
        for d in range(len(g.axes)):
            slope += grad[left, 0, d] * g.arm_left[f, d]
            along += grad[left, 0, d] * (g.arm_left[f, d] - g.arm_right[f, d])
        return s[left] + increment(slope, along, s[right] - s[left], ahead[left, 0], limited)
    for d in range(len(g.axes)):
        slope += grad[right, 0, d] * g.arm_right[f, d]
        along += grad[right, 0, d] * (g.arm_right[f, d] - g.arm_left[f, d])
    return s[right] + increment(slope, along, s[left] - s[right], ahead[right, 0], limited)


@kernel
def fractions(g, gas, solid, edge, s, grad, ahead, limited, faces):
    """Fractions of both phases on faces: columns 4 and 5 of `faces` (nf, 8) hold the velocities that choose the cell
    they come from, and get the fractions of gas and solids.
    """
    ni = len(g.right)
    for f in range(len(g.left)):
        left = g.left[f]
        if f < ni:
            faces[f, 4] = 1.0 - on_face(g, f, faces[f, 4] >= 0.0, s, grad, ahead, limited)
            forward = faces[f, 5] >= 0.0
            faces[f, 5] = max(0.0, on_face(g, f, forward, s, grad, ahead, limited))
            if limited:
                # an empty cell gives nothing, whatever its slope is on a skewed mesh
                faces[f, 5] = min(faces[f, 5], 2.0 * (s[left] if forward else s[g.right[f]]))
            continue
        b = f - ni
        if gas.kind[b] == OUTLET:
            # gas may come back, without particles
            faces[f, 4] = 1.0 - s[left] if faces[f, 4] > 0.0 else 1.0
            faces[f, 5] = s[left] if faces[f, 5] > 0.0 else 0.0
        else:
            eps = edge.eps_s[b] if solid.kind[b] == GIVEN else s[left]
            faces[f, 4] = 1.0 - eps
            if solid.flux[b] > 0.0:
                # what leaves has the fraction of the cell
                part = ahead[left, 0]
                for d in range(len(g.axes)):
                    part += grad[left, 0, d] * g.arm_left[f, d]
                jump = eps - s[left]
                eps = s[left] + (min(max(part, min(0.0, jump)), max(0.0, jump)) if limited else part)
            faces[f, 5] = eps
