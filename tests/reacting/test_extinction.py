"""Gases that are used up within the bed at orders below 1: c^(1-n) falls by a straight
line to zero, and stays there.

u dc/dx = -eps k c^n,    c = (c0^(1-n) - (1-n) eps k x/u)^(1/(1-n)) before the point of extinction, 0 behind it
"""

from __future__ import annotations

import cantera as ct
import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import MOLAR, P, isothermal, species
from scipy.integrate import solve_ivp
from solving import CLOSED

import contbed
from contbed.chemistry.thermo import R_GAS
from contbed.closures.formula import parse_formula
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.scene_text import scene_of, set_keys

# [mol^(1-n)/m^(3-3n)/s], [-], [m/s]; for n = 1/2 it ends at 0.61 m
K, EPS, SPEED = 20.0, 0.4, 0.5
X = np.linspace(0.0, 1.0, 81)


def bed(cells=None, **law):
    """A -> B in 1 m of gas."""
    scene = isothermal("A:1", species(A=0.028, B=0.028))
    scene["reactions"] = {"r": {"equation": "A -> B", **law}}
    scene["output"]["positions"] = X.tolist()
    if cells is not None:
        scene["mesh"]["cells"] = cells
    return scene


def power(n, **more):
    return bed(A=K, E=0.0, orders={"A": n}, **more)


def solved(scene, n):
    """The run, and the largest error of x_A outside of the cell in which the gas
    ends.
    """
    found = contbed.run(from_dict(scene))
    assert found.status == "ok" and not found.warnings
    assert_closed(found, CLOSED, "H")
    left = MOLAR ** (1.0 - n) - (1.0 - n) * EPS * K * X / SPEED
    wanted = np.maximum(left, 0.0) ** (1.0 / (1.0 - n)) / MOLAR
    problem = found.solved[0]
    end = MOLAR ** (1.0 - n) * SPEED / ((1.0 - n) * EPS * K)
    vertices = problem.line.vertices
    cell = np.searchsorted(vertices, end) - 1
    outside = (vertices[cell] >= X) | (vertices[cell + 1] < X)
    assert outside.sum() > len(X) - 20 and (X[outside] > end).any()
    return found, float(np.abs(found.profiles["x_A [1]"] - wanted)[outside].max())


@pytest.mark.parametrize(
    "scene",
    [
        bed(rate=f"{K}*sqrt(c_A)"),
        bed(rate="k*(p_A/p0)**0.5", parameters={"k": K * MOLAR**0.5, "p0": P}),
        power(0.5),
        power(0.5, cells=20),
    ],
    ids=["formula", "pressure", "order", "given cells"],
)
def test_a_square_root_ends_at_a_point(scene):
    """A parabola, which the cells hold: what is left are powers below 1e-7 of the
    gas, and the cell where it ends.
    """
    found, error = solved(scene, 0.5)
    assert error < 1e-6  # solver.tolerance
    assert found.qoi["conversion_A"] == approx(1.0, abs=1e-10)
    assert found.solved[0].bed.small.amounts <= 1e-7
    assert "cells" not in scene["mesh"] or found.qoi["cells"] == scene["mesh"]["cells"]


@pytest.mark.parametrize("n", [0.3, 0.7])
def test_other_orders_end_at_a_point(n):
    """Behind that of 0.7, which needs no help, polynomials of the cells around it
    reach further.
    """
    found, error = solved(power(n), n)
    assert error < 3e-5  # of cells, as solver.tolerance^0.7 is what they are held to
    assert found.qoi["conversion_A"] == approx(1.0, abs=1e-10)


def test_order_zero_ends_where_nothing_is_left():
    """A falls by a straight line; outside of the cell where it ends, see `solved`."""
    rate = MOLAR * SPEED / (EPS * 0.7)
    found = contbed.run(from_dict(bed(A=rate, E=0.0, orders={"A": 0.0})))
    assert_closed(found, CLOSED, "H")
    away = np.abs(X - 0.7) > 0.1
    wanted = np.maximum(1.0 - X / 0.7, 0.0)[away]
    assert found.profiles["x_A [1]"][away] == approx(wanted, abs=3e-5)
    assert found.qoi["conversion_A"] == approx(1.0, abs=1e-10)


def test_what_is_made_counts_where_it_is_on_the_left():
    """Autocatalysis without orders, by the logistic curve: the error of the cells."""
    scene = bed(40, A=1.0, E=0.0)
    set_keys(scene, 'reactions.r.equation = "A + B -> 2 B"')
    set_keys(scene, 'gas.composition = "A:0.99, B:0.01"')
    found = contbed.run(from_dict(scene))
    grown = 0.01 / 0.99 * np.exp(EPS * MOLAR * X / SPEED)
    assert found.profiles["x_B [1]"] == approx(grown / (1.0 + grown), abs=1e-5)


def test_two_gases_that_end_at_once_or_one_of_them():
    scene = bed(rate="20*sqrt(c_A)*sqrt(c_C)")
    scene["gas"]["species"] |= species(C=0.028, D=0.028)
    set_keys(scene, 'reactions.r.equation = "A + C -> B + D"')
    set_keys(scene, 'gas.composition = "A:0.4, C:0.6"')
    found = contbed.run(from_dict(scene))
    assert found.qoi["conversion_A"] == approx(1.0, abs=1e-10)
    assert found.qoi["conversion_C"] == approx(2.0 / 3.0, abs=1e-10)


def test_smooth_powers_of_a_formula():
    """Straight below a share of what a power is taken of at the sizes; all else is
    as it is.
    """
    formula = parse_formula("2*a**0.5 + sqrt(3*b)/a**1.5 - c**k")
    assert formula.has_roots({}) and not parse_formula(
        "a**1.5 + b**k/a**(-0.5)"
    ).has_roots({"k": 2.0})
    assert parse_formula("b**k").has_roots({"k": 0.5}) and not parse_formula(
        "b**k"
    ).has_roots({})
    values = {
        "a": np.array([4.0, 1e-6]),
        "b": np.array([9.0, 1e-7]),
        "c": np.array([2.0, 2.0]),
        "k": 0.5,
    }
    small, sizes = 0.01, {"a": 2.0, "b": 5.0, "c": 1.0, "k": 0.5}

    def smooth(x, s):
        return x * (x * x + s * s) ** -0.25

    a, b = values["a"], values["b"]
    wanted = 2.0 * smooth(a, 0.02) + smooth(3.0 * b, 0.15) / a**1.5 - smooth(2.0, 0.01)
    # of 1e-14 in a**1.5
    assert formula(values, small, sizes) == approx(wanted, rel=1e-9)
    assert formula(values) == approx(
        2.0 * a**0.5 + (3.0 * b) ** 0.5 / a**1.5 - 2.0**0.5, rel=1e-9
    )


@pytest.mark.parametrize(
    ("scene", "k", "n"),
    [
        pytest.param(power(0.5, cells=12), K, 0.5, id="order"),
        pytest.param(
            bed(64, rate="k*c_A**n", parameters={"k": K, "n": 0.5}),
            K,
            0.5,
            id="formula",
        ),
        pytest.param(
            bed(16, A=10.0 * K, E=0.0, orders={"A": 0.3}),
            10.0 * K,
            0.3,
            id="within one cell",
        ),
        pytest.param(
            power(0.5) | {"solver": {"adapt": 8, "tolerance": 1e-4}},
            K,
            0.5,
            id="following",
        ),
    ],
)
def test_a_gas_that_ends_in_time_is_as_in_a_steady_bed(scene, k, n):
    """Away from the cells around its end to the share that is smoothed, 1e-5, or
    what following cells are held to.
    """
    packed_bed = scene["packed_bed"] | {"gas_storage": "quasi_steady"}
    found = contbed.run(
        from_dict(scene | {"time": {"end": 1.0}, "packed_bed": packed_bed})
    )
    left = MOLAR ** (1.0 - n) - (1.0 - n) * EPS * k * X / SPEED
    off = np.abs(
        found.profiles["x_A [1]"] - np.maximum(left, 0.0) ** (1.0 / (1.0 - n)) / MOLAR
    )
    far = np.abs(X - MOLAR ** (1.0 - n) * SPEED / ((1.0 - n) * EPS * k)) > 0.1
    assert far.sum() > 60 and off[far].max() < (
        1e-4**0.7 if "solver" in scene else 1e-5
    )
    assert_closed(found, CLOSED, "H")


@pytest.mark.parametrize("trace", [1e-3, 1e-6])
def test_powers_of_a_trace_in_time_stay(trace):
    """A tenth of it is left where the bed ends: what is smoothed is a share of the
    trace, 1e-5, of 0.1 of it.
    """
    k = (1.0 - 0.1**0.5) * 2.0 * (trace * MOLAR) ** 0.5 * SPEED / EPS
    scene = bed(cells=8, A=k, E=0.0, orders={"A": 0.5})
    scene["gas"]["composition"] = f"A:{trace}, B:{1.0 - trace}"
    set_keys(scene, "time = { end = 1.0 }")
    set_keys(scene, 'packed_bed.gas_storage = "quasi_steady"')
    assert contbed.run(from_dict(scene)).qoi["x_A_out"] == approx(0.1 * trace, rel=1e-6)


METHANATION = """
model = "packed_bed"
mesh = { type = "line", length = 1.5, diameter = 0.02 }
packed_bed = { porosity = 0.4, pressure_drop = "none" }
heat = {}

[gas]
model = "cantera"
composition = "CO2:0.18, H2:0.72, CH4:0.05, H2O:0.05"
pressure = 5e5

[solids.nickel]
diameter = 2e-3
density = 1800

[reactions.sabatier]
equation = "CO2 + 4 H2 <-> CH4 + 2 H2O"
rate = "k*exp(-E/R*(1/T - 1/555))*sqrt(p_CO2*p_H2)*(1 - Q_over_K)/(1 + p_H2O/P0)"
parameters = { k = "0.1 mol/kg/s/bar", E = "78 kJ/mol", P0 = "0.5 bar" }
basis = "catalyst"

[boundary.left]
gas = { velocity = 1, temperature = 543.15 }

[boundary.wall]
coefficient = 250
ambient = 543.15
"""


def test_roots_are_sharp_behind_a_hot_spot():
    """Two ordinary differential equations of plug flow at Cantera's enthalpies and
    equilibrium: conversion to 1e-4, the hot spot to 2 K, as its cells are few. Newton's
    method alone stopped at powers that were straight below a tenth: 0.929.
    """
    gas = ct.Solution("gri30.yaml")
    p = 5e5
    gas.TPX = 543.15, p, "CO2:0.18, H2:0.72, CH4:0.05, H2O:0.05"
    flux, mass, feed = gas.density_mole * 1e3, gas.density, gas.X
    step = np.zeros(gas.n_species)
    k_CO2, k_H2, k_CH4, k_H2O = (
        gas.species_index(name) for name in ("CO2", "H2", "CH4", "H2O")
    )
    step[[k_CO2, k_H2, k_CH4, k_H2O]] = -1, -4, 1, 2

    def slopes(z, y):
        extent, T = y
        moles = flux * feed + step * extent
        x = moles / moles.sum()
        gas.TPX = T, p, x
        heat = step @ gas.standard_enthalpies_RT
        entropy = step @ gas.standard_entropies_R + step.sum() * np.log(p / ct.one_atm)
        Q_over_K = np.prod((x * p / ct.one_atm) ** step) / np.exp(entropy - heat)
        rate = 0.1e-5 * np.exp(-78e3 / R_GAS * (1 / T - 1 / 555))
        rate *= p * np.sqrt(x[k_CO2] * x[k_H2]) / (1 + p * x[k_H2O] / 0.5e5)
        rate *= 1800 * 0.6 * (1 - Q_over_K)
        cooled = 4 * 250 / 0.02 * (T - 543.15)
        return rate, (-heat * R_GAS * T * rate - cooled) / (mass * gas.cp)

    exact = solve_ivp(slopes, (0, 1.5), (0, 543.15), "LSODA", rtol=1e-9, max_step=5e-3)
    found = contbed.run(from_dict(scene_of(METHANATION)))
    wanted = exact.y[0, -1] / (flux * feed[k_CO2])
    assert found.qoi["conversion_CO2"] == approx(wanted, abs=1e-4)
    assert found.qoi["hot_spot_K"] == approx(exact.y[1].max(), abs=2.0)
