"""Sensitivity indices of results from the runs of a design, by SALib.

Sobol indices: the share of the variance of a result that a parameter causes alone
(first order), and with all its interactions (total) (Saltelli et al. 2010,
doi:10.1016/j.cpc.2009.09.018). Morris screening: the mean of the magnitude of
elementary effects shows how much a parameter matters, their scatter how far its effect
depends on the others (Campolongo et al. 2007, doi:10.1016/j.envsoft.2006.10.004).
Points of groups with a failed run are left out.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from contbed.arrays import Array
from contbed.many.sweep.table import VARIES
from contbed.many.uncertainty.propagate import of_size_one
from contbed.many.value_sets import LEVELS, unit_cube

CONFIDENCE = 0.90  # of the half widths of indices
RESAMPLES = 200  # of the groups, for their confidence
LEAST_GROUPS = 4  # with which indices say something
SEED = 1  # of the resampling; SALib takes 0 for none


@dataclass(frozen=True)
class Indices:
    """Indices of one result, by column: each of shape (parameters,); `groups` is how
    many groups of runs they use.
    """

    columns: dict[str, Array]
    groups: int


SOBOL_COLUMNS = {
    "first order": "S1",
    "first order +-": "S1_conf",
    "total": "ST",
    "total +-": "ST_conf",
}
MORRIS_COLUMNS = {
    "mean effect": "mu",
    "mean magnitude": "mu_star",
    "mean magnitude +-": "mu_star_conf",
    "scatter": "sigma",
}


def indices(method: str, points: Array, values: Array) -> Indices | None:
    """Return the indices of a result; None if too few groups of runs have a value, or
    none of them differ.

    Parameters
    ----------
    method : "sobol_indices" or "morris"
    points : of the design in the unit cube, shape (runs, parameters)
    values : of the result, shape (runs,); not a number where a run failed
    """
    parameters = points.shape[1]
    size = parameters + (2 if method == "sobol_indices" else 1)
    usable = np.isfinite(values.reshape(-1, size)).all(axis=1)
    rows = np.repeat(usable, size)
    groups, kept = int(usable.sum()), values[rows]
    kept, exponent = of_size_one(kept)
    if groups < LEAST_GROUPS or np.ptp(kept) <= VARIES:
        return None
    problem = unit_cube(parameters)
    options = {"num_resamples": RESAMPLES, "conf_level": CONFIDENCE, "seed": SEED}
    with warnings.catch_warnings():
        # on parameters without any effect, whose indices are 0
        warnings.simplefilter("ignore")
        from SALib.analyze import morris, sobol

        if method == "sobol_indices":
            columns = SOBOL_COLUMNS
            found = sobol.analyze(problem, kept, calc_second_order=False, **options)
        else:
            columns, x = MORRIS_COLUMNS, points[rows]
            found = morris.analyze(problem, x, kept, num_levels=LEVELS, **options)
    # effects are in the unit of the result, indices are shares
    scale = exponent if method == "morris" else 0
    return Indices(
        {
            name: np.ldexp(np.asarray(found[key], float), scale)
            for name, key in columns.items()
        },
        groups,
    )
