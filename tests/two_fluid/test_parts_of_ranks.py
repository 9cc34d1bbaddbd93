"""Parts of a grid that ranks have, and the outline that the root rank keeps, without ranks: what they must share."""

import numpy as np
import pytest
from core_closures import closures, rectangle, shaken

from contbed.mesh import build as meshing
from contbed.scene.mesh import MeshBox, MeshRectangle
from contbed.two_fluid.boundary import Inlet, Outlet, Wall, assemble
from contbed.two_fluid.distributed import partition
from contbed.two_fluid.end_pressure import end_pressure
from contbed.two_fluid.fv import grid
from contbed.two_fluid.model import Materials, build_model
from contbed.two_fluid.results import across
from contbed.two_fluid.state import zero_state

SIDES = [("left", "right"), ("bottom", "top")]
GRIDS = {
    "rectangles": lambda: rectangle(0.3, 1.0, (12, 20)),
    "periodic": lambda: rectangle(0.3, 1.0, (12, 20), SIDES[:1]),
    "without boundary": lambda: rectangle(0.3, 1.0, (12, 20), SIDES),
    "triangles": lambda: shaken("triangle", (12, 12)),
    "box": lambda: grid.build(meshing.build(MeshBox(type="box", length=0.1, width=0.2, height=0.3, cells=(7, 8, 9)))),
}


def conditions(of):
    known = {"bottom": Inlet(velocity=0.3), "top": Outlet(pressure=2.0)}
    return {name: known.get(name, Wall()) for name in of.boundaries}


@pytest.mark.parametrize("name", GRIDS)
def test_outline_answers_as_the_grid(name):
    whole = GRIDS[name]()
    kept = partition.outline(whole)
    assert kept.face_count == whole.face_count > len(kept.geometry.left)
    edges = [assemble(on, conditions(on), 2500.0) for on in (whole, kept)]
    for one, other in zip(edges[0], edges[1], strict=True):
        for x, y in zip(one, other, strict=True) if isinstance(one, tuple) else [(one, other)]:
            np.testing.assert_array_equal(x, y)
    for side in (-1, 1):
        one, other = (end_pressure(on, edge, side) for on, edge in zip((whole, kept), edges, strict=True))
        np.testing.assert_array_equal(one.weights, other.weights)  # the same bits
        assert one.outside == other.outside
    np.testing.assert_array_equal(np.ptp(whole.middles, axis=0), np.ptp(kept.middles, axis=0))
    assert across(whole)[0] == across(kept)[0]
    states = zero_state(whole), zero_state(kept)
    assert states[0].fluxes.moved.shape == states[1].fluxes.moved.shape
    assert whole.geometry.volume is kept.geometry.volume


@pytest.mark.parametrize("axis", ["bottom", "top"])
def test_outline_of_a_floor_that_is_no_outlet(axis):
    """The pressure of floor and roof by gradients, which reach two cells into a bed of shaken triangles."""
    whole = shaken("triangle", (12, 12))
    kept, side = partition.outline(whole), -1 if axis == "bottom" else 1
    edges = [assemble(on, {name: Wall() for name in on.boundaries}, 2500.0) for on in (whole, kept)]
    one, other = (end_pressure(on, edge, side) for on, edge in zip((whole, kept), edges, strict=True))
    assert np.count_nonzero(one.weights) > 24  # cells beside the side
    np.testing.assert_array_equal(one.weights, other.weights)


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("shape", ["quadrilateral", "triangle"])
def test_parts_hold_each_cell_and_face_once(shape, size):
    mesh = meshing.build(MeshRectangle(type="rectangle", length=1.0, height=1.0, cells=(9, 10), shape=shape))
    whole = grid.build(mesh)
    owner = np.minimum((whole.centres[:, 1] * size).astype(np.int64), size - 1)
    parts = list(partition.split(whole, mesh.skfem, owner, size))
    cells = np.concatenate([part.cells[: part.owned] for part in parts])
    faces = np.concatenate([part.faces[part.own_faces] for part in parts])
    assert np.array_equal(np.sort(cells), np.arange(len(whole.cells)))
    assert np.array_equal(np.sort(faces), np.arange(whole.face_count))
    for part in parts:
        g = part.geometry
        np.testing.assert_array_equal(whole.geometry.volume[part.cells], g.volume)
        np.testing.assert_array_equal(whole.geometry.normal[part.faces], g.normal)
        np.testing.assert_array_equal(whole.geometry.left[part.faces], part.cells[g.left])
        corners = part.points[part.corners]
        np.testing.assert_allclose(corners.mean(axis=1), whole.centres[part.cells], rtol=0.0, atol=1e-15)
        for other in parts:
            if part.rank in other.received:
                sent, received = part.cells[part.sent[other.rank]], other.cells[other.received[part.rank]]
                assert len(sent)
                np.testing.assert_array_equal(sent, received)


def test_a_model_on_the_outline_has_the_same_conditions_and_ends():
    whole = rectangle(0.3, 1.0, (12, 20))
    materials = Materials(1.2, 1.8e-5, 2500.0, 5e-4, 0.63, (0.0, -9.81))
    one, other = (build_model(on, materials, closures(), conditions(on)) for on in (whole, partition.outline(whole)))
    p = np.linspace(0.0, 100.0, len(whole.cells))
    assert [end.mean(p) for end in one.ends] == [end.mean(p) for end in other.ends]
    assert np.array_equal(one.boundary_cells, other.boundary_cells) and one.closed == other.closed
