"""Factors of systems in which balances of phases that hardly flow stand beside those
of all others.
"""

import numpy as np
import pytest
import scipy.sparse as sp

from contbed.errors import ConvergenceError
from contbed.solvers.linear import Policy, Solver

NODES, SMALL, LARGE = 60, 1e-10, 1e4


@pytest.fixture
def system():
    """A flow that falls to a third from node to node, the heat of what flows, small at
    its end, and a conducting gas.

    Heat taken from the flow is 1e14 times what a phase that is all but gone exchanges
    with the gas.
    """
    one, less = np.ones(NODES), np.ones(NODES - 1)
    flow = sp.diags([one, -less / 3.0], [0, -1])
    taken = sp.diags([LARGE * one, -LARGE * less / 3.0], [0, -1])
    passed = sp.diags([SMALL * one], [0])
    gas = sp.diags([2e3 * one, -1e3 * less, -1e3 * less], [0, 1, -1]) + passed
    matrix = sp.bmat(
        [[flow, None, None], [taken, passed, -passed], [None, -passed, gas]]
    ).tocsc()
    rhs = np.zeros(3 * NODES)
    rhs[0], rhs[NODES], rhs[2 * NODES :] = 1.0, LARGE, 1.0
    return matrix, rhs


def test_a_flow_that_vanishes_has_every_digit(system):
    """On a line: F = 3^-n to rounding, where other pivots leave the rounding of all
    balances, 1e-16, at each node.
    """
    matrix, rhs = system
    x = Solver(matrix, Policy(1))(rhs)
    assert x[:NODES] == pytest.approx(3.0 ** -np.arange(NODES), rel=1e-13, abs=0.0)
    # what the phase takes from the flow is nothing, so that it has the temperature of
    # the gas; other pivots leave 7e-3
    gas = x[2 * NODES :]
    assert np.abs(x[NODES : 2 * NODES] - gas)[NODES // 2 :].max() < 1e-12 * gas.max()


def test_factors_with_pivots_are_refined(system):
    """With equations in another order no diagonal can be kept; without refinement
    the phase is off by 1e-3.
    """
    matrix, rhs = system
    order = np.r_[NODES : 2 * NODES, 0:NODES, 2 * NODES : 3 * NODES]
    x = Solver(matrix[order].tocsc(), Policy(1))(rhs[order])
    gas = x[2 * NODES :]
    assert np.abs(x[NODES : 2 * NODES] - gas)[NODES // 2 :].max() < 1e-12 * gas.max()


def mixing(strength):
    """Nodes that exchange with their neighbours, each fed and drained by a flow of
    1.
    """
    one = np.ones(NODES)
    between = sp.diags([np.r_[1.0, 2.0 * one[2:], 1.0], -one[1:], -one[1:]], [0, 1, -1])
    return (strength * between + sp.identity(NODES)).tocsc()


def test_fast_mixing_is_solved_as_far_as_its_rounding_allows():
    """A x = b with sum(x) = sum(b): terms of 1e13 round by 1e-3 of b, which a limit of
    1e-3 takes for a fault or not.

    The mean is off by rounding of 1e-16 of these terms at each of 60 nodes; all nodes
    are as hot as the mean to 1e-11.
    """
    for seed in range(20):
        b = np.random.default_rng(seed).uniform(0.5, 2.0, NODES)
        x = Solver(mixing(1e13), Policy(1))(b)
        assert x.mean() == pytest.approx(b.mean(), rel=2e-2)
        assert np.ptp(x) < 1e-11 * x.mean()


def test_a_matrix_whose_indices_are_not_sorted_stays_as_it_is():
    """The factors share its indices, which SuperLU sorts: 1e-12 of a matrix of
    condition 1e3.
    """
    known = mixing(1.0)
    order = np.concatenate(
        [np.arange(known.indptr[k], known.indptr[k + 1])[::-1] for k in range(NODES)]
    )
    reversed_rows = known.data[order], known.indices[order], known.indptr
    matrix, b = sp.csc_matrix(reversed_rows), np.arange(1.0, NODES + 1.0)
    x = Solver(matrix, Policy(1))(b)
    assert known @ x == pytest.approx(b, rel=1e-12)
    assert (abs(matrix - known)).sum() == 0.0


def test_a_matrix_without_a_level_is_refused():
    """Nodes that only exchange have no mean, whatever rounding makes of it.

    Of 2000 a few look as if they had one: 1 where a residual may change a hundredth of
    the solution, 5 without that and nearly all without a limit of terms.
    """
    rng, solved = np.random.default_rng(1), 0
    for _ in range(2000):
        n = int(rng.integers(4, 20))
        k, b = np.exp(rng.normal(0.0, 4.0, n - 1)), rng.normal(size=n)
        between = sp.diags(
            [np.append(k, 0.0) + np.append(0.0, k), -k, -k], [0, 1, -1]
        ).tocsc()
        try:
            Solver(between, Policy(1))(b)
            solved += 1
        except ConvergenceError as error:
            assert any(word in str(error) for word in ("singular", "relative residual"))
    assert solved <= 3
