"""Linear response of a fully developed flow to small changes of its scene; see
`solvers.tangent`.

The nodes of the mesh, those at kinks of the drag included, move with the radius only.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from contbed.developed_flow.plan import coefficients
from contbed.developed_flow.problem import DevelopedProblem
from contbed.developed_flow.results import fill
from contbed.developed_flow.scene import DevelopedScene
from contbed.errors import UnlikeError
from contbed.result import Result
from contbed.solvers.tangent import Tangent as SteadyTangent

OTHER = "a small change adds or removes the particles"


class Tangent(SteadyTangent):
    """A solved flow and the factors of its Jacobian."""

    problem: DevelopedProblem

    def __init__(self, result: Result):
        self.problem, self.x = result.solved

    def results(
        self, below: DevelopedScene, above: DevelopedScene
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the named results of two scenes with a key a little below and above
        that of the solved one.

        Raises
        ------
        UnlikeError : the change adds or removes the particles
        """
        problems = [self._problem(scene) for scene in (below, above)]
        sides = [problem.steady for problem in problems]
        states, _ = self.response.states((self.x, self.x), sides)
        out = []
        for problem, state in zip(problems, states, strict=True):
            result = Result(problem.plan)
            fill(problem, state, result)
            out.append(result.qoi)
        return out[0], out[1]

    def _problem(self, scene: DevelopedScene) -> DevelopedProblem:
        plan = self.problem.plan
        c = coefficients(scene)
        if (c.solid_flux > 0) != self.problem.particles:
            raise UnlikeError(OTHER)
        ratio = scene.developed_flow.radius / plan.scene.developed_flow.radius
        changed = replace(plan, scene=scene, coefficients=c)
        if ratio != 1.0:
            return DevelopedProblem(changed.on(ratio * np.sort(plan.mesh.skfem.p[0])))
        other = copy(self.problem)
        other.plan, other.c = changed, c
        return other


def of(result: Result) -> Tangent:
    """Return the tangent of a run that has solved a steady state."""
    return Tangent(result)
