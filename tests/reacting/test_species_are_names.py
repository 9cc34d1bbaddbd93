"""Species of a mechanism are names: their atoms are those of the mechanism, whatever
formula a name looks like.
"""

import math
from pathlib import Path

import cantera
import pytest
from pytest import approx

import contbed as cb
from contbed import models
from contbed.chemistry.elements import ATOMIC_WEIGHTS
from contbed.chemistry.species import solid_species
from contbed.loading import loads
from tests.refusals import refused

DATA = Path(__file__).parents[1] / "data"
HEPTANE = """
mesh = { type = "line", length = "0.5 m" }
gas = { model = "cantera", mechanism = "hept.yaml", composition = "NC7H16:0.01, O2:0.21, N2:0.78", pressure = "2 bar" }
solids.pellets = { density = 1200, diameter = "3 mm" }
packed_bed.porosity = 0.4
boundary.left.gas = { velocity = "0.5 m/s", temperature = "600 K" }
output = { plots = false, fields = false }
[heat]
[reactions.r]
equation = "NC7H16 + 11 O2 -> 7 CO2 + 8 H2O"
A = 1e-3
E = 0
basis = "catalyst"
"""
# the names are also symbols of elements, boron, and of what is none
ISOMERS = """
phases:
- {name: gas, thermo: ideal-gas, elements: [C, H, N, O], species: [{species: [A, B]}, {gri30.yaml/species: [N2]}],
   transport: mixture-averaged, state: {T: 300.0, P: 1 atm}}
species:
"""
ISOMER = """- name: %s
  composition: {C: 2, H: 4}
  thermo:
    model: NASA7
    temperature-ranges: [200.0, 1000.0, 3500.0]
    data: [[4.0, 0.0, 0.0, 0.0, 0.0, %s, 0.0], [4.0, 0.0, 0.0, 0.0, 0.0, %s, 0.0]]
  transport: {model: gas, geometry: nonlinear, diameter: 4.0, well-depth: 250.0}
"""


@pytest.mark.parametrize("more", [{}, {"elements.C": 7.0, "elements.H": 16.0}])
def test_heptane_burns(more):
    """All that burns is CO2 and steam, and the gas leaves with the enthalpy that it
    had.
    """
    keys = {f"gas.species.NC7H16.{key}": value for key, value in more.items()}
    result = cb.run(loads(HEPTANE, overrides=keys, base=DATA))
    assert result.status == "ok"
    q = result.qoi
    burnt = q["extent_r_mol_m2s"]
    assert q["out_CO2_mol_m2s"] == approx(7.0 * burnt, rel=1e-9)
    assert q["out_H2O_mol_m2s"] == approx(8.0 * burnt, rel=1e-9)
    names = ("NC7H16", "O2", "N2", "CO2", "H2O")
    gas = cantera.Solution(str(DATA / "hept.yaml"))
    gas.TPX = 600.0, 2e5, "NC7H16:0.01, O2:0.21, N2:0.78"
    entering = gas.enthalpy_mass
    gas.HPX = entering, 2e5, {name: q[f"x_{name}_out"] for name in names}
    assert q["T_fluid_out_K"] == approx(gas.T, rel=1e-6)


def test_what_does_not_balance_is_named_by_the_atoms_of_the_mechanism():
    wrong = HEPTANE.replace("7 CO2", "6 CO2")
    refused(r"r\.equation = .*loses 1 atoms of C", loads, wrong, base=DATA)


def test_a_name_in_other_letters_leads_to_that_of_the_mechanism():
    for name in ("nc7h16", "Nc7h16"):
        wrong = HEPTANE.replace("NC7H16 +", f"{name} +")
        refused(
            rf"r\.equation.*there is no {name}; write NC7H16$", loads, wrong, base=DATA
        )
    wrong = HEPTANE.replace("N2:0.78", "n2:0.78")
    scene = loads(wrong, base=DATA)
    refused(r"n2 is neither a gas .*; write N2$", models.plan, scene)


OXIDE = """
model = "packed_bed"
mesh = { type = "line", length = 0.1, cells = 4 }
solids.oxide = { diameter = 0.003, density = 3000, composition = "CuO:0.2, Co:0.8" }
packed_bed.porosity = 0.4
boundary.left.gas = { mass_flux = 0.2, temperature = 900 }
time.end = 60

[gas]
model = "ideal_gas"
composition = "H2:0.2, N2:0.8"
species = { H2 = {}, N2 = {} }
viscosity = 3e-5

[reactions.reduction]
equation = "CuO + H2 -> Cu + H2O"
rate = "k*n_CuO"
parameters.k = 1e-3
"""


def test_gases_that_are_not_declared_are_no_solids():
    """Steam of a bed at 900 K is no ice; carbon monoxide is no cobalt; copper, which
    is not declared either, is a solid of Cantera's tables.
    """
    way = r"in \[gas\.species\.{0}\] or \[solids\.NAME\.constituent\.{0}\]$"
    refused(way.format("H2O"), models.plan, loads(OXIDE))
    carbon = OXIDE.replace("H2 -> Cu + H2O", "CO -> Cu + CO2")
    carbon = carbon.replace("N2 = {}", "N2 = {}, CO2 = {}")
    refused(way.format("CO"), models.plan, loads(carbon))
    models.plan(loads(OXIDE.replace("N2 = {}", "N2 = {}, H2O = {}")))


def test_hydroxides_keep_their_brackets():
    """Fe(OH)3(s) of Cantera's tables is no iron; the last bracket names its phase."""
    scene = OXIDE.split("[reactions")[0].replace("N2 = {}", "N2 = {}, H2O = {}")
    scene = (
        scene.replace("CuO", "Fe(OH)3")
        + """
        [reactions.calcination]
        equation = "2 Fe(OH)3 -> Fe2O3 + 3 H2O"
        law = "power"
        A = 1e-3
        E = 0.0
        orders = { "Fe(OH)3" = 1.0 }
    """
    )
    (phase,) = models.plan(loads(scene)).problem.species.phases.values()
    # JANAF: -832.6 kJ/mol
    formed = phase.all["Fe(OH)3"].enthalpy(298.15)
    assert formed == approx(-832.6e3, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "formed"), [("Ca(OH)2", -986.1e3), ("Al2O3", -1675.7e3)]
)
def test_solids_of_tables_that_are_written_in_another_way(name, formed):
    """CaO2H2 and AL2O3 of Cantera's tables; JANAF."""
    assert solid_species(name, None, True).enthalpy(298.15) == approx(formed, rel=1e-3)


def test_every_element_is_known():
    """Those that have a standard atomic weight, which Cantera has as well."""
    weights = {}
    for symbol in cantera.Element.element_symbols:
        try:
            weights[symbol] = cantera.Element(symbol).weight
        except cantera.CanteraError:
            continue
    assert ATOMIC_WEIGHTS.keys() == weights.keys()
    for symbol, weight in weights.items():
        assert ATOMIC_WEIGHTS[symbol] == approx(1e-3 * weight, rel=1e-4)


def test_a_name_with_a_remark_is_a_species():
    """CH2(S) is singlet methylene, and holds no sulphur."""
    relaxed = HEPTANE.replace("NC7H16 + 11 O2 -> 7 CO2 + 8 H2O", "CH2(S) -> CH2")
    scene = loads(relaxed.replace("NC7H16:0.01", "CH2(S):0.01"), base=DATA)
    assert cb.run(scene).qoi["x_CH2_out"] > 0.0


def test_isomers_of_any_name(tmp_path):
    """A -> B of first order at one temperature: what is left falls exponentially."""
    one, other = (ISOMER % (name, h, h) for name, h in (("A", 6e3), ("B", 5e3)))
    (tmp_path / "isomers.yaml").write_text(ISOMERS + one + other, encoding="utf-8")
    text = HEPTANE.replace("[heat]", "").replace("hept.yaml", "isomers.yaml")
    text = text.replace("NC7H16:0.01, O2:0.21, N2:0.78", "A:0.01, N2:0.99")
    text = text.replace("NC7H16 + 11 O2 -> 7 CO2 + 8 H2O", "A -> B")
    text = text.replace(
        "porosity = 0.4", 'porosity = 0.4\npacked_bed.pressure_drop = "none"'
    )
    q = cb.run(loads(text, base=tmp_path)).qoi
    left = math.exp(-1e-3 * 1200.0 * (1.0 - 0.4) * 0.5 / 0.5)
    assert q["conversion_A"] == approx(1.0 - left, rel=1e-6)
    assert q["x_B_out"] == approx(0.01 * (1.0 - left), rel=1e-6)


def test_solids_of_an_isothermal_bed_need_no_thermodynamics():
    """Neither the inert alumina nor the oxide, which Cantera does not have; and calcium
    carbonate, which the scene names in the equation alone, is a solid of Cantera.
    """
    text = HEPTANE.replace("[heat]", "").replace("NC7H16:0.01, O2:0.21", "CO2:0.22")
    text = text.replace("NC7H16 + 11 O2 -> 7 CO2 + 8 H2O", "CaO + CO2 -> CaCO3")
    text = text.replace(
        "density = 1200", 'density = 1200, composition = "CaO:0.4, Al2O3:0.6"'
    )
    law = 'law = "grain"\ngrain_radius = 1e-6\nmolar_density = 6e4'
    text = text.replace('basis = "catalyst"', law)
    text = text.replace("A = 1e-3", "A = 1e-8")
    text = text.replace("hept.yaml", "gri30.yaml") + "[time]\nend = 10\n"
    given = {"heat_capacity": 79.0, "enthalpy": -1.675e6}
    alumina = {f"solids.pellets.constituent.Al2O3.{k}": v for k, v in given.items()}
    bare, full = (cb.run(loads(text, overrides=more)) for more in ({}, alumina))
    assert 0.0 < bare.qoi["conversion_CO2"] == full.qoi["conversion_CO2"]
    wrong = text.replace("[reactions.r]", "[heat]\n[reactions.r]")
    wrong = wrong.replace("Al2O3", "ZnO")
    refused("ZnO has no thermodynamics", models.plan, loads(wrong))
