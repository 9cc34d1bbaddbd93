"""A bed at rest without conduction, heated by a stream: fronts move along
characteristics and stay sharp.

    C_f (dT_f/dt + v dT_f/dz) = h a (T_s - T_f)          C_f = eps rho_f c_f,   v = u/eps
    C_s dT_s/dt               = h a (T_f - T_s)          C_s = (1-eps) rho_s c_s

Fluid parcels one cell long move one cell in each step dt = dz/v, which is exact, so a
front stays where it belongs. Half steps of exchange before and after use the exact
exponential of each parcel with its cell (Strang splitting, second order). Both parts
conserve heat to round-off.

Source: Schumann, J. Franklin Inst. 208 (1929) 405, doi:10.1016/S0016-0032(29)91186-8.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.compiled.functions import entry

Array = Any
AT_ONCE = 10**7  # cells times steps between two reports of the progress


@dataclass(frozen=True)
class Snapshot:
    """Temperatures [K] at one time [s]: of the parcels, centred at `z_fluid` [m],
    and of the cells at `z_solid`.
    """

    time: float
    z_fluid: Array
    T_fluid: Array
    z_solid: Array
    T_solid: Array

    def at(self, z: Array) -> tuple[Array, Array]:
        """Return both temperatures at positions z.

        They are linear between centres, without smearing the front between two parcels.
        """
        return _sharp(z, self.z_fluid, self.T_fluid), _sharp(
            z, self.z_solid, self.T_solid
        )


def _sharp(z: Array, centres: Array, values: Array) -> Array:
    """Reconstruct linearly in each cell with the smaller one-sided slope (minmod),
    which keeps a jump sharp.
    """
    width = centres[1] - centres[0]
    steps = np.diff(values)
    left = np.concatenate(([steps[0]], steps))
    right = np.concatenate((steps, [steps[-1]]))
    slope = np.where(np.abs(left) < np.abs(right), left, right) / width
    cell = np.clip(
        np.floor((z - centres[0]) / width + 0.5).astype(int), 0, len(centres) - 1
    )
    return values[cell] + slope[cell] * (z - centres[cell])


@dataclass(frozen=True)
class Phases:
    """Capacities of fluid and solid per bed volume [J/m3/K], and the coefficient h a
    between them [W/m3/K].
    """

    capacity_fluid: float
    capacity_solid: float
    exchange: float


def track(
    length: float,
    cells: int,
    velocity: float,
    phases: Phases,
    inlet: float,
    initial: tuple[float, float],
    times: Sequence[float],
    advance: Callable[[float], None] = lambda time: None,
) -> tuple[list[Snapshot], dict[str, float]]:
    """Return temperatures at rising `times` [s] in a bed of `length` [m] that a stream
    of `velocity` v > 0 enters.

    `velocity` is in m/s. Also returns the heat balance per cross-section [J/m2]: entered and left
    with the stream, relative to the fluid's initial temperature, and stored.
    """
    dz = length / cells
    dt = dz / velocity
    z = (np.arange(cells) + 0.5) * dz
    fluid, solid = np.full(cells, float(initial[0])), np.full(cells, float(initial[1]))
    capacity_fluid, capacity_solid = phases.capacity_fluid, phases.capacity_solid
    rate = phases.exchange * (1.0 / capacity_fluid + 1.0 / capacity_solid)
    share = capacity_fluid / (capacity_fluid + capacity_solid)

    snapshots: list[Snapshot] = []
    left, step = 0.0, 0
    parcel = capacity_fluid * dz
    half = -np.expm1(-0.5 * rate * dt)
    for time in times:
        last = int(time * (1 + 1e-12) / dt)
        while step < last:
            count = min(last - step, max(AT_ONCE // cells, 1))
            left += parcel * moved(
                fluid,
                solid,
                inlet,
                initial[0],
                half * share,
                capacity_solid / capacity_fluid,
                count,
            )
            step += count
            advance(step * dt)
        rest = max(time - step * dt, 0.0)
        gained = -np.expm1(-rate * rest) * (solid - fluid)
        parcels, cells_now = fluid + (1.0 - share) * gained, solid - share * gained
        entering = np.concatenate(([inlet], parcels))
        centres = np.concatenate(([z[0] - dz], z)) + velocity * rest
        snapshots.append(Snapshot(time, centres, entering, z, cells_now))
    entered = step * parcel * (inlet - initial[0])
    stored = parcel * float(np.sum(fluid - initial[0])) + capacity_solid * dz * float(
        np.sum(solid - initial[1])
    )
    return snapshots, {"in": entered, "out": left, "stored": stored}


@entry(cache=True, nogil=True)
def moved(
    fluid: Array,
    solid: Array,
    inlet: float,
    reference: float,
    to_solid: float,
    ratio: float,
    count: int,
) -> float:
    """Take `count` steps in place: exchange, parcels that move by a cell, exchange.

    Parameters
    ----------
    fluid, solid : temperatures (cells,) [K]
    to_solid : of the difference of temperatures, what a cell takes up in half a step
    ratio : of the capacities of solid and fluid

    Returns
    -------
    the sum of the temperatures of parcels that leave above `reference` [K]
    """
    # a parcel takes up what its cell has lost after rounding, so that no heat is lost in
    # a million steps
    left = 0.0
    for _ in range(count):
        for i in range(len(fluid) - 1, -1, -1):
            apart = solid[i] - fluid[i]
            before = solid[i]
            solid[i] -= to_solid * apart
            parcel = fluid[i] + ratio * (before - solid[i])
            if i == len(fluid) - 1:
                left += parcel - reference
                continue
            apart = solid[i + 1] - parcel
            before = solid[i + 1]
            solid[i + 1] -= to_solid * apart
            fluid[i + 1] = parcel + ratio * (before - solid[i + 1])
        apart = solid[0] - inlet
        before = solid[0]
        solid[0] -= to_solid * apart
        fluid[0] = inlet + ratio * (before - solid[0])
    return left
