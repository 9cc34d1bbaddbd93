"""Parts of a grid that ranks have, and the outline that the root rank keeps, without
ranks: what they must share.
"""

import numpy as np
import pytest
from core_closures import closures, shaken_mesh
from numpy.testing import assert_array_equal

from contbed.mesh import build as meshing
from contbed.ranks.two_fluid.division import OF_FACES, OF_INTERIOR, Division
from contbed.scene.mesh import MeshAxisymmetric, MeshBox, MeshLine, MeshRectangle
from contbed.two_fluid.boundary import (
    InletCondition,
    OutletCondition,
    WallCondition,
    assemble,
)
from contbed.two_fluid.end_pressure import end_pressure
from contbed.two_fluid.fv import grid
from contbed.two_fluid.fv.connections import connect
from contbed.two_fluid.heat.wall_layer import NOWHERE, wall_layers
from contbed.two_fluid.model import Materials, build_model
from contbed.two_fluid.results import across
from contbed.two_fluid.state import zero_state
from contbed.two_fluid.vessel import Vessel, depth

SIDES = [("left", "right"), ("bottom", "top")]
PLANE = MeshRectangle(type="rectangle", length=0.3, height=1.0, cells=(12, 20))
BOX = {"type": "box", "length": 0.1, "width": 0.2, "height": 0.3}
ROUND = MeshAxisymmetric(
    type="axisymmetric", length=1.0, radius=0.3, cells=(6, 9), shape="triangle"
)
ONE_AROUND = MeshRectangle(type="rectangle", length=0.3, height=1.0, cells=(1, 9))
LINE = MeshLine(type="line", length=1.0, cells=9)
UNEVEN = [0.3 * np.linspace(0.0, 1.0, 13) ** 1.3, np.linspace(0.0, 1.0, 21) ** 0.8]
# mesh and periodic pairs; a row of one cell that is periodic has faces from the cell to
# itself
GRIDS = {
    "rectangles": lambda: (meshing.build(PLANE), []),
    "periodic": lambda: (meshing.build(PLANE), SIDES[:1]),
    "without boundary": lambda: (meshing.build(PLANE), SIDES),
    "line": lambda: (meshing.build(LINE), []),
    "closed line": lambda: (meshing.build(LINE), SIDES[:1]),
    "closed from the top": lambda: (meshing.build(PLANE), [("top", "bottom")]),
    "uneven": lambda: (meshing.build(PLANE, UNEVEN), []),
    "one cell around": lambda: (meshing.build(ONE_AROUND), SIDES[:1]),
    "triangles": lambda: (shaken_mesh("triangle", (12, 12)), []),
    "periodic triangles": lambda: (shaken_mesh("triangle", (12, 12)), SIDES[:1]),
    "quadrilaterals": lambda: (shaken_mesh("quadrilateral", (12, 12)), []),
    "round": lambda: (meshing.build(ROUND), []),
    "box": lambda: (meshing.build(MeshBox(**BOX, cells=(7, 8, 9))), []),
    "tetrahedra": lambda: (
        meshing.build(MeshBox(**BOX, cells=(4, 3, 5), shape="tetrahedron")),
        [],
    ),
}
# lists of `Geometry` by what they list
OF_CELLS = ("gradient_inverse", "volume", "moment_inverse", "radius")


def outline(mesh, periodic=()):
    return Division.of(connect(mesh, periodic)).outline()


def conditions(of):
    known = {
        "bottom": InletCondition(velocity=0.3),
        "top": OutletCondition(pressure=2.0),
    }
    return {name: known.get(name, WallCondition()) for name in of.boundaries}


@pytest.mark.parametrize("name", GRIDS)
def test_outline_answers_as_the_grid(name):
    mesh, periodic = GRIDS[name]()
    whole, kept = grid.build(mesh, periodic), outline(mesh, periodic)
    assert kept.face_count == whole.face_count > len(kept.geometry.left)
    edges = [assemble(on, conditions(on), 2500.0) for on in (whole, kept)]
    for one, other in zip(edges[0], edges[1], strict=True):
        for x, y in (
            zip(one, other, strict=True) if isinstance(one, tuple) else [(one, other)]
        ):
            assert_array_equal(x, y)
    for side in (-1, 1):
        one, other = (
            end_pressure(on, edge, side)
            for on, edge in zip((whole, kept), edges, strict=True)
        )
        assert_array_equal(one.weights, other.weights)  # the same bits
        assert one.outside == other.outside
    assert_array_equal(np.ptp(whole.middles, axis=0), np.ptp(kept.middles, axis=0))
    assert across(whole)[0] == across(kept)[0]
    states = zero_state(whole), zero_state(kept)
    assert states[0].fluxes.moved.shape == states[1].fluxes.moved.shape
    assert_array_equal(whole.geometry.volume, kept.geometry.volume)
    assert_array_equal(whole.centres, kept.centres)
    eps_s = np.where(whole.centres[:, -1] < whole.spans.mean(), 0.5, 0.1)
    assert depth(whole, eps_s) == depth(kept, eps_s) > 0.0  # the same bits
    assert_array_equal(Vessel.of(whole).volumes, Vessel.of(kept).volumes)
    assert whole.skewed == kept.skewed and whole.rectangular == kept.rectangular


def test_outline_of_a_large_grid_lists_few_faces():
    mesh = shaken_mesh("triangle", (40, 40))
    kept = outline(mesh)
    assert kept.face_count > 4 * len(kept.geometry.left)


@pytest.mark.parametrize("axis", ["bottom", "top"])
def test_outline_of_a_floor_that_is_no_outlet(axis):
    """The pressure of floor and roof by gradients, which reach two cells into a bed
    of shaken triangles.
    """
    mesh = shaken_mesh("triangle", (12, 12))
    whole, kept, side = grid.build(mesh), outline(mesh), -1 if axis == "bottom" else 1
    edges = [
        assemble(on, {name: WallCondition() for name in on.boundaries}, 2500.0)
        for on in (whole, kept)
    ]
    one, other = (
        end_pressure(on, edge, side)
        for on, edge in zip((whole, kept), edges, strict=True)
    )
    assert np.count_nonzero(one.weights) > 24  # cells beside the side
    assert_array_equal(one.weights, other.weights)


@pytest.mark.parametrize("size", [1, 2, 3])
@pytest.mark.parametrize("name", GRIDS)
def test_parts_are_those_of_the_grid(name, size):
    """Each cell and face once, and all that ranks make from their shares to the last
    bit as in the grid as built.
    """
    mesh, periodic = GRIDS[name]()
    whole, division = grid.build(mesh, periodic), Division.of(connect(mesh, periodic))
    height = whole.centres[:, -1] / whole.middles[:, -1].max()
    owner = np.minimum((height * size).astype(np.int64), size - 1)
    parts = [share.part() for share in division.split(owner, size)]
    cells = np.concatenate([part.cells[: part.owned] for part in parts])
    faces = np.concatenate([part.faces[part.own_faces] for part in parts])
    assert np.array_equal(np.sort(cells), np.arange(len(whole.cells)))
    assert np.array_equal(np.sort(faces), np.arange(whole.face_count))
    for part in parts:
        g, there = part.grid.geometry, whole.geometry
        for names, places in (
            (OF_FACES, part.faces),
            (OF_INTERIOR, part.interior),
            (OF_CELLS, part.cells),
        ):
            for key in names:
                if len(getattr(there, key)):
                    assert_array_equal(
                        getattr(there, key)[places], getattr(g, key), err_msg=key
                    )
        assert (g.skewed, g.axes, g.edge_from, g.edge_to) == (
            there.skewed,
            there.axes,
            len(g.right),
            len(g.left),
        )
        assert_array_equal(there.left[part.faces], part.cells[g.left])
        assert_array_equal(there.right[part.interior], part.cells[g.right])
        assert_array_equal(whole.centres[part.cells], part.grid.centres)
        assert_array_equal(whole.middles[part.faces], part.grid.middles)
        assert_array_equal(whole.cells[part.cells], part.grid.cells)
        for other in parts:
            if part.rank in other.received:
                sent, received = (
                    part.cells[part.sent[other.rank]],
                    other.cells[other.received[part.rank]],
                )
                assert len(sent)
                assert_array_equal(sent, received)
        assert part.sent.keys() == part.received.keys()


def layers_by_face(on, w, faces, cells):
    """What layers of a grid hold, by the number of their face in the whole one; those
    beside other ranks' cells too.
    """
    found = {}
    for k, face in enumerate(w.face):
        around = slice(w.start[k], w.start[k + 1])
        beyond = w.beyond_cell[around]
        others = np.where(beyond == NOWHERE, NOWHERE, cells[beyond])
        columns = (w.outward, w.opposite, w.beyond_column)
        lists = (faces[w.beside[around]], others, *(each[around] for each in columns))
        order = np.argsort(lists[0])
        numbers = np.stack([each[order] for each in lists])
        shape = np.stack((w.thickness[k], w.node[k], w.share[k]))
        found[int(faces[face])] = int(w.column[k]), numbers, shape
    return found


@pytest.mark.parametrize("name", ["rectangles", "triangles", "round", "box"])
def test_layers_beside_walls_are_those_of_the_grid(name):
    """Of own cells each rank has the same layers, and finds the same ones beside them
    beyond its own cells.
    """
    mesh, periodic = GRIDS[name]()
    whole, division = grid.build(mesh, periodic), Division.of(connect(mesh, periodic))
    edges = np.arange(whole.interior, whole.face_count)
    heated = whole.geometry.normal[edges].sum(axis=1) > 0.0
    everything = np.arange(whole.face_count)
    layers, columns = wall_layers(whole, heated)
    wanted = layers_by_face(whole, layers, everything, np.arange(len(whole.cells)))
    assert columns in (20, 40, 60)
    owner = (whole.centres[:, -1] > whole.centres[:, -1].mean()).astype(np.int64)
    met = 0
    for share in division.split(owner, 2):
        part = share.part()
        on = part.grid
        mine = part.faces[on.interior :] - whole.interior
        found = layers_by_face(
            on, wall_layers(on, heated[mine])[0], part.faces, part.cells
        )
        for face in found.keys() & set(part.faces[part.own_faces].tolist()):
            met += 1
            assert found[face][0] == wanted[face][0]
            for one, other in zip(found[face][1:], wanted[face][1:], strict=True):
                assert_array_equal(one, other)
    assert met == heated.sum()


def test_a_model_on_the_outline_has_the_same_conditions_and_ends():
    mesh = meshing.build(PLANE)
    whole = grid.build(mesh)
    materials = Materials(1.2, 1.8e-5, 2500.0, 5e-4, 0.63, (0.0, -9.81))
    one, other = (
        build_model(on, materials, closures(), conditions(on))
        for on in (whole, outline(mesh))
    )
    p = np.linspace(0.0, 100.0, len(whole.cells))
    assert [end.mean(p) for end in one.ends] == [end.mean(p) for end in other.ends]
    assert (
        np.array_equal(one.boundary_cells, other.boundary_cells)
        and one.closed == other.closed
    )
