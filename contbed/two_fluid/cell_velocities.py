"""Cell velocities from the normal velocities of faces, by least squares; the reverse
of the interpolation to faces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.boundary import OUTLET, Edge
from contbed.two_fluid.compiled import UNDERFLOW, Array, inner, kernel
from contbed.two_fluid.face_velocities import Cells, Velocities
from contbed.two_fluid.fv.gradient import neighbour_weight
from contbed.two_fluid.fv.grid import Geometry

# weight of a face [-] below which it is left out of the least squares of a cell's
# particle velocity (test_level_bed_on_triangles_calms_down)
MIN_FACE_WEIGHT = 1e-4
# weight [-] that every face has in the moment, so that it can be inverted: in
# directions without faces the least squares give 0, and add_reconstruction_remainder
# gives H (test_cell_without_particles_on_its_faces)
MIN_MOMENT_WEIGHT = 1e-12


class FaceVelocities(NamedTuple):
    """Normal velocities (nf,) [m/s] of both phases with the pressure, normal H, and
    the solids fraction.
    """

    gas: Array
    solid: Array
    h_gas: Array
    h_solid: Array
    eps_s: Array


class Gathered(NamedTuple):
    """Cell vectors (nc, dim) [m/s] from the face velocities and from the normal H of
    both phases.
    """

    gas: Array
    solid: Array
    h_gas: Array
    h_solid: Array

    @property
    def T(self) -> Gathered:
        """The vectors by component, for kernels over rows."""
        return Gathered(*(part.T for part in self))


@inner
def solid_face_weight(there: float, here: float) -> float:
    """Weight in the least squares of a cell of a face with solids fraction `there`;
    tiny ones are left out.
    """
    share = neighbour_weight(there, here)
    return share if share > MIN_FACE_WEIGHT else 0.0


@inner
def without_slope(
    g: Geometry, f: int, side: int, c: int, grad: Array, u: float
) -> float:
    """Return the normal velocity of a face less what the gradient (nc, dim, dim) of the
    cell c on its left (0) or right (1) adds on the way to it.
    """
    for k in range(len(g.axes)):
        for d in range(len(g.axes)):
            arm = g.arm_left[f, d] if side == 0 else g.arm_right[f, d]
            u -= grad[c, k, d] * (g.normal[f, k] * arm)
    return u


@kernel
def gather_gas(
    g: Geometry,
    faces: FaceVelocities,
    grad_new: Array,
    grad_h: Array,
    corrected: bool,
    out: Gathered,
) -> None:
    """Cell vectors of the gas from the normal u and H of the faces by least squares.

    Exact for linear fields where they are `corrected` with the gradients (nc, dim, dim)
    of both.
    """
    ni, dim = len(g.right), len(g.axes)
    new, old = out.gas, out.h_gas
    new[:] = 0.0
    old[:] = 0.0
    for f in range(len(g.left)):
        for side in range(2 if f < ni else 1):
            c = g.left[f] if side == 0 else g.right[f]
            u, h = faces.gas[f], faces.h_gas[f]
            if corrected:
                u = without_slope(g, f, side, c, grad_new, u)
                h = without_slope(g, f, side, c, grad_h, h)
            for k in range(dim):
                n = g.face_size[f] * g.normal[f, k]
                new[c, k] += n * u
                old[c, k] += n * h
    first, second = np.empty(dim), np.empty(dim)
    for c in range(len(g.volume)):
        for k in range(dim):
            first[k] = second[k] = 0.0
            for d in range(dim):
                first[k] += g.moment_inverse[c, k, d] * new[c, d]
                second[k] += g.moment_inverse[c, k, d] * old[c, d]
        for k in range(dim):
            new[c, k], old[c, k] = first[k], second[k]


@kernel
def gather_solid(
    g: Geometry,
    faces: FaceVelocities,
    s: Array,
    grad_new: Array,
    grad_h: Array,
    corrected: bool,
    out: Gathered,
) -> None:
    """Cell vectors of the particles as `gather_gas`; a face with far fewer particles
    than the cell has less weight.
    """
    ni, dim = len(g.right), len(g.axes)
    new, old = out.solid, out.h_solid
    moment = np.zeros((len(s), dim, dim))
    new[:] = 0.0
    old[:] = 0.0
    for f in range(len(g.left)):
        for side in range(2 if f < ni else 1):
            c = g.left[f] if side == 0 else g.right[f]
            weight = g.face_size[f] * solid_face_weight(faces.eps_s[f], s[c])
            u, h = faces.solid[f], faces.h_solid[f]
            if corrected:
                u = without_slope(g, f, side, c, grad_new, u)
                h = without_slope(g, f, side, c, grad_h, h)
            for k in range(dim):
                n = weight * g.normal[f, k]
                new[c, k] += n * u
                old[c, k] += n * h
                for d in range(k, dim):
                    moment[c, k, d] += (
                        (weight + MIN_MOMENT_WEIGHT * g.face_size[f])
                        * g.normal[f, k]
                        * g.normal[f, d]
                    )
    for c in range(len(g.volume)):
        # Cholesky's decomposition without roots: the moment is small, symmetric and
        # positive
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
def divergence_solid(
    g: Geometry, faces: FaceVelocities, s: Array, u: Array, out: Array
) -> None:
    """Divergence (nc,) [1/s] of the velocity of the solids, weighted as in
    `gather_solid`.
    """
    ni, dim = len(g.right), len(g.axes)
    for c in range(len(s)):
        out[c] = u[c, 0] / g.radius[c] if g.radius[c] > 0.0 else 0.0
    for f in range(len(g.left)):
        for side in range(2 if f < ni else 1):
            c = g.left[f] if side == 0 else g.right[f]
            weight = neighbour_weight(faces.eps_s[f], s[c]) * g.area[f] / g.volume[c]
            speed = faces.solid[f]
            for k in range(dim):
                speed -= u[c, k] * g.normal[f, k]
            out[c] += weight * speed if side == 0 else -weight * speed


@kernel
def face_residual(
    g: Geometry, edge: Edge, face: Array, u: Array, grad: Array, out: Array
) -> None:
    """Set the Rhie-Chow residual `out` (nf,) [m/s]: normal gas velocity less the
    interpolated cell velocity.

    It is zero on boundary faces other than outlets.

    u (nc, dim) [m/s] are the cell velocities, `grad` (nc, dim, dim) their gradients,
    used on skewed grids.
    """
    ni, dim = len(g.right), len(g.axes)
    for f in range(len(g.left)):
        out[f] = 0.0
        left = g.left[f]
        if f >= ni and edge.gas.kind[f - ni] != OUTLET:
            continue
        right, w = (g.right[f], g.weight[f]) if f < ni else (left, 1.0)
        out[f] = face[f]
        for k in range(dim):
            out[f] -= g.normal[f, k] * (w * u[left, k] + (1.0 - w) * u[right, k])
            if g.skewed and f < ni:
                for d in range(dim):
                    along = g.normal[f, k] * g.skew[f, d]
                    out[f] -= along * (
                        w * grad[left, k, d] + (1.0 - w) * grad[right, k, d]
                    )


@kernel
def add_reconstruction_remainder(
    begin: int,
    end: int,
    dt: float,
    cells: Cells,
    velocities: Velocities,
    gathered: Gathered,
    force_gas: Array,
    force_solid: Array,
) -> None:
    """Add to the cell velocities, in place, the remainder of H that interpolation and
    least squares lose.

    Drag damps the remainder of each phase but couples it not to the other phase: in a
    bed at rest, the gas that speeds up towards the surface would lift particles. The
    forces (nc, dim) [m/s2] are (velocity - H)/dt.
    """
    s = cells.eps_s
    for k in range(velocities.h_gas.shape[1]):
        h_g, h_s, old_g, old_s = (
            velocities.h_gas[:, k],
            velocities.h_solid[:, k],
            gathered.h_gas[:, k],
            gathered.h_solid[:, k],
        )
        new_g, new_s, force_g, force_s = (
            gathered.gas[:, k],
            gathered.solid[:, k],
            force_gas[:, k],
            force_solid[:, k],
        )
        for c in range(np.uint64(begin), np.uint64(end)):
            a_s = dt * cells.drag[c] / cells.rho_solid
            a_g = dt * cells.drag[c] * s[c] / ((1.0 - s[c]) * cells.rho_gas[c])
            gas = new_g[c] + (h_g[c] - old_g[c]) / (1.0 + a_g)
            solid = new_s[c] + (1.0 + a_g) / (1.0 + a_g + a_s) * (h_s[c] - old_s[c])
            new_g[c] = gas = gas if abs(gas) > UNDERFLOW else 0.0
            new_s[c] = solid = solid if abs(solid) > UNDERFLOW else 0.0
            force_g[c], force_s[c] = (gas - h_g[c]) / dt, (solid - h_s[c]) / dt
