"""Run of a medium that radiates by itself: solution, heat through the boundaries, balance, profiles."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from contbed.balance import HELD_SHARE, Balance
from contbed.fem.probe import line_along
from contbed.radiation.plan import Plan
from contbed.radiation.problem import RadiationProblem, emission
from contbed.radiation.results import fill
from contbed.result import Result

if TYPE_CHECKING:
    from contbed.radiation.ordinates import OrdinatesProblem

TOLERANCE = 1e-10  # share of its scale that a balance may be open by as a rule, solver.balance_tolerance


def run(plan: Plan, result: Result, folder: Path | None, quiet: bool, start: tuple[Any, Any] | None) -> None:
    """Solve and fill the result; a steady solution keeps no checkpoint and needs no folder."""
    line = line_along(plan.mesh, plan.scene.output.positions, plan.scene.output.across)
    result.warnings += [line.note] if line.note else []
    with result.timed("radiation"):
        problem = _problem(plan)
        state, history = problem.solve(plan.policy)
        result.history += history
    fluxes, conducted = problem.fluxes(state), problem.conducted(problem.assemble(state, False)[0])
    held = HELD_SHARE * emission(problem.optics, problem.surfaces, plan.mesh, 1.0)
    rounding = problem.rounding(state) / TOLERANCE
    result.balances["energy"] = Balance.of_fluxes(
        [*fluxes.values(), *conducted.values()], "W", problem.released(state), floor=max(held, rounding)
    ).as_dict()
    fill(plan, line, problem, state, fluxes, conducted, result)


def _problem(plan: Plan) -> RadiationProblem | OrdinatesProblem:
    level = plan.solved.radiation.level
    if level == "ordinates":
        from contbed.radiation.ordinates import OrdinatesProblem

        return OrdinatesProblem(plan.solved, plan.mesh)
    if level == "rosseland":
        from contbed.radiation.rosseland import RosselandProblem

        return RosselandProblem(plan.solved, plan.mesh)
    return RadiationProblem(plan.solved, plan.mesh)
