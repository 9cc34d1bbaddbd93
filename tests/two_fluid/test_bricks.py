"""Parts and outline of a rectangular grid by its coordinates: those of the grid as
built, without it.
"""

import numpy as np
import pytest

from contbed.errors import EngineError
from contbed.mesh import build as meshing
from contbed.ranks.two_fluid import bricks
from contbed.ranks.two_fluid.division import Division
from contbed.ranks.two_fluid.lattice import lattice_of, numbers_of_facets
from contbed.scene.mesh import MeshAxisymmetric, MeshBox, MeshLine, MeshRectangle
from contbed.two_fluid.boundary import Wall, assemble
from contbed.two_fluid.end_pressure import end_pressure
from contbed.two_fluid.fv import grid
from contbed.two_fluid.fv.connections import connect

# sizes are of the order of 1 and coordinates are rounded to 1e-16, so that differences
# of two over cells are to 1e-14
ROUNDING = 1e-13
LEFT, BOTTOM = ("left", "right"), ("top", "bottom")
PLANE = {"type": "rectangle", "length": 1.0, "height": 2.0}
GRIDS = {
    "line": (MeshLine(type="line", length=1.0, cells=7), []),
    "closed line": (MeshLine(type="line", length=1.0, cells=7), [LEFT]),
    "tall": (MeshRectangle(**PLANE, cells=(5, 8)), []),
    "wide": (MeshRectangle(**PLANE, cells=(8, 5)), [LEFT]),
    "closed from the top": (MeshRectangle(**PLANE, cells=(6, 6)), [BOTTOM]),
    "without boundary": (MeshRectangle(**PLANE, cells=(6, 7)), [LEFT, BOTTOM]),
    "two cells around": (MeshRectangle(**PLANE, cells=(2, 7)), [LEFT]),
    "one cell around": (MeshRectangle(**PLANE, cells=(1, 7)), [LEFT]),
    "round": (
        MeshAxisymmetric(type="axisymmetric", length=1.0, radius=2.0, cells=(4, 6)),
        [BOTTOM],
    ),
    "box": (
        MeshBox(type="box", length=1.0, width=2.0, height=3.0, cells=(4, 3, 5)),
        [("front", "back")],
    ),
}
UNEVEN = [np.cumsum([0.0, 0.1, 0.2, 0.15, 0.3, 0.25]), np.cumsum([0.0, 0.5, 0.2, 0.3])]


def made(name):
    """Mesh, grid as built, what divides it, lattice and its boundaries."""
    if name == "uneven":
        settings, pairs = MeshRectangle(**PLANE, cells=(5, 3)), [LEFT]
        mesh = meshing.build(settings, UNEVEN)
    else:
        settings, pairs = GRIDS[name]
        mesh = meshing.build(settings)
    lattice = lattice_of(mesh, settings.sides, pairs)
    division = Division.of(connect(mesh, pairs))
    return (
        mesh,
        grid.build(mesh, pairs),
        division,
        lattice,
        numbers_of_facets(lattice, mesh, pairs),
    )


def same(one, other):
    """Compare arrays, tuples of them and numbers by name."""
    for name in one._fields if hasattr(one, "_fields") else one.__dataclass_fields__:
        x, y = getattr(one, name), getattr(other, name)
        if name == "geometry":
            same(x, y)
        elif isinstance(x, dict):
            assert x.keys() == y.keys(), name
            for key in x:
                np.testing.assert_array_equal(x[key], y[key], err_msg=f"{name} {key}")
        elif name != "bandwidth":
            np.testing.assert_allclose(y, x, rtol=0.0, atol=ROUNDING, err_msg=name)


@pytest.mark.parametrize("size", [1, 2, 3, 4])
@pytest.mark.parametrize("name", [*GRIDS, "uneven"])
def test_parts_are_those_of_the_grid(name, size):
    mesh, whole, division, lattice, _ = made(name)
    shared = bricks.bricks_of(lattice, size)
    owner = shared.owner(lattice.places(np.arange(len(whole.cells))))
    assert sorted(set(owner)) == list(range(size))
    for rank, share in enumerate(division.split(mesh.skfem, owner, size)):
        same(share.part(), shared.part(rank))


@pytest.mark.parametrize("name", [*GRIDS, "uneven"])
def test_outline_is_that_of_the_grid(name):
    _, whole, division, lattice, boundaries = made(name)
    kept, expected = bricks.outline(lattice, boundaries), division.outline()
    assert (
        kept.face_count == whole.face_count
        and kept.boundaries.keys() == whole.boundaries.keys()
    )
    np.testing.assert_array_equal(kept.cells, whole.cells)
    np.testing.assert_allclose(
        np.ptp(kept.middles, axis=0),
        np.ptp(whole.middles, axis=0),
        rtol=0.0,
        atol=ROUNDING,
    )
    edges = [
        assemble(on, {key: Wall() for key in on.boundaries}, 2500.0)
        for on in (kept, expected)
    ]
    for side in (-1, 1):
        one, other = (
            end_pressure(on, edge, side)
            for on, edge in zip((kept, expected), edges, strict=True)
        )
        np.testing.assert_allclose(
            one.weights, other.weights, rtol=0.0, atol=10.0 * ROUNDING
        )
    if whole.boundaries:
        same(expected.geometry, kept.geometry)
        for key, faces in expected.boundaries.items():
            np.testing.assert_array_equal(kept.boundaries[key], faces)


def test_ranks_have_the_same_bits_and_no_list_of_the_whole():
    """Where two ranks have a cell or a face, and how long what one of nine has is
    beside 36 x 45 cells.
    """
    settings = MeshRectangle(**PLANE, cells=(36, 45))
    shared = bricks.bricks_of(
        lattice_of(meshing.build(settings), settings.sides, [LEFT]), 9
    )
    assert list(shared.along) == [3, 3]
    seen = {}
    for part in map(shared.part, range(9)):
        arrays = [
            x
            for x in (*vars(part).values(), *part.geometry)
            if isinstance(x, np.ndarray)
        ]
        assert (
            part.owned == 12 * 15 and max(map(len, arrays)) <= 2 * (16 * 19) + 16 + 19
        )
        g = part.geometry
        for f, number in enumerate(part.faces):
            values = (
                g.area[f],
                *g.normal[f],
                g.distance[f],
                *g.arm_left[f],
                *g.slope_left[f],
                *part.middles[f],
            )
            assert seen.setdefault(int(number), values) == values
        for c, number in enumerate(part.cells):
            assert seen.setdefault(-1 - int(number), g.volume[c]) == g.volume[c]
    # closed along x, so that it has as many faces as cells there
    assert len(seen) == 36 * 45 + (36 * 45 + 36 * 46)


def test_bricks_have_few_faces_between_them():
    for cells, size, along in (
        ((40, 10), 4, [4, 1]),
        ((30, 30), 6, [2, 3]),
        ((2, 3), 6, [2, 3]),
    ):
        settings = MeshRectangle(**PLANE, cells=cells)
        found = list(
            bricks.bricks_of(
                lattice_of(meshing.build(settings), settings.sides, []), size
            ).along
        )
        assert found == along or (found == along[::-1] and cells[0] == cells[1])
    settings = MeshRectangle(**PLANE, cells=(2, 3))
    lattice = lattice_of(meshing.build(settings), settings.sides, [])
    with pytest.raises(
        EngineError,
        match="7 ranks for a mesh of 2 x 3 cells: each rank needs one; start fewer",
    ):
        bricks.bricks_of(lattice, 7)
    with pytest.raises(
        EngineError, match="5 ranks for a mesh of 2 x 3 cells: start fewer"
    ):
        bricks.bricks_of(lattice, 5)


def test_what_is_no_lattice_is_built_as_before():
    triangles = meshing.build(MeshRectangle(**PLANE, cells=(3, 3), shape="triangle"))
    assert lattice_of(triangles, MeshRectangle.sides, []) is None
    square = meshing.build(MeshRectangle(**PLANE, cells=(3, 3)))
    assert lattice_of(square, MeshRectangle.sides, [("left", "top")]) is None
    assert lattice_of(square, MeshRectangle.sides, []).lends == (None, None)
