"""Linear response of a solved steady bed to small changes of its scene: the discrete
tangent.

Central differences of the results at both ends of a small step have an error of O(h^2),
with one solution for each key by factors that are found once; see `solvers.tangent`.
Mesh topology, elements and quadrature stay as they are; nodes move with the lengths of
the bed. The flow comes first, then the temperatures in the changed flow; where the
fluid expands, both in turn until they agree.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.errors import ConvergenceError, UnlikeError
from contbed.fem.probe import Line, line_along
from contbed.packed_bed import scene as s
from contbed.packed_bed.flow import (
    Flow,
    FlowEquations,
    LocalProperties,
    equations_of,
    solved_flow,
)
from contbed.packed_bed.heat import HeatProblem
from contbed.packed_bed.local_flow import local_properties
from contbed.packed_bed.results import steady_findings
from contbed.packed_bed.run import steady_balance
from contbed.packed_bed.run_parts import overshoot, report_flow
from contbed.packed_bed.time_steps import HeatSteps
from contbed.packed_bed.transient_run import Run
from contbed.result import Result
from contbed.solvers.anderson import Anderson
from contbed.solvers.tangent import STEP, Response, with_prescribed

TURNS = 40  # of flow and temperatures, each with the other's last change
SETTLED = 1e-7  # relative change of the temperatures' response in a turn
ROUNDING = 1e-13  # relative change of the temperatures that counts as none
OTHER = "a small change adds or removes a stream or a condition"


class Repeated:
    """A transient run that is repeated on its mesh with its time steps, at both ends of
    a small step of a key.

    Both runs have the same discretisation, so that their difference is as smooth as the
    equations; what Newton's method leaves of them allows larger steps than the tangent.
    """

    step = 1e-4  # relative: Newton's method leaves 1e-10 of the temperatures
    method = "differences"

    def __init__(self, result: Result):
        self.plan: Any = result.plan
        self.flow = result.solved.flow
        self.shares = result.solved.shares
        self.flows = result.solved.flows

    def results(
        self, below: s.Scene, above: s.Scene
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the named results of two scenes with a key a little below and above
        that of the solved one.
        """
        return self._results(below), self._results(above)

    def _results(self, scene: s.Scene) -> dict[str, Any]:
        plan = self.plan.with_values(scene)
        found, flow = Result(plan), None
        line = line_along(plan.mesh, scene.output.positions, scene.output.across)
        if not plan.plug:
            flow = solved_flow(
                plan, self.flow if plan.mesh is self.plan.mesh else None, found
            )
            report_flow(plan, line, flow, found)
        steps, sizes, before = HeatSteps(plan, flow, found, self.flows), [], 0.0
        for stop, shares in zip(steps.stops(), self.shares, strict=False):
            sizes += [share * (stop - before) for share in shares]
            before = stop
        Run(steps, line, steps.begin()).follow(True, None, sizes)
        return found.qoi


class _End:
    """The discrete problem at a changed value of a key: plan, line of profiles, and
    what is found of its solution.
    """

    def __init__(self, base: Steady, scene: s.Scene):
        self.plan = base.plan.with_values(scene)
        same_mesh = self.plan.mesh is base.plan.mesh
        output = scene.output
        self.line = (
            base.line
            if same_mesh
            else line_along(self.plan.mesh, output.positions, output.across)
        )
        self.flow: Flow | None = base.flow
        self.local: LocalProperties | None = None
        self.problem: Any = None
        self.state: Any = base.state
        self.residual: Any = None  # of the steady heat balances, linear in the response
        # numbering and quadrature are those of the solved bed unless its nodes have
        # moved
        self.flow_system = (
            base.flow.system if base.flow is not None and same_mesh else None
        )
        same_measure = same_mesh and self.plan.section == base.plan.section
        self.heat_system = (
            base.problem.system if base.problem is not None and same_measure else None
        )

    def equations(self) -> FlowEquations:
        """Return the equations of the flow, with properties at the temperatures
        where these matter.
        """
        plan = self.plan
        if self.flow is not None and self.flow.local is not None:
            self.local = local_properties(plan, self.problem, self.state)
        made = equations_of(plan, self.local, self.flow_system)
        self.flow_system = made.system
        return made

    def heat(self) -> None:
        """Make the problem of the temperatures in the flow as it is now."""
        self.problem = HeatProblem(self.plan, self.flow, system=self.heat_system)
        self.heat_system = self.problem.system

    def results(self) -> dict[str, Any]:
        """Return the named results."""
        result = Result(self.plan)
        if self.flow is not None:
            report_flow(self.plan, self.line, self.flow, result)
        if self.problem is not None:
            fluxes, conducted, _ = steady_balance(
                self.problem, self.state, self.residual
            )
            steady_findings(
                self.plan,
                self.line,
                self.problem,
                self.state,
                fluxes,
                conducted,
                result,
            )
            beyond = overshoot(self.plan, self.problem, [self.state])
            if beyond is not None:
                result.qoi["theta_overshoot"] = beyond
        return result.qoi


class Steady:
    """A solved steady bed, whose matrices are factored when they are first needed."""

    step = STEP
    method = "tangent"

    def __init__(self, result: Result):
        self.plan: Any = result.plan
        self.line: Line = result.solved.line
        self.problem = result.solved.problem
        self.state = result.solved.state
        self.flow = result.solved.flow
        self._flow: Response | None = None
        self._heat: Response | None = None

    def results(
        self, below: s.Scene, above: s.Scene
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the named results of two scenes with a key a little below and above
        that of the solved one.

        Raises
        ------
        UnlikeError : the change adds or removes an unknown or a condition
        ConvergenceError : flow and temperatures do not settle
        """
        ends = [_End(self, scene) for scene in (below, above)]
        if self.flow is not None and self.flow.local is not None:
            for end in ends:
                end.heat()
            self._coupled(ends)
        else:
            if self.flow is not None:
                self._move_flow(ends)
            if self.problem is not None:
                self._move_heat(ends)
        return ends[0].results(), ends[1].results()

    def _coupled(self, ends: list[_End]) -> None:
        """Find the responses of flow and temperatures to each other, in turn.

        The turns are a linear iteration, accelerated by Anderson's method.
        """
        accelerate = Anderson()
        for _ in range(TURNS):
            before = np.concatenate([end.state for end in ends])
            self._move_flow(ends)
            self._move_heat(ends)
            after = np.concatenate([end.state for end in ends])
            response = np.abs(ends[1].state - self.state).max()
            if np.abs(after - before).max() <= max(
                SETTLED * response, ROUNDING * np.abs(after).max()
            ):
                return
            ends[0].state, ends[1].state = np.split(accelerate(before, after), 2)
        raise ConvergenceError(
            "the derivatives of flow and temperatures with respect to a key "
            f"did not converge in {TURNS} iterations; use contbed sweep"
        )

    def _move_flow(self, ends: list[_End]) -> None:
        assert self.flow is not None
        equations = [end.equations() for end in ends]
        if any(
            not np.array_equal(one.fixed, equations[0].fixed) for one in equations[1:]
        ):
            raise UnlikeError(OTHER)
        if self._flow is None:
            middle = equations_of(self.plan, self.flow.local, self.flow.system)
            matrix = middle.residual(self.flow.state, True)[1]
            self._flow = Response(
                matrix, middle.fixed, self.flow.system.ordered(self.plan.policy)
            )
        starts = [one.with_given(self.flow.state) for one in equations]
        states, _ = self._flow.states(starts, [one.residual for one in equations])
        for end, one, state in zip(ends, equations, states, strict=True):
            porosity = end.plan.solved.packed_bed.porosity
            end.flow = Flow(one.system, state, porosity, end.local)

    def _move_heat(self, ends: list[_End]) -> None:
        for end in ends:
            end.heat()
            _require_alike(end.problem, self.problem)
        if self._heat is None:
            matrix = self.problem.steady(self.state, True)[1]
            policy = self.problem.system.ordered(self.plan.policy)
            self._heat = Response(matrix, self.problem.fixed, policy)
        starts = [
            with_prescribed(self.state, end.problem.fixed, end.problem.fixed_values)
            for end in ends
        ]
        sides = [end.problem.steady for end in ends]
        states, residuals = self._heat.states(starts, sides)
        for end, state, residual in zip(ends, states, residuals, strict=True):
            end.state, end.residual = state, residual


def _require_alike(problem: HeatProblem, base: HeatProblem) -> None:
    """Raise UnlikeError where unknowns, prescribed nodes or the kinds of conditions
    differ.
    """
    kinds = [
        [
            (name, wall.name, wall.mass_flux is None, wall.inflow is None, wall.crossed)
            for name, _, wall in one.boundary_terms
        ]
        for one in (problem, base)
    ]
    same = problem.system.size == base.system.size and np.array_equal(
        problem.fixed, base.fixed
    )
    if not same or kinds[0] != kinds[1]:
        raise UnlikeError(OTHER)


def of(result: Result) -> Steady | Repeated:
    """Return what follows a run to other numbers: the tangent of a steady one,
    repetitions of a transient.
    """
    return Steady(result) if result.solved.shares is None else Repeated(result)
