"""Error of what leaves a bed by the rings, layers or columns of its section: from a
second steady state with half as many of them, as the error is of second order.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contbed.arrays import Array
from contbed.errors import ConvergenceError
from contbed.reacting_bed import solve
from contbed.reacting_bed.equations.unknowns import Role
from contbed.reacting_bed.problem import Problem
from contbed.result import Result
from contbed.scene.values import at, with_value

KEY = ("packed_bed", "section", "rings")
LEAST = 4  # rings of which half are enough for an estimate
LARGE = 1e-2  # above which a run warns
# change of a temperature [K] and share of all gas below which nothing happens
LEAST_SPAN, LEAST_SHARE = 1.0, 1e-3


def report_section(problem: Problem, u: Array, result: Result) -> float:
    """Name the error of what leaves in a result, warn where it is large, and return it;
    0 where it is not estimated.
    """
    error = section_error(problem, u)
    if error is None:
        return 0.0
    result.qoi["estimated_error_section"] = error
    if error > LARGE:
        scene = problem.scene
        result.warnings.append(
            f"{scene.origin.at(KEY)}: packed_bed.section.rings = {at(scene, KEY)}: the "
            f"error across the flow is about {error:.1%} of what changes in the bed: use "
            "more rings"
        )
    return error


def section_error(problem: Problem, u: Array) -> float | None:
    """Estimate the error of what leaves, of means over the section, over what changes in
    the bed: temperatures, and the gas that changes most. None where half as many rings
    are too few or have no steady state.
    """
    scene, rings = problem.scene, problem.rings
    if rings is None or rings.number < LEAST:
        return None
    half = rings.number // 2
    coarse = replace(problem, scene=with_value(scene, KEY, half), damping=None)
    try:
        coarse, v = solve.first(coarse, _fewer(problem, u, half), solve.Report())
    except ConvergenceError:
        return None
    fine, rough = problem.mean(u), coarse.mean(v)
    gases = [
        k for k, each in enumerate(problem.layout.unknowns) if each.role is Role.GAS
    ]
    temperatures = [
        k
        for k, name in enumerate(problem.layout.names)
        if name in problem.layout.temperatures
    ]
    spans = np.ptp(fine.reshape(len(fine), -1), axis=1)
    sizes = np.full(len(fine), np.inf)
    sizes[gases] = max(float(spans[gases].max()), LEAST_SHARE * problem.moles)
    sizes[temperatures] = np.maximum(spans[temperatures], LEAST_SPAN)
    ends = np.s_[:, [0, -1], [0, -1]]
    change = np.abs(fine[ends] - rough[ends]) / sizes[:, None]
    return float(change.max() / ((rings.number / half) ** 2 - 1.0))


def _fewer(problem: Problem, u: Array, half: int) -> Array:
    """Return the state of the parts in the middle of which those of half as many lie."""
    rings = problem.rings
    assert rings is not None
    places = np.linspace(0.0, rings.number - 1.0, half).round().astype(int)
    shape = (rings.number,) * (2 if rings.shape == "duct" else 1)
    chosen = u.reshape(*shape, -1, *u.shape[1:])[places]
    if rings.shape == "duct":
        chosen = chosen[:, places]
    found: Array = chosen.reshape(-1, *u.shape[1:])
    return found
