"""Amounts of gases and solids that stay above zero: polynomials that fall below are
damped in their cells.

Where a reaction ends at a point, or a front is shorter than a cell, a polynomial of
degree p undershoots. Diffusion inside of the cell alone (`fem.line_dg`) takes nothing
and adds nothing, so that balances close as before. Where it is strong the amount is
constant in the cell and its equation the upwind one of order 1,

    C_e(u) - C_e(u_upwind) = h S_e(u),

whose solution is not below zero if what enters the cell is not and no rate consumes an
absent species. The damping grows until no amount is below zero, and no further: a cell
that is resolved is of order p + 1 with it, as its undershoot is. All other cells and
fields keep their polynomials. Where damping changes what leaves, the cells were too
long: they are halved.

Source: Zhang, Shu 2010, J. Comput. Phys. 229, 3091-3120, doi:10.1016/j.jcp.2009.12.030,
    for steps in time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contbed.arrays import Array
from contbed.errors import ConvergenceError
from contbed.reacting_bed import solve
from contbed.reacting_bed.cells import MOST_CELLS, moved
from contbed.reacting_bed.least_amounts import along, carried, lowest
from contbed.reacting_bed.problem import Problem

# of the share by which a polynomial has to become flat, the damping to begin with
FIRST = 0.4
LEAST, MOST = 1.1, 10.0  # growth from one trial to the next
ENOUGH = 1.05  # of what two trials suggest
# of it, from which on a mean below zero is not the polynomial's but that of rates
FLAT = 1e2
TRIALS = 16  # of dampings on one mesh
# of what leaves by damping, over the tolerance, to which estimates keep by such a
# factor
LARGE_CHANGE = 3.0
HALVINGS = 2  # of cells that are damped, before the damping is accepted


def damped(problem: Problem, u: Array, report: solve.Report) -> tuple[Problem, Array]:
    """Return the problem whose amounts are damped where they fall below zero, and its
    state.

    What is left below zero is what Newton's method leaves, or comes from rates that
    consume an absent species, or lies in a bed where no damped state is found.
    """
    low, before = lowest(problem, u), np.zeros(u.shape[:2])
    speeds, damping = carried(problem)[:, None], np.zeros(u.shape[:2])
    trial, state = problem, u
    for _ in range(TRIALS):
        mean = along(trial, state) @ problem.line.weights
        wrong = (low < -problem.scene.solver.newton_tolerance) & (speeds > 0.0)
        wrong &= (damping < FLAT * speeds) | (mean > 0.0)
        try:
            if wrong.any():
                damping = np.where(
                    wrong, next_damping(damping, low, before, mean, speeds), damping
                )
                before = low
                trial = replace(problem, damping=damping)
                du, step_length, _ = solve.newton_step(trial, state, report)
                state = state + step_length * du
            elif trial is problem:
                break
            else:
                problem = trial
                u = state = solve.newton(
                    trial, state, report, max_iterations=solve.FEW_ITERATIONS
                )
        except ConvergenceError:
            break
        low = lowest(problem, state)
    return problem, u


def next_damping(
    damping: Array, low: Array, before: Array, mean: Array, speeds: Array
) -> Array:
    """Return the next damping (m, N): by linear extrapolation of the last two trials,
    at first as a limiter.

    That of Zhang and Shu makes a polynomial flat by the share low/mean.
    """
    with np.errstate(all="ignore"):
        growth = 1.0 + ENOUGH * low / (before - low)
        first = np.where(mean > 0.0, FIRST * -low / mean, 1.0)
    growth = np.clip(np.where(before < low, growth, MOST), LEAST, MOST)
    found: Array = np.where(
        damping > 0.0, growth * damping, np.minimum(first, 1.0) * speeds
    )
    return found


def without_negative_amounts(
    problem: Problem, u: Array, report: solve.Report
) -> tuple[Problem, Array]:
    """Return a steady state without amounts below zero, where cells may be chosen on
    halves of those that need it.

    The report says in how many cells amounts are damped, and by how much that changes
    what leaves.
    """
    leaving, tolerance = solve.what_leaves(problem, u), problem.scene.solver.tolerance
    for halving in range(HALVINGS + 1):
        problem, u = damped(problem, u, report)
        if problem.damping is None:
            break
        cells = problem.damping.any(axis=0)
        report.damped = int(cells.sum())
        report.damping_changes = float(
            np.abs(solve.what_leaves(problem, u) - leaving).max()
        )
        chosen = (
            problem.scene.mesh.cells is None
            and problem.line.cells + report.damped <= MOST_CELLS
        )
        if (
            not chosen
            or halving == HALVINGS
            or report.damping_changes <= LARGE_CHANGE * tolerance
        ):
            break
        vertices = np.sort(
            np.append(problem.line.vertices, problem.line.points.mean(axis=1)[cells])
        )
        finer = problem.on(vertices)
        try:
            found = solve.newton(
                finer,
                moved(problem, u, finer),
                report,
                max_iterations=solve.FEW_ITERATIONS,
            )
        except ConvergenceError:
            break
        problem, u, leaving = finer, found, solve.what_leaves(finer, found)
    return problem, u
