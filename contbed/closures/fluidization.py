"""Minimum fluidization: Reynolds numbers from the Archimedes number, Re = sqrt(C1^2 + C2 Ar) - C1."""

from __future__ import annotations

from contbed.closures.registry import closure

_INF = float("inf")
_WEN_YU = "Wen, Yu 1966, AIChE J. 12, 610-612, doi:10.1002/aic.690120343"
_CHITESTER = "Chitester, Kornosky, Fan, Danko 1984, Chem. Eng. Sci. 39, 253-261"
_GRACE = "Grace 1982, in Hetsroni (ed.), Handbook of Multiphase Systems, chapter 8, Hemisphere, Washington"


@closure(kind="minimum_fluidization", unit="-", ranges={"Ar": (0, _INF)}, source=_CHITESTER)
def minimum_fluidization_chitester(Ar):
    """Chitester et al. (1984): Reynolds number at minimum fluidization.

        Re_mf = sqrt(28.7^2 + 0.0494 Ar) - 28.7,  u_mf = Re_mf mu / (rho d_p)

    Parameters
    ----------
    Ar : [-] Archimedes number d_p^3 rho (rho_solid - rho) g / mu^2

    Returns
    -------
    [-] Reynolds number of u_mf and the particle diameter

    Range
    -----
    Ar : 0 to inf

    Fitted to
    ---------
    coarse particles, also at high pressure; the bounds of the data have not been seen

    Limits
    ------
    Ar -> 0: 0.000861 Ar. Ar -> inf: 0.222 sqrt(Ar).

    Example
    -------
    >>> round(float(minimum_fluidization_chitester(Ar=1e4)), 6)
    7.6

    Source
    ------
    Chitester, Kornosky, Fan, Danko 1984, Chem. Eng. Sci. 39, 253-261.
    Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering, p. 69.
    """
    return (28.7**2 + 0.0494 * Ar) ** 0.5 - 28.7


@closure(kind="minimum_fluidization", unit="-", ranges={"Ar": (0, _INF)}, source=_GRACE)
def minimum_fluidization_grace(Ar):
    """Grace (1982): Reynolds number at minimum fluidization.

        Re_mf = sqrt(27.2^2 + 0.0408 Ar) - 27.2,  u_mf = Re_mf mu / (rho d_p)

    Parameters
    ----------
    Ar : [-] Archimedes number d_p^3 rho (rho_solid - rho) g / mu^2

    Returns
    -------
    [-] Reynolds number of u_mf and the particle diameter

    Range
    -----
    Ar : 0 to inf

    Fitted to
    ---------
    a revision of the constants of minimum_fluidization_wen_yu; the bounds of the data have not been seen

    Limits
    ------
    Ar -> 0: 0.00075 Ar. Ar -> inf: 0.202 sqrt(Ar).

    Example
    -------
    >>> round(float(minimum_fluidization_grace(Ar=1e4)), 6)
    6.679787

    Source
    ------
    Grace 1982, in Hetsroni (ed.), Handbook of Multiphase Systems, chapter 8, Hemisphere, Washington.
    Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering, p. 69.
    """
    return (27.2**2 + 0.0408 * Ar) ** 0.5 - 27.2


@closure(kind="minimum_fluidization", unit="-", ranges={"Ar": (1.65, 3.99e8)}, source=_WEN_YU)
def minimum_fluidization_wen_yu(Ar):
    """Wen and Yu (1966): Reynolds number at minimum fluidization.

        Re_mf = sqrt(33.7^2 + 0.0408 Ar) - 33.7,  u_mf = Re_mf mu / (rho d_p)

    Parameters
    ----------
    Ar : [-] Archimedes number d_p^3 rho (rho_solid - rho) g / mu^2

    Returns
    -------
    [-] Reynolds number of u_mf and the particle diameter

    Range
    -----
    Ar : 1.65 to 3.99e8

    Fitted to
    ---------
    284 data of several authors, Re_mf from 0.001 to 4000, by the Ergun equation with shape and voidage joined

    Limits
    ------
    Ar -> 0: 0.000605 Ar. Ar -> inf: 0.202 sqrt(Ar).

    Example
    -------
    >>> round(float(minimum_fluidization_wen_yu(Ar=1e4)), 6)
    5.589821

    Source
    ------
    Wen, Yu 1966, AIChE J. 12, 610-612, doi:10.1002/aic.690120343.
    Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering, p. 69.
    """
    return (33.7**2 + 0.0408 * Ar) ** 0.5 - 33.7
