"""Steps of a bare problem, for tests of the method alone."""

from typing import Any

import numpy as np

from contbed.course.dirk import DirkSteps, ladder, stages_of
from contbed.course.history import History
from contbed.solvers.linear import Policy
from contbed.solvers.newton import Options


class Bare(DirkSteps[History]):
    """Steps of one problem to an end [s], of one size or by their errors."""

    def __init__(
        self,
        problem: Any,
        policy: Policy,
        end: float,
        tolerance: float = 1.0,
        span: float = 1.0,
        step: float | None = None,
    ):
        self.problem, self.policy, self.end = problem, policy, end
        self.tolerance, self.span = tolerance, span
        self.control = ladder(1e-6 * end, step)

    def entered(self, history: History, stop: float) -> History:
        """The history; states count from zero."""
        zero = np.zeros_like(history.state)
        self.stages = stages_of(self.problem, self.policy, Options(), zero)
        return history

    def stops(self) -> list[float]:
        """The end."""
        return [self.end]


def last(problem: Any, state: Any, policy: Policy, end: float, **options: Any) -> Any:
    """State at the end."""
    steps = Bare(problem, policy, end, **options)
    *_, history = steps.march(History(state=state, size=steps.control.first))
    return history.state
