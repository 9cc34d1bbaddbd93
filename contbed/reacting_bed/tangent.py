"""Linear response of a steady reacting bed to small changes of its scene: the discrete
tangent.

    R(u, p) = 0:   du = -A^-1 (R(u, p + h) - R(u, p - h))/2,   A = dR/du

Results at u +- du and p +- h have a central difference with an error of O(h^2). The
cells stay in number, and their ends move with the length of the bed.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

from contbed.course.schedule import Schedule
from contbed.errors import UnlikeError
from contbed.fem.line_blocks import Factors
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.results import fill
from contbed.reacting_bed.scene import ReactingScene
from contbed.result import Result
from contbed.solvers.tangent import Tangent as SteadyTangent

OTHER = "a small change adds or removes a species, a reaction or a pressure"


class Tangent(SteadyTangent):
    """A solved steady bed and the factors of its Jacobian."""

    problem: Problem

    def __init__(self, result: Result):
        self.problem, self.u = result.solved
        self.plan = result.plan

    @cached_property
    def solver(self) -> Factors:
        """The factors, found when they are first needed."""
        slopes = self.problem.system.assemble(self.u)[1]
        found: Factors = slopes.factors(self.problem.flux_sizes, self.problem.sizes)
        return found

    def results(
        self, below: ReactingScene, above: ReactingScene
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the named results of two scenes with a key a little below and above
        that of the solved one.

        Raises
        ------
        UnlikeError : the change adds or removes an unknown
        """
        problems = [self._problem(scene) for scene in (below, above)]
        low, high = (problem.system.assemble(self.u, False)[0] for problem in problems)
        step = -self.solver.solve(0.5 * (high - low))
        out = []
        for problem, side in zip(problems, (-1.0, 1.0), strict=True):
            result = Result(self.plan)
            fill(problem, self.u + side * step, result)
            out.append(result.qoi)
        return out[0], out[1]

    def _problem(self, scene: ReactingScene) -> Problem:
        base = self.problem
        frozen = Schedule.of(scene.boundary, scene.origin.base).frozen(scene, 0.0)
        if base.layout.pressure != (frozen.packed_bed.pressure_drop == "ergun"):
            drop = "ergun" if base.layout.pressure else "none"
            frozen = frozen.with_table("packed_bed", pressure_drop=drop)
        ratio = scene.mesh.length / base.scene.mesh.length
        # data of the species take longer to read than the equations to make
        before, now = ((of.gas, of.solids) for of in (base.scene, frozen))
        same = before == now
        made = Problem.of(
            frozen, base.line.vertices * ratio, base.species if same else None
        )
        made = made.with_strength(base.bed.strength).with_small(base.bed.small)
        if made.layout != base.layout or len(made.reactions) != len(base.reactions):
            raise UnlikeError(OTHER)
        return replace(made, damping=base.damping)


def of(result: Result) -> Tangent:
    """Return the tangent of a run that has solved a steady state."""
    return Tangent(result)
