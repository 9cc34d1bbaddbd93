"""Real fluids against CoolProp itself."""

import pickle
import sys

import numpy as np
import pytest
from CoolProp.CoolProp import PropsSI
from numpy.testing import assert_allclose, assert_array_equal

from contbed.errors import SceneError
from contbed.materials import real_fluid
from contbed.materials.common import extrapolation
from tests.cases import each_case
from tests.refusals import refused

CASES = {
    "liquid water": ("Water", 1e5, (280.0, 370.0)),
    "water up to boiling": ("Water", 1e5, (273.16, 372.76)),
    "steam": ("steam", 1e5, None),
    "steam at 40 bar": ("Water", 40e5, (530.0, 1000.0)),
    "thin steam": ("Water", 100.0, (300.0, 1000.0)),
    "CO2 gas": ("CO2", 1e5, (250.0, 1500.0)),
    "supercritical CO2": ("CO2", 20e6, (250.0, 1100.0)),
    "CO2 past the critical point": ("CO2", 8e6, (280.0, 600.0)),
    "supercritical water": ("Water", 25e6, (300.0, 1000.0)),
}
KEYS = {"density": "D", "heat_capacity": "C", "viscosity": "V", "conductivity": "L"}


@pytest.fixture(scope="module", params=CASES, ids=list(CASES))
def case(request):
    """The fluid, and points between the nodes, off the ends where CoolProp may name
    the other phase.
    """
    name, pressure, T_range = CASES[request.param]
    fluid = real_fluid(name, pressure, T_range)
    lo, hi = fluid.T_range
    T = np.random.default_rng(7).uniform(lo + 0.01, hi - 0.02, 400)
    return fluid, "Water" if name == "steam" else name, T


def test_equals_coolprop(case):
    """1e-6, ten times the tolerance of the table, since its error is sampled half
    way between nodes.
    """
    fluid, name, T = case
    for method, key in KEYS.items():
        exact = [PropsSI(key, "T", T_i, "P", fluid.pressure, name) for T_i in T]
        assert_allclose(getattr(fluid, method)(T), exact, rtol=1e-6, err_msg=method)


def test_enthalpy_equals_coolprop(case):
    """It is integrated from heat capacity, not fitted; 1e-7 of its span."""
    fluid, name, T = case
    exact = np.array([PropsSI("H", "T", T_i, "P", fluid.pressure, name) for T_i in T])
    assert_allclose(fluid.enthalpy(T), exact, rtol=0, atol=1e-7 * np.ptp(exact))


def test_derivatives_of_the_tables(case):
    """Central differences of the table itself, O(step^2), where no node lies within the
    step.

    The tolerance covers round-off of the difference and, near the critical point, the
    third derivative.
    """
    fluid, _, T = case
    step = 1e-4
    for name, (f, df) in fluid._tables.items():
        difference = (f(T + step) - f(T - step)) / (2.0 * step)
        scale = np.max(np.abs(f(T))) * 1e-15 / step + np.max(np.abs(difference)) * 1e-6
        assert_allclose(df(T), difference, rtol=1e-6, atol=5.0 * scale, err_msg=name)


def test_derivative_of_enthalpy_is_heat_capacity(case):
    fluid, _, T = case
    assert_array_equal(fluid._tables["enthalpy"][1](T), fluid.heat_capacity(T))


def test_outside_the_range_values_stay_and_are_counted(case):
    fluid, _, _ = case
    lo, hi = fluid.T_range
    for name in KEYS:
        f = getattr(fluid, name)
        far, near = f(np.array([lo - 500.0, hi + 500.0])), f(np.array([lo, hi]))
        assert_allclose(far, near, rtol=1e-12)
    assert_allclose(
        fluid.enthalpy(hi + 100.0) - fluid.enthalpy(hi),
        100.0 * fluid.heat_capacity(hi),
        rtol=1e-9,
    )
    assert fluid.share_outside(np.array([lo - 1.0, lo, hi, hi + 1.0])) == 0.5


def test_values_outside_of_the_range_are_no_extrapolation():
    fluid = real_fluid("Nitrogen", 1e5, (300.0, 400.0))
    text = extrapolation("gas", fluid.heat_capacity, fluid.T_range, np.array([450.0]))
    assert (
        text == "gas: data from 300 to 400 K are used at 450 K with the values at 400 K"
    )


def test_shapes_and_pickling():
    fluid = real_fluid("Water", 1e5, (280.0, 370.0))
    T = np.linspace(281.0, 369.0, 12)
    assert_array_equal(fluid.density(T.reshape(4, 3)).ravel(), fluid.density(T))
    assert np.shape(fluid.density(300.0)) == ()
    assert_array_equal(pickle.loads(pickle.dumps(fluid)).enthalpy(T), fluid.enthalpy(T))
    assert fluid.table_error < 1e-7


@each_case(__file__, "mistakes")
def test_mistakes_are_told(arguments, words):
    with pytest.raises(SceneError) as caught:
        real_fluid(*arguments)
    for word in words:
        assert word in str(caught.value)


def test_no_coolprop(monkeypatch):
    monkeypatch.setitem(sys.modules, "CoolProp", None)
    refused(
        r"package CoolProp .*pip install CoolProp",
        real_fluid,
        "Water",
        1e5,
        (300.0, 350.0),
    )
