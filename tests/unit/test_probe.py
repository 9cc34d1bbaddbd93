"""Points and lines of a mesh at which fields are sampled."""

from __future__ import annotations

import numpy as np
import pytest
import skfem
from numpy.testing import assert_allclose
from pytest import approx

from contbed.fem.elements import Space
from contbed.fem.probe import Probe, line_along
from contbed.loading import loads
from contbed.mesh.build import build
from contbed.mesh.mesh import Mesh
from contbed.scene.mesh import MeshAxisymmetric, MeshBox, MeshRectangle
from tests.refusals import refused


def linear(mesh, space, weights):
    """A field that is linear in the coordinates, at the nodes of a space of degree
    1.
    """
    return np.asarray(weights) @ mesh.skfem.p


def with_hole(low, high):
    """A rectangle of 1 x 0.2 whose cells with a centre between `low` and `high` are
    cut out.
    """
    grid = skfem.MeshQuad.init_tensor(np.linspace(0, 1, 21), np.linspace(0, 0.2, 21))
    centre = grid.p[:, grid.t].mean(axis=1)
    inside = np.all(
        (centre > np.array(low)[:, None]) & (centre < np.array(high)[:, None]), axis=0
    )
    return Mesh(grid.remove_elements(np.flatnonzero(inside)))


@pytest.mark.parametrize(
    "settings",
    [
        MeshRectangle(type="rectangle", length=0.3, height=0.02, cells=(37, 5)),
        MeshAxisymmetric(
            type="axisymmetric",
            length=0.3,
            radius=0.02,
            cells=(5, 37),
            shape="triangle",
        ),
        MeshBox(type="box", length=0.3, width=0.02, height=0.03, cells=(11, 3, 2)),
        MeshBox(
            type="box",
            length=0.3,
            width=0.02,
            height=0.03,
            cells=(11, 3, 2),
            shape="tetrahedron",
        ),
    ],
    ids=["quadrilaterals", "triangles", "hexahedra", "tetrahedra"],
)
def test_linear_fields_are_exact_near_ends_and_at_nodes(settings):
    """To rounding at ends, at nodes and one hair inside of them."""
    mesh = build(settings)
    places = np.unique(
        [0.0, 1e-12, 0.2999, 0.3 - 1e-12, 0.3, *np.linspace(0.0, 0.3, 38)]
    )
    line = line_along(mesh, places)
    weights = np.arange(1.0, mesh.skfem.dim() + 1.0)
    space = Space(mesh.skfem, 1)
    found = line.probe(space, linear(mesh, space, weights))
    points = np.array(
        [line.probe(space, mesh.skfem.p[k]) for k in range(mesh.skfem.dim())]
    )
    assert_allclose(found, weights @ points, atol=1e-14)
    assert_allclose(points[mesh.axis], places, atol=1e-14)
    assert_allclose(
        line.probe.slope(space, mesh.skfem.p[mesh.axis], mesh.axis), 1.0, rtol=1e-11
    )


def test_distorted_quadrilaterals():
    """The inverse of a bilinear map by Newton's method: the point comes back to
    1e-14.
    """
    grid = skfem.MeshQuad.init_tensor(np.linspace(0, 1, 6), np.linspace(0, 1, 6))
    shift = 0.05 * np.sin(7.0 * grid.p[::-1]) * (grid.p * (1 - grid.p)).prod(axis=0)
    mesh = Mesh(skfem.MeshQuad(grid.p + shift * 4, grid.t))
    points = np.random.default_rng(1).uniform(0.02, 0.98, (2, 300))
    probe, space = Probe(mesh, points), Space(mesh.skfem, 1)
    found = np.array([probe(space, mesh.skfem.p[k]) for k in range(2)])
    assert_allclose(found, points, atol=1e-14)


def test_an_obstacle_in_the_middle_moves_the_line():
    """The hole reaches from 0.08 to 0.12 of 0.2 m: the next share of the width, 0.4,
    is on its edge, 0.3 is free.
    """
    line = line_along(with_hole((0.4, 0.07), (0.6, 0.13)))
    space = Space(with_hole((0.4, 0.07), (0.6, 0.13)).skfem, 1)
    assert space.size and "y = 0.06 m" in line.note
    assert line_along(with_hole((0.4, 0.16), (0.6, 0.21))).note == ""


def test_a_given_line_is_taken():
    mesh = with_hole((0.4, 0.07), (0.6, 0.13))
    line = line_along(mesh, across=(0.19,))
    assert_allclose(line.probe(Space(mesh.skfem, 1), mesh.skfem.p[1]), 0.19, atol=1e-15)


def test_a_gap_across_the_bed_leaves_the_longest_part_of_a_line():
    """Of given positions none may lie in the gap."""
    cut = with_hole((0.4, -1.0), (0.6, 1.0))
    line = line_along(cut)
    assert np.ptp(line.positions) == approx(0.4, rel=1e-6)
    assert "no line lies in the mesh from end to end" in line.note
    refused(r"output\.across", line_along, cut, [0.1, 0.5])
    assert len(line_along(cut, [0.1, 0.9]).positions) == 2


@pytest.mark.parametrize(
    ("across", "wrong"),
    [
        ("[0.3]", "outside of the bed"),
        ("'30 cm'", "outside of the bed"),
        ("[0.1, 0.1]", "needs 1"),
    ],
)
def test_a_line_outside_is_refused(across, wrong):
    text = f"""
        mesh = {{ type = "rectangle", length = 1.0, height = 0.2 }}
        radiation = {{ absorption = 1.0 }}
        boundary.left.radiation.temperature = 300
        output.across = {across}
    """
    refused(wrong, loads, text)
    along = text.replace("rectangle", "line").replace("height = 0.2", "cells = 4")
    refused("no other coordinate", loads, along)
    alone = loads(text.replace(across, "0.1"))
    assert alone.output.across == (0.1,)
