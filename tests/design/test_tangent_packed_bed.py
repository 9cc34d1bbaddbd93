"""The tangent of steady packed beds: closed forms, Taylor remainders, full solutions
on the same mesh.
"""

from dataclasses import fields

import numpy as np
import pytest
from design_scenes import SLIP, frozen_results, random_scene
from pytest import approx

import contbed as cb
from contbed.loading import loads
from contbed.many.derivatives import differences
from contbed.many.derivatives.gradients import gradient, gradient_of, picked
from contbed.many.derivatives.keys import continuous, key
from studies._exact import fin
from studies._exact.finite_length import finite_length
from tests.scene_text import scene_of

# the rounding of temperatures over the step of differences; the truncation of either is
# smaller
RELATIVE = 1e-6


def worst(scene, count=None, seed=0):
    """Largest difference of tangent and differences on the same mesh, over the largest
    relative derivative.

    `count` keys are drawn by a seed; all by default.
    """
    result = cb.run(scene)
    qoi = [
        name
        for name in result.qoi
        if name.endswith(("_out_K", "duty_W", "pressure_drop_Pa"))
    ]
    chosen = [one for one in continuous(scene) if one.value]
    if count is not None:
        drawn = np.random.default_rng(seed).choice(len(chosen), count, replace=False)
        chosen = [chosen[k] for k in drawn]
    made = gradient(scene, qoi, [one.name for one in chosen])
    assert made.method == "tangent"
    solve = frozen_results(result, qoi)
    centre = picked(scene, result.qoi, qoi)
    found = np.array(
        [differences.slope(scene, one, solve, centre, 3e-4).values for one in chosen]
    ).T
    weights = np.abs(found * made.at).max(axis=1)
    # of a result that none of the keys changes
    weights = np.maximum(weights, 1e-9 * np.abs(centre))
    return (np.abs(made.derivatives - found) * np.abs(made.at) / weights[:, None]).max()


def slip_case(values):
    """Outlet temperatures of the slip case by its exact solution on a finite length."""
    bed, fluid, solid = values["bed"], values["fluid"], values["solid"]
    area = 6.0 * (1.0 - bed["porosity"]) / bed["particle_diameter"]
    f, s = finite_length(
        np.array([values["length"]]),
        values["length"],
        fluid["density"] * fluid["heat_capacity"] * values["velocity"],
        solid["density"] * solid["heat_capacity"] * values["velocity_solid"],
        bed["porosity"] * fluid["conductivity"],
        (1.0 - bed["porosity"]) * solid["conductivity"],
        values["nusselt"] * fluid["conductivity"] / bed["particle_diameter"] * area,
    )
    return 300.0 + 100.0 * np.array([f[0], s[0]])


def test_slip_case_by_its_exact_solution():
    scene = loads(SLIP)
    names = scene_of("""
        "mesh.length" = ["length"]
        "gas.heat_capacity" = ["fluid", "heat_capacity"]
        "gas.conductivity" = ["fluid", "conductivity"]
        "solids.particles.density" = ["solid", "density"]
        "solids.particles.conductivity" = ["solid", "conductivity"]
        "packed_bed.porosity" = ["bed", "porosity"]
        "solids.particles.diameter" = ["bed", "particle_diameter"]
        "boundary.left.gas.velocity" = ["velocity"]
        "boundary.left.solids.particles.velocity" = ["velocity_solid"]
        "closures.nusselt" = ["nusselt"]
    """)
    made = gradient(scene, ["T_fluid_out_K", "T_solid_out_K"], list(names))
    assert made.method == "tangent"
    values = {
        "bed": scene.packed_bed.model_dump()
        | scene.closures.model_dump()
        | {"particle_diameter": scene.diameter},
        "fluid": scene.gas.model_dump(),
        "solid": scene.solid.model_dump(),
        "length": 0.04,
        "velocity": 0.2,
        "velocity_solid": 1e-4,
        "nusselt": 12.0,
    }
    for k, path in enumerate(names.values()):
        table = values if len(path) == 1 else values[path[0]]
        base, step = table[path[-1]], 1e-4 * table[path[-1]]
        ends = []
        for side in (1, -1):
            table[path[-1]] = base + side * step
            ends.append(slip_case(values))
        table[path[-1]] = base
        exact = (ends[0] - ends[1]) / (2 * step)
        # sixty cells of third degree; the smallest derivatives stand beside
        # temperatures of 350 K
        assert made.derivatives[:, k] * base == approx(exact * base, rel=1e-5, abs=1e-5)


def test_fin_between_a_hot_end_and_a_cold_fluid():
    """A bed that conducts to a fluid of fixed temperature: Q = sqrt(k h a) (T_w - T)
    tanh(m L).
    """
    text = SLIP.replace(
        "gas.velocity = 0.2\nsolids.particles.velocity = 1e-4", "gas.velocity = 2e6"
    )
    text = text.replace("gas.fixed_temperature", "gas.temperature")
    names = [
        "solids.particles.conductivity",
        "closures.nusselt",
        "solids.particles.diameter",
        "mesh.length",
        "boundary.left.solids.particles.fixed_temperature",
    ]
    names.append("boundary.left.gas.temperature")
    scene = loads(text.replace("length = 0.04", "length = 0.02"))
    made = gradient(scene, ["heat_left_W"], names)

    def heat(conductivity, nusselt, diameter, length, wall, fluid):
        k, ha = 0.4 * conductivity, nusselt * 0.0345 / diameter * 6.0 * 0.4 / diameter
        m = np.sqrt(ha / k)
        slope = (fin(np.array([1e-7 * length]), length, k, ha)[0] - 1.0) / (
            1e-7 * length
        )
        assert slope == approx(-m * np.tanh(m * length), rel=1e-5)
        return k * m * np.tanh(m * length) * (wall - fluid)

    at = np.array([0.8625, 12.0, 0.01, 0.02, 400.0, 300.0])
    assert made.values[0] == approx(heat(*at), rel=1e-6)
    for j in range(len(at)):
        step = 1e-4 * at[j] * np.eye(len(at))[j]
        exact = (heat(*(at + step)) - heat(*(at - step))) / (2e-4 * at[j])
        # the fluid takes up 1e-9 of its own temperature
        assert made.derivatives[0, j] * at[j] == approx(
            exact * at[j], rel=2e-5, abs=1e-6 * heat(*at)
        )


def test_danckwerts_reaction_free_limit():
    """A stream that enters by Danckwerts and heats a bed that loses heat to a cold
    solid at its inlet temperature.

    With both phases moving alike and no difference of temperature at the inlet but that
    of the stream, the outlet of a bed without exchange is the temperature of the
    stream: its derivative is one to the inlet, nought to all others.
    """
    text = SLIP.replace("nusselt = 12.0", "nusselt = 0.0").replace(
        "gas.fixed_temperature", "gas.temperature"
    )
    made = gradient(
        loads(text),
        ["T_fluid_out_K"],
        ["boundary.left.gas.temperature", "boundary.left.gas.velocity", "mesh.length"],
    )
    assert made.derivatives[0] == approx([1.0, 0.0, 0.0], abs=1e-6)


def test_remainder_of_taylor_falls_with_the_square_of_the_step():
    scene = loads(SLIP)
    result = cb.run(scene)
    names = [
        "packed_bed.porosity",
        "boundary.left.gas.velocity",
        "mesh.length",
        "boundary.left.solids.particles.fixed_temperature",
    ]
    qoi = ["T_fluid_out_K", "duty_W"]
    made, solve = gradient(scene, qoi, names), frozen_results(result, qoi)
    for j, name in enumerate(names[:3]):
        one = key(scene, name)
        remainders = []
        for step in (0.02 * one.value, 0.01 * one.value):
            change = solve(one.on(scene, one.value + step)) - made.values
            remainders.append(np.abs(change - made.derivatives[:, j] * step))
        assert np.log2(remainders[0] / remainders[1]) == approx([2.0, 2.0], abs=0.05)
    one = key(scene, names[3])  # linear
    change = solve(one.on(scene, one.value + 8.0)) - made.values
    assert change == approx(8.0 * made.derivatives[:, 3], rel=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_random_beds_against_differences_of_solutions(seed):
    assert worst(random_scene(seed), 2, seed) < RELATIVE


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5, 105))
def test_many_random_beds_against_differences_of_solutions(seed):
    assert worst(random_scene(seed)) < RELATIVE


def test_a_stream_that_a_change_would_start_takes_differences_of_runs():
    text = SLIP.replace(
        "solids.particles.velocity = 1e-4", "solids.particles.velocity = 0.0"
    )
    made = gradient(
        loads(text),
        ["T_fluid_out_K"],
        ["packed_bed.porosity", "boundary.left.solids.particles.velocity"],
    )
    assert (
        "boundary.left.solids.particles.velocity = 0: a small change adds or removes a "
        "stream" in made.notes[0]
    )


def test_gradients_of_a_bed_do_not_change_its_results():
    scene = loads(SLIP)
    result = cb.run(scene)
    before = dict(result.qoi)
    gradient_of(result, ["T_fluid_out_K"], ["packed_bed.porosity", "mesh.length"])
    assert result.qoi == before
    assert {field.name for field in fields(result)} >= {"solved"}
