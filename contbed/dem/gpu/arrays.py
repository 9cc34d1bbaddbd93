"""The arrays of particles on a GPU, and the numbers with which kernels and host talk.

One thread computes one particle. What its neighbours read stands in one row, so that a
neighbour costs few sectors of memory; what belongs to one place of a list stands in
columns by particle, so that threads next to each other read next to each other. Each
contact is listed for both of its particles, which compute the same bits: no thread adds
to another one's particle, and what leaves one enters the other.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba.cuda

cuda: Any = numba.cuda  # numba-cuda, where it is installed, takes its place at run time
config: Any = numba.config
# of kernels with few threads, such as sums over parts of a list
config.CUDA_LOW_OCCUPANCY_WARNINGS = 0
DeviceArray = Any

# columns of a row: position [m], radius [m], velocity [m/s], spin [rad/s], mass [kg],
# temperature [K]
X, Y, Z, RADIUS, VX, VY, VZ, WX, WY, WZ, MASS, TEMPERATURE = range(12)
# of `control`: steps before a new list or a failure, a particle to blame, places in a
# list that were needed
STOP, CULPRIT, NEEDED = range(3)
NEVER = 1 << 40  # of STOP and CULPRIT as long as nothing happened


class Bodies(NamedTuple):
    """What a thread alone reads of its particle, in the order of memory.

    half (n, 6) : velocity [m/s] and spin [rad/s] half a step earlier
    pushed (n, 3) : external force [N]
    heat (n, 2) : heat source [W], 1/(m c) [K/J]
    user, material (n,) : index for the user and of the material
    """

    half: DeviceArray
    pushed: DeviceArray
    heat: DeviceArray
    user: DeviceArray
    material: DeviceArray


class Lists(NamedTuple):
    """Neighbours of each particle and the histories of its contacts, by place in its
    list and particle.

    listed (n, 3) : positions for which the list was made [m]
    neighbours (n,) : how many
    entry (room, n) : as `neighbours` says, ascending for each particle
    spring (room, 3, n) : displacement [m] of the one of lower index against the other;
    onset (room, 2, n) : step of the first touch, normal impact speed [m/s]; of closed
        contacts
    wall_spring (w, 3, n), wall_onset (w, 2, n) : the same of walls; the step is -1
    while the contact is open
    """

    listed: DeviceArray
    neighbours: DeviceArray
    entry: DeviceArray
    spring: DeviceArray
    onset: DeviceArray
    wall_spring: DeviceArray
    wall_onset: DeviceArray


class Around(NamedTuple):
    """What all particles meet, and what threads report.

    load (n, 6) : force [N] and torque [N m] of each particle at the ends of intervals
    control (3,) : STOP, CULPRIT and NEEDED
    image (27, 3) : shifts of periodic images [m]
    pairs, heat, walls : tables of `kernel_arrays`
    """

    load: DeviceArray
    control: DeviceArray
    image: DeviceArray
    pairs: DeviceArray
    heat: DeviceArray
    walls: DeviceArray


class Grid(NamedTuple):
    """Cells in row-major order, x fastest.

    origin, size : [m]; along : cells along each axis; periodic : which sides are
    """

    origin: tuple[float, float, float]
    size: tuple[float, float, float]
    along: tuple[int, int, int]
    periodic: tuple[bool, bool, bool]


class Cells(NamedTuple):
    """Particles by cell: cell and slot in it of each particle (n,), order, first of
    each cell (cells + 1,).
    """

    cell: DeviceArray
    slot: DeviceArray
    order: DeviceArray
    place: DeviceArray
    first: DeviceArray
