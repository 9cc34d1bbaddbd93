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

EQUAL = 1e-9  # of 1 - C, below which the streams count as equal
SAME = 1e-6  # of the span: streams that close meet over a length, not at a point


def effectiveness(
    duty: float, contents: Sequence[float], opposite: bool
) -> dict[str, float]:
    """Return the share of the most that the streams could exchange, and the transfer
    units.

    Parameters
    ----------
    duty : heat that the fluid takes up [W]
    contents : heat of each stream between the temperatures at which they enter [W]
    opposite : whether the streams are counter-current
    """
    if not min(contents) > 0.0:
        return {}
    share = abs(duty) / min(contents)
    units = transfer_units(share, min(contents) / max(contents), opposite)
    return {"effectiveness": share} | ({} if units is None else {"NTU": units})


def transfer_units(e: float, C: float, opposite: bool) -> float | None:
    """Return the number of transfer units of an exchanger; None where no exchanger is
    as good.
    """
    if not opposite:
        left = 1.0 - e * (1.0 + C)
        return -log(left) / (1.0 + C) if left > 0.0 else None
    if not e < 1.0:
        return None
    if 1.0 - C < EQUAL:
        return e / (1.0 - e)
    return log((1.0 - e * C) / (1.0 - e)) / (1.0 - C)


def pinch(x: Any, T_fluid: Any, T_solid: Any) -> dict[str, float]:
    """Return the least difference of temperatures along the bed, and the first place
    where it is as small, but for `SAME` of the span of temperatures.
    """
    apart = np.abs(np.asarray(T_solid) - np.asarray(T_fluid))
    least = float(apart.min())
    span = float(np.ptp([T_fluid, T_solid]))
    place = int(np.argmax(apart <= least + SAME * span))
    return {"pinch_K": least, "pinch_m": float(x[place])}
