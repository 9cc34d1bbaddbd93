"""A run of the discrete elements: checks at the door, intervals, contacts,
checkpoint and restart.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contbed.arrays import Integers
from contbed.compiled.interrupts import deferred_interrupt
from contbed.dem import loop
from contbed.dem.contact import largest_safe_step, require_safe_step
from contbed.dem.contact_heat import ContactHeat
from contbed.dem.failure import STRIDE, Failure, not_a_number, of_particle, place
from contbed.dem.kernel_arrays import (
    HEAT_PAIR,
    Array,
    Box,
    Indices,
    Interval,
    Laws,
    Spheres,
)
from contbed.dem.memory import Memory, Record, halved, require_indices
from contbed.dem.neighbours import BITS, CLOSED, IMAGE, MASK, image_shifts, wall_gaps
from contbed.dem.particles import Material, Particles, pair_table
from contbed.dem.walls import SKIN, Domain, Wall, wall_table
from contbed.errors import ConvergenceError, SceneError
from contbed.output.checkpoint import require_form
from contbed.output.progress import Progress

if TYPE_CHECKING:
    from contbed.dem.gpu.memory import GpuMemory

LARGEST_OVERLAP = 0.05  # of the smaller radius, at the start
_STATE = ("position", "velocity", "spin", "force", "T")
# arrays of a checkpoint that are longer or shorter later
LISTS = Record._fields[3:]


@dataclass(frozen=True)
class Contacts:
    """Closed contacts of pairs: indices, overlap [m], unit normal from j to i, first
    touch [s], impact speed [m/s].
    """

    i: Integers
    j: Integers
    overlap: NDArray[np.float64]
    normal: NDArray[np.float64]
    since: NDArray[np.float64]
    impact_speed: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.i)


class Simulation:
    """Spheres that move, touch and settle.

    Parameters
    ----------
    particles, materials : `particles.material` counts in `materials`
    walls, domain : `walls.box(domain)` makes a box of the domain
    gravity [m/s2]
    time_step [s] : the largest safe one by default
    impact_speed [m/s] : typical speed of impacts, for the time step
    skin [m] : room of the neighbour list
    largest_overlap : of the smaller radius, accepted at the start
    most_halvings : how often the time step may be halved, from then on, where a
        particle is too fast for it
    heat, T [K] : conduction through contacts and temperatures at the start, one or
        each; None without
    engine : "cuda" computes on a GPU from NVIDIA, which needs contbed[cuda]

    `force` [N] of shape (n, 3) is added to every particle, `heat_source` [W] (n,) to
    its heat; change them between calls of `run`. `T` (n,) has no entries without
    `heat`.

    Raises
    ------
    SceneError : time step too large, overlapping start, particles outside, periodic
        sides too close
    EngineError : there is no GPU, or no numba-cuda
    """

    def __init__(
        self,
        particles: Particles,
        materials: Sequence[Material],
        walls: Sequence[Wall] = (),
        domain: Domain | None = None,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        time_step: float | None = None,
        impact_speed: float = 0.1,
        skin: float | None = None,
        largest_overlap: float = LARGEST_OVERLAP,
        most_halvings: int = 0,
        heat: ContactHeat | None = None,
        T: ArrayLike | None = None,
        engine: Literal["contbed", "cuda"] = "contbed",
    ):
        domain = domain or Domain()
        n = len(particles)
        if n == 0:
            raise SceneError("dem: no particles")
        known = range(len(materials))
        used = [*particles.material.tolist(), *(wall.material for wall in walls)]
        if missing := sorted({index for index in used if index not in known}):
            raise SceneError(
                f"dem: material {missing[0]} does not exist, there are {len(materials)}"
            )
        if time_step is None:
            time_step = largest_safe_step(particles, materials, impact_speed)
        require_safe_step(time_step, particles, materials, impact_speed)
        self.materials, self.walls, self.domain = tuple(materials), tuple(walls), domain
        self.time_step, self.steps_done = float(time_step), 0
        self._first_step, self._most_halvings = self.time_step, most_halvings
        self.skin = (
            float(skin) if skin is not None else SKIN * float(particles.radius.min())
        )
        if not 0.0 < self.skin < np.inf:
            raise SceneError(f"dem: skin = {self.skin:g} m must be positive")
        domain.require_wide(2.0 * float(particles.radius.max()) + self.skin)
        self.radius, self.kind = particles.radius.copy(), particles.material.copy()
        self._equal = bool(np.ptp(self.radius) == 0.0 and np.ptp(self.kind) == 0)
        self.mass = (
            particles.volume
            * np.array([material.density for material in materials])[self.kind]
        )
        self.inertia = 0.4 * self.mass * self.radius**2
        self.position, self.velocity = (
            particles.position.copy(),
            particles.velocity.copy(),
        )
        self.spin, self.force = particles.spin.copy(), np.zeros((n, 3))
        self.gravity = np.array(gravity, dtype=np.float64)
        self.heat_capacity, self.T, self.heat_source = (
            np.ones(n),
            np.empty(0),
            np.zeros(0),
        )
        heat_pairs = self._set_temperatures(heat, T)
        self._box = Box(
            np.array(domain.lower, float),
            np.array(domain.upper, float),
            np.array(domain.periodic),
        )
        with deferred_interrupt():
            self._laws = Laws(
                pair_table(materials),
                heat_pairs,
                wall_table(walls),
                image_shifts(self._box),
            )
        spheres = Spheres(self.radius, self.mass, self.inertia, self.kind, self._equal)
        self._memory = _engine(engine)(spheres, self._laws, self._box, self.skin)
        self._moved, self._stale = 0.0, True
        self._require_inside()
        with deferred_interrupt():
            self._load()
            while self._memory.make_list().status == loop.TOO_SMALL:
                self._memory.grow()
                self._memory.start()
                self._load()
        self._require_apart(largest_overlap)

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.steps_done * self.time_step

    @property
    def halvings(self) -> int:
        """How often the time step was halved since the start, for particles that
        were too fast for it.
        """
        return round(float(np.log2(self._first_step / self.time_step)))

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of translation and rotation [J]."""
        turning = (self.inertia * (self.spin**2).sum(axis=1)).sum()
        return float(
            0.5 * ((self.mass * (self.velocity**2).sum(axis=1)).sum() + turning)
        )

    def run(
        self,
        steps: int,
        interval: int | None = None,
        on_interval: Callable[[Simulation], bool | None] | None = None,
        quiet: bool = True,
    ) -> None:
        """Advance by the time of `steps`. After every `interval` of them `on_interval`
        is called; True ends the run.

        Raises
        ------
        ConvergenceError : a particle is too fast, not a number, or lost; the simulation
            is back at the start of the interval, and `state` holds its arrays
        """
        interval, step = interval or max(1, min(steps, 1000)), self.time_step
        with Progress(steps * step, "s", quiet=quiet) as progress:
            done = 0
            while done < steps:
                self.advance(min(interval, steps - done) * round(step / self.time_step))
                done += min(interval, steps - done)
                progress.advance_to(done * step)
                if on_interval is not None and on_interval(self):
                    break

    def state(self) -> dict[str, NDArray[Any]]:
        """Return all that changes as arrays for a checkpoint."""
        return self._state(self._memory.read())

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from the arrays of `state`: what follows is what would have followed
        there, bit for bit.

        Raises
        ------
        SceneError : the arrays belong to another simulation
        """
        missing = {*_STATE, *Record._fields, "numbers"} - set(state)
        if missing:
            raise SceneError(f"dem: the checkpoint lacks {', '.join(sorted(missing))}")
        require_form(state, self.state(), LISTS)
        moved, stale, steps, time_step, walls, skin = (
            float(value) for value in state["numbers"]
        )
        if walls != len(self.walls):
            raise SceneError(
                f"dem: checkpoint of another simulation: it has {walls:.0f} walls, "
                f"expected {len(self.walls)}"
            )
        # its list lacks pairs that are near enough to be listed here
        if skin < self.skin:
            raise SceneError(
                f"dem: the checkpoint has lists with a skin of {skin:g} m, expected "
                f"{self.skin:g} m"
            )
        if time_step not in self._first_step * 0.5 ** np.arange(
            self._most_halvings + 1
        ):
            raise SceneError(
                f"dem: the checkpoint has time step {time_step:g} s, expected "
                f"{self._first_step:g} s"
            )
        record = Record(*(np.array(state[name], order="C") for name in Record._fields))
        require_indices(record, len(self.position), len(self.walls))
        for name in _STATE:
            setattr(self, name, np.array(state[name], order="C"))
        self._go_back(record)
        self._moved, self._stale, self.steps_done, self.time_step = (
            moved,
            bool(stale),
            int(steps),
            time_step,
        )

    def contacts(self) -> Contacts:
        """Return the closed contacts of pairs as they are now, in the order of i and
        j, i < j.
        """
        record = self._memory.read()
        row, other, gap, normal = self._listed_pairs(record)
        first, impact = np.full(len(row), float(self.steps_done)), np.zeros(len(row))
        first[record.entry >= CLOSED], impact[record.entry >= CLOSED] = record.onset.T
        user = record.user.astype(np.int64)
        i, j = user[row], user[other]
        normal = np.where((i < j)[:, None], normal, -normal)
        i, j = np.minimum(i, j), np.maximum(i, j)
        order = np.lexsort((j, i))
        kept = order[gap[order] < 0.0]
        return Contacts(
            i[kept],
            j[kept],
            -gap[kept],
            normal[kept],
            first[kept] * self.time_step,
            impact[kept],
        )

    def _state(self, record: Record) -> dict[str, NDArray[Any]]:
        arrays: dict[str, NDArray[Any]] = {
            name: np.array(getattr(self, name)) for name in _STATE
        }
        numbers = (
            self._moved,
            self._stale,
            self.steps_done,
            self.time_step,
            len(self.walls),
            self.skin,
        )
        return (
            arrays | record._asdict() | {"numbers": np.array(numbers, dtype=np.float64)}
        )

    def _listed_pairs(self, record: Record) -> tuple[Indices, Indices, Array, Array]:
        """Find i and j in the order of memory, gap [m] and unit normal from j to i
        of every entry of the list.
        """
        i, j = record.row.astype(np.int64), (record.entry & MASK).astype(np.int64)
        x, radius = self.position[record.user], self.radius[record.user]
        apart = x[i] - x[j] - self._laws.image[(record.entry >> BITS) & IMAGE]
        distance = np.linalg.norm(apart, axis=1)
        gap = distance - radius[i] - radius[j]
        with np.errstate(invalid="ignore", divide="ignore"):
            return i, j, gap, apart / distance[:, None]

    def advance(self, steps: int) -> None:
        """Advance by the time of `steps`, as one interval, without a bar; if it fails,
        all is as at its start.

        Where a particle is too fast for the time step, the interval is done again with
        half of it, if that is allowed.
        """
        with deferred_interrupt():
            before: Any = self._memory.keep()
            now = (self._moved, self._stale, self.steps_done)
            start = {
                name: getattr(self, name).copy()
                for name in ("position", "velocity", "spin", "T")
            }
            self._load()
        end = self.steps_done + steps
        while self.steps_done < end:
            failure = self._take_part(min(self._memory.longest, end - self.steps_done))
            if failure is None:
                continue
            with deferred_interrupt():
                for name, array in start.items():
                    getattr(self, name)[:] = array
                self._moved, self._stale, self.steps_done = now
                is_slower = (
                    failure.status == loop.TOO_FAST
                    and self.halvings < self._most_halvings
                )
                if failure.status == loop.TOO_SMALL:
                    self._memory.grow()
                self._memory.back_to(before)
                if is_slower:
                    self._memory.write(halved(self._memory.read()))
                    before = self._memory.keep()
                    end = 2 * end
                    self.time_step = 0.5 * self.time_step
                    self.steps_done *= 2
                    now = (self._moved, self._stale, self.steps_done)
                elif failure.status != loop.TOO_SMALL:
                    raise ConvergenceError(failure.text, state=self.state())
                self._load()

    @deferred_interrupt()
    def _take_part(self, steps: int) -> Failure | None:
        """Run the steps in compiled code; return what went wrong, or None."""
        found, memory = self._take_steps(steps), self._memory
        if found.status == loop.TOO_SMALL:
            return Failure(found.status, "the lists of neighbours need more room")
        if found.status != loop.OK:
            time = (self.steps_done + found.done + 1) * self.time_step
            return of_particle(found.status, *memory.particle(found.particle), time)
        memory.store(self.position, self.velocity, self.spin, self.T)
        self.steps_done, self._moved = self.steps_done + steps, found.moved
        if not np.isfinite(self.T).all():
            return not_a_number(int((~np.isfinite(self.T)).argmax()))
        return None

    def _take_steps(self, steps: int) -> loop.Outcome:
        """Take steps, with new lists in between; how they ended, with the number of
        all that were completed.
        """
        memory = self._memory
        done = 0
        moved = self._moved
        begun = False
        is_pushed = bool(self.force.any())
        limit = STRIDE * float(self.radius.min()) / self.time_step
        while True:
            if self._stale:
                listed = memory.make_list()
                if listed.status != loop.OK:
                    return listed._replace(done=done)
                self._stale, moved = False, 0.0
            interval = Interval(
                self.gravity,
                self.time_step,
                self.steps_done + done,
                steps - done,
                0.5 * self.skin,
                moved,
                begun,
                limit,
                is_pushed,
            )
            found = memory.take_steps(interval)
            done += found.done
            if found.status != loop.LIST_IS_OLD:
                return found._replace(done=done)
            self._stale = begun = True

    def _load(self) -> None:
        """Copy the user's arrays to the order of memory."""
        pushed = (
            np.ascontiguousarray(self.force, np.float64) if self.force.any() else None
        )
        self._memory.load(self.position, self.velocity, self.spin, pushed)
        if len(self.T):
            self._memory.load_heat(
                self.T, np.asarray(self.heat_source, np.float64), self.heat_capacity
            )

    @deferred_interrupt()
    def _go_back(self, record: Record) -> None:
        self._memory.write(record)

    def _set_temperatures(
        self, heat: ContactHeat | None, T: ArrayLike | None
    ) -> NDArray[np.void]:
        if (heat is None) != (T is None):
            raise SceneError("dem: heat and T belong together; give both, or neither")
        if heat is None or T is None:
            return np.zeros((0, 0), HEAT_PAIR)
        self.T, self.heat_source = (
            np.empty(len(self.position)),
            np.zeros(len(self.position)),
        )
        self.T[:] = T
        self.heat_capacity = self.mass * heat.capacities(self.materials)[self.kind]
        return heat.table(self.materials)

    def _require_inside(self) -> None:
        lower, upper, periodic = self._box
        outside = ((self.position < lower) | (self.position > upper)) & ~periodic
        if outside.any():
            index = int(outside.any(axis=1).argmax())
            raise SceneError(
                f"dem: particle {index} at {place(self.position[index])} is outside "
                "the domain"
            )
        lengths = np.where(periodic, upper - lower, 1.0)
        base = np.where(periodic, lower, 0.0)
        turns = np.where(periodic, np.floor((self.position - base) / lengths), 0.0)
        self.position -= turns * lengths

    def _require_apart(self, largest: float) -> None:
        record = self._memory.read()
        row, other, gap, _ = self._listed_pairs(record)
        i, j = np.sort([record.user[row], record.user[other]], axis=0)
        deep = -gap / np.minimum(self.radius[i], self.radius[j])
        if len(deep) and deep.max() > largest:
            k = int(deep.argmax())
            raise SceneError(
                f"dem: particles {i[k]} and {j[k]} overlap by {-gap[k]:.4g} m at the "
                f"start, {deep[k]:.2g} of the "
                f"smaller radius; at most {largest:.2g} is accepted with their "
                "stiffness; move them apart, settle them "
                "with dem.packing, or give the modulus with which they have settled"
            )
        with deferred_interrupt():
            gaps = wall_gaps(self.position, self._laws.walls) / self.radius
        if gaps.size and gaps.min() < 1.0 - largest:
            number, k = divmod(int(gaps.argmin()), len(self.position))
            where = "is beyond" if gaps.min() < 0.0 else "overlaps"
            raise SceneError(
                f"dem: particle {k} at {place(self.position[k])} {where} wall {number} "
                "at the start"
            )


def _engine(name: Literal["contbed", "cuda"]) -> type[Memory | GpuMemory]:
    """Return what makes an engine; that of GPUs is loaded only where it is asked
    for.
    """
    if name == "contbed":
        return Memory
    from contbed.dem.gpu import require_gpu

    require_gpu()
    from contbed.dem.gpu.memory import GpuMemory

    return GpuMemory
