"""Results of a transient run of a reacting bed: profiles at output times, the outlet
over time, totals that close.
"""

from __future__ import annotations

import numpy as np

from contbed.arrays import Array
from contbed.balance import HELD_SHARE, Balance
from contbed.reacting_bed import results
from contbed.reacting_bed.cells import aim
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.history import BedHistory
from contbed.reacting_bed.of_columns import (
    column_findings,
    early_fronts,
    narrow_zones,
)
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.storage import content
from contbed.reacting_bed.swings import largest_swing, unresolved_front
from contbed.reacting_bed.time_cells import SHORTEST
from contbed.result import Result

LARGE_ERROR = 3.0  # of cells over what is aimed at, above which the run warns


def fill(course: Course, history: BedHistory, result: Result) -> None:
    """Fill in results at the end, profiles at the output times, the outlet over time
    and totals of the run.
    """
    problem = course.on(history).at(history.time)
    results.fill(problem, history.state, result, history.least)
    kept = history.kept or {history.time: (history.vertices, history.state)}
    tables = [
        (t, results.profiles(course.at(t).on(vertices), u))
        for t, (vertices, u) in kept.items()
    ]
    result.profiles = {
        "t [s]": np.concatenate([np.full(len(c["x [m]"]), t) for t, c in tables])
    }
    result.profiles |= {
        key: np.concatenate([c[key] for _, c in tables]) for key in tables[0][1]
    }
    swings = [
        largest_swing(course.at(t).on(vertices), u, t)
        for t, (vertices, u) in kept.items()
    ]
    worst = max(swings, key=lambda each: each.size)
    result.warnings += unresolved_front(problem, worst)
    result.tables["outlet"] = history.table()
    columns = column_findings(course, history)
    result.warnings += early_fronts(course, columns)
    result.warnings += narrow_zones(course, history, columns)
    result.qoi |= columns
    result.qoi |= {
        "time_steps": history.steps,
        "time_reached_s": history.time,
        "cells": problem.line.cells,
    }
    result.qoi |= {
        "cells_damped": int(history.damped.sum()),
        "steps_damped": history.steps_damped,
    }
    result.qoi |= {"steps_limited": history.steps_limited}
    if course.rounds:
        result.adaptations = history.changes
        result.qoi |= {"cells_most": history.most, "cells_changes": history.changes}
        result.qoi["cells_error"] = error = history.rough / history.time
        if error > LARGE_ERROR * aim(problem):
            result.warnings.append(_short_fronts(problem, error))
    held = contents(problem, history.state)
    _balances(problem, held, history, result)
    result.qoi |= _converted(problem, held, history)


def _converted(problem: Problem, held: Array, history: BedHistory) -> dict[str, float]:
    """Return the share of each constituent of solids at rest that has reacted; `held`
    is what the bed holds at the end.
    """
    found = {}
    for k, unknown in enumerate(problem.layout.names):
        name = unknown.removeprefix("n_")
        if name in problem.layout.solids and not problem.bed.velocity_of(unknown):
            left = float(held[k] / history.held[k]) if history.held[k] > 0.0 else 1.0
            if left < 1.0:
                found[f"conversion_{name}"] = 1.0 - left
    return found


def _short_fronts(problem: Problem, error: float) -> str:
    """Return the warning about fronts that the shortest cells do not resolve."""
    shortest = SHORTEST * problem.scene.mesh.length
    return (
        f"fronts are shorter than the shortest cells, {shortest:.2g} m: errors there "
        f"are {error:.2g} of the sizes of "
        f"the fields, {aim(problem):.2g} are aimed at; add conduction or dispersion in "
        "[closures], or raise "
        "solver.tolerance"
    )


def contents(problem: Problem, u: Array) -> Array:
    """Return what the bed holds by equation, per area, means over the section by
    name of the layout (m,).
    """
    line = problem.line
    held = np.einsum("ecj,j,c->e", content(problem, u), line.weights, line.h)
    return problem.mean(held)


def _balances(
    problem: Problem, held: Array, history: BedHistory, result: Result
) -> None:
    """Add what of every element, and of energy with heats of formation, has passed
    the ends and is stored; `held` is what the bed holds at the end.
    """
    gain = held - history.held
    inward = history.passed * np.array([1.0, -1.0])
    elements = results.atoms_of(problem)
    both_ways = {
        element: float((atoms @ history.both_ways).sum())
        for element, atoms in elements.items()
    }
    scales = {
        element: max(
            both_ways[element],
            float(np.abs(gain * atoms).max()),
            _blurring(held * atoms),
        )
        for element, atoms in elements.items()
    }
    least = results.LEAST_ATOMS * max(scales.values())
    for element, atoms in elements.items():
        if scales[element] > least:
            result.balances[element] = Balance.of_fluxes(
                (atoms @ inward).tolist(),
                "mol/m2",
                stored=float(gain @ atoms),
                floor=scales[element],
                both_ways=both_ways[element],
            ).as_dict()
    unknowns = problem.layout.unknowns
    heat = [k for k, each in enumerate(unknowns) if each.is_temperature]
    if heat:
        wall = float(history.sources[heat].sum())
        fluxes = inward[heat].ravel().tolist()
        heat_both_ways = float(history.both_ways[heat].sum())
        stored = float(gain[heat].sum())
        scale = max(history.carried, abs(wall), abs(stored), _blurring(held[heat]))
        result.balances["energy"] = Balance.of_fluxes(
            fluxes, "J/m2", wall, stored, scale, heat_both_ways
        ).as_dict()


def _blurring(held: Array) -> float:
    """Return the least scale of a balance by what a bed holds: each step rounds it,
    whatever passes or reacts.
    """
    return HELD_SHARE * float(np.abs(held).sum())
