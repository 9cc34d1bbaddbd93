"""Run of a reacting bed: a steady state, states followed over a value of the scene,
or steps in time.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contbed.errors import ConvergenceError
from contbed.reacting_bed import results, solve, steady_positivity
from contbed.reacting_bed.feeds import with_cells_of_one_value
from contbed.reacting_bed.plan import Plan
from contbed.reacting_bed.problem import Problem, isothermal_drop
from contbed.reacting_bed.rate_checks import taken_though_absent
from contbed.reacting_bed.section_error import report_section
from contbed.result import Result

# share of a gas or solid above which a warning says what was rounded
LARGE_SMOOTHING = 1e-5
# temperature [K] by which initial.temperature exceeds all of a state that is not the one
# meant
GONE_OUT = 300.0
RESTART_MAY_CHANGE = (
    "time.end",
    "time.times",
    "time.checkpoint_every",
    "time.cycle.tolerance",
    "output",
)


def run(
    plan: Plan,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    """Solve and fill the result.

    Parameters
    ----------
    folder : where checkpoints go; None for none
    start : arrays and numbers of a checkpoint to resume from

    Raises
    ------
    ConvergenceError : no state is found; the last one is kept, the message names where
        it fails
    """
    if plan.scene.time is not None:
        _in_time(plan, result, folder, quiet, start)
        return
    report = solve.Report()
    problem = plan.problem
    with result.timed("bed"):
        try:
            problem, u = whole = solve.steady(problem, report)
            problem, u = steady_positivity.without_negative_amounts(problem, u, report)
        except ConvergenceError as error:
            raise ConvergenceError(
                _sentence(problem, error), report.history, error.state
            ) from None
    result.history += report.history
    result.adaptations = report.rounds
    smoothed = (
        solve.smoothing_changes(problem, u, report)
        if report.small > LARGE_SMOOTHING
        else 0.0
    )
    across = report_section(problem, u, result)
    if report.rounds:
        result.qoi["estimated_error"] = max(
            report.estimate, report.damping_changes, smoothed, across
        )
    if report.stopped:
        result.warnings.append(
            "no solution was found on the last, finer mesh; results are "
            "those of the mesh before, with the errors in `estimated_error`"
        )
    if smoothed > plan.scene.solver.tolerance:
        result.warnings.append(
            "powers of what is left of a gas or solid are straight lines below "
            f"{report.small:g} of the whole, as "
            "sharper ones give no state on these cells; this changes what leaves by "
            f"{smoothed:.2g} of what enters. A "
            "solver.tolerance that differs, or mesh.cells, gives other cells"
        )
    tolerance = plan.scene.solver.tolerance
    if report.damping_changes > steady_positivity.LARGE_CHANGE * tolerance:
        result.warnings.append(
            f"amounts are damped in {report.damped} cells where they would be "
            "negative, which changes what leaves by "
            f"{report.damping_changes:.2g} of what enters: use more mesh.cells"
        )
    if (gone_out := _gone_out(problem, u)) is not None:
        result.warnings.append(gone_out)
    if report.marched:
        result.warnings.append("the first cells took steps in time to the steady state")
    with result.timed("results"):
        results.fill(problem, u, result)
    result.solved = problem, u
    if (sentence := taken_though_absent(problem, u)) is not None:
        raise ConvergenceError(
            f"{sentence}; such a state is impossible, so that the solution is "
            "not used: add mesh.cells, or change the order of this reaction",
            report.history,
            u,
        )
    result.qoi |= {"cells": problem.line.cells, "cells_damped": report.damped}
    if plan.scene.continuation is not None:
        from contbed.reacting_bed.branch import follow

        with result.timed("continuation"):
            follow(*whole, result)


def _gone_out(problem: Problem, u: Any) -> str | None:
    """Return a warning on a state that is far colder than the temperature from which it
    was sought; None if it is not.
    """
    T = problem.scene.initial.temperature
    if T is None or not problem.layout.temperatures:
        return None
    hottest = max(
        float(u[k].max())
        for k, each in enumerate(problem.unknowns)
        if each.is_temperature
    )
    if T - hottest < GONE_OUT:
        return None
    place = problem.scene.origin.at(("initial", "temperature"))
    return (
        f"{place}: initial.temperature = {T:g} K, from which the state is sought, is far "
        f"above this state, which has {hottest:.4g} K at most: if reactions have gone out, "
        "the bed may burn in another steady state; a run with [time] from this "
        "temperature reaches that state if the bed keeps burning"
    )


def _in_time(
    plan: Plan,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    """Take steps in time, in cells of one value where polynomials turn out to follow
    fronts that are shorter than a cell in far too many steps.
    """
    from contbed.reacting_bed.course import Course
    from contbed.reacting_bed.transient_run import ShortFrontsError, run_transient

    def run_with(problem: Problem, start: tuple[Any, Any] | None) -> None:
        course = Course.of(plan.scene, problem, plan.schedule, plan.stores_gas)
        run_transient(course, result, folder, quiet, start)

    problem = plan.problem
    # cycles, which never begin again, have no array of this name
    if start is not None and "state" in start[0] and start[0]["state"].shape[-1] == 1:
        problem = with_cells_of_one_value(problem)
    try:
        run_with(problem, start)
    except ShortFrontsError as error:
        cell = 1e3 * float(problem.line.h.max())
        sizes = ", ".join(
            f"{1e3 * table.diameter:.3g} mm" for table in plan.scene.solids.values()
        )
        result.warnings.append(
            f"fronts are shorter than a cell: after {error} by polynomials the run began "
            "again with one value a cell, as by solver.degree = 0, which spreads fronts "
            "over several cells, their root if nothing sharpens them, as axial "
            f"dispersion by particles of {cell:.3g} mm would (a Peclet number of 2; "
            f"those of the bed have {sizes}): give closures.dispersion and "
            "closures.dispersion_mass for the spread that beds have, more mesh.cells "
            "for sharper fronts, or solver.degree = 1, which keeps polynomials and "
            "takes many more steps"
        )
        run_with(with_cells_of_one_value(problem), None)


def _sentence(problem: Problem, error: ConvergenceError) -> str:
    """Return what failed, and what to try."""
    origin = problem.scene.origin.name
    drop = isothermal_drop(problem)
    if problem.layout.pressure and drop is None:
        return (
            f"{problem.scene.origin.at(('boundary',))}: boundary: the gas cannot pass "
            "the bed: by "
            "closures.permeability and closures.forchheimer its pressure of "
            f"{problem.streams.pressure:.4g} Pa is used "
            "up before the other end; lower the flow or mesh.length, or raise "
            "gas.pressure or the diameter of [solids]"
        )
    surface = any(table.surface for table in problem.scene.reactions.values())
    jumps = (
        ". Coverages of a surface that have two steady states, such as those of CO and O "
        "on platinum, make rates jump, and no state is found across a jump"
    )
    return (
        f"{origin}: no steady state is found: {error}. Give initial.temperature near "
        "the state that is meant, slow the "
        "fastest reaction by its factor, or add closures.dispersion or "
        f"closures.dispersion_mass where a front is steep{jumps if surface else ''}"
    )
