"""Linear response of a solved bubbling bed to small changes of its scene: the discrete
tangent.

    R(u, s, p) = 0,   s = S(u, s, p):      du = -A^-1 (R(u, s+, p + h) - R(u, s-, p - h))/2,   A = dR/du

s are the sizes of the particles and the height of the bed, which follow from its state;
they and u change in turn until both agree, as in `settling`. The nodes of the mesh move
with the height of the bed, their number stays; see `solvers.tangent`. Folds of the
continuation move as `branch` says.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from contbed.bubbling_bed.branch import Family, Fold, distance
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.bubbling_bed.results import fill
from contbed.bubbling_bed.settling import CHANGE, ROUNDS, settled, stretched, unsettled
from contbed.errors import ConvergenceError, UnlikeError
from contbed.result import Result
from contbed.solvers.tangent import Tangent as SteadyTangent

Array = Any
# relative, of sizes and height: below it they change by rounding
ROUNDING = 1e-15
# of the change of sizes and height, below which one that does not fall to FALLS of the
# one before is rounding
ROUGH, FALLS = 1e-4, 0.5
OTHER = "a small change adds or removes an unknown"


class Tangent(SteadyTangent):
    """A solved steady bed and the factors of its Jacobian."""

    problem: BubblingProblem

    def __init__(self, result: Result):
        self.problem = result.solved.problem
        self.x = self.problem.unknowns(result.solved.state)
        self.typical = self.problem.typical()
        self.settles = unsettled(result.scene)
        self.branch = result.solved.branch

    @cached_property
    def folds(self) -> list[Fold]:
        """The folds of the branch that was followed, found when they are first
        needed.
        """
        if self.branch is None:
            return []
        table = self.problem.plan.scene.continuation
        assert table is not None
        family = Family(self.problem, table.parameter)
        return [Fold(family, self.x, p, x) for _, p, x in self.branch.folds]

    def results(self, below: Any, above: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the named results of two scenes with a key a little below and above
        that of the solved one.

        Raises
        ------
        UnlikeError : the change adds or removes an unknown
        ConvergenceError : sizes and height do not settle
        """
        scenes = [self._as_settled(scene) for scene in (below, above)]
        found = [Result(self.problem.plan) for _ in scenes]
        moved, change = 0.0, np.inf
        for _ in range(ROUNDS):
            problems = [self._problem(scene) for scene in scenes]
            states = self._states(problems)
            if not self.settles:
                break
            scenes = [
                settled(*each)[0] for each in zip(problems, states, found, strict=True)
            ]
            apart, before = _apart(scenes), change
            change, moved = abs(apart - moved), apart
            # rounding of a stiff bed, which does not fall any more
            rests = FALLS * before < change <= ROUGH * moved
            if rests or change <= max(CHANGE * moved, ROUNDING):
                break
        else:
            raise ConvergenceError(
                "the derivatives of particle sizes and bed height with "
                "respect to a key did not converge; use contbed sweep"
            )
        for result, problem, state in zip(found, problems, states, strict=True):
            result.plan = problem.plan
            fill(problem.plan, problem, state, result)
        if self.branch is not None:
            moved_folds = [fold.values(problems) for fold in self.folds]
            for side, (result, problem) in enumerate(zip(found, problems, strict=True)):
                places = [values[side] for values in moved_folds]
                result.qoi |= {f"fold_{k}": p for k, p in enumerate(places, 1)}
                result.qoi |= distance(problem.plan.scene, places, self.branch.complete)
        return found[0].qoi, found[1].qoi

    def _as_settled(self, scene: Any) -> Any:
        """Return a scene as written with the sizes and the height of the solved one."""
        if not self.settles:
            return scene
        solved: Any = self.problem.plan.scene
        solids = {
            name: item
            if item.sizes is None
            or item.sizes.feed is None
            or name not in solved.present
            else item.model_copy(
                update={
                    "diameter": solved.solids[name].diameter,
                    "sizes": item.sizes.model_copy(
                        update={"bed": solved.solids[name].sizes.bed}
                    ),
                }
            )
            for name, item in scene.solids.items()
        }
        bed = scene.bubbling_bed
        if bed.settled_height is not None:
            bed = bed.model_copy(update={"height": solved.bubbling_bed.height})
        return scene.model_copy(update={"solids": solids, "bubbling_bed": bed})

    def _problem(self, scene: Any) -> BubblingProblem:
        plan = self.problem.plan
        if scene.bubbling_bed.height == plan.scene.bubbling_bed.height:
            made = self.problem.with_scene(scene, self.typical)
        else:
            made = stretched(plan, scene, self.typical)
        if made.plan.fields != plan.fields:
            raise UnlikeError(OTHER)
        return made

    def _states(self, problems: list[BubblingProblem]) -> list[Array]:
        with np.errstate(all="ignore"):  # bubbles of no size, where the bed rests
            sides = [problem.steady for problem in problems]
            states, _ = self.response.states((self.x, self.x), sides)
        return [problem._state(x) for problem, x in zip(problems, states, strict=True)]


def _apart(scenes: list[Any]) -> float:
    """Return how far sizes and heights of two scenes are from each other, relative
    to their values.
    """
    low, high = scenes
    far = [abs(high.bubbling_bed.height / low.bubbling_bed.height - 1.0)]
    far += [
        abs(item.diameter / low.solids[name].diameter - 1.0)
        for name, item in high.present.items()
    ]
    return float(max(far))


def of(result: Result) -> Tangent:
    """Return the tangent of a run that has solved a steady state."""
    return Tangent(result)
