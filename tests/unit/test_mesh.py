"""Built-in meshes, refinement and grading."""

from dataclasses import replace

import numpy as np
import pytest
import skfem
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from contbed.mesh.build import build
from contbed.mesh.grading import equidistributed, graded
from contbed.mesh.mesh import refine
from contbed.scene.mesh import MeshAxisymmetric, MeshBox, MeshLine, MeshRectangle
from tests.refusals import refused

LENGTH, RADIUS, WIDTH, HEIGHT = 0.37, 0.11, 0.13, 0.29
LINE = MeshLine(type="line", length=LENGTH, cells=7)
PLANE = {"type": "rectangle", "length": LENGTH, "height": HEIGHT, "cells": (5, 3)}
ROUND = {"type": "axisymmetric", "length": LENGTH, "radius": RADIUS, "cells": (3, 5)}
BOX = {
    "type": "box",
    "length": LENGTH,
    "width": WIDTH,
    "height": HEIGHT,
    "cells": (2, 3, 4),
}
PLANE_SIZES = {"left": HEIGHT, "right": HEIGHT, "bottom": LENGTH, "top": LENGTH}
END = np.pi * RADIUS**2
ROUND_SIZES = {
    "axis": 0.0,
    "wall": 2 * np.pi * RADIUS * LENGTH,
    "bottom": END,
    "top": END,
}
BOX_SIZES = {
    "left": WIDTH * HEIGHT,
    "right": WIDTH * HEIGHT,
    "front": LENGTH * HEIGHT,
    "back": LENGTH * HEIGHT,
    "bottom": LENGTH * WIDTH,
    "top": LENGTH * WIDTH,
}
CASES = {
    "line": (LINE, LENGTH, {"left": 1.0, "right": 1.0}),
    "quadrilateral": (MeshRectangle(**PLANE), LENGTH * HEIGHT, PLANE_SIZES),
    "triangle": (
        MeshRectangle(**PLANE, shape="triangle"),
        LENGTH * HEIGHT,
        PLANE_SIZES,
    ),
    "round": (MeshAxisymmetric(**ROUND), END * LENGTH, ROUND_SIZES),
    "round_triangle": (
        MeshAxisymmetric(**ROUND, shape="triangle"),
        END * LENGTH,
        ROUND_SIZES,
    ),
    "hexahedron": (MeshBox(**BOX), LENGTH * WIDTH * HEIGHT, BOX_SIZES),
    "tetrahedron": (
        MeshBox(**BOX, shape="tetrahedron"),
        LENGTH * WIDTH * HEIGHT,
        BOX_SIZES,
    ),
}
# axis of the normal of each side, and its direction
NORMALS = {
    "left": (0, -1),
    "right": (0, 1),
    "axis": (0, -1),
    "wall": (0, 1),
    "front": (1, -1),
    "back": (1, 1),
    "bottom": (-1, -1),
    "top": (-1, 1),
}


def assert_partition(mesh):
    """Each exterior facet in one boundary, each cell in one region."""
    facets = np.concatenate(list(mesh.skfem.boundaries.values()))
    assert_array_equal(np.sort(facets), mesh.skfem.boundary_facets())
    cells = np.concatenate(list(mesh.skfem.subdomains.values()))
    assert_array_equal(np.sort(cells), np.arange(mesh.skfem.nelements))


@pytest.mark.parametrize("times", [0, 1, 2])
@pytest.mark.parametrize("case", CASES)
def test_sizes_and_names_are_exact_on_every_level(case, times):
    settings, size, boundaries = CASES[case]
    coarse = build(settings)
    mesh = refine(coarse, times)
    assert mesh.skfem.nelements == coarse.skfem.nelements * 2 ** (
        mesh.skfem.dim() * times
    )
    assert mesh.measure() == pytest.approx(size, rel=1e-13)
    assert set(mesh.boundaries) == set(boundaries)
    for name, expected in boundaries.items():
        assert mesh.measure(name) == pytest.approx(expected, rel=1e-13, abs=1e-15), name
    assert mesh.regions == ("bed",)
    assert (mesh.axisymmetric, mesh.axis) == (coarse.axisymmetric, coarse.axis)
    assert (mesh.axisymmetric, mesh.axis) == (
        (True, 1) if case.startswith("round") else (False, 0)
    )
    assert_partition(mesh)


@pytest.mark.parametrize("times", [0, 1])
@pytest.mark.parametrize("case", CASES)
def test_normals_point_outwards(case, times):
    mesh = refine(build(CASES[case][0]), times).skfem
    for name, facets in mesh.boundaries.items():
        found = np.asarray(skfem.FacetBasis(mesh, mesh.elem(), facets=facets).normals)
        axis, direction = NORMALS[name]
        normal = np.zeros((mesh.dim(), 1, 1))
        normal[axis] = direction
        assert_allclose(found - normal, 0.0, atol=1e-14)


def moments(mesh, region):
    """Size of a region and the integrals of its coordinates."""
    basis = skfem.CellBasis(
        mesh, mesh.elem(), elements=mesh.subdomains[region], intorder=4
    )
    return [
        basis.dx.sum(),
        *(np.sum(basis.dx * c) for c in np.asarray(basis.global_coordinates())),
    ]


@pytest.mark.parametrize("case", CASES)
def test_refinement_keeps_regions_in_place(case):
    mesh = build(CASES[case][0])
    near = mesh.skfem.p[0, mesh.skfem.t].mean(axis=0) < 0.4 * mesh.skfem.p[0].max()
    halves = {"near": np.flatnonzero(near), "far": np.flatnonzero(~near)}
    coarse = replace(mesh, skfem=replace(mesh.skfem, _subdomains=halves))
    fine = refine(coarse, 2)
    assert fine.regions == ("near", "far")
    assert_partition(fine)
    for name in halves:
        assert_allclose(
            moments(fine.skfem, name), moments(coarse.skfem, name), rtol=1e-13
        )


@pytest.mark.parametrize("table", [PLANE, ROUND])
def test_no_triangle_has_two_exterior_sides(table):
    kind = MeshRectangle if table is PLANE else MeshAxisymmetric
    for cells in ((2, 2), (5, 3), (4, 7)):
        mesh = build(kind(**{**table, "cells": cells, "shape": "triangle"})).skfem
        exterior = mesh.f2t[1] == -1
        assert exterior[mesh.t2f].sum(axis=0).max() == 1


def test_default_cells_are_nearly_square_and_never_few():
    channel = build(MeshRectangle(type="rectangle", length=1.0, height=0.5)).skfem
    assert channel.nelements == 40 * 20
    flat = build(MeshRectangle(type="rectangle", length=1.0, height=1e-3)).skfem
    assert flat.nelements == 40 * 8
    shaft = build(MeshAxisymmetric(type="axisymmetric", length=1.0, radius=0.25)).skfem
    assert shaft.nelements == 40 * 10


def test_given_nodes_are_used_instead_of_cells():
    x = graded(LENGTH, [(0.0, 1e-3)])
    automatic = build(MeshLine(type="line", length=LENGTH), [x])
    assert_array_equal(np.sort(automatic.skfem.p[0]), x)
    assert build(LINE, [x]).skfem.nelements == len(x) - 1
    across = np.array([0.0, 0.05, RADIUS])
    shaft = build(
        MeshAxisymmetric(type="axisymmetric", length=LENGTH, radius=RADIUS), [across, x]
    )
    assert shaft.skfem.nelements == 2 * (len(x) - 1)
    assert_partition(shaft)


def test_refine_of_the_table_is_applied():
    settings = MeshBox(**{**BOX, "refine": 1})
    assert build(settings).skfem.nelements == 8 * 24


widths = st.floats(-9, 1).map(lambda exponent: 10.0**exponent)
layer_lists = st.lists(
    st.tuples(st.sampled_from([0.0, 1.0]) | st.floats(0, 1), widths), max_size=4
)


@given(layer_lists, st.floats(1.05, 2.0), st.floats(0.1, 1.0), st.floats(1e-3, 1e3))
def test_graded_resolves_every_layer(layers, ratio, fraction, length):
    x = graded(length, [(p * length, w * length) for p, w in layers], ratio, fraction)
    cells = np.diff(x)
    assert x[0] == 0.0 and x[-1] == length
    assert (cells > 0).all()
    assert cells.max() <= length / 40 * (1 + 1e-9)
    for position, width in layers:
        touching = (x[:-1] <= position * length) & (x[1:] >= position * length)
        # a layer that lies inside a cell has cells of up to one more growth
        allowed = fraction * width * length * (1 if position in (0, 1) else ratio)
        assert cells[touching].max() <= allowed * (1 + 1e-6) + 1e-14 * length
    jump = np.maximum(cells[1:] / cells[:-1], cells[:-1] / cells[1:])
    inner = [p for p, _ in layers if 0 < p < 1]
    assert jump.max() <= (2 * ratio if inner else ratio) * (1 + 1e-5)


@given(layer_lists, st.sampled_from([2, 3, 4]))
def test_scaled_nodes_are_nested_and_halve_the_cells(layers, parts):
    x, fine = graded(1.0, layers), graded(1.0, layers, scale=1 / parts)
    assert len(fine) - 1 == parts * (len(x) - 1)
    assert_allclose(fine[::parts], x, rtol=0, atol=1e-14)
    for left, right in zip(fine[:-parts:parts], fine[parts::parts], strict=True):
        inside = np.diff(fine[(fine >= left) & (fine <= right)])
        assert inside.max() < 1.3 * inside.min() * (1 + 1e-5)


def test_interior_layer_has_a_node():
    assert 0.3 in graded(1.0, [(0.3, 1e-4), (0.0, 0.01)])


@given(layer_lists, st.integers(20, 80), st.sampled_from([1, 2, 3]))
def test_equidistributed_gives_each_layer_its_share(layers, cells, degree):
    x = equidistributed(2.0, [(2.0 * p, 2.0 * w) for p, w in layers], cells, degree)
    assert (
        len(x) == cells + 1 and x[0] == 0.0 and x[-1] == 2.0 and (np.diff(x) > 0).all()
    )
    # each layer counts at most 2 (degree + 1), the smooth part 3
    share = (len(layers) * 2 * (degree + 1) + 3.0) / cells
    for position, width in layers:
        touching = (x[:-1] <= 2.0 * position) & (x[1:] >= 2.0 * position)
        # integral of the layer's own density over one side of the cell
        side = -(degree + 1) * np.log1p(-share / (degree + 1)) * 2.0 * width
        assert (
            np.diff(x)[touching].max()
            <= (1 if position in (0, 1) else 2) * side * (1 + 1e-6) + 1e-14
        )


def test_equidistributed_without_layers_is_uniform():
    assert_allclose(
        equidistributed(1.0, [], 7), np.linspace(0, 1, 8), rtol=0, atol=1e-15
    )


def test_too_thin_a_layer_is_an_error():
    refused(
        r"layer of width 1e-14 m in a bed of 1 m is too thin",
        graded,
        1.0,
        [(0.0, 1e-14)],
    )


def test_cells_fall_geometrically_towards_the_layer():
    x = graded(1.0, [(0.0, 1e-6)], ratio=1.2, fraction=0.25)
    cells = np.diff(x)
    assert 0.2e-6 < cells[0] <= 0.25e-6
    growing = cells[:-1] < 0.5 / 40
    assert_allclose((cells[1:] / cells[:-1])[growing], cells[1] / cells[0], rtol=1e-6)
