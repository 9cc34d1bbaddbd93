"""Run of a stand-alone radiating medium: solution, heat through the boundaries,
balance, profiles.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.balance import HELD_SHARE, Balance
from contbed.fem.probe import Line, Probe, line_along
from contbed.fields import distinct
from contbed.radiation.plan import Plan
from contbed.radiation.problem import RadiationProblem, emission
from contbed.radiation.results import fill
from contbed.result import Result

if TYPE_CHECKING:
    from contbed.radiation.ordinates import OrdinatesProblem

# share of its scale that a balance may be open by as a rule, solver.balance_tolerance
TOLERANCE = 1e-10
# points along the medium at which solutions with different ordinates are compared
SAMPLES = 41
SMALL_FLUX = 1e-6  # share of G
FAR = 0.02  # share of the heat from which the error of P1 and two-flux is said


@dataclass(frozen=True)
class Solved:
    """What a run has solved by P1, two-flux or Rosseland."""

    line: Line
    problem: Any
    state: Any


def run(
    plan: Plan,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    """Solve and fill the result; a steady solution keeps no checkpoint and needs no
    folder.
    """
    with result.timed("radiation"):
        plan, problem, state, error = _with_enough_ordinates(plan, result)
        result.plan = plan
    line = line_along(plan.mesh, plan.scene.output.positions, plan.scene.output.across)
    result.warnings += [line.note] if line.note else []
    if error is not None:
        _report_angles(plan, error, result)
    if plan.solved.radiation.level != "ordinates":
        result.solved = Solved(line, problem, state)
    fluxes, conducted = (
        problem.fluxes(state),
        problem.conducted(problem.assemble(state, False)[0]),
    )
    held = HELD_SHARE * emission(problem.optics, problem.surfaces, plan.mesh, 1.0)
    rounding = problem.rounding(state) / TOLERANCE
    result.balances["energy"] = Balance.of_fluxes(
        [*fluxes.values(), *conducted.values()],
        "W",
        problem.released(state),
        floor=max(held, rounding),
    ).as_dict()
    fill(plan, line, problem, state, fluxes, conducted, result)
    if (reference := plan.by_ordinates()) is not None:
        with result.timed("ordinates"):
            _compare(plan, fluxes, reference, result)


def _with_enough_ordinates(
    plan: Plan, result: Result
) -> tuple[Plan, RadiationProblem | OrdinatesProblem, Any, float | None]:
    """Return the plan that was solved, its problem and state, and the estimated error
    by the number of ordinates; None where their number is given.
    """
    problem, state = _solved(plan, result)
    error = None
    while (finer := plan.with_more_ordinates()) is not None and not (
        error is not None and error <= plan.scene.solver.tolerance
    ):
        before, of_before, plan = problem, state, finer
        problem, state = _solved(plan, result)
        error = _angular_error(before, of_before, problem, state)
    return plan, problem, state, error


def _compare(
    plan: Plan, fluxes: dict[str, float], reference: Plan, result: Result
) -> None:
    """Fill in the error of P1 or two-flux by its directions: the difference of the
    heats at the boundaries from those by ordinates, over the largest.
    """
    _, problem, state, _ = _with_enough_ordinates(reference, Result(reference))
    exact = problem.fluxes(state)
    scale = max(map(abs, exact.values()), default=0.0)
    if scale <= SMALL_FLUX * float(np.abs(problem.incident(state)).max()):
        return
    name = max(exact, key=lambda each: abs(fluxes[each] - exact[each]))
    error = (fluxes[name] - exact[name]) / scale
    result.qoi["estimated_error_angles"] = abs(error)
    if abs(error) > FAR:
        table = plan.scene.radiation
        result.warnings.append(
            f"{plan.scene.origin.at(('radiation', 'level'))}: radiation.level = "
            f'"{table.level}": the heat through boundary.{name} is off by '
            f"{100.0 * abs(error):.2g} % of the largest, by ordinates: use level = "
            '"ordinates"'
        )


def _solved(
    plan: Plan, result: Result
) -> tuple[RadiationProblem | OrdinatesProblem, Any]:
    problem = problem_of(plan)
    state, history = problem.solve(plan.policy)
    result.history += history
    return problem, state


def _angular_error(coarse: Any, of_coarse: Any, fine: Any, of_fine: Any) -> float:
    """Estimate the error of the finer of two solutions in G and in the flux, each over
    its largest value.

    Twice the ordinates leave a quarter of the error or less, so it is a third of the
    difference at most. A flux that is zero but for round-off is compared with
    `SMALL_FLUX` of G.
    """
    low, high = fine.mesh.skfem.p[0].min(), fine.mesh.skfem.p[0].max()
    positions = np.linspace(low, high, SAMPLES)[None, :]
    found = []
    for problem, state in ((coarse, of_coarse), (fine, of_fine)):
        probe = Probe(problem.mesh, positions)
        found.append(
            (probe(problem.space, problem.incident(state)), problem.flux(state, probe))
        )
    (G_coarse, q_coarse), (G, q) = found
    largest = np.abs(G).max()
    scale = max(np.abs(q).max(), SMALL_FLUX * largest)
    return (
        float(
            max(
                np.abs(G - G_coarse).max() / largest, np.abs(q - q_coarse).max() / scale
            )
        )
        / 3.0
    )


def _report_angles(plan: Plan, error: float, result: Result) -> None:
    ordinates, tolerance = plan.solved.radiation.ordinates, plan.scene.solver.tolerance
    result.qoi |= {"ordinates": ordinates, "estimated_error_angles": error}
    if error > tolerance:
        left, asked = distinct(error, tolerance)
        result.warnings.append(
            f"{ordinates} ordinates in each hemisphere leave an estimated error of "
            f"{left} of G and flux, "
            f"solver.tolerance asks for {asked}; no more are tried: thin media "
            "emit along grazing directions"
        )


def problem_of(plan: Plan) -> RadiationProblem | OrdinatesProblem:
    """Return the problem of the level of the radiation."""
    level = plan.solved.radiation.level
    if level == "ordinates":
        from contbed.radiation.ordinates import OrdinatesProblem

        return OrdinatesProblem(plan.solved, plan.mesh)
    if level == "rosseland":
        from contbed.radiation.rosseland import RosselandProblem

        return RosselandProblem(plan.solved, plan.mesh)
    return RadiationProblem(plan.solved, plan.mesh)
