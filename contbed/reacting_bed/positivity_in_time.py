"""Positivity-preserving time steps; for steady states see `steady_positivity`.

Two things take an amount below zero, and a step that does so is taken again with
bounds:

    in space    Polynomials of gases, and of solids that move, are damped in their cells as in steady states,
                C_e(u) - C_e(u_upwind) = h ( S_e(u) - dc_e/dt ) where damping is strong. It is measured by what is
                carried, and by what a stage stores, c h/(gamma dt). What damps a gas in the pores displaces the
                others, see `equations.bed`.
    in time     Solids at rest know nothing of each other: at nodes that would fall below zero reactions take in
                neither stage more than there is, n/((1 - gamma) dt) and what is left/(gamma dt),
                see `equations.consumption_limit`. Where a solid is used up reactions
                begin the next step ended: else the gas would react there again for a moment.

Neither takes anything from a balance, and where no amount falls below zero a step is
that without bounds to the last bit. A step for which no bounds are found is made
shorter, and taken as it is if that does not help.

Damping stays for the next step. Of solids that move its share of what makes a
polynomial flat does, which falls as steps grow: else the damping of the first, short
steps makes cells flat. Where there is room it falls by and by: a jump of it is one of
the gas that follows at once. Damping of a gas in the pores falls at a rate, and where
it is small no faster than that of others in one step: else it comes and goes for ever.
The error of a step is that before damping grows, or with the damping that it needs
where this is less: what damping changes is not of time, and does not become smaller
with the step.
In damped cells errors are those of the means. They are not less than the square of what
a step without bounds takes of solids at rest beyond their amount: of order 2 as the
estimate is.

Source: Zhang, Shu 2010, J. Comput. Phys. 229, 3091-3120, doi:10.1016/j.jcp.2009.12.030.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.errors import ConvergenceError
from contbed.reacting_bed import solve
from contbed.reacting_bed.least_amounts import along, at_rest, carried, lowest
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.stages import GAMMA, stages
from contbed.reacting_bed.steady_positivity import (
    ENOUGH,
    FIRST,
    FLAT,
    LEAST,
    MOST,
    next_damping,
)

Array = NDArray[np.float64]
Problems = tuple[Problem, Problem]
TRIALS = 12  # of a step, in each of which dampings grow by up to a factor of ten
ROOM = 0.05  # of the mean of a cell, least amounts above which its damping falls
FALL = 0.9  # from one step to the next: jumps of the damping are errors of a step
# rate at which damping of a gas in the pores falls at most, times the time that the gas
# stays in the cell: without a rate the first, short steps end it
FALL_RATE = 10.0
# of the damping that makes a polynomial flat, in long steps of a gas in the pores, below
# which there is none
NONE = 1e-4


class Bounded(NamedTuple):
    """A step in time.

    problems, states : the bed at its stages, and their states
    damping : of the next step
    limited : whether reactions take all there is of a solid
    within : whether no amount is below zero
    """

    problems: Problems
    states: tuple[Array, Array]
    error: float
    damping: Array
    limited: bool
    within: bool

    @property
    def cells(self) -> NDArray[np.bool_]:
        """Which cells are damped (N,)."""
        damping = self.problems[1].damping
        return (
            np.zeros(self.problems[1].line.cells, dtype=bool)
            if damping is None
            else (damping > 0.0).max(axis=0)
        )


class _Look(NamedTuple):
    """Least values and means in cells of both stages over sizes (m, N), and the
    least at nodes (m, N, p + 1).
    """

    low: Array
    mean: Array
    nodes: Array

    @classmethod
    def at(cls, problems: Problems, states: tuple[Array, Array]) -> _Look:
        """Look at the states of both stages."""
        pairs = list(zip(problems, states, strict=True))
        values = [along(problem, u) for problem, u in pairs]
        low = np.minimum(*(lowest(problem, u) for problem, u in pairs))
        return cls(
            low,
            np.minimum(*(v @ problems[0].line.weights for v in values)),
            np.minimum(*values),
        )


def bounded(
    problems: Problems,
    u: Array,
    guess: Array,
    dt: float,
    report: solve.Report,
    sizes: Array,
    damping: Array,
    near: Array | None = None,
    kept: bool = False,
    used_up: bool = False,
) -> Bounded:
    """Return a step from a state, begun with a damping (m, N), and where solids at rest
    are `used_up` with ended reactions; for others see `stages`.

    A step whose error is larger than `time.tolerance`, and that damping will not make
    smaller, is returned at once, but where its length is `kept`.

    Raises
    ------
    ConvergenceError : the step without bounds is not found
    """
    scene = problems[1].scene
    assert scene.time is not None
    below, flat = -scene.solver.newton_tolerance, flattening(problems[1], dt)
    rest, least = at_rest(problems[1])[:, None, None], 0.0
    trial = _damped(problems, damping)
    ended = np.zeros(u.shape, dtype=bool)
    if used_up:
        ended |= rest & (along(trial[1], u) < -below)
    empty = bool(ended.any())
    first, last, error = stages(
        trial, u, guess, dt, report, sizes, ended if empty else None, near
    )
    look = _Look.at(trial, (first, last))
    if rest.any():
        beyond = np.minimum(along(trial[1], u), 0.0) - look.nodes
        least = float(np.where(rest, beyond, 0.0).max()) ** 2
    start = Bounded(trial, (first, last), max(error, least), damping, empty, False)
    stored = problems[1].bed.gas_pressure is not None
    falls = stored and bool(((look.low < below) & (flat > 0.0)).any())
    if not kept and (least if falls else start.error) > scene.time.tolerance:
        return start
    take = partial(stages, u=u, guess=guess, dt=dt, report=report, sizes=sizes)
    within = partial(_within, problems, take, start, ended, look, dt, least)
    found, chosen = within(True)
    if chosen and not found.within:
        other, _ = within(False)
        return other if other.within else found
    return found


def _within(
    problems: Problems,
    take: Callable[..., tuple[Array, Array, float]],
    found: Bounded,
    ended: NDArray[np.bool_],
    look: _Look,
    dt: float,
    least: float,
    solids_first: bool,
) -> tuple[Bounded, bool]:
    """Return the step with bounds, or the last one tried, and whether another order
    would have tried other ones.

    A solid below zero makes the gas that it reacts with, and a gas below zero takes the
    solid that it makes: which of both comes first is tried where the other way does not
    help. `take` takes the step of dt [s] with a damping and `ended` reactions, `least`
    is the least error.
    """
    flat = flattening(problems[1], dt)
    below = -problems[1].scene.solver.newton_tolerance
    rest = at_rest(problems[1])[:, None, None]
    stored = problems[1].bed.gas_pressure is not None
    damping, without = found.damping, found.error
    before = np.zeros_like(damping)
    chosen = False
    for _ in range(TRIALS):
        wrong = (look.low < below) & (flat > 0.0)
        empty = rest & (look.nodes < below)
        if not (wrong.any() or empty.any()):
            return found._replace(
                damping=_later(problems[1], damping, look, flat, dt), within=True
            ), chosen
        wrong &= (damping < FLAT * flat) | (look.mean > 0.0)
        both = bool((empty & ~ended).any() and wrong.any())
        chosen = chosen or both
        if (empty & ~ended).any() and (solids_first or not both):
            ended = ended | empty
        elif wrong.any():
            damping = np.where(wrong, _grown(damping, look, before, flat), damping)
            before = np.where(wrong, look.low, 0.0)
        else:
            break
        trial = _damped(problems, damping)
        try:
            first, last, again = take(trial, ended=ended if ended.any() else None)
        except ConvergenceError:
            break
        error = min(again, without) if stored else without
        found = Bounded(
            trial, (first, last), max(error, least), damping, bool(ended.any()), False
        )
        look = _Look.at(trial, found.states)
    return found, chosen


def flattening(problem: Problem, dt: float) -> Array:
    """Return the damping that makes polynomials of a step flat (m, N): what is
    carried, and stored of it in a stage.
    """
    speeds, stored = carried(problem)[:, None], problem.bed.gas_pressure is not None
    of_gas = problem.gas_residence / problem.scene.mesh.length if stored else 0.0
    held = np.where(problem.is_gas, of_gas, 1.0)[:, None]
    found: Array = np.where(
        speeds > 0.0, speeds + held * problem.line.h / (GAMMA * dt), 0.0
    )
    return found


def of_next(problem: Problem, damping: Array, step: float, following: float) -> Array:
    """Return the damping with which a longer step [s] begins: of solids, the share
    of what makes polynomials flat.
    """
    if not damping.any():
        return damping
    with np.errstate(all="ignore"):
        share = flattening(problem, following) / flattening(problem, step)
    found: Array = (
        np.where(~problem.is_gas[:, None] & (share < 1.0), share, 1.0) * damping
    )
    return found


def _needed(damping: Array, look: _Look, flat: Array) -> Array:
    """Return the damping by which the least is zero, if deviations of the mean fall
    as 1/(1 + d/(FIRST flat)).
    """
    with np.errstate(all="ignore"):
        free = (look.mean - look.low) * (1.0 + damping / (FIRST * flat))
        found: Array = FIRST * flat * (free / look.mean - 1.0)
    return found


def _grown(damping: Array, look: _Look, before: Array, flat: Array) -> Array:
    """Return a larger damping: by a straight line through two trials, or what is
    needed by one.
    """
    with np.errstate(all="ignore"):
        largest = np.maximum(flat, MOST * damping)
        by_one = np.clip(
            ENOUGH * _needed(damping, look, flat), LEAST * damping, largest
        )
        by_one = np.where(look.mean > 0.0, by_one, largest)
    return np.where(
        before < 0.0, next_damping(damping, look.low, before, look.mean, flat), by_one
    )


def _later(
    problem: Problem, damping: Array, look: _Look, flat: Array, dt: float
) -> Array:
    """Return the damping after a step of dt [s], with which the next one begins."""
    if not damping.any():
        return damping
    stored = problem.is_gas[:, None] & (problem.bed.gas_pressure is not None)
    stays = problem.gas_residence / problem.scene.mesh.length * problem.line.h
    # large damping, that of a front, falls faster: what it leaves to fall is small
    rate = FALL_RATE * (1.0 + FALL_RATE * damping)
    fall = np.maximum(
        np.where(stored, 1.0 / (1.0 + rate * dt / stays), FALL), FALL / (1.0 + damping)
    )
    least = problem.scene.solver.newton_tolerance
    room = (look.low > ROOM * look.mean) | (look.mean < least)
    found = np.where(room, fall * damping, damping)
    # of a gas in the pores also after a step that is cut short
    return np.where(found < NONE * np.where(stored, 1.0, flat), 0.0, found)


def _damped(problems: Problems, damping: Array) -> Problems:
    """Return the bed at both stages with damping."""
    if not damping.any():
        return problems
    return replace(problems[0], damping=damping), replace(problems[1], damping=damping)
