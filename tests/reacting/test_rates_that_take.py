"""Rates that take what is not there, or have no value: told before the run where
that is sure, else by its result.
"""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import MOLAR, T, isothermal, let_move, solids, species
from several_solids import split
from solving import CLOSED
from test_bad_reacting import GOOD
from typer.testing import CliRunner

import contbed
from contbed.errors import ConvergenceError, SceneError
from contbed.loading import from_dict, loads
from contbed.models import plan
from contbed.reacting_bed import rate_checks
from contbed.reacting_bed.rate_checks import taken_though_absent, taken_to_the_end
from contbed.reacting_bed.solve import Report, newton_step
from tests.balances import assert_closed
from tests.refusals import refused
from tests.scene_text import scene_of, set_keys


def bed(rate, composition="A:1", **more):
    """Gas A of 1 m that becomes B by a formula."""
    scene = isothermal(composition, species(A=0.028, B=0.028))
    set_keys(scene, "mesh.cells = 8")
    scene["reactions"] = {"r": {"equation": "A -> B", "rate": rate, **more}}
    return from_dict(scene)


def test_a_negative_rate_takes_what_does_not_enter():
    refused(
        r"reactions\.r\.rate: takes .* of B where .*: B does not enter.*its sign",
        lambda: plan(bed("-1e-2*c_A")),
    )


def test_rates_that_run_back_may_be_negative():
    """B alone enters, and becomes A as by an equilibrium; to the error of 8 cells."""
    result = contbed.run(bed("c_A - c_B", "B:1"))
    assert result.status == "ok"
    assert result.qoi["x_A_out"] == approx(
        0.5 * (1.0 - 2.718281828 ** (-2.0 * 0.4 / 0.5)), abs=1e-5
    )


LIME = """
model = "packed_bed"
mesh = { type = "line", length = 6 }
packed_bed = { porosity = 0.45, pressure_drop = "none" }
heat = {}
closures = { nusselt = "gunn" }

[gas]
model = "cantera"
composition = "N2:0.72, CO2:0.28"
viscosity = 4e-5
conductivity = 0.08

[solids.stone]
diameter = 0.04
composition = "CaCO3:1"
density = 2700

[boundary.left]
gas = { mass_flux = 2.2, temperature = 1573 }

[boundary.right]
solids.stone = { velocity = 3.7e-4, temperature = 298 }
"""


def test_lime_does_not_form_where_there_is_none():
    """Limestone that sinks against hot gas: in the cold part its carbon dioxide would
    form limestone again, but of no lime. The formula whose part that runs back ends at
    zero calcines as much, with an equilibrium pressure that differs by some per cent.
    """
    shaft = scene_of(LIME)
    law = {"equation": "CaCO3 <-> CaO + CO2", "law": "power", "A": 3e6, "E": 180e3}
    shaft["reactions"] = {"calcination": law | {"orders": {"CaCO3": 1}}}
    by_law = contbed.run(from_dict(shaft))
    shaft["reactions"]["calcination"] = {
        "equation": "CaCO3 -> CaO + CO2",
        "rate": "k*exp(-E/(R*T))*n_CaCO3*max(1 - p_CO2/(4.137e12*exp(-20474/T)), 0)",
        "parameters": {"k": 3e6, "E": 180e3},
        "basis": "particle",
    }
    by_formula = contbed.run(from_dict(shaft))
    for result in (by_law, by_formula):
        assert 0.5 < result.qoi["conversion_CaCO3"] < 1.0
        assert_closed(result, CLOSED, "Ca", "C", "energy")
    conversions = [each.qoi["conversion_CaCO3"] for each in (by_law, by_formula)]
    assert conversions[0] == approx(conversions[1], rel=0.02)


def test_fast_lime_is_followed_from_slow_lime():
    """All limestone is calcined in a front of a millimetre in 5 m; the gas leaves at
    885.90 K by the enthalpies of NIST and Cantera, to rounding of these.
    """
    shaft = scene_of(LIME)
    shaft["mesh"]["length"] = 5.0
    shaft["gas"] = {"model": "cantera", "composition": "N2:0.8, CO2:0.2"}
    shaft["solids"]["stone"]["density"] = 2650
    shaft["packed_bed"] = {"porosity": 0.45}
    shaft["boundary"] = {
        "left": {"gas": {"molar_flux": 30, "temperature": 1600}},
        "right": {"solids": {"stone": {"velocity": 1.132e-4, "temperature": 300}}},
    }
    shaft["reactions"] = {
        "calcination": {
            "equation": "CaCO3 <-> CaO + CO2",
            "A": 3e5,
            "E": 190e3,
            "orders": {"CaCO3": 1},
        }
    }
    result = contbed.run(from_dict(shaft))
    assert result.qoi["conversion_CaCO3"] == approx(1.0, abs=1e-9)
    assert result.qoi["T_fluid_out_K"] == approx(885.90, abs=0.02)
    assert_closed(result, CLOSED, "Ca", "C", "energy")


def test_a_bed_that_goes_out_at_the_reference_temperature():
    """Gas and charge enter at 25 degC, where they carry no heat, and coke does not
    burn from 1500 K on: the balance is that of rounding, and a warning names the guess.
    """
    shaft = scene_of(LIME)
    shaft["gas"] = {"model": "cantera", "composition": "O2:0.21, N2:0.79, CO2:0"}
    shaft["solids"]["stone"]["composition"] = "C:0.05, Al2O3:0.95"
    shaft["boundary"] = {
        "left": {"gas": {"mass_flux": 0.5, "temperature": "25 degC"}},
        "right": {"solids": {"stone": {"velocity": 1e-4, "temperature": "25 degC"}}},
    }
    shaft["reactions"] = {
        "burning": {
            "equation": "C + O2 -> CO2",
            "A": 1e5,
            "E": 110e3,
            "orders": {"C": 1, "O2": 1},
            "basis": "bed",
        }
    }
    shaft["initial"] = {"temperature": 1500}
    result = contbed.run(from_dict(shaft))
    assert abs(result.balances["energy"]["relative_residual"]) < 1e-10
    assert any("far above this state, which has 298.2" in w for w in result.warnings)


def test_a_rate_that_does_not_end_is_no_state_that_can_be():
    # takes 0.55 of the gas that enters, half of which is A
    rate = 0.55 * 0.5 * MOLAR / 0.4
    said = r"r\.rate: takes .* of A where .*A falls to -0\..* at x = 0\.\d+ m"
    with pytest.raises(ConvergenceError, match=said) as found:
        contbed.run(bed(str(rate), "A:0.5, B:0.5"))
    assert found.value.exit_code == 3
    advice = str(found.value).split("such as ")[1].split(";")[0]
    assert advice == "c_A/(abs(c_A) + 0.1)"


def test_an_iteration_that_stops_where_a_gas_ends_names_it():
    """Newton's method takes no more of the only gas than there is."""
    with pytest.raises(
        ConvergenceError,
        match=r"largest residual is that of A .*: takes .* of A .*: A is used up at x = 0\.\d+ m",
    ):
        contbed.run(bed(str(1.5 * 0.5 * MOLAR / 0.4)))


def test_the_advice_ends_the_rate():
    rate = 1.5 * 0.5 * MOLAR / 0.4
    scene = bed(f"{rate}*c_A/(abs(c_A) + 0.1)")
    scene = scene.model_copy(
        update={"mesh": scene.mesh.model_copy(update={"cells": None})}
    )
    result = contbed.run(scene)
    assert result.status == "ok"
    assert result.qoi["conversion_A"] == approx(1.0, abs=1e-9)


def test_a_constant_rate_of_what_is_left_is_exact():
    """The same rate in half of the bed's gas: A falls by a straight line."""
    rate = 0.8 * 0.5 * MOLAR / 0.4
    result = contbed.run(bed(str(rate)))
    assert result.qoi["conversion_A"] == approx(0.8, abs=1e-10)
    assert not result.warnings


@pytest.mark.parametrize(
    ("gas", "excess"), [("quasi_steady", 1.1), ("quasi_steady", 1.5), ("stored", 1.5)]
)
def test_runs_in_time_keep_what_they_passed(gas, excess, tmp_path):
    """A rate that takes more than there is ends a run, whether its first step has a
    state with amounts below zero or none.
    """
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    set_keys(scene, "mesh.cells = 8")
    scene["reactions"] = {
        "r": {"equation": "A -> B", "rate": str(excess * 0.5 * MOLAR / 0.4)}
    }
    set_keys(scene, "time = { end = 2.0 }")
    scene["packed_bed"]["gas_storage"] = gas
    with pytest.raises(ConvergenceError, match=r"takes .* of A where .* at t = \d"):
        contbed.run(from_dict(scene), out=tmp_path)
    assert '"not converged"' in (tmp_path / "summary.json").read_text()


def test_films_are_looked_at():
    """The film lets less pass than the rate takes, although the gas is not used up."""
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    set_keys(
        scene,
        """
        mesh.length = 0.01
        mesh.cells = 2
        gas.diffusivity = 1e-6
        gas.viscosity = 2e-5
        closures.sherwood = 2.0
        solids.particles.density = 1000.0
        reactions = { r = { equation = "A -> B", rate = "100.0", basis = "particle" } }
        """,
    )
    with pytest.raises(
        ConvergenceError, match=r"of A at the particles where there is none"
    ):
        contbed.run(from_dict(scene))


def test_solids_that_move_are_looked_at():
    scene = let_move(isothermal("A:1", species(A=0.028, B=0.028)), -1e-5)
    set_keys(scene, "mesh.cells = 8")
    scene["solids"]["particles"] |= solids()
    set_keys(
        scene,
        """
        reactions = { r = { equation = "A + S -> B + P", rate = "0.1*c_A", basis = "bed" } }
        """,
    )
    with pytest.raises(
        ConvergenceError, match=r"of S where .*: S .*n_S/\(abs\(n_S\) \+ "
    ):
        contbed.run(from_dict(scene))


@pytest.mark.parametrize(
    ("rate", "said"),
    [
        (
            "c_A/c_B",
            r"is inf as gas and solids enter, at 500 K, where there is no B; add a "
            r"small amount",
        ),
        ("c_A/(1 + 1/c_B)", r"has a slope that is not finite"),
        (
            "c_A*c_B**(-0.5)",
            r"is inf as gas and solids enter, at 500 K, where there is no B",
        ),
        ("log(T - 600)", r"is nan as gas and solids enter, at 500 K; see its limits"),
    ],
)
def test_rates_without_value(rate, said):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        refused(r"reactions\.r\.rate: " + said, lambda: plan(bed(rate)))


def test_a_negative_order_in_what_does_not_enter_is_infinite():
    """Powers are straight lines to zero, so that nothing would react."""
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    scene["mesh"]["cells"] = 8
    scene["reactions"] = {
        "r": {"equation": "A -> B", "A": 1.0, "E": 0.0, "orders": {"A": 1.0, "B": -0.5}}
    }
    said = r"reactions\.r: is infinite .* there is no B, .* the order is -0\.5: .*\(c_B \+ 1e-6\)\*\*\(-0\.5\)"
    refused(said, lambda: plan(from_dict(scene)))
    set_keys(
        scene,
        """
        reactions = { r = { equation = "A -> B", rate = "c_A*(c_B + 1e-6)**(-0.5)" } }
        """,
    )
    advised = contbed.run(from_dict(scene))
    set_keys(
        scene,
        """
        reactions = { r = { equation = "A -> B", rate = "c_A/sqrt(c_B + 1e-6)" } }
        """,
    )
    assert advised.qoi["conversion_A"] == approx(
        contbed.run(from_dict(scene)).qoi["conversion_A"], rel=1e-9
    )
    assert 0.1 < advised.qoi["conversion_A"] < 1.0


def in_time(reaction, fills=None, **more):
    """Gas A and B that fills the bed or follows at once; `fills` is what is there
    before.
    """
    scene = isothermal("A:0.5, B:0.5", species(A=0.028, B=0.028, N=0.028))
    set_keys(scene, "mesh.cells = 8")
    scene["reactions"] = {"r": {"equation": "A -> B", **reaction}}
    scene["time"], scene["packed_bed"]["gas_storage"] = {"end": 1.0}, "stored"
    scene["initial"] = {} if fills is None else {"gas": {"composition": fills}}
    return {**scene, **more}


ORDERS = {"A": 0.1, "E": 0.0, "orders": {"A": 1.0, "B": -0.5}}
INFINITE = r"reactions\.r: is infinite {}, where there is no B, of which the order is -0\.5: .*\(c_B \+ 1e-6\)"


@pytest.mark.parametrize(
    ("reaction", "fills", "enters", "said"),
    [
        (
            {"rate": "0.5*c_A/c_B"},
            "N:1",
            None,
            r"r\.rate: is nan in the gas that fills .* at 500 K, where .* no A, no B",
        ),
        (
            ORDERS,
            "A:1",
            None,
            INFINITE.format("in the gas that fills the bed at the start"),
        ),
        (ORDERS, None, "A:1", INFINITE.format("as gas and solids enter")),
        (
            ORDERS,
            None,
            {"times": [0.0, 0.5], "values": ["A:0.5, B:0.5", "A:1"], "form": "step"},
            "is infinite as gas",
        ),
    ],
    ids=["filled", "filled by A", "enters", "enters later"],
)
def test_rates_without_value_are_told_before_a_run_in_time(
    reaction, fills, enters, said
):
    scene = in_time(reaction, fills)
    if enters is not None:
        scene["boundary"]["left"]["gas"]["composition"] = enters
    refused(said, lambda: plan(from_dict(scene)))


def test_a_gas_without_what_reacts_is_no_mistake():
    """A purge has neither A, of which the order is positive, nor B, of which it is
    negative.
    """
    plan(from_dict(in_time(ORDERS, "N:1")))


def test_a_rate_without_value_at_the_start_of_a_file_is_told(tmp_path):
    """The gas of the file has neither A nor B."""
    (tmp_path / "start.csv").write_text("x [m],x_N [1]\n0,1\n1,1\n")
    scene = in_time({"rate": "0.5*c_A/c_B"})
    set_keys(scene, 'initial = { file = "start.csv" }')
    with pytest.raises(
        ConvergenceError,
        match=r"at t = 0 s; the rate of r is nan at x = .*: add a small amount",
    ):
        contbed.run(from_dict(scene, base=tmp_path))


def test_a_rate_that_loses_its_value_in_time_is_told():
    with pytest.raises(
        ConvergenceError, match=r"the rate of r is nan at x = .* at t = 0\.\d+ s"
    ):
        contbed.run(from_dict(in_time({"rate": "c_A*(1 + 0*log(x_A - 0.45))"})))


def test_an_infinite_part_of_a_finite_rate_is_silent():
    """exp(-1/k) is that of k = 0."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = contbed.run(bed("0.1*c_A*(1 + exp(-1/k))", parameters={"k": 0.0}))
    assert result.status == "ok"


def test_a_rate_without_value_within_the_bed_names_its_place():
    """Newton's method meets what no gas that enters has."""
    scene = bed("c_A*(1 + 0*log(x_A - 0.5))")
    problem = plan(scene).problem
    u = problem.start()
    u[1, 3] = 2.0 * u[0, 3]
    with pytest.raises(ConvergenceError, match=r"the rate of r is nan at x = 0\.38"):
        newton_step(problem, u, Report())


def test_check_refuses_what_run_refuses(tmp_path):
    from contbed.cli import app

    file = tmp_path / "bed.toml"
    water = next(
        line for line in GOOD.splitlines(keepends=True) if line.startswith("H2O")
    )
    file.write_text(GOOD.replace(water, ""))
    said = {}
    for command in ("check", "run"):
        found = CliRunner().invoke(app, [command, str(file)])
        said[command] = str(found.exception)
        assert isinstance(found.exception, SceneError)
    assert said["check"] == said["run"]
    assert "H2O is neither a gas of [gas.species]" in said["check"]


def test_a_constant_rate_in_resolved_pellets():
    """No diffusion slows it down: what is taken is that of the whole pellets."""
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    set_keys(
        scene,
        """
        solids.particles.density = 1000.0
        solids.particles.inside = { mass = "interior", diffusivity = { A = 1e-6, B = 1e-6 } }
        reactions = { r = { equation = "A -> B", rate = "1.0", basis = "particle" } }
        """,
    )
    result = contbed.run(from_dict(scene))
    assert result.qoi["conversion_A"] == approx(0.6 / (0.5 * MOLAR), rel=1e-10)


def test_sections_are_looked_at_ring_by_ring():
    scene = isothermal("A:0.5, B:0.5", species(A=0.028, B=0.028))
    for gas in scene["gas"]["species"].values():
        gas["heat_capacity"] = 30.0
    set_keys(
        scene,
        """
        mesh.cells = 8
        heat = {}
        mesh.diameter = 0.1
        """,
    )
    scene["boundary"]["wall"] = {"coefficient": 50.0, "ambient": T}
    set_keys(scene, "packed_bed.section = { rings = 2, conductivity_solids = 1.0 }")
    scene["reactions"] = {
        "r": {"equation": "A -> B", "rate": str(0.55 * 0.5 * MOLAR / 0.4)}
    }
    with pytest.raises(
        ConvergenceError,
        match=r"takes .* of A where .*A falls to -0\.0\d* of the gas at x = 0\.9",
    ):
        contbed.run(from_dict(scene))


def test_solids_of_several_kinds_go_by_their_own_names():
    scene = let_move(isothermal("A:1", species(A=0.028, B=0.028)), -1e-5)
    set_keys(scene, "mesh.cells = 8")
    scene["solids"]["particles"] |= solids()
    scene["reactions"] = {
        "r": {
            "equation": "A + S -> B + P",
            "rate": "0.1*c_A",
            "basis": "particle",
            "solid": ["coarse", "fine"],
        }
    }
    with pytest.raises(
        ConvergenceError, match=r"of S_\w+ where .*n_S/\(abs\(n_S\) \+ "
    ):
        contbed.run(from_dict(split(scene)))


def test_beds_without_reactions_have_no_such_rates():
    problem = plan(
        from_dict(
            isothermal("A:1", species(A=0.028), closures={"dispersion_mass": 1e-4})
        )
    ).problem
    u = -problem.start()
    assert (
        taken_though_absent(problem, u) is None and taken_to_the_end(problem, u) is None
    )


def test_named_laws_are_not_blamed(monkeypatch):
    """Whatever their rates are in a state within an iteration: here one where there
    is no Fe3O4 and no FeO.
    """
    gases = {name: {"heat_capacity": 30.0} for name in ("H2", "H2O")}
    scene = let_move(isothermal("H2:0.9, H2O:0.1", gases), -1e-4)
    set_keys(
        scene,
        """
        mesh.cells = 4
        solids.particles.composition = "Fe2O3:1"
        solids.particles.density = 4000.0
        """,
    )
    scene["solids"]["particles"]["constituent"] = {
        name: {"heat_capacity": 100.0} for name in ("Fe2O3", "Fe3O4", "FeO", "Fe")
    }
    set_keys(
        scene,
        """
        boundary.left.gas.temperature = 1000.0
        reactions = { reduction = { law = "three_interfaces_H2" } }
        gas.diffusivity = 1e-4
        """,
    )
    problem = plan(from_dict(scene)).problem
    u = problem.start()
    monkeypatch.setattr(
        rate_checks,
        "rates_at_all_points",
        lambda *_: [k * np.ones(u[0].size) for k in (0.0, 1.0, 1.0)],
    )
    assert taken_to_the_end(problem, u) is None


PURGED = """
model = "packed_bed"
mesh = { type = "line", length = 0.3, cells = 4 }
gas = { model = "cantera", composition = "CO2:0.15, N2:0.85" }
[solids.lime]
diameter = 4e-3
density = 1600.0
composition = "CaO:1"
[packed_bed]
porosity = 0.45
pressure_drop = "none"
[reactions.carb]
equation = "CaO + CO2 <-> CaCO3"
A = 2e-5
E = 0
basis = "bed"
orders = { CO2 = 1, CaO = 1 }
[initial]
gas.composition = "N2:1"
temperature = 923.15
[boundary.left]
gas = { molar_flux = 8.0, temperature = 923.15 }
[time]
end = 5.0
"""


def test_a_law_with_orders_runs_back_where_there_is_no_gas_on_its_left():
    """Lime in dry nitrogen: c_CO2 (1 - Q/K) is -1/K there, and no 0 times infinity."""
    found = [
        contbed.run(loads(PURGED.replace('"N2:1"', start))).qoi["x_CO2_out"]
        for start in ('"N2:1"', '"N2:0.999999, CO2:1e-6"')
    ]
    # a millionth of CO2 in the gas of the start, which has left
    assert found[0] == approx(found[1], rel=1e-5)
    assert 0.05 < found[0] < 0.15
