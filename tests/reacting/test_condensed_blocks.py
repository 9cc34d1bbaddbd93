"""Fields in no flux are eliminated at their nodes: the same solution as that of the
whole matrix.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from contbed.errors import ConvergenceError
from contbed.fem import line_blocks
from contbed.fem.line_blocks import Blocks, Factors

N, M, NODES, LOCAL = 4, 5, 3, (1, 3)
SIZES = np.ones(M), np.ones(M)


def blocks():
    """Random blocks; local fields have entries at their own nodes alone."""
    random = np.random.default_rng(7)
    lower, own, upper = (
        random.standard_normal((N, M, NODES, M, NODES)) for _ in range(3)
    )
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


def held(parts, local=()):
    """Blocks in which what a node takes from itself is among the sources: half of
    it, and all of local fields.
    """
    lower, own, upper = parts
    exchanged = np.setdiff1d(np.arange(M), local)
    measure = np.random.default_rng(10).uniform(0.5, 2.0, (N, NODES))
    none = np.zeros((M, N, NODES, NODES))
    made = Blocks.zeros(exchanged, measure, np.ones(M, bool), none, none)
    for mine, given in ((made.lower, lower), (made.own, own), (made.upper, upper)):
        mine[...] = given[:, exchanged][:, :, :, exchanged]
    for node in range(NODES):
        made.own[:, :, node, :, node] *= 0.5
        at_node = own[:, :, node, :, node].copy()
        at_node[:, exchanged[:, None], exchanged] *= 0.5
        made.sources[..., node] = -at_node.transpose(1, 2, 0) / measure[:, node]
    return made


@pytest.mark.parametrize("local", [(), LOCAL], ids=["all fields", "condensed"])
def test_sources_belong_to_the_blocks(local):
    for found, given in zip(held(blocks(), local).of_all(), blocks(), strict=True):
        assert_allclose(found, given, rtol=1e-15)


def test_same_solution():
    right = np.random.default_rng(8).standard_normal((M, N, NODES))
    whole, condensed = (
        Factors(held(blocks()), SIZES).solve(right),
        Factors(held(blocks(), LOCAL), SIZES).solve(right),
    )
    assert_allclose(condensed, whole, rtol=1e-11, atol=1e-13)


def test_a_node_without_solution():
    lower, own, upper = blocks()
    own[2, LOCAL[0], 0] = 0.0
    with pytest.raises(ConvergenceError, match="singular"):
        Factors(held((lower, own, upper), LOCAL), SIZES)


@pytest.mark.parametrize("local", [(), LOCAL], ids=["all fields", "condensed"])
def test_wide_blocks_have_sparse_factors_with_the_same_solution(local, monkeypatch):
    right = np.random.default_rng(8).standard_normal((M, N, NODES))
    as_band = Factors(held(blocks(), local), SIZES).solve(right)
    monkeypatch.setattr(line_blocks, "WIDEST", 1)
    assert_allclose(
        Factors(held(blocks(), local), SIZES).solve(right),
        as_band,
        rtol=1e-11,
        atol=1e-13,
    )


@pytest.mark.parametrize(("value", "told"), [(0.0, "singular"), (np.nan, "not finite")])
def test_sparse_factors_tell_what_is_wrong(value, told, monkeypatch):
    monkeypatch.setattr(line_blocks, "WIDEST", 1)
    lower, own, upper = blocks()
    for part in (lower, own, upper):
        part[2, 0, 0] = value
    with pytest.raises(ConvergenceError, match=told):
        Factors(held((lower, own, upper)), SIZES)


@pytest.mark.parametrize("local", [(), LOCAL], ids=["all fields", "condensed"])
def test_units_leave_the_solution_as_exact_as_it_was(local):
    """Equations in other units and unknowns in others, a million times and a
    billionth: digits are lost to rounding.
    """
    random = np.random.default_rng(9)
    equations, unknowns = (
        10.0 ** random.uniform(-6, 6, M),
        10.0 ** random.uniform(-9, 9, M),
    )
    right = random.standard_normal((M, N, NODES))
    plain = Factors(held(blocks(), local), SIZES).solve(right)
    other = tuple(
        part * equations[:, None, None, None] / unknowns[:, None] for part in blocks()
    )
    found = Factors(held(other, local), (equations, unknowns)).solve(
        right * equations[:, None, None]
    )
    assert_allclose(found / unknowns[:, None, None], plain, rtol=1e-12, atol=1e-14)
