"""Pellets that are resolved inside of a bed that is resolved across the flow:
limits, closed forms, order, restart.
"""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pytest import approx
from reacting_bed_scenes import R_GAS, P, isothermal, species
from solving import solved
from test_pellets import D_A, REFORMER, R, left, pellets

from contbed.loading import from_dict
from contbed.many.derivatives.gradients import gradient_of
from contbed.plan_text import percent
from contbed.reacting_bed.plan import plan
from tests.particle.tables import sphere
from tests.scene_text import set_keys

SHELLS = 1e-5  # of what leaves: points inside err by 3e-6 of the effectiveness
RADIUS, CP, T_IN, T_WALL, E = 0.05, 30.0, 500.0, 420.0, 6e4


def alike(scene, **section):
    """The bed behind a wall that nothing passes, in place: one ring is as another."""
    scene["mesh"]["diameter"] = 2 * RADIUS
    set_keys(scene, "boundary.wall = { heat_flux = 0.0 }")
    if section:
        scene["packed_bed"]["section"] = section


def same(one, section, rel=1e-9):
    """All that a bed in one dimension reports, to Newton's tolerance."""
    for name, column in one.profiles.items():
        assert_allclose(
            section.profiles[name], column, rtol=rel, atol=1e-12, err_msg=name
        )
    for name in one.qoi.keys() - {"time_steps", "share_negative"}:
        assert section.qoi[name] == approx(one.qoi[name], rel=rel, abs=1e-12), name


def reforming(rings):
    """Three reactions of five gases with their heat, a falling pressure, species
    that pass between the rings.
    """
    scene = deepcopy(REFORMER)
    set_keys(scene, "mesh.cells = 4")
    set_keys(scene, 'packed_bed.pressure_drop = "ergun"')
    if rings:
        alike(scene, rings=rings, conductivity_solids=2.0, dispersion_mass=1e-4)
    return scene


def test_rings_alike_are_the_bed_in_one_dimension():
    one, section = (solved(reforming(rings)) for rings in (0, 3))
    same(one, section)
    assert 0.05 < one.qoi["conversion_CH4"] < 0.5


@pytest.mark.parametrize("shape", ["tube", "duct"])
@pytest.mark.parametrize("biot", [None, 5.0])
def test_first_order(shape, biot):
    """1/eta_o = 1/eta + phi^2/(3 Bi) with the film, eta of the closed form."""
    phi = 5.0
    scene, k = pellets(phi)
    eta = sphere(phi)
    if biot is not None:
        eta = 1.0 / (1.0 / eta + phi**2 / (3.0 * biot))
        set_keys(scene, "gas.diffusivity = 2e-5")
        scene["closures"] |= {"sherwood": 2.0 * biot * D_A / 2e-5}
    scene["mesh"] |= {"length": 1.0 / (0.6 * k * eta / 0.5), "cells": 6}
    for gas in scene["gas"]["species"].values():
        gas |= {"heat_capacity": CP, "enthalpy": 0.0}
    scene["heat"] = {}
    alike(scene, rings=2, shape=shape, conductivity_solids=1.0)
    assert solved(scene).qoi["x_A_out"] == approx(
        left(k * scene["mesh"]["length"], eta), rel=SHELLS
    )


def cooled(rings, mass="interior", factor=1.0):
    """First order that gives off heat to a wall, phi of 11 at the axis and 2 at the
    wall.
    """
    gases = species(A=0.028, B=0.028)
    gases["A"] |= {"heat_capacity": CP, "enthalpy": 6e3}
    gases["B"] |= {"heat_capacity": CP, "enthalpy": 0.0}
    scene = isothermal("A:1", gases)
    set_keys(
        scene,
        """
        mesh.length = 0.3
        mesh.cells = 6
        solids.particles.density = 1000.0
        solids.particles.heat_capacity = 800.0
        heat = {}
        """,
    )
    scene["reactions"] = {
        "r": {
            "equation": "A -> B",
            "A": 5e6,
            "E": E,
            "basis": "particle",
            "factor": factor,
        }
    }
    scene["mesh"]["diameter"] = 2 * RADIUS
    scene["boundary"]["wall"] = {"coefficient": 100.0, "ambient": T_WALL}
    scene["packed_bed"]["section"] = {
        "rings": rings,
        "conductivity_solids": 1.0,
        "dispersion_mass": 1e-4,
    }
    set_keys(scene, "output.positions = [0.1, 0.3]")
    scene["solids"]["particles"]["inside"] = {"mass": mass}
    if mass == "effectiveness":
        scene["reactions"]["r"]["diffusivity"] = D_A
    elif mass != "none":
        scene["solids"]["particles"]["inside"]["diffusivity"] = {"A": D_A, "B": D_A}
    return scene


def test_a_cooled_tube_is_that_with_the_closed_effectiveness():
    """Each ring has the modulus of its own temperature."""
    exact, found = (
        solved(cooled(4, mass)).profiles for mass in ("effectiveness", "interior")
    )
    for name, column in exact.items():
        assert_allclose(found[name], column, rtol=SHELLS, err_msg=name)
    assert np.all(found["T_fluid_axis [K]"] - found["T_fluid_wall [K]"] > 50.0)


def test_order_across():
    coarse, fine, finest = (
        np.array(
            [
                solved(cooled(rings)).qoi[key]
                for key in ("x_A_out", "T_fluid_out_K", "heat_wall_W")
            ]
        )
        for rings in (4, 8, 16)
    )
    orders = np.log2((coarse - fine) / (fine - finest))
    assert orders == approx(2.0, abs=0.2)


@pytest.mark.parametrize(("factor", "level"), [(1e-4, "none"), (1.0, "interior")])
def test_auto_weighs_the_rings_by_their_area(factor, level):
    """E = 1 - eta over the rates of the bed in which nothing resists inside, each
    ring with its own temperature.
    """
    planned = plan(from_dict(cooled(3, "auto", factor)))
    assert planned.scene.solids["particles"].inside.mass == level
    problem, u = solved(cooled(3, "none", factor)).solved
    g_A, g_B, T = u.reshape(3, 3, *u.shape[1:]).swapaxes(0, 1)
    k = factor * 5e6 * np.exp(-E / (R_GAS * T))
    rate = k * g_A / (g_A + g_B) * P / (R_GAS * T)
    line = problem.line
    whole, part = (
        np.einsum("r,rcj,j,c->", problem.rings.shares, f, line.weights, line.h)
        for f in (rate, rate * (1.0 - sphere(R * np.sqrt(k / D_A))))
    )
    told = dict(planned.built if level == "interior" else planned.skipped)[
        "intrapellet diffusion"
    ]
    assert f"changes the reacted amounts by {percent(part / whole)}" in told
    assert solved(cooled(3, "auto", factor)).qoi == solved(cooled(3, level, factor)).qoi


def in_time(scene, end):
    return scene | {"time": {"end": end, "tolerance": 1e-3}}


@pytest.mark.parametrize(
    "gas", ["quasi_steady", pytest.param("stored", marks=pytest.mark.slow)]
)
def test_rings_alike_in_time(gas):
    """A jump of the inlet temperature: the same steps, and at each the bed in one
    dimension.
    """
    runs = []
    for rings in (0, 2):
        scene = in_time(cooled(2), 30.0)
        scene["packed_bed"]["gas_storage"] = gas
        alike(scene)
        if not rings:
            del scene["packed_bed"]["section"]
        jump = {"times": [0, 10], "values": [T_IN - 30.0, T_IN], "form": "step"}
        scene["boundary"]["left"]["gas"]["temperature"] = jump
        runs.append(solved(scene))
    one, section = runs
    assert section.qoi["time_steps"] == one.qoi["time_steps"]
    same(one, section)
    assert 0.1 < one.qoi["x_A_out"] < 0.9


@pytest.mark.slow
def test_in_time_it_ends_in_the_steady_state():
    """B enters as well: of a scene that would fall below zero on its cells the
    steady state alone is damped.
    """
    scene = cooled(3)
    set_keys(scene, 'gas.composition = "A:0.9, B:0.1"')
    steady, late = solved(scene), solved(in_time(scene, 5e4))
    assert steady.qoi["cells_damped"] == 0
    for name, column in steady.profiles.items():
        assert_allclose(late.profiles[name], column, rtol=1e-8, err_msg=name)


def test_derivatives_are_those_of_differences():
    """Central differences err by the square of 1e-4 and by what is left of Newton's
    method over it.
    """
    key = "reactions.r.factor"
    found = gradient_of(solved(cooled(2)), ["x_A_out"], [key]).derivatives[0, 0]
    low, high = (
        solved(cooled(2, factor=1.0 + side * 1e-4)).qoi["x_A_out"]
        for side in (-1.0, 1.0)
    )
    assert found == approx((high - low) / 2e-4, rel=1e-5)
