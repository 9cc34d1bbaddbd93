"""Threads that run one kernel together: every piece once, nobody ahead of a phase,
the same bits for any number.
"""

import numpy as np
import pytest
from numba import njit

from contbed.compiled import barrier, threads
from contbed.compiled.barrier import finish, take, wait


@njit(nogil=True)
def smooth(crew, pieces, rounds, x, y):
    """Each round needs all of the round before; returns the number of threads."""
    length = len(x) // pieces
    for _ in range(rounds):
        piece = take(crew)
        while piece < pieces:
            for k in range(piece * length, (piece + 1) * length):
                y[k] = 0.3 * x[k - 1] + 0.7 * x[(k + 7 * length) % len(x)]
            piece = take(crew)
        finish(crew, pieces)
        x, y = y, x
    wait(crew)
    return crew.size


@pytest.mark.parametrize("number", [2, 3, 5])
def test_the_same_bits_for_any_number_of_threads(number):
    found = []
    for size in (1, number):
        x, y = np.random.default_rng(1).normal(size=(2, 1200))
        assert barrier.run(smooth, size, 24, 100, x, y) == size
        found.append(x)
    assert found[0].tobytes() == found[1].tobytes()


def test_one_thread_where_the_others_are_busy():
    """A second caller may not wait for threads that do not come."""

    def call():
        x, y = np.ones((2, 24))
        return barrier.run(smooth, 2, 24, 3, x, y)

    assert threads.together([(call, ()), (int, (1,))]) == [1, 1]


def test_pieces_are_taken_once():
    crews = barrier.crews(2)
    assert [take(crews[0]), take(crews[1]), take(crews[0])] == [0, 1, 2]
