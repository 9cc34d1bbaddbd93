"""Orders of convergence on manufactured solutions: one line a case.

Temperatures and incident radiation of degree k converge at k + 1 in L2, Taylor-Hood
velocity at 3 and pressure at 2, with and without SUPG. The observed order between the
two meshes may miss its value by 0.1, the share of higher-order terms on these meshes.
"""

import tomllib
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from manufactured_cases import Flow, Heat, Radiating

from contbed.solvers.linear import Policy
from studies._exact.manufactured import jet, observed_order

TOLERANCE = 0.1
KINDS = {"Heat": Heat, "Radiating": Radiating, "Flow": Flow}
TABLES = tomllib.loads(Path(__file__).with_name("mms.toml").read_text(encoding="utf-8"))
PARAMETERS = [
    *TABLES["cases"],
    *(pytest.param(name, marks=pytest.mark.slow) for name in TABLES["slow"]),
]


@pytest.mark.parametrize("name", PARAMETERS)
def test_order(name: str) -> None:
    values: dict[str, Any] = dict((TABLES["cases"] | TABLES["slow"])[name])
    case, errors = KINDS[values.pop("of")](**values), []
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
