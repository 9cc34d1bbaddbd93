"""How fast particles follow the gas around them: exact uptake, cheaper laws, and what
these change in a bed.

A particle that begins at 0 in a gas that becomes 1 takes up H times what it would
without any resistance inside, with p the variable of Laplace over time in units of
R^2/alpha, Bi = h R/k and s = 3, 2, 1 for spheres, cylinders, slabs:

    interior     H = phi/(Bi + phi),    phi = sqrt(p) coth(sqrt p) - 1,  sqrt(p) I1/I0,  sqrt(p) tanh(sqrt p)
    effective    H = K p/(p + s K Bi),  K = 1/(1 + Bi/(s + 2)): one temperature, 1/h_eff = 1/h + R/((s + 2) k)
    lumped       the same with K = 1:   one temperature, external film only
    n points     H = 1/(1 + s Bi g),    g = sum_m v_m^2/(p + lambda_m) over the modes of `interior`, v at the surface

    bed at rest, step at the inlet:     gas = L^-1{exp(-xi H)/p},  xi = h a z/(G c)
    steady bed that moves, gas along:   gas = L^-1{1/(p + s Gamma Bi H)} at Fo = alpha L/(v R^2); against: 1 over it

Gamma is the heat capacity flow of the solids over that of the gas, negative where the
gas flows against them. L^-1 is taken on Talbot's contour. The corrected coefficient is
the linear driving force of Glueckauf.

Source: Rosen, J. Chem. Phys. 20 (1952) 387, doi:10.1063/1.1700431; Glueckauf, Trans.
    Faraday Soc. 51 (1955) 1540,
doi:10.1039/TF9555101540; Abate, Valko, Int. J. Numer. Meth. Eng. 60 (2004) 979,
doi:10.1002/nme.995.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from contbed.arrays import Array
from contbed.particle.interior import SURFACE_OVER_VOLUME, interior

# a number is that of points inside
Level = Literal["lumped", "effective", "interior"] | int
# on Talbot's contour: errors of truncation and of rounding are both near 1e-10
NODES = 32
# over the largest possible; flows of heat that differ by less are equal
LEAST_GROWTH = 1e-9
# of the mean breakthrough, at which levels are compared: short beds differ most when
# the gas arrives
TIMES = np.concatenate([np.geomspace(1e-5, 0.02, 40)[:-1], np.arange(1, 151) * 0.02])
# size of p below which a sphere's difference of all but equal numbers is a series,
# exact to 1e-12
SMALL = 0.01
# with which errors of a breakthrough are up to 2e-7; those of 100 are 0.03
MOST_UNITS = 80.0
# transfer units, of films and insides together, beyond which a breakthrough is compared
# at this many: differences fall with more
LONGEST = 50.0


def correction(biot: float, shape: str = "sphere") -> float:
    """Return the film coefficient over the one that one temperature per particle
    needs, 1 + Bi/(s + 2).
    """
    return 1.0 + biot / (SURFACE_OVER_VOLUME[shape] + 2)


def _inside(biot: float, level: Level, shape: str) -> float:
    """Return the transfer units of films over those with an inside; 1 of points and of
    one temperature, whose transforms have large values on the contour.
    """
    return correction(biot, shape) if level in ("interior", "effective") else 1.0


def uptake(
    p: Any, biot: float, level: Level = "interior", shape: str = "sphere"
) -> Any:
    """Return H of the module at p, real or complex and not 0."""
    if level == "interior":
        phi = _potential(np.sqrt(np.asarray(p, dtype=complex)), shape)
        return phi / (biot + phi)
    if isinstance(level, int):
        rates, modes = interior(level, shape).modes()
        admitted = (modes[-1] ** 2 / (np.asarray(p)[..., None] + rates)).sum(axis=-1)
        return 1.0 / (1.0 + SURFACE_OVER_VOLUME[shape] * biot * admitted)
    share = 1.0 if level == "lumped" else 1.0 / correction(biot, shape)
    return share * p / (p + SURFACE_OVER_VOLUME[shape] * share * biot)


def _potential(root: Any, shape: str) -> Any:
    """Return phi of the module; arguments of large real part do not overflow."""
    if shape == "cylinder":
        from scipy.special import ive

        return root * ive(1, root) / ive(0, root)
    tanh = -np.expm1(-2.0 * root) / (1.0 + np.exp(-2.0 * root))
    if shape == "slab":
        return root * tanh
    p = root * root
    series = p * (1.0 / 3.0 + p * (-1.0 / 45.0 + p * (2.0 / 945.0 - p / 4725.0)))
    return np.where(np.abs(p) < SMALL, series, root / tanh - 1.0)


def invert(transform: Callable[[Any], Any], times: Array) -> Array:
    """Return the inverse Laplace transform at times (n,) above 0, on Talbot's
    contour.
    """
    angle = np.arange(1, NODES) * np.pi / NODES
    cotangent = 1.0 / np.tan(angle)
    delta = np.concatenate(
        [[0.4 * NODES], 0.4 * np.arange(1, NODES) * np.pi * (cotangent + 1j)]
    )
    slope = 1.0 + 1j * angle * (1.0 + cotangent**2) - 1j * cotangent
    gamma = np.concatenate([[0.5 * np.exp(delta[0])], slope * np.exp(delta[1:])])
    p = delta[None, :] / times[:, None]
    values: Array = 0.4 / times * np.real((transform(p) * gamma).sum(axis=1))
    return values


def breakthrough(
    xi: float,
    eta: Array,
    biot: float,
    level: Level = "interior",
    shape: str = "sphere",
) -> Array:
    """Return the temperature of the gas after a step at the inlet, eta = h a t/C_solid
    (n,) > 0 after it.

    Raises
    ------
    ValueError : more than `MOST_UNITS` transfer units xi, for which rounding on the
        contour is larger than the result
    """
    if xi > MOST_UNITS * _inside(biot, level, shape):
        raise ValueError(
            f"xi = {xi:g} transfer units; a breakthrough is inverted up to "
            f"{MOST_UNITS * _inside(biot, level, shape):g}"
        )
    fourier = eta / (SURFACE_OVER_VOLUME[shape] * biot)
    return invert(lambda p: np.exp(-xi * uptake(p, biot, level, shape)) / p, fourier)


def moving_bed(
    gamma: float,
    biot: float,
    fourier: float,
    level: Level = "interior",
    shape: str = "sphere",
) -> float:
    """Return the temperature of the gas where it leaves a steady moving bed, between
    0 (solids in) and 1 (gas in).
    """
    s = SURFACE_OVER_VOLUME[shape]

    def denominator(p: Any) -> Any:
        return p + s * gamma * biot * uptake(p, biot, level, shape)

    # solids that hold more than a gas against them: the inverse grows as exp(growth
    # Fo), more than the contour takes
    growth = 0.0
    if gamma < -1.0:
        from scipy.optimize import brentq

        def real(p: float) -> float:
            return float(np.real(denominator(p)))

        high = -s * gamma * biot
        low = LEAST_GROWTH * high
        growth = float(brentq(real, low, high)) if real(low) < 0.0 else 0.0
    scaled = invert(lambda p: 1.0 / denominator(p + growth), np.array([fourier]))[0]
    return float(scaled if gamma > 0.0 else np.exp(-growth * fourier) / scaled)


def breakthrough_error(
    xi: float, biot: float, level: Level, shape: str = "sphere", last: float = np.inf
) -> float:
    """Return the largest error of a breakthrough that a cheaper level makes, over the
    height of the step.

    `last` is the end of the run over the time of the mean breakthrough.
    """
    units = min(xi, LONGEST * _inside(biot, level, shape))
    share = 1.0 / correction(biot, shape) if level == "effective" else 1.0
    # when the gas arrives, H is K, and 1 with an inside
    at_once = abs(np.exp(-units * share) - np.exp(-units))
    times = TIMES[last > TIMES]
    if not len(times):
        return float(at_once)
    exact, cheap = (
        breakthrough(units, units * times, biot, each, shape)
        for each in ("interior", level)
    )
    return float(max(at_once, np.abs(cheap - exact).max()))


def moving_bed_error(
    gamma: float, biot: float, fourier: float, level: Level, shape: str = "sphere"
) -> float:
    """Return the error of the temperatures leaving a steady moving bed by a cheaper
    level, over the span of inlets.

    The heat that the gas gives is what the solids take: the error of their mean
    temperature is 1/|Gamma| of its own.
    """
    exact, cheap = (
        moving_bed(gamma, biot, fourier, each, shape) for each in ("interior", level)
    )
    return abs(cheap - exact) * max(1.0, 1.0 / abs(gamma))


def steady_error(xi: float, biot: float, level: Level, shape: str = "sphere") -> float:
    """Return the largest error of gas that passes particles of one temperature in a
    steady bed, over the span.

    The corrected coefficient and any points inside are exact there; with the external
    film only the gas misses exp(-x/c) - exp(-x) after x transfer units, c the
    correction, most at x = c ln(c)/(c - 1).
    """
    c = correction(biot, shape)
    if level != "lumped" or c == 1.0:
        return 0.0
    x = min(xi, c * float(np.log(c)) / (c - 1.0))
    return float(np.exp(-x / c) - np.exp(-x))
