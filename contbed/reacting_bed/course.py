"""A reacting bed in the course of a run: what its series say at a time, the state at
the start, where steps end.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.arrays import Array
from contbed.chemistry.kinetics import Reaction
from contbed.chemistry.local import Smoothing
from contbed.chemistry.thermo import R_GAS
from contbed.course.history import SAME, output_times
from contbed.course.schedule import Schedule
from contbed.errors import ConvergenceError
from contbed.materials.composition import mole_fractions
from contbed.reacting_bed import scene as s
from contbed.reacting_bed import solve
from contbed.reacting_bed.equations.unknowns import Role
from contbed.reacting_bed.history import BedHistory
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.schedule import kinks_passed
from contbed.reacting_bed.stages import GAMMA
from contbed.reacting_bed.storage import Storage
from contbed.scene.series import OF_A_TRACE
from contbed.scene.toml_lines import KeyPath

if TYPE_CHECKING:
    from contbed.reacting_bed.initial import Profile

# share of a gas or solid that is left, below which its powers are straight lines
SMOOTH = 1e-5
# mole fraction below which a gas or solid is taken as not there when smoothing is
# chosen
TRACE = 1e-9
# of the time that the gas stays, at the start and after a jump
FIRST_STEP = 5e-4
STAGES = (GAMMA, 1.0)  # times of the stages of a step over its size
# [K] of the temperatures of a run, where those of the scene and of the bed differ by
# less
LEAST_RANGE = 1.0


@dataclass(frozen=True)
class Course:
    """The bed of a scene in the course of a run, whose series have the values of a
    time; `problem` is at the start.

    `temperatures` are the lowest and highest of the scene: of what enters, of the wall
    and of the start [K]; `fractions` the largest mole fraction of each gas that enters,
    fills the bed, or is made from such gases; `initial` is the state of a file at the start.
    """

    scene: s.ReactingScene
    problem: Problem
    schedule: Schedule
    temperatures: tuple[float, float]
    fractions: Mapping[str, float]
    initial: Profile | None = None

    @classmethod
    def of(
        cls,
        scene: s.ReactingScene,
        problem: Problem,
        schedule: Schedule,
        stores_gas: bool,
    ) -> Course:
        """Return the bed of a plan; a gas that is stored is so at the pressures of the
        first moment.

        Raises
        ------
        ConvergenceError : these are not found
        """
        moments = problem.at_moments(scene, schedule)
        initial = initial_of(scene, problem)
        peaks = _peaks(scene, moments, initial)
        problem = problem.with_small(
            Smoothing(SMOOTH, SMOOTH * _scarcest(problem, peaks))
        ).with_peaks(peaks)
        course = cls(
            scene,
            problem,
            schedule,
            _temperatures(scene, moments, initial),
            _with_products(peaks, problem.reactions),
            initial,
        )
        if not stores_gas:
            return course
        pressure: Any = problem.bed.p_in
        if problem.layout.pressure:
            u = course.start()
            storage = Storage.after(course.problem, u, course.first_step)
            try:
                at_once = solve.newton(
                    course.problem,
                    u,
                    solve.Report(),
                    storage,
                    max_iterations=solve.FIRST_ITERATIONS,
                )
            except ConvergenceError as error:
                raise ConvergenceError(
                    f"{scene.origin.name}: {error} at t = 0 s, where the pressures of "
                    "the gas that fills the bed are "
                    'sought; give packed_bed.pressure_drop = "none"',
                    error.history,
                    error.state,
                ) from None
            pressure = problem.at_all_points(at_once)[problem.layout.names.index("p")]
        return replace(course, problem=course.problem.with_gas_stored(pressure))

    @property
    def time(self) -> s.Time:
        """The [time] table."""
        assert self.scene.time is not None
        return self.scene.time

    @property
    def rounds(self) -> int:
        """How often cells of a step may be others, where they follow its errors."""
        return follows(self.scene)

    def on(self, history: BedHistory) -> Course:
        """Return the course on the cells of a history."""
        if history.vertices is self.problem.line.vertices:
            return self
        problem = self.problem.on(history.vertices)
        return replace(
            self,
            problem=problem
            if history.pressure is None
            else problem.with_gas_stored(history.pressure),
        )

    @cached_property
    def small(self) -> dict[KeyPath, float]:
        """Sizes of kinks of the series that a step may pass."""
        return kinks_passed(self.schedule, self.scene)

    @cached_property
    def cuts(self) -> list[float]:
        """Jumps and kinks of the series, with the start and the end of the run [s]."""
        return self.schedule.cuts(self.time.end, self.small)

    @property
    def first_step(self) -> float:
        """Length of the first step, at the start and after a jump [s]."""
        return FIRST_STEP * self.problem.gas_residence

    def resolves(self, start: float, end: float) -> bool:
        """Return whether a step between two times [s] sees how the series change."""
        return self.schedule.sees(start, end, STAGES, self.small)

    def since(self, time: float) -> float:
        """Return the last jump or kink up to a time [s]."""
        return self.cuts[bisect_right(self.cuts, time * (1.0 + SAME)) - 1]

    def at(self, time: float, before: bool = True, since: float = 0.0) -> Problem:
        """Return the problem at a time [s], at a jump that `before` it, `since` an
        earlier one, or just after it.
        """
        if not self.schedule:
            return self.problem
        return self.problem.within(
            self.schedule.frozen(self.scene, time, before, since)
        )

    def start(self) -> Array:
        """Return the state at the start (m, N, p + 1)."""
        problem, initial = self.problem, self.scene.initial
        T = initial.gas_temperature or problem.streams.T_gas
        u, moles = problem.start(T), problem.streams.moles
        for k in problem.rows(Role.T_SOLID):
            table = initial.solids.get(str(problem.unknowns[k].phase))
            u[k] = (initial.temperature or T) if table is None else table.temperature
        if initial.gas.composition is not None:
            fractions = mole_fractions(initial.gas.composition)
            for k in problem.rows(Role.GAS):
                name = str(problem.unknowns[k].species)
                u[k] = fractions.get(name, 0.0) * moles
        if self.initial is not None:
            self.initial.fill(problem, u)
        m = len(problem.layout.names)
        for k in problem.rows(Role.POINT):
            point = problem.unknowns[k]
            # particles begin in equilibrium with the gas around them
            if self.initial is None or self.initial.inside(point) is None:
                first = k - k % m
                gas = first + problem.layout.gases.index(str(point.species))
                at = [
                    first + problem.layout.names.index(T)
                    for T in ("T_fluid", "T")
                    if T in problem.layout.names
                ]
                u[k] = (
                    u[gas]
                    / moles
                    * problem.streams.pressure
                    / (R_GAS * (u[at[0]] if at else T))
                )
        return u

    def sizes(self, u: Array) -> Array:
        """Return what errors of the unknowns refer to (m,): temperatures to the
        range of the scene and of a state, those of a trace to its own largest flux.
        """
        out = self.problem.sizes.copy()
        for k in self.problem.rows(Role.GAS):
            known = self.fractions.get(str(self.problem.unknowns[k].species), 1.0)
            largest = max(known * self.problem.moles, np.abs(u[k]).max())
            out[k] = min(out[k], OF_A_TRACE * largest)
        rows = [
            k
            for k, name in enumerate(self.problem.names)
            if name in self.problem.layout.temperatures
        ]
        if rows:
            low, high = self.temperatures
            out[rows] = max(high, u[rows].max()) - min(low, u[rows].min())
            out[rows] = np.maximum(out[rows], LEAST_RANGE)
        return out

    def stops(self) -> list[float]:
        """Return the times at which a step ends: output times, and jumps and kinks
        of the series [s].
        """
        time = self.time
        found: list[float] = []
        for stop in sorted({*output_times(time), *self.cuts} - {0.0}):
            if not found or stop - found[-1] > SAME * stop:
                found.append(stop)
        return found


def follows(scene: s.ReactingScene) -> int:
    """Return how often cells of a step in time may be others; 0 where they stay as
    they are.
    """
    return 0 if scene.time is None else scene.solver.adapt or 0


def initial_of(scene: s.ReactingScene, problem: Problem) -> Profile | None:
    """Return the state at the start that a scene takes from a file; None without one.

    Raises
    ------
    SceneError : the file cannot be used
    """
    if scene.time is None or scene.initial.file is None:
        return None
    from contbed.reacting_bed.initial import profile_of

    return profile_of(scene, problem)


def _peaks(
    scene: s.ReactingScene, moments: list[Problem], initial: Profile | None
) -> dict[str, float]:
    """Return the largest mole fraction of each gas that enters or fills the bed."""
    parts = [
        {name: g / at.streams.moles for name, g in at.streams.gas.items()}
        for at in moments
    ]
    if scene.initial.gas.composition is not None:
        parts.append(mole_fractions(scene.initial.gas.composition))
    if initial is not None:
        parts.append({name: float(x.max()) for name, x in initial.fractions.items()})
    return {
        name: max(part.get(name, 0.0) for part in parts)
        for part in parts
        for name in part
    }


def _with_products(
    peaks: Mapping[str, float], reactions: Iterable[Reaction]
) -> dict[str, float]:
    """Return mole fractions with those of gases that neither enter nor fill the bed: of
    the scarcest gas that a reaction makes them of, the largest of all reactions.
    """
    found = {name: x for name, x in peaks.items() if x > TRACE}
    entering = set(found)
    for _ in peaks:
        for reaction in reactions:
            sides = reaction.stoichiometry.items()
            known = [found[name] for name, nu in sides if nu < 0.0 and name in found]
            for name, nu in sides:
                if known and nu > 0.0 and name in peaks and name not in entering:
                    found[name] = max(found.get(name, 0.0), min(known))
    return found


def _scarcest(problem: Problem, peaks: Mapping[str, float]) -> float:
    """Return the least share of a gas or solid that reacts and enters or fills the
    bed: its powers are to stay.
    """
    gases = {name for reaction in problem.reactions for name in reaction.gases}
    solids = {
        name: n
        for name, n in problem.streams.solid.items()
        if name in problem.layout.solids
    }
    shares = [x for name, x in peaks.items() if name in gases]
    shares += [n / sum(solids.values()) for n in solids.values() if n > 0.0]
    return min((share for share in shares if share > TRACE), default=1.0)


def _temperatures(
    scene: s.ReactingScene, moments: list[Problem], initial: Profile | None
) -> tuple[float, float]:
    """Return the lowest and highest temperature of what enters, of the wall and of
    the start [K].
    """
    found: list[Any] = [
        T for at in moments for T in (at.streams.T_gas, *at.streams.T_solids.values())
    ]
    found += [at.scene.wall.ambient for at in moments if at.scene.wall is not None]
    found += scene.initial.temperatures.values()
    known = [constant(T) for T in found if T is not None]
    if initial is not None:
        known += [
            float(T)
            for each in initial.temperatures.values()
            for T in (each.min(), each.max())
        ]
    return min(known), max(known)
