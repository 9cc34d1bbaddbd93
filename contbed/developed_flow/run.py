"""Run of a fully developed flow: a solution, and a mesh with nodes at its
kinks.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from contbed.developed_flow.equations import reach_of_fluctuations, uniform_fraction
from contbed.developed_flow.problem import (
    START_SPECULARITY,
    START_THETA,
    DevelopedProblem,
)
from contbed.developed_flow.results import fill
from contbed.errors import ConvergenceError
from contbed.result import Result, timed

Array = Any
# rounds that move a node to where gas and particles have the same velocity
MAX_ALIGNMENT_ROUNDS = 3
# distance to such a place over the size of the cells, within which a node stays [-]
ALIGNMENT_TOLERANCE = 1e-3
# relative difference of theta at the centre within which a solution is the wanted one
# [-]
BRANCH_TOLERANCE = 0.1
FINE_CELLS = 60  # cells from which a search that fails is not repeated on finer ones
# share of the radius; FCC of 75 um in 100 mm, without a solution, has 0.005, 200 um,
# with one, 0.02
SHORT_REACH = 0.01
# the same in turbulent gas, whose flat profile shears few particles: 200 um in 100 mm
# have 0.02, and their pressure falls to 0 on the way to turbulent gas
SHORT_REACH_TURBULENT = 0.05
LEAST_STOKES = 1.0  # below which drag stops particles sooner than shear moves them
FAR = 3.0  # mean free path over the radius, up to which flows are found
# factors on a granular temperature from which no solution is found
GUESSES = (0.01, 0.1, 10.0)


@timed("flow")
def run(
    plan: Any, result: Result, folder: Path | None, quiet: bool, start: Any
) -> None:
    """Solve and fill the result; a steady run cannot resume, so `folder` and `start`
    are ignored.
    """
    from contbed.output.progress import Progress

    with Progress(100.0, "% of the way", quiet) as progress:
        _run(plan, result, lambda share, note: progress.advance_to(100.0 * share, note))


def _run(plan: Any, result: Result, watch: Callable[[float, str], None]) -> None:
    meant = plan.scene.developed_flow.granular_temperature_centre
    problem = DevelopedProblem(plan)
    problem.watch = watch
    try:
        problem, state, history = _found(problem, meant or START_THETA, result)
        result.history += history
    except ConvergenceError as error:
        where = plan.scene.origin.at(("developed_flow",))
        text = f"{where}: developed_flow: no solution found; {advice(problem)}"
        raise ConvergenceError(text, error.history, error.state) from error
    result.plan = problem.plan
    fill(problem, state, result)
    result.solved = problem, state
    if (
        problem.particles
        and meant is not None
        and abs(result.qoi["theta_centre"] / meant - 1.0) > BRANCH_TOLERANCE
    ):
        where = plan.scene.origin.at(("developed_flow", "granular_temperature_centre"))
        found = result.qoi["theta_centre"]
        result.warnings.append(
            f"{where}: theta at the centre is {found:.4g} m2/s2, not near "
            f"{meant:g}: it is another solution of the same flows; try another value"
        )


def _found(
    problem: DevelopedProblem, theta: float, result: Result
) -> tuple[DevelopedProblem, Array, list[float]]:
    """Solve; where the cells are too coarse for the wall layer of fine particles, on
    half as large ones.
    """
    cells, first = problem.plan.scene.solver.cells, None
    for refinement in (1, 2, 4):
        try:
            if refinement > 1:
                watch = problem.watch
                problem = DevelopedProblem(
                    problem.plan.on(_halved(np.sort(problem.plan.mesh.skfem.p[0])))
                )
                problem.watch = watch
            state, history = problem.solve(theta)
            finished, state = aligned(problem, state)
        except ConvergenceError as error:
            first = first or error
            if not problem.particles or refinement * cells >= FINE_CELLS:
                break
            continue
        if refinement > 1:
            where = problem.plan.scene.origin.at(("solver", "cells"))
            result.warnings.append(
                f"{where}: no solution with {cells} cells; {refinement * cells} are "
                "used"
            )
        return finished, state, history
    assert first is not None
    raise first


def _halved(nodes: Array) -> Array:
    """Return nodes with one more in the middle of each pair."""
    return np.sort(np.concatenate([nodes, 0.5 * (nodes[1:] + nodes[:-1])]))


def advice(problem: DevelopedProblem) -> str:
    """Say what to try where no solution is found."""
    c = problem.c
    if not problem.particles:
        return "raise solver.newton_tolerance"
    relaxation = c.rho_solid * c.d_p**2 / (18.0 * c.mu_gas)
    stokes = relaxation * abs(c.velocity) / c.radius
    if stokes < LEAST_STOKES:
        return (
            f"the Stokes number of the particles, {stokes:.2g} by their relaxation time, "
            "gas_velocity and the radius, is below 1: drag stops their fluctuations, and "
            "the kinetic theory of this model does not hold for them"
        )
    theta = problem.plan.scene.developed_flow.granular_temperature_centre or START_THETA
    smooth = c.specularity < START_SPECULARITY
    turbulent = "eddy_viscosity" in c.closures
    short = SHORT_REACH_TURBULENT if turbulent and not smooth else SHORT_REACH
    if (
        "granular_production" not in c.closures
        and reach_of_fluctuations(c, theta) < short * c.radius
    ):
        return (
            'name closures.granular_production = "granular_production_koch": without '
            "it drag stops the fluctuations of "
            f"particles of {c.d_p:g} m away from walls, and no fraction carries the "
            f"pressure; or {_tries(problem)}"
        )
    free = c.d_p / (6.0 * 2.0**0.5 * uniform_fraction(c))
    if free > FAR * c.radius:
        return (
            f"the mean free path of the particles between collisions, {free:.2g} m, is far "
            "above the radius: they meet the wall more often than each other, which the "
            "kinetic theory of this model does not describe; the pressure gradient "
            "without particles, solids_mass_flux = 0, and their weight are a good "
            "estimate"
        )
    if smooth:
        return (
            f"a wall with specularity = {c.specularity:g} makes few fluctuations, and "
            "where drag stops them in the middle no fraction carries the pressure: "
            f"try {START_SPECULARITY:g}; or {_tries(problem)}"
        )
    return _tries(problem)


def _tries(problem: DevelopedProblem) -> str:
    """Say which easier scenes to start from."""
    c = problem.c
    others = ", ".join(
        f"{factor * (problem.plan.scene.developed_flow.granular_temperature_centre or START_THETA):.2g}"
        for factor in GUESSES
    )
    tries = f"try granular_temperature_centre = {others} m2/s2, or more solver.cells"
    easier = (
        f"a solids_mass_flux below {c.solid_flux:g} kg/m2/s, a gas_velocity above "
        f"{c.velocity:g} m/s"
    )
    if c.specularity > START_SPECULARITY:
        easier += f", a specularity below {c.specularity:g}"
    return f"{tries}; then reach the scene from one that is easier: {easier}"


def aligned(problem: DevelopedProblem, state: Array) -> tuple[DevelopedProblem, Array]:
    """Solve again with a node wherever gas and particles are equally fast, because
    drag has a kink there.
    """
    for _ in range(MAX_ALIGNMENT_ROUNDS if problem.particles else 0):
        nodes = np.sort(problem.plan.mesh.skfem.p[0])
        moved = nodes.copy()
        for place in _crossings(problem, state):
            k = 1 + int(np.argmin(np.abs(nodes[1:-1] - place)))
            if abs(nodes[k] - place) > ALIGNMENT_TOLERANCE * (
                nodes[k + 1] - nodes[k - 1]
            ):
                moved[k] = place
        if np.array_equal(moved, nodes):
            break
        problem = DevelopedProblem(problem.plan.on(moved))
        state, _ = problem.solve_from(state)
    return problem, state


def _crossings(problem: DevelopedProblem, state: Array) -> Array:
    order = np.argsort(problem.r)
    r = problem.r[order]
    slip = (
        problem.system.part(state, "u_gas") - problem.system.part(state, "u_solid")
    )[order]
    k = np.flatnonzero(slip[:-1] * slip[1:] < 0)
    return r[k] + (r[k + 1] - r[k]) * slip[k] / (slip[k] - slip[k + 1])
