"""Automatic meshes of planes and round beds with walls that conduct or exchange
heat: estimated and true errors.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from pytest import approx
from wall_scenes import _finer, heats, reference, scene, solved, true_errors

import contbed as cb
from contbed.fem.elements import Space
from contbed.fem.tensor_error import TensorGrid, balanced
from contbed.loading import from_dict
from contbed.mesh.build import build
from contbed.mesh.grading import graded
from contbed.packed_bed import direction_errors
from contbed.packed_bed.corners import unlike_temperatures
from contbed.packed_bed.plan import plan
from tests.scene_text import scene_of

# True errors over solver.tolerance where no warning is given. Measured at 1e-4 on all
# fifty beds: theta at most 0.96; heat at most 0.05, and 10 to 840 in the eight beds
# with a corner of unlike prescribed temperatures, where it has no limit. The one warned
# bed, seed 9, has a single given temperature: theta has no span.
FACTOR = 1.0
WALLS = {
    "left": {"gas": {"velocity": 0.05, "temperature": 300.0}},
    "bottom": {"solids": {"particles": {"fixed_temperature": 500.0}}},
}


def plane(**tables):
    """A bed between a hot plate and an adiabatic one."""
    found = scene_of(
        """
        [mesh]
        type = "rectangle"
        length = 0.2
        height = 0.1

        [gas]
        density = 1.0
        heat_capacity = 1000.0
        conductivity = 0.1
        viscosity = 2e-5

        [solids.particles]
        density = 2000.0
        heat_capacity = 900.0
        conductivity = 5.0
        diameter = 0.01

        [packed_bed]
        porosity = 0.4

        [closures]
        nusselt = 1.0

        [heat]

        [output]
        plots = false
        fields = false
    """,
        {"boundary": WALLS},
    )
    return from_dict(found | tables)


@pytest.mark.parametrize("shape", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_estimate_of_interpolation(shape, degree):
    """A layer at a wall, interpolated on a graded mesh: the estimate is above the
    largest error between the nodes, and at most 1.6 times that. The derivative may grow
    within the first cell, which the estimate does not know.
    """
    bed = plane(
        mesh={"type": "rectangle", "length": 0.2, "height": 0.1, "shape": shape}
    )
    layers = [(0.1, 2e-3)]
    mesh = build(
        bed.mesh, [np.linspace(0.0, 0.2, 6), graded(0.1, layers, scale=0.2)]
    ).skfem
    space = Space(mesh, degree)
    grid = TensorGrid.of(space)
    assert grid is not None

    def layer(y):
        return np.exp((y - 0.1) / 2e-3)

    values = grid.values(layer(space.points[1]))
    assert grid.nodal(values) == approx(layer(space.points[1]))
    y = np.linspace(0.0, 0.1, 20001)
    between = grid.interpolated(values, [np.array([0.07]), y])[0]
    found = grid.errors(values, np.ones_like(values))
    assert found[0].max() < 1e-12
    true = np.abs(between - layer(y)).max()
    assert true <= found[1].max() <= 1.6 * true


def test_balanced_vertices_have_equal_errors():
    """A factor on each interval becomes its size; ends stay, and sizes about double
    at most from cell to cell.
    """
    ends = np.linspace(0.0, 1.0, 11)
    same = balanced(ends, np.ones(10), np.ones(2))
    assert same == approx(ends)
    finer = balanced(
        ends, np.where(np.arange(10) < 3, 0.25, 1.0), np.array([1e-3, 1.0])
    )
    size = np.diff(finer)
    assert finer[[0, -1]] == approx([0.0, 1.0])
    assert 0.5e-4 < size[0] < 2e-4
    assert (size[1:] / size[:-1]).max() < 2.2
    assert size[finer[:-1] < 0.25].max() < 0.027
    assert size.max() < 0.12


def test_an_automatic_plane_meets_its_tolerance():
    """A round bed of one conducting wall at a tolerance of 1e-4: the first mesh has
    twenty times this error.
    """
    bed = scene(21, tolerance=1e-4)
    first = plan(bed)
    _, problem, state = solved(first)
    result = cb.run(bed)
    assert result.adaptations >= 1
    assert result.qoi["estimated_error"] <= 1e-4
    assert not [text for text in result.warnings if "wrong by" in text]
    made = result.plan
    _, better, answer = solved(made)
    _, *exact = solved(reference(made, 1))
    worst, heat = true_errors(made, better, answer, tuple(exact))
    assert worst <= 1e-4
    assert heat <= 1e-4
    assert true_errors(first, problem, state, tuple(exact))[0] > 5e-4
    assert result.qoi["heat_right_W"] == approx(heats(*exact)["right"], rel=1e-4)


def test_rounds_are_limited_by_the_scene():
    """`adapt = 0` keeps the first mesh, and the warning says what is missing."""
    result = cb.run(plane(solver={"adapt": 0}))
    assert result.adaptations == 0
    assert result.qoi["estimated_error"] > 1e-4
    text = next(text for text in result.warnings if "wrong by" in text)
    assert "solver.tolerance asks for 1e-05" in text
    assert "graded cells needed are about" in text


def test_given_cells_have_an_estimate_and_a_remedy():
    """Ten cells across a layer are told; a fine graded mesh is not."""
    mesh = {"type": "rectangle", "length": 0.2, "height": 0.1}
    coarse = cb.run(plane(mesh=mesh | {"cells": [10, 10]}))
    assert coarse.qoi["estimated_error"] > 1e-3
    assert any("leave out mesh.cells" in text for text in coarse.warnings)
    fine = cb.run(plane(mesh=mesh))
    assert fine.qoi["estimated_error"] <= 1e-5


def test_a_jump_of_prescribed_temperatures_has_a_weight():
    """Where unlike temperatures meet, errors count by the distance; elsewhere in
    full.
    """
    walls = scene_of("""
        bottom = { solids = { particles = { fixed_temperature = 500.0 } } }

        [left]
        gas = { velocity = 0.05, temperature = 300.0 }
        solids = { particles = { fixed_temperature = 300.0 } }
    """)
    made = plan(plane(boundary=walls))
    corners = direction_errors._corners(
        made, partial(unlike_temperatures, made.solved.boundary, "solid")
    )
    assert corners == [((0, 0.0), (1, 0.0))]
    grid = TensorGrid.of(Space(made.mesh.skfem, 1))
    weight = direction_errors._weight(grid, corners)
    assert weight[0, 0] == 0.0
    assert weight[-1, -1] == weight[-1, 0] == weight[0, -1] == 1.0


def test_a_corner_of_unlike_temperatures_is_told():
    """By line, boundaries and values; equal temperatures, opposite sides and a phase
    that does not conduct are not.

    Heat through such a corner grows by the same amount each time that its cells are a
    hundred times smaller.
    """
    solid = {"fixed_temperature": 500.0}
    unlike = scene_of(
        """
            [left]
            gas = { velocity = 0.05, temperature = 300.0 }
            solids = { particles = { fixed_temperature = 300.0 } }
        """,
        {"bottom.solids.particles": solid},
    )
    text = "\n".join(plane(boundary=unlike).warnings)
    assert (
        "boundary.bottom.solids.particles.fixed_temperature = 500.0: 500 K meets 300 K of boundary.left in a "
        "corner" in text
    )
    assert "heat_left_W and heat_bottom_W" in text
    both = scene_of(
        'left = { type = "wall", temperature = 300.0 }',
        {"bottom": {"type": "wall", "temperature": 500.0}},
    )
    found = [text for text in plane(boundary=both).warnings if "in a corner" in text]
    assert len(found) == 1 and "no value of T_fluid and T_solid" in found[0]
    same = unlike | {
        "left": {
            "gas": {"velocity": 0.05, "temperature": 300.0},
            "solids": {"particles": solid},
        }
    }
    across = scene_of(
        """
            left = { gas = { velocity = 0.05, temperature = 300.0 } }
            top = { solids = { particles = { fixed_temperature = 300.0 } } }
        """,
        {"bottom.solids.particles": solid},
    )
    insulated = {"nusselt": 1.0, "conductivity_solids": 0.0}
    for bed in (
        plane(boundary=same),
        plane(boundary=across),
        plane(boundary=unlike, closures=insulated),
    ):
        assert not bed.warnings
    made = plan(plane(boundary=unlike))
    found = []
    for smallest in (1e-2, 1e-4, 1e-6):
        lines = [
            extent * np.append(0.0, np.geomspace(smallest, 1.0, 40))
            for extent in (0.2, 0.1)
        ]
        _, problem, state = solved(made.on(lines))
        found.append(heats(problem, state)["bottom"])
    growth = np.diff(found)
    # (1 - eps) k (T_2 - T_1) / (pi/2) ln(r_1/r_2)
    exact = 0.6 * 5.0 * 200.0 / (0.5 * np.pi) * np.log(100.0)
    assert growth == approx([exact, exact], rel=0.05)


def test_the_reference_keeps_the_cells_of_a_corner():
    """Cells of 1e-8 of the bed stay, and finer ones are added at the sides; each
    vertex once.
    """
    ends = np.concatenate(([0.0], 1e-8 * 4.0 ** np.arange(13), [0.5, 1.0]))
    found = _finer(ends, 1)
    assert np.isin(ends, found).all()
    assert found[1] <= 0.25e-8
    assert 1.0 - found[-2] <= 1e-5
    assert np.diff(found).min() > 1e-9


def test_fluxes_alone_have_a_span():
    """Errors of a bed with one given temperature and fluxes count from the span of
    its solution.
    """
    result = cb.run(scene(9, tolerance=1e-4))
    assert not any("wrong by" in text for text in result.warnings)
    assert result.plan.mesh.skfem.nelements < 20_000


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(50))
def test_random_walls(seed):
    """Theta and heat are below the tolerance times `FACTOR`, or a warning is given."""
    bed = scene(seed, tolerance=1e-4)
    result = cb.run(bed)
    made = result.plan
    if made.mesh.skfem.dim() == 1 or any(
        "wrong by" in text for text in result.warnings
    ):
        return
    _, problem, state = solved(made)
    _, *exact = solved(reference(made, 2 if made.mesh.skfem.nelements < 4000 else 1))
    theta, heat = true_errors(made, problem, state, tuple(exact))
    assert theta <= FACTOR * 1e-4
    if not any("in a corner" in text for text in bed.warnings):
        assert heat <= FACTOR * 1e-4
