"""Drag between gas and particles, per volume of the bed and velocity difference:
beta [kg/m3/s].

    force of the gas on the particles per volume of the bed = beta (u_gas - u_solid)

with intrinsic velocities, beside the pressure gradient that acts on both phases (model
A): a bed at rest has -dp/dx = beta u_gas/eps. The force on one particle is beta
V_p/(1 - eps) (u_gas - u_solid).

A force that is published as F times Stokes', 3 pi mu d_p U with U = eps |u_gas - u_solid|:
beta = 18 (1 - eps) eps F mu/d_p^2 if it is the drag alone (Beetstra), and
18 (1 - eps) eps^2 F mu/d_p^2 if it holds the mean pressure gradient too. In a dense bed at
Re -> 0 beta is 180 (1 - eps)^2/eps mu/d_p^2 (Carman).
"""

from __future__ import annotations

import numpy as np

from contbed.closures.registry import Value, closure

_FELICE = (
    "Di Felice 1994, Int. J. Multiphase Flow 20, 153-159, "
    "doi:10.1016/0301-9322(94)90011-6"
)
_GIDASPOW = "Gidaspow 1994, Multiphase Flow and Fluidization, Academic Press, eq. 2.11"
_WEN_YU = "Wen, Yu 1966, Chem. Eng. Prog. Symp. Ser. 62, 100-111"
_SYAMLAL = (
    "Syamlal, Rogers, O'Brien 1993, MFIX documentation: theory guide, "
    "doi:10.2172/10145548"
)
_BEETSTRA = (
    "Beetstra, van der Hoef, Kuipers 2007, AIChE J. 53, 489-501, doi:10.1002/aic.11065"
)
_IGCI = (
    "Igci, Pannala, Benyahia, Sundaresan 2012, Ind. Eng. Chem. Res. 51, 2094-2103, "
    "doi:10.1021/ie2007278"
)
_INF = float("inf")
# Re at which Schiller and Naumann's law meets the constant 0.44, but for 0.4 %
_STEP = 1000.0
# width of the change between them in Re; wider ones shift developed flows visibly
_RISE = 10.0
_LOOSE = 0.8  # porosity at which Gidaspow changes from Ergun to Wen and Yu
_BLEND = 0.01  # width of that change
# porosity at which Syamlal and O'Brien's terminal velocity changes its power
_DILUTE = 0.85
_TURN = 0.002  # width of that change
# width of the steps of the filtered drag, as a share of the solids fraction where its
# pieces meet
_JOINT = 0.01
# solids fraction below which the filtered drag is that at this one, as a power of it is
# infinite at 0
_DILUTEST = 1e-6


@closure(
    kind="drag",
    ranges={"Re": (0, 1000), "eps": (0.35, 0.95)},
    source=_BEETSTRA,
)
def drag_beetstra(Re: Value, eps: Value, d_p: Value, mu: Value) -> Value:
    """Beetstra (2007): lattice-Boltzmann simulations of static random arrays of equal
    spheres.

        beta = 18 (1 - eps) eps F mu/d_p^2
        F = 10 (1 - eps)/eps^2 + eps^2 (1 + 3/2 (1 - eps)^(1/2))
            + 0.413 Re/(24 eps^2) (1/eps + 3 eps (1 - eps) + 8.4 Re^-0.343)
              /(1 + 10^(3 (1 - eps)) Re^(-1/2 - 2 (1 - eps)))

    Fitted to: resolved simulations at solids volume fractions 0.1 to 0.6 and Re up to
        1000
    Limits: Re -> 0: Carman's law 180 (1 - eps)^2/eps mu/d_p^2 plus the second term.
        eps -> 1 at Re -> 0: Stokes's drag.

    >>> round(float(drag_beetstra(Re=100.0, eps=0.4, d_p=2e-3, mu=1.8e-5)), 4)
    1745.5062
    """
    solids, log_Re = 1 - eps, np.log(Re + 1e-30)
    still = 10.0 * solids / eps**2 + eps**2 * (1 + 1.5 * solids**0.5)
    rise = 1.0 / eps + 3.0 * eps * solids + 8.4 * np.exp(-0.343 * log_Re)
    inertia = (
        0.413
        * Re
        / (24.0 * eps**2)
        * rise
        / (1 + np.exp(np.log(1000.0) * solids - (0.5 + 2.0 * solids) * log_Re))
    )
    return 18.0 * solids * eps * (still + inertia) * mu / d_p**2


@closure(
    kind="drag",
    ranges={"Re": (0.01, 1e4), "eps": (0.37, 1)},
    source=_FELICE,
)
def drag_di_felice(Re: Value, eps: Value, d_p: Value, mu: Value) -> Value:
    """Di Felice (1994): single-sphere drag times a power of the porosity.

        beta = 3/4 (0.63 Re^(1/2) + 4.8)^2 (1 - eps) eps^(1 - chi) mu/d_p^2
        chi = 3.7 - 0.65 exp(-(1.5 - log10 Re)^2/2)

    Fitted to: fixed and fluidized beds and single spheres, with Dallavalle's drag
    Limits: Re -> 0: 17.28 (1 - eps) eps^-2.7 mu/d_p^2. eps -> 1: Dallavalle's single
        sphere.
    Source: As in Zhou, Hou, Yu 2011, Table 1.

    >>> round(float(drag_di_felice(Re=100.0, eps=0.4, d_p=2e-3, mu=1.8e-5)), 4)
    1750.8199
    """
    chi = 3.7 - 0.65 * np.exp(-0.5 * (1.5 - np.log(Re + 1e-30) / np.log(10.0)) ** 2)
    return (
        0.75 * (0.63 * Re**0.5 + 4.8) ** 2 * (1 - eps) * eps ** (1 - chi) * mu / d_p**2
    )


@closure(
    kind="drag",
    ranges={"Re": (0, _INF), "eps": (0.35, 1)},
    source=_GIDASPOW,
)
def drag_gidaspow(Re: Value, eps: Value, d_p: Value, mu: Value) -> Value:
    """Gidaspow (1994): Ergun below a porosity of 0.8, Wen and Yu above.

        beta = (150 (1 - eps)^2 + 1.75 (1 - eps) Re)/eps mu/d_p^2 for eps < 0.8, else drag_wen_yu

    joined by a logistic step in eps of width 0.01.

    Fitted to: Ergun's packed beds and Wen and Yu's expanded ones
    Limits: Re -> 0 in a packed bed: 150 (1 - eps)^2/eps mu/d_p^2, Ergun's. eps -> 1:
        the single sphere of drag_wen_yu.
    Source: The smooth step is an addition.

    >>> round(float(drag_gidaspow(Re=100.0, eps=0.4, d_p=2e-3, mu=1.8e-5)), 4)
    1788.75
    """
    packed = (150.0 * (1 - eps) ** 2 + 1.75 * (1 - eps) * Re) / eps * mu / d_p**2
    share = 1.0 / (1.0 + np.exp((_LOOSE - eps) / _BLEND))
    return packed + share * (drag_wen_yu(Re, eps, d_p, mu) - packed)


def joined(below: Value, above: Value, s: Value, at: float) -> Value:
    """Return one piece of a closure below a solids fraction and another above it, joined
    by a logistic step.
    """
    return below + (above - below) / (1.0 + np.exp((at - s) / (_JOINT * at)))


@closure(
    kind="drag",
    ranges={"Re": (0, _INF), "eps": (0.41, 1), "filter_froude": (0, 33)},
    source=_IGCI,
)
def drag_igci(
    Re: Value, eps: Value, d_p: Value, mu: Value, filter_froude: Value
) -> Value:
    """Igci et al. (2012): Wen and Yu's drag filtered over cells that do not resolve
    clusters.

        beta = beta_WenYu (1 - f g h),  f = F^1.6/(F^1.6 + 0.4), F = filter_froude
        g = eps_s^0.24 (1.48 + exp(-18 eps_s)) below eps_s = 0.18, then 1
        h = 2.7 eps_s^0.234                                                            below 0.0012
            0.963 - 0.019 eps_s^-0.455                                                 to 0.014
            0.868 exp(-0.38 eps_s) - 0.176 exp(-119.2 eps_s)                           to 0.25
            0.852 exp(-0.268 eps_s) - 4.59e-5 exp(19.75 eps_s)                         to 0.455
            (eps_s - 0.59) (-1501 eps_s^3 + 2203 eps_s^2 - 1054 eps_s + 162)           to 0.59, then 0

    joined by logistic steps whose width is 1 % of the fraction where the pieces meet;
    they differ there by up to 10 % of h, at eps_s = 0.0012. Walls are not accounted for
    (wall_drag_igci does), nor is the filtered stress of clusters.

    filter_froude : [-] filter size times g over the square of Stokes' terminal
        velocity; a filter is two cells wide

    Fitted to: two-fluid simulations of 75 um, 1500 kg/m3 in air, in periodic boxes
    Limits: filter_froude -> 0: Wen and Yu.

    >>> round(float(drag_igci(Re=1.0, eps=0.9, d_p=75e-6, mu=1.8e-5, filter_froude=2.0)), 1)
    2636.6
    """
    s = np.maximum(1 - eps, _DILUTEST)
    h = joined(2.7 * s**0.234, 0.963 - 0.019 * s**-0.455, s, 0.0012)
    thin = 0.868 * np.exp(-0.38 * s) - 0.176 * np.exp(-119.2 * s)
    h = joined(h, thin, s, 0.014)
    thick = 0.852 * np.exp(-0.268 * s) - 4.59e-5 * np.exp(19.75 * s)
    h = joined(h, thick, s, 0.25)
    dense = (s - 0.59) * (-1501.0 * s**3 + 2203.0 * s**2 - 1054.0 * s + 162.0)
    h = joined(h, dense, s, 0.455)
    h = h / (1.0 + np.exp((s - 0.59) / (_JOINT * 0.59)))
    g = joined(s**0.24 * (1.48 + np.exp(-18.0 * s)), 1.0, s, 0.18)
    filtered = filter_froude**1.6
    return drag_wen_yu(Re, eps, d_p, mu) * (1.0 - filtered / (filtered + 0.4) * g * h)


@closure(
    kind="drag",
    ranges={"Re": (0, _INF), "eps": (0.35, 1)},
    source=_SYAMLAL,
    bounds={"c": "(0, inf)", "d": "(0, inf)"},
)
def drag_syamlal_obrien(
    Re: Value, eps: Value, d_p: Value, mu: Value, c: float = 0.8, d: float = 2.65
) -> Value:
    """Syamlal and O'Brien (1993): Dallavalle's drag at the terminal velocity of the
    suspension.

        beta = 3/4 (1 - eps) eps/v^2 (0.63 Re_i^(1/2) + 4.8 v^(1/2))^2 mu/d_p^2,  Re_i = Re/eps
        v = (A - 0.06 Re_i + ((0.06 Re_i)^2 + 0.12 Re_i (2 B - A) + A^2)^(1/2))/2
        A = eps^4.14,  B = c eps^1.28 up to eps = 0.85, then eps^d

    joined by a logistic step in eps of width 0.002. c and d move the minimum
    fluidization to a measured one, with c 0.85^1.28 = 0.85^d; as they stand it comes
    too late for most beds.

    c : [-] factor below a porosity of 0.85
    d : [-] power above

    Fitted to: terminal velocities in settling and fluidized beds
    Limits: eps -> 1: Dallavalle's single sphere.
    Source: The powers are positive; print with minus signs is wrong.

    >>> round(float(drag_syamlal_obrien(Re=100.0, eps=0.4, d_p=2e-3, mu=1.8e-5)), 4)
    2069.3673
    """
    inner = Re / eps
    a = eps**4.14
    share = 1.0 / (1.0 + np.exp((_DILUTE - eps) / _TURN))
    b = c * eps**1.28 * (1.0 - share) + eps**d * share
    v = 0.5 * (
        a
        - 0.06 * inner
        + ((0.06 * inner) ** 2 + 0.12 * inner * (2 * b - a) + a**2) ** 0.5
    )
    return (
        0.75
        * (1 - eps)
        * eps
        / v**2
        * (0.63 * inner**0.5 + 4.8 * v**0.5) ** 2
        * mu
        / d_p**2
    )


@closure(
    kind="drag",
    ranges={"Re": (0, _INF), "eps": (0.4, 1)},
    source=_WEN_YU,
)
def drag_wen_yu(Re: Value, eps: Value, d_p: Value, mu: Value) -> Value:
    """Wen and Yu (1966): Schiller and Naumann's sphere times a power of the porosity.

        beta = 3/4 C Re (1 - eps) eps^-2.65 mu/d_p^2,  C Re = 24 (1 + 0.15 Re^0.687) up to Re = 1000, then 0.44 Re

    Fitted to: sedimentation and fluidization of spheres
    Limits: Re -> 0: 18 (1 - eps) eps^-2.65 mu/d_p^2. At Re = 1000 the laws differ by
        0.4 % and are joined by a logistic step in Re of width 10.

    >>> round(float(drag_wen_yu(Re=100.0, eps=0.4, d_p=2e-3, mu=1.8e-5)), 4)
    2506.5809
    """
    creeping = 24.0 * (1 + 0.15 * Re**0.687)
    share = 1.0 / (1.0 + np.exp((_STEP - Re) / _RISE))
    sphere = creeping + share * (0.44 * Re - creeping)
    return 0.75 * sphere * (1 - eps) * eps**-2.65 * mu / d_p**2
