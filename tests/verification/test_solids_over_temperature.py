"""Solids by tables over temperature and with latent heat, in every model that carries
heat in solids.
"""

from pathlib import Path

import numpy as np
import pytest
from pytest import approx
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import erf

import contbed as cb
from contbed.loading import from_dict
from contbed.scene.identity import resolved
from contbed.scene.inputs import inputs_elsewhere
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import scene_of

# [W/m/K] from 20 to 600 degC, and [J/kg/K]
K_FILE = "# of a core\nT [degC],k [W/m/K]\n20,2.5\n300,2.0\n600,1.8\n"
STORE = """
[mesh]
type = "line"
length = 0.2
cells = 40
[gas]
density = 1.0
viscosity = 2e-5
heat_capacity = 1000
conductivity = 1e-6
[solids.rock]
diameter = 0.01
density = 2500
heat_capacity = { temperatures = ["20 degC", "300 degC", "600 degC"], values = [790, "1 kJ/kg/K", 1100] }
conductivity = { temperatures = ["20 degC", "300 degC", "600 degC"], values = [2.5, 2.0, 1.8] }
[packed_bed]
porosity = 0.4
[closures]
nusselt = 2.0
conductivity_gas = 0
[heat]
[output]
fields = false
plots = false
"""
ENDS = {
    "boundary.left.solids.rock.fixed_temperature": 300.0,
    "boundary.right.solids.rock.fixed_temperature": 850.0,
}


def conductivity_integral(T):
    """Return the integral of the conductivity from 293.15 K [W/m]."""
    nodes, k = [293.15, 573.15, 873.15], [2.5, 2.0, 1.8]
    fine = np.linspace(293.15, T, 20_001)
    return np.trapezoid(np.interp(fine, nodes, k), fine)


@pytest.mark.parametrize("from_file", [False, True])
def test_conduction_follows_kirchhoffs_transform(tmp_path, from_file):
    """The integral of k over temperature is linear along a bed without flow; kinks of
    the table within a cell leave 1e-5 K.
    """
    (tmp_path / "k.csv").write_text(K_FILE)
    values = ENDS | {"output.positions": [0.05, 0.1, 0.15], "mesh.cells": 160}
    if from_file:
        values["solids.rock.conductivity"] = {"file": str(tmp_path / "k.csv")}
    found = cb.run(cb.load(scene_of(STORE, values)))
    low, high = (conductivity_integral(T) for T in (300.0, 850.0))
    for x, T in zip(
        found.profiles["x [m]"], found.profiles["T_solid [K]"], strict=True
    ):
        exact = brentq(
            lambda T, x=x: conductivity_integral(T) - low - x / 0.2 * (high - low),
            299.0,
            851.0,
        )
        assert approx(exact, abs=2e-5) == T
    flux = found.balances["energy"]
    assert abs(flux["relative_residual"]) < 1e-12


MELTING = {
    "solids.rock.melting": {"latent_heat": 1e5, "start": 390.0, "end": 410.0},
    "boundary.left.gas.velocity": 1.0,
    "boundary.left.gas.temperature": 500.0,
    "initial.temperature": 350.0,
    "closures.nusselt": "gunn",
    "gas.conductivity": 0.03,
    "mesh.cells": 10,
    "time.end": 4000.0,
}


def test_a_store_that_melts_holds_the_latent_heat():
    """Per volume, from cold to hot: (1-eps) rho (integral of c + L), and the gas."""
    found = cb.run(cb.load(scene_of(STORE, {**MELTING, "mesh.cells": 4})))
    capacity = 790.0 + (np.array([350.0, 500.0]) - 293.15) * 210.0 / 280.0
    heat = 0.6 * 2500.0 * (capacity.mean() * 150.0 + 1e5) + 0.4 * 1000.0 * 150.0
    assert found.qoi["storage_capacity_J"] == approx(0.2 * heat, rel=1e-12)
    assert found.qoi["heat_stored_J"] == approx(0.2 * heat, rel=1e-3)
    assert abs(found.balances["energy"]["relative_residual"]) < 1e-13
    assert not found.warnings


@pytest.mark.slow
def test_front_of_melting_follows_stefan():
    """A half-space at its melting point, heated from one end: the front is at 2 l sqrt(a
    t), with l exp(l^2) erf(l) = Ste/sqrt(pi). Melting over 1 K in 60 K leaves 2 %.
    """
    latent, k, c, rho, hot, time = 1e5, 2.0, 900.0, 2500.0, 460.0, 2000.0
    stefan = c * (hot - 400.0) / latent
    root = brentq(
        lambda x: x * np.exp(x * x) * erf(x) - stefan / np.sqrt(np.pi), 1e-6, 3.0
    )
    front = 2.0 * root * np.sqrt(k / (rho * c) * time)
    values = {
        "solids.rock.melting": {"latent_heat": latent, "start": 399.5, "end": 400.5},
        "solids.rock.heat_capacity": c,
        "solids.rock.conductivity": k,
        "boundary.left.solids.rock.fixed_temperature": hot,
        "initial.temperature": 399.5,
        "gas.density": 1e-6,
        "mesh.length": 0.08,
        "mesh.cells": 24,
        "time.end": time,
        "output.positions": [0.5 * front, 0.98 * front, 1.02 * front],
    }
    found = cb.run(cb.load(scene_of(STORE, values)))
    middle, before, behind = found.profiles["T_solid [K]"][-3:]
    exact = hot - (hot - 400.0) * erf(0.5 * root) / erf(root)
    assert middle == approx(exact, abs=0.02 * (hot - 400.0))
    assert before > 400.0 > behind


@pytest.mark.parametrize(("start", "end"), [(576.0, 582.0), (560.0, 600.0)])
def test_solids_that_sink_through_cold_gas_freeze(start, end):
    """Counterflow without conduction: the heat that the solid has lost is that of the
    gas, and one equation is left, integrated from the end where the solid leaves.
    """
    hot, cold, length, nusselt, conductivity, diameter = (
        673.0,
        298.0,
        0.3,
        20.0,
        0.04,
        0.012,
    )
    latent, of_gas, of_solid = 178e3, 0.7 * 1030.0, 1.8e-4 * 2000.0
    scene = scene_of(
        f"""
        mesh = {{ type = "line", length = {length}, cells = 150 }}
        gas = {{ density = 0.7, viscosity = 2.8e-5, heat_capacity = 1030, conductivity = {conductivity} }}
        packed_bed.porosity = 0.4
        heat = {{}}
        [solids.pcm]
        density = 2000
        heat_capacity = 1500
        conductivity = 1.0
        diameter = {diameter}
        inside.heat = "lumped"
        melting = {{ latent_heat = {latent}, start = {start}, end = {end} }}
        [closures]
        nusselt = {nusselt}
        conductivity_gas = 1e-6
        conductivity_solids = 1e-6
        [boundary.left]
        gas = {{ velocity = 1.0, temperature = {cold} }}
        [boundary.right]
        solids.pcm = {{ velocity = 1.8e-4, temperature = {hot} }}
        """
    )
    found = cb.run(from_dict(scene))
    exchange = 0.6 * 6.0 * nusselt * conductivity / diameter**2

    def melted(T):
        s = np.clip((T - start) / (end - start), 0.0, 1.0)
        return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)

    def heat(T):
        return of_solid * (1500.0 * T + latent * melted(T))

    def entering(leaves):
        def slope(_, T):
            gas = cold + (heat(T) - heat(leaves)) / of_gas
            step = 1e-4
            capacity = (heat(T + step) - heat(T - step)) / (2.0 * step)
            return exchange * (T - gas) / capacity

        path = solve_ivp(
            slope, (0.0, length), [leaves], "LSODA", rtol=1e-9, max_step=1e-3
        )
        return path.y[0, -1]

    leaves = brentq(lambda T: entering(T) - hot, cold + 0.1, 560.0, xtol=1e-6)
    assert found.qoi["T_solid_out_K"] == approx(leaves, abs=0.05)
    gas = cold + (heat(hot) - heat(leaves)) / of_gas
    assert found.qoi["T_fluid_out_K"] == approx(gas, abs=0.05)


def test_temperatures_beyond_a_table_are_reported():
    beyond = ENDS | {"boundary.right.solids.rock.fixed_temperature": 900.0}
    found = cb.run(cb.load(scene_of(STORE, beyond)))
    assert any("data from 293.15 to 873.15 K" in text for text in found.warnings)


def test_a_file_is_read_once_and_listed(tmp_path):
    """A resolved scene has the values of the file, and does not need it."""
    file = tmp_path / "k.csv"
    file.write_text(K_FILE)
    values = ENDS | {"solids.rock.conductivity": {"file": str(file)}}
    scene = cb.load(scene_of(STORE, values))
    assert scene.solid.conductivity.values == (2.5, 2.0, 1.8)
    assert inputs_elsewhere(scene, scene.origin.base) == [file]
    whole = resolved(scene)
    file.write_text(K_FILE.replace("1.8", "1.9"))
    refused("the file has other values", from_dict, whole)
    file.unlink()
    assert from_dict(whole).solid == scene.solid


@each_case(__file__, "mistakes_in_tables")
def test_mistakes_in_tables(table, part):
    values = ENDS | {"solids.rock.heat_capacity": table}
    refused(part, cb.load, scene_of(STORE, values))


def test_the_range_of_melting_rises():
    melting = {"latent_heat": 1e5, "start": 400.0, "end": 400.0}
    refused(
        "must lie above start",
        cb.load,
        scene_of(STORE, ENDS | {"solids.rock.melting": melting}),
    )


def test_fronts_within_particles_are_warned_of():
    values = MELTING | {"solids.rock.inside.heat": "effective"}
    (text,) = cb.load(scene_of(STORE, values)).warnings
    assert "solids.rock.inside.heat" in text and "front of melting" in text
    assert not cb.load(scene_of(STORE, MELTING)).warnings


def test_density_is_that_at_which_the_bed_was_filled():
    table = {"temperatures": [283.15, 303.15, 800.0], "values": [2600, 2500, 2000]}
    values = ENDS | {"solids.rock.density": table}
    assert cb.load(scene_of(STORE, values)).solid.density == approx(2550.0)
    values["solids.rock.material_temperature"] = 800.0
    fixed = cb.load(scene_of(STORE, values)).solid
    assert fixed.density == 2000.0
    assert fixed.conductivity == approx(2.0 - 0.2 * 226.85 / 300.0)


PACKAGE = Path(cb.__file__).parent


def template(model, values):
    """Return the template of a model with other values, without plots."""
    values = values | {"output.plots": False}
    return scene_of((PACKAGE / model / "template.toml").read_text(), values)


def level(value):
    """Return a table of one value at all temperatures."""
    return {"temperatures": [300.0, 700.0, 2000.0], "values": [value] * 3}


def test_bubbling_beds_take_tables():
    """A table of one value is that value; one that varies changes the bed, and all
    balances close.
    """
    number = cb.run(cb.load(template("bubbling_bed", {})))
    same = {"solids.sand.heat_capacity": level(1100.0)}
    table = cb.run(cb.load(template("bubbling_bed", same)))
    for name, value in number.qoi.items():
        assert table.qoi[name] == approx(value, rel=1e-8), name
    risen = {"temperatures": [300.0, 700.0], "values": [800.0, 1300.0]}
    varies = {
        "solids.sand.heat_capacity": risen,
        "solids.sand.conductivity": level(2.0),
    }
    found = cb.run(cb.load(template("bubbling_bed", varies)))
    assert found.status == "ok"
    assert any("solids.sand: data from 300 to 700 K" in text for text in found.warnings)


INERT_SPHERE = """
[solids.stone]
diameter = 0.02
density = 2600.0
conductivity = { temperatures = [300, 600], values = [2.5, 1.5] }
composition = "rock:1"
constituent.rock.heat_capacity = { temperatures = [300, 500, 700], values = [800, 1000, 1050] }
[boundary.surface]
ambient = 600.0
coefficient = 200.0
[initial]
temperature = 300.0
[time]
end = 7200.0
[output]
plots = false
"""


def test_a_particle_takes_up_the_integral_of_its_heat_capacity():
    found = cb.run(cb.load(scene_of(INERT_SPHERE)))
    exact = 0.5 * (800.0 + 1000.0) * 200.0 + 0.5 * (1000.0 + 1025.0) * 100.0
    mass = 2600.0 * np.pi / 6.0 * 0.02**3
    energy = found.balances["energy"]
    assert energy["stored"] == approx(mass * exact, rel=1e-6)
    assert abs(energy["relative_residual"]) < 1e-12


MELTING_GAS = """
model = "packed_bed"
[mesh]
type = "line"
length = 0.02
cells = 2
[gas]
model = "ideal_gas"
composition = "N2:1"
pressure = 1e5
viscosity = 2e-5
conductivity = 0.03
species.N2 = { heat_capacity = 29.1, enthalpy = 0 }
[solids.salt]
diameter = 0.01
density = 2000
heat_capacity = { temperatures = [300, 500], values = [1000, 1500] }
conductivity = { temperatures = [300, 500], values = [1.0, 0.5] }
melting = { latent_heat = 1e5, start = 400, end = 430 }
[packed_bed]
porosity = 0.4
[closures]
conductivity_solids = "conductivity_phase"
[heat]
[boundary.left]
gas.mass_flux = 2.0
gas.temperature = 500
[initial]
temperature = 350
[time]
end = 160
tolerance = 1e-2
"""


def test_beds_with_species_melt():
    found = cb.run(cb.load(scene_of(MELTING_GAS)))
    energy = found.balances["energy"]
    assert abs(energy["relative_residual"]) < 1e-12
    solid = 0.6 * 2000.0 * (1125.0 + 1500.0) / 2.0 * 150.0 + 0.6 * 2000.0 * 1e5
    assert 0.9 * 0.02 * solid < energy["stored"] < 1.01 * 0.02 * solid


def test_models_of_constants_say_which_property_varies():
    values = {"solids.beads.heat_capacity": level(800.0), "heat": {}}
    part = r"solids.beads.heat_capacity: varies with temperature, and this model takes"
    refused(part, cb.load, template("two_fluid", values))
    fixed = values | {"solids.beads.material_temperature": 600.0}
    refused("gas.heat_capacity", cb.load, template("two_fluid", fixed))
