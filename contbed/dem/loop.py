"""The time loop: velocity Verlet, contacts and their heat, blow-up detection in one
compiled kernel; lists in another.

Each step kicks by half a step, moves, and finds the forces at the new positions with
velocities extrapolated by half a step, so that dashpots are of second order too. The
two half kicks between steps are rounded in the same way whether or not an interval ends
there: a run cut into intervals gives what the uncut run gives, bit for bit.

All threads of a team run the kernel; they share the blocks of particles of each phase
(`contbed.compiled.barrier`). What they decide upon, such as a new list, each finds from
the reports of all blocks. One thread advances a block as soon as its contacts are done,
while it is in the cache: rows of later blocks do not look back at it.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from contbed.compiled import barrier
from contbed.compiled.barrier import Crew, finish, take, wait
from contbed.compiled.functions import digest, entry, inner, tied
from contbed.dem.forces import empty_batch, pair_forces
from contbed.dem.kernel_arrays import (
    BLOCK,
    Array,
    Blocks,
    Box,
    Indices,
    Interval,
    Laws,
    Room,
    Side,
    Sums,
    Table,
)
from contbed.dem.neighbours import (
    carry_pairs,
    carry_walls,
    find_incoming,
    find_near_walls,
    find_pairs,
)
from contbed.dem.ordering import cells_around, find_cells, reorder, sort, wrap
from contbed.dem.wall_forces import wall_forces as add_wall_forces

# how a kernel ends; TOO_SMALL: for the list
OK, LIST_IS_OLD, TOO_FAST, LOST, BEYOND_WALL, TOO_SMALL = range(6)
# what `_advance` does: the first half of a step; the second and the first of the next;
# the second
BEGIN, GO_ON, END = range(3)


class Outcome(NamedTuple):
    """How a kernel ended: status, the particle to blame or -1, steps completed.

    moved : farthest that a particle can have moved since the list was made [m]
    """

    status: int
    particle: int
    done: int
    moved: float


@inner(error_model="numpy", nogil=True)
def _advance(
    block: int,
    side: Side,
    sums: Sums,
    interval: Interval,
    phase: int | np.int64,
    blocks: Blocks,
) -> None:
    """Take both half kicks of velocity Verlet, and move: after the second half of a
    step comes the first of the next.

    First what other blocks and external forces give is added to the sums, and the heat
    to the temperatures. `largest` and `culprit` of the block become the largest speed
    squared and a particle above the limit or -1.
    """
    bodies = side.bodies
    spheres = side.spheres
    heat = side.heat
    crossing = sums.crossing
    load = sums.load
    half = side.bodies.half
    motion = side.bodies.motion
    dt = interval.time_step
    h, top, worst, is_warm = 0.5 * interval.time_step, 0.0, -1, len(side.heat.T) > 0
    per_mass, per_inertia = 1.0 / spheres.mass[0], 1.0 / spheres.inertia[0]
    for i in range(block * BLOCK, min((block + 1) * BLOCK, len(bodies.position))):
        if not spheres.equal:
            per_mass, per_inertia = 1.0 / spheres.mass[i], 1.0 / spheres.inertia[i]
        if phase != BEGIN:
            gained = 0.0
            for k in range(crossing.start[i], crossing.start[i + 1]):
                for a in range(6):
                    load[i, a] += crossing.carried[crossing.slot[k], a]
                gained += crossing.carried[crossing.slot[k], 6]
            if interval.is_pushed:
                for a in range(3):
                    load[i, a] += bodies.pushed[i, a]
            if is_warm:
                heat.T[i] += (
                    dt
                    * (gained + sums.gained[i] + heat.source[i])
                    * heat.inverse_capacity[i]
                )
        speed2 = 0.0
        for a in range(3):
            rate = load[i, a] * per_mass + interval.gravity[a]
            turn = load[i, 3 + a] * per_inertia
            v = motion[i, a] if phase == BEGIN else half[i, a] + h * rate
            w = motion[i, 3 + a] if phase == BEGIN else half[i, 3 + a] + h * turn
            if phase == END:
                motion[i, a], motion[i, 3 + a] = v, w
                continue
            u, s = v + h * rate, w + h * turn
            half[i, a], half[i, 3 + a] = u, s
            motion[i, a], motion[i, 3 + a] = u + h * rate, s + h * turn
            bodies.position[i, a] += dt * u
            speed2 += u * u
        # a NaN is never below
        if not speed2 <= interval.speed_limit * interval.speed_limit:
            worst = i
        top = max(top, speed2)
    blocks.largest[block], blocks.culprit[block] = top, worst


@inner(error_model="numpy", nogil=True)
def _measure_move(block: int, x: Array, x0: Array, largest: Array) -> None:
    """Find the largest distance squared from the positions at which the list was
    made [m2].
    """
    top = 0.0
    for i in range(block * BLOCK, min((block + 1) * BLOCK, len(x))):
        top = max(
            top,
            (x[i, 0] - x0[i, 0]) ** 2
            + (x[i, 1] - x0[i, 1]) ** 2
            + (x[i, 2] - x0[i, 2]) ** 2,
        )
    largest[block] = top


@inner(nogil=True)
def _culprit(culprits: Indices) -> int:
    """Return a particle that a block has reported, or -1."""
    for particle in culprits:
        if particle >= 0:
            return int(particle)
    return -1


@entry(cache=True, nogil=True)
def take_steps(
    crew: Crew,
    side: Side,
    laws: Laws,
    interval: Interval,
    sums: Sums,
    blocks: Blocks,
) -> Outcome:
    """Take the steps of an interval, up to its end or until the list is too old."""
    batch = empty_batch()
    pieces = len(blocks.largest)
    moved = interval.moved
    done = 0
    begun = interval.begun
    while done < interval.steps:
        if not begun:
            # the first half of the first step; each later one is taken with the
            # second half of the step before
            if done == 0:
                piece = take(crew)
                while piece < pieces:
                    _advance(piece, side, sums, interval, np.int64(BEGIN), blocks)
                    piece = take(crew)
                finish(crew, pieces)
            culprit = _culprit(blocks.culprit)
            if culprit >= 0:
                return Outcome(TOO_FAST, culprit, done, moved)
            moved += np.sqrt(blocks.largest.max()) * interval.time_step
            if moved > interval.enough:
                wait(crew)
                piece = take(crew)
                while piece < pieces:
                    _measure_move(
                        piece,
                        side.bodies.position,
                        side.pairs.listed,
                        blocks.largest,
                    )
                    piece = take(crew)
                finish(crew, pieces)
                moved = float(np.sqrt(blocks.largest.max()))
            if moved > interval.enough:
                return Outcome(LIST_IS_OLD, -1, done, moved)
        begun = False
        phase = GO_ON if done < interval.steps - 1 else END
        now = float(interval.first + done + 1)
        stages = 1 if crew.size == 1 else 2
        for stage in range(stages):
            piece = take(crew)
            while piece < pieces:
                if stage == 0:
                    pair_forces(piece, side, sums, laws, now, interval.time_step, batch)
                    add_wall_forces(piece, side, sums, laws, now, interval.time_step)
                if stage == stages - 1:
                    _advance(piece, side, sums, interval, phase, blocks)
                piece = take(crew)
            finish(crew, pieces)
        done += 1
    return Outcome(OK, -1, done, moved)


@entry(cache=True, nogil=True)
def make_list(
    crew: Crew,
    old: Side,
    new: Side,
    walls: Table,
    box: Box,
    skin: float,
    room: Room,
) -> Outcome:
    """Sort the particles and list pairs and near walls anew on the side `new`."""
    blocks = room.blocks
    sorting = room.sorting
    n = len(old.bodies.position)
    pieces = len(blocks.largest)
    widest = old.spheres.radius[0] if old.spheres.equal else old.spheres.radius.max()
    piece = take(crew)
    while piece < pieces:
        wrap(piece, old.bodies.position, box, blocks.culprit, blocks.extent)
        piece = take(crew)
    finish(crew, pieces)
    lost = _culprit(blocks.culprit)
    if lost >= 0:
        return Outcome(LOST, lost, 0, 0.0)
    cells = cells_around(blocks.extent, box, 2.0 * widest + skin, n)
    piece = take(crew)
    while piece < pieces:
        find_cells(piece, old.bodies.position, cells, sorting.cell)
        piece = take(crew)
    finish(crew, pieces)
    if crew.number == 0:
        sort(sorting, cells)
    wait(crew)
    piece = take(crew)
    while piece < pieces:
        reorder(piece, old, new, sorting.order)
        piece = take(crew)
    finish(crew, pieces)
    x, radius = new.bodies.position, new.spheres.radius
    piece = take(crew)
    while piece < pieces:
        needed = find_pairs(
            piece, x, radius, new.pairs, cells, sorting.first, box, skin
        )
        blocks.needed[piece, 0], blocks.needed[piece, 1] = needed
        blocks.needed[piece, 2], blocks.culprit[piece] = find_near_walls(
            piece, x, radius, new.near, walls, skin
        )
        piece = take(crew)
    finish(crew, pieces)
    lost = _culprit(blocks.culprit)
    if lost >= 0:
        return Outcome(BEYOND_WALL, int(np.int64(sorting.order[lost])), 0, 0.0)
    for piece in range(pieces):
        enough = (
            blocks.needed[piece, 0] <= new.pairs.room[0]
            and blocks.needed[piece, 1] <= new.pairs.room[1]
        )
        if not enough or blocks.needed[piece, 2] > len(new.near.wall) // pieces:
            return Outcome(TOO_SMALL, -1, 0, 0.0)
    if crew.number == 0:
        find_incoming(new.pairs, room.crossing)
    piece = take(crew)
    while piece < pieces:
        carry_pairs(piece, old.pairs, new.pairs, sorting.place)
        carry_walls(piece, old.near, new.near, sorting.place)
        piece = take(crew)
    finish(crew, pieces)
    return Outcome(OK, -1, 0, 0.0)


# numba itself watches the file of a kernel alone, not those of what it calls
_content = digest([*Path(__file__).parent.glob("*.py"), Path(str(barrier.__file__))])
for _kernel in (take_steps, make_list):
    tied(_kernel, _content)
