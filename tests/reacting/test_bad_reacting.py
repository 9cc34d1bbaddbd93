"""Mistakes in scenes of reacting beds: what is wrong, where, and the remedy."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from contbed.chemistry.mixture import fuller_volume
from contbed.chemistry.species import atoms_of
from contbed.errors import SceneError
from contbed.loading import loads
from contbed.models import plan
from tests.cases import each_case
from tests.refusals import refused

GOOD = """
[mesh]
type = "line"
length = 1.0

[gas]
model = "ideal_gas"
composition = "CH4:0.5, O2:0.5"

[gas.species]
CH4 = { heat_capacity = 40.0, enthalpy = -74.8e3 }
O2 = { heat_capacity = 30.0 }
CO2 = { heat_capacity = 40.0, enthalpy = -393.5e3 }
H2O = { heat_capacity = 35.0, enthalpy = -241.8e3 }

[solids.particles]
diameter = "3 mm"

[packed_bed]
porosity = 0.4

[reactions.burning]
equation = "CH4 + 2 O2 -> CO2 + 2 H2O"
A = 1.0
E = "50 kJ/mol"

[boundary.left]
gas.velocity = 0.5
gas.temperature = 500.0
"""
SOLID = """
composition = "FeO:1"
density = 3000.0
constituent = { FeO = { heat_capacity = 50.0 }, Fe = { heat_capacity = 30.0 } }
"""


def filled(text, particles=SOLID):
    """The scene with more of its particles."""
    return text.replace('diameter = "3 mm"\n', f'diameter = "3 mm"{particles}')


def test_the_scene_without_mistakes_is_taken():
    assert loads(GOOD).kind == "reacting_bed"


@each_case(__file__, "mistakes_of_gas_reactions")
def test_mistakes_of_gas_reactions(old, new, said):
    with pytest.raises(SceneError) as found:
        loads(GOOD.replace(old, new), "bed.toml")
    assert said in str(found.value)
    assert "bed.toml:" in str(found.value)


@each_case(__file__, "mistakes_of_formulas")
def test_mistakes_of_formulas(rate, said):
    text = GOOD.replace('A = 1.0\nE = "50 kJ/mol"', rate)
    with pytest.raises(SceneError, match=r"bed\.toml:") as found:
        loads(text, "bed.toml")
    assert said in str(found.value)


@each_case(__file__, "mistakes_of_reacting_solids")
def test_mistakes_of_reacting_solids(key):
    law = f'law = "shrinking_core"\ndiffusivity = 1e-6\nA = 1.0\n{key}'
    text = filled(GOOD).replace("CH4 + 2 O2 -> CO2 + 2 H2O", "2 Fe + O2 -> 2 FeO")
    name = key.partition(" ")[0]
    refused(
        f"{name}.*: has no meaning with the law shrinking_core",
        loads,
        text.replace("A = 1.0", law),
    )


@each_case(__file__, "properties_that_are_negative_where_streams_enter")
def test_properties_that_are_negative_where_streams_enter(old, new, said):
    text = (filled(GOOD) + "[heat]\n[time]\nend = 1.0\n").replace(old, new)
    refused(r"bed\.toml:\d+: .*" + said, loads, text, "bed.toml")


def test_solids_at_rest_have_no_steady_state():
    text = filled(
        GOOD.replace("CH4 + 2 O2 -> CO2 + 2 H2O", "CH4 + 4 FeO -> CO2 + 2 H2O + 4 Fe")
    )
    refused("are used up: no steady state exists", loads, text)


IN_TIME = """
[time]
end = 3.0
"""
CHAR = """
composition = "C:1"
density = 1000.0
constituent.C.heat_capacity = 20.0
"""
GRAINS = "grain_radius = 1e-6\nmolar_density = 1e5\nA = 1.0\nE = 0.0"


@pytest.mark.parametrize(
    ("law", "said"),
    [
        ('rate = "0.1*c_O2*(1 - X)"', r"rate = .*: the conversion X counts"),
        (f'law = "grain"\n{GRAINS}', "law = .*: the law grain counts"),
        (
            'law = "shrinking_core"\nA = 1e-3\nE = 0.0\ndiffusivity = 1e-9',
            "law = .*: the law shrinking_core counts",
        ),
    ],
)
def test_the_conversion_of_a_solid_that_leaves_as_gas_is_not_known(law, said):
    """Nothing stays in the bed by which to count what has reacted."""
    text = GOOD.replace("CH4 + 2 O2 -> CO2 + 2 H2O", "C + O2 -> CO2")
    text = filled(text.replace('A = 1.0\nE = "50 kJ/mol"', law), CHAR) + IN_TIME
    refused(
        rf"bed\.toml:\d+: reactions.burning.{said} .* write a formula with n_C",
        loads,
        text,
        "bed.toml",
    )


def test_species_without_thermodynamics():
    from contbed import models

    text = GOOD.replace("H2O = { heat_capacity = 35.0, enthalpy = -241.8e3 }", "")
    refused(
        r"bed.toml:22: reactions.burning: H2O is neither a gas of \[gas.species\]",
        lambda: models.plan(loads(text, "bed.toml")),
    )


def test_gas_that_cannot_pass_is_told():
    import contbed
    from contbed.errors import ConvergenceError

    text = GOOD.replace(
        '"CH4:0.5, O2:0.5"', '"CH4:0.5, O2:0.5"\nviscosity = 2e-5'
    ).replace("velocity = 0.5", "velocity = 9.0")
    with pytest.raises(
        ConvergenceError,
        match=r"the gas cannot pass the bed: by closures\.permeability",
    ):
        contbed.run(loads(text))


FAST = GOOD.replace("temperature = 500.0", "temperature = 700.0").replace(
    'A = 1.0\nE = "50 kJ/mol"', 'A = 1e14\nE = "150 kJ/mol"'
)


def with_pressure(text):
    """The scene with a pressure that Ergun's equation takes from the gas."""
    text = text.replace('O2:0.5"', 'O2:0.5"\nviscosity = 2e-5')
    bed = 'porosity = 0.4\npressure_drop = "ergun"\ngas_storage = "stored"'
    text = filled(text, "\ndensity = 1000.0\nheat_capacity = 800.0\n")
    return text.replace("porosity = 0.4", bed) + IN_TIME


@pytest.mark.parametrize(
    ("text", "said"),
    [
        # whose cells are halved before it is given up
        (
            FAST + "[heat]\n",
            r"converged is 0 s; the largest residual is that of T at x = 0 m\. Give initial\.temperature",
        ),
        (
            with_pressure(FAST + "[heat]\n"),
            r"the largest residual is that of \w+ at x = \S+ m at t = 0 s; use more mesh\.cells",
        ),
    ],
)
def test_what_fails_names_its_place(text, said):
    import contbed
    from contbed.errors import ConvergenceError

    with pytest.raises(ConvergenceError, match=said):
        contbed.run(loads(text))


def test_pressures_that_are_not_found_are_told(monkeypatch):
    """Before the first step those of a gas that is stored are sought; here in one
    iteration.
    """
    import contbed
    from contbed.errors import ConvergenceError
    from contbed.reacting_bed import solve

    monkeypatch.setattr(solve, "FIRST_ITERATIONS", 1)
    with pytest.raises(
        ConvergenceError,
        match=r'bed\.toml: .* at x = .* are sought; give packed_bed\.pressure_drop = "none"',
    ):
        contbed.run(loads(with_pressure(GOOD), "bed.toml"))


SECTION = """
[boundary.wall]
coefficient = 100.0
ambient = 600.0
[heat]
[packed_bed.section]
dispersion = "vdi"
"""


@pytest.mark.parametrize("table", ["closures", "packed_bed.section"])
def test_a_plan_finds_a_conductivity_of_solids_that_is_missing(table):
    text = GOOD.replace(
        'model = "ideal_gas"',
        'model = "ideal_gas"\nconductivity = 0.04\nviscosity = 2e-5',
    )
    text = text.replace("length = 1.0", "length = 1.0\ndiameter = 0.05")
    key = 'conductivity_solids = "zehner_schluender"\nconductivity_gas = 0.0\n'
    text += SECTION + (key if table != "closures" else f"[closures]\n{key}")
    with pytest.raises(
        SceneError, match=r"solids\.\w+\.conductivity: missing"
    ) as error:
        plan(loads(text, "bed.toml"))
    assert "NAME" not in str(error.value)


@pytest.mark.parametrize("table", ["closures", "packed_bed.section"])
@pytest.mark.parametrize(
    ("gas", "said"),
    [
        ('conductivity_gas = "phase"', "eps k_gas adds"),
        ('conductivity_gas = "zehner_schluender"', "conductivity_gas adds"),
        ("conductivity_gas = 0.0", None),
        ("", None),
    ],
)
def test_a_conductivity_of_the_whole_bed_beside_that_of_the_gas_is_told(
    table, gas, said
):
    whole = f'conductivity_solids = "zehner_schluender"\n{gas}\n'
    text = GOOD.replace(
        'model = "ideal_gas"', 'model = "ideal_gas"\nconductivity = 0.04'
    )
    text = filled(
        text, "\ndensity = 2000.0\nconductivity = 1.0\nheat_capacity = 900.0\n"
    )
    text = text.replace("length = 1.0", "length = 1.0\ndiameter = 0.05") + SECTION
    text += whole if table == "packed_bed.section" else f"[closures]\n{whole}"
    warnings = loads(text, "bed.toml").warnings
    assert len(warnings) == (said is not None)
    for warning in warnings:
        assert f"{table}.conductivity_solids" in warning and said in warning
        assert warning.endswith(f"a second time; give {table}.conductivity_gas = 0")


def test_a_heat_capacity_per_mass_of_a_constituent_is_reported():
    """Iron has 450 J/kg/K, 25 J/mol/K: only the first is beyond all solids."""
    shaft = Path(__file__).parents[2] / "studies" / "dri_shaft" / "h2_5m.toml"
    text = shaft.read_text(encoding="utf-8")
    iron = "shomate = [17.27992, 26.69392, 0.0, 0.0, 0.0]\n"
    assert iron in text
    for value, warns in ((450.0, True), (25.0, False)):
        scene = loads(text.replace(iron, f"heat_capacity = {value}\n"), "bed.toml")
        found = [each for each in scene.warnings if "more than any solid" in each]
        assert bool(found) == warns, value


def test_moisture_of_solids_has_the_heat_capacity_of_water():
    """75.3 J/mol/K is 4180 J/kg/K."""
    wet = filled(GOOD).replace("Fe = {", "H2O = { heat_capacity = 75.3 }, Fe = {")
    assert not [each for each in loads(wet).warnings if "more than any" in each]


@pytest.mark.parametrize("density", ["1e5", '"1e5 mol/m**3"', '"100 kmol/m3"'])
def test_moles_of_a_grain_take_a_unit(density):
    law = f'law = "grain"\ngrain_radius = 1e-6\nmolar_density = {density}\nA = 1.0'
    text = filled(GOOD).replace("CH4 + 2 O2 -> CO2 + 2 H2O", "2 Fe + O2 -> 2 FeO")
    text += "\n[time]\nend = 1.0\n"
    found = loads(text.replace("A = 1.0", law)).reactions["burning"].molar_density
    assert found == pytest.approx(1e5, rel=1e-15)


@pytest.mark.parametrize(("name", "meant"), [("NIO", "NiO"), ("CUO", "CuO")])
def test_names_in_capitals_that_read_as_iodine_or_uranium_are_refused(name, meant):
    with pytest.raises(SceneError, match=f"write {meant}"):
        atoms_of(name, None, None)
    assert atoms_of("HI", None, None) == {"H": 1.0, "I": 1.0}


def test_argon_has_its_diffusion_volume_by_any_name():
    """Mechanisms write AR."""
    assert fuller_volume(SimpleNamespace(name="AR", composition={"Ar": 1})) == 16.2


def test_wustite_is_not_the_oxide_of_tables():
    """Tables hold FeO, whose K with hydrogen is less than half of that of wustite."""
    text = """
model = "packed_bed"
[mesh]
type = "line"
length = 3.0
[gas]
model = "cantera"
composition = "H2:0.7, H2O:0.05, N2:0.25"
[solids.ore]
diameter = 0.012
density = 3500.0
composition = "FeO:0.9, Al2O3:0.1"
[packed_bed]
porosity = 0.45
pressure_drop = "none"
[reactions.red]
equation = "FeO + H2 <-> Fe + H2O"
A = 4e-6
E = 0
orders = { H2 = 1, FeO = 1 }
[boundary.left]
gas = { molar_flux = 20.0, temperature = 1153.15 }
[boundary.right]
solids.ore = { velocity = 2.5e-4, temperature = 1153.15 }
"""
    (told,) = loads(text).warnings
    assert "Fe0.947O" in told and "equilibrium_factor = 2.3" in told
    assert not loads(text.replace("E = 0", "E = 0\nequilibrium_factor = 2.3")).warnings
    assert not loads(text.replace("<->", "->")).warnings
