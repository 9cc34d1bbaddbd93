"""Flow beside no-slip walls with the density and viscosity of the local temperature, in
steady state and over time.

A fluid passes a bed in far less time than the bed warms up, so that the flow is that of
a steady state at each moment: div(rho u) = 0 with the temperatures of that moment, and
the mass flow is the prescribed one at any time. In steady state flow and temperatures
are solved in turn. Over time the flow is solved at the start and again after each step
by which density or viscosity have changed by more than `CHANGE`; in between it stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contbed.errors import ConvergenceError
from contbed.fem.probe import Line
from contbed.packed_bed.flow import LocalProperties, solved_flow
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.run_parts import heat_problem, report_flow
from contbed.result import Result

TURNS = 40  # of flow and temperatures, each with the other's last solution
SETTLED = 0.1  # share of solver.tolerance by which theta may still change in a turn
# Change of density or viscosity, mean over the nodes, from which the flow is solved
# anew: theta of a bed of 900 K that nitrogen of 300 K cools is then wrong by 2e-3 at
# most and 2e-4 in the mean, in proportion to this number.
CHANGE = 0.02
# change of density or viscosity that is warned of: theta is wrong by a tenth of it
LAGS = 0.1


def local_properties(plan: Plan, problem: Any, state: Any) -> LocalProperties:
    """Return the properties of the fluid at the temperatures of a state."""
    T, fluid = problem.system.part(state, "T_fluid"), plan.medium.fluid
    expansion = plan.medium.mass_flux_scale() / fluid.density(T)
    viscosity = fluid.viscosity(T)
    space = problem.system.fields["T_fluid"][0]
    return LocalProperties(
        space, *(np.broadcast_to(values, T.shape) for values in (expansion, viscosity))
    )


def settled(
    plan: Plan, line: Line, problem: Any, state: Any, result: Result
) -> tuple[Any, Any]:
    """Solve flow and temperatures in turn until both belong to each other; return
    problem and state.

    Raises
    ------
    ConvergenceError : they do not settle
    """
    allowed, change = SETTLED * plan.scene.solver.tolerance, np.inf
    for _ in range(TURNS):
        with result.timed("flow"):
            flow = solved_flow(
                plan,
                problem.flow,
                result,
                local_properties(plan, problem, state),
            )
        problem = heat_problem(plan, flow, result)
        with result.timed("heat"):
            found, history = problem.solve(plan.policy, state)
            result.history += history
        change = float(
            np.abs(problem.weights * (found - state)).max() / problem.span_of(found)
        )
        state = found
        if change <= allowed:
            report_flow(plan, line, flow, result)
            return problem, state
    raise ConvergenceError(
        f"flow and temperatures did not converge: after {TURNS} iterations "
        f"theta still changes by {change:.1g}; an expanding fluid may have no "
        "steady flow here: try a smaller temperature difference or a slip "
        "wall"
    )


@dataclass
class FlowOverTime:
    """The flow of a transient run, solved anew as the temperatures change.

    `solved` counts how often, `change` is the largest change of the properties from one
    to the next.
    """

    result: Result
    flow: Any
    solved: int = 0
    change: float = 0.0

    def outdated(self, plan: Plan, problem: Any, state: Any) -> bool:
        """Return whether the flow is to be solved anew at the temperatures of a
        state.
        """
        return _change(local_properties(plan, problem, state), self.flow.local) > CHANGE

    def solve(self, plan: Plan, problem: Any, state: Any) -> None:
        """Solve the flow at the temperatures of a state."""
        before, local = self.flow, local_properties(plan, problem, state)
        with self.result.timed("flow"):
            self.flow = solved_flow(plan, before, self.result, local, problem.share)
        if before.local is not None:
            self.change = max(self.change, _change(local, before.local))
            self.solved += 1

    def report(self, plan: Plan, line: Line) -> None:
        """Report the flow, how often it was solved anew, and by how much it changed
        from one time to the next.
        """
        report_flow(plan, line, self.flow, self.result)
        self.result.qoi |= {"flow_solutions": self.solved, "flow_change": self.change}
        if self.change > LAGS:
            self.result.warnings.append(
                f"density or viscosity of the fluid change by {self.change:.2g} in a "
                "step, with the flow from before "
                f"it: theta is wrong by up to about {0.1 * self.change:.1g}; lower "
                "time.tolerance or time.step"
            )

    def pack(self) -> dict[str, Any]:
        """Return the arrays of a checkpoint."""
        local = self.flow.local
        return {
            "flow_state": self.flow.state,
            "flow_expansion": np.asarray(local.expansion),
            "flow_viscosity": np.asarray(local.viscosity),
            "flow_counts": np.array([self.solved, self.change, self.flow.share]),
        }

    def restore(self, problem: Any, arrays: Mapping[str, Any]) -> None:
        """Take the flow of a checkpoint, solved in the system of this one."""
        space = problem.system.fields["T_fluid"][0]
        local = LocalProperties(
            space, arrays["flow_expansion"], arrays["flow_viscosity"]
        )
        solved, self.change, share = (float(one) for one in arrays["flow_counts"])
        self.solved = int(solved)
        self.flow = replace(
            self.flow, state=arrays["flow_state"], local=local, share=share
        )


def _change(new: LocalProperties, old: LocalProperties) -> float:
    """Return the mean relative change of density or viscosity, whichever is larger."""
    pairs = ((new.expansion, old.expansion), (new.viscosity, old.viscosity))
    return max(float(np.mean(np.abs(a / b - 1.0))) for a, b in pairs)
