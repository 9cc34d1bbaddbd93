"""The arrays of a simulation in the order of memory, and their passage from and to the
order of the user.

Two sides hold the particles in two orders: the list of one is made from the other.
`Record` is the list and the histories of closed contacts without the room between them,
which checkpoints hold and a failed interval goes back to.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Integers
from contbed.compiled import barrier, threads
from contbed.compiled.functions import entry
from contbed.dem import loop
from contbed.dem.kernel_arrays import (
    BLOCK,
    Array,
    Blocks,
    Bodies,
    Box,
    Crossing,
    Entries,
    Heat,
    Interval,
    Laws,
    NearWalls,
    Pairs,
    Room,
    Side,
    Sorting,
    Spheres,
    Sums,
    Unsigned,
)
from contbed.dem.neighbours import (
    BITS,
    CLOSED,
    IMAGE,
    IMAGES,
    MASK,
    find_incoming,
)
from contbed.dem.ordering import CUBE, MOST_CELLS
from contbed.errors import SceneError

# places for a particle at first: of pairs within its block, across blocks and near
# walls
ROOM = (6, 2, 1)
_EACH = ("radius", "mass", "inertia", "material")  # of `Spheres`, one for each particle
MARGIN = 1.25  # of what was needed when there was too little room
# steps times particles of one call of the kernel, about 0.2 s, so that Ctrl-C is heard
CHUNK = 2_000_000
# steps of one call; what goes in and out of it then costs a tenth of them for 1e6
# particles, Ctrl-C 1 s
FEWEST = 8
# particles that a thread must have; a step of them takes 0.1 ms, threads meet twice in
# it for 5 us
LEAST = 2000


class Record(NamedTuple):
    """What a step depends on besides positions, velocities and temperatures, in the
    order of memory.

    user (n,) : index of each particle for the user
    load (n, 6), listed (n, 3) : force and torque [N, N m], positions when the list was
        made [m]
    row, entry (e,) : the Verlet list; spring (c, 3) [m] and onset (c, 2) of its closed
        contacts
    wall_particle, wall (k,), wall_spring (k, 3), wall_onset (k, 2) : particles near to
    walls
    """

    user: Entries
    load: Array
    listed: Array
    row: Unsigned
    entry: Unsigned
    spring: Array
    onset: Array
    wall_particle: Entries
    wall: Entries
    wall_spring: Array
    wall_onset: Array


def nothing_listed(n: int) -> Record:
    """Return the record of n particles in the order of the user with an empty list."""
    history = np.zeros((0, 3)), np.zeros((0, 2))
    order = np.arange(n, dtype=np.int32)
    pairs = np.zeros(0, np.uint32)
    near = np.zeros(0, np.int32)
    return Record(
        order,
        np.zeros((n, 6)),
        np.zeros((n, 3)),
        pairs,
        pairs,
        *history,
        near,
        near,
        *history,
    )


def require_indices(record: Record, particles: int, walls: int) -> None:
    """Refuse a record that names particles, images or walls that do not exist, or that
    lacks histories of closed contacts: compiled loops would read beyond their arrays.

    Raises
    ------
    SceneError : it is of no run of contbed
    """
    row, other = record.row, record.entry & MASK
    closed, near = int((record.entry >= CLOSED).sum()), len(record.wall)
    fits = (
        np.array_equal(np.sort(record.user), np.arange(particles)),
        len(row) == len(other) and _below(row, particles) and _below(other, particles),
        _below((record.entry >> BITS) & IMAGE, IMAGES),
        len(record.spring) == len(record.onset) == closed,
        near == len(record.wall_particle) and _below(record.wall_particle, particles),
        len(record.wall_spring) == len(record.wall_onset) == near,
        _below(record.wall, walls),
    )
    if not all(fits):
        raise SceneError(
            "the checkpoint does not fit this scene: its lists name particles or walls "
            "that do not exist; run without --restart"
        )


def _below(numbers: NDArray[Any], end: int) -> bool:
    return bool(((numbers >= 0) & (numbers < end)).all())


def halved(record: Record) -> Record:
    """Return the record for half the time step, in which the steps of first touches
    count twice as many.
    """
    onset, wall_onset = record.onset.copy(), record.wall_onset.copy()
    for steps in (onset[:, 0], wall_onset[:, 0]):
        steps[steps >= 0.0] *= 2.0
    return record._replace(onset=onset, wall_onset=wall_onset)


class Particle(NamedTuple):
    """One particle as it is in memory: index for the user, position [m],
    velocity [m/s].
    """

    user: int
    position: Array
    velocity: Array


class Memory:
    """Both sides of a simulation and what its threads share.

    Parameters
    ----------
    spheres : in the order of the user
    laws : constants of contacts; with a table of heat particles have temperatures
    box : the domain
    skin : room of the neighbour list [m]
    """

    side: Side
    other: Side

    def __init__(self, spheres: Spheres, laws: Laws, box: Box, skin: float):
        self._given, self._laws, self._box, self._skin = spheres, laws, box, skin
        self._is_warm, n = len(laws.heat) > 0, len(spheres.radius)
        self.longest = max(FEWEST, CHUNK // n)
        self.blocks = -(-n // BLOCK)
        self._places = tuple(most * min(n, BLOCK) for most in ROOM)
        self._allocate()
        self.start()

    @property
    def user(self) -> Entries:
        """Index that each particle has for the user."""
        user: Entries = self.side.bodies.user
        return user

    def start(self) -> None:
        """Begin with the order of the user and an empty list."""
        self.write(nothing_listed(len(self._given.radius)))

    def swap(self) -> None:
        """Take the other side as the present one."""
        self.side, self.other = self.other, self.side

    def grow(self) -> None:
        """Make room for what the last list needed, with a margin. What the sides
        held is lost.
        """
        self._make_room(self.room.blocks.needed.max(axis=0).tolist())

    def load(
        self, position: Array, velocity: Array, spin: Array, pushed: Array | None
    ) -> None:
        """Copy positions [m], velocities [m/s], spins [rad/s] and external
        forces [N] from the user's order.
        """
        given = (
            np.ascontiguousarray(values, np.float64)
            for values in (position, velocity, spin)
        )
        threads.parallel(_load, len(position), self.side.bodies, *given)
        if pushed is not None:
            np.take(pushed, self.user, axis=0, out=self.side.bodies.pushed)

    def load_heat(self, T: Array, source: Array, capacity: Array) -> None:
        """Copy temperatures [K], heat sources [W] and heat capacities [J/K] from the
        user's order.
        """
        heat = self.side.heat
        heat.T[:] = T[self.user]
        heat.source[:] = source[self.user]
        heat.inverse_capacity[:] = 1.0 / capacity[self.user]

    def store(self, position: Array, velocity: Array, spin: Array, T: Array) -> None:
        """Copy positions, velocities, spins and temperatures to the user's order."""
        threads.parallel(
            _store, len(position), self.side.bodies, position, velocity, spin
        )
        if self._is_warm:
            T[self.user] = self.side.heat.T

    def make_list(self) -> loop.Outcome:
        """Sort the particles and make a list for their present positions."""
        arrays = (
            self.side,
            self.other,
            self._laws.walls,
            self._box,
            self._skin,
            self.room,
        )
        found: loop.Outcome = barrier.run(loop.make_list, self._threads(), *arrays)
        if found.status == loop.OK:
            self.swap()
        return found

    def take_steps(self, interval: Interval) -> loop.Outcome:
        """Take steps up to the end of an interval, or until the list is too old."""
        arrays = (self.side, self._laws, interval, self.sums, self.room.blocks)
        found: loop.Outcome = barrier.run(loop.take_steps, self._threads(), *arrays)
        return found

    def particle(self, place: int) -> Particle:
        """Return what is at a place of memory."""
        bodies = self.side.bodies
        return Particle(
            int(bodies.user[place]), bodies.position[place], bodies.motion[place, :3]
        )

    def keep(self) -> Record:
        """Return what `back_to` goes back to."""
        return self.read()

    def back_to(self, kept: Record) -> None:
        """Go back to a state of `keep`; positions, velocities and temperatures are
        those of `load`.
        """
        self.write(kept)

    def read(self) -> Record:
        """Return what a step depends on, as copies."""
        pairs, near = self.side.pairs, self.side.near
        inner, across = pairs.room
        lane = np.arange(inner + across)
        in_use = np.where(
            lane < inner,
            lane < pairs.used[0][:, None],
            lane - inner < pairs.used[1][:, None],
        )
        place = np.flatnonzero(in_use)
        entry = pairs.entry[place]
        closed = place[entry >= CLOSED]
        close = np.flatnonzero(
            np.arange(len(near.wall) // self.blocks) < near.used[:, None]
        )
        return Record(
            self.user.copy(),
            self.sums.load.copy(),
            pairs.listed.copy(),
            pairs.row[place],
            entry,
            pairs.spring[closed],
            pairs.onset[closed],
            near.particle[close],
            near.wall[close],
            near.spring[close],
            near.onset[close],
        )

    def write(self, record: Record) -> None:
        """Take up a state of `read`."""
        block = record.row // BLOCK
        across = record.row // BLOCK != (record.entry & MASK) // BLOCK
        group = 2 * block.astype(np.int64) + across
        wall_block = record.wall_particle.astype(np.int64) // BLOCK
        used = np.bincount(group, minlength=2 * self.blocks)
        close = np.bincount(wall_block, minlength=self.blocks)
        self._make_room(
            [int(used[0::2].max()), int(used[1::2].max()), int(close.max())]
        )
        pairs = self.side.pairs
        near = self.side.near
        bodies = self.side.bodies
        spheres = self.side.spheres
        place = _places(group, used, pairs.room)
        pairs.used[0], pairs.used[1] = used[0::2], used[1::2]
        pairs.row[place], pairs.entry[place] = record.row, record.entry
        closed = place[record.entry >= CLOSED]
        pairs.spring[closed], pairs.onset[closed] = record.spring, record.onset
        place = _places(wall_block, close, (len(near.wall) // self.blocks,))
        near.used[:] = close
        near.particle[place], near.wall[place] = record.wall_particle, record.wall
        near.spring[place], near.onset[place] = record.wall_spring, record.wall_onset
        find_incoming(pairs, self.sums.crossing)
        self.sums.load[:] = record.load
        bodies.user[:] = record.user
        pairs.listed[:] = record.listed
        if not spheres.equal:
            for name in _EACH:
                getattr(spheres, name)[:] = getattr(self._given, name)[record.user]

    def _threads(self) -> int:
        return threads.count(len(self._given.radius), LEAST)

    def _make_room(self, needed: list[int]) -> None:
        if all(
            need <= places for need, places in zip(needed, self._places, strict=True)
        ):
            return
        pairs = zip(needed, self._places, strict=True)
        self._places = tuple(
            places if need <= places else int(MARGIN * need) + 1
            for need, places in pairs
        )
        self._allocate()

    def _allocate(self) -> None:
        n = len(self._given.radius)
        warm = len(self._given.radius) if self._is_warm else 0
        blocks = self.blocks
        across, cells = blocks * self._places[1], MOST_CELLS * n + (1 << (3 * CUBE)) + 1
        self.side, self.other = self._make_side(), self._make_side()
        crossing = Crossing(np.empty((across, 7)), _whole(n + 1), _whole(across))
        self.sums = Sums(np.zeros((n, 6)), np.zeros(warm), crossing)
        self.room = Room(
            Sorting(_whole(n), _whole(n), _whole(n), _whole(cells)),
            Blocks(
                np.zeros(blocks),
                np.full(blocks, -1),
                np.zeros((blocks, 6)),
                np.zeros((blocks, 3), np.int64),
            ),
            crossing,
        )

    def _make_side(self) -> Side:
        given, n, blocks = self._given, len(self._given.radius), self.blocks
        warm = n if self._is_warm else 0
        inner, across, near = self._places
        size, close = blocks * (inner + across), blocks * near
        return Side(
            Bodies(
                np.zeros((n, 3)),
                np.zeros((n, 6)),
                np.zeros((n, 6)),
                np.zeros((n, 3)),
                _whole(n),
            ),
            given
            if given.equal
            else given._replace(
                **{name: given._asdict()[name].copy() for name in _EACH}
            ),
            Heat(np.empty(warm), np.empty(warm), np.empty(warm)),
            Pairs(
                (inner, across),
                np.zeros((2, blocks), np.int32),
                np.zeros((2, n), np.int32),
                np.zeros((2, n), np.int32),
                np.empty(size, np.uint32),
                np.empty(size, np.uint32),
                np.empty((size, 3)),
                np.empty((size, 2)),
                np.zeros((n, 3)),
            ),
            NearWalls(
                np.zeros(blocks, np.int32),
                _whole(close),
                _whole(close),
                np.empty((close, 3)),
                np.empty((close, 2)),
            ),
        )


@entry(nogil=True, cache=True)
def _load(
    begin: int, end: int, bodies: Bodies, position: Array, velocity: Array, spin: Array
) -> None:
    for i in range(begin, end):
        k = bodies.user[i]
        for a in range(3):
            bodies.position[i, a], bodies.motion[i, a] = position[k, a], velocity[k, a]
            bodies.motion[i, 3 + a] = spin[k, a]


@entry(nogil=True, cache=True)
def _store(
    begin: int, end: int, bodies: Bodies, position: Array, velocity: Array, spin: Array
) -> None:
    for i in range(begin, end):
        k = bodies.user[i]
        for a in range(3):
            position[k, a], velocity[k, a] = bodies.position[i, a], bodies.motion[i, a]
            spin[k, a] = bodies.motion[i, 3 + a]


def _whole(size: int) -> Entries:
    return np.empty(size, np.int32)


def _places(group: Integers, used: Integers, room: tuple[int, ...]) -> Integers:
    """Find the places of rows that are sorted by group, where the groups in turn
    have room for so many of them.
    """
    sizes = np.tile(room, len(used) // len(room))
    first, begin = np.cumsum(used) - used, np.cumsum(sizes) - sizes
    found: Integers = np.arange(len(group)) - first[group] + begin[group]
    return found
