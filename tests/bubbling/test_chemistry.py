"""Reactions of a bed as pure functions: elements, heats and equilibria against
Cantera, limits of char, yields.
"""

import cantera
import numpy as np
import pytest
from pytest import approx
from reacting_scenes import of_gases, particles

from contbed.bubbling_bed.chemistry import reactions as cr
from contbed.bubbling_bed.chemistry import scene as t
from contbed.bubbling_bed.chemistry import thermo
from contbed.bubbling_bed.chemistry.problem import fuel_data
from contbed.bubbling_bed.solids import Solid
from contbed.chemistry import char_and_lime as rs
from contbed.chemistry import devolatilisation as dv
from contbed.chemistry import power_law as r
from contbed.chemistry.elements import ATOMIC_WEIGHTS, elements_of
from contbed.chemistry.laws.gases import BY_REACTION
from contbed.chemistry.thermo import R_GAS, T_STANDARD
from contbed.errors import SceneError
from contbed.fem.ad.dual import Dual

ALL = [
    law for laws in (BY_REACTION | rs.CHAR_LAWS).values() for law in laws.values()
] + [
    rs.CALCINATION,
    rs.SULPHATION,
    rs.SULPHATE_REDUCTION,
]
T = np.array([600.0, 900.0, 1123.0, 1500.0])
GAS = {item.name: item for item in cantera.Species.list_from_file("nasa_gas.yaml")}
SOLID = {
    item.name: item for item in cantera.Species.list_from_file("nasa_condensed.yaml")
}
FUELS = {  # mass fractions of the dry, ash-free fuel, volatile matter
    "bituminous coal": (
        {"C": 0.83, "H": 0.055, "O": 0.08, "N": 0.015, "S": 0.02},
        0.38,
    ),
    "brown coal": ({"C": 0.667, "H": 0.048, "O": 0.274, "N": 0.008, "S": 0.003}, 0.53),
    "peat": ({"C": 0.569, "H": 0.058, "O": 0.351, "N": 0.019, "S": 0.003}, 0.684),
    "sawdust": ({"C": 0.503, "H": 0.061, "O": 0.435, "N": 0.001, "S": 0.0}, 0.83),
}


def ln_K(stoichiometry, T):
    """ln K of a reaction at 1 atm, the reference of Cantera's data."""
    gases = sum(n for name, n in stoichiometry.items() if name in thermo.GASES)
    at_bar = thermo.equilibrium(stoichiometry).ln_K(T)
    return at_bar - gases * np.log(1.01325)


def reference(name):
    return GAS[name] if name in thermo.GASES else SOLID[thermo.SOLIDS[name]]


@pytest.mark.parametrize("law", ALL, ids=lambda law: f"{law.name} {law.reaction}")
def test_reactions_hold_elements_mass_and_cite_their_source(law):
    species = thermo.table()
    change = {}
    for name, count in law.stoichiometry.items():
        for element, atoms in species[name].composition.items():
            change[element] = change.get(element, 0.0) + count * atoms
    assert max(map(abs, change.values())) == 0.0  # small integers and halves are exact
    assert (
        abs(
            sum(
                count * species[name].molar_mass
                for name, count in law.stoichiometry.items()
            )
        )
        < 1e-16
    )
    assert (
        "doi:" in law.source or "DOE/" in law.source or "no measurement" in law.source
    )
    assert np.all(np.diff(law.constant(T)) > 0)


@pytest.mark.parametrize("law", ALL, ids=lambda law: f"{law.name} {law.reaction}")
def test_heats_of_reaction_are_those_of_cantera(law):
    for temperature in T[T < 1200]:  # CaCO3 ends there
        exact = (
            sum(
                n * reference(name).thermo.h(temperature)
                for name, n in law.stoichiometry.items()
            )
            / 1e3
        )
        # published coefficients jump by up to 1 J/mol at 1000 K, which is smoothed here
        assert float(thermo.equilibrium(law.stoichiometry).heat(temperature)) == approx(
            exact, abs=2.0
        )


@pytest.mark.parametrize(
    "law", [law for law in ALL if law.reversible], ids=lambda law: law.reaction
)
def test_equilibrium_constants_are_those_of_cantera(law):
    for temperature in T[T < 1200]:
        g = sum(
            n * reference(name).thermo.h(temperature)
            - n * temperature * reference(name).thermo.s(temperature)
            for name, n in law.stoichiometry.items()
        )
        exact = -g / (cantera.gas_constant * temperature)
        assert float(ln_K(law.stoichiometry, temperature)) == approx(exact, abs=2e-4)


def test_published_equilibria():
    pressure = np.exp(ln_K(rs.CALCINATION.stoichiometry, 1171.0)) * 101325.0
    # 898 degC: 101 kPa, Handbook of Chemistry and Physics
    assert pressure == approx(101e3, rel=0.1)
    shift = BY_REACTION["water_gas_shift"]["biba"].stoichiometry
    assert np.exp(ln_K(shift, 1100.0)) == approx(
        0.0265 * np.exp(3968.0 / 1100.0), rel=0.06
    )


def test_slopes_by_temperature_are_exact():
    at = Dual(T, {"T": 1.0})
    species = thermo.table()
    for function in (
        species["CO2"].enthalpy,
        species["CaCO3"].enthalpy,
        species["H2O"].heat_capacity,
        lambda T: ln_K({"CO": -1.0, "H2O": -1.0, "CO2": 1.0, "H2": 1.0}, T),
        rs.lime_surface,
        rs.carbon_per_oxygen,
    ):
        found = function(at).tangents["T"]
        assert found == approx(
            (function(T + 1e-2) - function(T - 1e-2)) / 2e-2, rel=1e-6, abs=1e-9
        )


@pytest.mark.parametrize("name", ["water_gas_shift", "reforming"])
def test_reversible_reactions_stand_still_in_equilibrium_with_detailed_balance(name):
    gas = cantera.Solution(
        thermo="ideal-gas",
        species=[GAS[key] for key in ("CO", "H2O", "CO2", "H2", "CH4", "N2")],
    )
    gas.TPX = 1150.0, 1.2e5, "CO:2, H2O:3, CH4:1, N2:4"
    gas.equilibrate("TP")
    law = next(iter(BY_REACTION[name].values()))
    concentration = dict(zip(gas.species_names, 1e3 * gas.concentrations, strict=True))
    item = of_gases(name)
    forward = float(law.rate(1150.0, concentration, 0.0))
    # what Cantera's own solver of equilibria leaves, 1e-9, and the smoothing at 1000 K
    assert abs(item.rate(1150.0, concentration, 1.2e5, {})) < 1e-4 * forward
    made, lost = ("CO2", "CO") if name == "water_gas_shift" else ("H2", "H2O")
    assert (
        item.rate(1150.0, concentration | {made: 1.1 * concentration[made]}, 1.2e5, {})
        < 0
    )
    assert (
        item.rate(1150.0, concentration | {lost: 1.1 * concentration[lost]}, 1.2e5, {})
        > 0
    )


def test_fractional_orders_are_straight_below_a_trace():
    law = BY_REACTION["CO_oxidation"]["howard"]
    full = {"CO": 0.1, "O2": 1.0, "H2O": 1.0}
    assert law.rate(1100.0, full, 1e-4) == approx(law.constant(1100.0) * 0.1, rel=1e-8)
    assert law.rate(1100.0, full | {"O2": 0.0}, 1e-4) == 0.0
    # what is missing is given back
    assert law.rate(1100.0, full | {"O2": -1e-6}, 1e-4) < 0.0
    assert r.power(1e-8, 0.25, 1e-4) == approx(1e-8 * 1e-4**-0.75, rel=1e-7)


def char(model="shrinking", diameter=2e-3, **factors):
    laws = {
        name: (law, t.CharCombustion(factor=factors.get(name, 1.0)))
        for name, laws in rs.CHAR_LAWS.items()
        for law in laws.values()
    }
    return cr.Char("char", diameter, 800.0, model, 1.5, laws)


def test_char_burns_at_the_limits_of_kinetics_and_of_the_film():
    p, C = 1e5, 0.5
    kinetic, film = char(char_combustion=1e-9), char(char_combustion=1e12)
    law = rs.CHAR_LAWS["char_combustion"]["field"]
    assert kinetic.combustion_rate(1100.0, 1100.0, C, p) == approx(
        kinetic.surface * 1e-9 * law.constant(1100.0) * C
    )
    D = rs.diffusion_in_nitrogen("O2", 0.031998, 1100.0, p)
    assert film.combustion_rate(1100.0, 1100.0, C, p) == approx(
        film.surface * 1.5 * D / (0.8 * 2e-3) * C
    )
    CO = cr.Char(
        "char",
        2e-3,
        800.0,
        "shrinking",
        1.5,
        {"char_combustion": (law, t.CharCombustion(products="CO", factor=1e12))},
    )
    assert CO.combustion_rate(1100.0, 1100.0, C, p) == approx(
        2.0 * film.combustion_rate(1100.0, 1100.0, C, p)
    )


def test_diffusion_of_oxygen_in_nitrogen():
    """Measured: 0.181 cm2/s at 273 K and 1 atm (Marrero and Mason 1972,
    doi:10.1063/1.3253094).
    """
    assert rs.diffusion_in_nitrogen("O2", 0.031998, 273.15, 101325.0) == approx(
        1.81e-5, rel=0.05
    )


@pytest.mark.parametrize("model", rs.POPULATIONS)
def test_population_of_a_mixed_bed_by_quadrature(model):
    """Particles spend 1/|dr/dt| at each size (shrinking), or at each density: the
    mean rate is that of `Population`.
    """
    d, k, ShD = 2e-3, 0.05, 3e-4
    # share of the diameter, or of the carbon, that is left
    s = (np.arange(20000) + 0.5) / 20000
    size = s * d if model == "shrinking" else np.full_like(s, d)
    speed = 1.0 / (1.0 / k + size / ShD)  # per surface and concentration
    time = 1.0 / speed if model == "shrinking" else np.ones_like(s)
    volume = np.pi / 6.0 * (size**3 if model == "shrinking" else d**3 * s)
    mean = (time * np.pi * size**2 * speed).sum() / (time * volume).sum()
    population = rs.POPULATIONS[model]
    found = population.surface / d / (1.0 / k + population.film * d / ShD)
    assert found == approx(mean, rel=1e-6)  # of the midpoint rule


def test_gasification_stands_still_in_equilibrium_and_is_held_by_the_film():
    x = {"CO2": 0.2, "N2": 0.5}
    K = np.exp(ln_K(rs.CHAR_LAWS["char_CO2"]["barrio"].stoichiometry, 1150.0))
    x["CO"] = float((K * x["CO2"] / (2e5 / 101325.0)) ** 0.5)
    rate = char().gasification_rate("char_CO2", 1150.0, 1150.0, x, 2e5)
    assert abs(rate) < 1e-9 * char().gasification_rate(
        "char_CO2", 1150.0, 1150.0, x | {"CO": 0.0}, 2e5
    )
    film = char(char_steam=1e15)
    D = rs.diffusion_in_nitrogen("H2O", 0.018015, 1150.0, 1e5)
    flux = film.surface * 1.5 * D / (0.8 * 2e-3) * 0.3 * 1e5 / (R_GAS * 1150.0)
    assert film.gasification_rate(
        "char_steam", 1150.0, 1150.0, {"H2O": 0.3, "CO": 0.0, "H2": 0.0}, 1e5
    ) == approx(flux)


def test_lime_calcines_above_its_equilibrium_and_fills_with_sulphate():
    lime = cr.Lime("stone", 1e-3, 2600.0, 1.0, 1.0, 0.4)
    equal = float(np.exp(ln_K(rs.CALCINATION.stoichiometry, 1100.0))) * 101325.0
    assert (
        lime.calcination_rate(1100.0, 0.5 * equal, 1.0, 1.0)
        > 0
        > lime.calcination_rate(1100.0, 1.5 * equal, 1.0, 1.0)
    )
    assert abs(
        lime.calcination_rate(1100.0, equal, 1.0, 1.0)
    ) < 1e-4 * lime.calcination_rate(1100.0, 0.0, 1.0, 1.0)
    assert lime.sulphation_rate(1120.0, 0.01, 0.6, 0.4) < 1e-6 * lime.sulphation_rate(
        1120.0, 0.01, 1.0, 0.0
    )
    # 490 cm4/mol/s exp(-17,500 cal/mol / RT) times the surface [cm2/g] is k_v [1/s],
    # halfway up its rising branch
    assert lime.sulphation_rate(1150.0, 0.01, 2.0, 0.0) == approx(
        490.0
        * np.exp(-17500.0 * 4.184 / 8.314462618 / 1150.0)
        * (35.9 * 1150.0 - 3.67e4)
        * 0.01
        * 2.0
        * lime.volume,
        rel=3e-3,  # the branches of the surface are joined smoothly
    )
    surface = rs.lime_surface(np.array([1000.0, 1248.0, 1500.0]))
    assert surface[1] > 7000 and surface[0] < 10 and surface[2] < 10


def test_sulphate_gives_off_sulphur_dioxide_up_to_its_equilibrium():
    """The rate constant of the scene at 850 degC, first order in CO beyond
    equilibrium and in sulphate, 0 behind it.
    """
    lime = cr.Lime("stone", 1e-3, 2600.0, None, 1.0, 0.4, 2e-7)
    p = {"CO": 500.0, "CO2": 0.0, "SO2": 0.0}
    assert lime.reduction_rate(1123.15, p, 3.0) == approx(2e-7 * 500.0 * 3.0, rel=1e-6)
    assert lime.reduction_rate(1123.15, p | {"CO": 1000.0}, 3.0) == approx(
        2e-7 * 1000.0 * 3.0, rel=1e-6
    )
    growth = np.exp(57.8e3 * 4.184 / R_GAS * (1.0 / 1123.15 - 1.0 / 1200.0))
    assert lime.reduction_rate(1200.0, p, 3.0) == approx(
        2e-7 * growth * 500.0 * 3.0, rel=1e-6
    )
    K = float(
        np.exp(ln_K({"CaSO4": -1, "CO": -1, "CaO": 1, "SO2": 1, "CO2": 1}, 1123.15))
    )
    equal = p | {"CO2": 15000.0, "SO2": K * 101325.0 * 500.0 / 15000.0}
    assert lime.reduction_rate(1123.15, equal, 3.0) < 2e-4 * lime.reduction_rate(
        1123.15, p, 3.0
    )
    beyond = equal | {"SO2": 2.0 * equal["SO2"]}
    assert (
        0.0
        < lime.reduction_rate(1123.15, beyond, 3.0)
        < 1e-6 * lime.reduction_rate(1123.15, p, 3.0)
    )


@pytest.mark.parametrize("name", FUELS)
def test_volatiles_hold_every_element(name):
    ultimate, V = FUELS[name]
    found = dv.volatiles(ultimate, V)
    species = thermo.table()
    for element in "CHONS":
        made = sum(
            n * species[gas].composition.get(element, 0.0)
            for gas, n in found.yields.items()
        )
        given = (
            (ultimate[element] - (1.0 - V if element == "C" else 0.0))
            / ATOMIC_WEIGHTS[element]
            / V
        )
        assert made == approx(given, rel=1e-12, abs=1e-12)
    assert min(found.yields.values()) > 0
    assert sum(
        n * species[gas].molar_mass for gas, n in found.yields.items()
    ) == approx(1.0, rel=1e-12)


def test_a_guess_that_holds_the_elements_is_kept():
    guess = {"CO": 3.0, "CO2": 1.0, "H2O": 2.0, "H2": 4.0, "CH4": 1.0, "C6H6": 0.5}
    elements = [
        sum(n * elements_of(gas).get(e, 0) for gas, n in guess.items())
        for e in dv.BALANCED
    ]
    assert dv.balanced(guess, elements) == approx(guess, rel=1e-13)
    with pytest.raises(SceneError, match="no amounts"):
        dv.balanced(guess, [1.0, 1.0, 5.0])  # more oxygen than CO2 and H2O can hold


def fuel(**changes):
    table = {
        "moisture": 0.1,
        "ash": 0.08,
        "volatile_matter": 0.38,
        "heating_value": 30e6,
        "ultimate": {"C": 0.7636, "H": 0.0506, "O": 0.0736, "N": 0.0138, "S": 0.0184},
    }
    feed = {"mass_flow": 0.02, "temperature": 300.0, "height": 0.2, "width": 0.05}
    return Solid.model_validate(
        particles(0.02, 2e-3, 900.0, fuel=table | changes, feed=feed)
    )


def test_heat_of_formation_gives_the_heating_value_back():
    """Burn a kg of dry fuel, volatiles and char, to CO2, liquid water and SO2 at
    298.15 K.
    """
    data, species, T0 = fuel_data(fuel()), thermo.table(), T_STANDARD
    e = {name: n / data.rate for name, n in data.elements.items()}
    products = {
        "CO2": e["C"],
        "H2O(l)": 0.5 * e["H"],
        "SO2": e["S"],
        "N2": 0.5 * e["N"],
    }
    oxygen = e["C"] + 0.25 * e["H"] + e["S"] - 0.5 * e["O"]
    left = 0.38 * data.enthalpy + 0.62 / ATOMIC_WEIGHTS["C"] * float(
        species["C"].enthalpy(T0)
    )
    left += oxygen * float(species["O2"].enthalpy(T0))
    right = sum(n * float(species[name].enthalpy(T0)) for name, n in products.items())
    # O2, N2 and graphite are off zero by 10 J/mol at 298.15 K
    assert (left - right) * 0.92 == approx(30e6, rel=1e-4)
    assert 28e6 < data.lower * 0.92 < 30e6
    assert fuel_data(fuel(heating_value=None)).heating_value == approx(31.8e6, rel=0.03)
