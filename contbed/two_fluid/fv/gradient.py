"""Least-squares gradients of cell fields (nc, m) with m components, on the `Geometry` g
of grid.py.

The gradients of Muzaferija and Gosman (1997, J. Comput. Phys. 138, 766-787) with
weights 1/distance^2: exact for linear fields. On skewed grids a cell solves together
with its neighbours, as the few faces of a flat cell give noise.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.compiled import Array, Flags, inner, kernel
from contbed.two_fluid.fv.grid import Geometry

# ratio of two solids fractions [-] below which the weight of the smaller one falls with
# the ratio (test_level_bed_on_triangles_calms_down)
FEW_PARTICLES = 1e-2
# solids fraction [-] above which the particles of a cell bind the length of steps
# (test_few_particles_do_not_bind_the_step)
MIN_BINDING_FRACTION = 1e-6
NO_PARTICLES = 1e-30  # [-] solids fraction that makes the ratio of two empty cells 1


@inner
def neighbour_weight(there: float, here: float) -> float:
    """Weight of a neighbour of solids fraction `there` for particles of fraction
    `here`: 1 unless those are few.
    """
    return min(1.0, (there + NO_PARTICLES) / (FEW_PARTICLES * here + NO_PARTICLES))


@inner
def _extend_stencil(g: Geometry, s: Array, out: Array) -> None:
    """Turn the least-squares right-hand sides in `out` into gradients over a cell
    and its neighbours.
    """
    sums = out.copy()
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        to_left, to_right = (
            neighbour_weight(s[right], s[left]),
            neighbour_weight(s[left], s[right]),
        )
        for k in range(out.shape[1]):
            for d in range(out.shape[2]):
                out[left, k, d] += to_left * sums[right, k, d]
                out[right, k, d] += to_right * sums[left, k, d]
    for c in range(out.shape[0]):
        for k in range(out.shape[1]):
            for d in range(out.shape[2]):
                sums[c, k, d] = 0.0
                for e in range(out.shape[2]):
                    sums[c, k, d] += g.gradient_inverse[c, d, e] * out[c, k, e]
    # one by one: to assign an array makes the compiler build numba's functions of
    # texts, for the error of its shapes
    for c in range(out.shape[0]):
        for k in range(out.shape[1]):
            for d in range(out.shape[2]):
                out[c, k, d] = sums[c, k, d]


@inner
def add_boundary_gradient(g: Geometry, values: Array, edge: Array, out: Array) -> None:
    """Add the jumps from the cells to the boundary values `edge` (nb, m)."""
    ni = len(g.right)
    for f in range(g.edge_from, g.edge_to):
        left = g.left[f]
        for k in range(values.shape[1]):
            for d in range(len(g.axes)):
                out[left, k, d] += g.slope_left[f, d] * (
                    edge[f - ni, k] - values[left, k]
                )


@kernel
def gradient(g: Geometry, values: Array, edge: Array, out: Array) -> None:
    """Least-squares gradients `out` (nc, m, dim) of `values` (nc, m) with boundary
    values `edge` (nb, m).
    """
    dim = len(g.axes)
    out[:] = 0.0
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        for k in range(values.shape[1]):
            jump = values[right, k] - values[left, k]
            for d in range(dim):
                out[right, k, d] += g.slope_right[f, d] * jump
                out[left, k, d] += g.slope_left[f, d] * jump
    add_boundary_gradient(g, values, edge, out)
    if g.skewed:
        _extend_stencil(g, np.ones(len(values)), out)


@kernel
def gradient_solid(
    g: Geometry, s: Array, values: Array, edge: Array, out: Array
) -> None:
    """Set the gradients `out` of a field of the particles with solids fraction s (nc,).

    A neighbour with far fewer particles has less weight: where it has none, its
    difference counts as zero.
    """
    dim = len(g.axes)
    out[:] = 0.0
    for f in range(len(g.right)):
        left, right = g.left[f], g.right[f]
        to_left, to_right = (
            neighbour_weight(s[right], s[left]),
            neighbour_weight(s[left], s[right]),
        )
        for k in range(values.shape[1]):
            jump = values[right, k] - values[left, k]
            for d in range(dim):
                out[left, k, d] += to_left * jump * g.slope_left[f, d]
                out[right, k, d] += to_right * jump * g.slope_right[f, d]
    add_boundary_gradient(g, values, edge, out)
    if g.skewed:
        _extend_stencil(g, s, out)


@kernel
def gradient_rest_potential(
    g: Geometry,
    h: Array,
    q: Array,
    gravity: Array,
    force: Array,
    out: Array,
    resting: Flags,
) -> None:
    """Gradient `out` (nc, 1, dim) of h + q - gravity . x with the friction potential h
    and q = p/rho_s [m2/s2].

    Where particles rest on each other it is the `force` (nc, dim) [m/s2] of the gas
    that passes them, uniform without gas: least squares act on what the jumps have
    beside that of the force, which is added again, so that its curvature is no slope to
    them. The difference to a neighbour without friction, h = 0, counts as zero.
    `resting` (nc,) marks the cells with friction, and their neighbours.
    """
    dim = len(g.axes)
    out[:] = 0.0
    for c in range(len(h)):
        resting[c] = h[c] > 0.0
    for f in range(len(g.right)):
        left, right, w = g.left[f], g.right[f], g.weight[f]
        resting[left] |= h[right] > 0.0
        resting[right] |= h[left] > 0.0
        if h[left] > 0.0 and h[right] > 0.0:
            jump = h[right] + q[right] - h[left] - q[left]
            for d in range(dim):
                mean = w * force[left, d] + (1.0 - w) * force[right, d]
                jump -= (gravity[d] + mean) * (g.arm_left[f, d] - g.arm_right[f, d])
            for d in range(dim):
                out[left, 0, d] += jump * g.slope_left[f, d]
                out[right, 0, d] += jump * g.slope_right[f, d]
    if g.skewed:
        _extend_stencil(g, np.ones(len(h)), out)
    for c in range(len(h)):
        if h[c] > 0.0:
            for d in range(dim):
                out[c, 0, d] += force[c, d]
