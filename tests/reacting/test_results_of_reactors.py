"""Selectivity, yield, space velocities, hot spot and approach to equilibrium of reacting
beds against closed forms and hand calculations.
"""

from copy import deepcopy
from types import SimpleNamespace

import numpy as np
from pytest import approx
from reacting_bed_scenes import MOLAR, R_GAS, P, T, equilibrium, ignition, isothermal
from solving import solved

from contbed.chemistry.thermo import Equilibrium
from contbed.loading import loads
from contbed.reacting_bed.of_reactors import made_and_used, temperature_of
from contbed.runner import run
from tests.scene_text import set_keys

GASES = {
    name: {"elements": elements, "molar_mass": mass}
    for name, elements, mass in (
        ("CO", {"C": 1, "O": 1}, 0.028),
        ("H2", {"H": 2}, 0.002),
        ("CH4", {"C": 1, "H": 4}, 0.016),
        ("H2O", {"H": 2, "O": 1}, 0.018),
        ("CO2", {"C": 1, "O": 2}, 0.044),
        ("N2", {"N": 2}, 0.028),
    )
}


def parallel(k_methane, k_shift):
    """CO becomes CH4 and CO2 side by side in plug flow, both of first order in CO
    between much N2.
    """
    scene = isothermal("CO:1e-6, H2:1, H2O:1, N2:2", GASES)
    scene["reactions"] = {
        "methane": {"equation": "CO + 3 H2 -> CH4 + H2O", "A": k_methane / 0.4},
        "shift": {"equation": "CO + H2O -> CO2 + H2", "A": k_shift / 0.4},
    }
    for reaction in scene["reactions"].values():
        reaction |= {"E": 0.0, "orders": {"CO": 1.0}}
    set_keys(scene, "solids.particles.density = 1500.0")
    return scene


def test_an_inert_gas_is_not_used_up_by_rounding():
    """CO becomes CO2 beside much methane, which leaves less by 1e-14 of what enters."""
    fed = {"CO": 1.0, "H2O": 5.0, "CO2": 0.0, "H2": 0.0, "CH4": 50.0}
    leaving = {"CO": 0.4, "H2O": 4.4, "CO2": 0.6, "H2": 0.6, "CH4": 50.0 - 5e-13}
    atoms = {name: table["elements"] for name, table in GASES.items()}
    gases = {name: SimpleNamespace(composition=atoms[name]) for name in fed}
    problem = SimpleNamespace(
        streams=SimpleNamespace(gas=fed),
        species=SimpleNamespace(gases=gases),
        scene=SimpleNamespace(mesh=SimpleNamespace(length=1.0)),
    )
    found = made_and_used(problem, leaving)
    assert found["yield_CO2_C"] == approx(0.6, rel=1e-12)
    assert found["yield_H2_H"] == approx(0.6 * 2.0 / 10.0, rel=1e-12)


def test_parallel_reactions_of_first_order():
    """Plug flow of 0.5 m/s over 1 m: X = 1 - exp(-(k1 + k2) L/u), selectivities of C
    k1/(k1 + k2) and k2/(k1 + k2), yields X times these.
    """
    qoi = solved(parallel(0.6, 0.2)).qoi
    conversion = 1.0 - np.exp(-0.8 / 0.5)
    assert qoi["conversion_CO"] == approx(conversion, rel=1e-5)
    for name, share in (("CH4", 0.75), ("CO2", 0.25)):
        assert qoi[f"selectivity_{name}_C"] == approx(share, rel=1e-8)
        expected = conversion * share
        assert qoi[f"yield_{name}_C"] == approx(expected, rel=1e-5)
    made = conversion * 0.75 * 0.5 * MOLAR * 1e-6 / (4.0 + 1e-6)
    assert qoi["space_time_yield_CH4_mol_m3s"] == approx(made, rel=1e-5)
    # with excess of H2 and H2O only CO and H2 are used up: O of CO goes to H2O and CO2
    assert "yield_N2_N" not in qoi


def test_space_velocities_by_hand():
    """0.5 m/s at 500 K and 1 bar over 1 m; rates in the gas need no mass of it."""
    scene = parallel(0.6, 0.2)
    qoi = solved(scene).qoi
    hourly = 3600.0 * 0.5 * (P / 101325.0) * (273.15 / T)
    assert qoi["GHSV_1_h"] == approx(hourly, rel=1e-12)
    assert "WHSV_1_h" not in qoi and "hot_spot_K" not in qoi
    set_keys(scene, 'reactions.shift.basis = "catalyst"')
    qoi = solved(scene).qoi
    mean = (0.002 + 0.018 + 2 * 0.028) / 4.0
    weight = 0.6 * 1500.0
    expected = 3600.0 * 0.5 * MOLAR * mean / weight
    assert qoi["WHSV_1_h"] == approx(expected, rel=1e-6)


def test_a_bed_in_equilibrium_has_no_approach():
    equations = {"shift": "CO + H2O <-> CO2 + H2"}
    qoi = solved(equilibrium("CO:1, H2O:2, N2:1", 1e5, 900.0, equations)).qoi
    assert qoi["equilibrium_approach_shift_K"] == approx(0.0, abs=1e-5)


def test_a_formula_beyond_equilibrium_is_reported_and_ends_there_with_its_quotient():
    """k x_CO alone goes on until no CO is left; times (1 - Q/K) it ends in equilibrium,
    at the same composition as the law with constants.
    """
    equations = {"shift": "CO + H2O <-> CO2 + H2"}
    scene = equilibrium("CO:1, H2O:2, N2:1", 1e5, 900.0, equations)
    whole = solved(deepcopy(scene)).qoi
    table = {"equation": equations["shift"], "rate": "k*x_CO", "parameters": {"k": 1e4}}
    scene["reactions"] = {"shift": dict(table)}
    result = solved(deepcopy(scene))
    (text,) = [each for each in result.warnings if "beyond its equilibrium" in each]
    assert "multiply it by (1 - Q_over_K)" in text
    assert result.qoi["Q_over_K_shift"] > 100.0
    scene["reactions"]["shift"]["rate"] = "k*x_CO*(1 - Q_over_K)"
    result = solved(scene)
    assert not [each for each in result.warnings if "equilibrium" in each]
    assert result.qoi["Q_over_K_shift"] == approx(1.0, abs=1e-6)
    assert result.qoi["x_H2_out"] == approx(whole["x_H2_out"], rel=1e-6)


def test_a_formula_with_its_quotient_runs_back_where_there_is_no_reactant():
    """No CO enters: k x_CO (1 - Q/K) is -k x_CO2 x_H2/(x_H2O K) there."""
    equations = {"shift": "CO + H2O <-> CO2 + H2"}
    scene = equilibrium("CO2:2, H2:2, H2O:1, N2:2", 1e5, 1100.0, equations)
    whole = solved(deepcopy(scene)).qoi
    scene["reactions"]["shift"] = {
        "equation": equations["shift"],
        "rate": "k*x_CO*(1 - Q_over_K)",
        "parameters": {"k": 1e4},
    }
    result = solved(scene)
    assert result.qoi["Q_over_K_shift"] == approx(1.0, abs=1e-6)
    assert result.qoi["x_CO_out"] == approx(whole["x_CO_out"], rel=1e-6)


def test_the_temperature_of_equilibrium_of_constant_heats():
    """ln K = (T dS - dH)/(R T) with dH = -40 kJ/mol and dS = -40 J/mol/K."""

    class Constant:
        standard_pressure = 1e5

        def enthalpy(self, T):
            return -40e3 + 0.0 * T

        def gibbs(self, T):
            return -40e3 + 40.0 * T

    law = Equilibrium({"B": 1.0}, {"B": Constant()}, frozenset("B"))
    Q = 1.5
    expected = 40e3 / (R_GAS * Q + 40.0)
    assert temperature_of(law, Q, 800.0) == approx(expected, rel=1e-10)
    assert temperature_of(law, -1e3, 800.0) is None


def test_the_hot_spot_of_an_adiabatic_bed_is_its_end():
    qoi = solved(ignition(8.0, 8.0, 0.3, 6.0, 0.5)).qoi
    assert qoi["hot_spot_K"] == approx(qoi["T_fluid_out_K"], rel=1e-12)
    assert qoi["hot_spot_m"] == 1.0


SLOT = """
model = "packed_bed"
mesh = { type = "line", length = "6 m", diameter = "60 mm", cells = 20 }
[gas]
model = "ideal_gas"
composition = "N2O4:1"
pressure = "1 bar"
viscosity = 2e-5
conductivity = 0.03
diffusivity = 1e-9
species.N2O4 = { heat_capacity = 80, enthalpy = "100 kJ/mol" }
species.NO2 = { heat_capacity = 40, enthalpy = 0 }
[solids.c]
diameter = "4 mm"
density = 1500
heat_capacity = 900
conductivity = 1
[packed_bed]
porosity = 0.4
pressure_drop = "none"
section = { shape = "plane", conductivity_solids = 0.5, rings = 16 }
[heat]
[reactions.r]
equation = "N2O4 -> 2 NO2"
rate = "k"
parameters = { k = "0.1 mol/m**3/s" }
basis = "bed"
[boundary.left]
gas.mass_flux = 0.4
gas.temperature = "400 K"
[boundary.wall]
coefficient = 30
ambient = "400 K"
"""


def test_the_hot_spot_of_a_section_is_not_above_its_axis():
    """10 kW/m3 over 2 R = 60 mm between walls: T_wall + q R/h + q R^2/(2 k) = 419 K at
    the axis. The layer beside it has its mean, q (R/16)^2/(6 k) = 0.012 K lower; the
    gas, which warms by 0.01 K, takes the rest.
    """
    qoi = run(loads(SLOT, "slot.toml")).qoi
    assert qoi["hot_spot_K"] == approx(419.0, abs=0.02)


def test_a_bed_whose_reactions_absorb_heat_has_no_hot_spot():
    """Its hottest gas is that which enters."""
    absorbs = SLOT.replace('enthalpy = "100 kJ/mol"', 'enthalpy = "-100 kJ/mol"')
    qoi = run(loads(absorbs, "slot.toml")).qoi
    assert "hot_spot_K" not in qoi and qoi["T_fluid_out_K"] < 400.0
