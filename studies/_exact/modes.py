"""Modes exp(l x) of two energy equations with constant coefficients: their rates l."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from contbed.arrays import Array


def rates(
    flux_fluid: float,
    flux_solid: float,
    d_fluid: float,
    d_solid: float,
    ha: float,
    d_cross: float = 0.0,
) -> Array:
    """Return the signed rates l [1/m] of the modes exp(l x), ascending, correctly
    rounded.

    One for each root of the cubic: three with conduction in both phases, fewer without.
    Layers at x = 0 are 1/|l| wide with l < 0, layers at x = L are 1/l wide with l > 0.
    Balanced counter-current flow has l = 0. The cubic is evaluated in exact rational
    arithmetic, so nearly equal roots and any ratio of magnitudes are resolved.
    """
    check_streams(flux_fluid, d_fluid, d_solid, ha, d_cross)
    c_f, c_s, d_f, d_s, h, d_x = (
        Fraction(v) for v in (flux_fluid, flux_solid, d_fluid, d_solid, ha, d_cross)
    )
    cubic = (
        h * (c_f + c_s),
        c_f * c_s - h * (d_f + d_s + 2 * d_x),
        -(d_f * c_s + c_f * d_s),
        d_f * d_s - d_x**2,
    )
    low_f, high_f = _single_phase_rates(flux_fluid, d_fluid, ha)
    low_s, high_s = _single_phase_rates(flux_solid, d_solid, ha)
    net = flux_fluid + flux_solid
    inner = min(high_f, high_s) if net > 0 else max(low_f, low_s)
    found = [
        _outer_root(cubic, start)
        for start in (min(low_f, low_s), max(high_f, high_s))
        if math.isfinite(start)
    ]
    if math.isfinite(inner):
        found.append(_root_between(cubic, inner, 0.0) if net else 0.0)
    return np.sort(np.array(found))


def check_streams(
    flux_fluid: float, d_fluid: float, d_solid: float, ha: float, d_cross: float
) -> None:
    """Raise ValueError if the coefficients do not fit the two-energy equations."""
    if not (flux_fluid > 0 and ha > 0 and d_fluid >= 0 and d_solid >= 0):
        raise ValueError(
            "two-energy solution: need flux_fluid > 0, ha > 0, d_fluid >= 0, d_solid "
            ">= 0, "
            f"got {flux_fluid:g}, {ha:g}, {d_fluid:g}, {d_solid:g}"
        )
    if d_cross and d_cross**2 >= d_fluid * d_solid:
        raise ValueError(
            "two-energy solution: need d_cross^2 < d_fluid d_solid, got d_cross = "
            f"{d_cross:g}"
        )


def _single_phase_rates(flux: float, d: float, ha: float) -> tuple[float, float]:
    """Return the roots of d l^2 - flux l - ha = 0, negative and positive; infinite
    where absent.

    They belong to one phase with the other held at zero.
    """
    large = abs(flux) + math.sqrt(flux**2 + 4.0 * d * ha)
    near = 2.0 * ha / large if large else math.inf
    far = large / (2.0 * d) if d else math.inf
    return (-near, far) if flux >= 0 else (-far, near)


def _outer_root(cubic: tuple[Fraction, ...], start: float) -> float:
    """Return the root beyond `start`, the larger single-phase rate in magnitude.

    The cubic times `start` is negative there.
    """
    end = 2.0 * start
    while _cubic(cubic, end)[0] * Fraction(end) < 0:
        end *= 2.0
    return _root_between(cubic, start, end)


def _root_between(cubic: tuple[Fraction, ...], start: float, end: float) -> float:
    """Newton iteration kept inside the bracket, to the last bit; `start` itself
    where rounding put it past the root.
    """
    if _cubic(cubic, start)[0] * Fraction(start) >= 0:
        return start
    x = 0.5 * (start + end)
    while x not in (start, end):
        value, derivative = _cubic(cubic, x)
        if value == 0:
            return x
        if value * Fraction(x) < 0:
            start = x
        else:
            end = x
        newton = float(Fraction(x) - value / derivative) if derivative else math.inf
        if newton == x:
            return x
        x = (
            newton
            if min(start, end) < newton < max(start, end)
            else 0.5 * (start + end)
        )
    return x


def _cubic(cubic: tuple[Fraction, ...], at: float) -> tuple[Fraction, Fraction]:
    """Return value and derivative of the cubic, exactly."""
    a0, a1, a2, a3 = cubic
    x = Fraction(at)
    return a0 + x * (a1 + x * (a2 + x * a3)), a1 + x * (2 * a2 + x * 3 * a3)
