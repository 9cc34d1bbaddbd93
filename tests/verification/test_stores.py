"""Results of stores of heat against balances, closed forms and hand calculations."""

from math import erf, log
from pathlib import Path

import cantera as ct
import numpy as np
import pytest
from pytest import approx
from scipy.integrate import trapezoid

import contbed as cb
from contbed.loading import loads
from contbed.packed_bed.of_stores import Part, exchanged, exergy, thermocline, used

FIRST_HOUR = Path(__file__).parents[1] / "data" / "first_hour"
# a liquid through rock: 0.6 m long; the front moves at u C_f / (eps C_f + (1-eps) C_s)
EPS, SPEED, FLUID, SOLID = 0.4, 1e-3, 4e6, 2e6
STORE = f"""
mesh = {{ type = "line", length = 0.6, cells = 120 }}
gas = {{ density = 1000.0, heat_capacity = {FLUID / 1000}, conductivity = 0.6, viscosity = 1e-3 }}
solids.rock = {{ density = 2000.0, heat_capacity = {SOLID / 2000}, conductivity = 2.0, diameter = "5 mm" }}
packed_bed = {{ porosity = {EPS}, dead_state = 290.0 }}
closures = {{ nusselt = "wakao_kaguei" }}
heat = {{}}
initial.temperature = 300.0
[boundary.left]
gas = {{ velocity = FLOW, temperature = 350.0 }}
solids.rock = {{ coefficient = LOSS, ambient = 290.0 }}
[boundary.right]
BACKsolids.rock = {{ coefficient = LOSS, ambient = 290.0 }}
[time]
end = END
tolerance = 1e-4
"""
CYCLE = "{ times = [0, 200, 500], values = [0.001, 0.0, -0.001] }"


def store(flow, end, loss="0.0"):
    """The scene of a store; where its flow changes it turns."""
    back = "gas = { temperature = 300.0 }\n" if flow == CYCLE else ""
    text = STORE.replace("FLOW", flow).replace("END", end)
    return loads(text.replace("LOSS", loss).replace("BACK", back))


def results(*given, **more):
    return cb.run(store(*given, **more)).qoi


def test_what_a_store_takes_gives_loses_and_keeps_is_in_balance():
    q = results(CYCLE, "700.0", loss="20.0")
    assert q["heat_charged_J"] > q["heat_discharged_J"] > 0.0
    assert q["heat_lost_J"] > q["heat_lost_at_rest_J"] > 0.0
    kept = q["heat_charged_J"] - q["heat_discharged_J"] - q["heat_lost_J"]
    assert kept == approx(q["heat_stored_J"], rel=1e-8)
    held = q["utilisation"] * q["storage_capacity_J"]
    assert q["heat_charged_J"] - q["heat_lost_J"] < held < q["heat_charged_J"]


def test_without_losses_the_efficiency_is_that_of_the_balance():
    q = results(CYCLE, "700.0")
    assert q["heat_lost_J"] == q["heat_lost_at_rest_J"] == 0.0
    expected = 1.0 - q["heat_stored_J"] / q["heat_charged_J"]
    assert q["storage_efficiency"] == approx(expected, rel=1e-9)
    content = EPS * FLUID + (1.0 - EPS) * SOLID
    assert q["storage_capacity_J"] == approx(0.6 * content * 50.0, rel=1e-12)
    assert 0.0 < q["exergy_efficiency"] < q["storage_efficiency"]


def test_a_stream_that_leaves_cold_leaves_its_whole_exergy():
    q = results("0.001", "200.0")
    capacity, flow = FLUID / 1000.0, SPEED * 1000.0
    hot, cold = (
        capacity * (T - 290.0 - 290.0 * log(T / 290.0)) for T in (350.0, 300.0)
    )
    assert q["exergy_charged_J"] == approx(200.0 * flow * (hot - cold), rel=1e-4)
    assert q["heat_charged_J"] == approx(200.0 * flow * capacity * 50, rel=1e-6)
    assert q["effectiveness_charge"] == approx(1.0, rel=1e-6)
    assert q["exergy_discharged_J"] == q["heat_discharged_J"] == 0.0
    used_share = q["heat_stored_J"] / q["storage_capacity_J"]
    assert q["utilisation"] == approx(used_share, rel=1e-9)
    assert "storage_efficiency" not in q and "exergy_efficiency" not in q


def test_a_restart_keeps_the_parts_before_it(tmp_path):
    cb.run(store(CYCLE, "300.0", "20.0"), out=tmp_path / "part")
    again = cb.run(
        store(CYCLE, "700.0", "20.0"), out=tmp_path / "all", restart=tmp_path / "part"
    ).qoi
    whole = cb.run(store(CYCLE, "700.0", "20.0")).qoi
    for name in ("heat_charged_J", "heat_discharged_J", "heat_lost_at_rest_J"):
        assert again[name] == approx(whole[name], rel=1e-3)
    kept = again["heat_charged_J"] - again["heat_discharged_J"] - again["heat_lost_J"]
    assert kept == approx(again["heat_stored_J"], rel=1e-8)


def test_exergy_of_a_heat_capacity_that_grows_with_temperature():
    """c = a + b T: the entropy is a ln(T/T0) + b (T - T0)."""
    a, b, dead = 800.0, 0.5, 298.15
    T = np.array([250.0, 298.15, 600.0, 900.0])
    rise = a * (T - dead) + 0.5 * b * (T**2 - dead**2)
    entropy = a * np.log(T / dead) + b * (T - dead)
    found = exergy(lambda T: a * T + 0.5 * b * T**2, T, dead)
    np.testing.assert_allclose(found, rise - dead * entropy, rtol=1e-6, atol=1e-6)


def test_thermocline_of_an_error_function():
    """From 10 to 90 % an error function of width s takes 1.281552 * 2 s / sqrt(2)."""
    x = np.linspace(0.0, 1.0, 2001)
    T = np.array([400.0 - 50.0 * (1.0 + erf((at - 0.4) / 0.1)) for at in x])
    expected = 2.0 * 1.2815515655 * 0.1 / np.sqrt(2.0)
    assert thermocline(x, T, (300.0, 400.0)) == approx(expected, rel=1e-5)
    assert thermocline(x[:800], T[:800], (300.0, 400.0)) is None  # has not arrived


def test_quantities_of_a_cycle():
    heats = [(10.0, 20.0), (-1.0, 2.0), (-8.0, 16.0), (0.0, 5.0)]
    exergies = (4.0, -0.5, -1.5, 0.0)
    parts = [
        Part(left, 0.25, most, exergy, most != 5.0)
        for (left, most), exergy in zip(heats, exergies, strict=True)
    ]
    found = exchanged(parts)
    assert found["storage_efficiency"] == approx(0.9)
    assert found["effectiveness_charge"] == found["effectiveness_discharge"] == 0.5
    assert found["exergy_efficiency"] == 0.5
    # a wall heats: streams take more out than theirs could
    heated = exchanged([*parts, Part(-90.0, 0.25, 5.0, 0.0, True)])
    assert not {"effectiveness_discharge", "storage_efficiency"} & heated.keys()
    assert heated["effectiveness_charge"] == 0.5
    assert used(parts, 0.0, 90.0) == {
        "heat_lost_J": 1.0,
        "heat_stored_J": 0.0,
        "storage_capacity_J": 90.0,
        "heat_lost_at_rest_J": 0.25,
        "utilisation": approx(9.75 / 90.0),
    }


def test_a_round_bed_whose_inlet_temperature_changes():
    """A round bed that is solved on a line: series are those of its own sides."""
    ramp = '{ times = [0, 100], values = [300, 350], form = "step" }'
    text = STORE.split("[boundary.left]")[0] + (
        f"boundary.bottom.gas = {{ velocity = 0.001, temperature = {ramp} }}\n"
        "time.end = 200.0\n"
    )
    text = text.replace(
        '"line", length = 0.6', '"axisymmetric", radius = 0.1, length = 0.6'
    )
    text = text.replace(", cells = 120", "")
    q = cb.run(loads(text)).qoi
    flow = SPEED * np.pi * 0.01
    assert q["heat_charged_J"] == approx(100.0 * flow * FLUID * 50.0, rel=1e-6)


@pytest.mark.slow
def test_a_rock_store_of_a_newcomer():
    """A day of air of 450 degC, whose flow changes in steps: what streams leave, lose and hold
    closes, and heat charged is the enthalpy of what enters less that of what leaves, by
    Cantera, with the trapezoidal rule over the steps.
    """
    result = cb.run(cb.load(FIRST_HOUR / "store.toml"))
    qoi = result.qoi
    assert qoi["heat_stored_J"] == approx(
        qoi["heat_charged_J"] - qoi["heat_discharged_J"] - qoi["heat_lost_J"],
        rel=1e-6,
    )
    assert 0.5 < qoi["storage_efficiency"] < 1.0
    air = ct.Solution("air.yaml")
    air.TPX = 723.15, ct.one_atm, "N2:0.79, O2:0.21"
    hot, flow = air.enthalpy_mass, air.density * np.pi * 0.8**2 * 0.12
    outlet = result.tables["outlet"]
    t, T = (np.array(outlet[name]) for name in ("t [s]", "T_fluid_out [K]"))
    first = t <= 8 * 3600.0
    left = []
    for each in T[first]:
        air.TP = each, ct.one_atm
        left.append(hot - air.enthalpy_mass)
    charged = trapezoid(flow * np.array(left), t[first])
    assert qoi["heat_charged_J"] == approx(charged, rel=0.01)
