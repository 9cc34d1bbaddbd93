"""Kernels on face velocities: forces and implicit drag on each face, the equation of pressure, cell velocities.

With intrinsic velocities, K = beta/eps_s, a_g = dt beta/(eps_g rho_g) and a_s = dt K/rho_s, the normal velocities on
a face obey

    (1 + a_g) u_g - a_g u_s = H_g + dt (g - grad p/rho_g)
    (1 + a_s) u_s - a_s u_g = H_s + dt (g - grad p/rho_s - grad P/eps_s - grad h)

where H are the convected and sheared velocities, rho_s P is the kinetic and collisional pressure of the particles and
h(eps_s) = integral of d p_friction/(rho_s eps_s): a bed at rest has h + z g constant, on any mesh.

The columns of `faces` (nf, 8): u_g, u_s, their mobilities, fractions of gas and solids, normal H_g, H_s.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import GIVEN, OUTLET
from contbed.two_fluid.compiled import kernel
from contbed.two_fluid.fv.gradient import FEW, NEVER, heard

TINY = 1e-300
UNDERFLOW = 1e-60  # [m/s]
RESOLVED = 0.05  # (N dt)^2 of a buoyancy wave up to which the step follows it
SILENT = 1e-4  # say of a face that hardly a particle reaches
LEAST = 1e-12  # of all faces in the moment: along directions that no face gives, particles keep H


@kernel
def two_phase(first, second, a_g, a_s):
    """Both velocities after implicit drag."""
    scale = 1.0 / (1.0 + a_g + a_s)
    return scale * ((1.0 + a_s) * first + a_g * second), scale * (a_s * first + (1.0 + a_g) * second)


@kernel
def predict(g, gas, solid, edge, dt, gravity, rho, cells, vectors, gradients, corrections, own, faces):
    """Face velocities without the pressure; columns 4 and 5 get them with the last pressure.

    rho : densities of the gas (nc,) and of the solids
    cells : eps_s, K, P, h, p, and whether particles rest in or beside a cell
    vectors : H_g, H_s and the velocities before
    gradients : of H_g, H_s, (p, P, h + p/rho_s - g . x), used with `corrections` on skewed meshes
    own (nf,) : part of u_g that the cells around did not see; kept while the gas crosses a cell, longer where drag
        holds it, or p would be noise that grows as the steps become small
    """
    s, drag, kinetic, friction, p, resting = cells
    h_g, h_s, old_g, old_s = vectors
    grad_g, grad_s, grad_p = gradients
    rho_cell, rho_s = rho
    ni, dim = len(g.right), len(g.axes)
    for f in range(len(g.left)):
        left = g.left[f]
        rho_g = rho_cell[left]
        b = f - ni
        hg = hs = pull = away_p = away_k = away_h = away_s = 0.0
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
                    for k in range(dim):
                        along = g.normal[f, k] * g.skew[f, d]
                        hg += along * (w * grad_g[left, k, d] + (1.0 - w) * grad_g[right, k, d])
                        hs += along * (w * grad_s[left, k, d] + (1.0 - w) * grad_s[right, k, d])
                    away_p += g.cross[f, d] * (w * grad_p[left, 0, d] + (1.0 - w) * grad_p[right, 0, d])
                    away_k += g.cross[f, d] * (w * grad_p[left, 1, d] + (1.0 - w) * grad_p[right, 1, d])
                    away_h += g.cross[f, d] * (w * grad_p[left, 2, d] + (1.0 - w) * grad_p[right, 2, d])
                # the slopes of cells around must not push where there are no particles
                most = (kinetic[left] + kinetic[right]) / g.distance[f]
                away_k = min(max(away_k, -most), most)
                away_s = away_p / rho_s
                if resting[left] or resting[right]:
                    # between two centres the forces have a potential, and particles come to rest where it is level
                    most = 2.0 * min(friction[left], friction[right]) / g.distance[f]
                    away_s = min(max(away_h, -most), most)
                    for k in range(dim):
                        away_s += g.cross[f, k] * gravity[k]
            rho_g += (1.0 - w) * (rho_cell[right] - rho_g)
            mean = w * s[left] + (1.0 - w) * s[right]
            k_face = w * drag[left] + (1.0 - w) * drag[right]
            # with this mean the force of P on both cells together is its jump, as momentum needs
            carried = (1.0 - w) * s[left] + w * s[right] + TINY
            steep = (kinetic[right] - kinetic[left]) / g.distance[f] + away_k
            push = pull - steep / carried - (friction[right] - friction[left]) / g.distance[f]
            drop = (p[right] - p[left]) / g.distance[f]
        elif gas.kind[b] == OUTLET:
            for k in range(dim):
                hg += g.normal[f, k] * h_g[left, k]
                hs += g.normal[f, k] * h_s[left, k]
                pull += g.normal[f, k] * gravity[k]
                if corrections:
                    away_p += g.cross[f, k] * grad_p[left, 0, k]
            away_s = away_p / rho_s
            mean, k_face, push = s[left], drag[left], pull
            drop = (edge.p[b] - p[left]) / g.distance[f]
        else:
            eps = edge.eps_s[b] if solid.kind[b] == GIVEN else s[left]
            faces[f, 6] = faces[f, 0] = gas.flux[b] / (1.0 - eps)
            faces[f, 7] = faces[f, 1] = solid.flux[b] / eps if solid.flux[b] != 0.0 else 0.0
            faces[f, 2] = faces[f, 3] = 0.0
            # where velocities are given, the force is the one that keeps them so; at a wall there is none
            for k in range(dim):
                if gas.kind[b] == GIVEN:
                    faces[f, 6] += g.normal[f, k] * (h_g[left, k] - old_g[left, k])
                if solid.kind[b] == GIVEN:
                    faces[f, 7] += g.normal[f, k] * (h_s[left, k] - old_s[left, k])
            continue
        a_s = dt * k_face / rho_s
        # particles that stay, with none to come after them, do not hold the gas
        crossing = heard(s[left] if hs + dt * push >= 0.0 or b >= 0 else s[g.right[f]], mean)
        a_g = dt * k_face * mean * crossing / ((1.0 - mean) * rho_g)
        hg += (1.0 + a_g) / (1.0 + a_g + dt * abs(hg) / g.distance[f]) * own[f]
        scale = dt / (1.0 + a_g + a_s)
        move_g = scale * ((1.0 + a_s) / rho_g + a_g / rho_s)
        move_s = scale * (a_s / rho_g + (1.0 + a_g) / rho_s)
        u_g, u_s = two_phase(hg + dt * (pull - away_p / rho_g), hs + dt * (push - away_s), a_g, a_s)
        faces[f, 0], faces[f, 1], faces[f, 2], faces[f, 3] = u_g, u_s, move_g, move_s
        faces[f, 4], faces[f, 5], faces[f, 6], faces[f, 7] = u_g - move_g * drop, u_s - move_s * drop, hg, hs


@kernel
def stratify(g, dt, gravity, rho, s, faces):
    """In a closed vessel, where lighter lies on denser: gravity acts on the layers as the volume flux will have moved
    them, as far as a step does not resolve their buoyancy wave. Explicit, a wave of frequency N grows where N dt > 1.
    """
    rho_g, rho_s = rho
    for f in range(len(g.right)):
        left, right, w = g.left[f], g.right[f], g.share[f]
        pull = 0.0
        for k in range(len(g.axes)):
            pull += g.normal[f, k] * gravity[k]
        gas = w * rho_g[left] + (1.0 - w) * rho_g[right]
        mean = w * s[left] + (1.0 - w) * s[right]
        steep = dt * dt * pull * (rho_s - gas) * (s[right] - s[left]) / g.distance[f]
        least = RESOLVED * (gas + mean * (rho_s - gas))
        if steep > least:
            # both phases are slowed alike
            slower = 1.0 - least / steep
            flux = slower * (faces[f, 4] * faces[f, 0] + faces[f, 5] * faces[f, 1])
            mobility = slower * (faces[f, 4] * faces[f, 2] + faces[f, 5] * faces[f, 3])
            for phase in range(2):
                faces[f, phase] -= flux
                faces[f, 2 + phase] -= mobility


@kernel
def assemble(g, gas, solid, edge, faces, coef, rhs):
    """The equation of pressure, sum of coef (nf,) (p - p_neighbour) = rhs (nc,), from the sum of both fluxes; `rhs`
    holds the sources.
    """
    ni = len(g.right)
    for f in range(len(g.left)):
        left = g.left[f]
        if f >= ni and gas.kind[f - ni] != OUTLET:
            coef[f] = 0.0
            rhs[left] -= g.area[f] * (gas.flux[f - ni] + solid.flux[f - ni])
            continue
        flux = g.area[f] * (faces[f, 4] * faces[f, 0] + faces[f, 5] * faces[f, 1])
        coef[f] = g.area[f] * (faces[f, 4] * faces[f, 2] + faces[f, 5] * faces[f, 3]) / g.distance[f]
        rhs[left] -= flux
        if f < ni:
            rhs[g.right[f]] += flux
        else:
            rhs[left] += coef[f] * edge.p[f - ni]


@kernel
def correct(g, gas, solid, edge, p, faces, flux_solid, flux_total, outflow):
    """Face velocities with the pressure; fluxes of the solids and of both phases together [m3/s].

    outflow (nc, 2) [1/s] : rate at which each phase's velocity empties a cell, for the Courant numbers
    """
    ni = len(g.right)
    outflow[:] = 0.0
    for f in range(len(g.left)):
        left = g.left[f]
        area = g.area[f]
        drop = ((p[g.right[f]] if f < ni else edge.p[f - ni]) - p[left]) / g.distance[f]
        u_g = faces[f, 0] - faces[f, 2] * drop
        u_s = faces[f, 1] - faces[f, 3] * drop
        flux_solid[f] = area * faces[f, 5] * u_s
        flux_total[f] = area * (faces[f, 4] * u_g + faces[f, 5] * u_s)
        if f >= ni:
            if gas.kind[f - ni] == OUTLET:
                if u_s < 0.0:
                    # no particles come back: as at a wall
                    flux_solid[f] = u_s = faces[f, 7] = 0.0
            else:
                flux_total[f] = area * (gas.flux[f - ni] + solid.flux[f - ni])
        faces[f, 0], faces[f, 1] = u_g, u_s
        out_g, out_s = area * u_g, area * u_s
        outflow[left, 0] += max(0.0, out_g)
        outflow[left, 1] += max(0.0, out_s)
        if f < ni:
            right = g.right[f]
            outflow[right, 0] -= min(0.0, out_g)
            outflow[right, 1] -= min(0.0, out_s)
    for c in range(len(g.volume)):
        outflow[c, 0] /= g.volume[c]
        outflow[c, 1] /= g.volume[c]


@kernel
def gather_gas(g, faces, grad_new, grad_old, corrections, new, old):
    """Cell vectors (nc, dim) from the normal u_g and H_g of the faces by least squares; exact for linear fields with
    the gradients of both on skewed meshes.
    """
    ni, dim = len(g.right), len(g.axes)
    new[:] = 0.0
    old[:] = 0.0
    for f in range(len(g.left)):
        for side in range(2 if f < ni else 1):
            c = g.left[f] if side == 0 else g.right[f]
            u, h = faces[f, 0], faces[f, 6]
            if corrections:
                for k in range(dim):
                    for d in range(dim):
                        arm = g.normal[f, k] * (g.arm_left[f, d] if side == 0 else g.arm_right[f, d])
                        u -= grad_new[c, k, d] * arm
                        h -= grad_old[c, k, d] * arm
            for k in range(dim):
                n = g.flat[f] * g.normal[f, k]
                new[c, k] += n * u
                old[c, k] += n * h
    first, second = np.empty(dim), np.empty(dim)
    for c in range(len(g.volume)):
        for k in range(dim):
            first[k] = second[k] = 0.0
            for d in range(dim):
                first[k] += g.inverse[c, k, d] * new[c, d]
                second[k] += g.inverse[c, k, d] * old[c, d]
        for k in range(dim):
            new[c, k], old[c, k] = first[k], second[k]


@kernel
def gather_solid(g, faces, s, grad_new, grad_old, corrections, moment, new, old):
    """The same for u_s and H_s; a face that few of a cell's particles reach has little say in their velocity."""
    ni, dim = len(g.right), len(g.axes)
    new[:] = 0.0
    old[:] = 0.0
    moment[:] = 0.0
    for f in range(len(g.left)):
        for side in range(2 if f < ni else 1):
            c = g.left[f] if side == 0 else g.right[f]
            say = min(1.0, (faces[f, 5] + NEVER) / (FEW * s[c] + NEVER))
            weight = g.flat[f] * say if say > SILENT else 0.0
            u, h = faces[f, 1], faces[f, 7]
            if corrections:
                for k in range(dim):
                    for d in range(dim):
                        arm = g.normal[f, k] * (g.arm_left[f, d] if side == 0 else g.arm_right[f, d])
                        u -= grad_new[c, k, d] * arm
                        h -= grad_old[c, k, d] * arm
            for k in range(dim):
                n = weight * g.normal[f, k]
                new[c, k] += n * u
                old[c, k] += n * h
                for d in range(k, dim):
                    moment[c, k, d] += (weight + LEAST * g.flat[f]) * g.normal[f, k] * g.normal[f, d]
    for c in range(len(g.volume)):
        # Cholesky without roots: the moment is small, symmetric and positive
        for i in range(dim):
            for j in range(i + 1, dim):
                factor = moment[c, i, j] / moment[c, i, i]
                for k in range(j, dim):
                    moment[c, j, k] -= factor * moment[c, i, k]
                new[c, j] -= factor * new[c, i]
                old[c, j] -= factor * old[c, i]
        for i in range(dim - 1, -1, -1):
            for k in range(i + 1, dim):
                new[c, i] -= moment[c, i, k] * new[c, k]
                old[c, i] -= moment[c, i, k] * old[c, k]
            new[c, i] /= moment[c, i, i]
            old[c, i] /= moment[c, i, i]


@kernel
def expansion(g, faces, s, u, out):
    """Divergence (nc,) [1/s] of the velocity of the solids, without faces that few of a cell's particles reach."""
    ni, dim = len(g.right), len(g.axes)
    for c in range(len(s)):
        out[c] = u[c, 0] / g.radius[c] if g.radius[c] > 0.0 else 0.0
    for f in range(len(g.left)):
        for side in range(2 if f < ni else 1):
            c = g.left[f] if side == 0 else g.right[f]
            weight = min(1.0, (faces[f, 5] + NEVER) / (FEW * s[c] + NEVER)) * g.area[f] / g.volume[c]
            speed = faces[f, 1]
            for k in range(dim):
                speed -= u[c, k] * g.normal[f, k]
            out[c] += weight * speed if side == 0 else -weight * speed


@kernel
def remember(g, gas, faces, u, grad, corrections, own):
    """own (nf,) = the part of u_g on interior faces and outlets that the gathered cell velocities do not give back."""
    ni, dim = len(g.right), len(g.axes)
    for f in range(len(g.left)):
        own[f] = 0.0
        left = g.left[f]
        if f >= ni and gas.kind[f - ni] != OUTLET:
            continue
        right, w = (g.right[f], g.share[f]) if f < ni else (left, 1.0)
        own[f] = faces[f, 0]
        for k in range(dim):
            own[f] -= g.normal[f, k] * (w * u[left, k] + (1.0 - w) * u[right, k])
            if corrections and f < ni:
                for d in range(dim):
                    along = g.normal[f, k] * g.skew[f, d]
                    own[f] -= along * (w * grad[left, k, d] + (1.0 - w) * grad[right, k, d])


@kernel
def cell_velocities(dt, rho, s, drag, h_g, h_s, mean_g, mean_s, new_g, new_s, force_g, force_s):
    """Cell velocities from the gathered ones: `new`, in place, plus what gathering the normal H leaves of H, which is
    `h - mean`, after drag. The rests of the phases damp without moving each other: in a bed at rest gas that speeds up
    towards the surface would lift particles. The forces [m/s2] are the changes from H over the step.
    """
    rho_g, rho_s = rho
    for c in range(len(s)):
        a_s = dt * drag[c] / rho_s
        a_g = dt * drag[c] * s[c] / ((1.0 - s[c]) * rho_g[c])
        damp_g, damp_s = 1.0 / (1.0 + a_g), (1.0 + a_g) / (1.0 + a_g + a_s)
        for k in range(h_g.shape[1]):
            rest_g, rest_s = damp_g * (h_g[c, k] - mean_g[c, k]), damp_s * (h_s[c, k] - mean_s[c, k])
            # numbers that fade away in a bed at rest would end as slow subnormal ones
            new_g[c, k] = new_g[c, k] + rest_g if abs(new_g[c, k] + rest_g) > UNDERFLOW else 0.0
            new_s[c, k] = new_s[c, k] + rest_s if abs(new_s[c, k] + rest_s) > UNDERFLOW else 0.0
            force_g[c, k] = (new_g[c, k] - h_g[c, k]) / dt
            force_s[c, k] = (new_s[c, k] - h_s[c, k]) / dt
