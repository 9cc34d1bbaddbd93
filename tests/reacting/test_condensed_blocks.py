"""Fields in no flux are eliminated at their nodes: the same solution as that of the whole matrix."""

from __future__ import annotations

import numpy as np
import pytest

from contbed.errors import ConvergenceError
from contbed.fem import line_blocks
from contbed.fem.line_blocks import Factors

N, M, NODES, LOCAL = 4, 5, 3, (1, 3)


def blocks():
    """Random blocks; local fields have entries at their own nodes alone."""
    random = np.random.default_rng(7)
    lower, own, upper = (random.standard_normal((N, M, NODES, M, NODES)) for _ in range(3))
    for part in (lower, own, upper):
        for f in LOCAL:
            part[:, f] = 0.0
            part[:, :, :, f] = 0.0
    for node in range(NODES):
        for f in LOCAL:
            own[:, f, node, :, node] = random.standard_normal((N, M))
            own[:, :, node, f, node] = random.standard_normal((N, M))
    for f in range(M):
        for node in range(NODES):
            own[:, f, node, f, node] += 12.0
    return lower, own, upper


def test_same_solution():
    right = np.random.default_rng(8).standard_normal((M, N, NODES))
    whole, condensed = Factors(blocks()).solve(right), Factors(blocks(), LOCAL).solve(right)
    np.testing.assert_allclose(condensed, whole, rtol=1e-11, atol=1e-13)


def test_a_node_without_solution():
    lower, own, upper = blocks()
    own[2, LOCAL[0], 0] = 0.0
    with pytest.raises(ConvergenceError, match="singular"):
        Factors((lower, own, upper), LOCAL)


@pytest.mark.parametrize("local", [(), LOCAL], ids=["all fields", "condensed"])
def test_wide_blocks_have_sparse_factors_with_the_same_solution(local, monkeypatch):
    right = np.random.default_rng(8).standard_normal((M, N, NODES))
    as_band = Factors(blocks(), local).solve(right)
    monkeypatch.setattr(line_blocks, "WIDEST", 1)
    np.testing.assert_allclose(Factors(blocks(), local).solve(right), as_band, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize(("value", "told"), [(0.0, "singular"), (np.nan, "not finite")])
def test_sparse_factors_tell_what_is_wrong(value, told, monkeypatch):
    monkeypatch.setattr(line_blocks, "WIDEST", 1)
    lower, own, upper = blocks()
    for part in (lower, own, upper):
        part[2, 0, 0] = value
    with pytest.raises(ConvergenceError, match=told):
        Factors((lower, own, upper))
