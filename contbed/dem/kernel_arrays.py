"""The arrays that the compiled kernels share, grouped by role, and the columns of their tables by name.

Tables are structured arrays, one row a pair of materials, a contact or a wall: `pairs[i, j].shear_modulus`,
`history[k].first_step`. All quantities are in SI.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Entries = NDArray[np.int32]  # of a Verlet list, see `neighbours`
Table = NDArray[np.void]
Row = Any  # of a Table; its columns are attributes in compiled code


def _columns(*names: str) -> np.dtype:
    return np.dtype([(name, np.float64) for name in names], align=True)


# effective moduli E*, G* [Pa], damping factors [Pa^0.5], Coulomb and rolling friction of a pair of materials [-]
PAIR = _columns(
    "youngs_modulus", "shear_modulus", "damping_normal", "damping_tangential", "sliding_friction", "rolling_friction"
)
# tangential spring [m], number of the step of first touch (-1 for an open contact), normal impact speed [m/s]
HISTORY = _columns("spring_x", "spring_y", "spring_z", "first_step", "impact_speed")
# of a pair of materials in `contact_heat`: 4 c/(1/k_i + 1/k_j) [W/m/K]; c^3 of impacts [-]; the smaller rho c over the
# larger [-]; k/(rho c) of the smaller [m2/s]; 1/((rho c k)_i^(-1/2) + (rho c k)_j^(-1/2)) [W s^0.5/m2/K]
HEAT_PAIR = _columns("at_rest", "impact", "capacity_ratio", "diffusivity", "effusivity")
# `curvature` 0 of a plane, 1 of a cylinder around the bed, -1 of a tube in it; a point [m] of the plane or axis; the
# unit normal into the bed or unit direction of the axis; radius [m] and index of the material
WALL = np.dtype(
    [
        *((name, np.float64) for name in ("curvature", "x", "y", "z", "unit_x", "unit_y", "unit_z", "radius")),
        ("material", np.int64),
    ],
    align=True,
)
NEAR_WALL = np.dtype([("particle", np.int32), ("wall", np.int32)], align=True)


class State(NamedTuple):
    """What a step changes, each (n, 3): position [m], velocity [m/s], spin [rad/s], force [N] and torque [N m]."""

    position: Array
    velocity: Array
    spin: Array
    force: Array
    torque: Array


class Spheres(NamedTuple):
    """What a step leaves as it is, each (n,): radius [m], mass [kg], moment of inertia [kg m2], index of the material.

    `equal` : whether all have one radius and one material, so that every contact has the same constants
    """

    radius: Array
    mass: Array
    inertia: Array
    material: Indices
    equal: bool


class Box(NamedTuple):
    """Corners [m] and periodic sides of the domain, each (3,)."""

    lower: Array
    upper: Array
    periodic: NDArray[np.bool_]


class Neighbours(NamedTuple):
    """Verlet list with the contact histories of its entries.

    Row i is `entry[start[i]:start[i + 1]]`; `neighbours` says what an entry means. `listed` (n, 3) [m] holds the
    positions for which the list was made.
    """

    start: Indices
    entry: Entries
    history: Table
    listed: Array


class Walls(NamedTuple):
    """Walls (w,), the particles near to them (k,) and the contact histories (w, n)."""

    surface: Table
    near: Table
    history: Table


class Heat(NamedTuple):
    """Temperatures [K], heat sources [W] and 1/(m c) [K/J], each (n,) or empty; table (m, m) and room for n numbers."""

    T: Array
    source: Array
    inverse_capacity: Array
    pairs: Table
    gained: Array


class Interval(NamedTuple):
    """Steps of a run: external force (n, 3) [N], gravity (3,) [m/s2], time step [s], how many steps after step `first`.

    `skin` [m] of the Verlet list, `moved` [m] the farthest that a particle can have moved since the list was made,
    `stale` whether the list is to be made anew, `speed_limit` [m/s] of a particle.
    """

    force: Array
    gravity: Array
    time_step: float
    first: int
    steps: int
    skin: float
    moved: float
    stale: bool
    speed_limit: float


def blank_history(*shape: int) -> Table:
    """Return histories of open contacts."""
    history = np.zeros(shape, HISTORY)
    history["first_step"] = -1.0
    return history


def as_numbers(table: Table) -> NDArray[np.number]:
    """View a table as a plain array, its columns along the last axis; numpy copies it much faster."""
    names = table.dtype.names or ()
    return table.view(table.dtype[0]).reshape(*table.shape, len(names))


def as_table(numbers: NDArray[np.number], columns: np.dtype) -> Table:
    """View a plain array as a table, the inverse of `as_numbers`."""
    return numbers.view(columns)[..., 0]
