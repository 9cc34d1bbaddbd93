"""Every property of every material carries the exact derivative through a dual
number.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from contbed.fem.ad.dual import Dual
from contbed.materials import ConstantFluid, Solid, gas_mixture, pointwise, real_fluid

METHODS = ("density", "heat_capacity", "enthalpy", "viscosity", "conductivity")
MATERIALS = {
    "constant": lambda: ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026),
    "solid": lambda: Solid((2600.0, -0.1), (700.0, 0.5, -1e-4), (2.0, 1e-3)),
    "pure gas": lambda: gas_mixture("H2O", 1e5),
    "syngas": lambda: gas_mixture(
        "CO:0.2, CO2:0.1, H2:0.2, H2O:0.1, CH4:0.05, N2:0.35", 1e5
    ),
    "CO2": lambda: real_fluid("CO2", 1e5, (300.0, 1500.0)),
    "water": lambda: real_fluid("Water", 200e5, (300.0, 600.0)),
}


@pytest.fixture(scope="module", params=MATERIALS)
def material(request):
    return MATERIALS[request.param]()


@pytest.mark.parametrize("method", METHODS)
def test_dual_number(material, method):
    """Against sixth-order central differences with a step of 0.5 K: their truncation
    and round-off stay below 1e-9.
    """
    if method == "viscosity" and isinstance(material, Solid):
        return
    f = getattr(material, method)
    # away from 1000 K, where gas heat capacity has a kink
    T = np.array([[310.3, 420.7, 505.1], [555.5, 580.2, 590.9]])
    scale = np.array([[1.0, 2.0, -1.0], [0.5, 3.0, 1.0]])
    result = f(Dual(T, {"T": scale}))
    if isinstance(result, float):
        assert material.constant
        return
    assert_allclose(result.value, f(T), rtol=1e-15)
    h = 0.5
    slope = sum(
        c * (f(T + n * h) - f(T - n * h)) for n, c in ((1, 45.0), (2, -9.0), (3, 1.0))
    ) / (60.0 * h)
    assert_allclose(
        result.tangents["T"],
        slope * scale,
        rtol=2e-7,
        atol=1e-9 * np.max(np.abs(slope)),
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["pure gas", "syngas"])
def test_gas_by_complex_step(name, method):
    """Exact to round-off, on both sides of the mid temperature."""
    f = getattr(MATERIALS[name](), method)
    T = np.linspace(300.0, 2999.0, 28)
    result = f(Dual(T, {"T": np.ones_like(T)}))
    slope = f(T + 1e-20j).imag / 1e-20
    assert_allclose(
        result.tangents["T"], slope, rtol=1e-12, atol=1e-14 * np.max(np.abs(slope))
    )


def test_share_outside_takes_dual_numbers(material):
    T = np.array([400.0, 1e5])
    assert material.share_outside(Dual(T, {"T": np.ones(2)})) == material.share_outside(
        T
    )


def test_pointwise():
    T = np.array([1.0, 2.0])
    assert_array_equal(pointwise(np.square, np.exp, T), [1.0, 4.0])
    result = pointwise(np.sin, np.cos, Dual(T, {"T": np.array([2.0, 3.0])}))
    assert_array_equal(result.value, np.sin(T))
    assert_array_equal(result.tangents["T"], np.cos(T) * [2.0, 3.0])
