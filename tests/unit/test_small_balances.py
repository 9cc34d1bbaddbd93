"""Factors of systems in which balances of phases that hardly flow stand beside those of all others."""

import numpy as np
import pytest
import scipy.sparse as sp

from contbed.solvers.linear import Policy, Solver

NODES, SMALL, LARGE = 60, 1e-10, 1e4


@pytest.fixture
def system():
    """A flow that falls to a third from node to node, the heat of what flows, small at its end, and a conducting gas.

    Heat taken from the flow is 1e14 times what a phase that is all but gone exchanges with the gas.
    """
    one, less = np.ones(NODES), np.ones(NODES - 1)
    flow = sp.diags([one, -less / 3.0], [0, -1])
    taken = sp.diags([LARGE * one, -LARGE * less / 3.0], [0, -1])
    passed = sp.diags([SMALL * one], [0])
    gas = sp.diags([2e3 * one, -1e3 * less, -1e3 * less], [0, 1, -1]) + passed
    matrix = sp.bmat([[flow, None, None], [taken, passed, -passed], [None, -passed, gas]]).tocsc()
    rhs = np.zeros(3 * NODES)
    rhs[0], rhs[NODES], rhs[2 * NODES :] = 1.0, LARGE, 1.0
    return matrix, rhs


def test_a_flow_that_vanishes_has_every_digit(system):
    """On a line: F = 3^-n to rounding, where other pivots leave the rounding of all balances, 1e-16, at each node."""
    matrix, rhs = system
    x = Solver(matrix, Policy(1))(rhs)
    assert x[:NODES] == pytest.approx(3.0 ** -np.arange(NODES), rel=1e-13)
    # what the phase takes from the flow is nothing, so that it has the temperature of the gas; other pivots leave 7e-3
    gas = x[2 * NODES :]
    assert np.abs(x[NODES : 2 * NODES] - gas)[NODES // 2 :].max() < 1e-12 * gas.max()


def test_factors_with_pivots_are_refined(system):
    """With equations in another order no diagonal can be kept; without refinement the phase is off by 1e-3."""
    matrix, rhs = system
    order = np.r_[NODES : 2 * NODES, 0:NODES, 2 * NODES : 3 * NODES]
    x = Solver(matrix[order].tocsc(), Policy(1))(rhs[order])
    gas = x[2 * NODES :]
    assert np.abs(x[NODES : 2 * NODES] - gas)[NODES // 2 :].max() < 1e-12 * gas.max()
