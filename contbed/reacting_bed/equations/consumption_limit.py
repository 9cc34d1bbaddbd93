"""Rates that take of solids at rest no more than there is of them in a step of time.

    f_j = (L_j + gained_j)/lost_j    where solid j would lose more than L_j, else 1

multiplies all rates that take of j, so that species, heat and films see the same rate
as the solid. It is the limit of fluxes of Zalesak, for sources.

Source: Zalesak 1979, J. Comput. Phys. 31, 335-362, doi:10.1016/0021-9991(79)90051-2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

# of a rate, those at the points of particles; dual numbers or arrays at points of the
# bed
Parts = list[Any]


def within(
    rates: Sequence[Parts], reactions: Sequence[Any], most: Mapping[str, Any]
) -> list[Parts]:
    """Return rates by which no solid loses more than `most` at each
    point [mol/m3 bed/s], infinite for no limit.
    """
    found = list(rates)
    bound = {name: limit for name, limit in most.items() if np.isfinite(limit).any()}
    for _ in bound:  # what one solid keeps another does not gain
        for name, limit in bound.items():
            found = _slowed(
                found,
                [reaction.stoichiometry.get(name, 0.0) for reaction in reactions],
                limit,
            )
    return found


def _slowed(rates: list[Parts], counts: Sequence[float], limit: Any) -> list[Parts]:
    """Return rates of which those that take a solid are slower where it would lose
    more than a limit.
    """
    gained: Any = 0.0
    lost: Any = 0.0
    changes = [
        count * sum(parts[1:], parts[0]) if count else 0.0
        for parts, count in zip(rates, counts, strict=True)
    ]
    for change in changes:
        gained, lost = gained + np.maximum(change, 0.0), lost - np.minimum(change, 0.0)
    over = _plain(lost) - _plain(gained) > limit
    share = (np.where(over, limit, 0.0) + gained * over) / (lost * over + ~over)
    out = []
    for parts, change in zip(rates, changes, strict=True):
        takes = over & (_plain(change) < 0.0)
        out.append(
            [part * (share * takes + ~takes) for part in parts]
            if takes.any()
            else parts
        )
    return out


def _plain(value: Any) -> Any:
    return getattr(value, "value", value)
