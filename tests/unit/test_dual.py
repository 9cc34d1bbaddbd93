"""Dual numbers against complex steps, and what they refuse."""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from contbed.fem.ad import dual
from contbed.fem.ad.dual import Dual

STEP = 1e-30
# smooth on all reals and bounded, so that any composition stays finite
UNARY: dict[str, Callable[[Any], Any]] = {
    "negative": lambda a: -a,
    "positive": lambda a: +a,
    "sin": np.sin,
    "cos": np.cos,
    "tanh": np.tanh,
    "arctan": np.arctan,
    "square": lambda a: np.square(np.sin(a)),
    "exp": lambda a: np.exp(np.sin(a)),
    "sqrt": lambda a: np.sqrt(2.0 + np.sin(a)),
    "log": lambda a: np.log(2.0 + np.sin(a)),
    "log10": lambda a: np.log10(2.0 + np.cos(a)),
    "reciprocal": lambda a: np.reciprocal(2.0 + np.cos(a)),
    "power": lambda a: (2.0 + np.sin(a)) ** 1.7,
    "integer_power": lambda a: np.sin(a) ** 3,
    "exponent": lambda a: 1.5 ** np.sin(a),
    "float_power": lambda a: np.float_power(2.0 + np.sin(a), -0.4),
}
BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: np.sin(a) * b,
    "divide": lambda a, b: a / (2.0 + np.sin(b)),
    "power": lambda a, b: (2.0 + np.sin(a)) ** np.cos(b),
    "constant_left": lambda a, b: 3.0 - 2.0 * a / (1.5 + np.cos(b)),
}
POINT = st.floats(-3.0, 3.0)
EXPRESSION: st.SearchStrategy[Any] = st.recursive(
    st.sampled_from(["x", "y"]),
    lambda inner: st.one_of(
        st.tuples(st.sampled_from(sorted(UNARY)), inner),
        st.tuples(st.sampled_from(sorted(BINARY)), inner, inner),
    ),
    max_leaves=8,
)


def evaluate(expression: Any, x: Any, y: Any) -> Any:
    if isinstance(expression, str):
        return x if expression == "x" else y
    name, *arguments = expression
    values = [evaluate(argument, x, y) for argument in arguments]
    return (UNARY if len(values) == 1 else BINARY)[name](*values)


@given(EXPRESSION, POINT, POINT)
def test_derivative_is_the_complex_step(expression: Any, x: float, y: float) -> None:
    at = np.array([x]), np.array([y])
    result = evaluate(expression, Dual(at[0], {"x": 1.0}), Dual(at[1], {"y": 1.0}))
    # the complex step has no truncation error; both sides round some ten times
    close = {"rtol": 1e-12, "atol": 1e-12}
    assert_allclose(result.value, evaluate(expression, *at), **close)
    for slot, shift in (("x", (1j * STEP, 0.0)), ("y", (0.0, 1j * STEP))):
        step = evaluate(expression, at[0] + shift[0], at[1] + shift[1])
        expected = np.imag(step) / STEP * np.ones(1)
        assert_allclose(np.zeros(1) + result.tangents.get(slot, 0.0), expected, **close)


@pytest.mark.parametrize("ufunc", [np.add, np.subtract, np.multiply, np.divide])
@pytest.mark.parametrize("with_tangents", [True, False])
def test_operators_are_those_of_numpys_protocol(
    ufunc: np.ufunc, with_tangents: bool
) -> None:
    """To the bit, for two dual numbers and for one with a number or an array on
    either side.
    """
    operate = {
        np.add: operator.add,
        np.subtract: operator.sub,
        np.multiply: operator.mul,
        np.divide: operator.truediv,
    }
    one = Dual(
        np.array([1.3, -0.2]),
        {"x": 1.0, "y": np.array([0.3, 2.0])} if with_tangents else {},
    )
    two = Dual(
        np.array([0.7, 3.1]), {"y": np.array([1.1, -0.4])} if with_tangents else {}
    )
    array = np.array([0.3, -7.0])
    for pair in (
        (one, two),
        (one, one),
        (one, 0.3),
        (0.3, one),
        (one, 1.0),
        (1, one),
        (one, array),
        (array, one),
    ):
        found, expected = operate[ufunc](*pair), ufunc(*pair)
        assert_array_equal(found.value, expected.value)
        assert found.tangents.keys() == expected.tangents.keys()
        for slot, tangent in expected.tangents.items():
            assert_array_equal(found.tangents[slot], tangent)


def test_a_constant_needs_no_derivative_of_a_table() -> None:
    def derivative(x: Any) -> Any:
        raise AssertionError("the derivative of a constant was asked for")

    assert Dual(np.array([2.0]), {}).apply(np.square, derivative).value == 4.0


def test_every_rule_is_tried() -> None:
    known = set(dual._UNARY) | set(dual._BINARY) | {np.power, np.float_power}
    tried = {getattr(np, name) for name in (*UNARY, *BINARY) if hasattr(np, name)}
    piecewise = {np.abs, np.maximum, np.minimum}
    assert known == tried | piecewise


@pytest.mark.parametrize(
    ("function", "slope"),
    [
        (np.abs, [-1.0, 1.0]),
        (lambda T: np.maximum(T, 0.5), [0.0, 1.0]),
        (lambda T: np.minimum(0.5, T), [1.0, 0.0]),
        (lambda T: np.maximum(3.0 * T, T), [1.0, 3.0]),
        (lambda T: np.where(T > 0.0, 2.0 * T, 5.0), [0.0, 2.0]),
        (lambda T: np.where(T <= 0.0, T, 1.0 + 4.0 * T), [1.0, 4.0]),
        (lambda T: T * (T < 0.0), [1.0, 0.0]),
        (lambda T: np.where(1.0 < 2.0, 3.0 * T, 5.0 * T), [3.0, 3.0]),
        (lambda T: np.where(1.0 > 2.0, 3.0 * T, 5.0 * T), [5.0, 5.0]),
    ],
)
def test_piecewise_functions(
    function: Callable[[Any], Any], slope: list[float]
) -> None:
    T = np.array([-2.0, 2.0])
    result = function(Dual(T, {"T": 1.0}))
    assert_array_equal(result.value, function(T))
    assert_array_equal(result.tangents["T"], slope)


def test_comparisons_are_plain() -> None:
    T = Dual(np.array([-2.0, 2.0]), {"T": 1.0})
    for answer, expected in (
        (T > 0.0, [False, True]),
        (T <= 0.0, [True, False]),
        (T != 2.0, [True, False]),
    ):
        assert isinstance(answer, np.ndarray)
        assert answer.tolist() == expected


def test_table_enters_by_value_and_derivative() -> None:
    result = Dual(np.array([2.0]), {"T": 3.0}).apply(
        lambda T: 3.5 * T, lambda T: 0.25 * T
    )
    assert result.value.tolist() == [7.0]
    assert result.tangents["T"].tolist() == [1.5]


def test_what_has_no_derivative_is_refused() -> None:
    T = Dual(np.array([1.0]), {"T": 1.0})
    with pytest.raises(TypeError, match=r"numpy\.sinh"):
        np.sinh(T)
    with pytest.raises(TypeError):
        np.add.reduce(T)
    with pytest.raises(TypeError):
        np.concatenate([T, T])
