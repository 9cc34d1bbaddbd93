"""A run of the discrete elements: checks at the door, intervals, contacts, checkpoint and restart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contbed.dem import loop
from contbed.dem.contact import largest_safe_step, require_safe_step
from contbed.dem.contact_heat import ContactHeat
from contbed.dem.kernel_arrays import (
    HEAT_PAIR,
    HISTORY,
    NEAR_WALL,
    Array,
    Box,
    Heat,
    Indices,
    Interval,
    Neighbours,
    Spheres,
    State,
    Walls,
    as_numbers,
    as_table,
    blank_history,
)
from contbed.dem.neighbours import BITS, MASK, half_list, image_shifts, wall_gaps
from contbed.dem.particles import Material, Particles, pair_table
from contbed.dem.walls import Domain, Wall, wall_table
from contbed.errors import ConvergenceError, SceneError
from contbed.interrupts import deferred_interrupt
from contbed.output.progress import Progress

LARGEST_OVERLAP = 0.05  # of the smaller radius, at the start
STRIDE = 0.1  # of the smallest radius: nothing may move farther in one step
SKIN = 0.1  # of the smallest radius, unless given
CHUNK = 2_000_000  # steps times particles of one call of the kernel, about 0.2 s, so that Ctrl-C is heard
_STATE = (
    "position", "velocity", "spin", "force",
    "_load", "_torque", "_listed", "_start", "_entry", "T",
)  # fmt: skip
_TABLES = {"_history": HISTORY, "_near": NEAR_WALL, "_wall_history": HISTORY}


@dataclass(frozen=True)
class Contacts:
    """Closed contacts of pairs: indices, overlap [m], unit normal from j to i, first touch [s], impact speed [m/s]."""

    i: NDArray[np.int64]
    j: NDArray[np.int64]
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
    heat, T [K] : conduction through contacts and temperatures at the start, one or each; None without

    `force` [N] of shape (n, 3) is added to every particle, `heat_source` [W] (n,) to its heat; change them between
    calls of `run`. `T` (n,) has no entries without `heat`.

    Raises
    ------
    SceneError : time step too large, overlapping start, particles outside, periodic sides too close
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
        heat: ContactHeat | None = None,
        T: ArrayLike | None = None,
    ):
        domain = domain or Domain()
        n = len(particles)
        if n == 0:
            raise SceneError("dem: no particles")
        known = range(len(materials))
        used = [*particles.material.tolist(), *(wall.material for wall in walls)]
        if missing := sorted({index for index in used if index not in known}):
            raise SceneError(f"dem: material {missing[0]} does not exist, there are {len(materials)}")
        if time_step is None:
            time_step = largest_safe_step(particles, materials, impact_speed)
        require_safe_step(time_step, particles, materials, impact_speed)
        self.materials, self.walls, self.domain = tuple(materials), tuple(walls), domain
        self.time_step, self.steps_done = float(time_step), 0
        self.skin = float(skin) if skin is not None else SKIN * float(particles.radius.min())
        if not 0.0 < self.skin < np.inf:
            raise SceneError(f"dem: skin = {self.skin:g} m must be positive")
        domain.require_wide(2.0 * float(particles.radius.max()) + self.skin)
        self.radius, self.kind = particles.radius.copy(), particles.material.copy()
        self._equal = bool(np.ptp(self.radius) == 0.0 and np.ptp(self.kind) == 0)
        self.mass = particles.volume * np.array([material.density for material in materials])[self.kind]
        self.inertia = 0.4 * self.mass * self.radius**2
        self.position, self.velocity = particles.position.copy(), particles.velocity.copy()
        self.spin, self.force = particles.spin.copy(), np.zeros((n, 3))
        self.gravity = np.array(gravity, dtype=np.float64)
        self._pairs, self._walls = pair_table(materials), wall_table(walls)
        self._box = Box(np.array(domain.lower), np.array(domain.upper), np.array(domain.periodic))
        self._load, self._torque, self._listed = np.zeros((n, 3)), np.zeros((n, 3)), self.position.copy()
        self._wall_history = blank_history(len(walls), n)
        self._near = np.zeros(0, NEAR_WALL)
        self._set_temperatures(heat, T)
        self._moved, self._stale = 0.0, True
        self._require_inside()
        with deferred_interrupt():
            self._start, self._entry = half_list(self.position, self.radius, self._box, self.skin)
        self._history = blank_history(len(self._entry))
        self._require_apart(largest_overlap)

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.steps_done * self.time_step

    @property
    def heat_content(self) -> float:
        """Heat above 0 K [J] of particles with temperatures."""
        return float((self.heat_capacity * self.T).sum())

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of translation and rotation [J]."""
        turning = (self.inertia * (self.spin**2).sum(axis=1)).sum()
        return float(0.5 * ((self.mass * (self.velocity**2).sum(axis=1)).sum() + turning))

    def run(
        self,
        steps: int,
        interval: int | None = None,
        on_interval: Callable[[Simulation], bool | None] | None = None,
        quiet: bool = True,
    ) -> None:
        """Advance by `steps`; after every `interval` of them `on_interval` is called, and True from it ends the run.

        Raises
        ------
        ConvergenceError : a particle is too fast, not a number, or lost; the simulation is back at the start of the
            interval, and `state` holds its arrays
        """
        interval = interval or max(1, min(steps, 1000))
        with Progress(steps * self.time_step, "s", quiet=quiet) as progress:
            done = 0
            while done < steps:
                self._advance(min(interval, steps - done))
                done += min(interval, steps - done)
                progress.advance_to(done * self.time_step)
                if on_interval is not None and on_interval(self):
                    break

    def state(self) -> dict[str, NDArray[Any]]:
        """Return all that changes as arrays for a checkpoint."""
        arrays = {name.lstrip("_"): np.array(getattr(self, name)) for name in _STATE}
        arrays |= {name.lstrip("_"): as_numbers(getattr(self, name)).copy() for name in _TABLES}
        numbers = (self._moved, self._stale, self.steps_done, self.time_step)
        return arrays | {"numbers": np.array(numbers, dtype=np.float64)}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from the arrays of `state`: what follows is what would have followed there, bit for bit.

        Raises
        ------
        SceneError : the arrays belong to another simulation
        """
        missing = {*(name.lstrip("_") for name in (*_STATE, *_TABLES)), "numbers"} - set(state)
        if missing:
            raise SceneError(f"dem: the checkpoint lacks {', '.join(sorted(missing))}")
        own = self.state()
        for name in ("position", "wall_history"):
            found, wanted = np.shape(state[name]), own[name].shape
            if found != wanted:
                raise SceneError(f"dem: checkpoint of another simulation: {name} has shape {found}, expected {wanted}")
        moved, stale, steps, time_step = (float(value) for value in state["numbers"])
        if time_step != self.time_step:
            raise SceneError(f"dem: the checkpoint has time step {time_step:g} s, expected {self.time_step:g} s")
        for name in _STATE:
            setattr(self, name, np.array(state[name.lstrip("_")], order="C"))
        for name, columns in _TABLES.items():
            setattr(self, name, as_table(np.array(state[name.lstrip("_")], order="C"), columns))
        self._moved, self._stale, self.steps_done = moved, bool(stale), int(steps)

    def contacts(self) -> Contacts:
        """Return the closed contacts of pairs as they are now."""
        i, j, gap, normal = self._listed_pairs()
        closed = gap < 0.0
        history = self._history[closed]
        since = np.where(history["first_step"] < 0.0, float(self.steps_done), history["first_step"])
        return Contacts(
            i[closed], j[closed], -gap[closed], normal[closed], since * self.time_step, history["impact_speed"]
        )

    def _listed_pairs(self) -> tuple[Indices, Indices, Array, Array]:
        """Find i, j, gap [m] and unit normal from j to i of every entry of the list."""
        i = np.repeat(np.arange(len(self.position)), np.diff(self._start))
        j = (self._entry & MASK).astype(np.int64)
        with deferred_interrupt():
            images = image_shifts(self._box)
        apart = self.position[i] - self.position[j] - images[self._entry >> BITS]
        distance = np.linalg.norm(apart, axis=1)
        gap = distance - self.radius[i] - self.radius[j]
        with np.errstate(invalid="ignore", divide="ignore"):
            return i, j, gap, apart / distance[:, None]

    def _advance(self, steps: int) -> None:
        """Advance by the steps of one interval; if it fails, the simulation is back at its start."""
        before = self.state()
        longest = max(1, CHUNK // len(self.position))
        done = 0
        while done < steps:
            part = min(longest, steps - done)
            failure = self._call_kernel(part)
            if failure is not None:
                self.restore(before)
                raise ConvergenceError(failure, state=before)
            done += part

    def _call_kernel(self, steps: int) -> str | None:
        """Run the steps in compiled code; return what went wrong, or None."""
        state = State(self.position, self.velocity, self.spin, self._load, self._torque)
        with deferred_interrupt():
            found = loop.run_steps(
                state,
                Spheres(self.radius, self.mass, self.inertia, self.kind, self._equal),
                self._pairs,
                Walls(self._walls, self._near, self._wall_history),
                self._box,
                Neighbours(self._start, self._entry, self._history, self._listed),
                self._heat(),
                self._interval(steps),
            )
            self._start, self._entry, self._history, self._listed = found.neighbours
            self._near, self._moved = found.walls.near, found.moved
            if found.status == loop.OK:
                self.steps_done += steps
                self._stale = False
        if found.status != loop.OK:
            i, time = found.particle, (self.steps_done + found.done + 1) * self.time_step
            return _description(found.status, i, self.position[i], self.velocity[i], time)
        if not np.isfinite(self.T).all():
            i = int((~np.isfinite(self.T)).argmax())
            return (
                f"dem: temperature of particle {i} is not a number; a heat source, or a heat "
                "capacity too small for the time step"
            )
        return None

    def _heat(self) -> Heat:
        source = np.ascontiguousarray(self.heat_source, np.float64)
        return Heat(self.T, source, 1.0 / self.heat_capacity, self._heat_pairs, np.empty_like(self.T))

    def _interval(self, steps: int) -> Interval:
        return Interval(
            np.ascontiguousarray(self.force, np.float64),
            self.gravity,
            self.time_step,
            self.steps_done,
            steps,
            self.skin,
            self._moved,
            self._stale,
            STRIDE * float(self.radius.min()) / self.time_step,
        )

    def _set_temperatures(self, heat: ContactHeat | None, T: ArrayLike | None) -> None:
        if (heat is None) != (T is None):
            raise SceneError("dem: give both heat and T, or neither")
        n = 0 if heat is None else len(self.position)
        self.T, self.heat_source = np.empty(n), np.zeros(n)
        self.heat_capacity, self._heat_pairs = np.ones(n), np.zeros((0, 0), HEAT_PAIR)
        if heat is not None and T is not None:
            self.T[:] = T
            self.heat_capacity = self.mass * heat.capacities(self.materials)[self.kind]
            self._heat_pairs = heat.table(self.materials)

    def _require_inside(self) -> None:
        lower, upper, periodic = self._box
        outside = ((self.position < lower) | (self.position > upper)) & ~periodic
        if outside.any():
            index = int(outside.any(axis=1).argmax())
            raise SceneError(f"dem: particle {index} at {_place(self.position[index])} is outside the domain")
        lengths = np.where(periodic, upper - lower, 1.0)
        base = np.where(periodic, lower, 0.0)
        turns = np.where(periodic, np.floor((self.position - base) / lengths), 0.0)
        self.position -= turns * lengths

    def _require_apart(self, largest: float) -> None:
        i, j, gap, _ = self._listed_pairs()
        deep = -gap / np.minimum(self.radius[i], self.radius[j])
        if len(deep) and deep.max() > largest:
            k = int(deep.argmax())
            raise SceneError(
                f"dem: particles {i[k]} and {j[k]} overlap by {-gap[k]:.4g} m at the start, {deep[k]:.2g} of the "
                f"smaller radius; at most {largest:g} is accepted; move them apart or settle them with dem.packing"
            )
        with deferred_interrupt():
            gaps = wall_gaps(self.position, self._walls) / self.radius
        if gaps.size and gaps.min() < 1.0 - largest:
            number, k = divmod(int(gaps.argmin()), len(self.position))
            where = "is beyond" if gaps.min() < 0.0 else "overlaps"
            raise SceneError(f"dem: particle {k} at {_place(self.position[k])} {where} wall {number} at the start")


def _place(point: Array) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in point) + ") m"


def _description(status: int, particle: int, where: Array, velocity: Array, time: float) -> str:
    """Say what happened to a particle at `time` [s]."""
    speed = float(np.linalg.norm(velocity))
    what = {
        loop.TOO_FAST: f"moves at {speed:.4g} m/s, more than {STRIDE:g} of the smallest radius in a step",
        loop.LOST: "left the domain",
        loop.BEYOND_WALL: "was pushed through a wall",
    }[status]
    return (
        f"dem: particle {particle} at {_place(where)} {what} at t = {time:.6g} s; "
        "the state before this interval is kept; try a smaller time step or a closed domain"
    )
