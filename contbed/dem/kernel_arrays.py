"""The arrays that the compiled kernels share, grouped by role, and the columns of their
tables by name.

Tables are structured arrays, one row a pair of materials or a wall: `pairs[i,
j].shear_modulus`. All is in SI.

Particles are computed in an order of memory in which neighbours in space are mostly
neighbours in memory (`ordering`). BLOCK of them in a row are a block: the piece of work
that a thread takes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Entries = NDArray[np.int32]
# as an index it needs no check whether it counts from the end
Unsigned = NDArray[np.uint32]
Table = NDArray[np.void]
Row = Any  # of a Table; its columns are attributes in compiled code


BLOCK = 1024  # particles; of 0.6 kB each, half of a second cache of 1 MB


def _columns(*names: str) -> np.dtype:
    return np.dtype([(name, np.float64) for name in names], align=True)


# effective moduli E*, G* [Pa], damping factors [Pa^0.5], Coulomb and rolling friction
# of a pair of materials [-]
PAIR = _columns(
    "youngs_modulus",
    "shear_modulus",
    "damping_normal",
    "damping_tangential",
    "sliding_friction",
    "rolling_friction",
)
# of a pair of materials in `contact_heat`: 4 c/(1/k_i + 1/k_j) [W/m/K]; c^3 of impacts
# [-]; the smaller rho c over the larger [-]; k/(rho c) of the smaller [m2/s]; 1/((rho c
# k)_i^(-1/2) + (rho c k)_j^(-1/2)) [W s^0.5/m2/K]
HEAT_PAIR = _columns("at_rest", "impact", "capacity_ratio", "diffusivity", "effusivity")
# `curvature` 0 of a plane, 1 of a cylinder around the bed, -1 of a tube in it; a point
# [m] of the plane or axis; the unit normal into the bed or unit direction of the axis;
# radius [m] and index of the material
WALL = np.dtype(
    [
        *(
            (name, np.float64)
            for name in (
                "curvature",
                "x",
                "y",
                "z",
                "unit_x",
                "unit_y",
                "unit_z",
                "radius",
            )
        ),
        ("material", np.int64),
    ],
    align=True,
)


class Spheres(NamedTuple):
    """What a step leaves as it is, each (n,): radius [m], mass [kg], moment of
    inertia [kg m2], index of the material.

    `equal` : whether all have one radius and one material, so that every contact has
    the same constants
    """

    radius: Array
    mass: Array
    inertia: Array
    material: Indices
    equal: bool


class Bodies(NamedTuple):
    """What moves, in the order of memory.

    position (n, 3) [m]; motion (n, 6), velocity [m/s] and spin [rad/s] at the time of
    the position; half (n, 6), both half a step earlier; pushed (n, 3), external
    force [N]; user (n,), the index that the particle has for the user
    """

    position: Array
    motion: Array
    half: Array
    pushed: Array
    user: Entries


class Heat(NamedTuple):
    """Temperatures [K], heat sources [W] and 1/(m c) [K/J], each (n,) or empty."""

    T: Array
    source: Array
    inverse_capacity: Array


class Pairs(NamedTuple):
    """Verlet list with the histories of closed contacts; each block of rows has a
    segment of its own.

    A segment has two zones, for pairs within the block and for those whose j is in a
    later block, each sorted by row; of zone z of a block the first `used[z, block]` of
    `room[z]` places hold pairs.

    row, entry (m,) : i, and j as `neighbours` says
    spring (m, 3) : tangential displacement [m];
    onset (m, 2) : number of the step of first touch, normal impact speed [m/s]; both
        meaningful for closed contacts only
    start, stop (2, n) : those of row i in zone z are the places from `start[z, i]` to
        before `stop[z, i]`
    listed (n, 3) : positions for which the list was made [m]
    """

    room: tuple[int, int]
    used: NDArray[np.int32]
    start: NDArray[np.int32]
    stop: NDArray[np.int32]
    row: Unsigned
    entry: Unsigned
    spring: Array
    onset: Array
    listed: Array


class NearWalls(NamedTuple):
    """Particles near to walls in segments by block: how many in each block, particle
    and wall, and their histories.

    `onset` has the step -1 while the contact is open.
    """

    used: Entries
    particle: Entries
    wall: Entries
    spring: Array
    onset: Array


class Side(NamedTuple):
    """All arrays in one order of memory; a new list is made on the other side, in
    the order that fits it.
    """

    bodies: Bodies
    spheres: Spheres
    heat: Heat
    pairs: Pairs
    near: NearWalls


class Crossing(NamedTuple):
    """What contacts between two blocks give to the particle j, so that every thread
    adds to particles of its own block.

    carried (m, 7) : force [N], torque [N m] and heat [W] on j by place in the zones
        across blocks; zero while open
    start (n + 1,), slot (m,) : the places that belong to particle j are
        `slot[start[j]:start[j + 1]]`
    """

    carried: Array
    start: Entries
    slot: Entries


class Sums(NamedTuple):
    """Force [N] and torque [N m] (n, 6) and heat [W] (n,) or (0,) that particles get,
    and those that cross blocks.

    Between intervals `load` is the whole sum; in a step that of the contacts within a
    block.
    """

    load: Array
    gained: Array
    crossing: Crossing


class Sorting(NamedTuple):
    """Room for sorting: cell of each particle, sorted order and its inverse (n,),
    first particle of each cell.
    """

    cell: Entries
    order: Entries
    place: Entries
    first: Entries


class Blocks(NamedTuple):
    """What is found for each block: largest speed squared or distance squared, particle
    to blame or -1, corners, needs.

    largest, culprit : (blocks,)
    extent : (blocks, 6) lower and upper corner [m]
    needed : (blocks, 3) places of pairs within blocks, across them and near walls
    """

    largest: Array
    culprit: Indices
    extent: Array
    needed: Indices


class Box(NamedTuple):
    """Corners [m] and periodic sides of the domain, each (3,)."""

    lower: Array
    upper: Array
    periodic: NDArray[np.bool_]


class Room(NamedTuple):
    """What the threads that make a list share besides the two sides."""

    sorting: Sorting
    blocks: Blocks
    crossing: Crossing


class Laws(NamedTuple):
    """Constants of contacts: tables of pairs of materials and of heat, walls (w,),
    shifts of images (27, 3) [m].
    """

    pairs: Table
    heat: Table
    walls: Table
    image: Array


class Interval(NamedTuple):
    """Steps of a run: gravity (3,) [m/s2], time step [s], how many steps after step
    `first`.

    `enough` [m] is the move after which the list is made anew, `moved` [m] the farthest
    that a particle can have moved since it was made, `begun` whether the first step has
    moved the particles already, `speed_limit` [m/s] of a particle, `is_pushed` whether
    there are external forces.
    """

    gravity: Array
    time_step: float
    first: int
    steps: int
    enough: float
    moved: float
    begun: bool
    speed_limit: float
    is_pushed: bool
