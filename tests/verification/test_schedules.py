"""Values that change with time, and states that begin with a profile, against closed
forms and symmetries.
"""

import copy
from pathlib import Path

import cantera as ct
import numpy as np
import pytest
from moving_beds import started
from numpy.testing import assert_allclose
from pytest import approx
from scipy.integrate import solve_ivp

import contbed as cb
from contbed.course.schedule import Schedule
from contbed.errors import SceneError
from contbed.explain.sheets import explain
from contbed.loading import from_dict
from contbed.packed_bed.time_steps import HeatSteps
from contbed.scene.series import Samples
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refusal, refused
from tests.restarts import interrupt, same_run
from tests.scene_text import scene_of, set_keys

SLAB = scene_of(
    """
[mesh]
type = "line"
length = 0.1
cells = 20
[gas]
density = 1.2
heat_capacity = 1000.0
conductivity = 0.5
viscosity = 2e-5
[solids.particles]
density = 2000.0
heat_capacity = 900.0
conductivity = 2.0
diameter = 0.005
[packed_bed]
porosity = 0.4
[closures]
nusselt = 0.0
[heat]
[boundary]
[initial]
gas.temperature = 300.0
solids.particles.temperature = 300.0
[time]
end = 1000.0
[output]
positions = [0.0, 0.02, 0.05, 0.07, 0.1]
"""
)

STORE = scene_of(
    """
[mesh]
type = "line"
length = 1.0
cells = 60
[gas]
density = 800.0
heat_capacity = 2000.0
conductivity = 0.1
viscosity = 1e-3
[solids.particles]
density = 2500.0
heat_capacity = 900.0
conductivity = 2.0
diameter = 0.01
[packed_bed]
porosity = 0.4
[closures]
nusselt = 10.0
[heat]
[boundary.left]
gas.velocity.times = [0.0, 600.0, 900.0]
gas.velocity.values = [1e-3, 0.0, -1e-3]
gas.temperature = 400.0
[boundary.right]
gas.temperature = 300.0
[initial]
gas.temperature = 300.0
solids.particles.temperature = 300.0
[time]
end = 1500.0
times = [600.0, 900.0]
"""
)


def changed(scene: dict, **tables: dict) -> dict:
    """A copy of the scene with these tables in place of its own."""
    return copy.deepcopy(scene) | tables


def ramp(low: float, slope: float, end: float) -> dict:
    """A temperature that rises with `slope` [K/s] until `end` [s]."""
    return {"times": [0.0, end], "values": [low, low + slope * end]}


def run(scene: dict, base: Path | str = ".") -> cb.Result:
    return cb.run(from_dict(scene, base=base), quiet=True)


def last(result: cb.Result, name: str) -> np.ndarray:
    """Profile at the last time."""
    t = result.profiles["t [s]"]
    return result.profiles[name][t == t.max()]


def test_ramp_of_prescribed_walls_is_exact(tmp_path):
    """T = T0 + b t + b x (x - L)/(2 a) solves the heat equation, is quadratic in x and
    linear in t.

    Elements of degree 2 and the time steps hold it exactly, so that only rounding
    remains: 1e-9 K of 300.
    """
    slope, length = 0.01, 0.1
    x = np.linspace(0.0, length, 41)  # the nodes of 20 quadratic cells
    diffusivity = {
        "fluid": 0.4 * 0.5 / (0.4 * 1.2 * 1000.0),
        "solid": 0.6 * 2.0 / (0.6 * 2000.0 * 900.0),
    }

    def exact(phase, x, t):
        return 300.0 + slope * t + slope * x * (x - length) / (2.0 * diffusivity[phase])

    rows = np.column_stack([x, exact("fluid", x, 0.0), exact("solid", x, 0.0)])
    text = "x [m],T_fluid [K],T_solid [K]\n" + "\n".join(
        ",".join(f"{v:.17g}" for v in row) for row in rows
    )
    (tmp_path / "start.csv").write_text(text)
    rise = {"fixed_temperature": ramp(300.0, slope, 1000.0)}
    wall = {"gas": rise, "solids": {"particles": rise}}
    scene = changed(SLAB, boundary={"left": wall, "right": wall})
    scene["initial"] = started({"file": "start.csv"}, {"file": "start.csv"})
    result = run(scene, tmp_path)
    for phase in ("fluid", "solid"):
        found = last(result, f"T_{phase} [K]")
        assert_allclose(
            found, exact(phase, last(result, "x [m]"), 1000.0), rtol=0, atol=1e-9
        )
    assert_closed(result, 1e-12, "energy")


@pytest.mark.parametrize("kind", ["ambient", "flux"])
def test_thin_bed_follows_what_its_wall_gives(kind):
    """A bed that conducts well is one tank: C dT/dt = h (T_a(t) - T), or C
    dT/dt = q(t), both solved in closed form.

    The local error of the steps is 1e-7 of the span; the bed is not quite one tank: h
    L/(3 k) = 3e-5 of some 60 K.
    """
    h, length, end = 10.0, 0.01, 2000.0
    scene = changed(
        SLAB,
        mesh={"type": "line", "length": length, "cells": 4},
        output={"positions": [0.5 * length]},
    )
    set_keys(scene, "solids.particles.conductivity = 1e3")
    content = 0.6 * 2000.0 * 900.0 * length
    if kind == "ambient":
        scene["boundary"] = {
            "left": {
                "solids": {
                    "particles": {"coefficient": h, "ambient": ramp(300.0, 0.05, end)}
                }
            }
        }
        rate = h / content
        expected = 300.0 + 0.05 * (end - (1.0 - np.exp(-rate * end)) / rate)
    else:
        times, values = [0.0, 500.0, 1000.0], [0.0, 400.0, 100.0]
        scene["boundary"] = {
            "left": {
                "solids": {
                    "particles": {
                        "heat_flux": {"times": times, "values": values, "form": "step"}
                    }
                }
            }
        }
        expected = 300.0 + (500.0 * 400.0 + 1000.0 * 100.0) / content
    scene["time"] |= {"end": end, "tolerance": 1e-7}
    assert last(run(scene), "T_solid [K]")[0] == approx(expected, rel=0, abs=5e-3)


def test_series_with_equal_values_change_nothing():
    """Series that hold the same number at all times give what the number gives, to
    the tolerance of the steps.
    """
    scene = changed(
        STORE, boundary={"left": {"gas": {"velocity": 1e-3, "temperature": 400.0}}}
    )
    constant = run(scene)
    velocity = {"times": [0.0, 700.0], "values": [1e-3, 1e-3]}
    temperature = {"times": [0.0, 500.0, 1500.0], "values": [400.0] * 3}
    scene["boundary"]["left"] = {
        "gas": {"velocity": velocity, "temperature": temperature}
    }
    series = run(scene)
    assert_allclose(
        last(series, "T_fluid [K]"),
        last(constant, "T_fluid [K]"),
        rtol=0,
        atol=3e-4 * 100.0,
    )
    assert series.balances["energy"]["in"] == approx(
        constant.balances["energy"]["in"], rel=1e-5
    )


def test_reversal_is_symmetric():
    """The bed mirrored, with mirrored velocities and inlets, has mirrored
    temperatures, to rounding.
    """
    result = run(STORE)
    other = run(
        changed(
            STORE,
            boundary={
                "left": STORE["boundary"]["right"],
                "right": STORE["boundary"]["left"],
            },
        )
    )
    for name in ("T_fluid [K]", "T_solid [K]"):
        a, b = (r.profiles[name].reshape(3, -1) for r in (result, other))
        assert_allclose(a, b[:, ::-1], rtol=0, atol=1e-8)


def test_charge_rest_and_discharge_against_method_of_lines():
    """An independent solution by upwind finite volumes on 4000 cells and LSODA; the
    heat balance closes to 1e-10.

    Finite volumes of order 1 leave an error of some u dx/2 in conductivity, 0.2 % of
    that in the scene: 0.3 K.
    """
    result = run(STORE)
    balance = result.balances["energy"]
    assert abs(balance["relative_residual"]) < 1e-10
    n, length, eps = 4000, 1.0, 0.4
    dx = length / n
    capacity = {"fluid": eps * 800.0 * 2000.0, "solid": (1 - eps) * 2500.0 * 900.0}
    k = {"fluid": eps * 0.1, "solid": (1 - eps) * 2.0}
    exchange = 10.0 * 0.1 / 0.01 * 6.0 * (1 - eps) / 0.01

    def rates(u, inlet):
        def of(t, y):
            T_f, T_s = y[::2], y[1::2]
            upwind = (
                np.concatenate(([inlet], T_f[:-1]))
                if u > 0
                else np.concatenate((T_f[1:], [inlet]))
            )
            carried = abs(u) * 800.0 * 2000.0 * (upwind - T_f) / dx if u else 0.0
            out = np.empty_like(y)
            for T, key, into in ((T_f, "fluid", carried), (T_s, "solid", 0.0)):
                flux = np.zeros(n + 1)
                flux[1:-1] = k[key] * np.diff(T) / dx
                gain = exchange * ((T_s - T_f) if key == "fluid" else (T_f - T_s))
                out[(0 if key == "fluid" else 1) :: 2] = (
                    np.diff(flux) / dx + into + gain
                ) / capacity[key]
            return out

        return of

    y = np.full(2 * n, 300.0)
    for begin, end, u, inlet in (
        (0, 600, 1e-3, 400.0),
        (600, 900, 0.0, 0.0),
        (900, 1500, -1e-3, 300.0),
    ):
        y = solve_ivp(
            rates(u, inlet),
            (begin, end),
            y,
            "LSODA",
            rtol=1e-6,
            atol=1e-4,
            lband=2,
            uband=2,
        ).y[:, -1]
        found = result.profiles["T_fluid [K]"][
            np.isclose(result.profiles["t [s]"], end)
        ]
        x = result.profiles["x [m]"][np.isclose(result.profiles["t [s]"], end)]
        expected = np.interp(x, (np.arange(n) + 0.5) * dx, y[::2])
        assert_allclose(found[1:-1], expected[1:-1], rtol=0, atol=0.3)


def test_jump_of_a_prescribed_wall_is_in_the_balance():
    """The heat that prescribed nodes take when they jump is supplied by their wall:
    the balance closes to 1e-12.
    """
    step = {
        "times": [0.0, 300.0, 600.0],
        "values": [350.0, 320.0, 360.0],
        "form": "step",
    }
    scene = changed(
        SLAB,
        boundary={
            "left": {
                "solids": {"particles": {"fixed_temperature": step}},
                "gas": {"fixed_temperature": 300.0},
            }
        },
    )
    balance = run(scene).balances["energy"]
    assert abs(balance["relative_residual"]) < 1e-12
    assert balance["stored"] > 0.0


@pytest.mark.parametrize("cells", [2, 6])
def test_walls_that_differ_from_the_start_give_the_heat_of_the_first_cells(cells):
    scene = copy.deepcopy(SLAB)
    set_keys(scene, f"mesh.cells = {cells}\nclosures.conductivity_solids = 1.2")
    length, rise, capacity, conductivity = 0.1, 20.0, 0.6 * 2000.0 * 900.0, 1.2
    scene["boundary"] = {
        "left": {"solids": {"particles": {"fixed_temperature": 300.0 + rise}}},
        "right": {"solids": {"particles": {"fixed_temperature": 300.0 - rise}}},
    }
    half = 0.5 * length
    end = 2.0 * capacity * half**2 / conductivity
    scene["time"] = {"end": end}
    result = cb.run(from_dict(scene))
    # a half with its middle at 300 K, when its profile is straight: what passes and a
    # third of what its own rise would store
    heat = rise * half * (conductivity * end / half**2 + capacity / 3.0)
    energy = result.balances["energy"]
    assert energy["in"] == approx(heat, rel=1e-4)
    assert energy["out"] == approx(heat, rel=1e-4)
    assert_closed(result, 1e-11)


def test_cycles_repeat():
    """A period of the series is cut at the same places in each turn, and values jump
    where the next turn begins.
    """
    samples = Samples(np.array([0.0, 4.0]), np.array([1.0, 2.0]), "step", 10.0)
    assert list(samples.breaks(25.0)) == [4.0, 10.0, 14.0, 20.0, 24.0]
    assert samples.at(10.0) == 1.0 and samples.at(10.0, before=True) == 2.0
    assert samples.at(23.999) == 1.0 and samples.at(24.0) == 2.0
    linear = Samples(np.array([0.0, 4.0]), np.array([1.0, 3.0]), "linear", 8.0)
    assert linear.at(2.0) == 2.0 and linear.at(6.0) == 2.0 and linear.at(14.0) == 2.0


@pytest.mark.parametrize("period", [None, 20.0])
def test_what_a_step_does_not_see_of_a_series(period):
    """Kinks against the line between neighbours, and values against the polynomial
    through the stages: by hand.
    """
    times = np.linspace(0.0, 10.0, 11)
    curved = Samples(times, np.column_stack([times**2, 2.0 * times]), "linear", period)
    assert curved.kink(4.0) == approx([1.0, 0.0]) and np.all(curved.kink(0.0) == np.inf)
    # a parabola is seen by three stages at kinks, by two within (t - a)(b - t)
    assert curved.unseen(1.0, 9.0, (0.0, 0.25, 1.0)) == approx([0.0, 0.0], abs=1e-12)
    assert curved.unseen(1.0, 9.0, (0.0, 1.0)) == approx([16.0, 0.0])
    # no kink between
    assert curved.unseen(1.0, 2.0, (0.0, 1.0)) == approx([0.0, 0.0])
    if period is not None:
        assert curved.kink(24.0) == approx([1.0, 0.0])
        assert curved.unseen(21.0, 29.0, (0.0, 1.0)) == approx([16.0, 0.0])
    spike = Schedule(
        {
            ("a",): curved,
            ("b",): Samples(np.array([0.0, 3.0]), np.array([1.0, 2.0]), "step", period),
        }
    )
    small = {("a",): np.array([1.5, 1.5]), ("b",): 1e9}
    assert spike.cuts(6.0, small) == [0.0, 3.0, 6.0]  # jumps stay, whatever their size
    assert not spike.sees(3.0, 6.0, (0.0, 1.0), small) and spike.sees(
        3.0, 5.0, (0.0, 1.0), small
    )


def test_initial_profile_of_an_earlier_run(tmp_path):
    """Two runs after each other, the second from the profiles of the first, are the one
    long run.

    profiles.csv has the temperatures at 1001 positions; interpolation between them is
    below 1e-3 K here.
    """
    first = changed(
        STORE, boundary={"left": {"gas": {"velocity": 1e-3, "temperature": 400.0}}}
    )
    first["time"] |= {"end": 600.0, "times": []}
    cb.run(from_dict(first), tmp_path / "first", quiet=True)
    start = {"file": "first/profiles.csv"}
    second = changed(first)
    second["initial"] = started(start, start)
    long = changed(first)
    long["time"] |= {"end": 1200.0}
    a, b = run(second, tmp_path), run(long)
    assert_allclose(last(a, "T_solid [K]"), last(b, "T_solid [K]"), rtol=0, atol=2e-2)


@each_case(__file__, "bad_series")
def test_bad_series(tmp_path, table, value, words):
    """Mistakes name the key, or the file with line and column, before anything runs."""
    (tmp_path / "text.csv").write_text("t [s],T [K]\n0,300\n1,warm\n")
    (tmp_path / "unit.csv").write_text("t [s],T [m]\n0,300\n1,310\n")
    (tmp_path / "short.csv").write_text("t [s],T [K]\n0,300\n1\n")
    (tmp_path / "sheet.csv").write_text("t [s];T [K]\n0;300,5\n1;310,5\n")
    (tmp_path / "tabs.csv").write_text("# measured\nt [s]\tT [K]\n0\t300\n")
    (tmp_path / "long.csv").write_text("t [s],T [K]\n0," + 200_000 * "3" + "\n")
    (tmp_path / "good.csv").write_text("t [h],T [degC]\n0,20\n1,30\n")
    scene = changed(
        STORE, boundary={"left": {"gas": {"velocity": 1e-3, "temperature": 400.0}}}
    )
    scene["boundary"]["left"]["gas"][table] = value
    with pytest.raises(SceneError, match="scene") as caught:
        from_dict(scene, base=tmp_path)
    assert words in str(caught.value), str(caught.value)


def test_bad_profiles(tmp_path):
    """A profile that does not lie in the bed, or whose file lacks a position, is
    told before anything runs.
    """
    (tmp_path / "long.csv").write_text("z [m],T [K]\n0,300\n1.5,310\n")
    (tmp_path / "twice.csv").write_text("z [m],T [K]\n0.5,300\n0.5,310\n")
    (tmp_path / "none.csv").write_text("T [K]\n300\n")
    for name, words in (
        ("long.csv", "positions from 0 to 1.5 m, the bed is 1 m long"),
        ("twice.csv", "twice.csv:3: the position 0.5 m is given twice"),
        ("none.csv", "no column with a length"),
    ):
        scene = changed(STORE)
        scene["initial"]["solids"]["particles"]["temperature"] = {"file": name}
        assert words in refusal(from_dict, scene, base=tmp_path)


def test_a_profile_of_a_shorter_bed_is_told(tmp_path):
    """Beyond the ends of its file a bed begins with the nearest temperature: told
    above 5 % of the length.
    """
    for rows, told in (
        ("0,300\n0.5,310\n", True),
        ("0.3,300\n1,310\n", True),
        ("0.04,300\n0.96,310\n", False),
    ):
        (tmp_path / "start.csv").write_text("z [m],T [K]\n" + rows)
        scene = changed(STORE)
        set_keys(
            scene,
            """
            initial.solids.particles.temperature = { file = "start.csv" }
            """,
        )
        warned = run(scene, tmp_path).warnings
        assert (
            any(
                "initial.solids.particles.temperature: positions from" in text
                for text in warned
            )
            == told
        ), warned


def test_a_steady_scene_has_no_series():
    """A series without a [time] table is a mistake, told at its key."""
    scene = changed(STORE)
    del scene["time"]
    refused(
        r"boundary\.left\.gas\.velocity.*changes with time, and the scene is steady",
        from_dict,
        scene,
    )


def test_restart_across_a_jump_is_bit_for_bit(tmp_path):
    """Stopped before the kink at 600 s, and before the jump of the flow at 900 s."""
    scene = from_dict(STORE)
    interrupt(scene, tmp_path, HeatSteps, "passed", 223)
    interrupt(scene, tmp_path, HeatSteps, "passed", 34, restart=tmp_path)
    same_run(cb.run(scene, tmp_path, restart=tmp_path), cb.run(scene))


def test_a_key_that_takes_a_number_or_a_series_explains_both():
    """The data sheet of such a key has the unit of the number and the keys of the
    series.
    """
    text = explain("boundary.NAME.gas.temperature")
    assert "allowed: a number > 0 K, or a table with times, values" in text
    assert "period: a number > 0 s" in text


def test_profiles_have_the_flow_of_their_time(tmp_path):
    """Velocity and pressure of a profile are those of its time, not of the last part of
    the run.

    Constant properties: the pressure falls by (mu/K + rho c_F/sqrt(K) |u|) u L, to 1e-9
    of it; where the flow stops both are zero. At a jump they are those before it, as at
    the end of a run. So it is after a restart.
    """
    result = cb.run(from_dict(STORE), tmp_path, quiet=True)
    again = cb.run(from_dict(STORE), tmp_path, quiet=True, restart=tmp_path)
    d, eps = STORE["solids"]["particles"]["diameter"], STORE["packed_bed"]["porosity"]
    K, c_F = d**2 * eps**3 / (150.0 * (1.0 - eps) ** 2), 1.75 / (150.0 * eps**3) ** 0.5
    drop = (1e-3 / K + 800.0 * c_F / K**0.5 * 1e-3) * 1e-3
    t = result.profiles["t [s]"]
    for time, velocity, first, end in (
        (600.0, 1e-3, drop, 0.0),
        (900.0, 0.0, 0.0, 0.0),
        (1500.0, -1e-3, 0.0, drop),
    ):
        for found in (result, again):
            assert_allclose(found.profiles["u [m/s]"][t == time], velocity, rtol=1e-12)
            p = found.profiles["p [Pa]"][t == time]
            assert_allclose(p[[0, -1]], [first, end], rtol=0, atol=1e-9 * drop)


@pytest.mark.parametrize("form", ["step", "linear"])
def test_mass_flux_of_a_gas_that_enters_hotter(form):
    """Nitrogen of 300 K, then of 600 K at the same velocity, through a bed that hardly
    takes heat: what enters is the integral of u rho(T) h(T) over time, by the enthalpies
    of Cantera; to 1 %, which is the error of the steps. So it is along a ramp.
    """
    scene = copy.deepcopy(SLAB)
    scene["gas"] = {"model": "cantera", "composition": "N2:1"}
    scene["closures"]["nusselt"] = 0.01
    scene["mesh"]["cells"] = 4
    series = {"times": [0.0, 10.0, 20.0], "values": [300.0, 600.0, 600.0]}
    if form == "linear":
        series = {"times": [0.0, 20.0], "values": [300.0, 600.0]}
    scene["boundary"]["left"] = {
        "gas": {"velocity": 0.5, "temperature": {**series, "form": form}}
    }
    scene["time"] = {"end": 20.0, "tolerance": 1e-3}
    result = cb.run(from_dict(scene))
    gas = ct.Solution("gri30.yaml")

    def at(T):
        gas.TPX = T, ct.one_atm, "N2:1"
        return gas.density, gas.enthalpy_mass

    (_, h), (rho_hot, h_hot) = at(300.0), at(600.0)
    entered = 0.5 * 10.0 * rho_hot * (h_hot - h)
    if form == "linear":
        states = [at(T) for T in np.linspace(300.0, 600.0, 1001)]
        fluxes = [0.5 * density * (enthalpy - h) for density, enthalpy in states]
        entered = 20.0 * float(np.mean(fluxes))
    assert result.profiles["u [m/s]"][-5] == approx(0.5, rel=1e-3)
    assert result.balances["energy"]["in"] == approx(entered, rel=0.01)
    assert_closed(result, 1e-12, "energy")
