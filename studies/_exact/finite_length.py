"""Exact steady 1-D temperatures of a bed of finite length: two energy equations with
constant coefficients.

    flux_fluid f' = d_fluid f'' + d_cross s'' + ha (s - f)
    flux_solid s' = d_cross f'' + d_solid s'' - ha (s - f)

x [m] runs along the fluid flow; f and s [-] are the fluid and solid temperature, scaled
so that the fluid enters at 0 and the solid at 1. flux_fluid = (rho c_p)_f u_D > 0 and
flux_solid = (rho c_p)_s u_s [W/m2/K], with superficial velocities; flux_solid < 0 is
counter-current. d_fluid = phi k_f + dispersion, d_solid = (1 - phi) k_s and d_cross
(tortuosity) [W/m/K] form a symmetric matrix, positive definite unless d_cross = 0: then
d_fluid, d_solid may vanish. ha > 0 [W/m3/K] is the volumetric exchange coefficient.

Solutions are sums of v exp(l x), where l = 0 or a root of (d_f d_s - d_x^2) l^3 - (d_f
C_s + C_f d_s) l^2 + (C_f C_s - ha (d_f + d_s + 2 d_x)) l + ha (C_f + C_s) = 0
(C = flux). All roots are real: the matrix of the quadratic eigenvalue problem is
symmetric and its discriminant is never negative.

Source: Pivem and de Lemos (2012), doi:10.1016/j.ijheatmasstransfer.2011.11.047, Eqs.
    11, 12, 28-35.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import factorial

from contbed.arrays import Array
from studies._exact.modes import rates

Pair = tuple[Array, Array]


def finite_length(
    x: ArrayLike,
    length: float,
    flux_fluid: float,
    flux_solid: float,
    d_fluid: float,
    d_solid: float,
    ha: float,
    d_cross: float = 0.0,
    derivative: int = 0,
) -> Pair:
    """Return f(x) and s(x), or derivatives of that order [1/m^order], on
    0 <= x <= length [m], in the shape of x.

    f(0) = 0 and f'(L) = 0; s = 1 at the inlet of the solid and s' = 0 at its outlet.
    The inlet of the solid is at 0 for flux_solid >= 0 and at L for flux_solid < 0. A
    phase without conduction has no outlet condition, a solid that neither moves nor
    conducts has none at all. Rates closer than 1/L share divided differences of exp(l
    x) instead of exponentials, so balanced (l = 0 twice), nearly balanced and
    conduction-dominated beds keep full accuracy.
    """
    nodes = length * np.append(
        rates(flux_fluid, flux_solid, d_fluid, d_solid, ha, d_cross), 0.0
    )
    nodes.sort()
    clusters = np.split(nodes, np.flatnonzero(np.diff(nodes) >= 1.0) + 1)
    fluxes = (flux_fluid / length, flux_solid / length)
    scaled = (
        *fluxes,
        d_fluid / length**2,
        d_solid / length**2,
        ha,
        d_cross / length**2,
    )

    def modes(xi: Array, order: int) -> Array:
        columns = [
            _cluster_modes(cluster, directions(cluster, *scaled), xi, order)
            for cluster in clusters
        ]
        return np.concatenate(columns, axis=1)

    ends = np.array([0.0, 1.0])
    value, slope = modes(ends, 0), modes(ends, 1)
    solid_inlet = 0 if flux_solid >= 0 else 1
    rows, right_side = [value[0, :, 0]], [0.0]
    if flux_solid or d_solid:
        rows.append(value[1, :, solid_inlet])
        right_side.append(1.0)
    if d_fluid:
        rows.append(slope[0, :, 1])
        right_side.append(0.0)
    if d_solid:
        rows.append(slope[1, :, 1 - solid_inlet])
        right_side.append(0.0)
    matrix = np.array(rows)
    column_scale = np.abs(value).max(axis=(0, 2))
    row_scale = np.abs(matrix / column_scale).max(axis=1)
    weights = (
        np.linalg.solve(
            matrix / column_scale / row_scale[:, None], right_side / row_scale
        )
        / column_scale
    )
    xi = np.asarray(x, dtype=float) / length
    f, s = (
        np.tensordot(modes(xi, derivative), weights, axes=(1, 0)) / length**derivative
    )
    return f, s


def directions(
    nodes: Array, c_f: float, c_s: float, d_f: float, d_s: float, ha: float, d_x: float
) -> tuple[Array, Array]:
    """Return coefficients (ascending powers) of p(l), q(l) such that (p, q) exp(l x)
    solves the equations at the nodes.

    Either equation gives one; the one with less cancellation at the nodes and in
    differences over a cluster is used.
    """
    cross = np.array([1.0, 0.0, d_x / ha])
    fluid = np.array([1.0, c_f / ha, -d_f / ha])
    solid = np.array([1.0, c_s / ha, -d_s / ha])
    powers = np.vander(nodes, 3, increasing=True)
    sizes = np.vander(np.abs(nodes) + (len(nodes) > 1), 3, increasing=True)
    coupling = np.abs(powers @ cross)
    loss_fluid, loss_solid = (
        (sizes @ np.abs(row) / np.maximum(coupling, np.abs(powers @ row))).max()
        for row in (fluid, solid)
    )
    return (cross, fluid) if loss_fluid <= loss_solid else (solid, cross)


def _homogeneous(nodes: Array, degree: int) -> Array:
    """Return the complete homogeneous symmetric polynomials h_0 ... h_degree of the
    nodes.
    """
    h = np.zeros(degree + 1)
    h[0] = 1.0
    for node in nodes:
        for m in range(1, degree + 1):
            h[m] += node * h[m - 1]
    return h


def _exp_difference(nodes: Array, y: Array, terms: int = 32) -> Array:
    """Return the divided difference of exp(z y) over nodes z spanning at most 3,
    |y| <= 1, by its series.
    """
    k, centre = len(nodes) - 1, nodes.mean()
    series = _homogeneous(nodes - centre, terms)
    series /= factorial(np.arange(k, k + terms + 1))
    difference: Array = (
        np.exp(centre * y) * y**k * np.polynomial.polynomial.polyval(y, series)
    )
    return difference


def _cluster_modes(
    nodes: Array, vector: tuple[Array, Array], xi: Array, order: int
) -> Array:
    """Return derivatives of a basis of the solutions with the given rates; shape (2,
    number of nodes) + shape of xi.

    Member j is the divided difference of z^order (p(z), q(z)) exp(z y) over nodes 0 ...
    j, by the product rule; y is measured from the end where the exponentials are
    largest.
    """
    y = xi - (1.0 if nodes.mean() > 0 else 0.0)
    count = len(nodes)
    modes = np.zeros((2, count, *np.shape(xi)))
    for i in range(count):
        powers = np.concatenate([np.zeros(i), _homogeneous(nodes[: i + 1], order + 2)])
        p, q = (float(powers[order : order + 3] @ polynomial) for polynomial in vector)
        for j in range(i, count):
            difference = _exp_difference(nodes[i : j + 1], y)
            modes[0, j] += p * difference
            modes[1, j] += q * difference
    return modes
