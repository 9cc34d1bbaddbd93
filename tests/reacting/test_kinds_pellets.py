"""Pellets that are resolved inside among several kinds of particles: alike they are
one; unlike they add up.
"""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from pytest import approx
from several_solids import SHARES, split_pellets
from solving import solved
from test_pellets import D_A, REFORMER, R, left, pellets

from contbed.loading import from_dict
from contbed.plan_text import percent
from contbed.reacting_bed.plan import plan
from tests.cases import each_case
from tests.particle.tables import sphere
from tests.refusals import refused
from tests.scene_text import changed, set_keys

# of two solutions of the same equations, whose Newton's methods end at 1e-10
ROUNDING = 1e-9
SHELLS = 1e-5  # of what leaves: points inside err by 3e-6 of the effectiveness


def reforming():
    """Three reactions of five gases, two temperatures, a film and a falling
    pressure.
    """
    scene = deepcopy(REFORMER)
    set_keys(
        scene,
        """
        mesh.cells = 4
        gas.conductivity = 0.1
        packed_bed.pressure_drop = "ergun"
        heat = {}
        closures.nusselt = "nusselt_wakao_kaguei"
        closures.conductivity_solids = 0.5
        closures.sherwood = "sherwood_wakao_funazkri"
        """,
    )
    return scene


def test_kinds_that_are_alike_are_one():
    one, two = solved(reforming()), solved(split_pellets(reforming()))
    for name, column in one.profiles.items():
        for found in (
            [name]
            if name in two.profiles
            else [name.replace(" ", f"_{kind} ") for kind in SHARES]
        ):
            np.testing.assert_allclose(
                two.profiles[found], column, rtol=ROUNDING, atol=1e-12, err_msg=found
            )
    for name in ("reforming", "shift", "total"):
        extent = one.qoi[f"extent_{name}_mol_m2s"]
        assert two.qoi[f"extent_{name}_mol_m2s"] == approx(extent, rel=ROUNDING)
        assert two.qoi[f"extent_{name}_coarse_mol_m2s"] == approx(
            SHARES["coarse"] * extent, rel=ROUNDING
        )
    assert 0.05 < one.qoi["conversion_CH4"] < 0.5


def test_beads_dilute_a_catalyst():
    phi, share = 5.0, 0.3
    scene, k = pellets(phi)
    scene["mesh"]["length"] = L = 1.0 / (share * 0.6 * k * sphere(phi) / 0.5)
    scene = split_pellets(
        scene,
        {"catalyst": share, "beads": 1.0 - share},
        beads={"inside": {"diffusivity": {}}},
    )
    result = solved(scene)
    assert result.qoi["x_A_out"] == approx(left(k * L, share * sphere(phi)), rel=SHELLS)
    told = dict(result.plan.built)["intrapellet diffusion"]
    assert told.startswith(
        "diffusion and reaction of A, B in catalyst; effectiveness at the inlet: r 0.48"
    )


def test_each_kind_has_its_size_and_diffusivities():
    """Two catalysts in parallel, each with film and closed effectiveness:
    1/eta_o = 1/eta + phi^2/(3 Bi).
    """
    scene, k = pellets(2.0)
    d, factor, Bi = (
        {"coarse": 6e-3, "fine": 2e-3},
        {"coarse": 3.0, "fine": 0.5},
        {"coarse": 8.0, "fine": 4.0},
    )
    gas = 2e-5
    scene["gas"]["diffusivity"], scene["closures"]["sherwood"] = gas, 1.0
    total, changes = 0.0, {}
    for kind, share in SHARES.items():
        radius, inside = 0.5 * d[kind], factor[kind] * D_A
        phi = radius * np.sqrt(k / inside)
        total += share / (1.0 / sphere(phi) + phi**2 / (3.0 * Bi[kind]))
        changes[kind] = {
            "diameter": d[kind],
            "inside": {"mass": "interior", "diffusivity": {"A": inside, "B": inside}},
            "sherwood": 2.0 * Bi[kind] * inside / gas,
        }
    scene["mesh"]["length"] = L = 1.0 / (0.6 * k * total / 0.5)
    assert solved(split_pellets(scene, **changes)).qoi["x_A_out"] == approx(
        left(k * L, total), rel=SHELLS
    )


@pytest.mark.parametrize(("phi", "level"), [(0.1, "none"), (0.6, "interior")])
def test_auto_judges_all_kinds(phi, level):
    """Of two catalysts of which one is twice as large E is the mean of 1 - eta by
    volume.
    """
    scene, k = pellets(phi)
    scene["mesh"]["length"] = 0.5 / (0.6 * k)
    set_keys(scene, 'solids.particles.inside.mass = "auto"')
    scene = split_pellets(scene, coarse={"diameter": 4.0 * R})
    planned = plan(from_dict(scene))
    assert {table.inside.mass for table in planned.scene.solids.values()} == {level}
    error = 1.0 - SHARES["coarse"] * sphere(2.0 * phi) - SHARES["fine"] * sphere(phi)
    told = dict(planned.built if level == "interior" else planned.skipped)[
        "intrapellet diffusion"
    ]
    assert f"changes the reacted amounts by {percent(error)}" in told
    found = solved(scene).qoi["x_A_out"]
    for table in scene["solids"].values():
        table["inside"] = (
            {"mass": level} if level == "none" else table["inside"] | {"mass": level}
        )
    assert found == solved(scene).qoi["x_A_out"]


@each_case(__file__, "mistakes")
def test_mistakes(said, changes, without):
    scene = changed(split_pellets(pellets(1.0)[0]), changes, without)
    refused(said, from_dict, scene)
