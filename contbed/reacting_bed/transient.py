"""Steps in time of a reacting bed: particles store moles and heat, the gas follows at once.

    d/dt C(u) + R(u) = 0,    C what particles hold per volume of bed, zero for equations of the gas

Two stages of an L-stable diagonally implicit method of order 2 with gamma = 1 - 1/sqrt(2), written for C:

    C(U1) = C_n - gamma dt R(U1),    C(u) = C_n - (1 - gamma) dt R(U1) - gamma dt R(u)

What is stored is exactly what has passed the ends, weighted as the stages are. Steps follow the difference to a method
of order 1, filtered by the matrix of the last stage.

Source: Alexander 1977, SIAM J. Numer. Anal. 14, 1006-1021, doi:10.1137/0714068.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contbed.balance import Balance
from contbed.errors import ConvergenceError
from contbed.fem.line_blocks import Factors
from contbed.output.progress import Progress
from contbed.reacting_bed import results, solve
from contbed.reacting_bed.problem import Problem
from contbed.result import Result

Array = NDArray[np.float64]
GAMMA = 1.0 - 0.5**0.5
SMOOTH = 1e-5  # share of a solid that is left, below which its powers are straight lines
FIRST_STEP = 1e-5  # of the whole time
SHORTEST_STEP = 1e-12  # of the whole time, below which a run is given up
SAFETY, MOST_GROWTH, LEAST_GROWTH = 0.8, 2.5, 0.2


@dataclass
class History:
    """What a run has passed: state, time, totals through the ends and outlet over time."""

    u: Array
    time: float = 0.0
    steps: int = 0
    passed: Array = field(default_factory=lambda: np.zeros(0))  # integral of the fluxes at both ends, (m, 2)
    sources: Array = field(default_factory=lambda: np.zeros(0))  # integral of the sources, (m,)
    outlet: list[dict[str, float]] = field(default_factory=list)


def run_transient(problem: Problem, result: Result, quiet: bool) -> None:
    """Take steps to the end and fill the result.

    Raises
    ------
    ConvergenceError : steps become ever smaller
    """
    time = problem.scene.time
    assert time is not None
    problem = problem.with_small(SMOOTH)
    report = solve.Report()
    start = problem.start(time.initial_temperature or problem.streams.T_gas)
    m = len(problem.layout.names)
    history = History(start, passed=np.zeros((m, 2)), sources=np.zeros(m))
    held = contents(problem, start)
    snapshots: list[tuple[float, Array]] = []
    stops = sorted({*time.times, time.end} - {0.0})
    dt = FIRST_STEP * time.end
    try:
        with result.timed("bed"), Progress(time.end, "s", quiet) as progress:
            for stop in stops:
                dt = advance(problem, history, stop, dt, report)
                progress.advance_to(history.time)
                snapshots.append((history.time, history.u))
    except ConvergenceError as error:
        raise ConvergenceError(
            f"{problem.scene.origin.name}: {error} at t = {history.time:.4g} s; use more mesh.cells, or smooth a rate "
            "whose slope is infinite where nothing is left",
            report.history,
            history.u,
        ) from None
    finally:
        result.history += report.history[-50:]
        if history.steps:
            _fill(problem, history, snapshots or [(history.time, history.u)], held, result)


def advance(problem: Problem, history: History, stop: float, dt: float, report: solve.Report) -> float:
    """Take steps to a time; the length of the next step is returned."""
    time = problem.scene.time
    assert time is not None
    while history.time < stop * (1.0 - 1e-13):
        step = min(dt, stop - history.time)
        if step < SHORTEST_STEP * time.end and stop - history.time > 2.0 * step:
            raise ConvergenceError("steps in time become ever smaller")
        try:
            first, last, error = stages(problem, history.u, step, report)
        except ConvergenceError:
            dt = 0.25 * step
            if dt < SHORTEST_STEP * time.end:
                raise
            continue
        growth = SAFETY * (time.tolerance / max(error, 1e-300)) ** 0.5
        if error > time.tolerance and growth < 1.0:
            dt = step * max(growth, LEAST_GROWTH)
            continue
        fluxes = [problem.system.fluxes(u)[:, [0, -1]] for u in (first, last)]
        sources = [problem.system.sources(u) for u in (first, last)]
        history.passed = history.passed + step * ((1.0 - GAMMA) * fluxes[0] + GAMMA * fluxes[1])
        history.sources = history.sources + step * ((1.0 - GAMMA) * sources[0] + GAMMA * sources[1])
        history.u, history.time, history.steps = last, history.time + step, history.steps + 1
        history.outlet.append(_outlet(problem, history, fluxes[1]))
        dt = max(dt, step) * min(max(growth, LEAST_GROWTH), MOST_GROWTH) if step == dt else dt
    history.time = stop
    return dt


def stages(problem: Problem, u: Array, dt: float, report: solve.Report) -> tuple[Array, Array, float]:
    """Return both stages of a step and the estimate of its local error over typical sizes."""
    store = solve.Storage(problem, np.zeros_like(u), GAMMA * dt, loose=False)
    before = store.content(u, False)[0]
    one = solve.Storage(problem, before, GAMMA * dt, loose=False)
    first = solve.newton(problem, u, report, one, most=solve.FIRST_ITERATIONS)
    slope = (store.content(first, False)[0] - before) / (GAMMA * dt)
    target = before + (1.0 - GAMMA) * dt * slope
    two = solve.Storage(problem, target, GAMMA * dt, loose=False)
    last = solve.newton(problem, first, report, two, most=solve.FIRST_ITERATIONS)
    change = slope - (store.content(last, False)[0] - target) / (GAMMA * dt)
    line = problem.line
    difference = (0.5 - GAMMA) / GAMMA * change * line.weights * line.h[:, None]
    _, blocks = problem.system.assemble(last)
    blocks[1][...] += two(last, True)[1]
    filtered = Factors(blocks).solve(difference) / problem.sizes[:, None, None]
    return first, last, float(np.abs(filtered).max())


def contents(problem: Problem, u: Array) -> Array:
    """Return what the bed holds by equation, per area (m,)."""
    held = solve.Storage(problem, np.zeros_like(u), 1.0).content(u, False)[0]
    line = problem.line
    total: Array = np.einsum("ecj,j,c->e", held, line.weights, line.h)
    return total


def _outlet(problem: Problem, history: History, fluxes: Array) -> dict[str, float]:
    end = -1 if problem.streams.ahead else 0
    gas = {name: fluxes[k, end] for k, name in enumerate(problem.layout.gases)}
    total = sum(gas.values())
    state = results.values_at(problem, history.u, problem.line.vertices[[0, -1]])
    T = float(np.broadcast_to(state.T_fluid, (2,))[end])
    return {"t [s]": history.time, "T_fluid [K]": T} | {f"x_{k} [1]": float(g / total) for k, g in gas.items()}


def _fill(
    problem: Problem, history: History, snapshots: list[tuple[float, Array]], held: Array, result: Result
) -> None:
    """Fill in results at the end, profiles at the output times, the outlet over time and totals of the run."""
    results.fill(problem, history.u, result, transient=True)
    tables = [(t, results.profiles(problem, u)) for t, u in snapshots]
    result.profiles = {"t [s]": np.concatenate([np.full(len(c["x [m]"]), t) for t, c in tables])}
    result.profiles |= {key: np.concatenate([c[key] for _, c in tables]) for key in tables[0][1]}
    result.tables["outlet"] = {key: np.array([row[key] for row in history.outlet]) for key in history.outlet[0]}
    result.qoi |= {"time_steps": history.steps, "time_reached_s": history.time, "cells": problem.line.cells}
    gain = contents(problem, history.u) - held
    names = problem.layout.names
    inward = history.passed * np.array([1.0, -1.0])
    for element in dict.fromkeys(e for item in problem.species.all.values() for e in item.composition):
        atoms = np.zeros(len(names))
        for k, name in enumerate(names):
            if name[:2] in ("g_", "n_"):
                atoms[k] = problem.species.all[name[2:]].composition.get(element, 0.0)
        parts = (inward * atoms[:, None]).ravel()
        entering, leaving = parts[parts > 0].sum(), -parts[parts < 0].sum()
        stored = float(gain @ atoms)
        scale = max(entering, float(np.abs(gain * atoms).max()))
        if scale > 0.0:
            result.balances[element] = Balance(
                float(entering), float(leaving), "mol/m2", stored=stored, scale=float(scale)
            ).as_dict()
    heat = [k for k, name in enumerate(names) if name in problem.layout.temperatures]
    if heat:
        wall = float(history.sources[heat].sum())
        parts = inward[heat].ravel()
        stored = float(gain[heat].sum())
        carried = results.heat_carried(problem, history.u) * history.time
        scale = max(carried, abs(wall), abs(stored))
        result.balances["energy"] = Balance.of_fluxes(
            [float(part) for part in parts], "J/m2", wall, stored, floor=scale
        ).as_dict()
