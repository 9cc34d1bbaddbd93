"""One particle that conducts and reacts: calculated wood spheres, a conducting
sphere, balances, mistakes.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from contbed.errors import ConvergenceError
from contbed.loading import load, loads
from contbed.models import MODELS
from contbed.runner import run
from contbed.single_particle import run as single_particle
from tests.balances import assert_closed
from tests.cases import each_case
from tests.particle.tables import rows
from tests.refusals import refused

SPHERE = (
    MODELS["single_particle"]
    .template.read_text(encoding="utf-8")
    .split("[boundary.surface]")[0]
)


def wood(start, times, series):
    """Wood sphere whose surface follows a measured temperature, with the constants
    of the tables.
    """
    text = SPHERE.replace("0.1742 ", "0.2046 ").replace("0.0970", "0.0936")
    text = text.replace("heat_capacity = 1100.0", "heat_capacity = 0.0")
    text = text.replace("heat = 3.46e4", "heat = 1.1e5").replace(
        "heat = -6.4e3", "heat = -2.1e5"
    )
    return f"""{text}
[single_particle]
cells = 16
[initial]
temperature = {start}
[boundary.surface.fixed_temperature]
times = {[float(row["time_s"]) for row in series]}
values = {[float(row["T_surface_K"]) for row in series]}
[time]
end = {max(times)}
times = {times}
tolerance = 5e-4
"""


@pytest.mark.parametrize(
    ("furnace", "start"),
    [
        pytest.param(638, 304.0, marks=pytest.mark.slow),
        pytest.param(688, 306.0, marks=pytest.mark.slow),
    ],
)
def test_calculated_wood_sphere(tmp_path, furnace, start):
    table = rows(f"wood_sphere_{furnace}.csv")
    series = [
        row for row in rows("park_2010_temperatures.csv") if row["furnace_K"] == furnace
    ]
    path = tmp_path / "wood.toml"
    path.write_text(wood(start, [float(row["time_s"]) for row in table], series))
    found = run(load(path))
    # the table itself: 5e-4 and 0.3 K between its grids; 16 shells, time steps of 5e-4
    # of the span
    assert found.profiles["mass_fraction [1]"] == approx(
        [row["mass"] for row in table], abs=4e-3
    )
    centre = np.abs(
        found.profiles["T_centre [K]"] - [row["T_centre_K"] for row in table]
    )
    # the temperature falls from its peak by 80 K within the 40 s between two rows
    assert np.median(centre) < 1.0 and centre.max() < 5.0
    assert_closed(found, 1e-11, "energy")
    assert_closed(found, 1e-11, "mass")


def inert(cells, end, biot):
    """Sphere of R = 1 cm, alpha = 1e-6 m2/s in a gas 100 K hotter."""
    return f"""
[single_particle]
cells = {cells}
[solids.stone]
diameter = 0.02
density = 1000.0
conductivity = 1.0
composition = "stone:1"
constituent.stone.heat_capacity = 1000.0
[initial]
temperature = 300.0
[boundary.surface]
ambient = 400.0
coefficient = {biot * 1.0 / 0.01}
[time]
end = {end}
times = [{end}]
tolerance = 1e-5
"""


def test_heated_sphere_of_second_order(tmp_path):
    # first term and more of the series: mu cot mu = 1 - Bi
    biot, fourier = 2.0, 0.3
    mu = np.array(
        [
            brentq(
                lambda x: np.sin(x) * (biot - 1) + x * np.cos(x),
                (k + 0.5) * np.pi,
                (k + 1) * np.pi,
            )
            for k in range(12)
        ]
    )
    share = 4 * (np.sin(mu) - mu * np.cos(mu)) / (2 * mu - np.sin(2 * mu))
    exact = 400.0 - 100.0 * float(np.sum(share * np.exp(-(mu**2) * fourier)))
    errors = []
    for cells in (4, 8, 16):
        path = tmp_path / "inert.toml"
        path.write_text(inert(cells, fourier * 1e-4 / 1e-6, biot))
        errors.append(abs(run(load(path)).profiles["T_centre [K]"][-1] - exact))
    # second order
    assert errors[0] / errors[1] == approx(4.0, rel=0.3) and errors[1] / errors[
        2
    ] == approx(4.0, rel=0.3)
    assert errors[2] < 0.3


def test_uniform_reaction_is_exponential(tmp_path):
    text = inert(6, 100.0, 1.0).replace("ambient = 400.0", "ambient = 300.0")
    path = tmp_path / "reacts.toml"
    path.write_text(
        text + '[reactions.gas]\nof = "stone"\nA = 0.02\nE = 0.0\nyields = {}\n'
    )
    found = run(load(path))
    assert found.profiles["mass_fraction [1]"][-1] == approx(np.exp(-2.0), rel=1e-3)
    assert found.qoi["T_centre_max_K"] == approx(300.0, abs=1e-6)


TANK = """
[single_particle]
cells = 4
[solids.bead]
diameter = 0.01
density = 2000.0
conductivity = 400.0
composition = "copper:1"
constituent.copper.heat_capacity = 800.0
[initial]
temperature = 300.0
[boundary.surface]
coefficient = 100.0
ambient = {series}
[time]
end = 3600.0
times = {times}
"""
# [1/s] of a sphere that is as hot inside as outside
RATE = 100.0 * 6.0 / (0.01 * 2000.0 * 800.0)


@pytest.mark.parametrize("form", ["step", "linear"])
@pytest.mark.parametrize("width", [1.0, 60.0], ids=str)
def test_a_short_pulse_of_the_furnace_is_not_stepped_over(tmp_path, width, form):
    """Nothing happens for 3000 s, so that steps are long; then the furnace is hot,
    or warms and cools, for `width`.
    """
    begin, end = 3000.0, 3000.0 + width
    times, values = [0.0, begin, end], [300.0, 1000.0, 300.0]
    risen, after = 700.0 * (1.0 - np.exp(-RATE * width)), 10.0
    if form == "linear":  # a triangle
        times, values = (
            [0.0, begin, begin + 0.5 * width, end, 3600.0],
            [300.0, 300.0, 1000.0, 300.0, 300.0],
        )
        risen = 1400.0 / (RATE * width) * (1.0 - np.exp(-0.5 * RATE * width)) ** 2
    path = tmp_path / "pulse.toml"
    series = f'{{ times = {times}, values = {values}, form = "{form}" }}'
    path.write_text(TANK.format(series=series, times=[end, end + after]))
    found = run(load(path))
    # local errors of 1e-4 of 700 K; h R/(3 k) = 4e-4 of the rise, and of its delay
    expected = 300.0 + risen * np.array(
        [1.0, np.exp(-RATE * after), np.exp(-RATE * (3600.0 - end))]
    )
    assert found.profiles["T_mean [K]"] == approx(expected, abs=0.7)
    # rounding of 300 K over the few of a pulse
    assert_closed(found, 1e-10, "energy")
    if form == "step":  # what enters and leaves again is counted both ways
        entered = 2000.0 * 800.0 * np.pi / 6.0 * 0.01**3 * risen
        assert found.balances["energy"]["in"] == approx(entered, rel=1e-3)


def followed(times, values, moments):
    """Temperatures of a sphere as hot inside as outside, dT/dt = RATE
    (T_furnace - T), at moments, to 1e-8 K.
    """
    solved = solve_ivp(
        lambda t, T: RATE * (np.interp(t, times, values) - T), (0.0, moments[-1]), [300.0], "DOP853",
        t_eval=moments, rtol=1e-11, atol=1e-9, max_step=times[1] - times[0],
    )  # fmt: skip
    return solved.y[0]


def steps_of(monkeypatch):
    """Count the steps of a run from here on."""
    taken = []

    march = single_particle.ParticleSteps.march

    def counted(*arguments):
        for history in march(*arguments):
            taken.append(history)
            yield history

    monkeypatch.setattr(single_particle.ParticleSteps, "march", counted)
    return taken


def dense(form, times):
    """Temperatures of a furnace that rise by 400 K in all, with kinks smaller than
    the error of a step.
    """
    if form == "rises":
        return 300.0 + 400.0 * (1.0 - np.exp(-times / 900.0))
    if form == "jitters":
        return 300.0 + 400.0 * times / 3600.0 + 0.008 * (-1.0) ** np.arange(len(times))
    wave = np.where(
        (times > 2400.0) & (times < 2600.0),
        np.sin(np.pi * (times - 2400.0) / 200.0) ** 2,
        0.0,
    )
    # between the stages of a step from 1800 to 2700 s
    return np.where(times < 3600.0, 300.0 + 2.0 * wave, 700.0)


@pytest.mark.parametrize("form", ["rises", "hump", "jitters"])
def test_small_kinks_are_passed_within_the_error_of_a_step(tmp_path, monkeypatch, form):
    """A furnace measured every 5 s; a hump of small kinks after a long rest is not
    stepped over.
    """
    times = np.linspace(0.0, 3600.0, 721)
    values, moments = dense(form, times), np.linspace(100.0, 3600.0, 36)
    series = f"{{ times = {times.tolist()}, values = {values.tolist()} }}"
    (tmp_path / "dense.toml").write_text(
        TANK.format(series=series, times=moments.tolist())
    )
    taken = steps_of(monkeypatch)
    found = run(load(tmp_path / "dense.toml"))
    assert len(taken) < 300  # of 720 pieces
    span = max(values) - 300.0
    # local errors of 1e-4 of the span over some time constants, as much for what lies
    # between the stages; the sphere lags a little; 1e-5 to 4e-5 are found
    assert found.profiles["T_mean [K]"] == approx(
        followed(times, values, moments), abs=2e-4 * span
    )
    assert_closed(found, 1e-10, "energy")


def test_numbers_of_the_run_do_not_depend_on_output_times(tmp_path):
    text = inert(6, 100.0, 1.0).replace("ambient = 400.0", "ambient = 300.0")
    path = tmp_path / "reacts.toml"
    path.write_text(
        text + '[reactions.gas]\nof = "stone"\nA = 0.02\nE = 0.0\nyields = {}\n'
    )
    # of a loss of 1 - exp(-2) half is gone at -ln((1 + exp(-2))/2)/0.02
    assert run(load(path)).qoi["half_time_s"] == approx(
        -50.0 * np.log(0.5 * (1.0 + np.exp(-2.0))), rel=1e-4
    )
    series = '{ times = [0, 1000, 1030], values = [300, 1000, 300], form = "step" }'
    path.write_text(TANK.format(series=series, times=[3600.0]))
    found = run(load(path)).qoi
    assert found["T_centre_max_K"] == approx(
        300.0 + 700.0 * (1.0 - np.exp(-30.0 * RATE)), abs=0.7
    )
    assert found["time_of_T_centre_max_s"] == approx(1030.0, abs=0.5)
    assert "half_time_s" not in found  # nothing is lost


@pytest.mark.slow
def test_a_reaction_too_fast_for_any_step_is_told():
    """A step of 1e-6 of the run still takes all of the wood at once."""
    fast = {
        "reactions.tar.E": 3328.34 * 8.31446261815324,
        "reactions.intermediate.A": 1.65e9,
    }
    with pytest.raises(
        ConvergenceError, match=r"template\.toml:\d+: .*at t = .* s: .*lower its A"
    ):
        run(load(MODELS["single_particle"].template, fast))


def test_template_runs():
    found = run(
        load(
            MODELS["single_particle"].template,
            {"time.end": 200.0, "single_particle.cells": 8},
        )
    )
    assert found.status == "ok"
    # measured: 0.71 after 200 s
    assert found.qoi["mass_fraction_end"] == approx(0.71, abs=0.04)


@each_case(__file__, "mistakes")
def test_mistakes(tmp_path, old, new, message):
    path = tmp_path / "wrong.toml"
    path.write_text(
        MODELS["single_particle"].template.read_text(encoding="utf-8").replace(old, new)
    )
    refused(message, load, path)


def test_what_the_scene_is_told_as():
    assert MODELS["single_particle"].means({"boundary": {"surface": {}}})


FIBRE = """
model = "single_particle"
[solids.fibre]
diameter = "60 um"
density = 1300
conductivity = 0.2
composition = "P:0.9, filler:0.1"
constituent = { P.heat_capacity = 1500, filler.heat_capacity = 900 }
[reactions.d]
of = "P"
A = 1e12
E = "170 kJ/mol"
[boundary.surface]
fixed_temperature = { times = [0, 4500], values = [373.15, 973.15] }
[initial]
temperature = 373.15
[time]
end = 4500
"""


def test_a_fine_particle_follows_its_surface():
    """A fibre in a thermobalance: half is lost where the integral of A exp(-E/(R T))
    is ln 2, within the error of the steps. Its conduction, 1e5 times the differences
    of temperature that it needs, leaves the balance of energy closed.
    """
    result = run(loads(FIBRE))

    def passed(t):
        return quad(lambda s: 1e12 * np.exp(-20446.25 / (373.15 + s / 7.5)), 0.0, t)[0]

    half = brentq(lambda t: passed(t) - np.log(2.0), 1000.0, 3000.0)
    assert result.qoi["half_time_s"] == approx(half, rel=1e-4)
    assert_closed(result, 1e-9, "energy")


IGNITING = """
model = "single_particle"
[single_particle]
cells = {cells}
[solids.ball]
diameter = 0.02
density = 400.0
conductivity = {conductivity}
composition = "coal:1"
constituent = {{ coal.heat_capacity = 1200.0, ash.heat_capacity = 1200.0 }}
[reactions.oxidation]
of = "coal"
A = 1.333e8
E = "100 kJ/mol"
heat = -1.5e6
yields = {{ ash = 1.0 }}
[boundary.surface]
ambient = 400.0
coefficient = 1e-3
[initial]
temperature = 400.0
[time]
end = {end}
"""


def test_ignition_where_nothing_around_is_hotter(monkeypatch):
    """A ball of one temperature in a gas as hot, which insulates it: dT/dt = Q A
    exp(-E/(R T)) (1 - (T - T_0)/Q), Q = 1250 K. Errors of steps refer to what the
    reaction heats, not to the difference of 0 K to the gas.
    """

    def inverse(T):
        return np.exp(100e3 / 8.31446 / T) / 1.333e8 / (1250.0 - (T - 400.0))

    half = quad(inverse, 400.0, 400.0 + 0.999999 * 625.0)[0]
    taken = steps_of(monkeypatch)
    result = run(loads(IGNITING.format(cells=4, conductivity=50.0, end=2.0 * half)))
    T = result.profiles["T_mean [K]"]
    ignited = result.profiles["t [s]"][int(np.argmax(T > 1025.0))]
    assert ignited == approx(half, rel=0.03)  # between output times of 2 %
    assert T.max() == approx(1650.0, rel=2e-3)  # local errors of 1e-4
    assert len(taken) < 500  # 1100 with errors of 1e-4 K
    assert not result.warnings
    assert_closed(result, 1e-9, "energy")


def test_a_front_thinner_than_a_shell_is_a_warning():
    result = run(loads(IGNITING.format(cells=4, conductivity=0.01, end=1200.0)))
    assert any("thinner than a shell" in warning for warning in result.warnings)
