"""Orders of convergence on manufactured solutions: one line a case.

Temperatures and incident radiation of degree k converge at k + 1 in L2, Taylor-Hood
velocity at 3 and pressure at 2, with and without SUPG. The observed order between the
two meshes may miss its value by 0.1, the share of higher-order terms on these meshes.
"""

from functools import partial
from typing import Any

import numpy as np
import pytest
from manufactured_cases import Flow, Heat, Radiating

from contbed.solvers.linear import Policy
from studies._exact.manufactured import jet, observed_order

TOLERANCE = 0.1
CASES: dict[str, Any] = {
    "line_1": Heat("line", (16, 32), 1),
    "line_2": Heat("line", (16, 32), 2),
    "line_3": Heat("line", (16, 32), 3),
    "triangle_1": Heat("triangle", (16, 32), 1),
    "triangle_2": Heat("triangle", (16, 32), 2),
    "triangle_3": Heat("triangle", (8, 16), 3),
    "triangle_2_without_supg": Heat("triangle", (16, 32), 2, stabilised=False),
    "triangle_2_convective": Heat("triangle", (32, 64), 2, conductivity=1e-3),
    "triangle_2_computed_velocity": Heat("triangle", (16, 32), 2, computed=True),
    "triangle_2_nonlinear": Heat("triangle", (16, 32), 2, nonlinear=True),
    "triangle_2_axisymmetric": Heat("triangle", (16, 32), 2, axisymmetric=True),
    "quadrilateral_1": Heat("quadrilateral", (16, 32), 1),
    "quadrilateral_2": Heat("quadrilateral", (16, 32), 2),
    "quadrilateral_3": Heat("quadrilateral", (8, 16), 3),
    "quadrilateral_2_without_supg": Heat(
        "quadrilateral", (16, 32), 2, stabilised=False
    ),
    "quadrilateral_2_computed_velocity": Heat(
        "quadrilateral", (16, 32), 2, computed=True
    ),
    "quadrilateral_2_nonlinear": Heat("quadrilateral", (16, 32), 2, nonlinear=True),
    "quadrilateral_2_axisymmetric": Heat(
        "quadrilateral", (16, 32), 2, axisymmetric=True
    ),
    "tetrahedron_1": Heat("tetrahedron", (6, 12), 1),
    "tetrahedron_2": Heat("tetrahedron", (3, 6), 2),
    "tetrahedron_3": Heat("tetrahedron", (2, 4), 3),
    "tetrahedron_2_without_supg": Heat("tetrahedron", (4, 8), 2, stabilised=False),
    "hexahedron_1": Heat("hexahedron", (4, 8), 1),
    "hexahedron_2": Heat("hexahedron", (4, 8), 2),
    "radiating_triangle_1": Radiating("triangle", (16, 32), 1),
    "radiating_triangle_2": Radiating("triangle", (8, 16), 2),
    "radiating_triangle_2_without_supg": Radiating(
        "triangle", (8, 16), 2, stabilised=False
    ),
    "radiating_triangle_2_axisymmetric": Radiating(
        "triangle", (8, 16), 2, axisymmetric=True
    ),
    "radiating_quadrilateral_1": Radiating("quadrilateral", (16, 32), 1),
    "radiating_quadrilateral_2": Radiating("quadrilateral", (8, 16), 2),
    "radiating_quadrilateral_2_axisymmetric": Radiating(
        "quadrilateral", (8, 16), 2, axisymmetric=True
    ),
    "radiating_tetrahedron_1": Radiating("tetrahedron", (7, 13), 1),
    "flow_triangle": Flow("triangle", (8, 16)),
    "flow_quadrilateral": Flow("quadrilateral", (8, 16)),
    "flow_triangle_axisymmetric": Flow("triangle", (8, 16), axisymmetric=True),
    "flow_quadrilateral_axisymmetric": Flow(
        "quadrilateral", (8, 16), axisymmetric=True
    ),
    "flow_tetrahedron": Flow("tetrahedron", (3, 6)),
    "flow_hexahedron": Flow("hexahedron", (3, 6)),
}
SLOW = {
    "radiating_tetrahedron_2": Radiating("tetrahedron", (5, 9), 2),
    "finer_tetrahedron_1": Heat("tetrahedron", (12, 20), 1),
    "finer_tetrahedron_2": Heat("tetrahedron", (6, 10), 2),
    "finer_tetrahedron_3": Heat("tetrahedron", (4, 6), 3),
    "finer_radiating_tetrahedron_1": Radiating("tetrahedron", (12, 20), 1),
    "finer_radiating_tetrahedron_2": Radiating("tetrahedron", (6, 10), 2),
    "finer_tetrahedron_flow": Flow("tetrahedron", (4, 8)),
}
PARAMETERS = [*CASES, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)]


@pytest.mark.parametrize("name", PARAMETERS)
def test_order(name: str) -> None:
    case, errors = (CASES | SLOW)[name], []
    for n in case.sizes:
        manufactured, fixed = case.manufactured(n)
        state = manufactured.solve(
            fixed, Policy(manufactured.system.mesh.dim()), linear=case.linear
        )
        errors.append(manufactured.errors(state))
    for field, expected in case.expected.items():
        order = observed_order([e[field] for e in errors], 1.0 / np.array(case.sizes))[
            -1
        ]
        assert order == pytest.approx(expected, abs=TOLERANCE), field


def test_observed_order_of_a_power() -> None:
    sizes = np.array([0.5, 0.2, 0.05])
    # round-off
    assert observed_order(3.0 * sizes**2.5, sizes) == pytest.approx(
        [2.5, 2.5], rel=1e-12
    )


def test_jet_of_a_polynomial() -> None:
    x, y = np.array([0.3, -0.7]), np.array([1.1, 0.4])
    value, (along_x, along_y) = jet(lambda x, y: x**3 * y + y**2, (x, y))
    close = partial(np.testing.assert_allclose, rtol=1e-14)  # a few roundings
    close(value.value, x**3 * y + y**2)
    close(along_x.value, 3 * x**2 * y)
    close(along_y.value, x**3 + 2 * y)
    close([along_x.tangents[0], along_x.tangents[1]], [6 * x * y, 3 * x**2])
    close(
        [along_y.tangents[0], along_y.tangents[1] * np.ones(2)],
        [3 * x**2, np.full(2, 2.0)],
    )
