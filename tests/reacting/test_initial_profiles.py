"""Runs that begin with profiles: exact where these move or decay, continued from an
earlier run, bad tables told.
"""

from __future__ import annotations

import numpy as np
import pytest
from adsorption_scenes import adsorber
from pytest import approx
from reacting_bed_scenes import (
    MOLAR,
    N_SOLID,
    R_GAS,
    P,
    fixed_bed,
    heated,
    isothermal,
    let_move,
    solids,
    species,
)
from several_solids import split
from solving import solved

from contbed.errors import SceneError
from contbed.loading import from_dict
from contbed.models import plan
from contbed.output.tables import write_table
from contbed.particle.adsorption import Inside, Isotherm
from contbed.particle.interior import interior
from contbed.reacting_bed.course import Course
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import set_keys

RESIDENCE = 0.8  # [s] of the gas of `isothermal` in its pores
# steps to a local tolerance of 1e-4, of one order more than their estimate
STEPS = 2e-4


def begins_with(scene, path, text, **initial):
    """The scene with a table along the bed at its start."""
    (path / "start.csv").write_text(text)
    scene["initial"] |= {"file": str(path / "start.csv")} | initial
    return scene


def rows(header, *columns):
    return (
        "\n".join(
            [
                header,
                *(
                    ",".join(f"{float(value)!r}" for value in row)
                    for row in zip(*columns, strict=True)
                ),
            ]
        )
        + "\n"
    )


# gas, solids and temperatures that move or decay as they began


@pytest.mark.parametrize("direction", [1.0, -1.0], ids=["to the right", "to the left"])
def test_a_gas_in_the_pores_moves_and_decays_from_its_profile(tmp_path, direction):
    """x_A is 0.8 of the way of the gas from its inlet, moved by u t/eps and times
    e^(-k t); the table is linear.
    """
    k, after = 0.5, 0.5
    scene = isothermal("B:1", species(A=0.028, B=0.028))
    if direction < 0:
        scene["boundary"]["right"] = scene["boundary"].pop("left")
    scene["reactions"] = {"r": {"equation": "A -> B", "A": k, "E": 0.0}}
    set_keys(scene, "mesh.cells = 20")
    scene["time"] = {"end": after * RESIDENCE, "tolerance": 1e-5}
    set_keys(scene, 'packed_bed.gas_storage = "stored"')
    share = np.array([0.0, 0.8][:: int(direction)])
    begins_with(
        scene, tmp_path, rows("x [m],x_A [1],x_B [1]", (0.0, 1.0), share, 1.0 - share)
    )
    found = solved(scene)
    x = found.profiles["x [m]"]
    way = (x if direction > 0 else 1.0 - x) - after
    exact = 0.8 * np.maximum(way, 0.0) * np.exp(-k * after * RESIDENCE)
    # steps to a local error of 1e-5
    assert np.abs(found.profiles["x_A [1]"] - exact)[np.abs(way) > 0.3].max() < 1e-5
    # a kink in cells of 0.05
    assert np.abs(found.profiles["x_A [1]"] - exact).max() < 1e-2
    # kg of H per kg/mol of these species, all of what passes
    entered = 0.5 * MOLAR * after * RESIDENCE * 28.0
    assert found.balances["H"]["in"] == approx(entered, rel=1e-12)


def decaying(**time):
    """Particles at rest in which S becomes P by first order, whatever the gas."""
    scene = isothermal("A:1", species(A=0.028))
    scene["solids"]["particles"] |= solids()
    scene["reactions"] = {
        "r": {
            "equation": "S -> P",
            "A": 1e-3,
            "E": 0.0,
            "orders": {"S": 1.0},
            "basis": "particle",
        },
    }
    set_keys(scene, "mesh.cells = 4")
    scene["time"] = {"end": 1000.0, **time}
    return scene


def test_a_rate_without_gas_on_the_left_has_its_orders():
    """It would go on at one speed whatever is left."""
    scene = decaying()
    del scene["reactions"]["r"]["orders"]
    with pytest.raises(
        SceneError, match=r'give \{ "S" = 1.0 \} for a rate of first order'
    ):
        plan(from_dict(scene))
    scene["reactions"]["r"]["orders"] = {"S": 0.0}
    plan(from_dict(scene))


@pytest.mark.parametrize("by", ["moles", "mass"])
def test_solids_at_rest_decay_from_their_profile(tmp_path, by):
    """S falls from 0.2 + 0.6 x by one and the same factor everywhere, which is that
    of a uniform bed.
    """
    share = np.array([0.2, 0.8])
    header, of = (
        ("n_S [mol/m3],n_P [mol/m3]", N_SOLID)
        if by == "moles"
        else ("w_S [1],w_P [%]", 1.0)
    )
    other = (1.0 - share) * of * (1.0 if by == "moles" else 100.0)
    table = rows(f"x [m],{header}", (0.0, 1.0), share * of, other)
    found = solved(begins_with(decaying(), tmp_path, table))
    x = found.profiles["x [m]"]
    left = solved(decaying()).profiles["w_S [1]"][0]
    assert found.profiles["n_S [mol/m3]"] / N_SOLID == approx(
        (0.2 + 0.6 * x) * left, abs=STEPS
    )
    assert found.profiles["w_S [1]"] + found.profiles["w_P [1]"] == approx(
        1.0, abs=1e-12
    )
    assert left == approx(np.exp(-1.0), abs=STEPS)


def test_a_profile_of_temperature_moves_with_the_heat(tmp_path):
    """One temperature, gas at once: C dT/dt + G c_p dT/dx = 0, so that the profile
    moves as it is.
    """
    scene, _ = heated(4.0)
    scene["closures"], scene["initial"] = {}, {}
    set_keys(scene, "mesh.cells = 20")
    speed = 0.5 * 30.0 / 0.028 / (0.6 * 2000.0 * 800.0)
    time = 0.1 / speed  # through half of the bed
    set_keys(scene, "boundary.left.gas.temperature = 300.0")
    scene["time"] = {"end": time}
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    at = np.array([0.15, 0.17, 0.19])
    scene["output"]["positions"] = at.tolist()
    found = solved(
        begins_with(scene, tmp_path, "x [cm],T_fluid [degC]\n0,26.85\n20,126.85\n")
    )
    assert found.profiles["T_solid [K]"] == approx(
        300.0 + 500.0 * (at - 0.1), abs=300.0 * STEPS
    )


def test_solids_that_move_carry_their_profile(tmp_path):
    scene = decaying()
    let_move(scene, 0.6 * 5e-4)  # so that they move by 0.5 m
    set_keys(scene, "mesh.cells = 20")
    table = rows("x [m],w_S [1],w_P [1]", (0.0, 1.0), (1.0, 0.2), (0.0, 0.8))
    found = solved(begins_with(scene, tmp_path, table))
    x, w = found.profiles["x [m]"], found.profiles["w_S [1]"]
    moved = np.where(x > 0.5, (1.0 - 0.8 * (x - 0.5)) * np.exp(-1.0), np.exp(-x / 0.5))
    # a kink in cells of 0.05, and no P at the inlet, where a cell is damped
    assert np.abs(w - moved).max() < 1e-2
    assert np.abs(w - moved)[(np.abs(x - 0.5) > 0.2) & (x > 0.05)].max() < STEPS


# an earlier run


@pytest.mark.parametrize("section", [False, True], ids=["line", "section"])
def test_a_steady_state_stays(tmp_path, section):
    """Gas and particles that conduct and react, from the profiles of their steady
    state.
    """
    gas = {"elements": {"H": 28.0}, "molar_mass": 0.028, "heat_capacity": 30.0}
    scene = isothermal(
        "A:0.9, B:0.1", {"A": gas | {"enthalpy": 4000.0}, "B": gas | {"enthalpy": 0.0}}
    )
    set_keys(
        scene,
        """
        gas.viscosity = 2e-5
        gas.conductivity = 0.05
        gas.diffusivity = 2e-5
        solids.particles.density = 2000.0
        solids.particles.heat_capacity = 800.0
        heat = {}
        closures.nusselt = 10.0
        closures.conductivity_solids = 1.0
        reactions = { r = { equation = "A -> B", A = 5e3, E = 4e4 } }
        mesh.cells = 24
        """,
    )
    if section:  # adiabatic: uniform across
        scene["mesh"]["diameter"] = 0.1
        scene["boundary"]["wall"] = {"heat_flux": 0.0}
        scene["packed_bed"]["section"] = {
            "rings": 2,
            "conductivity_solids": 1.0,
            "conductivity_gas": 1.0,
        }
    scene["output"]["positions"] = np.linspace(0.0, 1.0, 193).tolist()
    before = solved(scene).profiles
    write_table(tmp_path / "profiles.csv", before)
    set_keys(scene, "time = { end = 300.0 }")
    set_keys(scene, 'packed_bed.gas_storage = "stored"')
    scene["initial"] |= {"file": str(tmp_path / "profiles.csv")}
    after = solved(scene).profiles
    span = np.ptp(before["T_solid [K]"])
    assert span > 30.0
    for key, size in (("T_fluid [K]", span), ("T_solid [K]", span), ("x_A [1]", 1.0)):
        # of interpolation and of steps
        assert after[key] == approx(before[key], abs=2e-4 * size)


def continued(tmp_path, scene, first, end):
    """Profiles of a run in one piece and of one that goes on from those of its first
    part.
    """
    whole = solved(scene | {"time": scene["time"] | {"end": end}})
    part = solved(
        scene | {"time": scene["time"] | {"end": first, "times": [0.5 * first]}}
    )
    write_table(tmp_path / "profiles.csv", part.profiles)
    rest = {
        "time": scene["time"] | {"end": end - first},
        "initial": {"file": str(tmp_path / "profiles.csv")},
    }
    return whole.profiles, solved(scene | rest).profiles


def reacting(cells):
    scene = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 0.8)
    scene["mesh"]["cells"] = cells
    set_keys(scene, "time = { tolerance = 1e-5 }")
    del scene["output"]["positions"]
    return scene


def test_a_run_goes_on_from_the_profiles_of_an_earlier_one(tmp_path):
    """Interpolation between three positions of a cell is of order 2; steps to 1e-5
    are below that.
    """
    errors = []
    for cells in (4, 8, 16):
        whole, after = continued(tmp_path, reacting(cells), 200.0, 400.0)
        errors.append(
            max(np.abs(whole[key] - after[key]).max() for key in ("w_S [1]", "x_A [1]"))
        )
    assert errors[0] < 2e-3 and errors[2] < 2e-4
    # 1/4 of order 2
    assert errors[1] < 0.35 * errors[0] and errors[2] < 0.35 * errors[1]


def test_two_temperatures_go_on(tmp_path):
    scene, eta = heated(4.0)
    set_keys(scene, "mesh.cells = 12")
    whole, after = continued(tmp_path, scene, 2.0 / eta, 4.0 / eta)
    for key in ("T_fluid [K]", "T_solid [K]"):
        # 1e-3 of 300 K by interpolation
        assert after[key] == approx(whole[key], abs=0.3)


@pytest.mark.parametrize("capacity", [None, 2.0], ids=["linear", "langmuir"])
def test_particles_that_hold_gas_go_on(tmp_path, capacity):
    scene, unit = adsorber(50.0, 20.0, 0.02, capacity)
    set_keys(scene, "mesh.cells = 24")
    del scene["output"]["positions"]
    whole, after = continued(tmp_path, scene, 8.0 * unit, 12.0 * unit)
    key = "q_A [mol/kg]"
    # interpolation of the front
    assert after[key] == approx(whole[key], abs=3e-3 * whole[key].max())


def test_kinds_go_on_with_what_each_holds(tmp_path):
    scene = split(adsorber(50.0, 20.0, 0.02)[0])
    unit = adsorber(50.0, 20.0, 0.02)[1]
    set_keys(scene, "mesh.cells = 30")
    del scene["output"]["positions"]
    whole, after = continued(tmp_path, scene, 8.0 * unit, 12.0 * unit)
    for key in (key for key in whole if key.startswith("q_")):
        assert after[key] == approx(whole[key], abs=5e-3 * whole[key].max())


def test_rows_of_the_time_that_is_named(tmp_path):
    table = (
        "t [s],x [m],w_S [1],w_P [1]\n0,0,1,0\n0,1,1,0\n600,0,0.5,0.5\n600,1,0.5,0.5\n"
    )
    early = plan(from_dict(begins_with(decaying(), tmp_path, table, time=0.0)))
    assert "start.csv at t = 0 s: n_S, n_P" in str(early)
    late = solved(begins_with(decaying(end=10.0), tmp_path, table))
    assert late.profiles["w_S [1]"][0] == approx(0.5 * np.exp(-0.01), abs=1e-6)
    refused(
        r"start\.csv:1: no rows at t = 300 s; the file has t = 0, 600 s",
        lambda: from_dict(begins_with(decaying(), tmp_path, table, time=300.0)),
    )


# particles that hold gas


def test_loadings_give_the_concentrations_that_hold_them():
    """What particles hold at given concentrations, and back; linear and competing
    isotherms, with and without pores.
    """
    points = interior(3, "sphere")
    T_solid = np.array([300.0, 400.0])
    c = {
        "A": np.array([1.0, 40.0]),
        "B": np.array([5.0, 0.0]),
        "C": np.array([3.0, 1e3]),
    }
    isotherms = {
        "A": Isotherm(1e-4, 2.0, -2e4, 300.0),
        "B": Isotherm(5e-4, 1.0, 0.0, 300.0),
        "C": Isotherm(1e-6, None, -1e4, 300.0),
    }
    for pores in (0.0, 0.4):
        inside = Inside(
            ("A", "B", "C"),
            isotherms,
            {},
            points.weights,
            points.stiffness,
            points.surface,
            0.0,
            1e-3,
            pores,
            900.0,
            0.6,
        )
        held = inside.held(
            {gas: [value] * inside.count for gas, value in c.items()}, T_solid
        )[0]
        q = {
            gas: sum(parts) / (inside.solids * inside.density)
            for gas, parts in held.items()
        }
        found = inside.concentrations(q, T_solid)
        for gas, value in c.items():
            assert found[gas] == approx(value, rel=1e-12, abs=1e-13)
    full = Inside(
        ("A",),
        {"A": isotherms["A"]},
        {},
        points.weights,
        points.stiffness,
        points.surface,
        0.0,
        1e-3,
        0.0,
        900.0,
        0.6,
    )
    assert not np.isfinite(
        full.concentrations({"A": np.array([2.0])}, np.array([300.0]))["A"]
    ).any()


def test_the_plan_tells_what_is_uniform(tmp_path):
    scene, _ = adsorber(50.0, 20.0, 10.0)
    del scene["initial"]["gas"]
    set_keys(scene, "time.end = 1.0")
    table = "x [m],q_A [mol/kg]\n0,1e-4\n1,0\n"
    text = str(plan(from_dict(begins_with(scene, tmp_path, table))))
    assert (
        "start.csv: q_A; gas of one composition; particles uniform inside, with the "
        "loadings of the file" in text
    )
    table = "x [m],x_A [1],x_N [1]\n0,1e-6,0.999999\n1,0,1\n"
    text = str(plan(from_dict(begins_with(scene, tmp_path, table))))
    assert (
        "start.csv: x_A, x_N; particles in equilibrium with the gas around them" in text
    )


def warm_sorbent(table, path):
    """Particles that adsorb, with heat, as they begin: by name of the unknown."""
    scene, _ = adsorber(50.0, 20.0, 0.02)
    del scene["initial"]["gas"]
    for data in scene["gas"]["species"].values():
        data |= {"heat_capacity": 30.0, "enthalpy": 0.0, "conductivity": 0.03}
    set_keys(
        scene,
        """
        solids.particles.heat_capacity = 900.0
        heat = {}
        closures.nusselt = 10.0
        time.end = 1.0
        """,
    )
    found = plan(from_dict(begins_with(scene, path, table)))
    course = Course.of(found.scene, found.problem, found.schedule, found.stores_gas)
    return dict(
        zip(course.problem.names, course.start(), strict=True)
    ), course.problem.line.points


def test_particles_begin_in_equilibrium_with_the_gas_of_the_file(tmp_path):
    """At the temperature of the gas around them, whose moles per volume fall with
    it.
    """
    u, x = warm_sorbent(
        "x [m],T_fluid [K],x_A [1],x_N [1]\n0,300,1e-6,0.999999\n1,600,1e-6,0.999999\n",
        tmp_path,
    )
    assert u["a_A_0"] == approx(1e-6 * P / (R_GAS * (300.0 + 300.0 * x)), rel=1e-12)


def test_one_temperature_is_that_of_the_particles(tmp_path):
    """They hold the heat; of two temperatures each has its own, and one column holds
    for both.
    """
    table = "x [m],T_fluid [K],T_solid [K]\n0,310,300\n0.2,310,300\n"
    for given, wanted in (
        (table, {"T": 300.0}),
        (table.replace(",T_solid [K]", "").replace(",300", ""), {"T": 310.0}),
    ):
        scene, _ = heated(4.0)
        scene["closures"], scene["initial"], scene["time"] = {}, {}, {"end": 1.0}
        found = plan(from_dict(begins_with(scene, tmp_path, given)))
        course = Course.of(found.scene, found.problem, found.schedule, found.stores_gas)
        u = dict(zip(course.problem.names, course.start(), strict=True))
        assert {name: float(u[name].mean()) for name in wanted} == wanted
    u, _ = warm_sorbent(
        "x [m],T_fluid [K],T_solid [K]\n0,310,300\n1,310,300\n", tmp_path
    )
    assert u["T_fluid"].mean() == 310.0 and u["T_solid"].mean() == 300.0
    u, _ = warm_sorbent("x [m],T_solid [K]\n0,300\n1,300\n", tmp_path)
    assert u["T_fluid"].mean() == 300.0 and u["T_solid"].mean() == 300.0


def test_gases_of_the_file_belong_to_the_bed(tmp_path):
    """A gas that neither enters nor reacts, but fills the bed, leaves it."""
    scene = isothermal(
        "B:1", species(A=0.028, B=0.028), closures={"dispersion_mass": 0.0}
    )
    set_keys(scene, "mesh.cells = 10")
    scene["time"] = {"end": 0.5 * RESIDENCE, "tolerance": 1e-3}
    set_keys(scene, 'packed_bed.gas_storage = "stored"')
    found = solved(begins_with(scene, tmp_path, "x [m],x_A [%]\n0,100\n1,100\n"))
    assert found.qoi["x_A_out"] == approx(1.0, abs=1e-3)


# bad tables


@each_case(__file__, "mistakes_of_a_table_are_told")
def test_mistakes_of_a_table_are_told(tmp_path, table, message):
    refused(
        r"initial\.file.*: (start\.csv:1: )?" + message,
        lambda: plan(from_dict(begins_with(decaying(), tmp_path, table))),
    )


def test_temperatures_and_gas_are_given_once(tmp_path):
    scene, _ = heated(4.0)
    set_keys(scene, "time.end = 1.0")
    table = "x [m],T_fluid [K]\n0,300\n0.2,300\n"
    refused(
        r"column 'T_fluid': temperatures stand in initial\.temperature as well",
        lambda: plan(from_dict(begins_with(scene, tmp_path, table))),
    )
    del scene["initial"]["temperature"]
    set_keys(scene, 'packed_bed.gas_storage = "stored"')
    set_keys(scene, 'initial.gas = { composition = "A:1" }')
    table = "x [m],T_fluid [K],x_A [1]\n0,300,1\n0.2,300,1\n"
    refused(
        r"column 'x_A': the gas stands in initial\.gas\.composition as well",
        lambda: plan(from_dict(begins_with(scene, tmp_path, table))),
    )


def test_inert_solids_and_full_particles_are_told(tmp_path):
    scene = decaying()
    scene["solids"]["particles"]["composition"] = "S:0.8, I:0.2"
    scene["solids"]["particles"]["constituent"]["I"] = {
        "elements": {"Al": 1.0},
        "molar_mass": 0.1,
    }
    table = "x [m],w_S [1],w_P [1]\n0,0.4,0.4\n1,0.4,0.3\n"
    refused(
        r"start\.csv:3: .* sum to 0\.9, 0\.2 of them of what does not react",
        lambda: plan(from_dict(begins_with(scene, tmp_path, table))),
    )
    table = "x [m],w_S [1],w_P [1],w_I [1]\n0,0.4,0.4,0.2\n1,0.4,0.3,0.3\n"
    refused(
        r"start\.csv:3: column 'w_I': 0\.3, and this solid does not react .* 0\.2",
        lambda: plan(from_dict(begins_with(scene, tmp_path, table))),
    )
    scene, _ = adsorber(50.0, 20.0, 0.02, 2.0)
    set_keys(scene, "time.end = 1.0")
    most = scene["solids"]["particles"]["adsorption"]["A"]["capacity"]
    refused(
        r"column 'q_A': .* no less than the capacity .* solids\.particles\.adsorption\.A\.capacity",
        lambda: plan(
            from_dict(
                begins_with(
                    scene, tmp_path, f"x [m],q_A [mol/kg]\n0,{2.0 * most!r}\n1,0\n"
                )
            )
        ),
    )


def test_a_missing_file_is_told(tmp_path):
    scene = decaying()
    scene["initial"] = {"file": str(tmp_path / "none.csv")}
    refused(r"initial\.file.*: no such file", from_dict, scene)


def test_a_profile_of_a_shorter_bed_is_told(tmp_path):
    for last, told in ((0.5, True), (0.96, False)):
        table = f"x [m],w_S [1],w_P [1]\n0,1,0\n{last},1,0\n"
        found = solved(begins_with(decaying(end=10.0), tmp_path, table))
        assert (
            any("positions from 0 to 0.5 m" in text for text in found.warnings) == told
        )
