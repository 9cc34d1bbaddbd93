"""Beds of burning fuel: a burning state is found without a guess, or the heat balance
says what is missing.
"""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import cantera as ct
import numpy as np
import pytest
from pytest import approx
from scipy.optimize import brentq

import contbed
from contbed.bubbling_bed.burning import (
    BURNING,
    HeatBalance,
    _remedies,
    explained,
    heat_balance,
)
from contbed.bubbling_bed.chemistry.of_boilers import unburnt_fuel
from contbed.bubbling_bed.diagnosis import char, explain
from contbed.bubbling_bed.ignition import HOT, NarrowFlameError, from_slow_mixing
from contbed.bubbling_bed.plan import plan
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.bubbling_bed.settling import _no_height
from contbed.errors import ConvergenceError
from contbed.loading import loads

FOLDER = Path(__file__).parents[1] / "data" / "first_hour"
MOLAR_MASS = {"C": 0.012011, "H": 0.001008, "O": 0.015999}


def problem(**sections):
    scene = contbed.load(FOLDER / "boiler.toml")
    if sections:
        tubes = scene.bubbling_bed.tubes.model_copy(update=sections)
        bed = scene.bubbling_bed.model_copy(update={"tubes": tubes})
        origin = scene.origin
        scene = scene.model_copy(update={"bubbling_bed": bed})
        scene._origin = origin
    return BubblingProblem(plan(scene))


def test_the_heat_balance_by_hand():
    """Half a kilogram of wood a second, a third of it water, in 2.6 kg/s of air."""
    found = heat_balance(problem(), BURNING)
    dry = 0.5 * 0.65
    air = 2.6 / (0.21 * 0.031998 + 0.79 * 0.028014)  # [mol/s]
    C, H, oxygen_of_wood = (
        dry * share / MOLAR_MASS[name]
        for name, share in (("C", 0.50), ("H", 0.06), ("O", 0.415))
    )
    # mean heat capacities from 298 to 1123 K [J/mol/K]: CO2, H2O, O2, N2
    oxygen = 0.21 * air - C - 0.25 * H + 0.5 * oxygen_of_wood
    water = 0.5 * H + 0.5 * 0.35 / 0.018015
    capacity = C * 48.6 + water * 38.6 + oxygen * 33.2 + 0.79 * air * 31.1
    brought = air * 29.3 * (423.15 - 298.15)
    gas = capacity * (BURNING - 298.15) - brought
    assert found.gas == approx(gas, rel=0.01)
    assert found.moisture == approx(0.175 / 0.018015 * 44.0e3, rel=0.01)
    area = 5.0 * 0.5 * 1.3  # tubes along the bed as it first stands
    assert found.surfaces == approx(300.0 * area * (BURNING - 523.15), rel=0.35)
    assert found.burnt == 1.0


def test_missing_heat_is_told():
    text = explained(problem(perimeter=50.0))
    assert (
        "MW are missing" in text
        and "at 1123 K in a bed 0.65 m high the fuel gives 6.14 MW" in text
    )
    assert "are left over" in explained(problem())


def test_the_advice_is_what_can_bring_the_missing_heat():
    """At 13.2 MW taken of 10.6 - 4.6 - 0.2 MW of heat 7.4 MW are missing: no drier fuel
    brings that, nor the 30 % more fuel for which there is air.
    """
    taken = {"gas": 4.6e6, "moisture": 0.2e6, "surfaces": 13.2e6}
    found = HeatBalance(BURNING, fuel=10.6e6, oxygen=1.3, **taken)
    assert found.surplus == approx(-7.4e6)
    assert _remedies(found) == "tubes and walls that take less"
    little = {"gas": 4.6e6, "moisture": 3.0e6, "surfaces": 5.0e6}
    found = HeatBalance(BURNING, fuel=10.6e6, oxygen=1.3, **little)
    assert _remedies(found).endswith("less or hotter gas, or drier fuel, or more fuel")
    found = HeatBalance(BURNING, fuel=1e6, oxygen=0.8, **little)
    assert _remedies(found).startswith("all of this: ")
    assert "more fuel" not in _remedies(found)


def test_a_bed_that_rises_until_its_walls_cool_it_out_is_told():
    """What its heat lacks is that at the height up to which it was followed."""
    bed, failure = problem(perimeter=50.0), ConvergenceError("no descent", [1.0])
    text = str(_no_height(bed, bed._start(BURNING), 2.5, failure))
    height = bed.plan.scene.bubbling_bed.height
    assert "the bed would be 2.5 m high" in text
    assert f"no steady state is found beyond {height:.3g} m" in text
    assert explained(bed) in text and text.endswith("give a smaller settled_height")
    warm = problem()
    x = warm._start(BURNING)
    warm.system.part(x, "n_char")[:] = 1e9
    assert "char piles up" in str(_no_height(warm, x, 2.5, failure))


def test_a_flame_is_followed_from_gases_that_mix_slowly():
    """Char with a third of the oxygen that burns it, in steam at 10 bar.

    What the gas that leaves does not burn heats it from 573 K: with mean heat
    capacities from 298 to 1800 K [J/mol/K] and heats of combustion [kJ/mol] by hand,
    it is at 1800 K.
    """
    scene = contbed.load(FOLDER.parent / "char_gasifier.toml")
    bed = BubblingProblem(plan(scene))
    state, _ = bed.solve_from(from_slow_mixing(bed, HOT))
    top = np.argmax(bed.space.points[0])

    def leaving(name):
        return sum(
            bed.system.part(state, f"N_{name}_{phase}")[top]
            for phase in ("emulsion", "bubble")
        )

    capacity = {"CO2": 52.9, "CO": 33.0, "H2O": 41.7, "H2": 30.7, "CH4": 67.0}
    heats = {"CO": 283.0, "H2": 241.8, "CH4": 802.3, "C6H6": 3169.0, "H2S": 518.0}
    moles = {name: leaving(name) for name in bed.chemistry.part.gases}
    C = sum(moles[name] for name in ("CO2", "CO", "CH4")) + 6.0 * moles["C6H6"]
    # 0.7 kg/s with 5 % of moisture and 87 % of carbon in what is dry
    assert approx(0.7 * 0.95 * 0.87 / MOLAR_MASS["C"], rel=1e-3) == C
    entering = 1.6 / (0.28 * 0.031998 + 0.72 * 0.018015)
    brought = entering * (0.28 * 30.6 + 0.72 * 34.8) * (573.15 - 298.15)
    released = 0.7 * 0.95 * 0.94 * 33.81e6 - 1e3 * sum(
        heat * moles[name] for name, heat in heats.items()
    )
    moisture = 0.7 * 0.05 / 0.018015 * 44.0e3
    per_kelvin = sum(moles[name] * cp for name, cp in capacity.items())
    T = 298.15 + (released + brought - moisture) / per_kelvin
    for phase in ("emulsion", "bubble"):
        found = bed.system.part(state, f"T_{phase}")[top]
        assert found == approx(T, rel=0.02), phase


def test_a_flame_narrower_than_cells_is_told_with_a_time_of_mixing(monkeypatch):
    """Newton's method fails below 0.2 s of mixing: the last of 3, 0.41 and 0.15 s, and
    of the shorter steps in between, is above that.
    """
    bed = BubblingProblem(plan(contbed.load(FOLDER.parent / "char_gasifier.toml")))
    solve_near = BubblingProblem.solve_near

    def only_slow(self, x):
        if self.plan.scene.bubbling_bed.mixing_time < 0.2:
            raise ConvergenceError("no descent", [1.0])
        return solve_near(self, x)

    monkeypatch.setattr(BubblingProblem, "solve_near", only_slow)
    with pytest.raises(NarrowFlameError) as caught:
        from_slow_mixing(bed, HOT)
    advised = float(re.search("give (.*?) s", str(caught.value))[1])
    # at the least step left is missed by 1/256 of ln(3/0.001)
    assert advised == approx(1.2 * 0.2, rel=0.05)


def test_char_that_piles_up_is_told_with_the_oxygen_that_passes_by():
    """The bed has 4 m2 with 55 % of particles; half as much char again is in it."""
    bed = problem()
    density = bed.plan.scene.solids["char"].fuel.char_density
    x = bed._start(1123.15)
    assert char(bed, x) is None
    n = 1.5 * 4.0 * 0.55 * density / MOLAR_MASS["C"]
    bed.system.part(x, "n_char")[:] = n
    z = bed.space.points[0]
    oxygen = 0.21 * bed.chemistry.inlet_flow
    bed.system.part(x, "N_O2_bubble")[:] = oxygen * (0.9 - 0.5 * z / z.max())
    text = char(bed, x)
    assert "1.5 times the volume of all particles" in text
    assert "carry 40 % of the oxygen" in text
    assert "bubbling_bed.bubbles.size as a number" in text
    # it is found before the equation that is missed most
    assert explain(bed, [x]) == text


def test_fuel_that_leaves_unburnt_is_named():
    """Tar without a reaction first; then what burns but has no time; nothing where
    little leaves, or where there is no air for it.
    """
    qoi = {"fuel_power_W": 1e6, "oxygen_ratio": 1.3, "ignited": 1.0}
    lost = {"CO": 1e4, "CH4": 2e4, "C6H6": 3e5, "char": 0.0}
    present = SimpleNamespace(CO_oxidation={}, CH4_oxidation={}, tar_oxidation=None)
    (text,) = unburnt_fuel(lost, qoi, present)
    assert text.startswith("33 % of the fuel's heating value leaves unburnt")
    assert "(shares: C6H6 0.3, CH4 0.02, CO 0.01)" in text
    assert text.endswith("add [reactions.tar_oxidation], which C6H6 burns by")
    present.tar_oxidation = {}
    (text,) = unburnt_fuel(lost, qoi, present)
    assert "a higher bubbling_bed.freeboard" in text
    assert not unburnt_fuel({"CO": 4e4}, qoi, present)
    assert not unburnt_fuel(lost, qoi | {"oxygen_ratio": 0.4}, present)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["boiler", "b2"])
def test_a_boiler_finds_its_burning_state(name):
    """The state that 1500 K lead to as well; what burns in the freeboard counts."""
    result = contbed.run(contbed.load(FOLDER / f"{name}.toml"))
    assert result.qoi["ignited"] == 1.0
    assert result.qoi["T_sand_mid_K"] == approx(1058.5825, abs=1e-3)
    assert result.qoi["x_CO_wet"] < 1e-6
    assert abs(result.balances["energy"]["relative_residual"]) < 1e-10


GASIFIER = """
[bubbling_bed]
settled_height = 0.6
section = 0.5
solids_fraction = 0.55
bubbles = {}
freeboard.height = 4.0
[gas]
composition = "O2:0.21, N2:0.79"
[boundary.bottom]
gas = { mass_flow = 0.2996, temperature = "400 degC" }
[solids.sand]
volume_share = 0.97
diameter = 0.9e-3
density = 2600
heat_capacity = 1000
nusselt = "ranz_marshall"
mixing_conductivity = 2e4
[solids.char]
volume_share = 0.03
diameter = 3e-3
density = 1100
heat_capacity = 1300
nusselt = "ranz_marshall"
mixing_conductivity = 2e4
feed = { mass_flow = 0.2, temperature = "25 degC", height = 0.3, width = 0.1 }
[solids.char.fuel]
moisture = 0.15
ash = 0.0
volatile_matter = 0.80
ultimate = { C = 0.50, H = 0.06, O = 0.44 }
[reactions]
drying.time = 5
devolatilisation.time = 10
char_combustion = {}
CO_oxidation = {}
H2_oxidation = {}
CH4_oxidation = {}
tar_oxidation = {}
water_gas_shift = {}
reforming = {}
char_steam = {}
char_CO2 = {}
"""


@pytest.mark.slow
def test_a_gasifier_is_followed_from_gases_that_rest_above_it():
    """Oxygen that bubbles bring to the freeboard burns tar there in a thin flame. All
    oxygen and all char react, so that carbon and hydrogen of the wood are in the gas,
    and the oxygen ratio is that by hand.
    """
    result = contbed.run(loads(GASIFIER))
    dry, air = 0.2 * 0.85, 0.2996 / (0.21 * 0.031998 + 0.79 * 0.028014)
    needed = dry * (
        0.50 / MOLAR_MASS["C"] + 0.06 / MOLAR_MASS["H"] / 4 - 0.44 / MOLAR_MASS["O"] / 2
    )
    assert result.qoi["oxygen_ratio"] == approx(0.21 * air / needed, rel=1e-3)
    assert result.qoi["x_O2_wet"] < 1e-5
    assert 1200.0 < result.qoi["T_freeboard_out_K"] < 1320.0  # equilibrium: 1059 K
    assert all(
        abs(balance["relative_residual"]) < 1e-9 for balance in result.balances.values()
    )


METHANE_IN_SAND = """
bubbling_bed.height = 0.8
bubbling_bed.section = 1.0
bubbling_bed.solids_fraction = 0.55
bubbling_bed.bubbles.size = "0.1 m"
bubbling_bed.tubes = { perimeter = 1.5, coefficient = 250, temperature = 473.15 }
gas.composition = "CH4:0.06, O2:0.1974, N2:0.7426"
boundary.bottom.gas = { mass_flow = 0.3, temperature = 298.15 }
reactions = { CH4_oxidation = {}, CO_oxidation = {} }
initial.temperature = 1170
[solids.sand]
volume_share = 1
diameter = "0.8 mm"
density = 2600
heat_capacity = 1050
nusselt = "gunn"
mixing_conductivity = 3e4
"""


@pytest.mark.slow
def test_gas_that_burns_in_bubbles_is_followed_from_slow_mixing():
    """All methane burns, and the sand has the temperature of the heat balance by
    Cantera, to 10 K: bubbles leave with some of the heat.
    """
    result = contbed.run(loads(METHANE_IN_SAND))
    gas = ct.Solution("gri30.yaml")
    gas.TPX = 298.15, 101325.0, "CH4:0.06, O2:0.1974, N2:0.7426"
    enters = gas.enthalpy_mass

    def balance(T):
        burnt = "CO2:0.06, H2O:0.12, O2:0.0774, N2:0.7426"
        gas.TPX = T, 101325.0, burnt
        tubes = 250.0 * 1.5 * 0.8 * (T - 473.15)
        return 0.3 * (enters - gas.enthalpy_mass) - tubes

    assert result.qoi["x_CH4_wet"] < 1e-6
    assert result.qoi["T_sand_mid_K"] == approx(brentq(balance, 600, 1800), abs=10.0)


LIME_IN_A_HEATED_BED = """
bubbling_bed.height = 1.0
bubbling_bed.section = 1.0
bubbling_bed.solids_fraction = 0.55
bubbling_bed.bubbles.size = 0.1
bubbling_bed.walls = { perimeter = 10, coefficient = 350, temperature = 1323.15 }
bubbling_bed.drain = { time = "3 h", end = "bottom" }
gas.material = "air"
boundary.bottom.gas = { mass_flow = 0.25, temperature = 473.15 }
reactions.calcination = {}
[solids.lime]
volume_share = 1
diameter = "0.6 mm"
density = 2300
heat_capacity = 1000
nusselt = "gunn"
mixing_conductivity = 3e4
feed = { mass_flow = 0.1, temperature = 298.15, height = 0.5, width = 0.1 }
limestone.purity = 0.97
"""


@pytest.mark.slow
@pytest.mark.parametrize("T", [600.0, 1123.0])
def test_a_bed_of_lime_is_found_from_below_where_lime_gives_off_its_gas(T):
    """Calcination needs 178 kJ/mol at 298 K; walls give it with the heat of gas and
    solids, to 4 % by constant heat capacities of 1130 and 1000 J/kg/K.
    """
    text = f"initial.temperature = {T}\n{LIME_IN_A_HEATED_BED}"
    found = contbed.run(loads(text)).qoi
    lime = 0.97 * 0.1 / 0.100087 * found["calcined"]
    bed = found["T_lime_mid_K"]
    needs = lime * 178e3 + 0.25 * 1130.0 * (bed - 473.15)
    needs += (0.1 - 0.044 * lime) * 1000.0 * (bed - 298.15)
    needs += lime * 49.0 * (bed - 298.15)  # of the carbon dioxide
    assert found["calcined"] > 0.99
    assert -found["walls_convection_W"] == approx(needs, rel=0.04)


LIME_IN_HOT_GAS = """
bubbling_bed.height = 1.2
bubbling_bed.section = 4.0
bubbling_bed.solids_fraction = 0.55
bubbling_bed.bubbles.size = 0.1
bubbling_bed.drain.time = "4 h"
gas.composition = "N2:0.72, CO2:0.1, H2O:0.1, O2:0.08"
boundary.bottom.gas = { mass_flow = "6 t/h", temperature = 1500 }
reactions.calcination = {}
[solids.stone]
diameter = "0.8 mm"
density = 2700
heat_capacity = 1000
nusselt = "ranz_marshall"
mixing_conductivity = 2e4
feed = { mass_flow = "1 t/h", temperature = 298.15, height = 0.5, width = 0.1 }
limestone.purity = 1.0
"""


@pytest.mark.slow
def test_lime_in_hot_gas_is_followed_from_lime_that_reacts_slowly():
    """The gas cools to the bed for 178 kJ/mol at 298 K and the heat of the solids; 3 %
    by constant heat capacities of CaO, CaCO3 and CO2, 53, 110 and 49 J/mol/K.
    """
    found = contbed.run(loads(LIME_IN_HOT_GAS)).qoi
    bed, turned = found["T_stone_mid_K"], found["calcined"]
    gas = ct.Solution("gri30.yaml")
    composition = "N2:0.72, CO2:0.1, H2O:0.1, O2:0.08"
    heat = []
    for T in (1500.0, bed):
        gas.TPX = T, 101325.0, composition
        heat.append(6.0 / 3.6 * gas.enthalpy_mass)
    stone = 1.0 / 3.6 / 0.100087
    each = turned * (178e3 + (53.0 + 49.0) * (bed - 298.15))
    each += (1.0 - turned) * 110.0 * (bed - 298.15)
    assert turned > 0.98
    assert heat[0] - heat[1] == approx(stone * each, rel=0.03)
    made = stone * turned / (6.0 / 3.6 / gas.mean_molecular_weight * 1e3)
    assert found["x_CO2_wet"] == approx((0.1 + made) / (1.0 + made), rel=2e-3)
