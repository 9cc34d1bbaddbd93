"""Banded matrices of a line against dense ones: products, solutions with prescribed
unknowns, orders, failures.
"""

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.testing import assert_allclose

from contbed.errors import ConvergenceError
from contbed.solvers.banded import WIDEST, Ordering


def line(n: int, seed: int) -> sp.csc_matrix:
    """A diagonally dominant matrix with five diagonals, in a random order of the
    unknowns.
    """
    random = np.random.default_rng(seed)
    diagonals = [random.normal(size=n - abs(k)) for k in (-2, -1, 1, 2)]
    matrix = sp.diags(diagonals, [-2, -1, 1, 2]) + 10.0 * sp.eye(n)
    shuffle = random.permutation(n)
    return sp.csc_matrix(matrix.tocsr()[shuffle][:, shuffle])


@pytest.mark.parametrize("n", [9, 40, 241])
def test_products_and_solutions_are_those_of_the_dense_matrix(n):
    """To rounding, 1e-13 of the largest entry, also with rows and columns of
    prescribed unknowns.
    """
    matrix, random = line(n, n), np.random.default_rng(1)
    ordering = Ordering.of(matrix)
    assert ordering is not None and ordering.width <= 4
    band, x = ordering.band(matrix), random.normal(size=n)
    assert_allclose(
        (band @ x[ordering.order])[ordering.back], matrix @ x, rtol=0, atol=1e-13 * 10
    )
    fixed = np.unique(random.integers(0, n, size=max(1, n // 10)))
    dense = matrix.toarray()
    dense[fixed], dense[:, fixed] = 0.0, 0.0
    dense[fixed, fixed] = 1.0
    solve = band.solver(np.sort(ordering.back[fixed]))
    assert_allclose(
        solve(x[ordering.order])[ordering.back],
        np.linalg.solve(dense, x),
        rtol=0,
        atol=1e-13,
    )


def test_sum_of_two_matrices():
    """A + c B entry by entry."""
    a, b = line(30, 5), line(30, 5)
    ordering = Ordering.of(a)
    assert ordering is not None
    x = np.linspace(0.0, 1.0, 30)
    both = ordering.band(a).plus(ordering.band(b), 0.3)
    assert_allclose(
        (both @ x[ordering.order])[ordering.back], a @ x + 0.3 * (b @ x), rtol=1e-12
    )


def test_entries_that_cancelled_do_not_widen_the_band():
    """An explicit zero far from the diagonal is left out."""
    matrix = line(30, 2).tolil()
    matrix[0, 20] = 1e-300
    matrix = sp.csc_matrix(matrix)
    matrix.data[np.abs(matrix.data) == 1e-300] = 0.0
    ordering = Ordering.of(line(30, 2))
    assert ordering is not None
    x = np.ones(30)
    assert_allclose((ordering.band(matrix) @ x)[ordering.back], matrix @ x, rtol=1e-12)


def test_wide_matrices_are_left_to_general_factors():
    """A full matrix has no order with a narrow band; a band as wide as a small
    matrix saves nothing.
    """
    assert Ordering.of(sp.csc_matrix(np.ones((2 * WIDEST + 4, 2 * WIDEST + 4)))) is None
    assert Ordering.of(line(3, 1)) is None


@pytest.mark.parametrize(
    ("value", "words"), [(0.0, "singular"), (np.nan, "not finite")]
)
def test_matrices_that_cannot_be_solved(value, words):
    """Zero and NaN end with a sentence."""
    matrix = line(10, 3)
    ordering = Ordering.of(matrix)
    assert ordering is not None
    band = ordering.band(matrix)
    band.data[:] = value
    with pytest.raises(ConvergenceError, match=words):
        band.solver(np.empty(0, dtype=np.int64))
