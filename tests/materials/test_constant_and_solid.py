"""Constants stay floats; polynomials of solids and their integrals."""

import dataclasses
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from contbed.errors import SceneError
from contbed.materials import ConstantFluid, Solid
from tests.cases import each_case

T = np.linspace(300.0, 1200.0, 10)


def test_constants_stay_floats():
    fluid = ConstantFluid(
        density=1.2, heat_capacity=1005, viscosity=1.8e-5, conductivity=0.026
    )
    solid = Solid(2600.0, 850, (1.5,))
    for material, methods in (
        (fluid, ("density", "heat_capacity", "viscosity", "conductivity")),
        (solid, ("density", "heat_capacity", "conductivity")),
    ):
        assert material.constant
        assert material.T_range == (0.0, math.inf)
        for name in methods:
            assert type(getattr(material, name)(T)) is float
    assert fluid.viscosity(T) == 1.8e-5
    assert solid.conductivity(T) == 1.5
    assert_allclose(np.diff(fluid.enthalpy(T)), 100.0 * 1005.0, rtol=1e-12)
    assert_allclose(np.diff(solid.enthalpy(T)), 100.0 * 850.0, rtol=1e-12)


def test_materials_are_frozen_values():
    fluid = ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026)
    assert fluid == ConstantFluid(1.2, 1005.0, 1.8e-5, 0.026)
    with pytest.raises(dataclasses.FrozenInstanceError):
        fluid.name = "other"


def test_polynomial_solid():
    solid = Solid(
        (2600.0, -0.1),
        (700.0, 0.5, -1e-4),
        (2.0, 1e-3, 0.0),
        T_range=(300.0, 1200.0),
        name="sand",
    )
    assert not solid.constant
    assert_allclose(solid.density(T), 2600.0 - 0.1 * T, rtol=1e-14)
    assert_allclose(solid.heat_capacity(T), 700.0 + 0.5 * T - 1e-4 * T**2, rtol=1e-14)
    assert_allclose(solid.conductivity(T), 2.0 + 1e-3 * T, rtol=1e-14)
    assert_allclose(
        solid.enthalpy(T + 1e-20j).imag / 1e-20, solid.heat_capacity(T), rtol=1e-14
    )
    assert solid.share_outside(np.array([300.0, 1200.0, 500.0, np.nan])) == 0.25
    assert solid.share_outside(np.array([])) == 0.0


def test_mixed_solid_keeps_its_constants():
    solid = Solid(2600.0, (700.0, 0.5), 1.5)
    assert not solid.constant
    assert type(solid.density(T)) is float


@each_case(__file__, "mistakes_are_told")
def test_mistakes_are_told(arguments, words):
    given = {"density": 2600.0, "heat_capacity": 850.0, "conductivity": 1.5} | arguments
    with pytest.raises(SceneError) as caught:
        Solid(**given)
    for word in words:
        assert word in str(caught.value)
    if not isinstance(next(iter(arguments.values())), list):
        with pytest.raises(SceneError):
            ConstantFluid(**given, viscosity=1e-5)
