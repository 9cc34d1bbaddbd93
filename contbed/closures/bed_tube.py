"""Heat between a fluidized bed and immersed tubes or walls [W/m2/K], without
radiation.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.bubbles import GRAVITY
from contbed.closures.registry import Value, closure

GAS_CONSTANT = 8.314462618  # [J/mol/K]
_INF = float("inf")
_MOLERUS = (
    "Molerus, Wirth 1997, Heat Transfer in Fluidized Beds, Chapman & Hall, London"
)
_ZABRODSKY = (
    "Zabrodsky 1966, Hydrodynamics and Heat Transfer in Fluidized Beds, MIT "
    "Press, Cambridge"
)
_PACKETS = (
    "Mickley, Fairbanks 1955, AIChE J. 1, 374-384, doi:10.1002/aic.690010317; Kunii, "
    "Levenspiel 1991, Fluidization Engineering, 2nd ed., chapter 13, Butterworth"
)
_MARTIN = "Martin 1984, Chem. Eng. Process. 18, 157-169 and 199-223"


@closure(
    kind="bed_tube",
    ranges={"Ar": (0.0, 1e8), "u_excess": (0.0, _INF)},
    source=_MOLERUS,
)
def bed_tube_molerus_wirth(
    Ar: Value,
    u_excess: Value,
    u_mf: Value,
    eps_mf: Value,
    rho_gas: Value,
    mu: Value,
    cp_gas: Value,
    k_gas: Value,
    rho_solid: Value,
    cp_solid: Value,
) -> Value:
    """Molerus and Wirth (1997): from fine to coarse particles, by the excess of gas.

        h = k_gas Nu / l,  l = (mu / (g^(1/2) (rho_solid - rho_gas)))^(2/3)
        p2 = k_gas / (2 cp_gas mu),  p4 = rho_gas / (rho_solid - rho_gas),  p7 = 1 - eps_mf
        p5 = (rho_solid cp_solid / (k_gas g))^(1/3) u_excess,  p6 = u_excess / u_mf
        Nu = 0.125 p7 / (1 + p2 + 0.28 p2 p7^2 p4^(1/2) p5^2 / p6) / (1 + 33.3 / (p6^(1/3) p5))
             + 0.165 Pr^(1/3) p4^(1/3) / (1 + 0.05 / p6)

    Ar : [-] Archimedes number d_p^3 rho (rho_solid - rho) g / mu^2; enters the range
        only

    Fitted to: vertical surfaces in beds of glass, sand, metals, up to 2 MPa. This
        equation covers the whole range; simpler ones hold below Ar = 100 and above 1e5
    Limits: u_excess -> 0: 0.
    Source: Quoted from secondary sources.

    >>> h = bed_tube_molerus_wirth(Ar=700.0, u_excess=0.5, u_mf=0.1, eps_mf=0.45, rho_gas=0.3, mu=4.5e-5,
    ...                            cp_gas=1150.0, k_gas=0.075, rho_solid=2600.0, cp_solid=1000.0)
    >>> round(float(h), 3)
    696.309
    """
    length = (mu / (GRAVITY**0.5 * (rho_solid - rho_gas))) ** (2 / 3)
    p2 = k_gas / (2.0 * cp_gas * mu)
    p4 = rho_gas / (rho_solid - rho_gas)
    p7 = 1.0 - eps_mf
    p5 = (rho_solid * cp_solid / (k_gas * GRAVITY)) ** (1 / 3) * u_excess
    p6 = u_excess / u_mf
    Pr = mu * cp_gas / k_gas
    turbulent = 1.0 + p2 + 0.28 * p2 * p7**2 * p4**0.5 * p5**2 / p6
    particles = 0.125 * p7 / turbulent / (1.0 + 33.3 / (p6 ** (1 / 3) * p5))
    return (
        k_gas
        / length
        * (particles + 0.165 * Pr ** (1 / 3) * p4 ** (1 / 3) / (1.0 + 0.05 / p6))
    )


@closure(kind="bed_tube", ranges={"Ar": (0.0, 1e2)}, source=_MOLERUS)
def bed_tube_molerus_laminar(
    Ar: Value, mu: Value, rho_gas: Value, cp_gas: Value, k_gas: Value, rho_solid: Value
) -> Value:
    """Molerus and Wirth (1997): the largest coefficient of fine particles.

        h = 1 / (l / (0.09 k_gas) + l / (0.09 cp_gas mu)),  l = (mu / (g^(1/2) (rho_solid - rho_gas)))^(2/3)

    Ar : [-] Archimedes number d_p^3 rho (rho_solid - rho) g / mu^2; enters the range
        only

    Fitted to: fine particles well fluidized; without influence of diameter and velocity
    Limits: cp_gas -> inf: 0.09 k_gas / l.
    Source: Quoted from secondary sources.

    >>> round(float(bed_tube_molerus_laminar(Ar=50.0, mu=4.5e-5, rho_gas=0.3, cp_gas=1150.0, k_gas=0.075,
    ...                                      rho_solid=2600.0)), 3)
    881.65
    """
    length = (mu / (GRAVITY**0.5 * (rho_solid - rho_gas))) ** (2 / 3)
    return 0.09 / length / (1.0 / k_gas + 1.0 / (cp_gas * mu))


@closure(
    kind="bed_tube",
    ranges={"contact_time": (1e-3, 1e2)},
    source=_PACKETS,
    bounds={"gap": "[0, inf)"},
)
def bed_tube_kunii_levenspiel_packet(
    k_stagnant: Value,
    eps: Value,
    d_p: Value,
    rho_gas: Value,
    cp_gas: Value,
    k_gas: Value,
    rho_solid: Value,
    cp_solid: Value,
    contact_time: Value,
    gap: float = 0.1,
) -> Value:
    """Mickley and Fairbanks (1955): packets of particles and gas that stay at the wall
    for a time, behind the gas before the first particles.

        1 / h = (pi contact_time / (4 k_stagnant C))^(1/2) + gap d_p / k_gas
        C = (1 - eps) rho_solid cp_solid + eps rho_gas cp_gas

    eps : [-] porosity of the packets, in a bubbling bed that of the emulsion
    gap : [-] thickness of the gas at the wall over the particle diameter

    Fitted to: nothing but `gap`, d_p/10 by Xavier and Davidson (1985)
    Limits: contact_time -> 0: k_gas / (gap d_p). eps -> 1: packets of gas.
    Source: As in Kunii and Levenspiel (1991), from secondary sources, not checked
        against it. The share of time in which bubbles are at the wall is left out.

    >>> h = bed_tube_kunii_levenspiel_packet(k_stagnant=0.16, eps=0.42, d_p=5e-4, rho_gas=1.2, cp_gas=1005.0,
    ...                                      k_gas=0.026, rho_solid=2600.0, cp_solid=800.0, contact_time=0.5)
    >>> round(float(h), 3)
    298.586
    """
    C = (1.0 - eps) * rho_solid * cp_solid + eps * rho_gas * cp_gas
    packets = (np.pi * contact_time / (4.0 * k_stagnant * C)) ** 0.5
    return 1.0 / (packets + gap * d_p / k_gas)


@closure(kind="bed_tube", ranges={"d_p": (5e-5, 1e-3)}, source=_ZABRODSKY)
def bed_tube_zabrodsky(d_p: Value, rho_solid: Value, k_gas: Value) -> Value:
    """Zabrodsky (1966): the largest coefficient over the velocity of the gas. In SI.

        h_max = 35.8 rho_solid^0.2 k_gas^0.6 d_p^-0.36

    Fitted to: group A and B particles in air and other gases; conduction through gas
        around particles, so that coarse ones with their convection of gas are outside
    Limits: d_p -> inf: 0.
    Source: Quoted from secondary sources.

    >>> round(float(bed_tube_zabrodsky(d_p=5e-4, rho_solid=2600.0, k_gas=0.075)), 3)
    562.711
    """
    return 35.8 * rho_solid**0.2 * k_gas**0.6 * d_p**-0.36


@closure(
    kind="bed_tube",
    ranges={"Ar": (0.0, 1e8), "delta": (0.0, 0.9)},
    source=_MARTIN,
    bounds={"packets": "(0, inf)"},
)
def bed_tube_martin(
    Ar: Value,
    Pr: Value,
    delta: Value,
    eps_mf: Value,
    d_p: Value,
    T: Value,
    p: Value,
    molar_mass: Value,
    cp_gas: Value,
    k_gas: Value,
    rho_solid: Value,
    cp_solid: Value,
    packets: float = 2.6,
) -> Value:
    """Martin (1984): particles move as molecules of a gas do, and gas convects.

        h = k_gas / d_p ((1 - delta) (1 - eps_mf) Z (1 - exp(-N)) + 0.009 Pr^(1/3) Ar^(1/2)),  N = Nu_wp / (packets Z)
        Z = rho_solid cp_solid / (6 k_gas) (g d_p^3 delta / (5 (1 - delta) (1 - eps_mf)))^(1/2)
        Nu_wp = 4 ((1 + Kn) ln(1 + 1/Kn) - 1),  Kn = (2 (2 / gamma - 1) L) (2 / d_p)
        L = (2 pi R T / M)^(1/2) k_gas / (p (2 cp_gas - R / M)),  log10(1 / gamma - 1) = 0.6 - (1000 K / T + 1) / 2.8

    packets : [-] ratio of the time of contact to that of free flight

    Fitted to: `packets` to data of many authors, single tubes and walls
    Limits: delta -> 0: the gas's share alone.
    Source: As in the VDI Heat Atlas, section M5, from secondary sources, not checked
        against it.

    >>> h = bed_tube_martin(Ar=700.0, Pr=0.7, delta=0.25, eps_mf=0.45, d_p=5e-4, T=1100.0, p=101325.0, molar_mass=0.029,
    ...                     cp_gas=1150.0, k_gas=0.075, rho_solid=2600.0, cp_solid=1000.0)
    >>> round(float(h), 3)
    358.693
    """
    accommodation = 1.0 / (1.0 + 10.0 ** (0.6 - (1000.0 / T + 1.0) / 2.8))
    specific = GAS_CONSTANT / molar_mass
    path = (2.0 * np.pi * specific * T) ** 0.5 * k_gas / (p * (2.0 * cp_gas - specific))
    Kn = 4.0 * (2.0 / accommodation - 1.0) * path / d_p
    contact = 4.0 * ((1.0 + Kn) * np.log(1.0 + 1.0 / Kn) - 1.0)
    solids = (1.0 - delta) * (1.0 - eps_mf)
    motion = (GRAVITY * d_p**3 * delta / (5.0 * solids)) ** 0.5
    Z = rho_solid * cp_solid / (6.0 * k_gas) * motion
    particles = solids * Z * (1.0 - np.exp(-contact / (packets * Z)))
    return k_gas / d_p * (particles + 0.009 * Pr ** (1 / 3) * Ar**0.5)
