"""What people bring from their own work: meshes, tables, fluids and numbers as they are
found in threads of the field. Each runs to the right value, or is refused by `check`
with file, line and a way out.
"""

import re
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed.chemistry.thermo import species_of
from contbed.cli import main
from contbed.closures.formula import parse_formula
from contbed.errors import SceneError
from contbed.loading import load, loads
from contbed.materials import gas_mixture, real_fluid
from contbed.mesh import gmsh
from contbed.models import MODELS, plan
from contbed.output import checkpoint
from contbed.scene.data_table import read_table
from contbed.scene.mechanism import aliases_that_multiply

FOLDER = Path(__file__).parents[1] / "data" / "first_hour"


def refused(name, **keys):
    with pytest.raises(SceneError) as error:
        plan(load(FOLDER / name, **keys))
    return error.value.problems


def test_names_of_a_mesh_with_a_byte_order_mark_and_umlauts():
    """Exact: 500 W/m2 on 0.5 m heat 5 W/m/K by 50 K; 1e-9 as the system is linear."""
    result = cb.run(load(FOLDER / "mesh_bom.toml"))
    assert result.qoi["T_fluid_out_K"] == approx(350.0, rel=1e-9)
    assert "heat_wall süd_W" in result.qoi


def test_names_of_a_mesh_in_windows_1252(tmp_path):
    data = (FOLDER / "bom.msh").read_text(encoding="utf-8-sig")
    (tmp_path / "bom.msh").write_bytes(data.encode("cp1252"))
    text = (FOLDER / "mesh_bom.toml").read_text()
    mesh = plan(loads(text, base=tmp_path)).mesh
    assert "wall süd" in mesh.boundaries


def test_a_number_as_velocity_on_a_mesh_file_is_along_the_normal():
    number = {"boundary.'gas in'.gas.velocity": 0.07}
    made = plan(load(FOLDER / "mesh_mm.toml", overrides=number))
    np.testing.assert_allclose(made.velocity, [0.07, 0.0], rtol=1e-12)


def test_the_boundary_that_gives_the_velocity_is_the_inlet_of_an_outlet():
    """Exact as above: what enters and leaves does not depend on who says so."""
    outlet = {"boundary.'gas out'.type": "outlet"}
    result = cb.run(load(FOLDER / "mesh_bom.toml", overrides=outlet))
    assert result.qoi["T_fluid_out_K"] == approx(350.0, rel=1e-9)


def test_a_mesh_in_millimetres_is_warned_of():
    scene = load(FOLDER / "mesh_mm.toml")
    plan(scene)
    (warning,) = scene.warnings
    assert warning.startswith(
        f"{FOLDER / 'mesh_mm.toml'}:2: mesh.file: the bed is 500 m"
    )
    assert warning.endswith("set mesh.scale = 0.001")
    scaled = load(FOLDER / "mesh_mm.toml", {"mesh.scale": 1e-3})
    plan(scaled)
    assert not scaled.warnings


def test_check_reads_the_files_of_a_scene(capsys):
    expected = {
        "mesh_mixed.toml": r":2: mesh.file: mixed.msh: cells of type quad and triangle",
        "mesh_unnamed.toml": r":15: boundary.gas in: .* name Physical groups in gmsh",
        "nofluid.toml": r":10: gas.name: no real fluid 'Water vapour' .*nearest: Water",
        "water_cross.toml": r":10: gas.name: .* crosses the phase change",
        "therm.toml": r":10: gas.name: .* boils at 529.72 K at .* raise the pressure",
        "cold_inlet.toml": r":10: boundary.left.gas.temperature: 3 K is too far",
        "mech_bomb.toml": r":3: gas.mechanism = .* aliases of aliases multiply",
    }
    for name, message in expected.items():
        assert main(["check", str(FOLDER / name)]) == 2
        assert re.search(re.escape(name) + message, capsys.readouterr().err), name


def test_an_error_of_coolprop_is_one_line():
    """CoolProp tells of states that an error keeps until Python ends."""
    command = [sys.executable, "-m", "contbed", "check", str(FOLDER / "therm.toml")]
    told = subprocess.run(command, capture_output=True, text=True)
    assert told.returncode == 2
    assert len(told.stderr.splitlines()) == 1


def test_a_table_in_latin_1():
    scene = load(FOLDER / "latin.toml")
    samples = plan(scene).schedule.samples[("boundary", "left", "gas", "temperature")]
    assert samples.at(8.0 * 3600.0) == approx(450.0 + 273.15)


def test_a_table_in_utf_16(tmp_path):
    text = (FOLDER / "latin.csv").read_text(encoding="cp1252")
    (tmp_path / "latin.csv").write_text(text, encoding="utf-16")
    here = read_table(FOLDER / "latin.csv")
    there = read_table(tmp_path / "latin.csv")
    assert (here.names, here.cells) == (there.names, there.cells)


def test_a_spreadsheet_is_no_table(tmp_path):
    (tmp_path / "feed.xlsx").write_bytes(b"PK\x03\x04\x00\xff")
    with pytest.raises(SceneError, match="not a text file; export a spread"):
        read_table(tmp_path / "feed.xlsx")


def test_oils_brines_and_mixtures_of_coolprop():
    """Against CoolProp's own values, to the tolerance of the tables."""
    from CoolProp.CoolProp import PropsSI

    for name, p, T_range in (
        ("INCOMP::TVP1", 12e5, (293.0, 650.0)),
        ("INCOMP::MEG-30%", 1e5, (270.0, 370.0)),
        ("INCOMP::MEG[0.3]", 1e5, (270.0, 370.0)),
        ("Nitrogen[0.79]&Oxygen[0.21]", 1e5, (300.0, 900.0)),
    ):
        fluid = real_fluid(name, p, T_range)
        for method, key in (
            ("density", "D"),
            ("heat_capacity", "C"),
            ("viscosity", "V"),
            ("conductivity", "L"),
        ):
            exact = PropsSI(key, "T", 341.0, "P", p, name)
            assert getattr(fluid, method)(341.0) == approx(exact, rel=1e-6)
    for name, message in (
        ("INCOMP::MEG", "give its mass fraction, such as INCOMP::MEG-30%"),
        ("Nitrogen[0.79]&Oxygen[0.31]", "mole fractions sum to 1.1"),
    ):
        with pytest.raises(SceneError, match=re.escape(message)):
            real_fluid(name, 1e5, (280.0, 370.0))


def test_one_cell_across_gives_a_warning_with_its_error():
    result = cb.run(load(FOLDER / "one_cell.toml"))
    assert result.qoi["estimated_error"] > 0.1
    assert any("leave out mesh.cells" in text for text in result.warnings)


def test_formulas_of_many_terms():
    """Sums of any length are read; what is nested too deeply is refused."""
    formula = parse_formula("x" + " - 1" * 450)
    assert formula({"x": 500.0}) == 50.0
    assert plan(load(FOLDER / "long_formula.toml")) is not None
    for text in ("-" * 300 + "x", "x" + "**x" * 300, "exp(" * 120 + "x" + ")" * 120):
        with pytest.raises(SceneError, match="nested 100 times"):
            parse_formula(text)


def test_a_geometry_that_never_ends(monkeypatch):
    pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    monkeypatch.setattr(gmsh, "LONGEST", 2.0)
    start = time.monotonic()
    (problem,) = refused("geo_loop.toml", trust=True)
    assert "mesh.file: loop.geo: gmsh has not meshed it in 2 s" in problem
    assert time.monotonic() - start < 60.0


def test_aliases_that_do_not_multiply_are_read(tmp_path):
    (tmp_path / "plain.yaml").write_text("a: &a [1, 2]\nb: *a\nc: [*a, *a]\n")
    assert aliases_that_multiply(tmp_path / "plain.yaml") == ""
    assert "multiply" in aliases_that_multiply(FOLDER / "bomb.yaml")


def test_a_packed_checkpoint_is_not_unpacked(tmp_path):
    with zipfile.ZipFile(
        tmp_path / checkpoint.NAME, "w", zipfile.ZIP_DEFLATED
    ) as packed:
        packed.writestr("array.a.npy", np.zeros(10**6).tobytes())
    with pytest.raises(
        SceneError, match="it is compressed, and contbed does not write"
    ):
        checkpoint.load(tmp_path)


def test_contacts_need_the_stiffness_of_the_material():
    """The contact radius goes with E^(-1/3): beads of alumina in a simulation at
    1e7 Pa conduct through contacts of 0.03 of the radius that is simulated.
    """
    (problem,) = refused("pack.toml")
    assert ":3: solids.beads.youngs_modulus: missing; give Young's modulus" in problem
    by_hand = cb.run(load(FOLDER / "packc.toml")).qoi["k_eff [W/m/K]"]
    named = cb.run(
        load(
            FOLDER / "pack.toml",
            {
                "solids.beads.material": "alumina",
                "solids.beads.youngs_modulus": 370e9,
                "solids.beads.poisson_ratio": 0.3,
            },
        )
    )
    assert named.qoi["k_eff [W/m/K]"] == approx(by_hand, rel=0.02)
    soft = cb.run(load(FOLDER / "pack.toml", {"solids.beads.youngs_modulus": 1e7}))
    assert soft.qoi["k_eff [W/m/K]"] > 3.0 * by_hand


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("boundary.left.gas.temperature", "150000 degC"),
        ("initial.temperature", 9763.0),
        ("initial.temperature", 5.0),
    ],
)
def test_temperatures_that_no_bed_has(key, value):
    text = (FOLDER / "latin.toml").read_text()
    text = text.replace('gas.temperature = { file = "latin.csv", column = "T" }', "")
    scene = loads(text, "a.toml", {"boundary.left.gas.temperature": 300.0, key: value})
    (warning,) = scene.warnings
    assert f"{key} = " in warning and "is the unit right?" in warning


@pytest.mark.parametrize(
    ("pressure", "warns"),
    [
        ("1 Pa", True),
        ("20 Pa", True),
        ("2 kPa", False),
        ("300 bar", False),
        ("1e9 Pa", True),
    ],
)
def test_pressures_that_no_bed_has(pressure, warns):
    lines = (FOLDER / "latin.toml").read_text().splitlines()
    gas = f'gas = {{ composition = "N2:1", pressure = "{pressure}" }}'
    text = "\n".join(gas if each.startswith("gas = ") else each for each in lines)
    text = text.replace('gas.temperature = { file = "latin.csv", column = "T" }', "")
    scene = loads(text, "a.toml", {"boundary.left.gas.temperature": 300.0})
    found = [each for each in scene.warnings if "is the unit right?" in each]
    assert len(found) == warns
    assert all("a.toml:3: gas.pressure = " in each for each in found)


def test_temperatures_of_a_file_that_no_bed_has(tmp_path):
    (tmp_path / "feed.csv").write_text("t [h],T [degC]\n0,300\n1000,150000\n")
    text = (FOLDER / "latin.toml").read_text()
    text = text.replace('file = "latin.csv", column = "T"', 'file = "feed.csv"')
    (warning,) = loads(text, "a.toml", base=tmp_path).warnings
    assert "temperature.file" in warning and "150273 K: above 3700 K" in warning


CELLS = {"mesh.cells": [6, 4]}
FORMS = """
phases:
- name: gas
  thermo: ideal-gas
  species: [A, B]
  state: {T: 300, P: 1 atm}
species:
- name: A
  composition: {N: 2}
  thermo:
    model: Shomate
    temperature-ranges: [298, 500, 6000]
    data:
    - [28.98641, 1.853978, -9.647459, 16.63537, 1.17e-4, -8.671914, 226.4168]
    - [19.50583, 19.88705, -8.598535, 1.369784, 0.527601, -4.935202, 212.39]
- name: B
  composition: {O: 2}
  thermo:
    model: constant-cp
    T0: 1000 K
    h0: 9.22 kcal/mol
    s0: -3.02 cal/mol/K
    cp0: 5.95 cal/mol/K
"""


@pytest.mark.parametrize("mechanism", ["airNASA9.yaml", "forms.yaml"])
def test_other_forms_of_thermodynamics(mechanism, tmp_path):
    """Against Cantera: heat capacities to rounding; enthalpies to 1e-4 of what a
    species stores, as published ranges do not quite meet.
    """
    cantera = pytest.importorskip("cantera")
    (tmp_path / "forms.yaml").write_text(FORMS)
    file = str(tmp_path / mechanism) if mechanism == "forms.yaml" else mechanism
    gas = cantera.Solution(file)
    x = {"A": 0.4, "B": 0.6} if mechanism == "forms.yaml" else {"N2": 0.79, "O2": 0.21}
    mixture = gas_mixture(x, 101325.0, file, viscosity=2e-5, conductivity=0.03)
    assert (mixture.viscosity(400.0), mixture.conductivity(400.0)) == (2e-5, 0.03)
    for T in (310.0, 700.0, 1500.0, 4000.0):
        gas.TPX = T, 101325.0, x
        assert mixture.heat_capacity(T) == approx(gas.cp_mass, rel=1e-12)
        assert mixture.density(T) == approx(gas.density, rel=1e-9)
        stored = gas.cp_mass * T
        assert mixture.enthalpy(T) == approx(gas.enthalpy_mass, abs=1e-4 * stored)
        for k, name in enumerate(gas.species_names):
            species = species_of(
                name, gas.species(k), float(gas.molecular_weights[k]) / 1e3
            )
            exact = gas.standard_gibbs_RT[k] * cantera.gas_constant * T / 1e3
            scale = 1e-4 * gas.cp_mole * T / 1e3
            assert species.gibbs(T) == approx(exact, abs=scale)


def test_a_mechanism_without_transport_data():
    """A bed takes constants in their place, and says so where they are missing."""
    text = (FOLDER / "cold_inlet.toml").read_text().replace("= 3 }", "= 400.0 }")
    bare = text.replace('"N2:1"', '"N2:1", mechanism = "airNASA9.yaml"')
    with pytest.raises(SceneError, match=r"give gas.viscosity and gas.conductivity"):
        plan(loads(bare))
    given = bare.replace(
        ".yaml", '.yaml", viscosity = 2e-5, conductivity = "0.03 W/m/K'
    )
    result = cb.run(loads(given, overrides=CELLS))
    assert 400.0 < result.qoi["T_fluid_out_K"] < 500.0


def test_air_below_its_data_gives_one_warning_with_an_error():
    """N2 of gri30 has data from 300 K; at 285 K its heat capacity moves by 0.13 %."""
    text = (FOLDER / "cold_inlet.toml").read_text().replace("= 3 }", "= 285.0 }")
    heated = text.replace("fixed_temperature = 500.0", "heat_flux = 10.0")
    result = cb.run(loads(heated, overrides=CELLS))
    (warning,) = [text for text in result.warnings if "extrapolated" in text]
    assert "K, where the heat capacity differs by 0.13%" in warning


def test_a_velocity_from_a_file_says_that_it_changes_in_steps(tmp_path):
    """Beside a temperature of the same file, which changes linearly."""
    (tmp_path / "day.csv").write_text("t [s],T [K],u [m/s]\n0,300,0.3\n600,400,0.6\n")
    template = MODELS["packed_bed"].template.read_text(encoding="utf-8")
    wanted = 'gas.velocity = { file = "day.csv", column = "u" }'
    text = template.replace('gas.velocity = "0.5 m/s"', wanted)
    assert wanted in text
    text += '\n[initial]\ntemperature = "300 K"\n[time]\nend = 600\n'
    said = "holds from each row of the file to the next"
    assert said in str(loads(text, "bed.toml", base=tmp_path).warnings)
    meant = text.replace('column = "u" }', 'column = "u", form = "step" }')
    assert said not in str(loads(meant, "bed.toml", base=tmp_path).warnings)
