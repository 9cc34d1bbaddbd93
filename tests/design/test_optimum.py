"""The search for an optimum through its inner function, on models in closed form."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pytest import approx

from contbed.many.optimise import constrained_search
from contbed.many.optimise.constrained_search import EvaluationFailed, minimise
from contbed.many.optimise.whole import ENUMERATED, best_choice


class Quadratic:
    """x'Hx/2 + c'x with A x <= b, or = b where `equality` says so; `fails(x)` where
    it cannot be computed.
    """

    def __init__(self, H, c, A, b, low, high, equality=None, fails=None):
        self.H, self.c, self.A, self.b = (
            np.array(part, dtype=float) for part in (H, c, A, b)
        )
        self.A = self.A.reshape(len(self.b), len(self.c))
        self.low, self.high = np.array(low, dtype=float), np.array(high, dtype=float)
        self.equality = (
            np.zeros(len(self.b), bool) if equality is None else np.array(equality)
        )
        self.fails, self.points = fails, []

    def values(self, x):
        self.points.append(x)
        if self.fails is not None and self.fails(x):
            raise EvaluationFailed(f"no value at {x}")
        return np.concatenate(
            [[0.5 * x @ self.H @ x + self.c @ x], self.A @ x - self.b]
        )

    def derivatives(self, x):
        return np.vstack([self.H @ x + self.c, self.A])


# Nocedal and Wright 2006, example 16.4: the solution is (1.4, 1.7), with the first
# constraint active at 0.8
EXAMPLE = (
    [[2, 0], [0, 2]],
    [-2, -5],
    [[-1, 2], [1, 2], [1, -2]],
    [2, 6, 2],
    [0, 0],
    [10, 10],
)


def test_a_quadratic_program_with_known_solution_and_multipliers():
    found = minimise(Quadratic(*EXAMPLE), np.array([2.0, 0.0]))
    assert_allclose(found.x, [1.4, 1.7], atol=1e-9)
    assert_allclose(found.prices, [0.8, 0.0, 0.0], atol=1e-8)
    assert found.converged and list(found.active) == [True, False, False]
    assert found.remarks == ()


@pytest.mark.parametrize("seed", range(8))
def test_random_quadratic_programs_with_scales_far_apart(seed):
    """The solution is chosen with its multipliers; c and b follow from the
    first-order conditions.
    """
    random = np.random.default_rng(seed)
    n, m = 4, 3
    scale = 10.0 ** random.integers(-4, 5, n)
    root = random.normal(size=(n, n))
    H = (root @ root.T + np.eye(n)) / np.outer(scale, scale)
    x = scale * random.uniform(-0.5, 0.5, n)
    A = random.normal(size=(m, n)) / scale * 10.0 ** random.integers(-3, 6, m)[:, None]
    prices = np.array([0.7, 0.3, 0.0]) / np.abs(A * scale).max(axis=1)
    c = -H @ x - A.T @ prices
    b = A @ x + np.array([0.0, 0.0, 0.5]) * np.abs(A * scale).max(axis=1)
    found = minimise(
        Quadratic(H, c, A, b, x - 3.0 * scale, x + 2.0 * scale),
        x + scale * random.uniform(-1, 1, n),
    )
    # f is flat where it is smallest: a search that ends at 1e-8 of its change has x to
    # the root of that
    assert_allclose((found.x - x) / scale, 0.0, atol=1e-3)
    assert_allclose(
        found.prices * np.abs(A * scale).max(axis=1), [0.7, 0.3, 0.0], atol=3e-3
    )
    assert found.converged


def test_prices_are_what_a_change_of_the_constraint_changes():
    H, c, A, b, low, high = EXAMPLE
    found = minimise(Quadratic(*EXAMPLE), np.array([2.0, 0.0]))
    d = 1e-3
    more, less = (
        minimise(Quadratic(H, c, A, [b[0] + s * d, *b[1:]], low, high), found.x).values[
            0
        ]
        for s in (1, -1)
    )
    assert (less - more) / (2.0 * d) == approx(found.prices[0], rel=1e-5)


def test_equalities_and_bounds_have_prices_of_either_sign():
    problem = ([[2, 0], [0, 2]], [-2, -5], [[1, 1]], [1.0], [0, 0], [10, 10], [True])
    found = minimise(Quadratic(*problem), np.array([2.0, 0.0]))
    assert_allclose(found.x, [0.0, 1.0], atol=1e-9)
    # grad f = (-2, -3); + 3 (1, 1) - (1, 0) = 0
    assert_allclose(found.prices, [3.0], atol=1e-8)
    assert_allclose(found.bound_prices, [1.0, 0.0], atol=1e-8)
    # the equality pulls the other way: a smaller right side is dearer
    other = minimise(Quadratic(*problem[:3], [9.0], *problem[4:]), np.array([2.0, 0.0]))
    assert_allclose(other.prices, [-(2.0 * other.x[0] - 2.0)], atol=1e-6)
    assert other.prices[0] < 0.0


def test_bounds_alone():
    found = minimise(Quadratic([[0.0]], [1.0], [], [], [0.5], [2.0]), np.array([1.5]))
    assert found.x[0] == 0.5  # exactly: no rounding stays behind
    assert found.bound_prices[0] == approx(1.0)
    high = minimise(Quadratic([[0.0]], [-3.0], [], [], [0.5], [2.0]), np.array([1.5]))
    assert (high.x[0], high.bound_prices[0]) == (2.0, approx(-3.0))


@pytest.mark.parametrize(
    "bound", [[], [10.0]], ids=["alone", "far from its constraint"]
)
def test_a_smallest_value_inside_of_the_bounds(bound):
    """The gradient is zero there, so that nothing is left to measure what is left of
    it by.
    """
    row = [[1.0, 1.0]] if bound else []
    problem = Quadratic([[2, 0], [0, 2]], [-2, -5], row, bound, [0, 0], [10, 10])
    for start in ([2.0, 0.0], [9.0, 9.0], [1.0, 2.5], [1.0 + 1e-9, 2.5]):
        found = minimise(problem, np.array(start))
        assert_allclose(found.x, [1.0, 2.5], atol=1e-3)
        assert found.converged, start


def test_a_target_is_met_by_the_square_of_what_is_missed():
    """(x - 2)^2 falls to zero itself; a search that begins there again says so too."""
    problem = Quadratic([[2.0]], [-4.0], [], [], [0.5], [3.0])
    problem.values = lambda x: np.array([(x[0] - 2.0) ** 2])
    found = minimise(problem, np.array([1.0]))
    assert found.x[0] == approx(2.0, abs=1e-3) and found.converged


def test_a_failed_point_is_stepped_back_from():
    """The first step leads to (2, 2), where there is no value; the optimum is on
    this side of it.
    """
    problem = Quadratic(*EXAMPLE, fails=lambda x: x[1] > 1.75)
    found = minimise(problem, np.array([2.0, 0.0]))
    assert_allclose(found.x, [1.4, 1.7], atol=1e-6)
    assert found.converged and found.remarks
    assert all(remark.startswith("stepped back") for remark in found.remarks)


def test_an_optimum_that_cannot_be_computed_is_not_claimed():
    problem = Quadratic(*EXAMPLE, fails=lambda x: x[1] > 1.5)
    found = minimise(problem, np.array([2.0, 0.0]))
    assert not found.converged and found.feasible
    assert found.values[0] < -4.0  # better than the start, at 0
    with pytest.raises(EvaluationFailed):
        minimise(Quadratic(*EXAMPLE, fails=lambda x: True), np.array([2.0, 0.0]))


def test_constraints_that_cannot_hold_end_where_they_are_missed_least():
    found = minimise(
        Quadratic([[2, 0], [0, 2]], [-2, -5], [[-1, -1]], [-30], [0, 0], [10, 10]),
        np.array([2.0, 0.0]),
    )
    assert not found.feasible and not found.converged
    # 30 asked for, 20 at the corner of the bounds
    assert found.values[1] == approx(10.0)


def test_a_start_that_misses_constraints_is_led_back():
    # a curved constraint with the start far outside of it
    class Circle(Quadratic):
        def values(self, x):
            return np.array([x[0] + x[1], x @ x - 2.0])

        def derivatives(self, x):
            return np.array([[1.0, 1.0], 2.0 * x])

    found = minimise(
        Circle(np.eye(2), [0, 0], [[0, 0]], [0], [-3, -3], [3, 3]),
        np.array([2.5, -2.8]),
    )
    assert_allclose(found.x, [-1.0, -1.0], atol=1e-5)
    assert found.prices[0] == approx(0.5, abs=1e-5)


def test_each_point_is_computed_once():
    problem = Quadratic(*EXAMPLE, fails=lambda x: x[1] > 1.75)
    minimise(problem, np.array([2.0, 0.0]))
    points = {point.tobytes() for point in problem.points}
    assert len(problem.points) - len(points) <= 1  # the start stands by itself


def whole_quadratic(a, b):
    """(x - 0.3 i - 0.2 j)^2 + (i - a)^2 + (j - b)^2 with whole i, j: smallest at the
    whole numbers next to (a, b).
    """

    def search(choice, near):
        i, j = choice
        problem = Quadratic([[2.0]], [-2.0 * (0.3 * i + 0.2 * j)], [], [], [-10], [10])
        found = minimise(problem, np.array([0.0]) if near is None else near.x)
        constant = (0.3 * i + 0.2 * j) ** 2 + (i - a) ** 2 + (j - b) ** 2
        return constrained_search.Optimum(
            **{**vars(found), "values": found.values + constant}
        )

    return search


@pytest.mark.parametrize("high", [3, 30])
def test_whole_numbers_by_all_choices_or_by_neighbours(high):
    best = best_choice([(0, high), (0, high)], (0, 0), whole_quadratic(2.4, 1.7))
    assert best.choice == (2, 2)
    assert best.optimum.x[0] == approx(1.0, abs=1e-6)
    assert best.complete == ((high + 1) ** 2 <= ENUMERATED)
    assert best.tried == (high + 1) ** 2 if best.complete else best.tried < 40


def test_choices_without_a_run_are_left_out():
    search = whole_quadratic(2.0, 2.0)
    best = best_choice(
        [(0, 3), (0, 3)],
        (0, 0),
        lambda choice, near: None if choice == (2, 2) else search(choice, near),
    )
    assert best.choice in {(1, 2), (2, 1), (3, 2), (2, 3)}
    assert best_choice([(0, 1)], (0,), lambda choice, near: None) is None
