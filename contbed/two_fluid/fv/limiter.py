"""Conservative limit on the solids flux, so that 0 <= eps_s <= eps_max holds after the
step whatever the flux.

A flux is only ever made smaller, and both its cells see the same flux, so mass is kept.
No cell gives more than it holds at the start of the step, so that what comes in is a
share of what is there afterwards. Fluxes into a cell that would overfill shrink to what
it can take, round by round, as one repair can fill a neighbour. If that does not end,
each cell's inflow shrinks to its room without counting on its outflow: then nothing
below can break a bound.

Cells that lose a large part of their particles in the step are marked: what they give
must have their own velocity and granular temperature, not a reconstructed one, or the
few particles left would keep the difference for all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.compiled import UNDERFLOW, Array, Flags, kernel
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.fv.halo import WHOLE, Halo

# then each inflow shrinks to the room of its cell
# (test_limiter_fills_a_row_cell_by_cell)
MAX_LIMITER_ROUNDS = 50
# share of its particles [-] that may leave a cell in a step, and that a limited outflow
# takes, smaller by rounding (test_limiter_empties_a_cell_in_one_round)
MAX_OUTFLOW, LIMITED_OUTFLOW = 1.0 - 1e-12, 1.0 - 2e-12
MIN_COUNTED_CHANGE = 1e-9  # [-] change of eps_s from which on a limited flux is counted
# share of its particles left in a cell, below which it gives its own values to its
# faces
MIN_LEFT = 0.75


class Bounds(NamedTuple):
    """Fraction (nc,) before the step, its source (nc,) [1/s], and the largest
    fraction.
    """

    s: Array
    source: Array
    highest: float


class Shares(NamedTuple):
    """Shares (nc,) of the flux into a cell and away from it that the bounds leave."""

    into: Array
    away: Array


@kernel
def _find_shares(
    g: Geometry,
    dt: float,
    bounds: Bounds,
    flux: Array,
    out: Array,
    last: bool,
    shares: Shares,
) -> bool:
    """Set the shares and `out`, eps_s after the step with `flux`; return whether all
    bounds hold.
    """
    s, highest, into, away = bounds.s, bounds.highest, shares.into, shares.away
    gain, loss, ni = np.empty(len(s)), np.empty(len(s)), len(g.right)
    for c in range(len(s)):
        gain[c] = max(0.0, bounds.source[c]) * g.volume[c]
        loss[c] = -min(0.0, bounds.source[c]) * g.volume[c]
    for f in range(len(g.left)):
        rate = flux[f]
        if rate >= 0.0:
            loss[g.left[f]] += rate
            if f < ni:
                gain[g.right[f]] += rate
        else:
            gain[g.left[f]] -= rate
            if f < ni:
                loss[g.right[f]] -= rate
    right = True
    for c in range(len(s)):
        out[c] = s[c] + dt * (gain[c] - loss[c]) / g.volume[c]
        into[c] = away[c] = 1.0
        content, room = s[c] * g.volume[c] / dt, (highest - s[c]) * g.volume[c] / dt
        if loss[c] > MAX_OUTFLOW * content:
            away[c] = LIMITED_OUTFLOW * content / loss[c]
            right = False
        if out[c] > highest or (last and gain[c] > room):
            into[c] = (
                LIMITED_OUTFLOW
                * max(0.0, room + (0.0 if last else loss[c] * away[c]))
                / gain[c]
            )
            right = False
    return right


@kernel
def _reduce(
    g: Geometry, dt: float, shares: Shares, flux: Array, touched: Flags
) -> None:
    """Reduce the flux of each face to the shares that its cells leave, and mark the
    faces where that counts.
    """
    into, away, ni = shares.into, shares.away, len(g.right)
    for f in range(len(g.left)):
        forward = flux[f] >= 0.0
        part = away[g.left[f]] if forward else into[g.left[f]]
        if f < ni:
            part = min(part, into[g.right[f]] if forward else away[g.right[f]])
        if part < 1.0:
            # a smaller change is rounding, as in cells that are empty but for rounding
            touched[f] |= (
                dt * abs(flux[f]) * (1.0 - part)
                > MIN_COUNTED_CHANGE * g.volume[g.left[f]]
            )
            flux[f] *= part


def limit(
    g: Geometry,
    dt: float,
    bounds: Bounds,
    flux: Array,
    out: Array,
    upwind_cells: Flags,
    halo: Halo = WHOLE,
) -> tuple[int, int]:
    """Limit `flux` in place, leave eps_s after the step in `out` and mark
    `upwind_cells` cells.

    Return the numbers of faces limited and of rounds.
    """
    touched = np.zeros(len(flux), dtype=np.bool_)
    shares = Shares(np.empty(len(out)), np.empty(len(out)))
    for turn in range(MAX_LIMITER_ROUNDS + 2):
        right = _find_shares(
            g, dt, bounds, flux, out, turn >= MAX_LIMITER_ROUNDS, shares
        )
        if halo.distributed:
            # the outer ghost cells lack faces
            own = shares.into[halo.cells], shares.away[halo.cells]
            right = not halo.any(bool(own[0].min() < 1.0 or own[1].min() < 1.0))
            halo.exchange(*(() if right else shares))
        if right:
            break
        _reduce(g, dt, shares, flux, touched)
    halo.exchange(out)
    out[out < UNDERFLOW] = 0.0
    upwind_cells[:] = out < MIN_LEFT * bounds.s
    return int(*halo.sum(int(touched[halo.faces].sum()))), turn
