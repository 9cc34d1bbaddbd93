"""Gradients of transient packed beds: runs on both sides keep mesh and time steps;
closed forms; fronts.
"""

import numpy as np
import pytest
from design_scenes import SLIP

from contbed.loading import loads
from contbed.many.derivatives.gradients import gradient, picked
from contbed.many.derivatives.keys import key
from contbed.runner import run

REST = """
[initial]
gas.temperature = 300.0
solids.particles.temperature = 500.0

[time]
end = 200.0
"""


def test_heat_of_a_bed_that_only_exchanges():
    """A bed whose streams are fast and weak: the gas leaves with its own
    temperature, one to one with the inlet.
    """
    text = (
        SLIP.replace(
            "solids.particles.velocity = 1e-4", "solids.particles.velocity = 0.0"
        ).replace("\nsolids.particles.fixed_temperature = 400.0", "")
        + REST
    )
    text = text.replace("gas.fixed_temperature", "gas.temperature").replace(
        "conductivity = 0.8625", "conductivity = 0.5"
    )
    names = [
        "boundary.left.gas.temperature",
        "initial.solids.particles.temperature",
        "initial.gas.temperature",
    ]
    made = gradient(loads(text), ["T_fluid_out_K"], names)
    assert made.method == "differences"
    # linear and homogeneous in the three temperatures together
    assert made.derivatives[0].sum() == pytest.approx(1.0, abs=1e-7)
    assert made.derivatives[0] @ made.at == pytest.approx(made.values[0], rel=1e-7)


@pytest.mark.parametrize("varies", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_derivatives_are_free_of_the_noise_of_steps_and_meshes(varies):
    text = SLIP + REST
    if varies:
        text = text.replace(
            "conductivity = 0.8625", "conductivity = [0.5, 1e-3]"
        ).replace("degree = 3", "degree = 1")
        text = text.replace("cells = 60", "cells = 12").replace(
            "end = 200.0", "end = 50.0"
        )
    scene, names, qoi = (
        loads(text),
        ["packed_bed.porosity", "mesh.length"],
        ["T_fluid_out_K", "T_solid_out_K"],
    )
    made, found = gradient(scene, qoi, names), []
    for one in (key(scene, name) for name in names):
        ends = [
            picked(scene, run(one.on(scene, one.value * (1 + side * 0.01))).qoi, qoi)
            for side in (1, -1)
        ]
        found.append((ends[0] - ends[1]) / (0.02 * one.value))
    # runs that choose their own steps agree to the tolerance of these, 1e-4 of the span
    # over 2 % of the key
    change = np.abs(made.derivatives - np.array(found).T) * made.at
    assert change.max() < 0.02 * np.abs(made.derivatives * made.at).max()


def test_fronts_take_differences_of_runs():
    text = SLIP.replace(
        "solids.particles.velocity = 1e-4", "solids.particles.velocity = 0.0"
    ).replace("\nsolids.particles.fixed_temperature = 400.0", "")
    text = text + REST.replace("200", "20")
    text = text.replace(
        "nusselt = 12.0",
        "nusselt = 12.0\nconductivity_gas = 0.0\nconductivity_solids = 0.0",
    )
    made = gradient(
        loads(text),
        ["T_fluid_out_K"],
        [
            "initial.solids.particles.temperature",
            "boundary.left.gas.fixed_temperature",
            "initial.gas.temperature",
        ],
    )
    assert made.method == "differences"
    assert made.derivatives[0].sum() == pytest.approx(1.0, abs=1e-3)
