"""Resistance of a bed to flow: permeability K [m2], Forchheimer constant c_F [-] and
Ergun's pressure gradient.

With the superficial velocity u relative to the solid, and p the pressure in the fluid,

    -dp/dx = mu u / K + c_F rho |u| u / sqrt(K)
"""

from __future__ import annotations

import math

import numpy as np

from contbed.closures.registry import Value, closure

_ERGUN = "Ergun 1952, Chem. Eng. Prog. 48, 89-94"
_CARMAN = (
    "Carman 1937, Trans. Inst. Chem. Eng. 15, 150-166, "
    "doi:10.1016/S0263-8762(97)80003-2"
)
_PIVEM = (
    "Pivem, de Lemos 2012, Int. J. Heat Mass Transfer, "
    "doi:10.1016/j.ijheatmasstransfer.2011.11.047"
)
_NAKAYAMA = (
    "Nakayama, Kuwahara 1999, J. Fluids Eng. 121, 427-433, doi:10.1115/1.2822227"
)
_WARD = "Ward 1964, J. Hydraul. Div. ASCE 90, 1-12, doi:10.1061/JYCEAJ.0001096"


@closure(kind="permeability", ranges={"eps": (0.3, 0.6)}, source=_ERGUN)
def permeability_ergun(d_p: Value, eps: Value) -> Value:
    """Ergun (1952): viscous part of the Ergun equation.

        K = d_p^2 eps^3 / (150 (1 - eps)^2)

    d_p : [m] particle diameter; of non-spherical particles 6 volume / surface

    Fitted to: gas flow through beds of spheres, sand and pulverised coke; the bounds on
        eps are those of usual packings
    Limits: eps -> 1: infinite. eps -> 0: 0.

    >>> f"{permeability_ergun(d_p=1e-3, eps=0.4):.6e}"
    '1.185185e-09'
    """
    return d_p**2 * eps**3 / (150 * (1 - eps) ** 2)


@closure(kind="permeability", ranges={"eps": (0.26, 0.7)}, source=_CARMAN)
def permeability_carman_kozeny(d_p: Value, eps: Value) -> Value:
    """Carman (1937): Kozeny's hydraulic-radius model with the constant 5.

        K = d_p^2 eps^3 / (180 (1 - eps)^2)

    d_p : [m] particle diameter; of non-spherical particles 6 volume / surface

    Fitted to: creeping flow through granular beds; the bounds on eps are those of usual
        packings
    Limits: eps -> 1: infinite. eps -> 0: 0.
    Source: The doi is that of the reprint.

    >>> f"{permeability_carman_kozeny(d_p=1e-3, eps=0.4):.6e}"
    '9.876543e-10'
    """
    return d_p**2 * eps**3 / (180 * (1 - eps) ** 2)


@closure(kind="permeability", ranges={"eps": (0.2, 0.9)}, source=_NAKAYAMA)
def permeability_kuwahara(d_p: Value, eps: Value) -> Value:
    """Nakayama and Kuwahara (1999): laminar flow through arrays of rods.

        K = d_p^2 eps^3 / (144 (1 - eps)^2)

    d_p : [m] rod diameter

    Fitted to: two-dimensional simulations of periodic arrays; the range is that of
        nusselt_kuwahara
    Limits: eps -> 1: infinite. eps -> 0: 0.
    Source: Quoted from secondary sources.

    >>> f"{permeability_kuwahara(d_p=1e-3, eps=0.4):.6e}"
    '1.234568e-09'
    """
    return d_p**2 * eps**3 / (144 * (1 - eps) ** 2)


@closure(kind="permeability", ranges={"eps": (0.2, 0.9)}, source=_PIVEM)
def permeability_pivem(d_p: Value, eps: Value) -> Value:
    """Pivem and de Lemos (2012): permeability_kuwahara as printed there, with eps
    squared instead of cubed.

        K = d_p^2 eps^2 / (144 (1 - eps)^2)

    Fitted to: nothing: most likely a misprint, but the tables of that paper follow it;
        see permeability_kuwahara
    Limits: eps -> 1: infinite. eps -> 0: 0.
    Source: Eq. 37.

    >>> f"{permeability_pivem(d_p=3e-3, eps=0.9):.6e}"
    '5.062500e-06'
    """
    return d_p**2 * eps**2 / (144 * (1 - eps) ** 2)


@closure(kind="forchheimer", ranges={"eps": (0.3, 0.6)}, source=_ERGUN)
def forchheimer_ergun(eps: Value) -> Value:
    """Ergun (1952): inertial part of the Ergun equation, to be used with
    permeability_ergun.

        c_F = 1.75 / sqrt(150 eps^3)

    Fitted to: gas flow through beds of spheres, sand and pulverised coke; the bounds on
        eps are those of usual packings
    Limits: eps -> 1: 0.143. eps -> 0: infinite.

    >>> round(forchheimer_ergun(eps=0.4), 6)
    0.56481
    """
    return 1.75 / (math.sqrt(150) * eps**1.5)


@closure(kind="forchheimer", ranges={"eps": (0.3, 0.6)}, source=_WARD)
def forchheimer_ward(eps: Value) -> Value:
    """Ward (1964): one constant for all granular media.

        c_F = 0.55

    eps : [-] porosity; only sets the shape of the result

    Fitted to: water through granular media; the bounds on eps are those of usual
        packings
    Limits: none

    >>> forchheimer_ward(eps=0.4)
    0.55
    """
    return 0.55 + 0.0 * eps


@closure(kind="pressure_gradient", ranges={"eps": (0.3, 0.6)}, source=_ERGUN)
def pressure_gradient_ergun(
    u: Value, d_p: Value, eps: Value, mu: Value, rho: Value
) -> Value:
    """Ergun (1952): pressure drop per length in the direction of u.

        -dp/dx = 150 mu (1 - eps)^2 / (d_p^2 eps^3) u + 1.75 rho (1 - eps) / (d_p eps^3) |u| u

    u : [m/s] superficial velocity relative to the solid, either sign
    d_p : [m] particle diameter; of non-spherical particles 6 volume / surface
    mu : [Pa s] viscosity of the fluid

    Fitted to: gas flow through beds of spheres, sand and pulverised coke; the bounds on
        eps are those of usual packings
    Limits: u -> 0: linear in u, slope continuous through 0. eps -> 1: 0.

    >>> round(float(pressure_gradient_ergun(u=0.5, d_p=3e-3, eps=0.4, mu=1.8e-5, rho=1.2)), 6)
    2484.375
    """
    viscous = 150 * mu * (1 - eps) ** 2 / (d_p**2 * eps**3)
    inertial = 1.75 * rho * (1 - eps) / (d_p * eps**3)
    return (viscous + inertial * np.abs(u)) * u
