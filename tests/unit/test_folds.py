"""Branches of one equation whose folds have closed forms.

x - a tanh(b x) = p,   folds where a b = cosh^2(b x)
"""

import numpy as np
import pytest
from pytest import approx
from scipy.sparse import csr_matrix

from contbed.solvers.branch import Way, trace
from contbed.solvers.linear import Policy


@pytest.mark.parametrize(
    ("a", "b"), [(1.0, 2.0), (1.0, 10.0), (0.5, 80.0), (1.0, 80.0)]
)
def test_a_branch_passes_sharp_folds_without_leaving_it(a, b):
    """With b = 80 a step past a fold finds another part of the branch, and is
    shortened. Folds within 1e-6, of the tolerance of their search.
    """

    def assemble(x, p, jacobian):
        slope = 1.0 - a * b / np.cosh(b * x) ** 2
        matrix = csr_matrix(np.diag(slope)) if jacobian else None
        return x - a * np.tanh(b * x) - p, matrix

    x = np.array([-a - 2.0])
    start = float(x[0] + a)
    way = Way(start, -start, 200)
    found = trace(assemble, x, way, Policy(1), weights=np.ones(1), size=1.0)
    at = np.arccosh(np.sqrt(a * b)) / b
    fold = a * np.tanh(b * at) - at
    assert [p for _, p, _ in found.folds] == approx([fold, -fold], abs=1e-6)
    assert found.complete
    assert found.parameter[-1] == -start
