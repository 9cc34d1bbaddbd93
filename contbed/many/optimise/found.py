"""What a search has found: the point, whether it is an optimum, and what each
constraint costs, in units.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from contbed.arrays import Array, Flags
from contbed.fields import behind
from contbed.many.optimise.constrained_search import FEASIBLE, FIRST_ORDER, Optimum
from contbed.many.optimise.evaluations import Evaluation, Evaluations, named_values
from contbed.many.optimise.expression import Expression
from contbed.many.optimise.problem import Constraint, Design

NOTHING = 1e-9  # of the objective, a change that is no more than rounding

OPTIMUM = "optimum"
SETTLED = "settled"
INFEASIBLE = "infeasible"
NOT_CONVERGED = "not converged"


@dataclass(frozen=True)
class Found:
    """The point that a search ended at.

    status : "optimum", "settled" for a search without gradients that expects nothing
        better, "infeasible" or "not converged"
    why : the verdict in one sentence
    evaluation : the run there
    slopes : derivatives of objective and excess of each constraint to the keys,
        (1 + constraints, keys); nan where a key is whole, None without gradients
    prices : change of the objective by one unit more of the excess of each constraint,
        (constraints,)
    bound_prices : change of the objective by one unit of each bound that a key lies on,
        (keys,)
    active : constraints without slack, (constraints,)
    residual : of the first-order conditions; None without gradients
    expected, errors : objective and excess of each constraint by the surrogate, and
        their standard errors, (1 + constraints,); None with gradients
    """

    status: str
    why: str
    evaluation: Evaluation
    prices: Array
    bound_prices: Array
    active: Flags
    slopes: Array | None = None
    residual: float | None = None
    remarks: tuple[str, ...] = ()
    errors: Array | None = None
    expected: Array | None = None


def found_at(
    evaluations: Evaluations,
    optimum: Optimum | None,
    point: Array | None,
    rest: list[int],
    remarks: tuple[str, ...],
    about_whole: str,
) -> Found:
    """Return what a search by gradients has found; without an optimum the best point
    that was computed.
    """
    design = evaluations.design
    if optimum is None or point is None:
        why = remarks[-1] if remarks else "no search could begin"
        return replace(not_converged(evaluations, why), remarks=remarks)
    evaluation = evaluations.at(point)
    sign = design.sign
    bound_prices = np.zeros(len(design.keys))
    bound_prices[rest] = sign * optimum.bound_prices
    slopes = np.full((1 + len(design.constraints), len(design.keys)), np.nan)
    slopes[:, rest] = optimum.derivatives
    slopes[0] *= sign
    if optimum.converged:
        status, why = OPTIMUM, "all constraints and the first-order conditions hold"
        why += f" (residual {optimum.residual:.1e} of the gradient)" if rest else ""
        why += f"; {about_whole}" if about_whole else ""
    elif not optimum.feasible:
        status, why = INFEASIBLE, infeasible(design, evaluation)
    else:
        status = NOT_CONVERGED
        fails = any(row.functions is None for row in evaluations.rows)
        why = (
            f"the first-order conditions are open by {optimum.residual:.1e} of the "
            f"gradient, allowed {FIRST_ORDER:g}; "
        )
        why += (
            "runs beyond this point fail, see table.csv: narrow the bounds, or mend "
            "the scene there"
            if fails
            else "give a smaller solver.tolerance in the scene, or this point as start"
        )
    return Found(
        status,
        why,
        evaluation,
        -sign * optimum.prices,
        bound_prices,
        optimum.active,
        slopes,
        optimum.residual,
        remarks,
    )


def not_converged(evaluations: Evaluations, why: str) -> Found:
    """Return the best point that was computed, of which no prices are known."""
    design = evaluations.design
    nothing = np.zeros(len(design.constraints))
    best = best_of(evaluations.rows, design)
    free = np.zeros(len(design.keys))
    return Found(NOT_CONVERGED, why, best, nothing, free, nothing.astype(bool))


def infeasible(design: Design, evaluation: Evaluation) -> str:
    """Say which constraints are missed at the nearest point, and by how much."""
    missed = []
    for one, excess in zip(design.constraints, evaluation.values[1:], strict=True):
        beyond = abs(excess) if one.sign == "==" else excess
        if beyond > 0.0:
            missed.append(f'"{one.text}" by {beyond:.4g}{behind(one.left.unit)}')
    nearest = ", ".join(missed) or "none by more than it scatters"
    return (
        "no point within the bounds was found that fulfils all constraints; the "
        f"nearest misses {nearest}"
    )


def best_of(evaluations: Sequence[Evaluation], design: Design) -> Evaluation:
    """Return the best point of all: feasible ones first, else the one that misses
    its constraints least.
    """
    computed = [one for one in evaluations if one.functions is not None]
    missed = np.array(
        [
            np.where(design.equality, np.abs(one.values[1:]), one.values[1:])
            for one in computed
        ]
    )
    size = np.abs(missed).max(axis=0, initial=0.0)
    size[size == 0.0] = 1.0
    excess = np.maximum(missed / size, 0.0).max(axis=1, initial=0.0)
    excess[excess <= FEASIBLE] = 0.0
    return computed[
        min(range(len(computed)), key=lambda k: (excess[k], computed[k].values[0]))
    ]


def costs(design: Design, found: Found) -> Iterator[str]:
    """Yield a sentence for each active constraint and bound: what a little more or
    less of it changes.
    """
    if found.slopes is None or found.status == INFEASIBLE:
        return
    values = named_values(design, found.evaluation.point, found.evaluation.qoi)
    for one, price, active in zip(
        design.constraints, found.prices, found.active, strict=True
    ):
        if active:
            amount = _round_part(one.bound(values), one.left(values))
            if abs(price * amount) <= NOTHING * abs(design.objective(values)):
                yield f'"{one.text}" is active and costs nothing to first order'
            else:
                yield f'"{one.text}": {_relaxed(one, amount)} {_change(design.objective, price * amount)}'
    for k, key in enumerate(design.keys):
        if price := found.bound_prices[k]:
            value = float(found.evaluation.point[k])
            side, sign = (
                ("lower", -1.0)
                if value - key.low < key.high - value
                else ("upper", 1.0)
            )
            amount = _round_part(value, key.span)
            words = (
                f"{amount:g}{behind(key.unit)} {'lower' if sign < 0.0 else 'higher'}"
            )
            change = _change(design.objective, sign * price * amount)
            yield f"{key.name} is at its {side} bound, {key.shown(value)}: {words} {change}"


def _relaxed(one: Constraint, amount: float) -> str:
    text = f"{amount:g}{behind(one.left.unit)}"
    return (
        text
        + {
            "<=": " more allowed",
            ">=": " less asked for",
            "==": " more on the right side",
        }[one.sign]
    )


def _change(objective: Expression, change: float) -> str:
    return f"changes {objective.text} by {change:+.4g}{behind(objective.unit)}"


def _round_part(value: float, otherwise: float) -> float:
    """Return a power of ten between a hundredth and a tenth of a value: an amount to
    speak of.
    """
    size = abs(value) or abs(otherwise) or 1.0
    return float(10.0 ** (math.floor(math.log10(size)) - 1))
