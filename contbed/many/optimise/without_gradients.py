"""Search of a design without gradients: results that scatter, or
`method = "surrogate"`; see `surrogate`.

Every point is run `repeats` times, with seeds one higher each time, and its values are
the means. The scatter of all points together gives the standard error of a mean, the
same for all points. A scene without seeds is run once at a point, and its scatter is
fitted.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contbed.arrays import Array
from contbed.fields import behind
from contbed.many.optimise.evaluations import Evaluation, Evaluations, OutOfRuns
from contbed.many.optimise.found import (
    INFEASIBLE,
    NOT_CONVERGED,
    SETTLED,
    Found,
    infeasible,
    not_converged,
)
from contbed.many.optimise.surrogate import (
    Known,
    Surrogate,
    best_known,
    first_points,
    propose,
)
from contbed.models import model_of

FIRST = 4  # points before the first fit, for each key
# improvement, of the range of the objective, below which nothing is promised
PROMISE = 1e-3
OF_ERROR = 0.1  # the same, of the standard error of a value
# probability of all constraints below which no feasible point is expected
UNLIKELY = 1e-3
PATIENCE = 3  # proposals in turn that promise nothing, after which a search ends
CLEAR = 2.0  # standard errors by which a constraint must hold not to count as active


def search(evaluations: Evaluations) -> Found:
    """Return the best point that is found without gradients;
    `surrogate.require_sklearn` comes before it.
    """
    design = evaluations.design
    steps = [1.0 / key.span if key.whole else 0.0 for key in design.keys]
    verdict, out_of_runs = "", False
    try:
        for z in first_points(FIRST * len(design.keys), steps):
            evaluations.at(design.low + z * (design.high - design.low))
        verdict = _improve(evaluations, steps)
    except OutOfRuns:
        out_of_runs = True
        verdict = (
            f"all {design.runs} points are computed; raise runs and give the "
            "same command to resume"
        )
    return _found(evaluations, verdict, out_of_runs)


def _improve(evaluations: Evaluations, steps: list[float]) -> str:
    """Compute what the surrogate proposes until it promises nothing; return why it
    ended.
    """
    design, idle = evaluations.design, 0
    while True:
        known = known_of(evaluations)
        surrogate = Surrogate(known)
        proposal = propose(known, surrogate, steps, len(evaluations.found))
        least = _least(known, surrogate)
        nothing = proposal.promise < (least if proposal.feasible else UNLIKELY)
        idle = idle + 1 if nothing else 0
        evaluations.at(design.low + proposal.z * (design.high - design.low))
        if idle >= PATIENCE:
            unit = behind(design.objective.unit)
            if not proposal.feasible:
                return (
                    "no point is expected to hold all constraints (probability "
                    f"below {UNLIKELY:g})"
                )
            return f"no point promises an improvement above {least:.2g}{unit}"


def _least(known: Known, surrogate: Surrogate) -> float:
    """Return the improvement of the objective that is worth a run."""
    values = known.values[np.isfinite(known.values).all(axis=1), 0]
    return float(max(PROMISE * np.ptp(values), OF_ERROR * surrogate.errors[0]))


def known_of(evaluations: Evaluations) -> Known:
    """Return all points that were computed, scaled, with the variance of their
    means.
    """
    design, rows = evaluations.design, evaluations.rows
    points = np.array([row.point for row in rows])
    failed = np.full(1 + len(design.constraints), np.nan)
    values = np.array(
        [failed if row.functions is None else row.functions for row in rows]
    )
    return Known(
        (points - design.low) / (design.high - design.low),
        values,
        variance_of_means(rows, len(failed)),
    )


def variance_of_means(rows: tuple[Evaluation, ...], functions: int) -> Array:
    """Return the variance of the mean of repeats, pooled over all points
    (functions,); nan where they are alike.
    """
    repeated = [row for row in rows if row.functions is not None and len(row.each) > 1]
    if not repeated:
        return np.full(functions, np.nan)
    squares = sum(
        ((row.each - row.each.mean(axis=0)) ** 2).sum(axis=0) for row in repeated
    )
    freedom = sum(len(row.each) - 1 for row in repeated)
    found: Array = (
        np.asarray(squares) / freedom / max(len(row.each) for row in repeated)
    )
    found[found == 0.0] = np.nan  # seeds that change nothing
    return found


def _found(evaluations: Evaluations, verdict: str, out_of_runs: bool) -> Found:
    """Return the best point by the surrogate, with the errors of its predicted
    values.
    """
    design = evaluations.design
    known, found = known_of(evaluations), not_converged(evaluations, verdict)
    if np.isfinite(known.values).all(axis=1).sum() < 2:
        return found
    surrogate = Surrogate(known)
    best_row, feasible = best_known(known, surrogate)
    best, z = evaluations.rows[best_row], known.z[best_row : best_row + 1]
    mean, error = (one[0] for one in surrogate.predict(z))
    unit = behind(design.objective.unit)
    reason = ", as results scatter" if model_of(design.scene).scatters else ""
    there = (
        f"{design.objective.text} there {design.sign * mean[0]:.5g}{unit} +- "
        f"{error[0]:.2g}{unit}"
    )
    how = f"by Gaussian processes{reason}: {there}"
    if not feasible:
        status, why = INFEASIBLE, f"{infeasible(design, best)}; {verdict}"
    else:
        status = NOT_CONVERGED if out_of_runs else SETTLED
        why = (
            f"{verdict}; {how}; without gradients, so that prices of constraints are "
            "not known"
        )
    active = np.abs(mean[1:]) <= np.maximum(
        CLEAR * error[1:], PROMISE * surrogate.size[1:]
    )
    expected = np.array([design.sign * mean[0], *mean[1:]])
    return replace(
        found,
        status=status,
        why=why,
        evaluation=best,
        active=active,
        errors=np.array(error),
        expected=expected,
    )
