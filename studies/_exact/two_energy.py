"""Exact steady 1-D solutions of the two-energy-equation model in a bed without end, and
the bed of Nakayama et al.

`studies._exact.finite_length` has the equations, the symbols and the bed of finite length.

Source: Nakayama, Kuwahara, Sugiyama and Xu (2001), doi:10.1016/S0017-9310(01)00069-2;
    the numbers of other equations
are those of Pivem and de Lemos (2012), doi:10.1016/j.ijheatmasstransfer.2011.11.047.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from studies._exact.finite_length import Pair, directions
from studies._exact.modes import rates


def decay_rate(
    flux_fluid: float,
    flux_solid: float,
    d_fluid: float,
    d_solid: float,
    ha: float,
    d_cross: float = 0.0,
) -> tuple[float, float]:
    """Return rate lam [1/m] and direction r [-] of the one mode (1, r) exp(-lam x) that
    decays from co-current inlets.

    The equilibrium temperature is 1/(1 - r) and the distance to 99 % of it ln(100)/lam.
    A solid that neither moves nor conducts has no inlet of its own: lam = inf,
    r = -inf.
    """
    if flux_solid < 0:
        raise ValueError(
            f"decay_rate needs flux_solid >= 0, got {flux_solid:g}; use rates for "
            "counter-current flow"
        )
    rate = (
        rates(flux_fluid, flux_solid, d_fluid, d_solid, ha, d_cross)[0]
        if flux_solid or d_solid
        else -math.inf
    )
    if math.isinf(rate):
        return math.inf, -math.inf
    p, q = directions(
        np.array([rate]), flux_fluid, flux_solid, d_fluid, d_solid, ha, d_cross
    )
    return -float(rate), float(np.polyval(q[::-1], rate) / np.polyval(p[::-1], rate))


def semi_infinite(
    x: ArrayLike,
    flux_fluid: float,
    flux_solid: float,
    d_fluid: float,
    d_solid: float,
    ha: float,
    d_cross: float = 0.0,
) -> Pair:
    """Return f(x) and s(x) for f(0) = 0, s(0) = 1, bounded for x -> inf,
    flux_solid >= 0; two arrays of the shape of x.

    f = theta_eq (1 - exp(-lam x)), s = theta_eq + (1 - theta_eq) exp(-lam x),
    theta_eq = 1/(1 - r).
    """
    lam, r = decay_rate(flux_fluid, flux_solid, d_fluid, d_solid, ha, d_cross)
    x = np.asarray(x, dtype=float)
    equilibrium = 1.0 / (1.0 - r)
    exponent = -lam * x if math.isfinite(lam) else np.where(x > 0, -np.inf, 0.0)
    return -equilibrium * np.expm1(exponent), equilibrium + (
        1.0 - equilibrium
    ) * np.exp(exponent)


def tortuosity_parameter(porosity: float, conductivity_ratio: float) -> float:
    """Return the tortuosity parameter G [-] of a bed with stagnant conductivity k_stg;
    conductivity_ratio = k_s/k_f.

    k_stg/k_f = 1 - b^2 + b^2 c/((1 - b) c + b), b = (1 - phi)^(1/3), c = k_s/k_f  (Hsu
    et al. 1995; Eq. 34), and G = (k_stg/k_f - phi - (1 - phi) c)/(c - 1)^2  (Eq. 33
    without its spurious "1", as its Table 1 requires).
    """
    b, c = (1.0 - porosity) ** (1.0 / 3.0), conductivity_ratio
    stagnant = 1.0 - b**2 + b**2 * c / ((1.0 - b) * c + b)
    return float((stagnant - porosity - (1.0 - porosity) * c) / (c - 1.0) ** 2)


def nakayama_peclet(peclet_d: float, prandtl: float, porosity: float) -> float:
    """Return the peclet number [-] on the exchange length sqrt(k_f/(a h)), spheres with
    Wakao's coefficient (Eq. 30).

    Pe = Pe_d/sqrt(6 (1 - phi) (2 + 1.1 Pr^(-4/15) Pe_d^0.6)), Pe_d = rho_f c_pf u_D
    D/k_f.
    """
    return peclet_d / math.sqrt(
        6.0 * (1.0 - porosity) * (2.0 + 1.1 * prandtl ** (-4.0 / 15.0) * peclet_d**0.6)
    )


def nakayama_coefficients(
    peclet: float,
    porosity: float,
    conductivity_ratio: float,
    dispersion_ratio: float,
    tortuosity: float,
) -> dict[str, float]:
    """Return the keyword arguments of decay_rate, semi_infinite and finite_length for
    the bed of Nakayama et al.

    Pe f' = (phi + G + K) f'' - c G s'' + (s - f),  0 = ((1 - phi) c + c^2 G) s'' - c G
    f'' - (s - f) with c = k_s/k_f, K = dispersion_ratio = K_xx/k_f, G = tortuosity, and
    X = x/sqrt(k_f/(a h)) as the coordinate [-]. The bed is stationary. Hot fluid over a
    cold bed (f(0) = 1, s(0) = 0): take one minus the temperatures of semi_infinite.
    """
    c = conductivity_ratio
    return {
        "flux_fluid": peclet,
        "flux_solid": 0.0,
        "d_fluid": porosity + tortuosity + dispersion_ratio,
        "d_solid": (1.0 - porosity) * c + c**2 * tortuosity,
        "ha": 1.0,
        "d_cross": -c * tortuosity,
    }
