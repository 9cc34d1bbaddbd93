"""The way from an easier problem to the one that is meant."""

import pytest

from contbed.errors import ConvergenceError
from contbed.solvers.continuation import LEAST_SHARE, from_easier


def test_no_step_of_the_way_is_tried_twice():
    """States are followed in steps up to 0.3, but in those up to 0.02 where less than
    0.05 is left; a step that fails is halved from what was tried, also at the end.
    """
    tried = []

    def solve(left, state):
        tried.append((state, left))
        if state - left > (0.3 if left > 0.05 else 0.02):
            raise ConvergenceError("too far", [], state)
        return left

    assert from_easier(solve, 1.0) == 0.0
    assert len(set(tried)) == len(tried)


def test_a_way_that_ends_is_told():
    tried = []

    def solve(left, state):
        tried.append(left)
        if left < 0.5:
            raise ConvergenceError("no state", [], state)
        return left

    with pytest.raises(ConvergenceError, match="no state"):
        from_easier(solve, None)
    # the last step is shorter than twice the shortest
    assert 0.5 - max(left for left in tried if left < 0.5) < 2.0 * LEAST_SHARE
