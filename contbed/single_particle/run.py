"""Run of one particle: time steps, balances of mass and heat, what is left and how hot it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from contbed.balance import Balance
from contbed.errors import ConvergenceError
from contbed.fields import header
from contbed.output.progress import Progress
from contbed.result import Result, timed
from contbed.scene.series import Series
from contbed.scene.toml_lines import Origin
from contbed.single_particle.equations import SCALE_HEAT, Material, Sphere, Surface
from contbed.single_particle.plan import Plan
from contbed.single_particle.scene import SingleParticleScene
from contbed.solvers.timestep import STAGES, WEIGHTS, Step, march

ROWS = 100  # output times where none are given


def material_of(scene: SingleParticleScene) -> Material:
    """Return the numbers of the particle of a scene."""
    names, table = list(scene.constituent), scene.particle
    reactions = list(scene.reactions.values())
    change = np.array([[r.yields.get(name, 0.0) - (r.of == name) for r in reactions] for name in names])
    product = table.conductivity if table.conductivity_product is None else table.conductivity_product
    return Material(
        0.5 * table.diameter,
        table.density,
        table.temperature,
        (table.conductivity, product),
        table.gas_heat_capacity,
        np.array([one.heat_capacity for one in scene.constituent.values()]),
        np.array([one.mass_fraction for one in scene.constituent.values()]),
        np.array([r.A for r in reactions]),
        np.array([r.activation_temperature for r in reactions]),
        np.array([r.heat for r in reactions]),
        np.array([names.index(r.of) for r in reactions], dtype=np.int64),
        change.reshape(len(names), len(reactions)),
    )


def surface_of(scene: SingleParticleScene) -> Surface:
    """Return the condition at the surface of a scene."""
    table, base = scene.surroundings, scene.origin.base

    def function(value: Any) -> Callable[[float], float]:
        if isinstance(value, Series):
            samples = value.samples(base)
            return lambda t: float(samples.at(t))
        return lambda t: float(value)

    if table.surface is not None:
        given = function(table.surface)
        return Surface(given, given, 0.0, 0.0)
    return Surface(None, function(table.temperature), table.coefficient, table.emissivity or 0.0)


@timed("particle")
def run(plan: Plan, result: Result, folder: Path | None, quiet: bool, start: tuple[Any, Any] | None) -> None:
    """Solve and fill the result; a run of seconds keeps no checkpoint.

    Raises
    ------
    ConvergenceError : a time step fails
    """
    scene = plan.scene
    material, surface = material_of(scene), surface_of(scene)
    end = scene.time.end
    moments = sorted({*(scene.time.times or np.linspace(0.0, end, ROWS + 1).tolist()), end})
    samples = [surface.furnace(t) for t in np.linspace(0.0, end, ROWS + 1)]
    span = max(max(samples) - material.start, material.start - min(samples), 1.0)
    problem = Sphere(material, surface, scene.particle.cells, span)
    state = problem.initial()
    kept = [state] if moments[0] == 0.0 else []
    sums = np.zeros(4)  # heat conducted in, carried out, released [J/kg]; gas that left
    before = problem.content(state, False)[0]
    mass0 = float(problem.volume @ problem.masses(state).sum(axis=0))
    options = {"tolerance": scene.solver.newton_tolerance, "iterations": scene.solver.newton_iterations}
    gas = (problem.count + 2) * problem.shells - 1
    steps = march(problem, state, end, plan.policy, tolerance=scene.time.tolerance, span=span, newton_options=options)
    with Progress(end, "s", quiet) as progress:
        for step in _told(steps, scene.origin):
            for moment in moments[len(kept) :]:
                if moment <= step.end * (1 + 1e-12):
                    kept.append(step.states[-1] if moment >= step.end else step.at(moment))
            for weight, share, stage in zip(WEIGHTS, STAGES, step.states, strict=True):
                problem.at(step.start + share * step.size)
                sums += weight * step.size * np.array([*problem.heat_in(stage), stage[gas]])
            state = step.states[-1]
            progress.advance_to(step.end)
    whole = material.density * np.pi / 6.0 * (2.0 * material.radius) ** 3
    n = problem.shells
    stored = SCALE_HEAT * float((problem.content(state, False)[0] - before)[:n].sum())
    conducted, carried, released, left = sums
    held = SCALE_HEAT * float(np.abs(problem.content(state, False)[0][:n]).sum())
    parts = [conducted * whole, -carried * whole]
    result.balances["energy"] = Balance.of_fluxes(
        parts, "J", released * whole, stored * whole, floor=held * whole
    ).as_dict()
    mass = float(problem.volume @ problem.masses(state).sum(axis=0))
    result.balances["mass"] = Balance.of_fluxes([-left * whole], "kg", 0.0, (mass - mass0) * whole, whole).as_dict()
    _findings(plan, problem, moments, kept, result)


def _told(steps: Iterator[Step], origin: Origin) -> Iterator[Step]:
    """Yield the steps; what stops them is told with its time and what to try."""
    reached = 0.0
    try:
        for step in steps:
            yield step
            reached = step.end
    except ConvergenceError as error:
        text = f"{origin.at(('reactions',))}: {error}, at t = {reached:.4g} s"
        advice = "no shorter step helps; a reaction may be too fast: lower its A, or raise its activation_temperature"
        raise ConvergenceError(f"{text}: {advice}", error.history, error.state) from None


def _findings(plan: Plan, problem: Sphere, moments: list[float], kept: list[Any], result: Result) -> None:
    """Fill in what is left and temperatures over the time."""
    n, volume = problem.shells, problem.volume
    masses = np.array([problem.masses(state) @ volume for state in kept])
    result.profiles = {
        header("t"): np.array(moments),
        header("mass_fraction"): masses.sum(axis=1),
        header("T_centre"): np.array([problem.centre(state) for state in kept]),
        header("T_surface"): np.array([state[-1] for state in kept]),
        header("T_mean"): np.array([state[:n] @ volume for state in kept]),
    }
    for k, name in enumerate(plan.scene.constituent):
        result.profiles[f"mass_fraction.{name} [1]"] = masses[:, k]
    hottest = int(np.argmax(result.profiles[header("T_centre")]))
    half = masses.sum(axis=1)
    middle = 0.5 * (half[0] + half[-1])
    result.qoi |= {
        "mass_fraction_end": float(half[-1]),
        "T_centre_max_K": float(result.profiles[header("T_centre")][hottest]),
        "time_of_T_centre_max_s": moments[hottest],
        "half_time_s": float(np.interp(-middle, -half, moments)),
    }
