"""Run of a bubbling bed: steady state, height and sizes that settle with it,
branches, other steady states.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contbed.bubbling_bed.burning import explained, is_out
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.bubbling_bed.results import fill
from contbed.errors import ConvergenceError
from contbed.result import Result, timed
from contbed.solvers.branch import Branch

# temperatures from which other steady states are looked for [K]
COLD, HOT = 400.0, 2000.0
APART = 1.0  # difference of temperatures of two steady states [K]


@dataclass(frozen=True)
class Solved:
    """What a run has solved, and the branch that was followed from there.

    The scene of the `problem` has the sizes and the height that have settled.
    """

    problem: BubblingProblem
    state: Any
    branch: Branch | None = None


@timed("heat")
def run(
    plan: Any, result: Result, folder: Path | None, quiet: bool, start: Any
) -> None:
    """Solve and fill the result; a steady run cannot resume, so `folder` and `start`
    are ignored.
    """
    from contbed.output.progress import Progress

    with Progress(100.0, "% of the way", quiet) as progress:
        problem = BubblingProblem(plan)
        problem.watch = lambda share, note: progress.advance_to(100.0 * share, note)
        _solve(problem, result)


def _solve(problem: BubblingProblem, result: Result) -> None:
    plan = problem.plan
    state, history = problem.solve()
    result.history += history
    if plan.scene.computed:
        from contbed.bubbling_bed.settling import settle, unsettled

        if unsettled(plan.scene):
            problem, state = settle(problem, state, result)
            plan = result.plan = problem.plan
    if problem.unrecorded:
        result.warnings.append(
            "Jacobians are computed by dual numbers, some five times slower than "
            "recorded forms: " + problem.unrecorded
        )
    if is_out(problem, state):
        result.warnings.append(f"the fuel does not burn: {explained(problem)}")
    fill(plan, problem, state, result)
    branch = None
    if plan.scene.continuation is not None:
        from contbed.bubbling_bed.branch import follow

        branch = follow(problem, state, result)
    result.solved = Solved(problem, state, branch)
    if plan.guesses > 1:
        result.qoi["steady_states_found"] = _steady_states(problem, state, result)


def _steady_states(problem: BubblingProblem, state: Any, result: Result) -> int:
    """Count the steady states, including those found from a cold and a hot guess.

    Heat release that grows with temperature allows several.
    """
    found = [state]
    for guess in (COLD, HOT):
        try:
            other, _ = problem.solve(guess)
        except ConvergenceError:
            result.warnings.append(
                f"no steady state was found from a uniform {guess:g} K"
            )
            continue
        if all(_distance(problem, other, known) > APART for known in found):
            here, there = (
                np.mean(
                    [
                        problem.system.part(each, f"T_{name}")
                        for name in problem.c.species
                    ]
                )
                for each in (state, other)
            )
            result.warnings.append(
                f"this is the {'ignited' if here > there else 'extinguished'} one of "
                "several steady states: its "
                f"particles are at {here:.6g} K on average, those of another at "
                f"{there:.6g} K; initial.temperature = "
                f"{guess:g} leads there"
            )
            found.append(other)
    return len(found)


def _distance(problem: BubblingProblem, a: Any, b: Any) -> float:
    """Return the largest difference of a temperature [K]."""
    names = problem.c.streams
    return max(
        float(np.abs(problem.system.part(a, name) - problem.system.part(b, name)).max())
        for name in names
    )
