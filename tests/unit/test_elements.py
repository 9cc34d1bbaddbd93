"""Nodal elements: basis functions are one at their node and zero at the others, and
constants have no gradient.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from skfem.refdom import RefHex, RefLine, RefQuad, RefTet, RefTri

import contbed as cb
from contbed.fem.elements import Lagrange
from tests.balances import assert_closed

SHAPES = [
    (shape, degree)
    for shape in (RefLine, RefTri, RefQuad, RefTet, RefHex)
    for degree in (1, 2, 3)
]


@pytest.mark.parametrize(
    ("shape", "degree"), [one for one in SHAPES if one != (RefHex, 3)]
)
def test_basis_is_nodal_and_constants_have_no_gradient(shape, degree):
    element = Lagrange(shape, degree)
    # nodes at thirds are rounded, and coefficients of squares are up to 500 in size
    np.testing.assert_allclose(
        element.table(element.nodes.T), np.eye(len(element.nodes)), rtol=0.0, atol=1e-13
    )
    points = np.random.default_rng(1).random((element.dim, 40))
    for axis in range(element.dim):
        for axes in ((axis,), (axis, axis)):
            # rounding of the smallest derivative; of the largest it is 4e-15
            assert (
                max(abs(math.fsum(column)) for column in element.table(points, *axes).T)
                <= 2e-16
            )


def test_balance_of_many_thin_cells_closes():
    """3000 cells of third degree, the first of 1e-7 m: the gradients of 300 K in
    each add up to 1e-10 of the heat.
    """
    scene = cb.load(
        "studies/nakayama_2001/hot_fluid.toml",
        {
            "boundary.left.gas.fixed_temperature": 280.0,
            "solids.particles.conductivity": 2.6,
        },
    )
    assert_closed(cb.run(scene), 5e-11, "energy")
