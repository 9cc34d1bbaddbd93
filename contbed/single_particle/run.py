"""Run of one particle: time steps, balances of mass and heat, what is left and how
hot it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from contbed.balance import Balance
from contbed.chemistry.thermo import R_GAS
from contbed.course.dirk import STAGES, WEIGHTS, DirkSteps, Step, ladder, stages_of
from contbed.course.history import History
from contbed.course.schedule import Schedule
from contbed.errors import ConvergenceError
from contbed.fields import header
from contbed.materials.common import share_outside
from contbed.materials.composition import mole_fractions
from contbed.materials.curve import function_of, integral_of
from contbed.output.progress import Progress
from contbed.result import Result, timed
from contbed.scene.property_table import range_of
from contbed.single_particle.equations import SCALE_HEAT, Material, Sphere, Surface
from contbed.single_particle.plan import Plan
from contbed.single_particle.scene import SURFACE, SingleParticleScene
from contbed.solvers.newton import Options

# [s] first step, at the start and after a jump
FIRST_STEP = 2.0**-10
ROWS = 100  # output times where none are given
# of the mass, below which none is lost, and no time in which half of it is
LEAST_LOSS = 1e-9


def material_of(scene: SingleParticleScene) -> Material:
    """Return the numbers of the particle of a scene."""
    solid = scene.solid
    names, fresh = list(solid.constituent), mole_fractions(solid.composition)
    reactions = list(scene.reactions.values())
    change = np.array(
        [
            [r.yields.get(name, 0.0) - (r.of == name) for r in reactions]
            for name in names
        ]
    )
    T_start = scene.initial.temperature
    fresh_k, product_k = solid.conductivity, solid.conductivity_product
    return Material(
        0.5 * solid.diameter,
        solid.density,
        T_start,
        (
            function_of(fresh_k),
            function_of(fresh_k if product_k is None else product_k),
        ),
        scene.gas.heat_capacity,
        tuple(
            cp if isinstance(cp, float) else integral_of(cp, None, T_start)
            for cp in (one.heat_capacity for one in solid.constituent.values())
        ),
        np.array([fresh.get(name, 0.0) for name in names]),
        np.array([r.A for r in reactions]),
        np.array([r.E / R_GAS for r in reactions]),
        np.array([r.heat for r in reactions]),
        np.array([names.index(r.of) for r in reactions], dtype=np.int64),
        change.reshape(len(names), len(reactions)),
    )


def surface_of(
    scene: SingleParticleScene, series: Schedule, since: float = 0.0
) -> Surface:
    """Return the condition at the surface from a jump or kink of the series to the
    next, `since` the former [s].
    """
    table = scene.surface

    def function(key: str) -> Callable[[float], float]:
        samples = series.samples.get(("boundary", SURFACE, key))
        if samples is None:
            value = float(getattr(table, key))
            return lambda t: value
        return lambda t: float(samples.at(t, before=True, since=since))

    if table.fixed_temperature is not None:
        given = function("fixed_temperature")
        return Surface(given, given, 0.0, 0.0)
    return Surface(
        None, function("ambient"), table.coefficient, table.emissivity or 0.0
    )


@dataclass(frozen=True, kw_only=True)
class ParticleHistory(History):
    """State of a particle and what it has passed.

    sums : heat conducted in, carried out, released [J/kg], gas that left; exchanged :
        heat both ways
    passed : time, mass and centre temperature of all stages
    """

    sums: Any
    exchanged: float = 0.0
    passed: tuple[tuple[float, float, float], ...]


class ParticleSteps(DirkSteps[ParticleHistory]):
    """The time steps of a plan, none of which crosses a jump of the surroundings, or a
    kink beyond its error.
    """

    def __init__(self, plan: Plan):
        self.scene, self.policy = plan.scene, plan.policy
        material, time = material_of(plan.scene), plan.scene.time
        self.series = Schedule.of(plan.scene.boundary, plan.scene.origin.base)
        self.small = self.series.small(time.tolerance, [material.start])
        self.cuts = self.series.cuts(time.end, self.small)
        surface = surface_of(plan.scene, self.series)
        values = self.series.temperatures() or [surface.furnace(0.0)]
        farthest = max(abs(T - material.start) for T in values)
        self.span, self.tolerance = max(farthest, 1.0), time.tolerance
        cells = plan.scene.single_particle.cells
        self.problem = Sphere(material, surface, cells, self.span)
        self.control = ladder(FIRST_STEP)
        given = time.times or np.linspace(0.0, time.end, ROWS + 1).tolist()
        self.outputs = sorted({*given, time.end})

    def begin(self) -> ParticleHistory:
        """Return the history at the start of the run."""
        state = self.problem.initial()
        first = (0.0, _mass(self.problem, state), self.problem.centre(state))
        history = ParticleHistory(
            state=state, size=FIRST_STEP, sums=np.zeros(4), passed=(first,)
        )
        return history.keeping(0.0) if self.outputs[0] == 0.0 else history

    def stops(self) -> list[float]:
        """Return the times of jumps and kinks, and the end [s]."""
        return self.cuts[1:]

    def resolves(self, start: float, end: float) -> bool:
        """Return whether a step misses less of the series than is small."""
        return self.series.sees(start, end, STAGES, self.small)

    def entered(self, history: ParticleHistory, stop: float) -> ParticleHistory:
        """Return the history with the surface after a jump or kink."""
        problem, time = self.problem, history.time
        problem.surface = surface_of(self.scene, self.series, time)
        options = Options.of(self.scene, what="time step")
        self.stages = stages_of(problem, self.policy, options)
        if time == 0.0:
            return history
        problem.set_time(time)
        size = FIRST_STEP if self.series.jumps(time) else history.size
        return replace(history, state=problem.with_surface(history.state), size=size)

    def passed(
        self, history: ParticleHistory, step: Step, end: float, size: float
    ) -> ParticleHistory:
        """Return the history after a step; the weights are those of the method."""
        problem, passed = self.problem, list(history.passed)
        gas = (problem.count + 2) * problem.shells - 1
        sums, exchanged = history.sums, history.exchanged
        for weight, share, stage in zip(WEIGHTS, STAGES, step.states, strict=True):
            time = step.start + share * step.size
            problem.set_time(time)
            rates = np.array([*problem.heat_in(stage), stage[gas]])
            sums = sums + weight * step.size * rates
            exchanged += weight * step.size * abs(rates[0])
            if share:
                passed.append((time, _mass(problem, stage), problem.centre(stage)))
        return replace(
            super().passed(history, step, end, size),
            sums=sums,
            exchanged=exchanged,
            passed=tuple(passed),
            kept=self.kept(history, step, end, self.outputs),
        )


@timed("particle")
def run(
    plan: Plan,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    """Solve and fill the result; a run of seconds keeps no checkpoint.

    Raises
    ------
    ConvergenceError : a time step fails
    """
    steps = ParticleSteps(plan)
    begin = history = steps.begin()
    try:
        with Progress(plan.scene.time.end, "s", quiet) as progress:
            for history in steps.march(begin):
                progress.advance_to(history.time)
    except ConvergenceError as error:
        text = f"{plan.scene.origin.at(('reactions',))}: {error}"
        advice = (
            "no shorter step helps; a reaction may be too fast: lower its A, or "
            "raise its E"
        )
        raise ConvergenceError(
            f"{text}, at t = {history.time:.4g} s: {advice}", error.history, error.state
        ) from None
    _balances(steps.problem, begin, history, result)
    _profiles(plan, steps.problem, history.kept, result)
    _findings(np.array(history.passed), result)


def _balances(
    problem: Sphere, begin: ParticleHistory, history: ParticleHistory, result: Result
) -> None:
    """Fill in the balances of energy and mass."""
    material, n = problem.material, problem.shells
    whole = material.density * np.pi / 6.0 * (2.0 * material.radius) ** 3
    before, content = (
        problem.content(each.state, False)[0][:n] for each in (begin, history)
    )
    stored = SCALE_HEAT * float((content - before).sum())
    conducted, carried, released, left = history.sums
    held = SCALE_HEAT * float(np.abs(content).sum())
    parts = [conducted * whole, -carried * whole]
    both_ways = (history.exchanged + abs(carried)) * whole
    result.balances["energy"] = Balance.of_fluxes(
        parts, "J", released * whole, stored * whole, held * whole, both_ways
    ).as_dict()
    gain = _mass(problem, history.state) - _mass(problem, begin.state)
    result.balances["mass"] = Balance.of_fluxes(
        [-left * whole], "kg", 0.0, gain * whole, whole
    ).as_dict()


def _mass(problem: Sphere, state: Any) -> float:
    """Return the mass that is left over that of the fresh particle."""
    return float(problem.volume @ problem.masses(state).sum(axis=0))


def _profiles(
    plan: Plan, problem: Sphere, kept: Mapping[float, Any], result: Result
) -> None:
    """Fill in what is left and temperatures at the output times."""
    n, volume = problem.shells, problem.volume
    states = kept.values()
    masses = np.array([problem.masses(state) @ volume for state in states])
    result.profiles = {
        header("t"): np.array(list(kept)),
        header("mass_fraction"): masses.sum(axis=1),
        header("T_centre"): np.array([problem.centre(state) for state in states]),
        header("T_surface"): np.array([state[-1] for state in states]),
        header("T_mean"): np.array([state[:n] @ volume for state in states]),
    }
    solid = plan.scene.solid
    for k, name in enumerate(solid.constituent):
        result.profiles[f"mass_fraction.{name} [1]"] = masses[:, k]
    capacities = [one.heat_capacity for one in solid.constituent.values()]
    limits = range_of(solid.conductivity, solid.conductivity_product, *capacities)
    T = np.array([state[:n] for state in states])
    if share_outside(T, limits):
        low, high = limits
        result.warnings.append(
            f"data of the particle from {low:g} to {high:g} K are used at "
            f"{T.min():.5g} to {T.max():.5g} K"
        )


def _findings(passed: NDArray[np.float64], result: Result) -> None:
    """Fill in numbers of the whole run; `passed` (n, 3) are times, masses and centre
    temperatures of all steps.
    """
    times, mass, centre = passed.T
    hottest = int(np.argmax(centre))
    result.qoi |= {
        "mass_fraction_end": float(mass[-1]),
        "T_centre_max_K": float(centre[hottest]),
        "time_of_T_centre_max_s": float(times[hottest]),
    }
    if mass[0] - mass[-1] > LEAST_LOSS:
        left, middle = PchipInterpolator(times, mass), 0.5 * (mass[0] + mass[-1])
        k = int(np.argmax(mass <= middle))
        result.qoi["half_time_s"] = float(
            brentq(lambda t: left(t) - middle, times[k - 1], times[k])
        )
