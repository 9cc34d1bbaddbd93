"""How fast a porous particle reacts when diffusion inside and a film outside slow the
reaction down.

    eta = mean rate in the particle / rate at the state of its surface,    first order, isothermal:

    sphere    3 (phi coth phi - 1)/phi^2        R the radius
    slab      tanh(phi)/phi                     R half of the thickness

    phi = R sqrt(k/D)     Thiele modulus, k [1/s] per volume of particle, D [m2/s] effective diffusivity in the particle
    Bi  = k_film R/D      Biot number of mass;  1/eta_overall = 1/eta + phi^2/(n Bi), n = 3 (sphere), 1 (slab)

R is the radius, not volume over surface. All functions work on numbers, arrays and dual
numbers alike.

Source: Thiele, Ind. Eng. Chem. 31 (1939) 916, doi:10.1021/ie50355a027; Aris, Chem. Eng.
    Sci. 6 (1957) 262,
doi:10.1016/0009-2509(57)85028-3.
"""

from __future__ import annotations

from typing import Any

import numpy as np

# phi coth phi = sum_n B_2n (2 phi)^2n/(2n)!, B the Bernoulli numbers; eta from n = 1
# on, in powers of phi^2
SPHERE_SERIES = (
    1.0, -1.0 / 15.0, 2.0 / 315.0, -1.0 / 1575.0, 2.0 / 31185.0, -1382.0 * 3.0 / 638512875.0, 12.0 / 18243225.0,
)  # fmt: skip
# of tanh(phi)/phi, in powers of phi^2
SLAB_SERIES = (
    1.0,
    -1.0 / 3.0,
    2.0 / 15.0,
    -17.0 / 315.0,
    62.0 / 2835.0,
    -1382.0 / 155925.0,
    21844.0 / 6081075.0,
)
# phi below which the first seven terms are exact to 1e-14 and the closed form loses
# digits
SERIES_UP_TO = 0.15


def _series(coefficients: tuple[float, ...], square: Any) -> Any:
    total: Any = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        total = coefficient + total * square
    return total


def sphere(phi: Any) -> Any:
    """Effectiveness of a sphere [-] at a Thiele modulus phi = R sqrt(k/D) >= 0, any
    shape.

    >>> round(float(sphere(3.0)), 11)
    0.67163648998
    """
    small = phi < SERIES_UP_TO
    safe = np.where(small, 1.0, phi)
    return np.where(
        small,
        _series(SPHERE_SERIES, phi * phi),
        3.0 * (1.0 / np.tanh(safe) - 1.0 / safe) / safe,
    )


def slab(phi: Any) -> Any:
    """Effectiveness of a slab [-] at phi = L sqrt(k/D) >= 0, L half of its thickness.

    >>> round(float(slab(2.0)), 9)
    0.48201379
    """
    small = phi < SERIES_UP_TO
    safe = np.where(small, 1.0, phi)
    return np.where(small, _series(SLAB_SERIES, phi * phi), np.tanh(safe) / safe)


def overall(eta: Any, phi: Any, biot: Any, surface: float = 3.0) -> Any:
    """Effectiveness over the rate at the state of the gas [-], with a film in series.

    Parameters
    ----------
    eta : effectiveness over the rate at the surface
    phi : Thiele modulus R sqrt(k/D)
    biot : Biot number of mass k_film R/D > 0
    surface : R times surface over volume of the particle: 3 of a sphere, 2 of a long
        cylinder, 1 of a slab

    >>> round(float(overall(sphere(3.0), 3.0, 10.0)), 12)
    0.559002539021
    """
    return eta / (1.0 + eta * phi * phi / (surface * biot))


def thiele(radius: Any, rate_constant: Any, diffusivity: Any) -> Any:
    """Thiele modulus R sqrt(k/D) [-] of R [m], k [1/s] per volume of particle,
    D [m2/s]; 0 where k is not positive.

    Its derivative has no bound at k = 0; `effectiveness_of` has none of this.
    """
    return radius * np.sqrt(np.maximum(rate_constant, 0.0) / diffusivity)


def effectiveness_of(radius: Any, rate_constant: Any, diffusivity: Any) -> Any:
    """Effectiveness of a sphere [-] from R [m], k [1/s] per volume of particle and
    D [m2/s], smooth down to k = 0.

    Where k < 0, as between two steps of an iteration, the series is continued.

    >>> round(float(effectiveness_of(2e-3, 9.0, 4e-6)), 11)
    0.67163648998
    """
    square = radius * radius * rate_constant / diffusivity
    small = square < SERIES_UP_TO**2
    safe = np.where(small, 1.0, square)
    phi = np.sqrt(safe)
    return np.where(
        small, _series(SPHERE_SERIES, square), 3.0 * (phi / np.tanh(phi) - 1.0) / safe
    )
