"""Effectiveness of a sphere in which a reaction of first order releases or takes heat:
all its steady states.

    y'' + 2 y'/r = phi^2 y exp(g b (1 - y)/(1 + b (1 - y))),   y(1) = 1,  y'(0) = 0

    y    concentration over that at the surface           phi  R sqrt(k/D), k at the temperature of the surface
    g    E/(R_gas T_surface)                              b    (-dH) D c_surface/(k_e T_surface), Prater's number

The temperature follows from Prater's relation, T/T_surface = 1 + b (1 - y). With
s = phi r the problem is one of initial values, y(0) = y_0: each y_0 belongs to exactly
one phi, where y = 1. The curve phi(y_0) therefore holds all states; it turns at the
folds. It is integrated over u = ln y, which does not lose digits where the centre is
empty:

    q = s^2,  m = (du/ds)/s:    dq/du = 2/m,   dm/du = (F - 3 m - m^2 q)/(m q),   F = exp(g b (1 - y)/(1 + b (1 - y)))

from q = 0, m = F/3 at the centre to u = 0; phi = sqrt(q), eta = 3 m there.

Source: Weisz, Hicks, Chem. Eng. Sci. 17 (1962) 265, doi:10.1016/0009-2509(62)85005-2;
    Prater, Chem. Eng. Sci. 8 (1958)
284, doi:10.1016/0009-2509(58)80001-9.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Array = NDArray[np.float64]
RTOL = 1e-12  # of the integration from the centre
# share of the way from the centre over which the series of the centre is taken, exact
# to its fourth power
START = 1e-4
# imaginary step whose result over itself is a derivative without cancellation
COMPLEX = 1e-30
POINTS = 81  # of the curve phi(y_0), between which folds are looked for
# Thiele modulus up to which the curve is always followed: folds lie far below
WIDEST = 16.0
STEEPEST = 700.0  # exponents beyond this overflow


@dataclass(frozen=True)
class State:
    """One steady state of the particle."""

    eta: float  # mean rate over the rate at the state of the surface
    centre: float  # concentration at the centre over that at the surface


def _rate(u: Any, g: float, b: float) -> Any:
    used = -b * np.expm1(u)  # b (1 - y)
    return np.exp(g * used / (1.0 + used))


def _curve(centre: Any, g: float, b: float) -> tuple[Any, Any]:
    """Integrate from ln y_0 = `centre` < 0 (n,), real or complex; return phi and eta
    (n,).
    """
    u0 = np.atleast_1d(centre)
    rate = _rate(u0, g, b)
    slope = (_rate(u0 + 1e-5, g, b) - _rate(u0 - 1e-5, g, b)) / 2e-5
    # series of the centre: u = u0 + a s^2 + c s^4
    a = rate / 6.0
    c = (slope * a - 4.0 * a * a) / 20.0
    gone = -START * u0
    q = gone / a * (1.0 - c / a * gone / a)
    m = 2.0 * a + 4.0 * c * q

    def derivative(t: float, state: Any) -> Any:
        q, m = state.reshape(2, -1)
        u = u0 * (1.0 - t)
        dm = (_rate(u, g, b) - 3.0 * m - m * m * q) / (m * q)
        return np.concatenate([-u0 * 2.0 / m, -u0 * dm])

    start = np.concatenate([q, m])
    end = solve_ivp(
        derivative, (START, 1.0), start, method="DOP853", rtol=RTOL, atol=0.0
    ).y[:, -1]
    q, m = end.reshape(2, -1)
    return np.sqrt(q), 3.0 * m


def _phi(centre: float, g: float, b: float) -> float:
    return float(_curve(np.array([centre]), g, b)[0][0])


def _turns(centre: float, g: float, b: float) -> float:
    """Return dphi/d(ln y_0)."""
    return float(_curve(np.array([centre + 1j * COMPLEX]), g, b)[0][0].imag / COMPLEX)


def _check(g: float, b: float) -> None:
    if not b > -1.0:
        raise ValueError(
            f"b = {b:g}: Prater's number is above -1, or the temperature inside falls "
            "below 0 K"
        )
    if abs(g * b / (1.0 + max(b, 0.0))) > STEEPEST:
        raise ValueError(
            f"g = {g:g}, b = {b:g}: the rate changes by more than exp({STEEPEST:g}) in "
            "the particle"
        )


@lru_cache(maxsize=64)
def _table(g: float, b: float, largest: float) -> tuple[Array, Array]:
    """Return ln y_0 in falling order and phi on the curve, until phi exceeds
    `largest` for good.
    """
    deepest = -max(30.0, 2.0 * largest * float(np.sqrt(max(_rate(-30.0, g, b), 1.0))))
    centre = -np.geomspace(1e-10, -deepest, POINTS)
    # alike in size, for one step size each
    parts = [_curve(part, g, b)[0] for part in np.array_split(centre, 6)]
    return centre, np.concatenate(parts)


@lru_cache(maxsize=64)
def folds(g: float, b: float) -> tuple[tuple[float, State], ...]:
    """Return phi and state at every fold of the curve of states, from the full towards
    the empty centre.

    Raises
    ------
    ValueError : g and b that no particle has

    >>> [round(phi, 9) for phi, _ in folds(20.0, 0.6)]
    [0.57185855, 0.297320968]
    """
    _check(g, b)
    centre, phi = _table(g, b, WIDEST)
    rising = np.diff(phi) > 0.0
    found = []
    for k in np.flatnonzero(rising[1:] != rising[:-1]):
        at = brentq(
            _turns, centre[k], centre[k + 2], args=(g, b), xtol=1e-14, rtol=1e-12
        )
        where, eta = _curve(np.array([at]), g, b)
        found.append((float(where[0]), State(float(eta[0]), float(np.exp(at)))))
    return tuple(found)


def states(phi: float, g: float, b: float) -> list[State]:
    """Return all steady states of the particle at a Thiele modulus phi > 0, from the
    full towards the empty centre.

    Raises
    ------
    ValueError : phi not above 0, g and b that no particle has

    >>> [round(state.eta, 7) for state in states(0.4, 20.0, 0.6)]
    [1.1588263, 6.75788, 44.5473045]
    """
    _check(g, b)
    if not phi > 0.0:
        raise ValueError(f"phi = {phi:g}: the Thiele modulus is above 0")
    # in powers of 2, to be kept
    centre, values = _table(g, b, max(WIDEST, 2.0 ** np.ceil(np.log2(phi))))
    marks = sorted(
        [*centre, *(float(np.log(state.centre)) for _, state in folds(g, b))],
        reverse=True,
    )
    heights = np.interp(-np.array(marks), -centre, values)
    for where, state in folds(g, b):
        heights[marks.index(float(np.log(state.centre)))] = where
    found = []
    for k in np.flatnonzero((heights[:-1] < phi) != (heights[1:] < phi)):
        at = brentq(
            lambda x: _phi(x, g, b) - phi,
            marks[k],
            marks[k + 1],
            xtol=1e-15,
            rtol=1e-13,
        )
        found.append(
            State(float(_curve(np.array([at]), g, b)[1][0]), float(np.exp(at)))
        )
    return found


def hottest(b: float, centre: float) -> float:
    """Temperature at the centre over that of the surface, 1 + b (1 - y_0), by
    Prater's relation.
    """
    return 1.0 + b * (1.0 - centre)
