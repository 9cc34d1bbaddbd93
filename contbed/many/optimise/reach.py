"""Constraints that the first gradient says cannot be reached within the bounds: a hint
before a long search.

    least excess  =  g(x_0) + sum_k min(dg/dx_k (low_k - x_k), dg/dx_k (high_k - x_k))

It is exact where a constraint is linear in the keys. Each constraint is taken alone, so
that constraints that exclude each other are not seen here.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contbed.arrays import Array
from contbed.fields import behind
from contbed.many.optimise.constrained_search import EvaluationFailed
from contbed.many.optimise.evaluations import Evaluations
from contbed.many.optimise.problem import Design


def warnings_at_start(evaluations: Evaluations) -> Iterator[str]:
    """Yield a sentence for each constraint that the gradient at the start does not
    reach; none with whole keys.
    """
    design = evaluations.design
    if not design.constraints or any(key.whole for key in design.keys):
        return
    at = evaluations.at(design.start)
    try:
        slopes = evaluations.derivatives(design.start, range(len(design.keys)))
    except EvaluationFailed:
        return  # the search reports why
    for one, excess, short in zip(
        design.constraints,
        at.values[1:],
        least_misses(design, at.values[1:], slopes[1:]),
        strict=True,
    ):
        if short > 0.0:
            unit = behind(one.left.unit)
            yield (
                f'{one.at}: "{one.text}" is missed by {abs(excess):.4g}{unit} at the '
                "start and, by the gradient there, "
                f"by {short:.4g}{unit} at the best point within the bounds; widen them "
                "or change it if the search "
                "does not find otherwise"
            )


def least_misses(design: Design, excess: Array, slopes: Array) -> Array:
    """Return by how much constraints (m,) are missed at best, for linear ones with
    slopes (m, keys); 0 if they hold.
    """
    steps = design.low - design.start, design.high - design.start
    ends = np.stack([slopes * step for step in steps])
    least = excess + ends.min(axis=0).sum(axis=1)
    most = excess + ends.max(axis=0).sum(axis=1)
    found: Array = np.where(design.equality, np.maximum(least, -most), least)
    return np.maximum(found, 0.0)
