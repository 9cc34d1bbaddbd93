"""Built-in meshes by the coordinates along their axes: any nodes and cells have the
numbers of the whole mesh.
"""

from dataclasses import replace

import numpy as np
import pytest

from contbed.mesh import tensor
from contbed.mesh.build import build
from contbed.mesh.grading import graded
from contbed.scene.mesh import MeshAxisymmetric, MeshBox, MeshLine, MeshRectangle

PLANE = {"type": "rectangle", "length": 1.0, "height": 2.0}
SPACE = {"type": "box", "length": 1.0, "width": 2.0, "height": 3.0, "cells": (3, 4, 5)}
ROUND = {"type": "axisymmetric", "length": 1.0, "radius": 2.0}
MESHES = {
    "line": (MeshLine(type="line", length=1.0, cells=7), 7),
    "rectangles": (MeshRectangle(**PLANE, cells=(5, 8)), 40),
    "triangles": (MeshRectangle(**PLANE, cells=(5, 8), shape="triangle"), 80),
    "around an axis": (MeshAxisymmetric(**ROUND, cells=(4, 3)), 12),
    "triangles around an axis": (
        MeshAxisymmetric(**ROUND, cells=(4, 3), shape="triangle"),
        24,
    ),
    "bricks": (MeshBox(**SPACE), 60),
    "tetrahedra": (MeshBox(**SPACE, shape="tetrahedron"), 360),
}


def uneven(settings):
    """Coordinates graded to a layer at one end of each axis."""
    return [
        graded(size, [(0.0, 0.2 * size)], coarse=0.3 * size)
        for size in settings.extents
    ]


@pytest.mark.parametrize("name", MESHES)
def test_any_nodes_and_cells_are_those_of_the_mesh(name, monkeypatch):
    monkeypatch.setattr(tensor, "AT_ONCE", 7)
    settings, cells = MESHES[name]
    for nodes in (None, uneven(settings)):
        mesh = build(settings, nodes).skfem
        found = tensor.tensor_of(mesh)
        assert found is not None and (found.cells, found.nodes) == (
            mesh.nelements,
            mesh.nvertices,
        )
        assert nodes is not None or found.cells == cells
        some = np.arange(found.cells)[::-3]
        np.testing.assert_array_equal(found.corners(some), mesh.t[:, some].T)
        some = np.arange(found.nodes)[::-2]
        # the same bits
        np.testing.assert_array_equal(found.points(some), mesh.p[:, some].T)


def test_other_numberings_have_no_such_description():
    settings, _ = MESHES["triangles"]
    whole = build(settings).skfem
    moved = whole.p.copy()
    moved[0, 12] += 1e-3
    swapped = whole.t.copy()
    swapped[:, [3, 4]] = swapped[:, [4, 3]]
    for other in (
        replace(whole, doflocs=moved),
        replace(whole, t=swapped),
        whole.refined(),
        whole.refined([0]),
    ):
        assert tensor.tensor_of(other) is None
    assert tensor.tensor_of(whole) is not None
