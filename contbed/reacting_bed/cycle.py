"""Cyclic steady state of a reacting bed: what is stored, and how far an extrapolated
state may go; see `contbed.course.cycle`.

What is stored are temperatures over the range of the scene and of the bed after one
period; moles of solids over those that enter, of each phase; intraparticle
concentrations over that of the gas, of traces over their largest; mole fractions of a
gas in the pores over 1. What follows at once (a gas that is not stored, films, the
pressure) is no part of it. The change of a cycle is the largest of it over a period.

An extrapolated state may leave the bounds: amounts and fractions at or above zero,
temperatures no further than half of their size beyond those at the end of the period.
At each node where it does, the state there is moved towards that at the end of the
period, which is within, until it is: with one share for all that is stored at the node,
so that sums such as those of fractions, and of solids at rest of which one becomes the
other, stay. At worst this is plain repetition.

What no period changes, such as the moles of iron at a place of a bed at rest, is that
of the start.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array, Flags
from contbed.reacting_bed.equations.unknowns import LEAST_T
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.storage import gas_of_rings, stored_rows

# of the size of temperatures, by which an extrapolated one may leave those at the end
# of a period
BEYOND = 0.5


@dataclass(frozen=True, eq=False)
class Stored:
    """What is stored of a state, over its sizes; `rows` of the unknowns that store
    something, `sizes` (m,) of all.

    `gas` are the rows of the gas in the pores of each ring, none where it follows at
    once.
    """

    rows: NDArray[np.intp]
    sizes: Array
    gas: tuple[NDArray[np.intp], ...]
    warm: Flags  # which rows are temperatures

    @classmethod
    def of(cls, problem: Problem, sizes: Array) -> Stored:
        """Return what a problem stores."""
        rows = stored_rows(problem)
        gas = gas_of_rings(problem) if problem.bed.gas_pressure is not None else ()
        return cls(
            rows,
            sizes,
            gas,
            np.array([problem.unknowns[k].is_temperature for k in rows]),
        )

    def values(self, u: Array) -> Array:
        """Return what is stored of a state (m, N, p + 1) over sizes (rows, N,
        p + 1).
        """
        out = u / self.sizes[:, None, None]
        for rows in self.gas:
            out[rows] = u[rows] / u[rows].sum(axis=0)
        found: Array = out[self.rows]
        return found

    def in_kelvin(self, change: Array) -> float | None:
        """Return the largest change of a temperature."""
        if not self.warm.any():
            return None
        sizes = self.sizes[self.rows][self.warm]
        return float((change[self.warm] * sizes[:, None, None]).max())

    def bounded(self, values: Array, image: Array) -> Array:
        """Return the state with stored values, at nodes where these leave the bounds
        moved towards an image.
        """
        inside = self.values(image)
        wanted = values.reshape(inside.shape)
        low, high = np.minimum(inside, 0.0), np.full_like(inside, np.inf)
        if self.warm.any():
            T, coldest = inside[self.warm], LEAST_T / self.sizes[self.rows][self.warm]
            low[self.warm] = np.maximum(T.min(axis=(1, 2)) - BEYOND, coldest)[
                :, None, None
            ]
            high[self.warm] = T.max(axis=(1, 2))[:, None, None] + BEYOND
        step = wanted - inside
        with np.errstate(divide="ignore", invalid="ignore"):
            down = np.where(wanted < low, (inside - low) / -step, 1.0)
            up = np.where(wanted > high, (high - inside) / step, 1.0)
        share = np.clip(np.minimum(down, up).min(axis=0), 0.0, 1.0)
        return self._state(inside + share * step, image)

    def _state(self, values: Array, image: Array) -> Array:
        """Return a state with stored values; the rest is that of an image."""
        u = image.copy()
        u[self.rows] = values * self.sizes[self.rows][:, None, None]
        for rows in self.gas:
            at = np.searchsorted(self.rows, rows)
            u[rows] = values[at] * image[rows].sum(axis=0)
        return u
