"""Closed forms of two-flux and P1 radiation and references for enclosures of more than
one dimension.

Both models solve, with E = sigma T^4, extinction beta = Ka + Ks, D = 1/(4 beta)
(two-flux) or 1/(3 beta) (P1):

    -div(D grad G) + Ka G = 4 Ka E,   q = -D grad G,   D dG/dn = e/(2 (2 - e)) (4 E_w - G) at a wall of emissivity e

In units of 1/beta: D = 1/4 or 1/3, k = sqrt((1 - omega)/D) is the decay rate of a
layer. Powers and fluxes are in any common unit, such as sigma T1^4. Modest and
Mazumder, Radiative Heat Transfer, 2022, doi:10.1016/C2018-0-03206-5. The exact side of
the plane problems is studies._exact.transport.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev, legendre
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import BarycentricInterpolator

Array = NDArray[np.float64]

TWO_FLUX, P1 = 0.25, 1.0 / 3.0


def equilibrium_flux(
    tau: ArrayLike, D: float, emissivity: tuple[float, float] = (1.0, 1.0)
) -> Array:
    """Return Psi = q/(sigma T1^4 - sigma T2^4) [-] of gray plates in radiative
    equilibrium, at any albedo.

    Psi = 1/(c tau + 1/e1 + 1/e2 - 1), c = 1/(4 D): 1 for two-flux, 3/4 for P1
    """
    first, second = emissivity
    return np.asarray(
        1.0
        / (0.25 / D * np.asarray(tau, dtype=float) + 1.0 / first + 1.0 / second - 1.0)
    )


def equilibrium_profile(
    t: ArrayLike, tau: float, D: float, emissivity: tuple[float, float] = (1.0, 1.0)
) -> Array:
    """Return Phi = (T^4 - T2^4)/(T1^4 - T2^4) [-] at optical depths t.

    Phi = Psi (c (tau - t) + 1/e2 - 1/2)
    """
    remaining = 0.25 / D * (tau - np.asarray(t, dtype=float))
    return np.asarray(
        equilibrium_flux(tau, D, emissivity) * (remaining + 1.0 / emissivity[1] - 0.5)
    )


def gray_plates(black: ArrayLike, emissivity: tuple[float, float]) -> Array:
    """Return Psi of gray plates from that of black ones, Psi/(1 + Psi
    (1/e1 + 1/e2 - 2)); exact for transport.
    """
    psi = np.asarray(black, dtype=float)
    return np.asarray(
        psi / (1.0 + psi * (1.0 / emissivity[0] + 1.0 / emissivity[1] - 2.0))
    )


def isothermal_slab(
    tau: ArrayLike,
    D: float,
    albedo: ArrayLike = 0.0,
    emissivity: float = 1.0,
) -> Array:
    """Return the flux to a cold wall beside an isothermal medium, over sigma T^4 [-].

    q = 4 m D k t/(m + D k t) at the wall, m = e/(2 (2 - e)), t = tanh(k tau/2)

    Parameters
    ----------
    tau : optical thickness beta L [-], > 0
    D : 1/4 or 1/3
    albedo : omega [-], 0 ... 1
    emissivity : of the wall [-], > 0
    """
    k = np.sqrt((1.0 - np.asarray(albedo, dtype=float)) / D)
    ratio = D * k * np.tanh(0.5 * k * np.asarray(tau, dtype=float))
    m = 0.5 * emissivity / (2.0 - emissivity)
    return np.asarray(4.0 * m * ratio / (m + ratio))


def linear_slab(
    t: ArrayLike,
    tau: float,
    D: float,
    powers: tuple[float, float],
    walls: tuple[float, float],
    albedo: float = 0.0,
    emissivity: tuple[float, float] = (1.0, 1.0),
) -> tuple[Array, Array]:
    """Return G and q at optical depths t of a slab whose emissive power E is linear in
    t.

    G = 4 E + A exp(-k t) + B exp(-k (tau - t)),   q = -D G'

    Parameters
    ----------
    t : optical depths [-], 0 ... tau
    tau : optical thickness [-], > 0
    D : 1/4 or 1/3
    powers : E of the medium at t = 0 and at t = tau
    walls : sigma T^4 of the walls
    albedo : omega [-], < 1
    emissivity : of the walls [-]
    """
    t = np.asarray(t, dtype=float)
    k = np.sqrt((1.0 - albedo) / D)
    slope = (powers[1] - powers[0]) / tau
    m1, m2 = (0.5 * e / (2.0 - e) for e in emissivity)
    fade = np.exp(-k * tau)
    matrix = [[m1 + D * k, (m1 - D * k) * fade], [(m2 - D * k) * fade, m2 + D * k]]
    right = [
        4.0 * m1 * (walls[0] - powers[0]) + 4.0 * D * slope,
        4.0 * m2 * (walls[1] - powers[1]) - 4.0 * D * slope,
    ]
    A, B = np.linalg.solve(matrix, right)
    falling, rising = A * np.exp(-k * t), B * np.exp(-k * (tau - t))
    return 4.0 * (
        powers[0] + slope * t
    ) + falling + rising, -4.0 * D * slope + D * k * (falling - rising)


def square_p1(x: ArrayLike, tau: float, D: float = P1, degree: int = 80) -> Array:
    """Return the flux over sigma T^4 [-] to the cold black walls of a square with an
    isothermal absorbing medium.

    Chebyshev collocation at Lobatto points in both directions, by the eigenvectors of
    the one-dimensional operator.

    Parameters
    ----------
    x : position along a wall over its length [-], 0 ... 1
    tau : kappa L [-], > 0
    D : 1/3, or another diffusion coefficient in units of 1/kappa
    degree : of the polynomials; 80 gives 1e-10 for tau up to 10
    """
    nodes = chebyshev.chebpts2(degree + 1)
    unit = np.linalg.solve(chebyshev.chebvander(nodes, degree), np.eye(degree + 1))
    slope = (
        chebyshev.chebvander(nodes, degree - 1) @ chebyshev.chebder(unit) * 2.0 / tau
    )
    inner, ends = slice(1, degree), [0, degree]
    robin = D * slope[ends] * [[-1.0], [1.0]] + 0.5 * np.eye(degree + 1)[ends]
    to_ends = -np.linalg.solve(robin[:, ends], robin[:, inner])
    curvature = slope @ slope
    operator = -D * (curvature[inner, inner] + curvature[inner][:, ends] @ to_ends)
    values, vectors = np.linalg.eig(operator)
    source = np.linalg.solve(vectors, np.ones(degree - 1))
    modes = 4.0 * np.outer(source, source) / (values[:, None] + values + 1.0)
    field = np.real(vectors @ modes @ vectors.T)
    wall = to_ends[0] @ field
    along = np.concatenate([to_ends[:1] @ wall, wall, to_ends[1:] @ wall])
    return np.asarray(
        0.5
        * BarycentricInterpolator(0.5 * (nodes + 1.0), along)(
            np.asarray(x, dtype=float)
        )
    )


def square_transport(x: ArrayLike, tau: float) -> Array:
    """Return the flux of `square_p1` by exact transport, for 0 < x < 1.

    q/(sigma T^4) = 1 - (2/pi) int cos psi Ki3(kappa s(psi)) dpsi over -pi/2 ... pi/2,
    where s(psi) is the distance to the opposite wall in the plane and
    Ki3(y) = int_0^(pi/2) exp(-y/sin a) sin^2 a da. Error below 1e-10.
    """
    nodes, weights = legendre.leggauss(96)
    u, weight = 0.5 * (nodes + 1.0), 0.5 * weights
    polar, polar_weight = 0.5 * np.pi * u, 0.5 * np.pi * weight

    def side(ahead: Array) -> Array:
        """Integral over the angles on one side of the normal, with the corner
        `ahead` along the wall.
        """
        corner = np.arctan(ahead)[..., None]
        total = np.zeros_like(ahead)
        for low, high, facing in (
            (0.0 * corner, corner, True),
            (corner, 0.5 * np.pi + 0.0 * corner, False),
        ):
            psi = low + (high - low) * u
            path = tau * (
                1.0 / np.cos(psi) if facing else ahead[..., None] / np.sin(psi)
            )
            bickley = np.exp(-path[..., None] / np.sin(polar)) @ (
                polar_weight * np.sin(polar) ** 2
            )
            total = total + np.sum(
                (high - low) * weight * np.cos(psi) * bickley, axis=-1
            )
        return total

    at = np.asarray(x, dtype=float)
    return np.asarray(1.0 - 2.0 / np.pi * (side(at) + side(1.0 - at)))
