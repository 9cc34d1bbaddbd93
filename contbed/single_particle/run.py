"""Run of one particle: time steps, balances of mass and heat, what is left and how
hot it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from contbed.balance import Balance
from contbed.chemistry.thermo import R_GAS
from contbed.course.schedule import Schedule
from contbed.errors import ConvergenceError
from contbed.fields import header
from contbed.materials.composition import mole_fractions
from contbed.output.progress import Progress
from contbed.result import Result, timed
from contbed.scene.toml_lines import Origin
from contbed.single_particle.equations import SCALE_HEAT, Material, Sphere, Surface
from contbed.single_particle.plan import Plan
from contbed.single_particle.scene import SURFACE, SingleParticleScene
from contbed.solvers.timestep import LEVELS, STAGES, WEIGHTS, Step, level_of, march

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
    product = (
        solid.conductivity
        if solid.conductivity_product is None
        else solid.conductivity_product
    )
    return Material(
        0.5 * solid.diameter,
        solid.density,
        scene.initial.temperature,
        (solid.conductivity, product),
        scene.gas.heat_capacity,
        np.array([one.heat_capacity for one in solid.constituent.values()]),
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


def _pieces(
    problem: Sphere, state: Any, plan: Plan, series: Schedule, span: float
) -> Iterator[Step]:
    """Yield the time steps, none of which crosses a jump of the surroundings, or a
    kink beyond its error.
    """
    scene, size, tolerance = plan.scene, 0.0, plan.scene.time.tolerance
    small = series.small(tolerance, [problem.material.start])
    options = {
        "tolerance": scene.solver.newton_tolerance,
        "iterations": scene.solver.newton_iterations,
    }
    for start, end in pairwise(series.cuts(scene.time.end, small)):
        problem.surface = surface_of(scene, series, start)
        if start > 0.0:
            problem.set_time(start)
            state = problem.with_surface(state)
        level = (
            level_of(size, end - start) if size and not series.jumps(start) else None
        )
        for step in march(
            problem,
            state,
            end,
            plan.policy,
            tolerance=tolerance,
            span=span,
            start=start,
            level=level,
            newton_options=options,
            sees=lambda begin, until: series.sees(begin, until, STAGES, small),
        ):
            yield step
            state, size = (
                step.states[-1],
                (end - start) * 2.0 ** (step.next_level - LEVELS),
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
    scene = plan.scene
    material = material_of(scene)
    series = Schedule.of(scene.boundary, scene.origin.base)
    surface, end = surface_of(scene, series), scene.time.end
    moments = sorted(
        {*(scene.time.times or np.linspace(0.0, end, ROWS + 1).tolist()), end}
    )
    values = [v for samples in series.samples.values() for v in samples.values] or [
        surface.furnace(0.0)
    ]
    span = max(max(values) - material.start, material.start - min(values), 1.0)
    problem = Sphere(material, surface, scene.single_particle.cells, span)
    state = problem.initial()
    kept = [state] if moments[0] == 0.0 else []
    # heat conducted in, carried out, released [J/kg], gas that left; heat both ways
    sums, exchanged = np.zeros(4), 0.0
    passed = [(0.0, _mass(problem, state), problem.centre(state))]
    before = problem.content(state, False)[0]
    mass0 = _mass(problem, state)
    gas = (problem.count + 2) * problem.shells - 1
    steps = _pieces(problem, state, plan, series, span)
    with Progress(end, "s", quiet) as progress:
        for step in _told(steps, scene.origin):
            for moment in moments[len(kept) :]:
                if moment <= step.end * (1 + 1e-12):
                    kept.append(
                        step.states[-1] if moment >= step.end else step.at(moment)
                    )
            for weight, share, stage in zip(WEIGHTS, STAGES, step.states, strict=True):
                problem.set_time(step.start + share * step.size)
                rates = np.array([*problem.heat_in(stage), stage[gas]])
                sums += weight * step.size * rates
                exchanged += weight * step.size * abs(rates[0])
                if share:
                    passed.append(
                        (
                            step.start + share * step.size,
                            _mass(problem, stage),
                            problem.centre(stage),
                        )
                    )
            state = step.states[-1]
            progress.advance_to(step.end)
    whole = material.density * np.pi / 6.0 * (2.0 * material.radius) ** 3
    n = problem.shells
    stored = SCALE_HEAT * float((problem.content(state, False)[0] - before)[:n].sum())
    conducted, carried, released, left = sums
    held = SCALE_HEAT * float(np.abs(problem.content(state, False)[0][:n]).sum())
    parts = [conducted * whole, -carried * whole]
    result.balances["energy"] = Balance.of_fluxes(
        parts, "J", released * whole, stored * whole, floor=max(held, exchanged) * whole
    ).as_dict()
    mass = _mass(problem, state)
    result.balances["mass"] = Balance.of_fluxes(
        [-left * whole], "kg", 0.0, (mass - mass0) * whole, whole
    ).as_dict()
    _profiles(plan, problem, moments, kept, result)
    _findings(np.array(passed), result)


def _mass(problem: Sphere, state: Any) -> float:
    """Return the mass that is left over that of the fresh particle."""
    return float(problem.volume @ problem.masses(state).sum(axis=0))


def _told(steps: Iterator[Step], origin: Origin) -> Iterator[Step]:
    """Yield the steps; an error that stops them names the time and a remedy."""
    reached = 0.0
    try:
        for step in steps:
            yield step
            reached = step.end
    except ConvergenceError as error:
        text = f"{origin.at(('reactions',))}: {error}, at t = {reached:.4g} s"
        advice = (
            "no shorter step helps; a reaction may be too fast: lower its A, or "
            "raise its E"
        )
        raise ConvergenceError(
            f"{text}: {advice}", error.history, error.state
        ) from None


def _profiles(
    plan: Plan, problem: Sphere, moments: list[float], kept: list[Any], result: Result
) -> None:
    """Fill in what is left and temperatures at the output times."""
    n, volume = problem.shells, problem.volume
    masses = np.array([problem.masses(state) @ volume for state in kept])
    result.profiles = {
        header("t"): np.array(moments),
        header("mass_fraction"): masses.sum(axis=1),
        header("T_centre"): np.array([problem.centre(state) for state in kept]),
        header("T_surface"): np.array([state[-1] for state in kept]),
        header("T_mean"): np.array([state[:n] @ volume for state in kept]),
    }
    for k, name in enumerate(plan.scene.solid.constituent):
        result.profiles[f"mass_fraction.{name} [1]"] = masses[:, k]


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
