"""Streams that change with time: superposition of exact responses, symmetry, totals
that close.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import T, bilinear, fixed_bed, heated, schumann
from scipy.integrate import quad

import contbed
from contbed.course.schedule import Schedule
from contbed.loading import from_dict
from contbed.scene.series import Samples
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import set_keys

# of the span: steps to a local tolerance of 1e-4; the largest error found is 4e-5
STEPS = 1e-4
CLOSED = 1e-12


def closes(result):
    assert_closed(result, CLOSED)


def test_steps_of_the_inlet_temperature_superpose():
    scene, eta_per_s = heated(4.0)
    end, jump = 5.0 / eta_per_s, 2.0 / eta_per_s
    series = {"times": [0.0, jump], "values": [600.0, 400.0], "form": "step"}
    scene["boundary"]["left"]["gas"]["temperature"] = series
    scene["time"] |= {"end": end, "times": [jump]}
    result = contbed.run(from_dict(scene))
    exact = 300.0 * schumann(4.0, 5.0) - 200.0 * schumann(4.0, 3.0)
    assert result.qoi["T_fluid_out_K"] - 300.0 == approx(exact, abs=300.0 * STEPS)
    assert jump in result.tables["outlet"]["t [s]"]
    closes(result)


def turning(later):
    """Temperature and steps of a bed whose gas turns, and in which what enters has
    another temperature later by a share of the time.
    """
    scene, eta_per_s = heated(4.0)
    end = 3.0 / eta_per_s
    turns = {"times": [0.0, end / 3.0], "values": [0.5, -0.5], "form": "step"}
    colder = {
        "times": [0.0, end / 3.0 * (1.0 + later)],
        "values": [500.0, 400.0],
        "form": "step",
    }
    scene["boundary"]["left"]["gas"]["mass_flux"] = turns
    scene["boundary"]["left"]["gas"]["temperature"] = colder
    scene["boundary"]["right"] = {"gas": {"temperature": colder}}
    scene["time"]["end"] = end
    qoi = contbed.run(from_dict(scene)).qoi
    return qoi["T_fluid_out_K"], qoi["time_steps"]


@pytest.fixture(scope="module")
def at_once():
    return turning(0.0)


@pytest.mark.parametrize(
    "later", [1e-12, 1e-10, 4e-10, 6e-10, 1e-9, 1e-8, 1e-6, 1e-5], ids=str
)
def test_jumps_at_all_but_the_same_time_are_one(at_once, later):
    """As two files with other digits say it.

    Where both are cuts, what lies between them is no reason to store the gas, which
    stays a thousand times as long.
    """
    temperature, steps = turning(later)
    # the same steps, each longer or shorter by that share, of a temperature that
    # changes by some 200 K in the run
    assert temperature == approx(at_once[0], rel=1e-8, abs=200.0 * later)
    # one between times that are two, or those that grow from the first step to the time
    # between where that is longer; none that are halved towards a jump
    most = {1e-6: 2, 1e-5: 4}.get(later, 1)
    assert 0 <= steps - at_once[1] <= most


def test_totals_of_flows_that_cancel_close():
    """What the gas brings in a third of the time, it takes back at half of the flow
    in the rest.
    """
    scene, eta_per_s = heated(4.0)
    end = 1.5 / eta_per_s
    scene["boundary"]["left"]["gas"]["mass_flux"] = {
        "times": [0.0, end / 3.0],
        "values": [0.5, -0.25],
        "form": "step",
    }
    set_keys(
        scene,
        """
        boundary.left.gas.temperature = 500.0
        boundary.right = { gas = { temperature = 500.0 } }
        mesh.cells = 10
        """,
    )
    scene["time"] |= {"end": end}
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    result = contbed.run(from_dict(scene))
    moles = 0.5 * end / 3.0 / 1e-3  # of H, 1 g/mol as in all molecules here
    assert result.balances["H"]["in"] == approx(2.0 * moles, rel=1e-10)
    closes(result)


@pytest.mark.parametrize("later", [6e-10, 1e-9, 1.01e-9, 1e-8], ids=str)
@pytest.mark.parametrize("period", [None, 4.0], ids=["once", "periodic"])
def test_between_two_near_jumps_there_is_what_holds_since_the_first(later, period):
    samples = Samples(
        np.array([0.0, 1.0, 1.0 + later]), np.array([1.0, 2.0, 3.0]), "step", period
    )
    schedule = Schedule({("boundary", "left", "gas", "velocity"): samples})
    first, second = schedule.cuts(3.0)[1:3]
    for share in (0.3, 1.0):  # the stages of a step
        assert (
            samples.at(first + share * (second - first), before=True, since=first)
            == 2.0
        )
    assert samples.at(second) == 3.0
    assert samples.at(first, before=True) == 1.0
    assert schedule.jumps(second)


def test_kinks_of_two_series_whose_times_differ_by_rounding_are_no_jumps():
    """Times by products and by sums; after a jump steps begin anew, 1e5 times as
    short as the run.
    """
    times, values = 0.1 * np.arange(101), np.sin(np.arange(101.0))
    summed = np.cumsum(np.append(0.0, np.full(100, 0.1)))
    schedule = Schedule(
        {
            ("a",): Samples(times, values, "linear", None),
            ("b",): Samples(summed, values[::-1], "linear", None),
        }
    )
    cuts = schedule.cuts(10.0)
    assert len(cuts) == 101 and not any(schedule.jumps(time) for time in cuts[1:-1])
    step = Schedule({("a",): Samples(times, values, "step", None)})
    assert all(step.jumps(time) for time in step.cuts(10.0)[1:-1])


def test_a_ramp_of_the_inlet_temperature():
    scene, eta_per_s = heated(4.0)
    end = 5.0 / eta_per_s
    scene["boundary"]["left"]["gas"]["temperature"] = {
        "times": [0.0, end],
        "values": [300.0, 600.0],
    }
    scene["time"]["end"] = end
    result = contbed.run(from_dict(scene))
    exact = 300.0 * quad(lambda eta: schumann(4.0, eta) / 5.0, 0.0, 5.0)[0]
    assert result.qoi["T_fluid_out_K"] - 300.0 == approx(exact, abs=300.0 * STEPS)
    closes(result)


@pytest.mark.parametrize("form", ["rises", "hump"])
def test_small_kinks_are_passed_within_the_error_of_a_step(form):
    """An inlet measured at 720 times: a rise, and a hump of small kinks after a
    rest, which is not stepped over.
    """
    scene, eta_per_s = heated(4.0)
    end = 5.0 / eta_per_s
    times = np.linspace(0.0, end, 721)
    values = 300.0 + 400.0 * (1.0 - np.exp(-5.0 * times / end))
    if form == "hump":
        share = (times / end - 0.6) * 9.0
        wave = np.where(
            (share > 0.0) & (share < 1.0), 12.0 * np.sin(np.pi * share) ** 2, 0.0
        )
        values = np.where(times < 0.97 * end, 300.0 + wave, 700.0)
    scene["boundary"]["left"]["gas"]["temperature"] = {
        "times": times.tolist(),
        "values": values.tolist(),
    }
    now = 0.95 * end
    scene["time"] |= {"end": end, "times": [now]}
    result = contbed.run(from_dict(scene))
    middle = 0.5 * (times[1:] + times[:-1])
    # superposition of the rises; 720 parts miss less than 1e-3 K
    parts = [
        d * schumann(4.0, eta_per_s * (now - t))
        for d, t in zip(np.diff(values), middle, strict=True)
        if t < now
    ]
    outlet = result.tables["outlet"]
    found = np.interp(now, outlet["t [s]"], outlet["T_fluid [K]"])
    assert found - 300.0 == approx(sum(parts), abs=400.0 * STEPS)
    assert len(outlet["t [s]"]) < 300  # of 720 pieces
    closes(result)


def switched(first: float):
    """A bed that is used up from one end and then from the other, by gases of two
    compositions.
    """
    scene = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 0.8)
    composition = {
        "times": [0.0, 500.0],
        "values": ["A:1", "A:0.4, B:0.6"],
        "form": "step",
    }
    ends = {
        end: {"gas": {"temperature": T, "composition": composition}}
        for end in ("left", "right")
    }
    ends["left"]["gas"]["velocity"] = {
        "times": [0.0, 300.0],
        "values": [first, -0.6 * first],
        "form": "step",
    }
    scene["boundary"] = ends
    set_keys(scene, "mesh.cells = 30")
    length = scene["mesh"]["length"]
    scene["output"]["positions"] = [k * length / 8 for k in range(9)]
    return contbed.run(from_dict(scene))


def test_reversal_is_symmetric_and_closes():
    one, other = switched(0.5), switched(-0.5)
    closes(one)
    closes(other)
    for name in ("x_A [1]", "w_S [1]", "w_P [1]"):
        # rounding grows along the same steps; 1e-8 is the tolerance of Newton's method
        # over that of the steps
        np.testing.assert_allclose(
            one.profiles[name], other.profiles[name][::-1], atol=1e-8
        )
    assert one.qoi["u_in_m_s"] == approx(0.3)
    # the gas enters at the right now
    assert one.profiles["x_A [1]"][-1] == approx(0.4, abs=1e-6)


def test_composition_from_a_file(tmp_path):
    scene = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 0.8)
    pairs = {"times": [0.0, 400.0, 800.0], "values": ["A:1", "A:0.5, B:0.5", "A:1"]}
    (tmp_path / "feed.csv").write_text(
        "t [min],A [1],B [%]\n0,1,0\n6.666666666666667,0.5,50\n13.33333333333334,1,0\n"
    )
    inlet = scene["boundary"]["left"]["gas"]
    inlet["composition"] = pairs
    one = contbed.run(from_dict(scene))
    inlet["composition"] = {"file": "feed.csv"}
    other = contbed.run(from_dict(scene, base=tmp_path))
    for name, column in one.profiles.items():
        np.testing.assert_allclose(other.profiles[name], column, rtol=1e-9, atol=1e-12)
    closes(one)


def test_solids_that_start_to_move():
    """Particles at rest keep what has reacted and hand it over when they move; all
    iron is accounted for.
    """
    scene = bilinear(3.0, 0.8)
    stream = scene["boundary"]["right"]["solids"]["particles"]
    speed = stream["velocity"]
    # in which particles, at speed/0.6 between walls, move by a tenth of the bed
    move = 0.1 * 0.6 / speed
    stream["velocity"] = {"times": [0.0, move], "values": [0.0, speed], "form": "step"}
    scene["time"] = {"end": 2.0 * move}
    set_keys(scene, "mesh.cells = 10")
    result = contbed.run(from_dict(scene))
    closes(result)
    balance = result.balances["Fe"]
    assert balance["in"] == approx(0.1 * 0.6 * 3000.0 / 0.1, rel=1e-10)
    # each mole of S that reacts becomes one of P
    assert balance["out"] == approx(balance["in"], rel=1e-10)


@each_case(__file__, "mistakes")
def test_mistakes_in_series(key, series, said):
    scene = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 0.8)
    scene["boundary"]["left"]["gas"][key] = series
    refused(said, from_dict, scene)
