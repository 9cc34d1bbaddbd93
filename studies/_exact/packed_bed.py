"""Exact transient and lumped solutions for packed beds: Schumann's bed,
two-temperature relaxation, the fin.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import i0e

Array = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(80)
# exp(-7^2) = 5e-22: beyond this distance from its peak the integrand of
# _bessel_integral is nothing
_REACH = 7.0


def schumann(
    z: ArrayLike, t: ArrayLike, velocity: float, rate_fluid: float, rate_solid: float
) -> tuple[Array, Array]:
    """Return fluid and solid temperature after a step at the inlet of a bed without
    conduction (Schumann 1929).

        d theta_f/dt + u d theta_f/dz = A (theta_s - theta_f),   d theta_s/dt = B (theta_f - theta_s)

    theta = 0 at t = 0, theta_f = 1 at z = 0. With xi = A z/u and tau = B
    (t - z/u) >= 0,

        theta_f = int_xi^inf exp(-s - tau) I0(2 sqrt(s tau)) ds,  theta_s = int_0^tau exp(-s - xi) I0(2 sqrt(s xi)) ds

    and both vanish for t < z/u. Relative error below 1e-14, ahead of the front as well.

    Parameters
    ----------
    z : distance from the inlet [m], >= 0
    t : time [s]
    velocity : interstitial velocity u [m/s]
    rate_fluid : A = h a/(eps rho c_p)_f [1/s]
    rate_solid : B = h a/((1 - eps) rho c_p)_s [1/s]

    Returns
    -------
    theta_f, theta_s [-], each of the common shape of z and t.

    Source: Schumann, J. Franklin Inst. 208 (1929) 405,
        doi:10.1016/S0016-0032(29)91186-8.
    """
    z, t = np.broadcast_arrays(np.asarray(z, dtype=float), np.asarray(t, dtype=float))
    since_arrival = t - z / velocity
    xi, tau = (
        np.sqrt(rate_fluid * z / velocity),
        np.sqrt(rate_solid * np.maximum(since_arrival, 0.0)),
    )
    fluid = _bessel_integral(xi, np.maximum(xi, tau) + _REACH, tau)
    solid = _bessel_integral(np.zeros_like(tau), tau, xi)
    return np.where(since_arrival >= 0, fluid, 0.0), np.where(
        since_arrival >= 0, solid, 0.0
    )


def two_temperature_relaxation(
    t: ArrayLike,
    capacity_fluid: float,
    capacity_solid: float,
    ha: float,
    fluid_start: float,
    solid_start: float,
    loss_fluid: float = 0.0,
    loss_solid: float = 0.0,
    ambient: float = 0.0,
) -> tuple[Array, Array]:
    """Return the temperatures of uniform fluid and solid that exchange heat with each
    other and with the surroundings.

        C_f dT_f/dt = ha (T_s - T_f) - g_f (T_f - T_a),   C_s dT_s/dt = -ha (T_s - T_f) - g_s (T_s - T_a)

    Two exponentials in general; without losses T_f and T_s approach (C_f T_f0 + C_s
    T_s0)/(C_f + C_s) at the one rate ha (1/C_f + 1/C_s).

    Parameters
    ----------
    t : time [s]
    capacity_fluid, capacity_solid : C_f = eps (rho c_p)_f, C_s = (1 - eps) (rho
        c_p)_s [J/m3/K], > 0
    ha : exchange between the phases [W/m3/K], > 0
    fluid_start, solid_start, ambient : T_f0, T_s0, T_a [K]
    loss_fluid, loss_solid : g_f, g_s [W/m3/K], >= 0

    Returns
    -------
    T_f, T_s [K], each of the shape of t.
    """
    t = np.asarray(t, dtype=float)
    fluid, solid = ha / capacity_fluid, ha / capacity_solid
    out_fluid, out_solid = loss_fluid / capacity_fluid, loss_solid / capacity_solid
    own_fluid, own_solid = fluid + out_fluid, solid + out_solid
    split = math.hypot(own_fluid - own_solid, 2.0 * math.sqrt(fluid * solid))
    fast = 0.5 * (own_fluid + own_solid + split)
    determinant = (ha * (loss_fluid + loss_solid) + loss_fluid * loss_solid) / (
        capacity_fluid * capacity_solid
    )
    slow = determinant / fast
    decay = np.exp(-slow * t)
    mixed = -decay * np.expm1(-split * t) / split
    f, s = fluid_start - ambient, solid_start - ambient
    rise_fluid = fluid * (s - f) - (out_fluid - slow) * f
    rise_solid = solid * (f - s) - (out_solid - slow) * s
    return (
        ambient + decay * f + mixed * rise_fluid,
        ambient + decay * s + mixed * rise_solid,
    )


def fin(x: ArrayLike, length: float, conductivity: float, ha: float) -> Array:
    """Return the steady temperature of a solid that conducts and exchanges heat with a
    fluid at zero [-].

    d s'' = ha s, s(0) = 1, s'(L) = 0: s = cosh(m (L - x))/cosh(m L), m = sqrt(ha/d),
    the limit of the two-energy equations for infinite fluid flux. conductivity
    d [W/m/K], ha [W/m3/K], x and length [m]; returns the shape of x. Never overflows.
    """
    x = np.asarray(x, dtype=float)
    m = math.sqrt(ha / conductivity)
    return (np.exp(-m * x) + np.exp(-m * (2.0 * length - x))) / (
        1.0 + math.exp(-2.0 * m * length)
    )


def _bessel_integral(low: Array, high: Array, centre: Array) -> Array:
    """Integrate 2 w exp(-w^2 - centre^2) I0(2 w centre) over w from `low` to `high`.

    The integrand is a bell of unit width at w = centre (w^2 = s).
    """
    low = np.maximum(low, np.minimum(centre, high) - _REACH)
    high = np.minimum(high, np.maximum(centre, low) + _REACH)
    half = 0.5 * (high - low)[..., None]
    w, c = low[..., None] + half * (1.0 + _NODES), centre[..., None]
    integral: Array = (
        2.0 * w * np.exp(-((w - c) ** 2)) * i0e(2.0 * w * c) * half
    ) @ _WEIGHTS
    return integral
