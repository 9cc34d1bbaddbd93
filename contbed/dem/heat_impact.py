"""Heat exchanged by two particles in one impact: Hertz's collision and Zhou, Yu and
Horio's finite-element fit.

Equation numbers are those of Zhou, Hou and Yu 2011. Numbers or arrays that broadcast,
SI. `impact_of` and `conductance_of` are bare arithmetic, which the time loop compiles
(`contact_heat`).
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload, register_jitable
from numpy.typing import ArrayLike

from contbed.arrays import Array

_DURATION = 2.9432751843247043  # t_c v/delta_max = 2 sqrt(pi) Gamma(7/5)/Gamma(9/10)
DURATION5 = _DURATION**5 * (15.0 / 16.0) ** 2  # t_c^5 in units of m*^2/(R* E*^2 v)


class Impact(NamedTuple):
    """Largest overlap [m], duration [s] and largest contact radius [m] of an elastic
    collision.
    """

    overlap: Array
    duration: Array
    radius: Array


def _root(x: Any) -> Any:
    """Evaluate the square root; np.sqrt is not among the functions that numba has
    for GPUs.
    """
    return np.sqrt(x)


@overload(_root)
def _compiled_root(x: Any) -> Callable[[Any], Any]:
    def root(x: Any) -> Any:
        return sqrt(x)

    return root


def hertz_impact(
    R: ArrayLike, mass: ArrayLike, modulus: ArrayLike, speed: ArrayLike
) -> Impact:
    """Evaluate an elastic collision at a normal speed (Hertz; Johnson, Contact
    Mechanics, 1985, eq. 11.23-11.24).

        delta = (15 m* v^2/(16 E* sqrt(R*)))^(2/5),  t_c = 2.9432752 delta/v,  r_c = sqrt(R* delta)

    Parameters
    ----------
    R, mass : reduced radius R* = R_i R_j/(R_i + R_j) [m] and mass m* [kg]
    modulus : reduced modulus E*, 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j [Pa]
    speed : normal relative speed before the impact [m/s], > 0
    """
    R, mass, modulus, speed = (
        np.asarray(item, dtype=float) for item in (R, mass, modulus, speed)
    )
    return Impact(*impact_of(R, mass, modulus, speed))


@register_jitable(error_model="numpy")
def impact_of(R: Any, mass: Any, modulus: Any, speed: Any) -> Any:
    """Evaluate largest overlap, duration and contact radius as `hertz_impact`."""
    overlap = (15.0 * mass * speed**2 / (16.0 * modulus * _root(R))) ** 0.4
    return overlap, _DURATION * overlap / speed, _root(R * overlap)


@register_jitable(error_model="numpy")
def impact_factor(fourier: Any, s: Any) -> Any:
    """Evaluate c' of Eq. 7 [-] (Zhou, Yu, Horio 2008, doi:10.1016/j.cej.2007.08.024, as
    quoted by public codes).

        c' = 0.435 (sqrt(C2^2 - 4 C1 (C3 - Fo)) - C2)/C1, Ck quadratic in s

    Parameters
    ----------
    fourier : Fo = k_i t_c/((rho c)_i r_c^2) of the particle of smaller rho c
    s : the smaller rho c over the larger one
    """
    C1 = -2.300 * s**2 + 8.909 * s - 4.235
    C2 = 8.169 * s**2 - 33.770 * s + 24.885
    C3 = -5.758 * s**2 + 24.464 * s - 20.511
    # the smaller root without cancellation: C1 vanishes at s = 0.556
    return (
        0.435 * -4.0 * (C3 - fourier) / (_root(C2**2 - 4.0 * C1 * (C3 - fourier)) + C2)
    )


def impact_conductance(
    impact: Impact,
    k: tuple[ArrayLike, ArrayLike],
    heat: tuple[ArrayLike, ArrayLike],
    factor: ArrayLike = 1.0,
) -> Array:
    """Evaluate the conduction [W/K] during an impact (Eq. 7); times t_c it is the heat
    of one impact [J/K].

        G = c' pi r_c^2 t_c^(-1/2)/((rho c k)_i^(-1/2) + (rho c k)_j^(-1/2))

    Parameters
    ----------
    impact : of the simulated, soft particles
    k : conductivities [W/m/K] of the two particles
    heat : their rho c [J/m3/K]
    factor : c = (E/E_0)^(1/5), `heat_pair.correction` with IMPACT. The real impact has
        r_c and t_c smaller by c and c^2, and its heat, which goes with r_c^2 sqrt(t_c),
        is smaller by c^3: it is spread over the simulated duration.

    Returns
    -------
    G [W/K], symmetric in the particles.
    """
    constants = constants_of(k, heat)
    G: Array = np.asarray(factor, dtype=float) ** 3 * conductance_of(
        impact.duration, impact.radius, *constants
    )
    return G


def constants_of(
    k: tuple[ArrayLike, ArrayLike], heat: tuple[ArrayLike, ArrayLike]
) -> tuple[Array, Array, Array]:
    """Return what Eq. 7 takes of two materials: diffusivity [m2/s] of that of smaller
    rho c, the smaller rho c over the larger one, both effusivities [W s^0.5/m2/K].
    """
    (k_i, k_j), (C_i, C_j) = (
        tuple(np.asarray(part, dtype=float) for part in pair) for pair in (k, heat)
    )
    lean = np.minimum(C_i, C_j)
    diffusivity = np.where(C_i <= C_j, k_i, k_j) / lean
    effusivity = 1.0 / ((C_i * k_i) ** -0.5 + (C_j * k_j) ** -0.5)
    return diffusivity, lean / np.maximum(C_i, C_j), effusivity


@register_jitable(error_model="numpy")
def conductance_of(
    duration: Any, radius: Any, diffusivity: Any, ratio: Any, effusivity: Any
) -> Any:
    """Evaluate Eq. 7 uncorrected [W/K]: ratio <= 1, diffusivity of the particle of
    smaller rho c, both effusivities.
    """
    # the correction changes t_c and r_c^2 alike, so that Fo is that of the real impact
    # as well
    factor = impact_factor(diffusivity * duration / radius**2, ratio)
    return factor * np.pi * radius**2 * effusivity / _root(duration)
