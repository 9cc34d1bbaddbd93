"""Closures for cells that do not resolve clusters: filtered drag of Milioli et al.,
filtered stress of Igci et al.

`filter_froude` is the size of the filter, two cells, times g over the square of Stokes'
terminal velocity v_t = g d_p^2 (rho_s - rho)/(18 mu); fits are to two-fluid simulations
of 75 um, 1500 kg/m3 in air, in periodic boxes. The filtered stress takes the place of
granular temperature: it is given over rho_s theta with theta = v_t^2. The drag of Igci
et al. stands in drag.py. Near walls all three are smaller than in the periodic boxes:
the factors of Igci and Sundaresan multiply them there.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.drag import drag_wen_yu, joined
from contbed.closures.registry import Value, closure

_MILIOLI = (
    "Milioli, Milioli, Holloway, Agrawal, Sundaresan 2013, AIChE J. 59, "
    "3265-3275, doi:10.1002/aic.14130"
)
_IGCI = (
    "Igci, Pannala, Benyahia, Sundaresan 2012, Ind. Eng. Chem. Res. 51, 2094-2103, "
    "doi:10.1021/ie2007278"
)
_WALL = "Igci, Sundaresan 2011, AIChE J. 57, 2691-2707, doi:10.1002/aic.12486"
_MFIX = "coefficients as in MFiX 21.3.2, model/drag_gs.f and model/calc_mu_s.f"
_INF = float("inf")
# solids fraction below which closures are those at this one, as powers of it are
# infinite at 0
_DILUTEST = 1e-6
# of the change to the smaller of two shares H, and of the steps in eps_s where pieces
# meet
_WIDTH = 2e-3
# solids fraction over which H ends without a jump of its slope; without, powers of 0.03
# are almost steps
_CUT = 0.018
_NO_ROOM = 1e-12  # solids fraction that counts as none, so that its powers have a slope
_LARGEST = 0.999  # H at most, so that drag stays positive
_FREE = 0.59  # solids fraction above which there is no room for clusters
# Milioli et al., one row for each size F of the filter: F, k0 to k5, o0 to o3: H_lin =
# (k0 + k1 v + (k2 v + k3)/(k4 v + k5)) eps_s + o0 + o1 v - o2/(o3 v + 0.01) A, p, B, q,
# C, joint: H_env = A (1 + eps_s) eps_s^p/(B eps_s^q + C) below the joint D, r, t, end:
# H_env = D (end - eps_s)^r/(1 - eps_s^t) above it, none beyond the end
_ROWS = (
    (2.056, 1.268, -0.2, 0.0, 0.14, 1.0, 0.01, 0.385, 0.09, 0.05, 0.2,
     8.6, 0.2, 10.0, 1.0, 6.3, 0.53, 0.423, 0.3, 0.4, 0.65),
    (4.112, 0.0, 0.0, 0.018, 0.1, 0.14, 0.01, 0.9454, 0.0, 0.09, 0.2,
     7.9, 0.2, 10.0, 0.9, 5.0, 0.5, 0.705, 0.3, 0.7, 0.63),
    (8.224, 0.0, 0.0, 0.05, 0.3, 0.4, 0.06, 0.9466, 0.0, 0.05, 0.11,
     7.9, 0.2, 10.0, 0.6, 3.6, 0.45, 0.78, 0.2, 0.9, 0.57),
    (12.336, 0.0, 0.0, 1.3, 2.2, 5.2, 0.07, 0.9363, 0.0, 0.11, 0.3,
     7.6, 0.2, 10.0, 0.6, 3.3, 0.35, 0.81, 0.3, 0.7, 0.55),
    (16.448, 0.0, 0.0, 2.6, 4.0, 10.0, 0.08, 0.926, 0.0, 0.17, 0.5,
     8.4, 0.2, 10.0, 0.5, 3.3, 0.25, 1.01, 0.03, 0.9, 0.52),
    (20.56, 0.0, 0.0, 2.5, 4.0, 10.0, 0.08, 0.9261, 0.0, 0.17, 0.5,
     8.4, 0.2, 10.0, 0.5, 3.3, 0.25, 1.065, 0.3, 1.0, 0.52),
    (24.672, 0.0, 0.0, 1.6, 4.0, 7.9, 0.08, 0.9394, 0.0, 0.22, 0.6,
     9.0, 0.15, 10.0, 0.45, 4.2, 0.25, 0.91, 0.4, 0.6, 0.52),
)  # fmt: skip
UNFILTERED = 1.028  # F up to which the drag is not filtered


@closure(
    kind="drag",
    ranges={"Re": (0, _INF), "eps": (0.41, 1), "filter_froude": (0, 33)},
    source=f"{_MILIOLI}; {_MFIX}",
)
def drag_milioli(
    Re: Value, eps: Value, d_p: Value, mu: Value, filter_froude: Value, Re_t: Value
) -> Value:
    """Milioli et al. (2013): Wen and Yu's drag filtered over cells that do not resolve
    clusters, with the slip.

        beta = beta_WenYu (1 - H),  H = min(H_env, max(H_lin, 0)) of eps_s and v = slip/v_t = Re/(eps Re_t)

    with an envelope H_env(eps_s) and H_lin linear in eps_s for each of the filters
    2.056, 4.112, 8.224, 12.336, 16.448, 20.56 and larger ones, 24.672; no filter up to
    1.028. Between these H goes from one to the next by a cubic in the logarithm of
    filter_froude; as one reads them elsewhere, it jumps by up to 0.6 there. Minimum,
    maximum and steps in eps_s are smooth over 0.002, H ends in eps_s over 0.018, and it
    is at most 0.999. Walls are not accounted for: wall_drag_igci does.

    filter_froude : [-] filter size times g over the square of Stokes' terminal
        velocity; a filter is two cells wide

    Fitted to: two-fluid simulations of 75 um, 1500 kg/m3 in air, in periodic boxes
    Limits: filter_froude <= 1.028: Wen and Yu.

    >>> round(float(drag_milioli(Re=1.0, eps=0.9, d_p=75e-6, mu=1.8e-5, filter_froude=2.056, Re_t=1.27)), 1)
    5967.7
    """
    s, v = np.maximum(1 - eps, _DILUTEST), Re / (eps * Re_t)
    last, H = UNFILTERED, 0.0 * (s + v + filter_froude)
    for (
        F,
        k0,
        k1,
        k2,
        k3,
        k4,
        k5,
        o0,
        o1,
        o2,
        o3,
        A,
        p,
        B,
        q,
        C,
        joint,
        D,
        r,
        t,
        end,
    ) in _ROWS:
        line = (
            (k0 + k1 * v + (k2 * v + k3) / (k4 * v + k5)) * s
            + o0
            + o1 * v
            - o2 / (o3 * v + 0.01)
        )
        line = np.maximum(line, 0.0) + _WIDTH * np.log(
            1.0 + np.exp(-np.absolute(line) / _WIDTH)
        )
        envelope = A * (1.0 + s) * s**p / (B * s**q + C)
        room = np.maximum(end - s, _NO_ROOM)
        cut = np.minimum(room / _CUT, 1.0)
        dense = D * room**r / (1.0 - s**t) * cut**2 * (3.0 - 2.0 * cut)
        envelope = envelope + (dense - envelope) / (1.0 + np.exp((joint - s) / _WIDTH))
        least = np.minimum(line, envelope) - _WIDTH * np.log(
            1.0 + np.exp(-np.absolute(line - envelope) / _WIDTH)
        )
        least = np.minimum(least, _LARGEST) - _WIDTH * np.log(
            1.0 + np.exp(-np.absolute(least - _LARGEST) / _WIDTH)
        )
        share = np.minimum(
            np.maximum(np.log(filter_froude / last + 1e-30) / np.log(F / last), 0.0),
            1.0,
        )
        H, last = H + share**2 * (3.0 - 2.0 * share) * (np.maximum(least, 0.0) - H), F
    return drag_wen_yu(Re, eps, d_p, mu) * (1.0 - H)


def fits_milioli(filter_froude: float) -> tuple[float, float]:
    """Fitted filters that the drag of Milioli et al. goes between; twice the same at
    one of them and beyond the last.

    Up to the first of them the drag is not filtered.

    >>> fits_milioli(5.0), fits_milioli(30.0), fits_milioli(1.0)
    ((4.112, 8.224), (24.672, 24.672), (1.028, 1.028))
    """
    sizes = (UNFILTERED, *(row[0] for row in _ROWS))
    smaller = max((size for size in sizes if size <= filter_froude), default=sizes[0])
    larger = min((size for size in sizes if size >= filter_froude), default=sizes[-1])
    return smaller, max(smaller, larger)


@closure(
    kind="granular_pressure",
    ranges={"eps_s": (0, 0.63), "filter_froude": (0, 33)},
    source=f"{_IGCI}; {_MFIX}",
)
def granular_pressure_igci(
    eps_s: Value, g0: Value, e: Value, filter_froude: Value
) -> Value:
    """Igci et al. (2012): filtered pressure of particles over rho_s v_t^2, with kinetic
    theory and clusters.

        p = rho_s v_t^2 (p_kinetic + p_clusters)
        p_kinetic = -10.4 eps_s^2 + 0.31 eps_s                                     below 0.0131
            -0.185 eps_s^3 + 0.066 eps_s^2 - 0.000183 eps_s + 0.00232              to 0.29
            -0.00978 eps_s + 0.00615                                               to 0.595, then constant
        p_clusters = 0.48 F^0.86 (1 - exp(-F/1.4)) (0.59 - eps_s) eps_s (1.69 + 4.61 eps_s - 11 eps_s^2)

    joined by logistic steps whose width is 1 % of the fraction where pieces meet; no
    clusters above 0.59. A cubic is printed for fractions above 0.595; with its three
    digits it is negative up to 0.61, where friction acts in any case. The granular
    temperature is v_t^2 and frozen, by the keys granular_temperature of [two_fluid]
    and [initial]. Between 0.3 and 0.59 the pressure falls with eps_s.

    g0 : [-] radial distribution at contact, without effect
    e : [-] restitution of two particles, without effect
    filter_froude : [-] filter size times g over the square of Stokes' terminal
        velocity; a filter is two cells wide

    Fitted to: two-fluid simulations of 75 um, 1500 kg/m3 in air, in periodic boxes
    Limits: filter_froude -> 0: the kinetic part alone.

    >>> round(float(granular_pressure_igci(eps_s=0.1, g0=1.0, e=0.9, filter_froude=4.0)), 5)
    0.15184
    """
    s = eps_s + 0.0 * (g0 + e)
    kinetic = -10.4 * s**2 + 0.31 * s
    thin = -0.185 * s**3 + 0.066 * s**2 - 0.000183 * s + 0.00232
    kinetic = joined(kinetic, thin, s, 0.0131)
    thick = -0.00978 * s + 0.00615
    kinetic = joined(kinetic, thick, s, 0.29)
    packed = -0.00978 * 0.595 + 0.00615
    kinetic = joined(kinetic, packed, s, 0.595)
    size = 0.48 * filter_froude**0.86 * (1.0 - np.exp(-filter_froude / 1.4))
    clusters = size * np.maximum(_FREE - s, 0.0) * s * (1.69 + 4.61 * s - 11.0 * s**2)
    return kinetic + clusters


@closure(
    kind="granular_viscosity",
    ranges={"eps_s": (0, 0.63), "filter_froude": (0, 33)},
    source=f"{_IGCI}; {_MFIX}",
)
def granular_viscosity_igci(
    eps_s: Value,
    g0: Value,
    e: Value,
    filter_froude: Value,
    terminal_froude: Value,
    kinetic: Value = 1.0,
) -> Value:
    """Igci et al. (2012): filtered shear viscosity over rho_s d_p v_t, with kinetic
    theory and clusters.

        mu = rho_s v_t^3/g (mu_kinetic + mu_clusters)
        mu_kinetic = 1720 eps_s^4 - 215 eps_s^3 + 9.81 eps_s^2 - 0.207 eps_s + 0.00254          below 0.02
            2.72 eps_s^4 - 1.55 eps_s^3 + 0.329 eps_s^2 - 0.0296 eps_s + 0.00136                to 0.2
            -0.0128 eps_s^3 + 0.0107 eps_s^2 - 0.0005 eps_s + 0.000335                          to 0.6095, then constant
        mu_clusters = 0.37 F^1.22/(0.28 F^0.43 + 1) (0.59 - eps_s) eps_s (1.22 + 0.7 eps_s + 2 eps_s^2), none above 0.59

    joined as granular_pressure_igci, with the same granular temperature; the printed
    parabola above 0.6095 is negative there. The bulk viscosity that goes with it is
    none.

    g0 : [-] radial distribution at contact, without effect
    e : [-] restitution of two particles, without effect
    filter_froude : [-] filter size times g over the square of Stokes' terminal
        velocity; a filter is two cells wide
    kinetic : [-] share of the kinetic part that guards leave, without effect

    Fitted to: two-fluid simulations of 75 um, 1500 kg/m3 in air, in periodic boxes
    Limits: filter_froude -> 0: the kinetic part alone.

    >>> round(float(granular_viscosity_igci(eps_s=0.1, g0=1.0, e=0.9, filter_froude=4.0, terminal_froude=88.6)), 3)
    7.608
    """
    s = eps_s + 0.0 * (g0 + e + kinetic)
    theory = 1720.0 * s**4 - 215.0 * s**3 + 9.81 * s**2 - 0.207 * s + 0.00254
    thin = 2.72 * s**4 - 1.55 * s**3 + 0.329 * s**2 - 0.0296 * s + 0.00136
    theory = joined(theory, thin, s, 0.02)
    thick = -0.0128 * s**3 + 0.0107 * s**2 - 0.0005 * s + 0.000335
    theory = joined(theory, thick, s, 0.2)
    packed = -0.0128 * 0.6095**3 + 0.0107 * 0.6095**2 - 0.0005 * 0.6095 + 0.000335
    theory = joined(theory, packed, s, 0.6095)
    size = 0.37 * filter_froude**1.22 / (0.28 * filter_froude**0.43 + 1.0)
    clusters = size * np.maximum(_FREE - s, 0.0) * s * (1.22 + 0.7 * s + 2.0 * s**2)
    return terminal_froude * (theory + clusters)


@closure(
    kind="wall_drag",
    ranges={"wall_froude": (0, _INF)},
    source=f"{_WALL}; {_MFIX}",
)
def wall_drag_igci(wall_froude: Value) -> Value:
    """Igci and Sundaresan (2011): filtered drag near a wall over that far from it.

        1/(1 + 6 exp(-0.295 x)),  x = distance g/v_t^2 = wall_froude

    Fitted to: two-fluid simulations of 75 um, 1500 kg/m3 in air, in channels with
        free-slip walls
    Limits: a seventh at the wall, 1 far from it.

    >>> round(float(wall_drag_igci(wall_froude=4.0)), 4)
    0.3517
    """
    return 1.0 / (1.0 + 6.0 * np.exp(-0.295 * wall_froude))


@closure(
    kind="wall_pressure",
    ranges={"wall_froude": (0, _INF)},
    source=f"{_WALL}; {_MFIX}",
)
def wall_pressure_igci(wall_froude: Value) -> Value:
    """Igci and Sundaresan (2011): filtered pressure of particles near a wall over that
    far from it.

        1/(1 + 9.14 exp(-0.345 x)),  x = distance g/v_t^2 = wall_froude

    Fitted to: two-fluid simulations of 75 um, 1500 kg/m3 in air, in channels with
        free-slip walls
    Limits: a tenth at the wall, 1 far from it.

    >>> round(float(wall_pressure_igci(wall_froude=4.0)), 4)
    0.3031
    """
    return 1.0 / (1.0 + 9.14 * np.exp(-0.345 * wall_froude))


@closure(
    kind="wall_viscosity",
    ranges={"wall_froude": (0, _INF)},
    source=f"{_WALL}; {_MFIX}",
)
def wall_viscosity_igci(wall_froude: Value) -> Value:
    """Igci and Sundaresan (2011): filtered viscosity of particles near a wall over that
    far from it.

        1/(1 + 5.69 exp(-0.228 x)),  x = distance g/v_t^2 = wall_froude

    Fitted to: two-fluid simulations of 75 um, 1500 kg/m3 in air, in channels with
        free-slip walls
    Limits: a seventh at the wall, 1 far from it.

    >>> round(float(wall_viscosity_igci(wall_froude=4.0)), 4)
    0.3043
    """
    return 1.0 / (1.0 + 5.69 * np.exp(-0.228 * wall_froude))
