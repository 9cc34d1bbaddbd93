"""Folds and multiple steady states of the adiabatic bed against a fold system solved
by collocation.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import ignition, table

import contbed
from contbed.loading import from_dict, loads
from contbed.scene.uncertain import uncertain_numbers
from tests.scene_text import set_keys

ROWS = table("ignition_adiabatic_bed")
BEDS = sorted({(row["Pe_m"], row["Pe_h"], row["B"], row["g"]) for row in ROWS})


def rows_of(bed, kind):
    keys = ("Pe_m", "Pe_h", "B", "g")
    return [
        row
        for row in ROWS
        if tuple(row[key] for key in keys) == bed and row["kind"] == kind
    ]


CELLS = 16  # by which folds are exact to 2e-9


@pytest.mark.parametrize(
    ("bed", "cells"),
    [
        ((5.0, 5.0, 10.0, 20.0), CELLS),
        pytest.param((20.0, 8.0, 8.0, 20.0), None, marks=pytest.mark.slow),
    ],
    ids=str,
)
def test_folds_and_states(bed, cells):
    assert bed in BEDS
    ((on,), (off,), states) = (
        rows_of(bed, kind) for kind in ("ignition", "extinction", "state")
    )
    scene = ignition(*bed, Da=0.5 * off["Da"])
    scene["continuation"] = {
        "parameter": "reactions.r.factor",
        "to": 2.0 * on["Da"],
        "at": states[0]["Da"],
    }
    if cells is not None:
        scene["mesh"]["cells"] = cells
    result = contbed.run(from_dict(scene))
    # the table's extinction agrees to 2e-7 between its two grids, its ignition to 1e-12
    assert result.qoi["fold_1"] == approx(on["Da"], rel=1e-7)
    assert result.qoi["fold_2"] == approx(off["Da"], rel=1e-6)
    assert result.qoi["steady_states_found"] == len(states)
    left = sorted(result.tables["states"]["x_A_out [1]"], reverse=True)
    assert [1.0 - x for x in left] == approx([row["X_out"] for row in states], abs=1e-7)


def test_a_bed_without_fold_has_one_state():
    scene = ignition(20.0, 20.0, 8.0, 20.0, 0.05)
    scene["mesh"]["cells"] = CELLS
    set_keys(
        scene,
        """
        continuation = { parameter = "reactions.r.factor", to = 0.3, at = 0.1, points = 30 }
        """,
    )
    result = contbed.run(from_dict(scene))
    assert not [key for key in result.qoi if key.startswith("fold")]
    assert result.qoi["steady_states_found"] == 1


def in_a_section(scene, rings, **wall):
    """The bed with a wall, across which heat passes easily."""
    set_keys(scene, "mesh.diameter = 0.1")
    if wall:
        scene["boundary"]["wall"] = wall
    if rings:
        scene["packed_bed"]["section"] = {
            "rings": rings,
            "conductivity_solids": 1e3,
            "dispersion_mass": 1e-2,
        }
    return scene


def test_folds_of_rings_alike_are_those_of_the_bed():
    """Without heat through the wall the branch of the section is that of the table."""
    bed = (5.0, 5.0, 10.0, 20.0)
    (on,), (off,), _ = (
        rows_of(bed, kind) for kind in ("ignition", "extinction", "state")
    )
    scene = in_a_section(ignition(*bed, Da=0.5 * off["Da"]), 2)
    scene["continuation"] = {"parameter": "reactions.r.factor", "to": 2.0 * on["Da"]}
    scene["mesh"]["cells"] = CELLS
    result = contbed.run(from_dict(scene))
    assert result.qoi["fold_1"] == approx(on["Da"], rel=1e-7)
    assert result.qoi["fold_2"] == approx(off["Da"], rel=1e-6)


@pytest.mark.slow
def test_fold_of_a_cooled_section_comes_to_that_of_one_dimension():
    """Wide conduction across: R/(4 K_r) beside 1/h_w = 0.2 is 1e-5 of 0.2 m2 K/W,
    and so is the change of the fold.
    """
    folds = []
    for rings in (0, 2):
        scene = in_a_section(
            ignition(5.0, 5.0, 10.0, 20.0, Da=0.02),
            rings,
            coefficient=5.0,
            ambient=600.0,
        )
        set_keys(
            scene,
            """
            continuation = { parameter = "reactions.r.factor", to = 2.0 }
            """,
        )
        scene["mesh"]["cells"] = CELLS
        folds.append(contbed.run(from_dict(scene)).qoi["fold_1"])
    adiabatic = rows_of((5.0, 5.0, 10.0, 20.0), "ignition")[0]["Da"]
    assert folds[0] > 1.2 * adiabatic
    assert folds[1] == approx(folds[0], rel=1e-4)


def test_a_branch_that_does_not_reach_the_value_of_its_states_says_so():
    scene = ignition(5.0, 5.0, 10.0, 20.0, Da=0.01)
    scene["mesh"]["cells"] = CELLS
    scene["continuation"] = {
        "parameter": "reactions.r.factor",
        "to": 0.02,
        "at": 0.5,
    }
    result = contbed.run(from_dict(scene))
    assert result.qoi["steady_states_found"] == 0
    assert "states" not in result.tables
    (text,) = [each for each in result.warnings if "continuation.at" in each]
    assert text.endswith("reactions.r.factor goes from 0.01 to 0.02")


def test_a_branch_over_a_constant_with_a_unit():
    """A first-order decay in plug flow, k = 360 1/h up to 1 1/s: at the end
    exp(-k L/u) of the gas is left, to the tolerance of the cells.
    """
    scene = loads("""
model = "packed_bed"
mesh = { type = "line", length = 1.0 }
reactions.decay = { equation = "A -> B", rate = "k*c_A", basis = "bed", parameters = { k = "360 1/h" } }
solids.catalyst.diameter = 0.003
packed_bed = { porosity = 0.4, pressure_drop = "none" }
boundary.left.gas = { velocity = 0.5, temperature = 500 }
continuation = { parameter = "reactions.decay.parameters.k", to = 1.0 }

[gas]
model = "ideal_gas"
composition = "A:0.1, N2:0.9"
species = { A.elements.C = 1, B.elements.C = 1, N2 = {} }
viscosity = 3e-5
""")
    found = contbed.run(scene)
    branch = found.tables["continuation"]
    k = branch["reactions.decay.parameters.k [1/s]"]
    assert k[[0, -1]] == approx([0.1, 1.0])
    left = branch["x_A_out [1]"] / 0.1
    assert left == approx(np.exp(-k / 0.5), rel=1e-3)
    values = list(
        uncertain_numbers({"reactions.decay.parameters.k": "5 %"}, scene, scene.origin)
    )
    assert values == [("reactions.decay.parameters.k", approx(0.1), approx(0.005))]
