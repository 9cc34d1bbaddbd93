"""Particles above a fluidized bed: how many are thrown up, how they fall back, and
what the gas carries away.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.bubbles import GRAVITY
from contbed.closures.registry import Value, closure

_INF = float("inf")
_PEMBERTON = "Pemberton, Davidson 1986, Chem. Eng. Sci. 41, 243-251 and 253-262"
_WEN_CHEN = "Wen, Chen 1982, AIChE J. 28, 117-128, doi:10.1002/aic.690280117"
_KL = (
    "Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, "
    "Butterworth-Heinemann, Boston"
)
_GELDART = (
    "Geldart, Cullinan, Georghiades, Gilvray, Pope 1979, Trans. Inst. Chem. "
    "Eng. 57, 269-275"
)
_COLAKYAN = "Colakyan, Levenspiel 1984, Powder Technol. 38, 223-232"
_HAIDER = (
    "Haider, Levenspiel 1989, Powder Technol. 58, 63-70, "
    "doi:10.1016/0032-5910(89)80008-7"
)


@closure(
    kind="terminal_velocity",
    ranges={"Ar": (0.0, 1e9), "sphericity": (0.5, 1.0)},
    source=_HAIDER,
)
def terminal_velocity_haider_levenspiel(
    Ar: Value, mu: Value, rho_gas: Value, d_p: Value, sphericity: Value
) -> Value:
    """Haider and Levenspiel (1989): a single particle that falls through resting gas.

        u_t = mu / (rho_gas d_p) Ar^(1/3) u x,  x = Ar^(1/3),  u = 1 / (18 / x^2 + (2.335 - 1.744 phi) / x^(1/2))

    d_p : [m] particle diameter, of the sphere of equal volume

    Fitted to: an approximation, explicit in the velocity, of drag measured on spheres
        and isometric particles
    Limits: Ar -> 0: Stokes' law, mu Ar / (18 rho_gas d_p).
    Source: As in Kunii and Levenspiel 1991, Eqs. 3.32 and 3.33.

    >>> u_t = terminal_velocity_haider_levenspiel(Ar=700.0, mu=4.5e-5, rho_gas=0.3, d_p=5e-4, sphericity=1.0)
    >>> round(float(u_t), 6)
    6.243238
    """
    x = Ar ** (1 / 3)
    return (
        mu / (rho_gas * d_p) * x / (18.0 / x**2 + (2.335 - 1.744 * sphericity) / x**0.5)
    )


@closure(kind="ejection", ranges={"u_excess": (0.0, _INF)}, source=_PEMBERTON)
def ejection_pemberton_davidson(
    rho_solid: Value, eps_mf: Value, u_excess: Value
) -> Value:
    """Pemberton and Davidson (1986): bubbles throw up their wakes.

        F_0 = 0.1 rho_solid (1 - eps_mf) u_excess

    Fitted to: particles of groups B and D, with a tenth of the bubble's volume ejected;
        fine ones come from the bubble's nose
    Limits: u_excess -> 0: 0.
    Source: Quoted from a public implementation.

    >>> round(float(ejection_pemberton_davidson(rho_solid=2600.0, eps_mf=0.5, u_excess=0.5)), 6)
    65.0
    """
    return 0.1 * rho_solid * (1.0 - eps_mf) * u_excess


@closure(kind="ejection", ranges={"u_excess": (0.0, _INF)}, source=_WEN_CHEN)
def ejection_wen_chen(d_b: Value, rho_gas: Value, mu: Value, u_excess: Value) -> Value:
    """Wen and Chen (1982): what leaves the surface of the bed, of particles that the
    gas can carry. In SI.

        F_0 = 3.07e-9 d_b rho_gas^3.5 g^0.5 u_excess^2.5 / mu^2.5

    d_b : [m] diameter of the bubbles at the surface

    Fitted to: fine and coarse particles near ambient conditions; the power of rho_gas
        makes it small in hot beds
    Limits: u_excess -> 0: 0.
    Source: Quoted from secondary sources; the density of gas is also printed with the
        power 2.5, for which the units fail.

    >>> round(float(ejection_wen_chen(d_b=0.1, rho_gas=1.2, mu=1.8e-5, u_excess=0.5)), 6)
    234.072821
    """
    return 3.07e-9 * d_b * rho_gas**3.5 * GRAVITY**0.5 * u_excess**2.5 / mu**2.5


@closure(
    kind="decay",
    ranges={"u_gas": (0.1, 1.25), "d_p": (5e-5, 8e-4)},
    source=_KL,
)
def decay_kunii_levenspiel(u_gas: Value, d_p: Value) -> Value:
    """Kunii and Levenspiel (1991): rate at which the flow of particles above a bed
    falls to what is carried away.

        a = 0.03918 (d_p / 1 um)^0.65883 / u_gas

    Fitted to: a fit to the curve of the book's figure 7.12, data of many authors
    Limits: d_p -> 0: 0, particles that follow the gas.
    Source: Fig. 7.12. Constants from a public implementation.

    >>> round(float(decay_kunii_levenspiel(u_gas=1.0, d_p=5e-4)), 6)
    2.35086
    """
    return 0.03918 * (1e6 * d_p) ** 0.65883 / u_gas


@closure(
    kind="elutriation",
    ranges={"u_gas": (0.1, 10.0), "u_t": (0.0, _INF)},
    source=_GELDART,
)
def elutriation_geldart(u_gas: Value, u_t: Value, rho_gas: Value) -> Value:
    """Geldart et al. (1979): what gas carries away of particles of one size, were the
    bed all of it.

        K = 23.7 rho_gas u_gas exp(-5.4 u_t / u_gas)

    Fitted to: sands and other solids of groups A and B
    Limits: u_t -> inf: 0.
    Source: From secondary sources, not checked against the paper.

    >>> round(float(elutriation_geldart(u_gas=1.0, u_t=0.5, rho_gas=0.3)), 6)
    0.477831
    """
    return 23.7 * rho_gas * u_gas * np.exp(-5.4 * u_t / u_gas)


@closure(
    kind="elutriation",
    ranges={"u_t/u_gas": (0.0, 1.0)},
    source=_COLAKYAN,
)
def elutriation_colakyan_levenspiel(
    u_gas: Value, u_t: Value, rho_solid: Value
) -> Value:
    """Colakyan and Levenspiel (1984): what gas carries away of particles of one size;
    none that fall faster than it.

        K = 0.011 rho_solid (1 - u_t / u_gas)^2  where u_t < u_gas, else 0

    Fitted to: particles of 36 mm/s to some m/s terminal velocity, ambient air
    Limits: u_t -> u_gas: 0, with zero slope.
    Source: From secondary sources, not checked against the paper.

    >>> round(float(elutriation_colakyan_levenspiel(u_gas=1.0, u_t=0.5, rho_solid=2600.0)), 6)
    7.15
    """
    return 0.011 * rho_solid * np.maximum(1.0 - u_t / u_gas, 0.0) ** 2
