"""Elements, geometry, assembly and derivatives of the engine, on irregular meshes of
every cell shape.
"""

from typing import Any

import numpy as np
import pytest
import skfem
from numpy.testing import assert_allclose, assert_array_equal
from skfem.helpers import dot, grad

from contbed.fem.ad.dual import Components, Dual
from contbed.fem.skfem import Domain, Ops, System
from studies._exact.manufactured import Manufactured, exact
from tests.refusals import refused

KINDS = {
    "line": skfem.MeshLine,
    "triangle": skfem.MeshTri,
    "quadrilateral": skfem.MeshQuad,
    "tetrahedron": skfem.MeshTet,
    "hexahedron": skfem.MeshHex,
}
DEGREES = {
    "line": 3,
    "triangle": 3,
    "quadrilateral": 3,
    "tetrahedron": 3,
    "hexahedron": 2,
}
SPACES = [
    (shape, degree)
    for shape, highest in DEGREES.items()
    for degree in range(1, highest + 1)
]
# sums of some hundred terms of order one, and second derivatives of cells of size 0.3
ROUNDOFF = 1e-12


def mesh(shape: str) -> skfem.Mesh:
    """The unit interval, square or cube in two to four cells a side, its inner nodes
    displaced and all renumbered.
    """
    kind = KINDS[shape]
    dim = kind.elem.refdom.dim()
    made = kind.init_tensor(*[np.linspace(0.0, 1.0, 5 - dim + 1)] * dim)
    random = np.random.default_rng(3)
    inner = ((made.p > 1e-9) & (made.p < 1 - 1e-9)).all(axis=0)
    x = made.p + inner * random.uniform(-0.06, 0.06, made.p.shape)
    place = random.permutation(made.nvertices)
    p = np.empty_like(x)
    p[:, place] = x
    m = kind(p, place[made.t])
    return m.with_boundaries(
        {"all": m.boundary_facets(), "right": lambda x: x[0] > 1 - 1e-9}
    )


def polynomial(degree: int) -> Any:
    """Of this total degree, with a term for each coordinate."""
    return lambda *x: (
        0.3 + sum((k + 1) * x_k for k, x_k in enumerate(x)) ** degree + 0.7 * x[-1]
    )


@pytest.mark.parametrize(("shape", "degree"), SPACES)
def test_polynomials_are_reproduced(shape: str, degree: int) -> None:
    system = System(mesh(shape), {"T": (degree, 0)}, 2 * degree)
    function = polynomial(degree)
    known = exact(function, system.mesh, system.cells)
    size = sum(range(1, system.mesh.dim() + 1)) ** degree

    def defect(unknowns: Any, o: Ops) -> Any:
        value = unknowns.T - known
        slope, curvature = (
            o.grad(unknowns.T) - o.grad(known),
            o.hess(unknowns.T) - o.hess(known),
        )
        return (
            value**2
            + o.dot(slope, slope)
            + o.inner(curvature, curvature)
            + (o.low(unknowns.T) - o.low(known)) ** 2
        )

    state = Manufactured(system, {"T": function}, []).interpolant()
    # second derivatives of degree 3 on cells of size 1/4 lose two further digits
    assert (
        system.integrate(defect, [system.cells], state) ** 0.5 <= 100 * ROUNDOFF * size
    )


def test_linear_field_has_no_second_derivative_on_a_distorted_quadrilateral() -> None:
    p = np.array([[0.0, 2.0, 1.6, 0.3], [0.0, 0.4, 1.9, 0.8]])
    system = System(skfem.MeshQuad(p, np.array([[0], [1], [2], [3]])), {"T": (2, 0)}, 4)
    x, y = system.fields["T"][0].points
    curvature = system.integrate(
        lambda u, o: o.inner(o.hess(u.T), o.hess(u.T)),
        [system.cells],
        1.0 + 2.0 * x - 3.0 * y,
    )
    assert curvature <= ROUNDOFF**2


@pytest.mark.parametrize("axisymmetric", [False, True])
@pytest.mark.parametrize("shape", KINDS)
def test_divergence_theorem(shape: str, axisymmetric: bool) -> None:
    m = mesh(shape)
    if axisymmetric and m.dim() != 2:
        return
    system = System(m, {"u": (2, m.dim())}, 5, axisymmetric=axisymmetric)
    state = np.random.default_rng(5).uniform(-1.0, 1.0, system.size)
    inside = system.integrate(lambda u, o: o.div(u.u), [system.cells], state)
    through = system.integrate(
        lambda u, o: o.dot(u.u, o.n), system.boundary("all"), state
    )
    assert inside == pytest.approx(through, abs=ROUNDOFF * 2 * np.pi)


@pytest.mark.parametrize("shape", KINDS)
def test_measures(shape: str) -> None:
    m = mesh(shape)
    system = System(m, {}, 3, section=2.5)
    sides = 2 * m.dim()
    assert system.integrate(
        lambda u, o: 1.0, [system.cells], np.empty(0)
    ) == pytest.approx(2.5, rel=ROUNDOFF)
    around = system.integrate(lambda u, o: 1.0, system.boundary("all"), np.empty(0))
    assert around == pytest.approx(2.5 * sides, rel=ROUNDOFF)


def everything(unknowns: Any, tests: Any, c: Any, o: Ops) -> Any:
    """A form that is nonlinear in every slot of its unknowns."""
    T, u, v, w = unknowns.T, unknowns.u, tests.T, tests.u
    total = (
        np.sqrt(1.0 + T * T) * o.dot(o.grad(T), o.grad(v))
        + o.low(T) ** 2 * np.exp(-T) * v
    )
    total = (
        total + o.laplacian(T) * o.dot(u, o.grad(v)) + o.dot(o.mul(o.hess(T), u), u) * v
    )
    convection = o.dot(o.mul(o.grad(u), u), w) + o.dot(
        o.mul(o.transpose(o.grad(u)), u), w
    )
    return (
        total
        + convection
        + T**1.5 * o.div(u) * o.div(w)
        + np.where(T > 1.5, T**3, 2.25 * T) * w[0]
    )


@pytest.mark.parametrize(("shape", "degree"), SPACES)
def test_jacobian(shape: str, degree: int) -> None:
    m = mesh(shape)
    system = System(
        m, {"T": (degree, 0), "u": (1, m.dim())}, 4, axisymmetric=shape == "triangle"
    )
    random = np.random.default_rng(11)
    state, direction = (
        random.uniform(1.0, 2.0, system.size),
        random.uniform(-1.0, 1.0, system.size),
    )
    forms = [(everything, system.cells, None)]
    forms += [
        (lambda u, t, c, o: np.exp(u.T) * o.dot(u.u, o.n) * t.T, part, None)
        for part in system.boundary("right")
    ]
    slope = system.assemble(forms, state)[1] @ direction
    h = 1e-6
    ahead, behind = (
        system.assemble(forms, state + s * direction, False)[0] for s in (h, -h)
    )
    # central differences: h^2 of truncation and 1e-16/h of round-off
    assert (
        np.abs((ahead - behind) / (2 * h) - slope).max() <= 1e-8 * np.abs(slope).max()
    )


@pytest.mark.parametrize(
    ("shape", "element"),
    [
        ("line", skfem.ElementLineP1()),
        ("line", skfem.ElementLineP2()),
        ("triangle", skfem.ElementTriP1()),
        ("triangle", skfem.ElementTriP2()),
        ("quadrilateral", skfem.ElementQuad1()),
        ("quadrilateral", skfem.ElementQuad2()),
        ("tetrahedron", skfem.ElementTetP1()),
        ("tetrahedron", skfem.ElementTetP2()),
        ("hexahedron", skfem.ElementHex1()),
        ("hexahedron", skfem.ElementHex2()),
    ],
)
def test_matrix_equals_scikit_fem(shape: str, element: skfem.Element) -> None:
    m = mesh(shape)
    degree = 1 if len(element.doflocs) == m.elem.refdom.nnodes else 2
    system = System(m, {"T": (degree, 0)}, 5)
    matrix = system.assemble(
        [
            (
                lambda u, t, c, o: o.dot(o.grad(u.T), o.grad(t.T)) + u.T * t.T,
                system.cells,
                None,
            )
        ],
        np.zeros(system.size),
    )[1]
    basis = skfem.Basis(m, element, intorder=5)
    expected = skfem.BilinearForm(
        lambda u, v, w: dot(grad(u), grad(v)) + u * v
    ).assemble(basis)
    assert matrix is not None
    # the same sums in another order
    assert abs(matrix - expected).max() <= 1e-13 * abs(expected).max()


@pytest.mark.parametrize(("shape", "degree"), SPACES)
def test_nodes_on_a_boundary(shape: str, degree: int) -> None:
    m = mesh(shape)
    system = System(m, {"u": (degree, m.dim())}, 2)
    last = m.dim() - 1
    x = system.fields["u"][0].points
    expected = np.flatnonzero(x[0] > 1 - 1e-9) + system.offset["u", last]
    assert_array_equal(system.nodes("u", m.boundaries["right"], last), expected)


@pytest.mark.parametrize("shape", KINDS)
def test_length_is_the_longest_edge(shape: str) -> None:
    m = mesh(shape)
    found = Domain(m, 2).h[:, 0]
    edges = m.t if m.dim() == 1 else (m.facets if m.dim() == 2 else m.edges)
    of_cell = (
        np.zeros((1, m.nelements), dtype=int)
        if m.dim() == 1
        else (m.t2f if m.dim() == 2 else m.t2e)
    )
    lengths = np.linalg.norm(m.p[:, edges[0]] - m.p[:, edges[1]], axis=0)
    expected = lengths if m.dim() == 1 else lengths[of_cell].max(axis=0)
    assert_allclose(found, expected, rtol=1e-14)


def test_cubic_hexahedra_are_refused() -> None:
    refused("hexahedra", lambda: System(mesh("hexahedron"), {"T": (3, 0)}, 4))


def test_repeated_assembly_is_the_same() -> None:
    system = System(mesh("triangle"), {"T": (2, 0), "u": (1, 2)}, 4)
    state = np.random.default_rng(1).uniform(1.0, 2.0, system.size)
    first, second = (
        system.assemble([(everything, system.cells, None)], state)[1] for _ in range(2)
    )
    assert first is not None and second is not None
    assert (first != second).nnz == 0


def test_products_of_vectors_and_matrices() -> None:
    A, B = (
        np.array([[1.0, 2.0, -1.0], [0.5, 3.0, 4.0], [2.0, 0.0, 7.0]]),
        np.arange(9.0).reshape(3, 3),
    )
    a, b = (Components(Components(row) for row in matrix) for matrix in (A, B))
    assert list(Ops.mul(a, b[1])) == list(A @ B[1])
    assert [list(row) for row in Ops.transpose(a)] == A.T.tolist()
    assert Ops.inner(a, b) == np.sum(A * B)
    assert Ops.inner(a[0], b[1]) == Ops.dot(a[0], b[1]) == A[0] @ B[1]


def test_tests_may_be_added_to_zero() -> None:
    system = System(mesh("line"), {"T": (1, 0)}, 2)

    def assembled(form: Any) -> Any:
        return system.assemble(
            [(form, system.cells, None)], np.zeros(system.size), False
        )[0]

    expected = assembled(lambda u, t, c, o: 2.0 * t.T)
    for form in (
        lambda u, t, c, o: 0 + 2.0 * t.T,
        lambda u, t, c, o: 0.0 - (-t.T) / 0.5,
    ):
        assert_array_equal(assembled(form), expected)
    assert not assembled(lambda u, t, c, o: 0.0).any()


def test_form_must_be_linear_in_its_tests() -> None:
    system = System(mesh("line"), {"T": (1, 0)}, 2)
    for form in (
        lambda u, t, c, o: t.T * t.T,
        lambda u, t, c, o: t.T + 1.0,
        lambda u, t, c, o: np.exp(t.T),
    ):
        with pytest.raises(TypeError, match="linear in its test functions"):
            system.assemble([(form, system.cells, None)], np.zeros(system.size))


def test_components() -> None:
    a, b = Components([1.0, 2.0]), Components([3.0, np.array([5.0, 6.0])])
    T = Dual(np.array([2.0, 3.0]), {"T": 1.0})
    assert_array_equal((a + b)[1], [7.0, 8.0])
    assert_array_equal((-(b - a) / 2.0)[1], [-1.5, -2.0])
    assert_array_equal((T * b)[1].value, [10.0, 18.0])
    assert_array_equal((b * T)[1].tangents["T"], [5.0, 6.0])
    assert_array_equal((np.array([2.0, 3.0]) * b)[1], [10.0, 18.0])
