"""Linear response of a stand-alone radiating medium to small changes of its scene; see
`solvers.tangent`.

By P1, two-flux and Rosseland; discrete ordinates, whose number follows their errors,
take differences of runs.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from contbed.errors import UnlikeError
from contbed.fem.probe import line_along
from contbed.radiation.results import fill
from contbed.radiation.run import problem_of
from contbed.radiation.scene import RadiationScene
from contbed.result import Result
from contbed.solvers.tangent import Response, with_prescribed
from contbed.solvers.tangent import Tangent as SteadyTangent

OTHER = "a small change adds or removes a surface or a field"


class Tangent(SteadyTangent):
    """A solved medium and the factors of its Jacobian."""

    def __init__(self, result: Result):
        self.plan: Any = result.plan
        self.line, self.problem, self.x = (
            result.solved.line,
            result.solved.problem,
            result.solved.state,
        )

    @cached_property
    def response(self) -> Response:
        """The factors, found when they are first needed."""
        _, matrix = self.problem.assemble(self.x, True)
        return Response(
            matrix, self.problem.fixed, self.problem.system.ordered(self.plan.policy)
        )

    def results(
        self, below: RadiationScene, above: RadiationScene
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the named results of two scenes with a key a little below and above
        that of the solved one.

        Raises
        ------
        UnlikeError : the change adds or removes an unknown or a surface
        """
        plans = [self.plan.with_values(scene) for scene in (below, above)]
        problems: list[Any] = [problem_of(plan) for plan in plans]
        for problem in problems:
            same = np.array_equal(problem.fixed, self.problem.fixed) and len(
                problem.forms
            ) == len(self.problem.forms)
            if not same or problem.system.size != self.problem.system.size:
                raise UnlikeError(OTHER)
        starts = [
            with_prescribed(self.x, problem.fixed, problem.fixed_values)
            for problem in problems
        ]
        sides = [problem.assemble for problem in problems]
        states, residuals = self.response.states(starts, sides)
        out = []
        for plan, problem, state, residual in zip(
            plans, problems, states, residuals, strict=True
        ):
            output = plan.scene.output
            line = (
                self.line
                if plan.mesh is self.plan.mesh
                else line_along(plan.mesh, output.positions, output.across)
            )
            result = Result(plan)
            fill(
                plan,
                line,
                problem,
                state,
                problem.fluxes(state),
                problem.conducted(residual),
                result,
            )
            out.append(result.qoi)
        return out[0], out[1]


def of(result: Result) -> Tangent:
    """Return the tangent of a run that has solved a steady state."""
    return Tangent(result)
