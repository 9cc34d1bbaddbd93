"""Both engines give the same results on the same mesh, on one rank and on two.

They sum the same terms in another order and factor with other pivots, so states differ
by rounding times the condition of the systems, which Newton's last steps reduce: 1e-10
of the largest value of a field is the tolerance, and 1e-12 is usual. Heats are
differences of what streams carry, so they are compared with the largest of them; so is
radiation, of which the top of a bed may keep a thousandth of what goes either way, and
which changes four times as much as T.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from dolfinx_scenes import SCENES

from contbed.loading import from_dict
from contbed.many.derivatives.gradients import gradient
from contbed.runner import run

TOLERANCE = 1e-10


def heats(found, name: str) -> float:
    """The largest heat of a run whose name has `name` [W or J], 1 if there is none."""
    return (
        max(
            (
                abs(float(v))
                for k, v in found.items()
                if k.startswith("qoi.") and name in k
            ),
            default=0.0,
        )
        or 1.0
    )


@pytest.fixture(scope="session")
def expected():
    """Results of the first engine, made when asked for."""
    from dolfinx_program import found

    return cache(lambda name: found(run(from_dict(SCENES[name]))))


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", SCENES)
def test_scene(name: str, ranks: int, results, expected) -> None:
    one, other = (
        expected(name),
        dict(np.load(Path(results("agree", ranks)) / f"{name}.npz")),
    )
    assert one.keys() == other.keys()
    assert any(
        np.ptp(values) > 0 for key, values in one.items() if key.startswith("nodal.")
    )
    for key, values in one.items():
        assert values.shape == other[key].shape, key
        scale, tolerance = np.nanmax(np.abs(values)), TOLERANCE
        if key.startswith("qoi.heat_"):
            scale = heats(one, "qoi.heat_")
        elif key.endswith("_radiation_W"):
            scale, tolerance = heats(one, "_radiation_W"), 4.0 * TOLERANCE
        elif key.startswith("balance.") or key in (
            "qoi.theta_overshoot",
            "qoi.estimated_error",
        ):
            scale = 1.0
        elif key == "qoi.pinch_K":  # a difference of temperatures
            scale = np.nanmax(one["profile.T_solid [K]"])
        elif key == "qoi.pinch_m":  # where a flat curve is least: slopes over bends
            tolerance = 1e3 * TOLERANCE
        elif key.startswith("profile.q_radiation"):  # slopes of G over cells
            scale = scale + 1e-3 * np.nanmax(np.abs(one["profile.G [W/m2]"]))
        np.testing.assert_allclose(
            other[key], values, rtol=0.0, atol=tolerance * scale, err_msg=key
        )


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", ["heat_tetrahedra", "heat_hexahedra"])
def test_multigrid_and_field_split_reach_the_same(
    name: str, ranks: int, results, expected
) -> None:
    """Krylov methods stop at 1e-11 of the right-hand side, Newton at 1e-10 of its
    first residual: 1e-8 of fields.
    """
    one, other = expected(name), np.load(results("iterate", ranks) / f"{name}.npz")
    for key in (key for key in one if key.startswith("nodal.")):
        assert np.abs(one[key] - other[key]).max() <= 1e-8 * np.abs(one[key]).max(), key
    assert abs(float(other["balance.energy"])) <= 1e-10


@pytest.mark.parametrize("ranks", [1, 2])
def test_derivatives_are_those_of_the_tangent(ranks: int, results) -> None:
    """Differences of runs at two distances err by 1e-12 of the cube of a step of
    1e-3; Newton leaves 1e-10/1e-3.
    """
    name, qoi = "heat_constant", "T_fluid_out_K"
    keys = [
        "packed_bed.porosity",
        "solids.particles.diameter",
        "boundary.left.gas.fixed_temperature",
        "boundary.bottom.gas.coefficient",
    ]
    exact = gradient(from_dict(SCENES[name]), [qoi], keys)
    found = np.load(Path(results("slopes", ranks, name, qoi, *keys)) / "slopes.npz")
    assert exact.method == "tangent" and found["method"] == "differences"
    scale = np.abs(exact.derivatives * exact.at).max()
    assert np.all(np.abs(exact.derivatives * exact.at) > 1e-4 * scale)
    np.testing.assert_allclose(
        found["derivatives"] * exact.at,
        exact.derivatives * exact.at,
        rtol=0,
        atol=1e-6 * scale,
    )
