"""Cyclic steady state: the state that one period of a run gives back, found directly
instead of by many periods.

With y the state at the start of a period and Phi(y) that at its end, Phi(y) = y is
solved by Anderson's acceleration (`solvers.anderson`). Plain repetition takes hundreds
of periods where a period is short, as in regenerators. After a few periods the sequence
of time steps is kept, so that Phi is smooth.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contbed.errors import ConvergenceError
from contbed.packed_bed.transient import History, enter, steps_of
from contbed.solvers.anderson import Anderson
from contbed.solvers.linear import Policy

ADAPTIVE = 4  # periods whose steps are chosen anew; later ones repeat those of the last
MOST = 60  # periods after which the run gives up


@dataclass
class Cycle:
    """A periodic state.

    state : at the start of a period; periods : how many were computed; residual :
        largest change over one [K]
    levels : sizes of the time steps of each part of the period
    """

    state: Any
    periods: int
    residual: float
    levels: dict[int, list[int]] = field(default_factory=dict)


def find_cycle(
    problems: Sequence[Any],
    state: Any,
    policy: Policy,
    tolerance: float,
    keep: Callable[[Any], None],
) -> Cycle:
    """Find the periodic state from a first guess.

    Parameters
    ----------
    problems : of the parts of a period, each with its interval
    tolerance : largest change over one period, over the span of temperatures
    keep : is called with the state from which each further period begins, and the state
        that is found

    Raises
    ------
    ConvergenceError : no state comes back within `tolerance` after `MOST` periods
    """
    low, high = problems[0].T_span
    found = Cycle(state, 0, np.inf)
    accelerate = Anderson()
    best = np.inf
    for count in range(1, MOST + 1):
        after = _period(problems, found, policy, fresh=count <= ADAPTIVE)
        change = (after - found.state) * problems[0].weights
        found.residual, found.periods = float(np.abs(change).max()), count
        best = min(best, found.residual)
        # the steps of the last periods belong to the state that is reported
        closed = found.residual <= tolerance * (high - low) and count > 1
        found.state = found.state if closed else accelerate(found.state, after)
        keep(found.state)
        if closed:
            return found
    raise ConvergenceError(
        f"cycle: after {MOST} periods the bed still changes by {best:.3g} K over one, "
        "allowed are "
        f"{tolerance * (high - low):.3g} K; raise time.cycle.tolerance"
    )


def _period(problems: Sequence[Any], cycle: Cycle, policy: Policy, fresh: bool) -> Any:
    """Return the state after one period; keep the sizes of the steps where they are
    chosen `fresh`.
    """
    history = History(cycle.state)
    for k, problem in enumerate(problems):
        interval = problem.interval
        enter(
            problem, history, policy, None if interval.jumps or k == 0 else history.size
        )
        levels = None if fresh else cycle.levels[k]
        taken = []
        for step in steps_of(problem, history, policy, interval.end, levels):
            history.state, history.time = step.states[-1], step.end
            history.tick, history.level = step.tick + 2**step.level, step.next_level
            taken.append(step.level)
        cycle.levels[k] = taken
    return history.state
