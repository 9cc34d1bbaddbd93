"""How long a run will take whose cost no formula gives, from a trial of its beginning on this machine.

Time steps: the trial runs the scene itself for `BUDGET` seconds of processor time and reads what a step costs here. How
many steps are to come follows from the pace of its second half; in a packed bed, whose steps grow or shrink over the
whole run, from a run on a coarse mesh instead, as the steps follow the temperatures and hardly the mesh; in a reacting
bed from one with a larger error of a step, by the order of that error. Compiling, which the run finds done, does not
count. Searches for a steady state, that of reacting beds included: most end within `SEARCH_BUDGET`; the others tell
which share of their way they have gone by then. Steady planes and volumes whose meshes are chosen by their errors: the
first of these meshes tell the last one.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contbed import models
from contbed.compiled.cache import compile_clock
from contbed.models import FewerSteps, Plan
from contbed.output.progress import Progress
from contbed.result import Result

BUDGET = 2.0  # s of processor time of a trial, after its first step, which may compile
COUNT_BUDGET = 5.0  # s of processor time of the run that counts the steps
SEARCH_BUDGET = 5.0  # s of processor time of the trial of a search for a steady state
COARSE = 40  # cells along the bed of the run that counts the steps; across it a quarter
OUTPUT = 0.5  # s of processor time for pictures and fields
BRANCH = "; the branch over [continuation] comes on top"
FEWEST = 3  # steps from which a pace is read


class _Enough(Exception):
    """The trial has seen what it needs."""


@dataclass
class Trial:
    """Times that a trial reached [s], and the processor time from its start to each [s].

    `ended` tells a run that came to its end before the budget was spent.
    """

    reached: list[float] = field(default_factory=list)
    spent: list[float] = field(default_factory=list)
    ended: bool = False

    @property
    def middle(self) -> int:
        """Number of the step after half of the processor time since the first one."""
        return int(np.searchsorted(self.spent, 0.5 * (self.spent[0] + self.spent[-1])))

    def cost_of_a_step(self) -> float:
        """Return the processor time of a step in the second half [s]."""
        first = min(self.middle, len(self.spent) - 2)
        return (self.spent[-1] - self.spent[first]) / (len(self.spent) - 1 - first)

    def steps_to(self, end: float) -> float:
        """Return the number of steps to a time [s], by the size of those in the second half."""
        first = min(self.middle, len(self.reached) - 2)
        size = (self.reached[-1] - self.reached[first]) / (len(self.reached) - 1 - first)
        return len(self.reached) + max(end - self.reached[-1], 0.0) / size


def predicted_time(plan: Plan, before: float = 0.0) -> str:
    """Return a line with the processor time of a run whose cost no formula gives; empty for others, or if it fails.

    `before` is what a run takes as well to come this far: of a command the processor time since it began [s].
    """
    if getattr(plan, "searches", models.model_of(plan.scene).searches):
        return _text_of_search(plan, before)
    if getattr(plan, "balanced", False):
        return _text_of_last_mesh(plan, before)
    if (known := getattr(plan, "seconds", None)) is not None:
        seconds = known()
        return "" if seconds is None else f"time: about {_text(before + seconds + OUTPUT)} of processor"
    # fronts and one particle take steps that no checkpoint goes on from
    if not plan.steps and getattr(plan.scene, "time", None) is None:
        return ""
    seconds, steps = _predict(plan, plan.scene.time.end)
    if not steps:
        return ""
    return f"time: about {_text(before + seconds + OUTPUT)} of processor for some {steps:.2g} steps, by a trial"


def _text_of_search(plan: Plan, before: float = 0.0) -> str:
    seconds, ended = _searched(plan)
    if not seconds:
        return ""
    branch = getattr(plan.scene, "continuation", None) is not None and not ended
    how = "by a trial" if ended else f"by the first {SEARCH_BUDGET:g} s of a trial"
    return f"time: about {_text(before + seconds + OUTPUT)} of processor, {how}{BRANCH if branch else ''}"


def _text_of_last_mesh(plan: Plan, before: float) -> str:
    found = models.model_of(plan.scene).find("last_mesh", "last_mesh")(plan)
    if found is None:
        return ""
    seconds, how = before + found.seconds + OUTPUT, "by a trial" if found.ended else "by a trial of the first ones"
    return f"time: about {_text(seconds)} of processor, {found.cells} cells in the last mesh, {how}"


def _searched(plan: Plan) -> tuple[float, bool]:
    """Return the processor time of a search [s], zero if it fails, and whether the trial came to its end."""
    start, guess, last, guesses = clock.process_time(), 0, 0.0, getattr(plan, "guesses", 1)
    seconds = 0.0

    def watch(progress: Progress, value: float) -> None:
        nonlocal guess, last, seconds
        guess, last = guess + (value < last), value
        spent, share = clock.process_time() - start, (min(guess, guesses - 1) + value / progress.total) / guesses
        if spent >= SEARCH_BUDGET and share > 0.0:
            seconds = spent / share
            raise _Enough

    run = models.solver_of(plan.scene)
    with Progress.watched(watch), suppress(Exception):  # a run that fails is told by the run
        run(plan, Result(plan), None, True, None)
        return clock.process_time() - start, True
    return seconds, False


def _predict(plan: Plan, end: float) -> tuple[float, float]:
    """Return the processor time of the run itself [s] and its number of steps; zeros where no steps can be made."""
    before = 0.0
    if (to_try := getattr(plan, "to_try", None)) is not None:
        plan, before = to_try()
    fine = _tried(plan, BUDGET)
    if len(fine.spent) < FEWEST:
        return 0.0, 0.0
    if fine.ended:
        return before + fine.spent[-1], len(fine.spent)
    steps = fine.steps_to(end)
    if (fewer := _with_fewer_steps(plan)) is not None:
        counted = _tried(fewer.plan, COUNT_BUDGET)
        if len(counted.spent) >= FEWEST:
            steps = fewer.steps(len(counted.spent) if counted.ended else counted.steps_to(end))
    steps = max(steps, len(fine.spent))
    return before + fine.spent[0] + fine.cost_of_a_step() * steps, steps


def _tried(plan: Plan, budget: float) -> Trial:
    """Run the scene until the budget [s] is spent, without writing anything."""
    trial, start = Trial(), clock.process_time()
    base, last = 0.0, 0.0
    owner: Any = None

    def watch(progress: Progress, value: float) -> None:
        nonlocal base, last, owner
        if progress is not owner:  # a physics may have a bar for each piece of its run
            base, owner = base + last, progress
        last = value
        trial.reached.append(base + value)
        trial.spent.append(clock.process_time() - start - compiling())
        if trial.spent[-1] - trial.spent[0] >= budget and len(trial.spent) >= FEWEST:
            raise _Enough

    run = models.solver_of(plan.scene)
    clocked = compile_clock() if models.model_of(plan.scene).compiles else nullcontext(lambda: 0.0)
    with clocked as compiling, Progress.watched(watch), suppress(Exception):  # a run that fails is told by the run
        run(plan, Result(plan), None, True, None)
        trial.ended = True
    return trial


def _with_fewer_steps(plan: Plan) -> FewerSteps | None:
    """Return a run of the same scene that is done sooner, where the physics has one that tells the number of steps."""
    fewer: Callable[[int], FewerSteps | None] | None = getattr(plan, "with_fewer_steps", None)
    with suppress(Exception):
        return None if fewer is None else fewer(COARSE)
    return None


def _text(seconds: float) -> str:
    if seconds >= 3600.0:
        return f"{seconds / 3600.0:.2g} h"
    return f"{seconds / 60.0:.2g} min" if seconds >= 99.5 else f"{seconds:.2g} s"
