"""Fluidized beds: minimum fluidization, volume of bubbles, gas through the emulsion, mixing of the solids.

Minimum fluidization is a Reynolds number from the Archimedes number, Re = sqrt(C1^2 + C2 Ar) - C1.
"""

from __future__ import annotations

from contbed.closures.registry import closure

_INF = float("inf")
_WEN_YU = "Wen, Yu 1966, AIChE J. 12, 610-612, doi:10.1002/aic.690120343"
_CHITESTER = "Chitester, Kornosky, Fan, Danko 1984, Chem. Eng. Sci. 39, 253-261"
_RICHARDSON = "Richardson 1971, in Davidson, Harrison (eds.), Fluidization, chapter 2, Academic Press, London"
_SAXENA = "Saxena, Vogel 1977, Trans. Inst. Chem. Eng. 55, 184-189"
_BABU = "Babu, Shah, Talwalkar 1978, AIChE Symp. Ser. 74 (176), 176-186"
_ERGUN = "Ergun 1952, Chem. Eng. Prog. 48, 89-94"
_KL = "Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, Butterworth-Heinemann, Boston"
_SOUZA = "Souza-Santos 2010, Solid Fuels Combustion and Gasification, 2nd edition, CRC Press, Boca Raton"
_TOOMEY = "Toomey, Johnstone 1952, Chem. Eng. Prog. 48, 220-226"
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


@closure(kind="minimum_fluidization", unit="-", ranges={"Ar": (0, _INF)}, source=_RICHARDSON)
def minimum_fluidization_richardson(Ar):
    """Richardson (1971): Reynolds number at minimum fluidization.

        Re_mf = sqrt(25.7^2 + 0.0365 Ar) - 25.7,  u_mf = Re_mf mu / (rho d_p)

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
    spheres; the bounds of the data have not been seen

    Limits
    ------
    Ar -> 0: 0.00071 Ar. Ar -> inf: 0.191 sqrt(Ar).

    Example
    -------
    >>> round(float(minimum_fluidization_richardson(Ar=1e4)), 6)
    6.323273

    Source
    ------
    Richardson 1971, in Davidson, Harrison (eds.), Fluidization, chapter 2, Academic Press, London.
    Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering, p. 69.
    """
    return (25.7**2 + 0.0365 * Ar) ** 0.5 - 25.7


@closure(kind="minimum_fluidization", unit="-", ranges={"Ar": (0, _INF)}, source=_SAXENA)
def minimum_fluidization_saxena_vogel(Ar):
    """Saxena and Vogel (1977): Reynolds number at minimum fluidization.

        Re_mf = sqrt(25.3^2 + 0.0571 Ar) - 25.3,  u_mf = Re_mf mu / (rho d_p)

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
    dolomite of wide distributions, hot and under pressure; the bounds of the data have not been seen

    Limits
    ------
    Ar -> 0: 0.00113 Ar. Ar -> inf: 0.239 sqrt(Ar).

    Example
    -------
    >>> round(float(minimum_fluidization_saxena_vogel(Ar=1e4)), 6)
    9.500718

    Source
    ------
    Saxena, Vogel 1977, Trans. Inst. Chem. Eng. 55, 184-189.
    Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering, p. 69.
    """
    return (25.3**2 + 0.0571 * Ar) ** 0.5 - 25.3


@closure(kind="minimum_fluidization", unit="-", ranges={"Ar": (0, _INF)}, source=_BABU)
def minimum_fluidization_babu(Ar):
    """Babu, Shah and Talwalkar (1978): Reynolds number at minimum fluidization.

        Re_mf = sqrt(25.3^2 + 0.0651 Ar) - 25.3,  u_mf = Re_mf mu / (rho d_p)

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
    coal, coke and char of many authors; the bounds of the data have not been seen

    Limits
    ------
    Ar -> 0: 0.00129 Ar. Ar -> inf: 0.255 sqrt(Ar).

    Example
    -------
    >>> round(float(minimum_fluidization_babu(Ar=1e4)), 6)
    10.631741

    Source
    ------
    Babu, Shah, Talwalkar 1978, AIChE Symp. Ser. 74 (176), 176-186.
    Constants as given in Kunii and Levenspiel 1991, Fluidization Engineering, p. 69.
    """
    return (25.3**2 + 0.0651 * Ar) ** 0.5 - 25.3


@closure(
    kind="minimum_fluidization", unit="-", source=_ERGUN,
    ranges={"eps_mf": (0.36, 0.7), "sphericity": (0.3, 1.0)},
)
def minimum_fluidization_ergun(Ar, eps_mf, sphericity):
    """Ergun (1952): the weight of the bed against the pressure drop of a packing of known voidage and shape.

        K1 Re^2 + K2 Re = Ar,  K1 = 1.75 / (phi eps^3),  K2 = 150 (1 - eps) / (phi^2 eps^3)

    Parameters
    ----------
    Ar : [-] Archimedes number d_p^3 rho (rho_solid - rho) g / mu^2
    eps_mf : [-] voidage at minimum fluidization
    sphericity : [-] phi, surface of the sphere of equal volume over that of the particle

    Returns
    -------
    [-] Reynolds number of u_mf and the particle diameter

    Range
    -----
    eps_mf : 0.36 to 0.7
    sphericity : 0.3 to 1.0

    Fitted to
    ---------
    pressure drop of packed beds; sensitive to eps_mf, some 4 % in u_mf for 1 % in it

    Limits
    ------
    Ar -> 0: Ar / K2. Ar -> inf: sqrt(Ar / K1).

    Example
    -------
    >>> round(float(minimum_fluidization_ergun(Ar=1e4, eps_mf=0.45, sphericity=0.86)), 6)
    7.218631

    Source
    ------
    Ergun 1952, Chem. Eng. Prog. 48, 89-94.
    As in Kunii and Levenspiel 1991, Fluidization Engineering, Eqs. 3.21 to 3.23.
    """
    K1 = 1.75 / (sphericity * eps_mf**3)
    K2 = 150.0 * (1.0 - eps_mf) / (sphericity**2 * eps_mf**3)
    half = 0.5 * K2 / K1
    return (half**2 + Ar / K1) ** 0.5 - half


@closure(kind="bubble_fraction", unit="-", ranges={"u/u_mf": (1.0, _INF)}, source=_KL)
def bubble_fraction_kunii_levenspiel(u, u_mf, u_b, eps_mf):
    """Kunii and Levenspiel (1991): volume of bubbles, by how fast they rise past the gas of the emulsion.

        delta = (1 - w) (u - u_mf) / (u_b + s u_mf) + w u / u_b,  r = u_b eps_mf / u_mf
        s = 2 - S(r, 1) - S(r, 3) - S(r, 5),  w = S(r, 10),  S(r, c) = r^4 / (r^4 + c^4)

    Parameters
    ----------
    u : [m/s] superficial velocity
    u_mf : [m/s] that at minimum fluidization
    u_b : [m/s] velocity of the bubbles
    eps_mf : [-] voidage at minimum fluidization

    Returns
    -------
    [-] share of bubbles in the volume of the bed

    Range
    -----
    u/u_mf : 1.0 to inf

    Fitted to
    ---------
    nothing: balances of gas. The book switches s from 2 to 1, 0, -1 at r = 1, 3, 5 and to u / u_b at 10, which jumps;
    here the same limits join smoothly, each over a factor of 1.7 in r

    Limits
    ------
    r -> 0: (u - u_mf) / (u_b + 2 u_mf). r -> inf: u / u_b.

    Example
    -------
    >>> round(float(bubble_fraction_kunii_levenspiel(u=1.0, u_mf=0.2, u_b=1.8, eps_mf=0.45)), 6)
    0.450544

    Source
    ------
    Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, Butterworth-Heinemann, Boston, Eqs. 6.26 to 6.29.
    """
    r4 = (u_b * eps_mf / u_mf) ** 4
    s = 2.0 - r4 / (r4 + 1.0) - r4 / (r4 + 3.0**4) - r4 / (r4 + 5.0**4)
    vigorous = r4 / (r4 + 10.0**4)
    return (1.0 - vigorous) * (u - u_mf) / (u_b + s * u_mf) + vigorous * u / u_b


@closure(kind="bubble_fraction", unit="-", ranges={"u/u_mf": (1.0, _INF)}, source=_TOOMEY)
def bubble_fraction_two_phase(u, u_mf, u_b):
    """Toomey and Johnstone (1952): all gas beyond minimum fluidization flows as bubbles.

        delta = (u - u_mf) / u_b

    Parameters
    ----------
    u : [m/s] superficial velocity
    u_mf : [m/s] that at minimum fluidization
    u_b : [m/s] velocity of the bubbles

    Returns
    -------
    [-] share of bubbles in the volume of the bed

    Range
    -----
    u/u_mf : 1.0 to inf

    Fitted to
    ---------
    nothing: the two-phase theory, which gives bubbles somewhat too much gas

    Limits
    ------
    u -> u_mf: 0.

    Example
    -------
    >>> round(float(bubble_fraction_two_phase(u=1.0, u_mf=0.2, u_b=1.6)), 6)
    0.5

    Source
    ------
    Toomey, Johnstone 1952, Chem. Eng. Prog. 48, 220-226.
    """
    return (u - u_mf) / u_b


@closure(kind="emulsion_gas", unit="m/s", ranges={"u_mf": (0, _INF)}, source=_TOOMEY)
def emulsion_gas_two_phase(u_mf):
    """Toomey and Johnstone (1952): the emulsion stays at minimum fluidization.

        u_e = u_mf

    Parameters
    ----------
    u_mf : [m/s] superficial velocity at minimum fluidization

    Returns
    -------
    [m/s] gas through the emulsion, per section of emulsion

    Range
    -----
    u_mf : 0 to inf

    Fitted to
    ---------
    nothing: the two-phase theory

    Limits
    ------
    none

    Example
    -------
    >>> emulsion_gas_two_phase(u_mf=0.2)
    0.2

    Source
    ------
    Toomey, Johnstone 1952, Chem. Eng. Prog. 48, 220-226.
    """
    return 1.0 * u_mf


@closure(kind="emulsion_gas", unit="m/s", ranges={"delta": (0.0, 0.7), "wake": (0.0, 0.5)}, source=_KL)
def emulsion_gas_kunii_levenspiel(u_mf, eps_mf, delta, u_b, wake=0.2):
    """Kunii and Levenspiel (1991): the gas rises through particles that sink to make good for those in wakes.

        u_e = u_mf - eps_mf wake delta u_b / (1 - delta - wake delta)

    Parameters
    ----------
    u_mf : [m/s] superficial velocity at minimum fluidization
    eps_mf : [-] voidage at minimum fluidization
    delta : [-] share of bubbles in the volume
    u_b : [m/s] velocity of the bubbles
    wake : [-] volume of wake over that of bubble

    Returns
    -------
    [m/s] gas through the emulsion, per section of emulsion; below zero it flows down, which beds refuse

    Range
    -----
    delta : 0.0 to 0.7
    wake : 0.0 to 0.5

    Fitted to
    ---------
    nothing: balances of gas and solids

    Limits
    ------
    delta -> 0: u_mf.

    Example
    -------
    >>> round(float(emulsion_gas_kunii_levenspiel(u_mf=0.3, eps_mf=0.45, delta=0.2, u_b=1.0, wake=0.2)), 6)
    0.276316

    Source
    ------
    Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, Butterworth-Heinemann, Boston, Eqs. 6.39 and 6.40.
    """
    return u_mf - eps_mf * wake * delta * u_b / (1.0 - delta - wake * delta)


@closure(kind="nusselt", unit="-", ranges={"Re": (0.1, 100.0)}, source=_KL)
def nusselt_kunii_levenspiel(Re):
    """Kunii and Levenspiel (1969): fine particles of a fluidized bed, as measured by plug flow of the gas.

        Nu = 0.03 Re^1.3

    Parameters
    ----------
    Re : [-] superficial Reynolds number on d_p

    Returns
    -------
    [-] Nusselt number on d_p and the conductivity of the gas

    Range
    -----
    Re : 0.1 to 100.0

    Fitted to
    ---------
    data of many authors; below one since gas that bypasses in bubbles is counted. With bubbles as a phase of their own
    nusselt_gunn or nusselt_ranz_marshall is the choice

    Limits
    ------
    Re -> 0: 0.

    Example
    -------
    >>> round(float(nusselt_kunii_levenspiel(Re=10.0)), 6)
    0.598579

    Source
    ------
    Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, Butterworth-Heinemann, Boston, Fig. 11.6.
    Range read from secondary sources.
    """
    return 0.03 * Re**1.3


@closure(
    kind="solids_mixing", unit="m2/s", ranges={"delta": (0.0, 0.7), "wake": (0.0, 0.5)}, source=_KL
)
def solids_mixing_kunii_levenspiel(delta, u_b, d_b, u_mf, eps_mf, wake=0.2):
    """Kunii and Levenspiel (1969): vertical mixing of the solids by the wakes that bubbles carry up.

        D_s = wake^2 eps_mf delta d_b u_b^2 / (3 u_mf)

    Parameters
    ----------
    delta : [-] share of bubbles in the volume
    u_b : [m/s] velocity of the bubbles
    d_b : [m] their diameter
    u_mf : [m/s] superficial velocity at minimum fluidization
    eps_mf : [-] voidage at minimum fluidization
    wake : [-] volume of wake over that of bubble

    Returns
    -------
    [m2/s] axial dispersion of the solids

    Range
    -----
    delta : 0.0 to 0.7
    wake : 0.0 to 0.5

    Fitted to
    ---------
    nothing: the counter-current flow model with exchange between wake and emulsion; an order of magnitude

    Limits
    ------
    delta -> 0: 0.

    Example
    -------
    >>> round(float(solids_mixing_kunii_levenspiel(delta=0.3, u_b=1.0, d_b=0.1, u_mf=0.2, eps_mf=0.45)), 6)
    0.0009

    Source
    ------
    Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, Butterworth-Heinemann, Boston, chapter 6.
    Quoted from secondary sources.
    """
    return wake**2 * eps_mf * delta * d_b * u_b**2 / (3.0 * u_mf)


@closure(kind="expansion", unit="-", ranges={"u_excess": (0.0, _INF), "d_p": (5e-5, 5e-3)}, source=_SOUZA)
def expansion_souza_santos(u_excess, u_mf, d_p, rho_solid, rho_gas):
    """Souza-Santos (2010): height of a bed wider than 64 mm over its height at minimum fluidization. In SI.

        R = 1 + 14.314 u_excess^0.738 d_p^1.006 rho_solid^0.376 / (rho_gas^0.126 u_mf^0.937)

    Parameters
    ----------
    u_excess : [m/s] u - u_mf
    u_mf : [m/s] superficial velocity at minimum fluidization
    d_p : [m] particle diameter
    rho_solid : [kg/m3] density of the particles
    rho_gas : [kg/m3] density of the gas

    Returns
    -------
    [-] ratio of the heights

    Range
    -----
    u_excess : 0.0 to inf
    d_p : 5e-05 to 0.005

    Fitted to
    ---------
    beds of many authors, by Babu, Shah and Talwalkar (1978); the bounds of the data have not been seen

    Limits
    ------
    u_excess -> 0: 1.

    Example
    -------
    >>> round(float(expansion_souza_santos(u_excess=0.5, u_mf=0.2, d_p=7e-4, rho_solid=2600.0, rho_gas=0.3)), 6)
    1.58159

    Source
    ------
    Souza-Santos 2010, Solid Fuels Combustion and Gasification, 2nd edition, CRC Press, Boca Raton, Eq. 14.8.
    """
    return 1.0 + 14.314 * u_excess**0.738 * d_p**1.006 * rho_solid**0.376 / (rho_gas**0.126 * u_mf**0.937)
