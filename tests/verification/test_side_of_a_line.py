"""Heat through the side of a bed on a line, [boundary.wall], against closed forms; the
pressure drop of a bed without temperatures.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pytest import approx

from contbed.loading import loads
from contbed.runner import run
from studies._exact import packed_bed as exact
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused

BED = """
mesh = { type = "line", length = 1.0, diameter = 0.2 }
gas = { density = 1.2, viscosity = 1.8e-5, heat_capacity = 1000, conductivity = 0.02 }
solids.s = { density = 2500, heat_capacity = 800, conductivity = 1, diameter = 0.005 }
packed_bed.porosity = 0.5
closures = { nusselt = 10, conductivity_gas = 0, conductivity_solids = 0 }
heat = {}
"""
AREA = 6.0 * 0.5 / 0.005
EXCHANGE = 10 * 0.02 / 0.005 * AREA
CAPACITIES = 0.5 * 1.2 * 1000, 0.5 * 2500 * 800
PERIMETER = 4.0 / 0.2


@pytest.mark.parametrize("table", ["wall", "wall.gas"])
def test_a_stream_loses_heat_exponentially(table):
    """Without conduction particles at rest have the temperature of the gas: T - T_a
    falls by exp(-4 h x/(D G c)); the loss is what the stream loses.
    """
    text = f"""{BED}
boundary.left.gas = {{ velocity = 0.5, temperature = 600 }}
boundary.{table} = {{ coefficient = 10, ambient = 300 }}
"""
    found = run(loads(text))
    flow, x = 1.2 * 1000 * 0.5, found.profiles["x [m]"]
    falls = 300.0 * np.exp(-10 * PERIMETER * x / flow)
    assert_allclose(found.profiles["T_fluid [K]"], 300 + falls, atol=1e-5)
    lost = flow * (300.0 - falls[-1])
    assert found.qoi["heat_wall_W"] == approx(-lost, rel=1e-8)
    assert_closed(found, 1e-11, "energy")


def test_a_side_that_gas_passed_earlier_is_no_wall():
    """Gas enters until 60 s and rests to the end at 120 s: what it brought is no heat
    of a wall.
    """
    text = f"""{BED}
boundary.left.gas = {{ velocity = {{ times = [0, 59, 60, 120], values = [0.2, 0.2, 0, 0] }}, temperature = 400 }}
boundary.right.type = "outlet"
boundary.wall = {{ coefficient = 20, ambient = 300 }}
initial = {{ gas.temperature = 300, solids.s.temperature = 300 }}
time.end = 120
"""
    found = run(loads(text))
    assert found.qoi["heat_wall_W"] * 120.0 == approx(-found.qoi["heat_lost_J"])
    assert "heat_left_W" not in found.qoi


def test_a_bed_at_rest_is_a_fin():
    """cosh(m (L - x))/cosh(m L) with m^2 = 4 h/(D K), to the tolerance of the cells;
    the heat of the base is K m tanh(m L) dT.
    """
    text = BED.replace("conductivity_solids = 0", "conductivity_solids = 2.0")
    text += """
[boundary.left]
solids.s.fixed_temperature = 500
[boundary.wall]
solids.s = { coefficient = 0.3, ambient = 300 }
"""
    found = run(loads(text))
    m, x = np.sqrt(0.3 * PERIMETER / 2.0), found.profiles["x [m]"]
    T = 300.0 + 200.0 * np.cosh(m * (1.0 - x)) / np.cosh(m)
    assert_allclose(found.profiles["T_solid [K]"], T, atol=2e-4)
    base = 2.0 * m * np.tanh(m) * 200.0
    assert found.qoi["heat_left_W"] == approx(base, rel=1e-6)
    assert found.qoi["heat_wall_W"] == approx(-base, rel=1e-6)


def test_both_phases_of_a_bed_at_rest_cool_down():
    """Two temperatures that exchange and lose heat, as the matrix exponential says, to
    the tolerance of the steps.
    """
    text = f"""{BED}
boundary.wall = {{ coefficient = 4, ambient = 290 }}
boundary.wall.solids.s = {{ coefficient = 2000, ambient = 290 }}
initial = {{ gas.temperature = 300, solids.s.temperature = 400 }}
time = {{ end = 60, times = [1, 10], tolerance = 1e-6 }}
""".replace("boundary.wall = {", "boundary.wall.gas = {")
    found = run(loads(text))
    losses = 4 * PERIMETER, 2000 * PERIMETER
    for k, t in enumerate((1.0, 10.0, 60.0)):
        wanted = exact.two_temperature_relaxation(
            t, *CAPACITIES, EXCHANGE, 300.0, 400.0, *losses, 290.0
        )
        for name, T in zip(("T_fluid", "T_solid"), wanted, strict=True):
            rows = found.profiles[f"{name} [K]"][found.profiles["t [s]"] == t]
            assert_allclose(rows, T, atol=2e-3, err_msg=f"{k} {name}")
    assert_closed(found, 1e-10, "energy")


def test_the_bed_follows_surroundings_that_warm_up():
    """Losses in proportion to the capacities keep both phases at one temperature,
    T - T_0 = r (t - (1 - exp(-k t))/k) in surroundings that gain r [K/s].
    """
    rate, k = 0.5, 2e-2
    each = [k * capacity / PERIMETER for capacity in CAPACITIES]
    ambient = "{ times = [0, 100], values = [300, 350] }"
    text = f"""{BED}
boundary.wall.gas = {{ coefficient = {each[0]}, ambient = {ambient} }}
boundary.wall.solids.s = {{ coefficient = {each[1]}, ambient = {ambient} }}
initial.temperature = 300
time = {{ end = 100, tolerance = 1e-6 }}
"""
    found = run(loads(text))
    T = 300.0 + rate * (100.0 - (1.0 - np.exp(-k * 100.0)) / k)
    assert found.profiles["T_solid [K]"] == approx(T, abs=1e-3)
    assert found.profiles["T_fluid [K]"] == approx(T, abs=1e-3)


@pytest.mark.parametrize("table", ["wall", "wall.gas", "wall.solids.s"])
def test_heat_beside_a_line_that_changes_enters_once(table):
    """A flux that rises from 0 to 2 kW/m2 gives the bed the heat of its mean: to
    rounding, as steps integrate a line exactly.
    """
    text = f"""{BED}
initial.gas.temperature = 300
initial.solids.s.temperature = 300
time.end = 400
boundary.left.gas = {{ velocity = 0.5, temperature = 300 }}
boundary.{table}.heat_flux = {{ times = [0, 400], values = [0, 2000] }}
"""
    found = run(loads(text))
    assert found.balances["energy"]["in"] == approx(1000 * PERIMETER * 400, rel=1e-10)
    assert_closed(found, 1e-11, "energy")


@each_case(__file__, "mistakes")
def test_mistakes(old, new, words):
    """What a side of a line cannot be is refused."""
    text = f"""{BED}
boundary.left.gas = {{ velocity = 0.5, temperature = 600 }}
boundary.wall = {{ coefficient = 10, ambient = 300 }}
"""
    refused(words, lambda: loads(text.replace(old, new)))


@pytest.mark.parametrize(
    "mesh", ['type = "line"', 'type = "rectangle", height = 0.1, cells = [4, 4]']
)
@pytest.mark.parametrize("velocity", [2.0, -2.0])
def test_pressure_drop_of_a_bed_without_temperatures(mesh, velocity):
    """mu u/K + c_F rho u^2/sqrt(K) per length, to rounding."""
    text = f"""
mesh = {{ {mesh}, length = 0.5 }}
gas = {{ density = 1.2, viscosity = 1.8e-5 }}
solids.block = {{ diameter = 0.005 }}
packed_bed.porosity = 0.5
closures = {{ permeability = 1e-8, forchheimer = 0.6 }}
boundary.{"left" if velocity > 0 else "right"}.gas.velocity = 2.0
"""
    found = run(loads(text))
    gradient = 1.8e-5 / 1e-8 * 2.0 + 0.6 * 1.2 / 1e-8**0.5 * 4.0
    assert found.qoi["pressure_drop_Pa"] == approx(0.5 * gradient, rel=1e-13)
    assert found.qoi["residence_time_s"] == approx(0.5 * 0.5 / 2.0, rel=1e-13)
    x, p = found.profiles["x [m]"], found.profiles["p [Pa]"]
    left = 0.5 - x if velocity > 0 else x
    assert_allclose(p, gradient * left, rtol=1e-12, atol=1e-9)


def test_ergun_without_temperatures():
    """150 (1 - eps)^2 mu u/(eps^3 d^2) + 1.75 (1 - eps) rho u^2/(eps^3 d), to
    rounding.
    """
    text = """
mesh = { type = "line", length = 2.0 }
gas = { density = 1.2, viscosity = 1.8e-5 }
solids.s = { diameter = 0.003 }
packed_bed.porosity = 0.4
boundary.left.gas.velocity = 0.5
"""
    found = run(loads(text)).qoi["pressure_drop_Pa"]
    viscous = 150 * 0.6**2 * 1.8e-5 * 0.5 / (0.4**3 * 0.003**2)
    inertial = 1.75 * 0.6 * 1.2 * 0.25 / (0.4**3 * 0.003)
    assert found == approx(2.0 * (viscous + inertial), rel=1e-13)
