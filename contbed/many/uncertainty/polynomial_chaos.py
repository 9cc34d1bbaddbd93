"""Results as polynomials of the uncertain parameters, by least squares on the runs of a
sample (polynomial chaos).

    f(z) = sum_k c_k prod_j P_(a_kj)(z_j),        mean = c_0,        variance = sum_(k > 0) c_k^2

P are orthonormal in the distribution of each parameter, Legendre's of an even one and
Hermite's of a normal one, in the coordinate in which it is even or normal. The terms
that contain parameter j only, over the variance, are its first-order index, those that
contain it at all its total one (Sudret 2008, doi:10.1016/j.ress.2007.04.002). Terms are
taken one after the other, by their projection on what is left (sparse as in Blatman &
Sudret 2011, doi:10.1016/j.jcp.2010.12.021) or by degree; which, and how many, the error
decides at a fifth of the runs that is left out in turn.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array
from contbed.many.distributions import Distribution
from contbed.many.sweep.table import VARIES
from contbed.many.uncertainty.indices import SOBOL_COLUMNS, Indices
from contbed.many.uncertainty.propagate import COVERAGE, Spread, of_size_one

# share of the variance that the polynomial may leave; above, its indices say little
MOST_UNEXPLAINED = 0.1
MOST_TERMS = 600  # to choose from, which bounds memory and time
MOST_TAKEN = 120  # of them; smooth results are exact to many digits before
# at least; coefficients of more terms than half of the runs are mostly noise
RUNS_PER_TERM = 2
HIGHEST_DEGREE = 14
# norm of the degrees that is bounded: high degrees in one parameter, lower ones where
# several act
INTERACTIONS = 0.75
ROUNDING = 1e-9  # of that norm
FOLDS = 5  # of the runs, each of which is left out once
QUANTILE = 1.645  # of the normal distribution, for half widths at 90 %
# part of a term, by norm, below which the runs do not distinguish it from those before
DEPENDENT = 1e-8
POINTS = 4096  # of the polynomial, for its band
SEED = 1  # of these points


@dataclass(frozen=True)
class Expansion:
    """A polynomial of the scaled coordinates.

    distributions : of the parameters in their order
    degrees : of each term in each parameter, shape (terms, parameters), the constant
        first; coefficients (terms,)
    unexplained : share of the variance that it misses at runs by which neither terms
        nor coefficients were found
    half_widths : of the bands of first-order and total indices, shape (2, parameters)
    """

    distributions: Sequence[Distribution]
    degrees: NDArray[np.int_]
    coefficients: Array
    unexplained: float
    half_widths: Array
    runs: int

    @property
    def deviation(self) -> float:
        """Standard deviation of the polynomial."""
        return math.hypot(*self.coefficients[1:])


def expansion(
    points: Array, values: Array, distributions: Sequence[Distribution]
) -> Expansion | None:
    """Return the polynomial of a result; None where it would leave too much of the
    variance, or there is none.

    Parameters
    ----------
    points : independent ones in the unit cube, shape (runs, parameters)
    values : of the result, shape (runs,); not a number where a run failed
    distributions : of the parameters in their order
    """
    kept = np.isfinite(values) & ((points > 0.0) & (points < 1.0)).all(axis=1)
    y, exponent = of_size_one(values[kept])
    most = min(len(y) * (FOLDS - 1) // (FOLDS * RUNS_PER_TERM), MOST_TAKEN)
    if most < 2 + len(distributions) or np.ptp(y) <= VARIES:
        return None
    degrees = _degrees(len(distributions))
    basis = _basis(points[kept], degrees, distributions)
    fold = np.arange(len(y)) % FOLDS
    best = min(
        (_validated(basis, y, fold, most, greedy) for greedy in (True, False)),
        key=lambda each: each.error,
    )
    if best.error > MOST_UNEXPLAINED:
        return None
    shares = []
    for k, terms in enumerate(best.terms):
        shares.append(
            _shares(degrees[terms], _fitted(basis[fold != k][:, terms], y[fold != k]))
        )
    taken, _ = _taken(basis, y, len(best.terms[0]), basis[:0], best.greedy)
    half = QUANTILE * np.hypot(
        math.sqrt(FOLDS - 1.0) * np.std(shares, axis=0), best.error
    )
    coefficients = np.ldexp(_fitted(basis[:, taken], y), exponent)
    return Expansion(
        distributions, degrees[taken], coefficients, best.error, half, len(y)
    )


def chaos_spread(found: Expansion) -> Spread:
    """Return mean, standard deviation and band of the polynomial."""
    from scipy.stats import qmc

    points = qmc.Sobol(len(found.distributions), scramble=True, seed=SEED).random(
        POINTS
    )
    values = _basis(points, found.degrees, found.distributions) @ found.coefficients
    low, high = np.quantile(values, (0.5 * (1.0 - COVERAGE), 0.5 * (1.0 + COVERAGE)))
    deviation = found.deviation
    error = deviation * math.sqrt(found.unexplained / found.runs)
    mean = float(found.coefficients[0])
    return Spread(
        "polynomial chaos", mean, deviation, float(low), float(high), error, found.runs
    )


def chaos_indices(found: Expansion) -> Indices:
    """Return first-order and total indices with the half widths of their bands."""
    first, total = _shares(found.degrees, found.coefficients)
    columns = zip(
        SOBOL_COLUMNS,
        (first, found.half_widths[0], total, found.half_widths[1]),
        strict=True,
    )
    return Indices(dict(columns), found.runs)


def _shares(degrees: NDArray[np.int_], coefficients: Array) -> tuple[Array, Array]:
    parts, has = of_size_one(coefficients)[0] ** 2, degrees > 0
    alone = has.sum(axis=1) == 1
    variance = parts[has.any(axis=1)].sum() or 1.0
    first = np.array([parts[alone & has[:, j]].sum() for j in range(degrees.shape[1])])
    total = np.array([parts[has[:, j]].sum() for j in range(degrees.shape[1])])
    return first / variance, total / variance


def _degrees(parameters: int) -> NDArray[np.int_]:
    """Return the degrees of the terms up to the highest bound of their norm with
    MOST_TERMS at most, constant first.
    """
    for highest in range(HIGHEST_DEGREE, 1, -1):
        found = list(
            islice(
                _within(parameters, highest**INTERACTIONS + ROUNDING), MOST_TERMS + 1
            )
        )
        if len(found) <= MOST_TERMS:
            return np.array(sorted(found, key=lambda degrees: (sum(degrees), degrees)))
    return np.vstack([np.zeros(parameters, dtype=int), np.eye(parameters, dtype=int)])


def _within(parameters: int, left: float) -> Iterator[tuple[int, ...]]:
    """Yield the degrees the sum of whose powers is not above `left`."""
    if parameters == 0:
        yield ()
        return
    degree = 0
    while degree**INTERACTIONS <= left:
        for others in _within(parameters - 1, left - degree**INTERACTIONS):
            yield (degree, *others)
        degree += 1


def _basis(
    points: Array, degrees: NDArray[np.int_], distributions: Sequence[Distribution]
) -> Array:
    """Return the values of the terms at points of the unit cube, shape (runs,
    terms).
    """
    from numpy.polynomial import hermite_e, legendre
    from scipy.special import ndtri

    highest = int(degrees.max(initial=0))
    values = np.ones((len(points), len(degrees)))
    for j, distribution in enumerate(distributions):
        n = np.arange(highest + 1)
        if distribution.even:
            table = legendre.legvander(2.0 * points[:, j] - 1.0, highest) * np.sqrt(
                2.0 * n + 1.0
            )
        else:
            norms = np.sqrt(np.cumprod(np.maximum(n, 1).astype(float)))
            table = hermite_e.hermevander(ndtri(points[:, j]), highest) / norms
        values *= table[:, degrees[:, j]]
    return values


class _Validated(NamedTuple):
    """Terms taken without each part of the runs, as many as predict it best, and the
    share of the variance missed.
    """

    error: float
    terms: list[list[int]]
    greedy: bool


def _validated(
    basis: Array, y: Array, fold: NDArray[np.int_], most: int, greedy: bool
) -> _Validated:
    errors, taken = np.zeros(most), []
    for k in range(FOLDS):
        terms, predicted = _taken(
            basis[fold != k], y[fold != k], most, basis[fold == k], greedy
        )
        missed = ((y[fold == k, None] - predicted) ** 2).sum(axis=0)
        errors += np.pad(missed, (0, most - len(missed)), mode="edge")
        taken.append(terms)
    number = 1 + int(np.argmin(errors))
    return _Validated(
        errors[number - 1] / ((y - y.mean()) ** 2).sum(),
        [terms[:number] for terms in taken],
        greedy,
    )


def _taken(
    basis: Array, y: Array, most: int, others: Array, greedy: bool
) -> tuple[list[int], Array]:
    """Return the terms in the order in which they are taken, and with each of them the
    values at other runs.

    Those taken are made orthonormal (Gram and Schmidt), here and at the other runs
    alike, so that a further one leaves the parts of those before as they are. Terms
    that the runs do not distinguish from them are left out.

    Parameters
    ----------
    basis, others : terms at the runs to fit and at others, shapes (runs, terms) and
        (others, terms)
    greedy : by their projection on what is left, else by their degree, which few runs
        mislead less
    """
    norms = np.linalg.norm(basis, axis=0)
    here, there = np.empty((len(y), most)), np.empty((len(others), most))
    predicted, rest = np.zeros((len(others), most)), y
    taken: list[int] = []
    open_terms = np.ones(basis.shape[1], dtype=bool)
    while len(taken) < most and open_terms.any():
        count = len(taken)
        ranked = (
            np.abs(basis.T @ rest) / norms
            if greedy and count
            else -np.arange(len(norms), dtype=float)
        )
        term = int(np.argmax(np.where(open_terms, ranked, -np.inf)))
        open_terms[term] = False
        q, r = basis[:, term].copy(), others[:, term].copy()
        for _ in range(2):  # again for what rounding leaves
            parts = here[:, :count].T @ q
            q, r = q - here[:, :count] @ parts, r - there[:, :count] @ parts
        size = float(np.linalg.norm(q))
        if size < DEPENDENT * norms[term]:
            continue
        taken.append(term)
        here[:, count], there[:, count] = q / size, r / size
        part = float(here[:, count] @ rest)
        rest = rest - part * here[:, count]
        predicted[:, count] = predicted[:, count - 1] + part * there[:, count]
    return taken, predicted[:, : len(taken)]


def _fitted(basis: Array, y: Array) -> Array:
    return np.asarray(np.linalg.lstsq(basis, y, rcond=None)[0], dtype=float)
