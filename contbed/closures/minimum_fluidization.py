"""Minimum fluidization: a Reynolds number from the Archimedes number,
Re = sqrt(C1^2 + C2 Ar) - C1.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_INF = float("inf")
_WEN_YU = "Wen, Yu 1966, AIChE J. 12, 610-612, doi:10.1002/aic.690120343"
_CHITESTER = "Chitester, Kornosky, Fan, Danko 1984, Chem. Eng. Sci. 39, 253-261"
_RICHARDSON = (
    "Richardson 1971, in Davidson, Harrison (eds.), Fluidization, chapter 2, "
    "Academic Press, London"
)
_SAXENA = "Saxena, Vogel 1977, Trans. Inst. Chem. Eng. 55, 184-189"
_BABU = "Babu, Shah, Talwalkar 1978, AIChE Symp. Ser. 74 (176), 176-186"
_ERGUN = "Ergun 1952, Chem. Eng. Prog. 48, 89-94"
_GRACE = (
    "Grace 1982, in Hetsroni (ed.), Handbook of Multiphase Systems, chapter 8, "
    "Hemisphere, Washington"
)


def _reynolds(C1: Value, C2_Ar: Value) -> Value:
    """Return sqrt(C1^2 + C2 Ar) - C1 without the difference, which loses all digits
    of fine particles.
    """
    return C2_Ar / ((C1**2 + C2_Ar) ** 0.5 + C1)


@closure(kind="minimum_fluidization", ranges={"Ar": (0, _INF)}, source=_CHITESTER)
def minimum_fluidization_chitester(Ar: Value) -> Value:
    """Chitester et al. (1984): Reynolds number at minimum fluidization.

        Re_mf = sqrt(28.7^2 + 0.0494 Ar) - 28.7,  u_mf = Re_mf mu / (rho d_p)

    Fitted to: coarse particles, also at high pressure; the bounds of the data have not
        been seen
    Limits: Ar -> 0: 0.000861 Ar. Ar -> inf: 0.222 sqrt(Ar).
    Source: Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering,
        p. 69.

    >>> round(float(minimum_fluidization_chitester(Ar=1e4)), 6)
    7.6
    """
    return _reynolds(28.7, 0.0494 * Ar)


@closure(kind="minimum_fluidization", ranges={"Ar": (0, _INF)}, source=_GRACE)
def minimum_fluidization_grace(Ar: Value) -> Value:
    """Grace (1982): Reynolds number at minimum fluidization.

        Re_mf = sqrt(27.2^2 + 0.0408 Ar) - 27.2,  u_mf = Re_mf mu / (rho d_p)

    Fitted to: a revision of the constants of minimum_fluidization_wen_yu; the bounds of
        the data have not been seen
    Limits: Ar -> 0: 0.00075 Ar. Ar -> inf: 0.202 sqrt(Ar).
    Source: Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering,
        p. 69.

    >>> round(float(minimum_fluidization_grace(Ar=1e4)), 6)
    6.679787
    """
    return _reynolds(27.2, 0.0408 * Ar)


@closure(kind="minimum_fluidization", ranges={"Ar": (1.65, 3.99e8)}, source=_WEN_YU)
def minimum_fluidization_wen_yu(Ar: Value) -> Value:
    """Wen and Yu (1966): Reynolds number at minimum fluidization.

        Re_mf = sqrt(33.7^2 + 0.0408 Ar) - 33.7,  u_mf = Re_mf mu / (rho d_p)

    Fitted to: 284 data of several authors, Re_mf from 0.001 to 4000, by the Ergun
        equation with shape and voidage joined
    Limits: Ar -> 0: 0.000605 Ar. Ar -> inf: 0.202 sqrt(Ar).
    Source: Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering,
        p. 69.

    >>> round(float(minimum_fluidization_wen_yu(Ar=1e4)), 6)
    5.589821
    """
    return _reynolds(33.7, 0.0408 * Ar)


@closure(kind="minimum_fluidization", ranges={"Ar": (0, _INF)}, source=_RICHARDSON)
def minimum_fluidization_richardson(Ar: Value) -> Value:
    """Richardson (1971): Reynolds number at minimum fluidization.

        Re_mf = sqrt(25.7^2 + 0.0365 Ar) - 25.7,  u_mf = Re_mf mu / (rho d_p)

    Fitted to: spheres; the bounds of the data have not been seen
    Limits: Ar -> 0: 0.00071 Ar. Ar -> inf: 0.191 sqrt(Ar).
    Source: Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering,
        p. 69.

    >>> round(float(minimum_fluidization_richardson(Ar=1e4)), 6)
    6.323273
    """
    return _reynolds(25.7, 0.0365 * Ar)


@closure(kind="minimum_fluidization", ranges={"Ar": (0, _INF)}, source=_SAXENA)
def minimum_fluidization_saxena_vogel(Ar: Value) -> Value:
    """Saxena and Vogel (1977): Reynolds number at minimum fluidization.

        Re_mf = sqrt(25.3^2 + 0.0571 Ar) - 25.3,  u_mf = Re_mf mu / (rho d_p)

    Fitted to: dolomite of wide distributions, hot and under pressure; the bounds of the
        data have not been seen
    Limits: Ar -> 0: 0.00113 Ar. Ar -> inf: 0.239 sqrt(Ar).
    Source: Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering,
        p. 69.

    >>> round(float(minimum_fluidization_saxena_vogel(Ar=1e4)), 6)
    9.500718
    """
    return _reynolds(25.3, 0.0571 * Ar)


@closure(kind="minimum_fluidization", ranges={"Ar": (0, _INF)}, source=_BABU)
def minimum_fluidization_babu(Ar: Value) -> Value:
    """Babu, Shah and Talwalkar (1978): Reynolds number at minimum fluidization.

        Re_mf = sqrt(25.3^2 + 0.0651 Ar) - 25.3,  u_mf = Re_mf mu / (rho d_p)

    Fitted to: coal, coke and char of many authors; the bounds of the data have not been
        seen
    Limits: Ar -> 0: 0.00129 Ar. Ar -> inf: 0.255 sqrt(Ar).
    Source: Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering,
        p. 69.

    >>> round(float(minimum_fluidization_babu(Ar=1e4)), 6)
    10.631741
    """
    return _reynolds(25.3, 0.0651 * Ar)


@closure(
    kind="minimum_fluidization",
    source=_ERGUN,
    ranges={"eps_mf": (0.36, 0.7), "sphericity": (0.3, 1.0)},
)
def minimum_fluidization_ergun(Ar: Value, eps_mf: Value, sphericity: Value) -> Value:
    """Ergun (1952): the weight of the bed against the pressure drop of a packing of
    known voidage and shape.

        K1 Re^2 + K2 Re = Ar,  K1 = 1.75 / (phi eps^3),  K2 = 150 (1 - eps) / (phi^2 eps^3)

    Fitted to: pressure drop of packed beds; sensitive to eps_mf, some 4 % in u_mf for 1
        % in it
    Limits: Ar -> 0: Ar / K2. Ar -> inf: sqrt(Ar / K1).
    Source: As in Kunii and Levenspiel 1991, Fluidization Engineering, Eqs. 3.21 to
        3.23.

    >>> round(float(minimum_fluidization_ergun(Ar=1e4, eps_mf=0.45, sphericity=0.86)), 6)
    7.218631
    """
    K1 = 1.75 / (sphericity * eps_mf**3)
    K2 = 150.0 * (1.0 - eps_mf) / (sphericity**2 * eps_mf**3)
    return _reynolds(0.5 * K2 / K1, Ar / K1)
