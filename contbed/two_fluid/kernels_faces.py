"""Kernels on face velocities: forces and implicit drag on each face, the equation of pressure, cell velocities.

With intrinsic velocities, K = beta/eps_s, a_g = dt beta/(eps_g rho_g) and a_s = dt K/rho_s, the normal velocities on
a face obey

    (1 + a_g) u_g - a_g u_s = H_g + dt (g - grad p/rho_g)
    (1 + a_s) u_s - a_s u_g = H_s + dt (g - grad p/rho_s - grad P/eps_s - grad h)

where H are the convected and sheared velocities, rho_s P is the kinetic and collisional pressure of the particles and
h(eps_s) = integral of d p_friction/(rho_s eps_s): a bed at rest has h + z g constant, on any mesh.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from contbed.two_fluid.boundary import GIVEN, OUTLET
from contbed.two_fluid.kernels_fields import increment

TINY = 1e-300


@njit(cache=True)
def two_phase(first, second, a_g, a_s):
    """Both velocities after implicit drag."""
    scale = 1.0 / (1.0 + a_g + a_s)
    return scale * ((1.0 + a_s) * first + a_g * second), scale * (a_s * first + (1.0 + a_g) * second)


@njit(cache=True)
def predict(g, gas, solid, edge, dt, gravity, rho, cells, vectors, gradients, corrections, limited, faces, coef, rhs):
    """Face velocities before the pressure, fractions on faces, and the equation of pressure.

    rho : densities of gas and solid
    cells : eps_s, change of eps_s in half a step, K, P, h, p
    vectors : H_g, H_s and the velocities before
    gradients : of eps_s, H_g, H_s, (p, P, h)
    corrections : whether the mesh is skewed
    faces (nf, 8) : u_g, u_s without pressure, their mobilities, fractions of gas and solid, normal H_g, H_s
    coef (nf,), rhs (nc,) : of the pressure equation sum coef (p - p_neighbour) = rhs
    """
    s, ahead, drag, kinetic, friction, p = cells
    h_g, h_s, old_g, old_s = vectors
    grad_s, grad_g_old, grad_s_old, grad_p = gradients
    rho_g, rho_s = rho
    ni, dim = len(g.right), len(g.axes)
    for f in range(len(g.left)):
        left = g.left[f]
        b = f - ni
        if b >= 0 and gas.kind[b] != OUTLET:
            open_gas = gas.flux[b]
            eps = edge.eps_s[b] if solid.kind[b] == GIVEN else s[left]
            faces[f, 4], faces[f, 5] = 1.0 - eps, eps
            faces[f, 6] = faces[f, 0] = open_gas / (1.0 - eps)
            faces[f, 7] = faces[f, 1] = solid.flux[b] / eps if solid.kind[b] == GIVEN and eps > 0.0 else 0.0
            # where velocities are given, the force is the one that keeps them so; at a wall there is none
            for k in range(dim):
                if gas.kind[b] == GIVEN:
                    faces[f, 6] += g.normal[f, k] * (h_g[left, k] - old_g[left, k])
                if solid.kind[b] == GIVEN:
                    faces[f, 7] += g.normal[f, k] * (h_s[left, k] - old_s[left, k])
            if solid.flux[b] > 0.0:
                # what leaves has the fraction of the cell
                part = ahead[left]
                for d in range(dim):
                    part += grad_s[left, 0, d] * g.arm_left[f, d]
                jump = edge.eps_s[b] - s[left]
                faces[f, 5] = s[left] + (min(max(part, min(0.0, jump)), max(0.0, jump)) if limited else part)
            faces[f, 2] = faces[f, 3] = coef[f] = 0.0
            rhs[left] -= g.area[f] * (open_gas + solid.flux[b])
            continue
        hg = hs = pull = away_p = away_k = away_h = 0.0
        if b < 0:
            right = g.right[f]
            w = g.share[f]
            for k in range(dim):
                n = g.normal[f, k]
                hg += n * (w * h_g[left, k] + (1.0 - w) * h_g[right, k])
                hs += n * (w * h_s[left, k] + (1.0 - w) * h_s[right, k])
                pull += n * gravity[k]
                if corrections:
                    for d in range(dim):
                        both = w * grad_g_old[left, k, d] + (1.0 - w) * grad_g_old[right, k, d]
                        hg += n * both * g.skew[f, d]
                        both = w * grad_s_old[left, k, d] + (1.0 - w) * grad_s_old[right, k, d]
                        hs += n * both * g.skew[f, d]
            if corrections:
                for d in range(dim):
                    away_p += g.cross[f, d] * (w * grad_p[left, 0, d] + (1.0 - w) * grad_p[right, 0, d])
                    away_k += g.cross[f, d] * (w * grad_p[left, 1, d] + (1.0 - w) * grad_p[right, 1, d])
                    away_h += g.cross[f, d] * (w * grad_p[left, 2, d] + (1.0 - w) * grad_p[right, 2, d])
            mean = w * s[left] + (1.0 - w) * s[right]
            k_face = w * drag[left] + (1.0 - w) * drag[right]
            # with this mean the force of P on both cells together is its jump, as momentum needs
            carried = (1.0 - w) * s[left] + w * s[right] + TINY
            steep = (kinetic[right] - kinetic[left]) / g.distance[f] + away_k
            push = pull - steep / carried - (friction[right] - friction[left]) / g.distance[f] - away_h
            p_other = p[right]
        else:
            right = left
            for k in range(dim):
                hg += g.normal[f, k] * h_g[left, k]
                hs += g.normal[f, k] * h_s[left, k]
                pull += g.normal[f, k] * gravity[k]
                if corrections:
                    away_p += g.cross[f, k] * grad_p[left, 0, k]
            mean, k_face, push, p_other = s[left], drag[left], pull, edge.p[b]
        a_s = dt * k_face / rho_s
        a_g = dt * k_face * mean / ((1.0 - mean) * rho_g)
        scale = dt / (1.0 + a_g + a_s)
        move_g = scale * ((1.0 + a_s) / rho_g + a_g / rho_s)
        move_s = scale * (a_s / rho_g + (1.0 + a_g) / rho_s)
        u_g, u_s = two_phase(hg + dt * pull, hs + dt * push, a_g, a_s)
        u_g -= move_g * away_p
        u_s -= move_s * away_p
        drop = (p_other - p[left]) / g.distance[f]
        if b < 0:
            eps_s = on_face(g, f, u_s - move_s * drop >= 0.0, s, grad_s, ahead, limited)
            eps_g = 1.0 - on_face(g, f, u_g - move_g * drop >= 0.0, s, grad_s, ahead, limited)
        else:
            eps_s = s[left] if u_s - move_s * drop > 0.0 else 0.0
            eps_g = 1.0 - s[left] if u_g - move_g * drop > 0.0 else 1.0
        faces[f, 0], faces[f, 1], faces[f, 2], faces[f, 3] = u_g, u_s, move_g, move_s
        faces[f, 4], faces[f, 5], faces[f, 6], faces[f, 7] = eps_g, eps_s, hg, hs
        flux = g.area[f] * (eps_g * u_g + eps_s * u_s)
        coef[f] = g.area[f] * (eps_g * move_g + eps_s * move_s) / g.distance[f]
        rhs[left] -= flux
        if b < 0:
            rhs[right] += flux
        else:
            rhs[left] += coef[f] * edge.p[b]


@njit(cache=True)
def on_face(g, f, forward, s, grad, ahead, limited):
    """Solid fraction on an interior face, reconstructed in the cell that the phase comes from."""
    left, right = g.left[f], g.right[f]
    slope = along = 0.0
    if forward:
        for d in range(len(g.axes)):
            slope += grad[left, 0, d] * g.arm_left[f, d]
            along += grad[left, 0, d] * (g.arm_left[f, d] - g.arm_right[f, d])
        return s[left] + increment(slope, along, s[right] - s[left], ahead[left], limited)
    for d in range(len(g.axes)):
        slope += grad[right, 0, d] * g.arm_right[f, d]
        along += grad[right, 0, d] * (g.arm_right[f, d] - g.arm_left[f, d])
    return s[right] + increment(slope, along, s[left] - s[right], ahead[right], limited)


@njit(cache=True)
def correct(g, gas, solid, edge, p, faces, coef, flux_solid, flux_total, outflow, divergence):
    """Face velocities with the pressure; fluxes of the solids and of both phases together [m3/s].

    outflow (nc, 2) [1/s] : rate at which each phase's velocity empties a cell, for the Courant numbers
    divergence (nc,) [1/s] : of the velocity of the solids
    """
    ni = len(g.right)
    outflow[:] = 0.0
    divergence[:] = 0.0
    for f in range(len(g.left)):
        left = g.left[f]
        area = g.area[f]
        if f < ni:
            right = g.right[f]
            drop = (p[right] - p[left]) / g.distance[f]
        else:
            drop = (edge.p[f - ni] - p[left]) / g.distance[f]
        faces[f, 0] -= faces[f, 2] * drop
        faces[f, 1] -= faces[f, 3] * drop
        u_g, u_s = faces[f, 0], faces[f, 1]
        if f >= ni and gas.kind[f - ni] == OUTLET:
            flux_solid[f] = max(0.0, area * faces[f, 5] * u_s)
            flux_total[f] = area * (faces[f, 4] * u_g + faces[f, 5] * u_s)
            if u_s < 0.0:
                faces[f, 1] = u_s = 0.0
        elif f >= ni:
            flux_solid[f] = area * faces[f, 5] * u_s
            flux_total[f] = area * (gas.flux[f - ni] + solid.flux[f - ni])
        else:
            flux_solid[f] = area * faces[f, 5] * u_s
            flux_total[f] = area * (faces[f, 4] * u_g + faces[f, 5] * u_s)
        outflow[left, 0] += max(0.0, area * u_g)
        outflow[left, 1] += max(0.0, area * u_s)
        divergence[left] += area * u_s
        if f < ni:
            outflow[right, 0] -= min(0.0, area * u_g)
            outflow[right, 1] -= min(0.0, area * u_s)
            divergence[right] -= area * u_s
    for c in range(len(g.volume)):
        outflow[c, 0] /= g.volume[c]
        outflow[c, 1] /= g.volume[c]
        divergence[c] /= g.volume[c]


@njit(cache=True)
def gather(g, faces, column, weight, grad, corrections, out):
    """Cell vectors (nc, dim) from the normal components in a column of `faces`, least squares weighted with `weight`
    (nf,) times the size of the face; exact for linear fields with the gradient `grad` on skewed meshes.
    """
    ni, dim = len(g.right), len(g.axes)
    moment = np.zeros((len(g.volume), dim, dim))
    out[:] = 0.0
    for f in range(len(g.left)):
        w = weight[f] * g.flat[f]
        for side in range(2 if f < ni else 1):
            c = g.left[f] if side == 0 else g.right[f]
            value = faces[f, column]
            if corrections:
                for k in range(dim):
                    for d in range(dim):
                        arm = g.arm_left[f, d] if side == 0 else g.arm_right[f, d]
                        value -= g.normal[f, k] * grad[c, k, d] * arm
            for k in range(dim):
                out[c, k] += w * value * g.normal[f, k]
                for d in range(dim):
                    moment[c, k, d] += w * g.normal[f, k] * g.normal[f, d]
    for c in range(len(g.volume)):
        solve_small(moment[c], out[c], dim)


@njit(cache=True)
def solve_small(a, b, dim):
    """b = a^-1 b for a symmetric positive matrix of 1 to 3 rows."""
    for i in range(dim):
        for j in range(i + 1, dim):
            factor = a[j, i] / a[i, i]
            for k in range(i, dim):
                a[j, k] -= factor * a[i, k]
            b[j] -= factor * b[i]
    for i in range(dim - 1, -1, -1):
        for k in range(i + 1, dim):
            b[i] -= a[i, k] * b[k]
        b[i] /= a[i, i]


@njit(cache=True)
def presence(faces, out):
    """Weight of each face in the velocity of the particles: a face that no particles reach has no say in it."""
    for f in range(len(out)):
        out[f] = (faces[f, 5] + 1e-18) / (faces[f, 5] + 1e-7)


@njit(cache=True)
def cell_velocities(dt, rho, s, drag, h_g, h_s, mean_g, mean_s, new_g, new_s):
    """Cell velocities from the gathered face values: `new` (gathered velocities, in place) plus what gathering the
    normal H leaves of H, `h - mean`, after implicit drag.
    """
    rho_g, rho_s = rho
    for c in range(len(s)):
        a_s = dt * drag[c] / rho_s
        a_g = dt * drag[c] * s[c] / ((1.0 - s[c]) * rho_g)
        for k in range(h_g.shape[1]):
            left_g, left_s = two_phase(h_g[c, k] - mean_g[c, k], h_s[c, k] - mean_s[c, k], a_g, a_s)
            new_g[c, k] += left_g
            new_s[c, k] += left_s
