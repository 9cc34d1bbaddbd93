"""Properties as tables over temperature and latent heat: exact integrals."""

import numpy as np
import pytest
from pytest import approx

from contbed.fem.ad.dual import Dual
from contbed.materials import Solid
from contbed.materials.curve import Curve, LatentHeat, integral_of
from contbed.scene.property_table import HeatCapacityTable

T = np.linspace(200.0, 1000.0, 801)
TABLE = HeatCapacityTable(
    temperatures=(293.15, 573.15, 873.15), values=(790.0, 1000.0, 1100.0)
)
LATENT = LatentHeat(178e3, 576.0, 582.0)


def test_a_table_is_linear_between_its_temperatures_and_constant_beyond():
    curve = Curve(TABLE.temperatures, TABLE.values)
    assert curve(433.15) == approx(895.0, rel=1e-15)
    assert curve(100.0) == 790.0
    assert curve(2000.0) == 1100.0


def test_the_enthalpy_of_a_table_is_the_area_below_it():
    content = integral_of(TABLE)
    whole = 0.5 * (790.0 + 1000.0) * 280.0 + 0.5 * (1000.0 + 1100.0) * 300.0
    assert content(873.15) - content(293.15) == approx(whole, rel=1e-14)
    assert content(0.0) == 0.0
    assert content(900.0) - content(873.15) == approx(1100.0 * 26.85, rel=1e-12)
    middle = 0.5 * (790.0 + 895.0) * 140.0
    assert content(433.15) - content(293.15) == approx(middle, rel=1e-13)
    assert integral_of(TABLE, start=293.15)(433.15) == approx(middle, rel=1e-13)


def test_latent_heat_is_taken_up_whole_and_smoothly():
    assert LATENT.enthalpy(576.0) == 0.0
    assert LATENT.enthalpy(582.0) == 178e3
    assert LATENT.enthalpy(579.0) == approx(89e3, rel=1e-14)
    h = 1e-3
    between = np.linspace(576.1, 581.9, 59)
    for value, slope in (
        (LATENT.enthalpy, LATENT.heat_capacity),
        (LATENT.heat_capacity, LATENT._slope),
    ):
        found = (value(between + h) - value(between - h)) / (2.0 * h)
        scale = np.abs(slope(between)).max()
        np.testing.assert_allclose(found, slope(between), rtol=0, atol=1e-5 * scale)
    outside = np.array([500.0, 576.0, 582.0, 700.0])
    assert not LATENT.heat_capacity(outside).any()


@pytest.mark.parametrize("capacity", [900.0, (700.0, 0.5), TABLE])
@pytest.mark.parametrize("latent", [None, LATENT])
def test_heat_capacity_is_the_slope_of_the_enthalpy(capacity, latent):
    solid = Solid(2600.0, capacity, 2.0, latent_heat=latent)
    assert solid.constant == (capacity == 900.0 and latent is None)
    one = np.ones_like(T)
    slope = solid.enthalpy(Dual(T, {"T": one})).tangents["T"]
    np.testing.assert_allclose(slope, solid.heat_capacity(T) * one, rtol=1e-13)
    gained = solid.enthalpy(1000.0) - solid.enthalpy(200.0)
    bare = Solid(2600.0, capacity, 2.0)
    rest = bare.enthalpy(1000.0) - bare.enthalpy(200.0)
    assert gained - rest == approx(0.0 if latent is None else 178e3, rel=1e-12)
