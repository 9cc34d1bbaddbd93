"""Fronts that move through beds at rest, against their closed forms: speeds, and
temperatures between and behind them.

Of a catalytic bed the rate is that above a temperature of ignition and none below, here
over a width: what that changes a trajectory of the equations in the frame of the front
tells, theta' = s theta - 1 + c, c' = -K H(theta) c.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import isothermal, let_move, solids, species, table
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import contbed
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.scene_text import set_keys

GAS_SOLID = table("front_gas_solid")
T0 = 300.0  # [K], of gas and bed


def hot_between(row, cells, sharp):
    """Result of a bed of 1 m whose solid takes the gas within 1/`sharp` of it, after
    0.8 m, and fronts of the form.
    """
    F, b, N = row["F"], row["b"], row["N"]
    mass = row["G"] / F
    gases = species(A=mass, B=mass)
    for gas in gases.values():
        gas |= {"heat_capacity": row["cp"] * mass, "enthalpy": 0.0}
    scene = isothermal("A:1", gases)
    scene["mesh"]["cells"] = cells
    scene["boundary"]["left"]["gas"] = {"molar_flux": F, "temperature": T0}
    set_keys(scene, 'packed_bed.pressure_drop = "none"')
    scene["solids"]["particles"] |= solids() | {"density": N * 0.1 / 0.6}
    for name, data in scene["solids"]["particles"]["constituent"].items():
        data |= {
            "heat_capacity": row["C"] / N,
            "enthalpy": 0.0 if name == "S" else row["dH"] / b,
        }
    scene["heat"] = {}
    end = 0.8 / row["w_reaction"]
    scene["time"] = {"end": end, "tolerance": 1e-3}
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    scene["reactions"] = {
        "r": {
            "equation": f"A + {b:g} S -> B + {b:g} P",
            "basis": "bed",
            "rate": "k*x_A*n_S/N",
            "parameters": {"k": sharp * F, "N": N},
        }
    }
    scene["output"] |= {"positions": np.linspace(0.0, 1.0, 2001).tolist()}
    return contbed.run(from_dict(scene)), row["w_heat"] * end, row["w_reaction"] * end


@pytest.mark.slow
@pytest.mark.parametrize(
    ("row", "cells", "sharp", "off"),
    [
        # the fronts of the last are near each other, and were nearer at first
        pytest.param(0, 30, 60.0, 2e-3, id="apart-coarse"),
        pytest.param(0, 60, 100.0, 1e-3, id="apart"),
        pytest.param(1, 60, 100.0, 0.2, id="near"),
    ],
)
def test_a_bed_is_hot_between_its_fronts(row, cells, sharp, off):
    """Means of the temperature between the fronts, in kelvin, and both speeds to a
    thousandth and a hundredth.
    """
    exact = GAS_SOLID[row]
    result, cold, reacted = hot_between(exact, cells, sharp)
    x, T = result.profiles["x [m]"], result.profiles["T_fluid [K]"]
    place = (x - cold) / (reacted - cold)
    between = (place > 0.4) & (place < 0.7)
    assert np.mean(T[between]) - T0 == approx(exact["dT"], rel=0.0, abs=off)
    assert np.interp(0.5, result.profiles["w_S [1]"], x) == approx(reacted, rel=1e-3)
    assert x[np.argmax(0.5 * exact["dT"] < T - T0)] == approx(cold, rel=1e-2)
    assert_closed(result, 1e-12, "energy")


CATALYTIC = table("front_catalytic")
RISE = 200.0  # [K], adiabatic
WIDTH = 0.04  # of it, over which the rate of the catalytic bed begins


def ignited(row, cells, length, travel, solids_speed=0.0):
    """Speed of a front between two moments and the highest temperature behind or ahead
    of it.

    Parameters
    ----------
    length : of the bed, over that of conduction lam/(G c_p)
    travel : of a front from the inlet with the speed of the closed form until both
        moments, over the same
    solids_speed : of the bed, over G c_p/C; a front that moves upstream stays in it
        then
    """
    cp, lam, eps = 30.0, 0.5, 0.4
    density, heat = 1000.0, 800.0
    unit, speed = lam / cp, cp / ((1.0 - eps) * density * heat)  # of 1 mol/m2/s
    gases = species(A=0.028, B=0.028)
    gases["A"] |= {"heat_capacity": cp, "enthalpy": cp * RISE}
    gases["B"] |= {"heat_capacity": cp, "enthalpy": 0.0}
    scene = isothermal("A:1", gases)
    scene["mesh"] = {"type": "line", "length": length * unit, "cells": cells}
    scene["boundary"]["left"]["gas"] = {"molar_flux": 1.0, "temperature": T0}
    set_keys(scene, 'packed_bed.pressure_drop = "none"')
    if solids_speed:
        let_move(scene, solids_speed * speed * (1.0 - eps), temperature=T0)
    scene["solids"]["particles"] |= {"density": density, "heat_capacity": heat}
    scene["heat"] = {}
    scene["closures"] |= {"conductivity_solids": lam}
    scene["reactions"] = {
        "r": {
            "equation": "A -> B",
            "basis": "bed",
            "rate": "k*x_A*0.5*(1 + tanh((T - T_i)/w))",
            "parameters": {
                "k": row["K"] / unit,
                "T_i": T0 + row["theta_i"] * RISE,
                "w": WIDTH * RISE,
            },
        }
    }
    times = [xi * unit / (speed * (solids_speed + row["omega"])) for xi in travel]
    x = np.linspace(0.0, length * unit, 6001)
    hot = T0 + RISE * row["theta_behind"]
    scene["time"] = {"end": times[1], "times": times, "tolerance": 1e-3}
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    scene["initial"]["temperature"] = hot
    scene["output"] |= {"positions": x.tolist()}
    result = contbed.run(from_dict(scene))
    theta = (result.profiles["T_fluid [K]"].reshape(2, -1) - T0) / RISE
    ahead = [int(np.argmax(one > row["theta_i"])) for one in theta]
    at = [
        np.interp(row["theta_i"], one[: k + 1][-2:], x[: k + 1][-2:])
        for one, k in zip(theta, ahead, strict=True)
    ]
    return (at[1] - at[0]) / (times[1] - times[0]) / speed - solids_speed, theta[
        1
    ].max()


def of_trajectory(row):
    """Speed omega = 1 - s of a front whose rate begins over WIDTH: theta ends at 1/s
    where nothing is left.
    """
    theta_i, K = row["theta_i"], row["K"]

    def slopes(_, y, s):
        return [
            s * y[0] - 1.0 + y[1],
            -0.5 * K * (1.0 + np.tanh((y[0] - theta_i) / WIDTH)) * y[1],
        ]

    def missed(s):
        ends = [
            lambda x, y, s: y[1] - 1e-9,
            lambda x, y, s: y[0] - 3.0 / s,
            lambda x, y, s: y[0] - theta_i + 0.5,
        ]
        for end in ends:
            end.terminal = True
        start = [theta_i - 12.0 * WIDTH, 1.0]
        path = solve_ivp(
            slopes,
            (0.0, 400.0),
            start,
            "LSODA",
            events=ends,
            args=(s,),
            rtol=1e-11,
            atol=1e-13,
        )
        theta, c = path.y[:, -1]
        return theta - 1.0 / s + c / (s + K)

    s = 1.0 - row["omega"]
    return 1.0 - brentq(missed, s - 0.01, s + 0.01, xtol=1e-12)


@pytest.mark.parametrize(
    "row", CATALYTIC, ids=lambda row: f"{row['theta_i']:g}-{row['K']:g}"
)
def test_what_the_width_of_ignition_changes(row):
    """At most 4e-3 of the speed of heat: less than cells do in the runs below; the
    closed form is that of no width.
    """
    assert of_trajectory(row) == approx(row["omega"], rel=0.0, abs=4e-3)
    s = 1.0 - row["omega"]
    assert row["theta_i"] * s**2 + row["K"] * row["theta_i"] * s - row["K"] == approx(
        0.0, abs=1e-10
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "cells", "length", "travel", "solids_speed", "off"),
    [
        (0, 64, 8.0, (3.5, 4.5), 1.0, 2e-3),
        (1, 64, 8.0, (3.5, 4.5), 0.0, 2e-3),
        (2, 96, 6.0, (3.6, 4.2), 0.0, 6e-3),
        (3, 60, 30.0, (14.0, 18.0), 0.0, 2e-3),
    ],
    ids=["upstream", "downstream", "thin", "fast"],
)
def test_speeds_of_catalytic_fronts(number, cells, length, travel, solids_speed, off):
    """To 2e-3 of the speed of heat, which cells of a quarter to two thirds of the
    reaction's length and settling leave.

    The thin front reacts within less than a cell.
    """
    row = CATALYTIC[number]
    omega, highest = ignited(row, cells, length, travel, solids_speed)
    assert omega == approx(of_trajectory(row), rel=0.0, abs=off)
    if number < 2:  # heat of the start has left the bed
        assert highest == approx(1.0 / (1.0 - omega), abs=5e-3)


@pytest.mark.slow
def test_speeds_follow_the_cells():
    """Half of the length of cells leaves less than half of the error."""
    row = CATALYTIC[1]
    errors = [
        abs(ignited(row, cells, 8.0, (3.5, 4.5))[0] - of_trajectory(row))
        for cells in (32, 64)
    ]
    assert errors[1] < 0.5 * errors[0]
