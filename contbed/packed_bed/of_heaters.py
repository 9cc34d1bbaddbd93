"""Results of heaters and coolers: a stream of particles and one of fluid that exchange
heat.

    counter-current  NTU = ln((1 - e C)/(1 - e)) / (1 - C),   e/(1 - e) where C = 1
    co-current       NTU = -ln(1 - e (1 + C)) / (1 + C)

are the transfer units of an exchanger of effectiveness e without conduction along the
streams; C is the smaller over the larger heat that the streams could exchange.
Source: Kays, London, Compact Heat Exchangers, 3rd ed., McGraw-Hill (1984), chapter 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import log
from typing import Any

import numpy as np

from contbed.fem.probe import peak

# of 1 - C below which the streams count as equal, and of the cosine between them below
# which they are parallel
EQUAL = 1e-9
SAME = 1e-9  # of the span: streams that close meet over a length, not at a point


def opposite(velocity: Any, other: Any) -> bool | None:
    """Return whether two streams are counter-current; None where they cross."""
    along = float(velocity @ other)
    speeds = float(np.linalg.norm(velocity) * np.linalg.norm(other))
    return along < 0.0 if abs(along) > (1.0 - EQUAL) * speeds else None


def effectiveness(
    duty: float, contents: Sequence[float], opposite: bool | None
) -> dict[str, float]:
    """Return the share of the most that the streams could exchange, and the transfer
    units.

    Parameters
    ----------
    duty : heat that the fluid takes up [W]
    contents : heat of each stream between the temperatures at which they enter [W]
    opposite : whether the streams are counter-current; None of streams that cross, for
        which there are no transfer units
    """
    if not min(contents) > 0.0:
        return {}
    share = abs(duty) / min(contents)
    if opposite is None:
        return {"effectiveness": share}
    units = transfer_units(share, min(contents) / max(contents), opposite)
    return {"effectiveness": share} | ({} if units is None else {"NTU": units})


def transfer_units(e: float, C: float, opposite: bool) -> float | None:
    """Return the number of transfer units of an exchanger; None where no exchanger is
    as good, or where it is rounding, as the streams leave with what they could reach.
    """
    if not opposite:
        left = 1.0 - e * (1.0 + C)
        return -log(left) / (1.0 + C) if left > SAME else None
    if not 1.0 - e > SAME:
        return None
    if 1.0 - C < EQUAL:
        return e / (1.0 - e)
    return log((1.0 - e * C) / (1.0 - e)) / (1.0 - C)


def pinch(x: Any, gap: Any, span: float) -> dict[str, float]:
    """Return the least distance of temperatures along the bed, and the first place
    where they are as close, but for `SAME` of the span.

    Parameters
    ----------
    x : positions [m], increasing
    gap : difference of temperatures there [K]; a parabola through three points gives
        the least of it between them, and it is 0 where the streams cross
    span : of the temperatures [K]
    """
    apart = np.abs(gap)
    where, least = peak(x, -apart)
    least = 0.0 if gap.min() < 0.0 < gap.max() else -least
    over = apart - (least + SAME * span)
    first = int(np.argmax(over <= 0.0))
    if over[first] <= 0.0 and first < np.argmin(apart):
        before = slice(max(first - 1, 0), first + 1)
        where = float(np.interp(0.0, -over[before], x[before]))
    return {"pinch_K": least, "pinch_m": where}
