"""Cyclic steady states of reacting beds: against regenerators, against marching many
periods, bounds, messages.
"""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from adsorption_scenes import adsorber
from pytest import approx
from reacting_bed_scenes import MOLAR, heated, isothermal, looping, species, switched
from solving import solved

import contbed
from contbed.course import cycle as periodic
from contbed.errors import ConvergenceError
from contbed.loading import from_dict
from contbed.models import plan
from contbed.reacting_bed import cycle
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.solve import Report
from contbed.reacting_bed.time_steps import BedSteps, begin
from contbed.reacting_bed.transient_results import contents
from contbed.reacting_bed.transient_run import searched
from contbed.solvers.anderson import Anderson
from tests.particle.tables import rows
from tests.refusals import refused
from tests.restarts import interrupt, same_run
from tests.scene_text import set_keys

TOLERANCE = 1e-8  # of the change over a period, the default


def regenerator(row):
    """A bed that stores heat, without reactions, with one blow from either end; the
    times of both.
    """
    scene, eta = heated(row["Lambda_hot"])
    times = [row[f"Pi_{blow}"] / eta for blow in ("hot", "cold")]
    scene["boundary"]["left"]["gas"]["mass_flux"] = switched(
        [0.5, -0.5 * row["Lambda_hot"] / row["Lambda_cold"]], times[0]
    )
    set_keys(scene, "boundary.right = { gas = { temperature = 300.0 } }")
    scene["time"] = {"end": sum(times), "times": [times[0]]}
    set_keys(
        scene,
        """
        packed_bed.gas_storage = "quasi_steady"
        initial.temperature = 450.0
        time.cycle = {}
        mesh.cells = 20
        """,
    )
    nodes, weights = np.polynomial.legendre.leggauss(40)
    scene["output"]["positions"] = (
        0.5 * scene["mesh"]["length"] * (1.0 + nodes)
    ).tolist()
    return scene, 0.5 * weights


@pytest.mark.slow
def test_a_regenerator():
    """Heat stored by the hot blow over what the gas could leave, of exact tables:
    (T_mid - T_end)/dT Lambda/Pi.
    """
    row = next(
        row
        for row in rows("regenerator.csv")
        if row["Lambda_hot"] == 30 and row["Pi_cold"] == 25
    )
    scene, weights = regenerator(row)
    found = solved(scene)
    middle, end = found.profiles["T_solid [K]"].reshape(2, -1)
    charged = (
        float(weights @ (middle - end)) / 300.0 * row["Lambda_hot"] / row["Pi_hot"]
    )
    # steps to a local error of 1e-4
    assert charged == approx(row["effectiveness_hot"], abs=2e-4)
    assert (
        found.qoi["cycle_change_K"] <= TOLERANCE * 300.0
        and found.qoi["cycle_periods"] < 20
    )
    assert found.qoi["cycle_change"] <= TOLERANCE


@pytest.mark.slow
def test_solids_that_are_reduced_and_oxidised_against_plain_repetition(monkeypatch):
    found = solved(looping())
    monkeypatch.setattr(Anderson, "__call__", lambda self, state, image: image)
    plain = solved(looping())
    for key in ("n_S [mol/m3]", "x_A [1]", "x_O [1]"):
        # the change falls by 0.3 a period: what is left is below 2 of the tolerance,
        # over 0.3 of what reacts
        size = max(np.abs(plain.profiles[key]).max(), 1.0)
        assert found.profiles[key] == approx(plain.profiles[key], abs=1e-6 * size)
    assert found.qoi["cycle_periods"] < plain.qoi["cycle_periods"]
    # what is at rest is that of the start, and what one half gives the other takes
    total = found.profiles["n_S [mol/m3]"] + found.profiles["n_P [mol/m3]"]
    assert total == approx(total[0], rel=1e-12)
    reduced, oxidised = (
        found.qoi[f"extent_{name}_mol_m2s"] for name in ("reduction", "oxidation")
    )
    assert oxidised > 0.0 and reduced > -1e-12 * oxidised
    fe = found.balances["Fe"]
    assert abs(fe["in"]) < 1e-12 and abs(fe["stored"]) < 1e-9


@pytest.mark.slow
def test_a_hot_zone_between_two_directions_of_flow():
    """An exothermic reaction that the turning flow keeps in the bed: repetition
    falls by 2 % a period near its end.
    """
    gas = {"elements": {"H": 28.0}, "molar_mass": 0.028, "heat_capacity": 30.0}
    scene = isothermal(
        "A:0.02, B:0.98", {"A": gas | {"enthalpy": 150e3}, "B": gas | {"enthalpy": 0.0}}
    )
    set_keys(
        scene,
        """
        solids.particles.density = 1500.0
        solids.particles.heat_capacity = 800.0
        heat = {}
        closures.conductivity_solids = 5.0
        mesh.length = 0.5
        mesh.cells = 8
        """,
    )
    # not where cells meet
    scene["output"]["positions"] = (0.5 / 16.0 * (np.arange(16) + 0.5)).tolist()
    scene["boundary"] = {
        side: {"gas": {"temperature": 350.0}} for side in ("left", "right")
    }
    scene["boundary"]["left"]["gas"]["mass_flux"] = switched([0.3, -0.3], 60.0)
    set_keys(
        scene,
        """
        reactions = { r = { equation = "A -> B", A = 2e4, E = 5e4 } }
        time = { end = 120.0, times = [60.0] }
        packed_bed.gas_storage = "quasi_steady"
        initial.temperature = 600.0
        time.tolerance = 1e-3
        time.cycle = {}
        """,
    )
    found = solved(scene)
    assert found.qoi["cycle_periods"] <= 40  # some 1000 by repetition
    middle, end = found.profiles["T_solid [K]"].reshape(2, -1)
    assert end.max() > 450.0  # ignited: what enters has 350 K and could rise by 100 K
    # both halves are mirror images: the first ends as the second from the other side
    assert middle == approx(end[::-1], abs=0.3)  # 1e-3 of 300 K by steps


def search(course):
    """All periods of the search for a cycle."""
    steps = BedSteps(course, Report())
    return list(searched(steps, None, lambda _: None, lambda *_: None))


def course_of(scene):
    found = plan(from_dict(scene))
    return Course.of(found.scene, found.problem, found.schedule, found.stores_gas)


def marched(scene, count):
    """The run that goes through so many periods."""
    time = {
        key: value
        for key, value in scene["time"].items()
        if key not in ("cycle", "times")
    }
    again = scene | {"time": time | {"end": count * time["end"]}}
    again["boundary"] = deepcopy(scene["boundary"])
    again["boundary"]["left"]["gas"]["composition"]["period"] = time["end"]
    return solved(again)


@pytest.mark.parametrize(
    "isotherm", ["linear", pytest.param("langmuir", marks=pytest.mark.slow)]
)
def test_a_bed_that_adsorbs_and_is_flushed_against_marching(isotherm):
    scene, unit = adsorber(20.0, 6.0, 0.02, None if isotherm == "linear" else 2.0)
    scene["boundary"]["left"]["gas"]["composition"] = switched(
        ["A:1e-6, N:0.999999", "N:1"], 2.0 * unit
    )
    scene["time"] |= {"end": 4.0 * unit, "tolerance": 1e-3, "cycle": {}}
    set_keys(scene, "mesh.cells = 4")
    del scene["output"]["positions"]
    found, after = solved(scene), marched(scene, 8)
    key = "q_A [mol/kg]"
    # of steps
    assert found.profiles[key] == approx(
        after.profiles[key], abs=2e-3 * after.profiles[key].max()
    )
    carbon = found.balances["C"]
    assert abs(carbon["stored"]) < 10.0 * TOLERANCE * carbon["in"]
    assert carbon["in"] == approx(carbon["out"], rel=10.0 * TOLERANCE)


@pytest.mark.slow
def test_a_gas_in_the_pores_against_marching():
    scene = isothermal(
        "A:1", species(A=0.028, B=0.028), closures={"dispersion_mass": 0.1}
    )
    scene["boundary"]["left"]["gas"]["composition"] = switched(["A:1", "B:1"], 0.4)
    set_keys(
        scene,
        """
        time = { end = 0.8, tolerance = 1e-3, cycle = {} }
        packed_bed.gas_storage = "stored"
        initial.gas = { composition = "B:1" }
        mesh.cells = 6
        """,
    )
    found, after = solved(scene), marched(scene, 6)
    # of steps
    assert found.profiles["x_A [1]"] == approx(after.profiles["x_A [1]"], abs=2e-3)
    assert found.qoi["cycle_periods"] <= 12


@pytest.mark.slow
def test_kept_steps_that_miss_more_than_allowed_are_chosen_anew(monkeypatch):
    """Steps of the first period alone, that of a bed at one temperature, do not fit
    the last.
    """
    wanted = solved(looping())
    monkeypatch.setattr(periodic, "ADAPTIVE", 1)
    found = solved(looping())
    assert found.profiles["n_S [mol/m3]"] == approx(
        wanted.profiles["n_S [mol/m3]"], rel=2e-3, abs=10.0
    )
    errors = []
    monkeypatch.setattr(periodic, "MOST", 8)
    course = course_of(looping())
    # of which every step misses more: all periods are chosen anew
    monkeypatch.setattr(periodic, "OUTDATED", 1e-3)
    before = BedSteps.repeated
    monkeypatch.setattr(
        BedSteps, "repeated", lambda *given: errors.append(1) or before(*given)
    )
    seen = search(course)
    assert len(errors) <= (len(seen) + 1) // 2


@pytest.mark.slow
def test_a_period_that_fails_from_an_extrapolated_state_is_repeated_from_the_best(
    monkeypatch,
):
    course, before, calls = course_of(looping()), periodic._steps, []

    def failing(*given):
        calls.append(1)
        if len(calls) == 3:
            raise ConvergenceError("the time step fell below its limit")
        return before(*given)

    monkeypatch.setattr(periodic, "_steps", failing)
    found = search(course)
    assert found[-1].closed and len(found) == len(calls) - 1
    monkeypatch.setattr(periodic, "_steps", lambda *_: failing())
    calls[:] = [1, 1]
    with pytest.raises(ConvergenceError, match="below its limit"):
        search(course)


@pytest.mark.slow
def test_an_extrapolation_that_changes_much_more_is_given_up_for_the_best_period(
    monkeypatch,
):
    course, before, calls = course_of(looping()), Anderson.__call__, []

    def wild(self, state, image):
        calls.append(1)
        return (
            image.reshape(2, -1)[::-1].ravel()
            if len(calls) == 3
            else before(self, state, image)
        )

    # what is left of S is P, and the other way round
    monkeypatch.setattr(Anderson, "__call__", wild)
    found = search(course)
    assert found[3].largest > periodic.GROWN * found[2].largest
    assert found[4].history.held == approx(
        contents(course.problem, found[2].history.state), rel=1e-12
    )
    assert found[-1].closed


def test_extrapolated_states_stay_within_their_bounds_node_by_node():
    course = course_of(looping())
    problem, u = course.problem, course.start()
    S, P = (problem.names.index(name) for name in ("n_S", "n_P"))
    u[P], u[S] = 0.25 * u[S], 0.75 * u[S]
    stored = cycle.Stored.of(problem, course.sizes(u))
    wanted = stored.values(u)
    assert wanted.shape[0] == 2 and wanted.sum(axis=0) == approx(1.0)
    wanted[:, 2, 1] = [1.5, -0.5]  # beyond: P would be below zero
    wanted[:, 3, 0] = [0.1, 0.9]
    found = stored.values(stored.bounded(wanted, u))
    assert found[:, 2, 1] == approx([1.0, 0.0], abs=1e-15)
    assert found[:, 3, 0] == approx([0.1, 0.9])
    assert found.sum(axis=0) == approx(1.0, abs=1e-15)
    others = np.ones(found.shape[1:], dtype=bool)
    others[2, 1] = others[3, 0] = False
    assert np.array_equal(found[:, others], stored.values(u)[:, others])


def test_extrapolated_temperatures_and_fractions_stay_within_their_bounds():
    scene, _ = heated(4.0)
    scene["gas"]["species"]["B"] = scene["gas"]["species"]["A"]
    set_keys(
        scene,
        """
        gas.composition = "A:0.5, B:0.5"
        mesh.cells = 3
        time = { end = 1.0 }
        packed_bed.gas_storage = "stored"
        initial.temperature = 300.0
        """,
    )
    course = course_of(scene)
    u = course.start()
    stored = cycle.Stored.of(course.problem, course.sizes(u))
    names = [course.problem.names[k] for k in stored.rows]
    assert names == ["g_A", "g_B", "T_fluid", "T_solid"]
    wanted = stored.values(u)
    wanted[:, 0, 0] = [1.2, -0.2, *wanted[2:, 0, 0]]
    wanted[2, 1, 0] += 2.0  # of 300 K: further than half of it
    out = stored.bounded(wanted, u)
    found = stored.values(out)
    assert found[:2, 0, 0] == approx([1.0, 0.0], abs=1e-15)
    assert found[:2].sum(axis=0) == approx(1.0, abs=1e-15)
    assert found[2, 1, 0] == approx(1.0 + cycle.BEYOND)
    # the flux of the gas is that it had
    assert out[:2].sum(axis=0) == approx(u[:2].sum(axis=0), rel=1e-14)


@pytest.mark.slow
def test_a_cycle_goes_on_from_its_checkpoint(tmp_path):
    scene, loose = from_dict(looping()), looping()
    loose["time"]["cycle"] = {"tolerance": 1e-2}
    few = contbed.run(from_dict(loose), out=tmp_path / "loose")
    first = contbed.run(scene, out=tmp_path / "one", restart=tmp_path / "loose")
    assert few.qoi["cycle_change"] > TOLERANCE >= first.qoi["cycle_change"]
    again = contbed.run(scene, out=tmp_path / "two", restart=tmp_path / "one")
    assert again.qoi == first.qoi
    key = "n_S [mol/m3]"
    assert np.array_equal(again.profiles[key], first.profiles[key])


def test_a_cycle_that_is_not_found_keeps_its_last_period(monkeypatch):
    monkeypatch.setattr(periodic, "MOST", 2)
    kept = []
    monkeypatch.setattr(
        "contbed.reacting_bed.transient_run.fill",
        lambda at, history, result: kept.append(history.time),
    )
    with pytest.raises(
        ConvergenceError,
        match=r"time\.cycle: of 2 periods the best changes the bed by 0\.0",
    ):
        contbed.run(from_dict(looping()))
    assert kept == [1200.0]


def test_a_cycle_that_is_not_found_ends_with_its_best_period(monkeypatch):
    course, before = course_of(looping()), Anderson.__call__

    def wild(self, state, image):
        return (
            image.reshape(2, -1)[::-1].ravel()
            if len(self.pairs) == 1
            else before(self, state, image)
        )

    # what is left of S is P, and the other way round
    monkeypatch.setattr(Anderson, "__call__", wild)
    monkeypatch.setattr(periodic, "MOST", 3)
    *found, best = search(course)
    assert [each.number for each in found] == [1, 2, 3] and best.number == 3
    assert best.largest == min(each.largest for each in found) < 0.5 * found[-1].largest


def test_cycles_that_cannot_be_are_told():
    scene = looping()
    set_keys(scene, 'boundary.left.gas.composition = "A:1"')
    refused(
        r"time\.cycle.*: a cycle needs a composition, a flow, or a temperature",
        from_dict,
        scene,
    )
    scene = looping()
    set_keys(scene, "boundary.left.gas.composition.period = 900.0")
    refused(
        r"its period of 900 s fits 1\.33333 times into the cycle.*multiple",
        from_dict,
        scene,
    )
    scene["boundary"]["left"]["gas"]["composition"]["period"] = 600.0 + 1e-5
    set_keys(scene, "boundary.left.gas.composition.times = [0.0, 300.0]")
    refused("fits 2 times into the cycle", from_dict, scene)
    set_keys(scene, "boundary.left.gas.composition.period = 600.0")
    from_dict(scene)
    set_keys(scene, "time.cycle = { tolerance = 0.0 }")
    refused(r"time\.cycle\.tolerance", from_dict, scene)


@pytest.mark.slow
def test_a_state_that_comes_back_comes_back_by_other_steps():
    """The state of a cycle by kept steps, marched once by steps that are chosen
    anew, to their errors.
    """
    course = course_of(looping())
    last = search(course)[-1]
    last = last.history.state
    *_, after = BedSteps(course, Report()).march(begin(course, last))
    stored = cycle.Stored.of(course.problem, course.sizes(after.state))
    assert np.abs(stored.values(after.state) - stored.values(last)).max() < 1e-3


def following(rate):
    """Gas A that becomes B in a bed that stores nothing, of two compositions in
    turn.
    """
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    set_keys(scene, "mesh.cells = 8")
    scene["boundary"]["left"]["gas"]["composition"] = switched(
        ["A:0.5, B:0.5", "A:1"], 1.0
    )
    scene["reactions"] = {"r": {"equation": "A -> B", "rate": rate}}
    set_keys(scene, "time = { end = 2.0, cycle = {} }")
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    return scene


def test_a_bed_that_stores_nothing_closes_in_its_first_period():
    found = solved(following("c_A"))
    assert found.qoi["cycle_periods"] == 1 and found.qoi["cycle_change"] == 0.0
    # plug flow, to the error of 8 cells
    assert found.qoi["x_A_out"] == approx(np.exp(-0.4 / 0.5), abs=1e-6)


def test_a_cycle_that_was_found_is_told_at_other_times(tmp_path):
    scene = following("c_A")
    contbed.run(from_dict(scene), out=tmp_path / "one")
    set_keys(scene, "time.times = [0.5, 1.5]")
    again = contbed.run(
        from_dict(scene), out=tmp_path / "two", restart=tmp_path / "one"
    )
    assert again.qoi["cycle_periods"] == 1
    wanted = solved(scene)
    # nothing is stored
    assert again.profiles["x_A [1]"] == approx(wanted.profiles["x_A [1]"], rel=1e-12)
    assert sorted(set(again.profiles["t [s]"])) == [0.5, 1.5, 2.0]


def test_rates_that_take_what_is_not_there_in_a_cycle_are_told():
    # 0.55 of the gas, of which half is A in the first half of the period
    taking = 0.55 * 0.5 * MOLAR / 0.4
    with pytest.raises(
        ConvergenceError,
        match=r"r\.rate: takes .* of A where .*A falls to -0\.05 .* at t = 0\.0004 s",
    ):
        contbed.run(from_dict(following(str(taking))))


def loosely():
    """A cycle to a tolerance of some periods."""
    scene = looping()
    set_keys(scene, "time.cycle.tolerance = 1e-4")
    return from_dict(scene)


@pytest.fixture(scope="module")
def whole():
    return contbed.run(loosely())


@pytest.mark.parametrize("moment", [30, 100])
def test_an_interrupted_cycle_resumes_bit_for_bit(tmp_path, whole, moment):
    scene = loosely()
    interrupt(scene, tmp_path / "a", BedSteps, "_passed", moment)
    same_run(contbed.run(scene, out=tmp_path / "b", restart=tmp_path / "a"), whole)


def test_a_balance_counts_both_ways_at_an_end():
    """A gas that turns round each second: u n 28 of H enter in each of both, though
    as much leaves by the same end.
    """
    scene = following("0.0 * c_A")
    gas = scene["boundary"]["left"]["gas"]
    gas["composition"], gas["velocity"] = "A:1", switched([0.5, -0.5], 1.0)
    scene["boundary"]["right"] = {"gas": {"composition": "B:1", "temperature": 500.0}}
    found = solved(scene).balances["H"]
    assert found["in"] == approx(2.0 * 0.5 * MOLAR * 28.0, rel=1e-12)
    assert found["out"] == approx(found["in"], rel=1e-12)
