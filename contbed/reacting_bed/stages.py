"""One step in time of a reacting bed, d/dt C(u) + R(u, t) = 0 with the content C and
fluxes less sources R.

Two stages of an L-stable diagonally implicit method of order 2 with
gamma = 1 - 1/sqrt(2), written for C, so that what is stored is exactly what has passed:

    C(U1) = C_n - gamma dt R(U1, t + gamma dt),
    C(u) = C_n - (1 - gamma) dt R(U1, t + gamma dt) - gamma dt R(u, t + dt)

Both have the same matrix C'/(gamma dt) + R' but for the change of the state: it is
computed and factorised once for a step and again only where corrections do not fall
fast. The error of a step is the difference to a method of order 1, filtered by the
first matrix of the step: whether another is needed may hang on rounding, and the steps
then as well.

Source: Alexander 1977, SIAM J. Numer. Anal. 14, 1006-1021, doi:10.1137/0714068.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.arrays import Array, Flags
from contbed.chemistry.local import Smoothing
from contbed.errors import ConvergenceError
from contbed.reacting_bed import solve
from contbed.reacting_bed.least_amounts import carried
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.storage import Storage, content

GAMMA = 1.0 - 0.5**0.5
SLOWEST = 0.2  # factor by which a correction with an older matrix has to fall
CORRECTIONS = 12  # at most, with an older matrix
# of the terms of a residual, below which no other matrix makes it smaller
ROUNDINGS = 1e3
# of typical sizes, below which what is left of an error does not open balances
ROUNDING = 5e-16


def stages(
    problems: tuple[Problem, Problem],
    u: Array,
    guess: Array,
    dt: float,
    report: solve.Report,
    sizes: Array,
    ended: Flags | None = None,
) -> tuple[Array, Array, float]:
    """Return both stages of a step from a state, and the estimate of its local error
    over sizes.

    Parameters
    ----------
    problems : at the times of the stages
    u : state at the begin of the step (m, N, p + 1)
    guess : of the first stage
    dt : length of the step [s]
    sizes : (m,) of the unknowns, that the estimate refers to
    ended : (m, N, p + 1) solids at rest of which neither stage takes more than there
        is; None for none

    Raises
    ------
    ConvergenceError : a stage is not found
    """
    before = content(problems[0], u)
    start = (
        problems[0]
        if ended is None
        else _limited(problems[0], before, (1.0 - GAMMA) * dt, ended)
    )
    one = Storage(start, before, GAMMA * dt, loose=False)
    with np.errstate(all="ignore"):
        matrix = _matrix(start, guess, one)
    first, factors = _solved(start, guess, report, one, matrix)
    slope = (one.content(first, False)[0] - before) / (GAMMA * dt)
    target = before + (1.0 - GAMMA) * dt * slope
    end = (
        problems[1]
        if ended is None
        else _limited(problems[1], target, GAMMA * dt, ended)
    )
    two = Storage(end, target, GAMMA * dt, loose=False)
    # on the line through the states so far, as far as amounts stay positive
    ahead = (1.0 - GAMMA) / GAMMA * (first - u)
    near = first + solve.damping_factor(end, first, ahead) * ahead
    last, _ = _solved(end, first, report, two, factors, near)
    change = slope - (two.content(last, False)[0] - target) / (GAMMA * dt)
    line = problems[1].line
    difference = (0.5 - GAMMA) / GAMMA * change * line.weights * line.h[:, None]
    filtered = matrix.solve(difference) / sizes[:, None, None]
    if problems[1].damping is not None:
        means = (filtered @ line.weights)[:, :, None]
        moves = (carried(problems[1])[:, None] > 0.0) & (problems[1].damping > 0.0).any(
            axis=0
        )
        filtered = np.where(moves[:, :, None], means, filtered)
    return first, last, float(np.abs(filtered).max())


def _limited(problem: Problem, there: Array, dt: float, ended: Flags) -> Problem:
    """Return the problem that in a time takes no more of some solids at rest than is
    there.
    """
    return problem.with_most_lost(np.where(ended, np.maximum(there, 0.0) / dt, np.inf))


def _matrix(problem: Problem, u: Array, storage: Storage) -> Any:
    residual, slopes = problem.system.assemble(u)
    storage.add(u, residual, slopes)
    return slopes.factors(problem.flux_sizes, problem.sizes)


def _solved(
    problem: Problem,
    guess: Array,
    report: solve.Report,
    storage: Storage,
    factors: Any,
    near: Array | None = None,
) -> tuple[Array, Any]:
    """Return the solution of a stage, and the last matrix; that which is given is used
    as long as it serves.

    It is that of the guess, unless the first corrections begin at a state `near` the
    solution.
    """
    with np.errstate(all="ignore"):
        begin = guess if near is None else near
        found = _corrected(problem, begin, report, storage, factors)
        if found is None and near is not None:
            factors = _matrix(problem, guess, storage)
            found = _corrected(problem, guess, report, storage, factors)
        if found is None:
            found = _by_newton(problem, guess, report, storage)
            factors = _matrix(problem, found, storage)
        return found, factors


def _by_newton(
    problem: Problem, guess: Array, report: solve.Report, storage: Storage
) -> Array:
    """Return the solution of a stage by Newton's method, from one with smoother powers
    where that is of use.

    A gas that follows at once is not nearer to its solution in a shorter step, as one
    that is stored is.

    Raises
    ------
    ConvergenceError : it does not converge
    """
    try:
        return solve.newton(
            problem, guess, report, storage, max_iterations=solve.FIRST_ITERATIONS
        )
    except ConvergenceError:
        if problem.bed.gas_pressure is not None or not any(
            each.has_roots for each in problem.reactions
        ):
            raise
    own, share, factor = problem.bed.small, solve.SMOOTHEST, solve.SHARPER
    smooth = problem.with_small(Smoothing(max(share, own.solids), share))
    guess = solve.newton(
        smooth, guess, report, storage, max_iterations=solve.FIRST_ITERATIONS
    )
    while share > own.amounts:
        below = max(factor * share, own.amounts)
        trial = problem.with_small(Smoothing(max(below, own.solids), below))
        try:
            guess = solve.newton(
                trial, guess, report, storage, max_iterations=solve.FIRST_ITERATIONS
            )
            share = below
        except ConvergenceError:
            factor **= 0.5
            if factor > solve.LEAST_SHARPER:
                raise
    return guess


def _corrected(
    problem: Problem, u: Array, report: solve.Report, storage: Storage, factors: Any
) -> Array | None:
    """Return the solution by corrections with one matrix; None where they do not
    fall fast.
    """
    scale = problem.sizes[:, None, None]
    before = np.inf
    for _ in range(CORRECTIONS):
        residual = problem.system.assemble(u, False)[0] + storage.residual(u)
        report.history.append(solve.scaled_residual_norm(problem, residual))
        du = factors.solve(-residual)
        change = float(np.abs(du / scale).max())
        if not change < SLOWEST * before or solve.damping_factor(problem, u, du) < 1.0:
            rounded = np.all(np.abs(residual) < ROUNDINGS * storage.rounding())
            return u if change < ROUNDING or rounded else None
        u = u + du
        rate = change / before if np.isfinite(before) else SLOWEST
        if change * rate < ROUNDING:
            return u
        before = change
    return None
