"""Recorded forms against dual numbers: any expression, branches that change with the
state, meshes, what is refused.
"""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from skfem import MeshLine, MeshQuad
from test_dual import EXPRESSION, evaluate

from contbed.fem.ad.batched import Program, RecordedForms
from contbed.fem.ad.dual import Components, Dual
from contbed.fem.ad.graph import Field, Graph, Node, NotRecordableError
from contbed.fem.ad.plan import planned, structure
from contbed.fem.skfem import System

POINTS = 70  # more than are differentiated together


def recorded(function: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """The function as a program: of two arrays its value and its derivatives to
    both.
    """
    graph = Graph()
    result = function(*(Field(graph, "slot", name, 0) for name in "xy"))
    program = Program(graph, [graph.leaf(result).place], (1, POINTS))

    def evaluated(x: Any, y: Any) -> Any:
        at = {"x": x, "y": y}
        value = program.values(
            np.array([at[name] for name, *_ in program.slots]).reshape(-1, POINTS)
        )[0, 0].copy()
        slopes = program.slopes()
        found = {
            program.slots[slot][0]: slopes[k, 0]
            for k, (_, slot, _) in enumerate(program.derivatives)
        }
        return value, [found.get(name, np.zeros(POINTS)) for name in "xy"]

    return evaluated


def by_dual_numbers(function: Callable[[Any, Any], Any], x: Any, y: Any) -> Any:
    result = function(Dual(x, {"x": 1.0}), Dual(y, {"y": 1.0}))
    return result.value, [
        np.zeros(POINTS) + result.tangents.get(name, 0.0) for name in "xy"
    ]


def compare(
    function: Callable[[Any, Any], Any],
    *states: tuple[Any, Any],
    rounding: float = 1e-13,
) -> None:
    program = recorded(function)
    for x, y in states:
        (value, slopes), (expected, tangents) = (
            program(x, y),
            by_dual_numbers(function, x, y),
        )
        # the same operations; a function may round by its place in an array
        assert_allclose(value, expected, rtol=rounding, atol=0)
        for slope, tangent in zip(slopes, tangents, strict=True):
            assert_allclose(
                slope, tangent, rtol=rounding, atol=rounding * np.abs(tangents).max()
            )


@given(EXPRESSION, st.integers(0, 1000))
def test_any_expression(expression: Any, seed: int) -> None:
    x, y = np.random.default_rng(seed).uniform(-3.0, 3.0, (2, POINTS))
    # sums of derivatives that cancel keep the rounding of their terms, some ten
    # operations deep
    compare(lambda a, b: evaluate(expression, a, b), (x, y), rounding=1e-12)


BRANCHES: dict[str, Callable[[Any, Any], Any]] = {
    "where": lambda x, y: np.where(x > y, x**2 * y, np.sin(y)),
    "minimum": lambda x, y: np.minimum(x * y, 1.0) * x,
    "maximum": lambda x, y: np.maximum(x, y) ** 2,
    "and": lambda x, y: np.where((x > 0.0) & (y > 0.0), x / (1.0 + y * y), y),
    "or": lambda x, y: np.where((x < 0.0) | ~(y <= 1.0), x * x, x * y),
    "abs": lambda x, y: np.abs(x - y) * y,
    "frozen": lambda x, y: x * getattr(x * y, "value", x * y),
    "table": lambda x, y: y * x.apply(np.sinh, np.cosh),
}


@pytest.mark.parametrize("name", BRANCHES)
def test_branches_follow_the_state(name: str) -> None:
    """One recording at states on either side of each branch."""
    rng = np.random.default_rng(3)
    mixed = rng.uniform(-2.0, 2.0, (2, POINTS))
    one_side, other = (
        rng.uniform(*ends, POINTS) for ends in ((1.0, 2.0), (-2.0, -1.0))
    )
    compare(BRANCHES[name], tuple(mixed), (one_side, other), (other, one_side))


def test_forms_with_other_numbers_share_a_plan() -> None:
    """Numbers, arrays and tables are values: each program keeps its own, and is
    right after the other was made.
    """
    weights = np.random.default_rng(4).uniform(1.0, 2.0, (2, 1, POINTS))
    tables = ((np.sinh, np.cosh), (np.sin, np.cos))

    def form(k: int) -> Callable[[Any, Any], Any]:
        return lambda x, y: (
            (2.5 + k) * y.apply(*tables[k])
            + np.where(x > k, x ** (3.0 + k), weights[k, 0] * x * y)
        )

    x, y = np.random.default_rng(5).uniform(0.5, 2.0, (2, POINTS))
    found = [recorded(form(k)) for k in (0, 1)]
    expected = [2.5 * np.cosh(y), 3.5 * np.cos(y)]
    upper = [(x > k) for k in (0, 1)]
    for k in (0, 1):
        value, (to_x, to_y) = found[k](x, y)
        w, power = weights[k, 0], 3.0 + k
        # three operations on top of those of numpy
        assert_allclose(
            to_x, np.where(upper[k], power * x ** (power - 1.0), w * y), rtol=1e-14
        )
        assert_allclose(to_y, expected[k] + np.where(upper[k], 0.0, w * x), rtol=1e-14)
        assert_allclose(
            value,
            (2.5 + k) * tables[k][0](y) + np.where(upper[k], x**power, w * x * y),
            rtol=1e-14,
        )
    assert plan_of(form(0)) is plan_of(form(1))


def test_forms_of_other_operations_have_other_plans() -> None:
    exponents = np.full((1, POINTS), 3.0)
    forms: list[Callable[[Any, Any], Any]] = [
        lambda x, y: x**3.0 * y,
        # has a derivative to its exponent by another rule
        lambda x, y: x**exponents * y,
        lambda x, y: x**3.0 + y,
        lambda x, y: y**3.0 * x,
        lambda x, y: x**1.0 * y,  # is left out
    ]
    assert len({id(plan_of(form)) for form in forms}) == len(forms)


def plan_of(form: Callable[[Any, Any], Any]) -> Any:
    graph = Graph()
    result = form(*(Field(graph, "slot", name, 0) for name in "xy"))
    return planned(structure(graph, [graph.leaf(result).place]))


@pytest.mark.parametrize(
    "function",
    [
        lambda x, y: x if np.any(x > y) else y,
        lambda x, y: x if x > y else y,
        lambda x, y: x * float(y),
        lambda x, y: np.arctan2(x, y),
        lambda x, y: np.asarray(x),
        lambda x, y: np.add.reduce([x, y]),
        lambda x, y: max(x, y),
    ],
)
def test_what_asks_for_values_is_refused(function: Callable[[Any, Any], Any]) -> None:
    with pytest.raises(NotRecordableError, match=r"recorded"):
        recorded(function)


def form(u: SimpleNamespace, v: SimpleNamespace, c: Any, o: Any) -> Any:
    """Convection, stabilisation with second derivatives, a vector, and one number
    for the whole mesh.
    """
    k = 1.0 + np.where(u.T > 0.1, u.T, 0.1) ** 2
    total = (
        k * o.dot(o.grad(u.T), o.grad(v.T))
        + o.low(u.T) * u.mean * v.T
        + c * (u.T - o.x[0]) * v.mean
    )
    total = total + o.h * (o.laplacian(u.T) + u.mean) * o.grad(v.T)[0] * u.T
    if hasattr(u, "u"):
        total = (
            total
            + o.inner(o.grad(u.u), o.grad(v.u))
            + o.dot(u.u, o.grad(u.T)) * v.T
            - o.div(v.u) * u.T
        )
    return total


def edge(u: SimpleNamespace, v: SimpleNamespace, c: Any, o: Any) -> Any:
    return c * np.exp(u.T) * v.T + u.T * u.mean * v.mean


@pytest.mark.parametrize("dim", [1, 2])
@pytest.mark.parametrize("axisymmetric", [False, True])
def test_same_matrices_as_the_assembly(dim: int, axisymmetric: bool) -> None:
    if dim == 1:
        mesh: Any = MeshLine(np.linspace(0.0, 1.0, 6) ** 1.5)
    else:
        mesh = MeshQuad.init_tensor(np.linspace(0.0, 1.0, 4), np.linspace(0.0, 2.0, 4))
        # cells are no rectangles
        mesh = MeshQuad(mesh.p + 0.5 + 0.05 * np.sin(3.0 * mesh.p[::-1]), mesh.t)
    mesh = mesh.with_boundaries(
        {"left": lambda x: x[0] < 0.7 if dim == 2 else x[0] == 0.0}
    )
    fields = {"T": (2, 0), "mean": (0, 0)} | ({"u": (1, 2)} if dim == 2 else {})
    system = System(mesh, fields, 4, axisymmetric=axisymmetric)
    forms = [
        (form, system.cells, 2.0),
        *((edge, where, 0.3) for where in system.boundary("left")),
    ]
    together = RecordedForms(system, forms)
    for seed in range(2):
        state = np.random.default_rng(seed).uniform(-1.0, 1.0, system.size)
        residual, matrix = system.assemble(forms, state)
        found, jacobian = together.assemble(state, True)
        assert_allclose(found, residual, rtol=0, atol=1e-14 * np.abs(residual).max())
        assert jacobian is not None and matrix is not None
        assert abs(jacobian - matrix).max() < 1e-14 * abs(matrix).max()
        assert_array_equal(together.assemble(state, False)[0], found)


def test_constant_results() -> None:
    """A form whose coefficients do not depend on unknowns has a residual and no
    matrix.
    """
    system = System(MeshLine(np.linspace(0.0, 1.0, 4)), {"T": (1, 0)}, 2)
    forms = [
        (lambda u, v, c, o: o.x[0] * v.T - 2.0 * o.grad(v.T)[0], system.cells, None)
    ]
    state = np.ones(system.size)
    residual, matrix = RecordedForms(system, forms).assemble(state, True)
    assert_array_equal(residual, system.assemble(forms, state)[0])
    assert matrix is not None and matrix.nnz == 0


def test_components_take_recorded_factors() -> None:
    graph = Graph()
    x = Field(graph, "slot", "x", 0)
    assert all(item.place == x.place for item in (Components((1.0, 1.0)) * x).items)


def test_a_node_beside_a_dual_number_is_its_value() -> None:
    """As where the flow of a whole bed, recorded for all ranks, is integrated over a
    boundary on rank 0.
    """
    graph = Graph(
        lambda place: graph.values([place], lambda *_: np.array([2.0, 3.0]))[0]
    )
    node, dual = Field(graph, "known", 0), Dual(np.array([5.0, 7.0]), {"T": np.ones(2)})
    assert_array_equal((node * 2.0).value, [4.0, 6.0])
    for found, slope in (
        (node * dual, [2.0, 3.0]),
        (dual * node, [2.0, 3.0]),
        (node + dual - node, [1.0, 1.0]),
    ):
        assert_array_equal(found.tangents["T"], slope)
    assert_array_equal(np.where(node > 2.5, dual, node).value, [2.0, 7.0])
    assert isinstance(node * node.value, Node)
