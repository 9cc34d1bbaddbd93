"""Reacting beds whose solution is known, and beds that break models: each converges
and closes every balance.
"""

from types import SimpleNamespace

import cantera
import numpy as np
import pytest
from bubbling_scenes import changed
from pytest import approx
from reacting_scenes import (
    BURNING,
    COAL,
    combustor,
    of_gases,
    tables,
    tube,
    without_fuel,
)
from scipy.integrate import solve_ivp

import contbed as cb
from contbed.bubbling_bed.chemistry import thermo
from contbed.bubbling_bed.chemistry.scene import SulphateReduction
from contbed.bubbling_bed.equations.species import SourceTerms, Species
from contbed.bubbling_bed.plan import plan
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.chemistry.laws.gases import BY_REACTION
from contbed.chemistry.thermo import R_GAS
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.refusals import refused

# of the throughput: rounding of exchange with walls; what is asked for is 1e-8
CLOSED = 1e-11


def solved(scene):
    result = cb.run(scene)
    assert_closed(result, CLOSED)
    return result


@pytest.fixture(scope="module")
def burning():
    return solved(combustor(stone=True))


def test_a_combustor_burns_its_coal(burning):
    qoi = burning.qoi
    assert sorted(burning.balances) == ["C", "Ca", "H", "N", "O", "S", "energy"]
    assert (
        qoi["ignited"] == 1
        and qoi["carbon_conversion"] > 0.97
        and qoi["combustion_efficiency"] > 0.97
    )
    assert 0.5 < qoi["sulphur_capture"] < 0.9 and qoi["calcined"] > 0.99
    power = qoi["fuel_power_W"] * qoi["combustion_efficiency"]
    assert 0.3 < qoi["tubes_convection_W"] / power < 0.5
    wet = sum(
        value
        for name, value in qoi.items()
        if name.startswith("x_") and name.endswith("_wet")
    )
    assert wet == approx(1.0, rel=1e-12)
    # what is not captured leaves with the gas, but for 0.3 % in volatile matter that is
    # drained
    S = (qoi["x_SO2_wet"] + qoi["x_H2S_wet"]) * qoi["gas_out_mol_s"]
    assert (
        approx((1.0 - qoi["sulphur_capture"]) * burning.balances["S"]["in"], rel=0.02)
        == S
    )


@pytest.mark.slow
def test_carbon_monoxide_takes_sulphur_from_the_lime(burning):
    """Elements and energy close as without; capture falls, by more where the rate is
    larger.
    """
    captured = [burning.qoi["sulphur_capture"]]
    for constant in (1e-7, 1e-6):
        scene = combustor(stone=True)
        table = SulphateReduction(rate_constant=constant)
        reactions = scene.reactions.model_copy(update={"sulphate_reduction": table})
        captured.append(
            solved(scene.model_copy(update={"reactions": reactions})).qoi[
                "sulphur_capture"
            ]
        )
    assert captured[0] > captured[1] > captured[2] > 0.0


def test_sulphate_reduction_needs_sulphate_and_a_rate():
    """By key: there is no default, as no published constant is confirmed."""
    reactions = tables(stone=True)["reactions"]
    without = {key: value for key, value in reactions.items() if key != "sulphation"}
    refused(
        "there is no sulphate without",
        lambda: combustor(
            stone=True,
            reactions=without | {"sulphate_reduction": {"rate_constant": 1e-7}},
        ),
    )
    refused(
        r"sulphate_reduction\.rate_constant",
        lambda: combustor(stone=True, reactions=reactions | {"sulphate_reduction": {}}),
    )


def test_profiles_are_fractions(burning):
    for phase in ("emulsion", "bubble"):
        columns = [
            column
            for name, column in burning.profiles.items()
            if name.endswith(f"_{phase} [1]")
        ]
        assert np.sum(columns, axis=0) == approx(1.0, rel=1e-12)
        assert np.min(columns) > -1e-3  # 12 cells
    assert any(use["name"] == "char_combustion: field" for use in burning.closures)


def test_nothing_reacts_as_nothing_is_computed():
    """Tables of no reaction give the inert bed of the same gas, but for two sets of
    polynomials of its heat.
    """
    inert = without_fuel(
        drain=None, reactions={}, inlet={"mass_flow": 0.45, "temperature": 700.0}
    )
    result = solved(from_dict(inert))
    plain = cb.run(
        from_dict({key: value for key, value in inert.items() if key != "reactions"})
    )
    for name in ("T_inert_mid_K", "T_emulsion_top_K"):
        assert result.qoi[name] == approx(plain.qoi[name], rel=1e-3)
    assert "x_CO2_wet" not in result.qoi and result.qoi["x_O2_wet"] == approx(
        0.21, rel=1e-10
    )
    assert not any(name.startswith("x_") for name in plain.profiles)


@pytest.mark.slow
def test_a_millionth_of_fuel_is_no_fuel():
    little = tables()
    little["solids"]["char"]["feed"]["mass_flow"] = 1e-8
    result = solved(from_dict(little))
    none = solved(from_dict(without_fuel(drain=None, reactions={})))
    # without fuel the bed holds 2 % of its particles less, whose surface the gas then
    # lacks
    assert result.qoi["T_inert_mid_K"] == approx(none.qoi["T_inert_mid_K"], rel=1e-3)
    assert result.qoi["x_O2_wet"] == approx(none.qoi["x_O2_wet"], rel=1e-5)


def test_shift_by_an_integrator_of_ordinary_equations():
    """N_CO' = -V r at 1200 K, walls and particles hold it there."""
    scene = tube("CO:0.3, H2O:0.4, N2:0.3", {"water_gas_shift": {"factor": 3.0}})
    result = solved(scene)
    law = BY_REACTION["water_gas_shift"]["biba"]
    item = of_gases("water_gas_shift", 3.0, 1e-3)
    species = thermo.table()
    x = {"CO": 0.3, "H2O": 0.4, "N2": 0.3, "CO2": 0.0, "H2": 0.0}
    total = 0.02 / sum(species[name].molar_mass * value for name, value in x.items())
    volume, c = 0.1 * 0.45, 101325.0 / (R_GAS * 1200.0)

    def slope(z, made):
        now = {
            name: (value + law.stoichiometry.get(name, 0.0) * made[0] / total) * c
            for name, value in x.items()
        }
        return [volume * item.rate(1200.0, now, 101325.0, {})]

    z = result.profiles["z [m]"]
    exact = (
        solve_ivp(slope, (0, 0.5), [0.0], t_eval=z, rtol=1e-10, atol=1e-12).y[0] / total
    )
    # 20 cells of degree 3, and 0.05 K by which the gas leads the walls
    assert result.profiles["x_CO2_emulsion [1]"] == approx(exact, abs=2e-5)
    assert exact[-1] > 0.05


def two_gases(**more):
    """CO2 and O2 in emulsion and bubbles, and fields that a test gives."""
    gases = {
        "CO2": SimpleNamespace(molar_mass=0.044, enthalpy=lambda T: -4e5 + 50.0 * T),
        "O2": SimpleNamespace(molar_mass=0.032, enthalpy=lambda T: 30.0 * T),
    }
    return SimpleNamespace(
        gases=gases, phases=("emulsion", "bubble"), solids={}, **more
    )


def test_a_particle_gives_at_its_temperature_and_takes_at_that_of_the_gas():
    terms = SourceTerms(two_gases())
    terms.particle(
        "char",
        {"CO2": 2.0, "O2": -3.0},
        {},
        SimpleNamespace(T={"char": 1200.0, "emulsion": 900.0}),
    )
    assert terms.gas["emulsion"] == {"CO2": 2.0, "O2": -3.0}
    brought = 2.0 * (-4e5 + 50.0 * 1200.0) - 3.0 * 30.0 * 900.0
    assert terms.gain == approx({"T_emulsion": brought, "T_char": -brought})


@pytest.mark.parametrize(("crossing", "of"), [(0.3, "emulsion"), (-0.3, "bubble")])
def test_gas_that_crosses_has_the_composition_of_where_it_comes_from(crossing, of):
    """0.3 kg/s/m into the bubbles is gas of the emulsion, out of them that of the
    bubbles.
    """
    part = two_gases(pressure=1e5, section=1.0, exchange=lambda local, state: 0.0)
    w = {"emulsion": {"CO2": 0.9, "O2": 0.1}, "bubble": {"CO2": 0.2, "O2": 0.8}}
    both = {"emulsion": 1000.0, "bubble": 1000.0}
    local = SimpleNamespace(delta=0.3, crossing=crossing)
    terms = SourceTerms(part)
    Species._exchange(
        part,
        SimpleNamespace(
            local=local, w=w, T=both, molar_mass={"emulsion": 0.04, "bubble": 0.03}
        ),
        terms,
    )
    moved = {
        "CO2": crossing * w[of]["CO2"] / 0.044,
        "O2": crossing * w[of]["O2"] / 0.032,
    }
    assert terms.gas["bubble"] == approx(moved)
    assert terms.gas["emulsion"] == approx(
        {name: -amount for name, amount in moved.items()}
    )


def test_exchange_of_fuel_goes_by_the_surface_that_is_there():
    """Twice the char has twice the surface for gas, mixing and the other particles;
    the pair of others stays.
    """
    problem = BubblingProblem(plan(combustor(stone=True)))
    computed, z = problem.c.computed, np.full(1, 0.5)
    values = {
        f"T_{name}": np.full(1, 1100.0)
        for name in ("char", "inert", "stone", "emulsion", "bubble")
    }
    values |= {
        name: np.full(1, 1.0) * value
        for name, value in computed.start(1100.0, z).items()
    }
    values["n_volatiles"] = np.zeros(1)
    once, _ = computed.recorded(values, z)
    twice, _ = computed.recorded(values | {"n_char": 2.0 * values["n_char"]}, z)
    share = once.shares["char"]
    assert once.pairs["char", "inert"] == approx(share * 2e4)
    assert once.pairs["stone", "inert"] == approx(1e5)
    # a trace of surface stays without char
    assert twice.shares["char"] == approx(2.0 * share, rel=1e-6)
    assert twice.pairs["char", "inert"] == approx(twice.shares["char"] * 2e4)
    assert twice.gas["char"] == approx(2.0 * once.gas["char"], rel=1e-6)


def test_flows_may_hardly_undershoot_zero():
    """Newton's method may leave a hundredth of what enters, not more, below zero."""
    problem = BubblingProblem(plan(combustor()))
    for name, size in problem.chemistry.sizes.items():
        assert problem.system.part(problem.lower, name) == approx(-0.01 * size), name
    assert problem.system.part(problem.lower, "T_char") == approx(0.0)


def test_infinite_rate_is_equilibrium():
    scene = tube("CO:0.3, H2O:0.4, N2:0.3", {"water_gas_shift": {"factor": 1e5}})
    q = solved(scene).qoi
    shift = thermo.equilibrium(BY_REACTION["water_gas_shift"]["biba"].stoichiometry)
    K = float(np.exp(shift.ln_K(q["T_emulsion_top_K"])))
    assert q["x_CO2_wet"] * q["x_H2_wet"] / (q["x_CO_wet"] * q["x_H2O_wet"]) == approx(
        K, rel=1e-6
    )


def test_adiabatic_flame_by_cantera():
    """Without walls the gas leaves at the temperature and composition of equilibrium
    at constant enthalpy.
    """
    mixture = "CO:0.04, H2:0.03, O2:0.15, H2O:0.03, N2:0.75"
    inlet = {"mass_flow": 0.02, "temperature": 900.0}
    q = solved(
        tube(mixture, {"CO_oxidation": {}, "H2_oxidation": {}}, inlet=inlet, walls=None)
    ).qoi
    names = ("CO", "H2", "O2", "H2O", "N2", "CO2")
    burnt = cantera.Solution(
        thermo="ideal-gas",
        species=[
            item
            for item in cantera.Species.list_from_file("nasa_gas.yaml")
            if item.name in names
        ],
    )
    burnt.TPX = 900.0, 101325.0, mixture
    burnt.equilibrate("HP")
    # what is left of the fuel, and enthalpies smoothed at 1000 K
    assert q["T_emulsion_top_K"] == approx(burnt.T, abs=0.1)
    assert q["x_CO2_wet"] == approx(burnt["CO2"].X[0], rel=1e-4)
    assert q["x_O2_wet"] == approx(burnt["O2"].X[0], rel=1e-4)


def test_exhausted_fuel_and_exhausted_oxygen():
    """Rates a thousand times faster than any: whichever is short is gone, and mole
    fractions stay at zero.
    """
    fast = {name: {"factor": 1e3} for name in ("CO_oxidation", "H2_oxidation")}
    rich = solved(tube("CO:0.1, H2:0.1, O2:0.02, H2O:0.05, N2:0.73", fast)).qoi
    lean = solved(tube("CO:0.02, H2:0.02, O2:0.1, H2O:0.05, N2:0.81", fast)).qoi
    assert abs(rich["x_O2_wet"]) < 1e-8 and rich["x_CO_wet"] > 0.05
    assert abs(lean["x_CO_wet"]) < 1e-8 and abs(lean["x_H2_wet"]) < 1e-8
    # N2 is the tie: 0.02 of each fuel takes 0.02 of O2
    assert lean["x_O2_wet"] / lean["x_N2_wet"] == approx((0.1 - 0.02) / 0.81, rel=1e-6)


@pytest.mark.slow
def test_no_char():
    none = tables()
    none["solids"]["char"]["fuel"] |= {
        "volatile_matter": 1.0 - 1e-9,
        "ultimate": {"C": 0.46, "H": 0.055, "O": 0.385},
    }
    gas = solved(from_dict(none))
    assert gas.qoi["ignited"] == 1 and gas.qoi["held_char_mol"] < 1e-3


@pytest.mark.slow
def test_only_char():
    coke = tables(
        reactions={"char_combustion": {"products": "arthur"}, "CO_oxidation": {}}
    )
    dry = {
        "volatile_matter": 0.0,
        "moisture": 0.0,
        "ultimate": {"C": 0.9, "H": 0.0, "O": 0.0},
    }
    coke["solids"]["char"]["fuel"] |= dry
    coke["initial"] = {"temperature": 1200.0}
    char = solved(from_dict(coke))
    assert char.qoi["carbon_conversion"] > 0.9
    assert "x_H2S_wet" not in char.qoi and "volatiles [kg/m]" not in char.profiles


@pytest.mark.slow
def test_six_guesses_lead_to_two_states():
    found = {
        guess: solved(combustor(initial={"temperature": guess})).qoi
        for guess in (400.0, 700.0, 1000.0, 1150.0, 1500.0, 2000.0)
    }
    hot = [q["T_inert_mid_K"] for q in found.values() if q["ignited"]]
    cold = [q["T_inert_mid_K"] for q in found.values() if not q["ignited"]]
    assert found[400.0]["ignited"] == 0 and found[1500.0]["ignited"] == 1
    assert np.ptp(hot) < 0.1 and np.ptp(cold) < 0.1 and min(hot) > max(cold) + 300


@pytest.mark.slow
def test_energy_follows_the_heating_value():
    """More heat per kg of the same elements makes the bed hotter."""
    low, high = tables(), tables()
    low["solids"]["char"]["fuel"]["heating_value"] = 27e6
    high["solids"]["char"]["fuel"]["heating_value"] = 29e6
    a, b = (solved(from_dict(each)).qoi for each in (low, high))
    assert b["fuel_power_W"] - a["fuel_power_W"] == approx(2e6 * 0.035 * 0.92, rel=1e-9)
    assert b["T_inert_mid_K"] > a["T_inert_mid_K"] + 20


FUEL = ("solids", "char", "fuel")
BAD = {
    "sum to 1.1, not to 1": changed(tables(), {(*FUEL, "ultimate", "O"): 0.22}),
    "less than the fixed carbon": changed(tables(), {(*FUEL, "volatile_matter"): 0.1}),
    "no amounts of CO": changed(
        tables(), {FUEL: {**COAL, "ultimate": {"C": 0.15, "H": 0.01, "O": 0.74}, "volatile_matter": 0.9}}
    ),
    "far from the": changed(tables(), {(*FUEL, "heating_value"): 3e6}),
    "char.fuel.*needs solids.char.feed with a mass_flow": changed(tables(), {(*FUEL[:-1], "feed"): None}),
    "one solid phase may have it": changed(tables(), {("solids", "inert", "fuel"): COAL}),
    "removes its char": tables(drain=None, reactions={"drying": {"time": 1.0}, "devolatilisation": {"time": 1.0}}),
    "removes its moisture": tables(drain=None, reactions={k: v for k, v in BURNING.items() if k != "drying"}),
    "so that no steady state exists: add": tables(stone=True, drain=None),
    "there is no .solids.NAME.fuel.": without_fuel(),
    "did you mean 'howard'": tables(reactions=BURNING | {"CO_oxidation": {"law": "howrd"}}),
    "above the bed": changed(tables(), {(*FUEL[:-1], "feed", "height"): 2.0}),
    "has no use without": tables(reactions=None),
    "CO_oxydation: unknown reaction without an equation": tables(reactions={"CO_oxydation": {}}),
}  # fmt: skip


@pytest.mark.parametrize("text", BAD)
def test_bad_scenes_are_explained(text):
    refused(text, lambda: from_dict(BAD[text]))


def test_reactions_that_cannot_run_are_named():
    result = solved(
        tube("CO:0.3, H2O:0.3, N2:0.4", {"CO_oxidation": {}, "water_gas_shift": {}})
    )
    assert any("CO_oxidation does not run" in text for text in result.warnings)
    assert "x_O2_wet" not in result.qoi


def test_ash_has_the_heat_capacity_of_its_fuel():
    """To rounding, above 298.15 K; 1000 J/kg/K by default."""
    for keys, expected in (({}, 1e5), ({"ash_heat_capacity": 840.0}, 0.84e5)):
        scene = from_dict(changed(tables(), {FUEL: {**COAL, **keys}}))
        (ash,) = plan(scene).coefficients.computed.chemistry.part.ash
        assert ash.enthalpy(398.15) == approx(expected, rel=1e-12)


def test_a_fuel_of_nearly_all_ash_needs_its_heating_value():
    """The formula of Channiwala and Parikh holds up to 71 % of ash; at 99 % it gives
    less than nothing.
    """
    coked = {**COAL, "ash": 0.99, "volatile_matter": 0.0}
    coked |= {"moisture": 0.0, "ultimate": {"C": 0.01, "H": 0.0, "O": 0.0}}
    found = changed(tables(), {FUEL: coked})
    refused("heating_value: missing; the formula", lambda: from_dict(found))
    coked["heating_value"] = 0.328e6
    assert from_dict(changed(tables(), {FUEL: coked})).solids["char"].fuel.ash == 0.99
