"""MUSCL reconstruction of cell fields on faces, and convection with it; `g` is the
`Geometry` of grid.py.

A face value is that of the upwind cell plus a limited increment (van Leer 1979, J.
Comput. Phys. 32, 101-136), taken half a step ahead as in the MUSCL-Hancock scheme (van
Leer 1984, SIAM J. Sci. Stat. Comput. 5, 1-20).
"""

from __future__ import annotations

from typing import NamedTuple

from contbed.two_fluid.compiled import Array, Flags, inner, kernel
from contbed.two_fluid.fv.grid import Geometry


class Reconstruction(NamedTuple):
    """What face values are made of.

    A field (nc, m), its gradients (nc, m, dim), its change in half a step (nc, m), its
    boundary values (nb, m), the cells (nc,) that give their own value to all faces, and
    whether increments are limited.
    """

    values: Array
    gradient: Array
    half_step: Array
    edge: Array
    first_order: Flags
    limited: bool

    @property
    def T(self) -> Reconstruction:
        """The field by component, for kernels over rows."""
        return self._replace(
            values=self.values.T, gradient=self.gradient.T, half_step=self.half_step.T
        )


@kernel
def limited_increment(
    slope: float, along: float, jump: float, half_step: float, limited: bool
) -> float:
    """Value at a face minus the value of the upwind cell: second order, with the
    monotonized central limiter.

    `slope` and `along` are the gradient times the way to the face and to the other
    cell, `jump` the difference to the other cell, `half_step` the change of the cell's
    value in half a step. The value behind the upwind cell is extrapolated, 2
    along - jump (Darwish and Moukalled 2003, Int. J. Heat Mass Transfer 46, 599-611).
    """
    if not limited:
        return slope + half_step
    behind = 2.0 * along - jump
    if behind * jump <= 0.0:
        return 0.0
    part, size, least = slope + half_step, abs(along), 2.0 * min(abs(behind), abs(jump))
    if least < size:
        part *= least / size
    # the middle of the face may lie off the line between the centres
    aside = abs(slope - 0.5 * along)
    return min(max(part, min(0.0, jump) - aside), max(0.0, jump) + aside)


@kernel
def predictor_half_step(
    dt: float, u: Array, grad: Array, carrier: Array, rate: Array, out: Array
) -> None:
    """Set the change `out` of u (nc, m) in half a step.

    It is convected by the velocity `carrier` (nc, dim), and has the last `rate` of
    change without convection.
    """
    for c in range(u.shape[0]):
        for k in range(u.shape[1]):
            total = rate[c, k]
            for d in range(carrier.shape[1]):
                total -= carrier[c, d] * grad[c, k, d]
            out[c, k] = 0.5 * dt * total


@kernel
def convect(g: Geometry, flux: Array, field: Reconstruction, out: Array) -> None:
    """Add -sum over faces of flux (u_face - u_cell) [m3/s times u] to `out` (nc, m);
    `flux` (nf,) is a volume flux.
    """
    ni = len(g.right)
    # taken out of the loop, where each would be counted as a reference
    u, grad, half_step = field.values, field.gradient, field.half_step
    first_order, limited = field.first_order, field.limited
    for f in range(ni):
        rate, left, right = flux[f], g.left[f], g.right[f]
        forward = rate >= 0.0
        c = left if forward else right
        for k in range(u.shape[1]):
            value = u[c, k]
            if not first_order[c]:
                value = face_value(g, f, k, forward, u, grad, half_step, limited)
            out[right, k] += rate * (value - u[right, k])
            out[left, k] -= rate * (value - u[left, k])
    convect_at_boundary(g, flux, field, out)


@inner
def convect_at_boundary(
    g: Geometry, flux: Array, field: Reconstruction, out: Array
) -> None:
    """Add what crosses the boundary, see `convect`."""
    u, grad, half_step, edge = field.values, field.gradient, field.half_step, field.edge
    first_order, limited, ni = field.first_order, field.limited, len(g.right)
    for f in range(g.edge_from, g.edge_to):
        rate, c = flux[f], g.left[f]
        for k in range(u.shape[1]):
            value = edge[f - ni, k]
            if rate >= 0.0:
                value = (
                    u[c, k]
                    if first_order[c]
                    else value_that_leaves(g, f, k, u, grad, half_step, value, limited)
                )
            out[c, k] -= rate * (value - u[c, k])


@inner
def value_that_leaves(
    g: Geometry,
    f: int,
    k: int,
    values: Array,
    grad: Array,
    half_step: Array,
    given: float,
    limited: bool,
) -> float:
    """Component k of a field on the boundary face f that the flow leaves through,
    between the value of the cell and the `given` one of the face where it is limited.
    """
    c = g.left[f]
    jump, part = given - values[c, k], half_step[c, k]
    for d in range(len(g.axes)):
        part += grad[c, k, d] * g.arm_left[f, d]
    if limited:
        part = min(max(part, min(0.0, jump)), max(0.0, jump))
    return float(values[c, k] + part)


@inner
def face_value(
    g: Geometry,
    f: int,
    k: int,
    forward: bool,
    values: Array,
    grad: Array,
    half_step: Array,
    limited: bool,
) -> float:
    """Component k of a field on the interior face f, reconstructed in the cell
    upwind.
    """
    here, there = (g.left[f], g.right[f]) if forward else (g.right[f], g.left[f])
    slope = along = 0.0
    for d in range(len(g.axes)):
        left, right = g.arm_left[f, d], g.arm_right[f, d]
        arm, way = (left, left - right) if forward else (right, right - left)
        slope += grad[here, k, d] * arm
        along += grad[here, k, d] * way
    jump, aside = values[there, k] - values[here, k], 0.0
    if g.skewed and values.shape[1] > 1:
        # the middle of the face lies off the line between the centres, along which the
        # limiter acts; fractions and temperatures stay within their bounds without it
        for d in range(len(g.axes)):
            aside += grad[here, k, d] * g.skew[f, d]
    increment = limited_increment(
        slope - aside, along, jump, half_step[here, k], limited
    )
    return float(values[here, k] + (increment + aside))


@kernel
def face_values(g: Geometry, flux: Array, field: Reconstruction, out: Array) -> None:
    """Values `out` (nf,) that `flux` (nf,) carries; what leaves through the boundary
    has the value of the cell.
    """
    ni = len(g.right)
    values, grad, half_step, edge = (
        field.values,
        field.gradient,
        field.half_step,
        field.edge,
    )
    first_order, limited = field.first_order, field.limited
    for f in range(len(flux)):
        forward = flux[f] >= 0.0
        if f >= ni:
            out[f] = values[g.left[f], 0] if forward else edge[f - ni, 0]
            continue
        c = g.left[f] if forward else g.right[f]
        if first_order[c]:
            out[f] = values[c, 0]
        else:
            out[f] = face_value(g, f, 0, forward, values, grad, half_step, limited)


@kernel
def divergence(
    g: Geometry, flux: Array, face: Array, values: Array, net: Array, out: Array
) -> None:
    """Sum `net` (nc,) of the `flux` (nf,) that leaves a cell, and `out` (nc,) = -sum
    of flux (face - value).
    """
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
