"""Heat conduction and radiation through a plane slab between two walls, by collocation.

With theta = T/T1, optical depth t = 0 ... tau, powers and fluxes in units of sigma
T1^4, N = k beta/(4 sigma T1^3):

    Q = -4 N theta' + q = constant,   theta(0) = 1,   theta(tau) = theta_L

exact (studies._exact.transport):
                  q(t) = 2 [J1 E3(t) - J2 E3(tau - t) + int S sgn(t - t') E2(|t - t'|) dt']
two-flux and P1:  q = -D G',  q' = (1 - omega) (4 theta^4 - G),  D = 1/4 and 1/3,
                  q(0) = m1 (4 - G),  q(tau) = m2 (G - 4 theta_L^4),  m = e/(2 (2 - e))

Viskanta and Grosh, J. Heat Transfer 84 (1962) 63, posed the problem.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from contbed.errors import ConvergenceError
from studies._exact.transport import slab

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HeatFlux:
    """Total flux Q and radiative fluxes at the walls, in units of sigma T1^4, and
    theta [-] at optical depths.
    """

    total: float
    radiative: tuple[float, float]
    depth: Array
    theta: Array


def conduction_radiation(
    tau: float,
    N: float,
    theta_L: float,
    albedo: float = 0.0,
    emissivity: tuple[float, float] = (1.0, 1.0),
) -> HeatFlux:
    """Solve conduction with exact radiative transport; error below 1e-10 sigma T1^4.

    Parameters
    ----------
    tau : optical thickness [-], > 0
    N : conduction-radiation parameter k beta/(4 sigma T1^3) [-], > 0
    theta_L : temperature ratio T2/T1 of the walls [-], > 0
    albedo : omega = Ks/beta [-], 0 <= omega < 1
    emissivity : e1, e2 of the walls [-]
    """
    medium = slab(tau)
    response = medium.respond(albedo, emissivity)
    count = len(medium.depth)
    through = np.concatenate([medium.depth, [tau]])
    integral = np.vstack([medium.cumulative, medium.weights]) @ response.flux

    def residual(unknown: Array) -> tuple[Array, Array]:
        theta = np.append(unknown[:-1], theta_L)
        powers = np.concatenate([unknown[:-1] ** 4, [1.0, theta_L**4]])
        value = theta - 1.0 + (unknown[-1] * through - integral @ powers) / (4.0 * N)
        slope = np.zeros((count + 1, count + 1))
        slope[:, :-1] = -integral[:, :-2] * unknown[:-1] ** 3 / N
        slope[np.arange(count), np.arange(count)] += 1.0
        slope[:, -1] = through / (4.0 * N)
        return value, slope

    linear = 1.0 + (theta_L - 1.0) * medium.depth / tau
    solved = _newton(residual, np.append(linear, 4.0 * N * (1.0 - theta_L) / tau))
    radiative = response.wall_fluxes(
        np.concatenate([solved[:-1] ** 4, [1.0, theta_L**4]])
    )
    return HeatFlux(float(solved[-1]), radiative, medium.depth, solved[:-1])


def conduction_diffusion(
    tau: float,
    N: float,
    theta_L: float,
    D: float,
    albedo: float = 0.0,
    emissivity: tuple[float, float] = (1.0, 1.0),
    degree: int = 0,
) -> HeatFlux:
    """Solve conduction with two-flux (D = 1/4) or P1 (D = 1/3) radiation by Chebyshev
    collocation at Lobatto points.

    4 N theta + D G = a - Q t eliminates G. `degree` 0 chooses one that resolves layers
    of width (1/D + 4/N)^-1/2; the error is then below 1e-10 sigma T1^4. Other arguments
    are those of `conduction_radiation`.
    """
    degree = degree or 40 + int(
        np.ceil(6.0 * np.sqrt(tau * np.sqrt(1.0 / D + 4.0 / N)))
    )
    nodes = chebyshev.chebpts2(degree + 1)
    derivative = 2.0 / tau * _derivative(nodes)
    t = 0.5 * tau * (nodes + 1.0)
    curvature = derivative @ derivative
    count = degree + 1
    exchange = 1.0 - albedo
    marshak = [0.5 * e / (2.0 - e) for e in emissivity]

    def residual(unknown: Array) -> tuple[Array, Array]:
        theta, a, Q = unknown[:count], unknown[count], unknown[count + 1]
        G = (a - Q * t - 4.0 * N * theta) / D
        G_slope = np.hstack(
            [
                -4.0 * N / D * np.eye(count),
                np.full((count, 1), 1.0 / D),
                -t[:, None] / D,
            ]
        )
        value, slope = np.zeros(count + 2), np.zeros((count + 2, count + 2))
        value[:count] = 4.0 * N * curvature @ theta - exchange * (4.0 * theta**4 - G)
        slope[:count, :count] = 4.0 * N * curvature - exchange * np.diag(
            16.0 * theta**3
        )
        slope[:count] += exchange * G_slope
        for row, end, wall in ((0, 0, 1.0), (count - 1, -1, theta_L)):
            value[row] = theta[end] - wall
            slope[row] = np.eye(count + 2)[end % count]
        for row, end, wall, m in (
            (count, 0, 1.0, marshak[0]),
            (count + 1, -1, -theta_L, -marshak[1]),
        ):
            value[row] = (
                Q + 4.0 * N * derivative[end] @ theta - m * (4.0 * wall**4 - G[end])
            )
            slope[row, :count] = 4.0 * N * derivative[end]
            slope[row, -1] = 1.0
            slope[row] += m * G_slope[end]
        return value, slope

    theta = 1.0 + (theta_L - 1.0) * t / tau
    Q = 4.0 * N * (1.0 - theta_L) / tau
    solved = _newton(residual, np.concatenate([theta, [4.0 * N + 4.0 * D, Q]]))
    theta, Q = solved[:count], float(solved[-1])
    conducted = -4.0 * N * derivative[[0, -1]] @ theta
    return HeatFlux(Q, (Q - float(conducted[0]), Q - float(conducted[1])), t, theta)


def _newton(residual: Callable[[Array], tuple[Array, Array]], start: Array) -> Array:
    """Solve by Newton's method; temperatures change by at most a half in a step and
    stay positive.
    """
    unknown = start
    size = np.inf
    for _ in range(80):
        value, slope = residual(unknown)
        step = np.linalg.solve(slope, -value)
        last, size = size, float(np.abs(step).max())
        unknown = unknown + min(1.0, 0.5 / size) * step
        if size < 1e-13 * np.abs(unknown).max() or (size < 1e-9 and size >= 0.5 * last):
            return unknown
    raise ConvergenceError(
        f"conduction and radiation: last Newton change {size:.1e}; try a larger N or "
        "theta_L"
    )


def _derivative(nodes: Array) -> Array:
    """Return the differentiation matrix of the polynomial through Lobatto points;
    rows sum to zero exactly.
    """
    count = len(nodes)
    weight = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    weight[[0, -1]] *= 0.5
    difference = nodes[:, None] - nodes + np.eye(count)
    matrix = np.outer(1.0 / weight, weight) / difference
    matrix -= np.diag(matrix.diagonal())
    return np.asarray(matrix - np.diag(matrix.sum(axis=1)))
