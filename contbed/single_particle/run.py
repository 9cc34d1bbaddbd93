"""Run of one particle in time steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from contbed.chemistry.thermo import R_GAS
from contbed.course.dirk import STAGES, WEIGHTS, DirkSteps, Step, ladder, stages_of
from contbed.course.march import Accept
from contbed.course.schedule import Schedule
from contbed.errors import ConvergenceError
from contbed.materials.composition import mole_fractions
from contbed.materials.curve import function_of, integral_of
from contbed.output.progress import Progress
from contbed.result import Result, timed
from contbed.single_particle import results
from contbed.single_particle.equations import Material, Sphere, Surface
from contbed.single_particle.history import ParticleHistory, Passed
from contbed.single_particle.plan import Plan
from contbed.single_particle.scene import SURFACE, SingleParticleScene
from contbed.solvers.newton import Options

# [s] first step, at the start and after a jump
FIRST_STEP = 2.0**-10
ROWS = 100  # output times where none are given


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
        self.hottest = max(material.start, *values)
        cells = plan.scene.single_particle.cells
        self.problem = Sphere(material, surface, cells, self.span)
        self.control = ladder(FIRST_STEP)
        given = time.times or np.linspace(0.0, time.end, ROWS + 1).tolist()
        self.outputs = sorted({*given, time.end})

    def begin(self) -> ParticleHistory:
        """Return the history at the start of the run."""
        state = self.problem.initial()
        first = self._row(0.0, state)
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

    def take(
        self, history: ParticleHistory, end: float, size: float, repeated: bool = False
    ) -> tuple[float, Accept[ParticleHistory]]:
        """Take a step; errors refer to what reactions have heated too."""
        problem = self.problem
        T = history.state[: problem.shells]
        heated = float(np.abs(T - problem.material.start).max())
        error, accept = super().take(history, end, size, repeated)
        return error * self.span / max(self.span, heated), accept

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
                passed.append(self._row(time, stage))
        return replace(
            super().passed(history, step, end, size),
            sums=sums,
            exchanged=exchanged,
            passed=tuple(passed),
            kept=self.kept(history, step, end, self.outputs),
        )

    def _row(self, time: float, state: Any) -> Passed:
        problem = self.problem
        T = state[: problem.shells]
        steepest = float(np.abs(np.diff(T)).max())
        left, centre = problem.left(state), problem.centre(state)
        return time, left, centre, float(T.max()) - self.hottest, steepest


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
    results.balances(steps.problem, begin, history, result)
    results.profiles(plan, steps.problem, history.kept, result)
    results.findings(np.array(history.passed), steps.span, result)
