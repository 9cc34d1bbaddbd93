"""Water inside of tubes and walls: CoolProp's states, exact heating, boiling,
balances with the bed.
"""

import numpy as np
import pytest
from bubbling_scenes import case1, one
from computed_scenes import hot
from CoolProp import CoolProp
from pytest import approx

import contbed as cb
from contbed.materials.steam import steam
from tests.balances import assert_closed
from tests.refusals import refused


@pytest.mark.parametrize("pressure", [1e5, 60e5, 180e5, 300e5])
def test_table_is_coolprop(pressure):
    water = steam(pressure)
    h = np.linspace(50.0, 3900.0, 301)
    exact = CoolProp.PropsSI("T", "P", pressure, "Hmass", 1e3 * h, "Water")
    # near the critical point the curve bends within 1 kJ/kg
    assert np.abs(water.temperature(h) - exact).max() < (
        1e-3 if pressure < 1e7 else 2e-2
    )
    slope = (water.temperature(h + 1e-4) - water.temperature(h - 1e-4)) / 2e-4
    inside = np.abs(h - water.liquid) > 1
    inside &= np.abs(h - water.vapour) > 1
    assert water._slope(h)[inside] == approx(slope[inside], rel=1e-4, abs=1e-6)


def test_boiling_water_has_one_temperature_and_a_quality():
    water = steam(60e5)
    assert water.temperature(0.5 * (water.liquid + water.vapour)) == approx(
        548.73, abs=0.01
    )
    assert water.quality(0.25 * water.liquid + 0.75 * water.vapour) == approx(0.75)
    assert water.quality(100.0) is None


def inert(direction, coefficient):
    """Particles of one temperature, far hotter than the water of a small flow."""
    return one(
        inert={"mixing_conductivity": 1e7, "gas_coefficient": 1e4},
        inlet={"capacity_flow": 3e4, "temperature": 700.0},
        tubes={
            "perimeter": 2.0,
            "coefficient": 100.0,
            "steam": {
                "pressure": 60e5,
                "temperature": 300.0,
                "mass_flow": 0.2,
                "coefficient": coefficient,
                "direction": direction,
            },
        },
        mesh={"cells": 20},
    )


@pytest.mark.parametrize("direction", ["up", "down"])
def test_water_of_a_stirred_bed_is_heated_exponentially(direction):
    result = cb.run(inert(direction, 400.0))
    k = 2.0 / (1 / 100.0 + 1 / 400.0)  # both resistances in series [W/m/K]
    z, h = result.profiles["z [m]"], result.profiles["h_tubes_water [kJ/kg]"]
    T = np.interp(z, z, result.profiles["T_inert [K]"])
    along = z if direction == "up" else z[::-1]
    water = steam(60e5)
    from scipy.integrate import solve_ivp

    rise = np.abs(along - along[0])
    exact = solve_ivp(
        lambda y, x: k * (T.mean() - water.temperature(x)) / 200.0,
        (0, 0.6),
        [water.enthalpy(300.0)],
        t_eval=rise,
        rtol=1e-9,
        atol=1e-9,
    ).y[0]
    found = h if direction == "up" else h[::-1]
    # the bed differs by 1e-3 K from one temperature
    assert np.abs(found - exact).max() < 2e-4
    assert_closed(result, 1e-12)
    assert result.qoi["tubes_water_W"] == approx(
        result.qoi["tubes_convection_W"], rel=1e-10
    )


@pytest.mark.parametrize("make", [case1, hot])
def test_evaporator_in_a_bed(make):
    """A bed with all its physics boils water: the metal is q/(p h_i), 35 K at most,
    above saturation.
    """
    given = {
        "pressure": "60 bar",
        "temperature": 540.0,
        "mass_flow": 0.5,
        "coefficient": 5000.0,
    }
    tubes = {"perimeter": 4.0, "coefficient": 200.0, "emissivity": 0.8, "steam": given}
    result = cb.run(make(tubes=tubes))
    assert_closed(result, 1e-11)
    assert 0 < result.qoi["tubes_water_out_quality"] < 1
    assert result.qoi["tubes_water_out_K"] == approx(548.73, abs=0.01)
    metal = result.profiles["T_tubes_surface [K]"]
    assert np.nanmin(metal) > 540 and np.nanmax(metal) < 590
    duty = result.qoi["tubes_convection_W"] + result.qoi["tubes_radiation_W"]
    assert result.qoi["tubes_water_W"] == approx(duty, rel=1e-9)


def test_a_surface_has_one_cold_side():
    refused(
        "give one of temperature, steam",
        case1,
        tubes={"perimeter": 4.0, "coefficient": 200.0},
    )
