"""One step in time of a reacting bed, d/dt C(u) + R(u, t) = 0 with the content C and
fluxes less sources R.

Two stages of an L-stable diagonally implicit method of order 2 with
gamma = 1 - 1/sqrt(2), written for C, so that what is stored is exactly what has passed:

    C(U1) = C_n - gamma dt R(U1, t + gamma dt),
    C(u) = C_n - (1 - gamma) dt R(U1, t + gamma dt) - gamma dt R(u, t + dt)

Both have the same matrix C'/(gamma dt) + R' but for the change of the state: it is
computed and factorised for a state near that of the first stage, and again only where
this costs less than the corrections that it saves. The error of a step is the
difference to a method of order 1, filtered by the first matrix of the step: whether
another is needed may hang on rounding, and the steps then as well.

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
CORRECTIONS = 20  # at most
# that cost as much as a matrix, its factors and the one that follows it
DEAR = 7
FIRST_RATE = 0.2  # of corrections, until there are two
# of the terms of a residual, below which no other matrix makes it smaller
ROUNDINGS = 1e3
# of typical sizes, below which what is left of an error does not open balances, where
# so many roundings of the terms of a residual are left of it as well: steep isotherms
# hold much more after a small change (test_a_steep_isotherm)
ROUNDING, LEFT = 1e-14, 10.0


def stages(
    problems: tuple[Problem, Problem],
    u: Array,
    guess: Array,
    dt: float,
    report: solve.Report,
    sizes: Array,
    ended: Flags | None = None,
    near: Array | None = None,
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
    near : where the first stage is sought first; None: at `guess`

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
    first, matrix, factors = _solved(start, guess, report, one, near)
    slope = (one.content(first, False)[0] - before) / (GAMMA * dt)
    target = before + (1.0 - GAMMA) * dt * slope
    end = (
        problems[1]
        if ended is None
        else _limited(problems[1], target, GAMMA * dt, ended)
    )
    two = Storage(end, target, GAMMA * dt, loose=False)
    ahead = beyond(end, first, (1.0 - GAMMA) / GAMMA * (first - u))
    last, _, _ = _solved(end, first, report, two, ahead, factors)
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


def beyond(problem: Problem, u: Array, step: Array) -> Array:
    """Return a state on the line through those so far, a `step` further, as far as
    amounts stay positive.
    """
    found: Array = u + solve.damping_factor(problem, u, step) * step
    return found


def _linear(problem: Problem, u: Array, storage: Storage) -> tuple[Array, Any]:
    """Return the residual of a state and the factors of its matrix."""
    residual, slopes = problem.system.assemble(u)
    residual = storage.add(u, residual, slopes)
    return residual, slopes.factors(problem.flux_sizes, problem.sizes)


def _solved(
    problem: Problem,
    guess: Array,
    report: solve.Report,
    storage: Storage,
    near: Array | None = None,
    factors: Any = None,
) -> tuple[Array, Any, Any]:
    """Return the solution of a stage, and the first and the last matrix; one that is
    given is used as long as it serves.

    It is sought from a state `near` it, and where that fails from the guess.
    """
    with np.errstate(all="ignore"):
        for begin in (guess,) if near is None else (near, guess):
            found = _corrected(problem, begin, report, storage, factors)
            if found is not None:
                return found
            factors = None
        u = _by_newton(problem, guess, report, storage)
        _, factors = _linear(problem, u, storage)
        return u, factors, factors


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
) -> tuple[Array, Any, Any] | None:
    """Return the solution by corrections, and the first and the last matrix, None
    where they do not become small; the matrix is computed anew where that is cheaper.
    """
    scale, first = problem.sizes[:, None, None], factors
    before = np.inf
    for _ in range(CORRECTIONS):
        if factors is None:
            residual, factors = _linear(problem, u, storage)
            first = first or factors
        else:
            residual = problem.system.assemble(u, False)[0] + storage.residual(u)
        report.history.append(solve.scaled_residual_norm(problem, residual))
        du = factors.solve(-residual)
        change = float(np.abs(du / scale).max())
        # of a matrix of which nothing is known yet: it may be far from the solution
        rate = change / before if np.isfinite(before) else FIRST_RATE
        slow = np.isfinite(before) and not change * rate**DEAR < ROUNDING
        rounding = storage.rounding()
        if slow and np.all(np.abs(residual) < ROUNDINGS * rounding):
            return u, first, factors
        if not rate < 1.0 or solve.damping_factor(problem, u, du) < 1.0:
            return None
        u, before = u + du, change
        left = rate * np.abs(residual)
        if change * rate < ROUNDING and np.all(left < LEFT * rounding):
            return u, first, factors
        if slow:
            factors, before = None, np.inf
    return None
