"""A run of the discrete elements: checks at the door, intervals, contacts, checkpoint and restart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contbed.dem import loop
from contbed.dem.contact import HISTORY, SINCE, SPEED, largest_safe_step, require_safe_step
from contbed.dem.contact_heat import ContactHeat
from contbed.dem.neighbours import BITS, MASK, half_list, shifts, wall_gaps
from contbed.dem.particles import Material, Particles, pair_table
from contbed.dem.walls import Domain, Wall, wall_rows
from contbed.errors import ConvergenceError, SceneError
from contbed.output.progress import Progress

LARGEST_OVERLAP = 0.05  # of the smaller radius, at the start
STRIDE = 0.1  # of the smallest radius: nothing may move farther in one step
SKIN = 0.1  # of the smallest radius, unless given
_STATE = (
    "position", "velocity", "spin", "force",
    "_load", "_torque", "_listed", "_start", "_mates", "_past", "_near", "_wall_past", "T",
)  # fmt: skip


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
        self.mass = particles.volume * np.array([material.density for material in materials])[self.kind]
        self.inertia = 0.4 * self.mass * self.radius**2
        self.position, self.velocity = particles.position.copy(), particles.velocity.copy()
        self.spin, self.force = particles.spin.copy(), np.zeros((n, 3))
        self.gravity = np.array(gravity, dtype=np.float64)
        self._table, self._walls = pair_table(materials), wall_rows(walls)
        self._wall_kind = np.array([wall.material for wall in walls], dtype=np.int64)
        self._sides = (np.array(domain.lower), np.array(domain.upper), np.array(domain.periodic))
        self._load, self._torque, self._listed = np.zeros((n, 3)), np.zeros((n, 3)), self.position.copy()
        self._wall_past = _blank(len(walls), n)
        self._near = np.zeros((0, 2), np.int32)
        self._warm(heat, T)
        self._reach, self._stale = 0.0, True
        self._require_inside()
        self._start, self._mates = half_list(self.position, self.radius, *self._sides, self.skin)
        self._past = _blank(len(self._mates))
        self._require_apart(largest_overlap)

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self.steps_done * self.time_step

    @property
    def heat_content(self) -> float:
        """Above 0 K [J], of particles with temperatures."""
        return float((self.heat_capacity * self.T).sum())

    @property
    def kinetic_energy(self) -> float:
        """Of translation and rotation [J]."""
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
                self._interval(min(interval, steps - done))
                done += min(interval, steps - done)
                progress.advance_to(done * self.time_step)
                if on_interval is not None and on_interval(self):
                    break

    def state(self) -> dict[str, NDArray]:
        """All that moves, as arrays for a checkpoint."""
        arrays = {name.lstrip("_"): np.array(getattr(self, name)) for name in _STATE}
        numbers = (self._reach, self._stale, self.steps_done, self.time_step)
        return arrays | {"numbers": np.array(numbers, dtype=np.float64)}

    def restore(self, state: Mapping[str, NDArray]) -> None:
        """Continue from the arrays of `state`: what follows is what would have followed there, bit for bit.

        Raises
        ------
        SceneError : the arrays belong to another simulation
        """
        missing = {*(name.lstrip("_") for name in _STATE), "numbers"} - set(state)
        if missing:
            raise SceneError(f"dem: the checkpoint lacks {', '.join(sorted(missing))}")
        for name in ("position", "wall_past"):
            found, wanted = np.shape(state[name]), self.state()[name].shape
            if found != wanted:
                raise SceneError(f"dem: checkpoint of another simulation: {name} has shape {found}, expected {wanted}")
        reach, stale, steps, time_step = (float(value) for value in state["numbers"])
        if time_step != self.time_step:
            raise SceneError(f"dem: the checkpoint has time step {time_step:g} s, expected {self.time_step:g} s")
        for name in _STATE:
            setattr(self, name, np.array(state[name.lstrip("_")], order="C"))
        self._reach, self._stale, self.steps_done = reach, bool(stale), int(steps)

    def contacts(self) -> Contacts:
        """Closed contacts of pairs as they are now."""
        i, j, gap, normal, entry = self._pairs()
        closed = gap < 0.0
        past = self._past[entry[closed]]
        since = np.where(past[:, SINCE] < 0.0, float(self.steps_done), past[:, SINCE])
        return Contacts(i[closed], j[closed], -gap[closed], normal[closed], since * self.time_step, past[:, SPEED])

    def _pairs(self) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
        entry = np.arange(len(self._mates))
        i, j = np.repeat(np.arange(len(self.position)), np.diff(self._start)), (self._mates & MASK).astype(np.int64)
        apart = self.position[i] - self.position[j] - shifts(*self._sides)[self._mates >> BITS]
        distance = np.linalg.norm(apart, axis=1)
        gap = distance - self.radius[i] - self.radius[j]
        with np.errstate(invalid="ignore", divide="ignore"):
            return i, j, gap, apart / distance[:, None], entry

    def _interval(self, steps: int) -> None:
        before = self.state()
        status, culprit, done, self._reach, self._start, self._mates, self._past, self._near = loop.run_steps(
            self.position,
            self.velocity,
            self.spin,
            self._load,
            self._torque,
            self._listed,
            self._start,
            self._mates,
            self._past,
            self._near,
            self._wall_past,
            self.radius,
            self.mass,
            self.inertia,
            self.kind,
            self._table,
            self._walls,
            self._wall_kind,
            *self._sides,
            self.gravity,
            np.ascontiguousarray(self.force, np.float64),
            self._uniform,
            self.time_step,
            self.skin,
            STRIDE * float(self.radius.min()) / self.time_step,
            self._reach,
            self.steps_done,
            steps,
            self._stale,
            self.T,
            np.ascontiguousarray(self.heat_source, np.float64),
            1.0 / self.heat_capacity,
            self._heat_table,
        )
        if status == loop.OK and not np.isfinite(self.T).all():
            culprit = int((~np.isfinite(self.T)).argmax())
            self.restore(before)
            raise ConvergenceError(
                f"dem: temperature of particle {culprit} is not a number; a heat source, or a heat "
                "capacity too small for the time step",
                state=before,
            )
        if status == loop.OK:
            self.steps_done += steps
            self._stale = False
            return
        where, speed = self.position[culprit].copy(), float(np.linalg.norm(self.velocity[culprit]))
        self.restore(before)
        time = (self.steps_done + done + 1) * self.time_step
        raise ConvergenceError(_obituary(status, culprit, where, speed, time), state=before)

    def _warm(self, heat: ContactHeat | None, T: ArrayLike | None) -> None:
        if (heat is None) != (T is None):
            raise SceneError("dem: give both heat and T, or neither")
        n = 0 if heat is None else len(self.position)
        self.T, self.heat_source = np.empty(n), np.zeros(n)
        self.heat_capacity, self._heat_table = np.ones(n), np.zeros((0, 0, 5))
        if heat is not None and T is not None:
            self.T[:] = T
            self.heat_capacity = self.mass * heat.capacities(self.materials)[self.kind]
            self._heat_table = heat.table(self.materials)

    @property
    def _uniform(self) -> bool:
        return bool(np.ptp(self.radius) == 0.0 and np.ptp(self.kind) == 0)

    def _require_inside(self) -> None:
        lower, upper, periodic = self._sides
        outside = ((self.position < lower) | (self.position > upper)) & ~periodic
        if outside.any():
            index = int(outside.any(axis=1).argmax())
            raise SceneError(f"dem: particle {index} at {_place(self.position[index])} is outside the domain")
        lengths = np.where(periodic, upper - lower, 1.0)
        base = np.where(periodic, lower, 0.0)
        turns = np.where(periodic, np.floor((self.position - base) / lengths), 0.0)
        self.position -= turns * lengths

    def _require_apart(self, largest: float) -> None:
        i, j, gap, _, _ = self._pairs()
        deep = -gap / np.minimum(self.radius[i], self.radius[j])
        if len(deep) and deep.max() > largest:
            k = int(deep.argmax())
            raise SceneError(
                f"dem: particles {i[k]} and {j[k]} overlap by {-gap[k]:.4g} m at the start, {deep[k]:.2g} of the "
                f"smaller radius; at most {largest:g} is accepted; move them apart or settle them with dem.packing"
            )
        gaps = wall_gaps(self.position, self._walls) / self.radius
        if gaps.size and gaps.min() < 1.0 - largest:
            number, k = divmod(int(gaps.argmin()), len(self.position))
            where = "is beyond" if gaps.min() < 0.0 else "overlaps"
            raise SceneError(f"dem: particle {k} at {_place(self.position[k])} {where} wall {number} at the start")


def _blank(*shape: int) -> NDArray[np.float64]:
    past = np.zeros((*shape, HISTORY))
    past[..., SINCE] = -1.0
    return past


def _place(point: NDArray) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in point) + ") m"


def _obituary(status: int, particle: int, where: NDArray, speed: float, time: float) -> str:
    what = {
        loop.TOO_FAST: f"moves at {speed:.4g} m/s, more than {STRIDE:g} of the smallest radius in a step",
        loop.LOST: "left the domain",
        loop.BEYOND_WALL: "was pushed through a wall",
    }[status]
    return (
        f"dem: particle {particle} at {_place(where)} {what} at t = {time:.6g} s; "
        "the state before this interval is kept; try a smaller time step or a closed domain"
    )
