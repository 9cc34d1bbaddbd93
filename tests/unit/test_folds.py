"""Branches of one equation whose folds have closed forms.

x - a tanh(b x) = p,   folds where a b = cosh^2(b x)
"""

from types import SimpleNamespace

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


@pytest.mark.parametrize("ahead", [1e-5, 1e-6])
@pytest.mark.parametrize("first_fold", [True, False])
def test_a_fold_within_the_first_step_is_passed(ahead, first_fold):
    """The branch begins `ahead` of a fold and comes back to this parameter on its other
    side: about as far from it, by the parabola through the fold, to 2 % by its next
    term.
    """

    def assemble(x, p, jacobian):
        slope = 1.0 - 10.0 / np.cosh(10.0 * x) ** 2
        matrix = csr_matrix(np.diag(slope)) if jacobian else None
        return x - np.tanh(10.0 * x) - p, matrix

    at = -np.arccosh(np.sqrt(10.0)) / 10.0
    start = at - np.tanh(10.0 * at) - ahead
    x = np.array([at - 0.3 * ahead**0.5])
    for _ in range(60):
        residual, matrix = assemble(x, start, True)
        x = x - residual / matrix.toarray()[0, 0]
    way = Way(start, 2.0, 100, first_fold=first_fold)
    found = trace(assemble, x, way, Policy(1), weights=np.ones(1), size=1.0)
    assert found.folds[0][1] == approx(start + ahead, abs=1e-8)
    result = SimpleNamespace(warnings=[], qoi={})
    found.report("p", result)
    if first_fold:
        assert found.complete and not result.warnings
    else:
        assert "turns back" in result.warnings[0]
        assert found.states[-1][0] - at == approx(at - x[0], rel=0.02)
