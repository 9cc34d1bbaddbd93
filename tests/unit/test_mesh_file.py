"""Gmsh files: what is read, and every way in which a file can be wrong."""

import builtins
import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx

from contbed.errors import SceneError
from contbed.mesh.build import build
from contbed.mesh.mesh import refine
from contbed.packed_bed.flow import passes_along
from contbed.scene.mesh import MeshFile
from tests.imported import modules_after

MESHES = Path(__file__).parents[2] / "meshes"
SHIPPED = {
    "moving_bed_heater": (
        {"axisymmetric": True},
        np.pi * 0.01,
        {"axis": 0, "wall": 0.2 * np.pi, "bottom": np.pi * 0.01},
    ),
    "channel": (
        {},
        0.25 * 0.0775,
        {"left": 0.0775, "right": 0.0775, "bottom": 0.25, "top": 0.25},
    ),
    "square_quad": ({}, 1.0, {"left": 1, "right": 1, "bottom": 1, "top": 1}),
    "cube_tet": (
        {"dimension": 3},
        1.0,
        dict.fromkeys(("left", "right", "front", "back", "bottom", "top"), 1),
    ),
    "two_layers": ({}, 0.02, {"left": 0.1, "right": 0.1, "bottom": 0.2, "top": 0.2}),
}
POINT, LINE, TRIANGLE, QUAD, TETRA, HEXAHEDRON, PRISM = 15, 1, 2, 3, 4, 5, 6
UNIT = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
SIDES = [(LINE, 1, (1, 2)), (LINE, 2, (2, 3)), (LINE, 3, (3, 4)), (LINE, 4, (4, 1))]
NAMES = {
    (1, 1): "bottom",
    (1, 2): "right",
    (1, 3): "top",
    (1, 4): "left",
    (2, 5): "bed",
}
SQUARE = [*SIDES, (TRIANGLE, 5, (1, 2, 3)), (TRIANGLE, 5, (1, 3, 4))]


@pytest.fixture
def gmsh():
    """gmsh, for tests that mesh or write with it."""
    try:
        import gmsh
    except (ImportError, OSError) as error:
        pytest.skip(f"gmsh cannot be imported: {error}")
    return gmsh


def write(path, points=UNIT, elements=SQUARE, names=NAMES):
    """An ASCII 2.2 mesh; elements are (gmsh type, physical tag, nodes from 1)."""
    lines = [
        "$MeshFormat",
        "2.2 0 8",
        "$EndMeshFormat",
        "$PhysicalNames",
        str(len(names)),
    ]
    lines += [f'{dim} {tag} "{name}"' for (dim, tag), name in names.items()]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    lines += [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(points, 1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [
        f"{i} {kind} 2 {tag} {tag} {' '.join(map(str, n))}"
        for i, (kind, tag, n) in enumerate(elements, 1)
    ]
    path.write_text("\n".join([*lines, "$EndElements", ""]))


def load(path, **keys):
    return build(MeshFile(type="file", file=path.name, **keys), base=str(path.parent))


def problems(path, **keys):
    """The error's lines, each of which must start with the file's name."""
    with pytest.raises(SceneError) as caught:
        load(path, **keys)
    for line in caught.value.problems:
        assert line.startswith(f"{path.name}: ") and "\n" not in line
    return caught.value.problems


@pytest.fixture
def only_problem(tmp_path):
    """Writes a mesh and returns its one problem."""

    def check(points=UNIT, elements=SQUARE, names=NAMES, **keys):
        write(tmp_path / "a.msh", points, elements, names)
        (line,) = problems(tmp_path / "a.msh", **keys)
        return line

    return check


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_meshes(name):
    keys, size, boundaries = SHIPPED[name]
    mesh = load(MESHES / f"{name}.msh", **keys)
    assert (MESHES / f"{name}.msh").stat().st_size < 60_000
    assert mesh.regions == (("lower", "upper") if name == "two_layers" else ("bed",))
    for level in (mesh, refine(mesh)):
        assert level.measure() == approx(size, rel=1e-12)
        for boundary, expected in boundaries.items():
            assert level.measure(boundary) == approx(expected, rel=1e-12, abs=1e-15)
        facets = np.concatenate(list(level.skfem.boundaries.values()))
        assert_array_equal(np.sort(facets), level.skfem.boundary_facets())
    assert mesh.axis == (1 if mesh.axisymmetric else 0)


@pytest.mark.parametrize("name", SHIPPED)
def test_geometry_gives_the_shipped_mesh(gmsh, name):
    keys = SHIPPED[name][0]
    meshed, stored = (
        load(MESHES / f"{name}.geo", **keys),
        load(MESHES / f"{name}.msh", **keys),
    )
    if not gmsh.__version__.startswith("4.15"):
        pytest.skip(
            f"the shipped meshes are from gmsh 4.15, this is {gmsh.__version__}"
        )
    assert_allclose(meshed.skfem.p, stored.skfem.p, atol=1e-15)
    assert_array_equal(meshed.skfem.t, stored.skfem.t)
    assert meshed.boundaries == stored.boundaries and meshed.regions == stored.regions
    for boundary in stored.boundaries:
        assert_array_equal(
            meshed.skfem.boundaries[boundary], stored.skfem.boundaries[boundary]
        )


@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_formats(gmsh, tmp_path, version, binary):
    path = tmp_path / "a.msh"
    gmsh.initialize(interruptible=False)
    try:
        for option, value in {
            "General.Terminal": 0,
            "Mesh.MshFileVersion": version,
            "Mesh.Binary": binary,
        }.items():
            gmsh.option.setNumber(option, value)
        gmsh.open(str(MESHES / "two_layers.msh"))
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    assert path.read_bytes()[:20].startswith(
        f"$MeshFormat\n{version} {binary}".encode()
    )
    mesh, stored = load(path), load(MESHES / "two_layers.msh")
    assert set(mesh.boundaries) == set(stored.boundaries) and mesh.regions == (
        "lower",
        "upper",
    )
    assert mesh.measure() == approx(stored.measure(), rel=1e-14)
    assert mesh.measure("left") == approx(0.1, rel=1e-14)


def test_size_and_scale(gmsh):
    coarse = load(MESHES / "channel.geo", size=0.03)
    assert coarse.skfem.nelements < 200
    small = load(MESHES / "channel.geo", size=0.03e-3, scale=1e-3)
    assert small.skfem.nelements == coarse.skfem.nelements
    assert small.measure() == approx(0.25 * 0.0775 * 1e-6, rel=1e-12)


def test_reading_a_mesh_needs_no_gmsh():
    code = f"""
from contbed.mesh.build import build
from contbed.scene.mesh import MeshFile
build(MeshFile(type='file', file='channel.msh'), base={str(MESHES)!r})
"""
    assert "gmsh" not in modules_after(code)


def test_missing_system_library_is_named(tmp_path, monkeypatch):
    real = builtins.__import__

    def fail(name, *args, **kwargs):
        if name == "gmsh":
            raise OSError(
                "libGLU.so.1: cannot open shared object file: No such file or directory"
            )
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", fail)
    shutil.copy(MESHES / "channel.geo", tmp_path / "a.geo")
    (line,) = problems(tmp_path / "a.geo")
    assert "libGLU.so.1" in line and "apt install libglu1-mesa" in line


def test_broken_geometry(gmsh, tmp_path, capfd):
    (tmp_path / "a.geo").write_text("Point(1) = {0, 0, 0;\nLine(")
    assert "gmsh cannot mesh it" in problems(tmp_path / "a.geo")[0]
    assert not gmsh.isInitialized()
    (tmp_path / "b.geo").write_text("Point(1) = {0, 0, 0};\n")
    assert "holds no cells" in problems(tmp_path / "b.geo")[0]
    assert capfd.readouterr() == ("", "")


def test_curve_in_two_groups_of_a_geometry(gmsh, tmp_path):
    source = (MESHES / "channel.geo").read_text()
    (tmp_path / "a.geo").write_text(source + 'Physical Curve("walls", 9) = {1, 3};\n')
    (line,) = problems(tmp_path / "a.geo")
    assert (
        "72 facets are in more than one Physical Curve" in line
        and "'bottom', 'walls'" in line
    )


def test_cells_are_oriented_and_unused_nodes_dropped(tmp_path):
    cube = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    nodes = [5, 6, 7, 8, 1, 2, 3, 4]  # bottom and top exchanged: inside out
    faces = [
        (1, 2, 3, 4),
        (5, 6, 7, 8),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (3, 4, 8, 7),
        (4, 1, 5, 8),
    ]
    elements = [(QUAD, 1, face) for face in faces] + [(HEXAHEDRON, 7, nodes)]
    write(
        tmp_path / "a.msh",
        [*cube, (9, 9, 9)],
        elements,
        {(2, 1): "skin", (3, 7): "bed"},
    )
    mesh = refine(load(tmp_path / "a.msh", dimension=3))
    assert mesh.measure() == approx(1.0, rel=1e-14) and mesh.measure("skin") == approx(
        6.0, rel=1e-14
    )
    assert mesh.skfem.p.max() == 1.0
    assert (mesh.skfem.mapping().detDF(np.full((3, 1), 0.5)) > 0).all()


def test_line_mesh(tmp_path):
    elements = [
        (POINT, 1, (1,)),
        (POINT, 2, (3,)),
        (LINE, 3, (1, 2)),
        (LINE, 3, (3, 2)),
    ]
    write(
        tmp_path / "a.msh",
        [(0, 0, 0), (0.2, 0, 0), (1, 0, 0)],
        elements,
        {(0, 1): "in", (0, 2): "out"},
    )
    mesh = refine(load(tmp_path / "a.msh", dimension=1))
    assert mesh.boundaries == ("in", "out") and mesh.regions == ("region_3",)
    assert mesh.measure() == approx(1.0, rel=1e-14)


def test_unnamed_groups_are_numbered(tmp_path):
    write(tmp_path / "a.msh", names={})
    mesh = load(tmp_path / "a.msh")
    assert mesh.boundaries == ("boundary_1", "boundary_2", "boundary_3", "boundary_4")
    assert mesh.regions == ("region_5",)


def test_constant_z_is_allowed(tmp_path):
    write(tmp_path / "a.msh", [(x, y, 5.0) for x, y, _ in UNIT])
    assert load(tmp_path / "a.msh").measure() == approx(1.0)


def test_groups_between_regions_are_no_boundary(tmp_path):
    elements = [
        *SIDES,
        (LINE, 6, (1, 3)),
        (TRIANGLE, 5, (1, 2, 3)),
        (TRIANGLE, 7, (1, 3, 4)),
    ]
    write(
        tmp_path / "a.msh",
        elements=elements,
        names={**NAMES, (1, 6): "inner", (2, 7): "second"},
    )
    mesh = load(tmp_path / "a.msh")
    assert "inner" not in mesh.boundaries and mesh.regions == ("bed", "second")


def test_missing_unreadable_and_foreign_files(tmp_path):
    assert "No such file" in problems(tmp_path / "a.msh")[0]
    (tmp_path / "folder.msh").mkdir()
    assert "cannot be read" in problems(tmp_path / "folder.msh")[0]
    (tmp_path / "a.stl").write_text("solid")
    assert "ends in .msh or .geo, found '.stl'" in problems(tmp_path / "a.stl")[0]
    (tmp_path / "b.msh").write_text("hello\n")
    assert "not a gmsh mesh" in problems(tmp_path / "b.msh")[0]
    (tmp_path / "c.msh").write_bytes(b"")
    assert "not a gmsh mesh" in problems(tmp_path / "c.msh")[0]
    write(tmp_path / "d.msh", [], [], {})
    assert len(problems(tmp_path / "d.msh")) == 1


def test_truncated_and_damaged_files_never_pass_or_crash(tmp_path, capfd):
    rng = np.random.default_rng(1)
    for name in ("square_quad.msh", "two_layers.msh"):
        data = (MESHES / name).read_bytes()
        for end in range(0, len(data) - len("$EndElements\n"), 1 + len(data) // 40):
            (tmp_path / "a.msh").write_bytes(data[:end])
            assert problems(tmp_path / "a.msh")
            start = int(rng.integers(0, len(data) - 60))
            (tmp_path / "b.msh").write_bytes(data[:start] + data[start + 50 :])
            try:
                assert load(tmp_path / "b.msh").skfem.nelements > 0
            except SceneError as error:
                assert str(error).startswith("b.msh: ")
    assert capfd.readouterr() == ("", "")


def test_wrong_dimension(only_problem):
    assert only_problem(dimension=3) == (
        "a.msh: a 2-D mesh (triangle) in a 3-D scene; set dimension = 2 in [mesh], "
        "or mesh with gmsh -3 and put the bed into a Physical Volume"
    )
    tetra = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    assert "a 3-D mesh (tetra) in a 2-D scene; set dimension = 3" in only_problem(
        tetra, [(TETRA, 5, (1, 2, 3, 4))]
    )


def test_axisymmetric_needs_two_dimensions(only_problem):
    assert "axisymmetric needs dimension = 2, found 3" in only_problem(
        dimension=3, axisymmetric=True
    )


def test_planes(only_problem):
    tilted = [(x, y, 0.5 * x) for x, y, _ in UNIT]
    assert "varies along x, y, z" in only_problem(tilted)
    assert "lies in the x-z plane" in only_problem([(x, 0, y) for x, y, _ in UNIT])


def test_nan(only_problem):
    assert "1 of 4 nodes have nan" in only_problem([*UNIT[:3], (0, "nan", 0)])


def test_mixed_and_unsupported_cells(only_problem):
    points = [*UNIT, (2, 0, 0)]
    assert "quad and triangle" in only_problem(
        points, [(QUAD, 5, (1, 2, 3, 4)), (TRIANGLE, 5, (2, 5, 3))]
    )
    prism = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (0, 1))]
    assert "cells of type wedge" in only_problem(
        prism, [(PRISM, 5, (1, 2, 3, 4, 5, 6))], dimension=3
    )


def test_second_order(only_problem):
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.5, 0, 0), (0.5, 0.5, 0), (0, 0.5, 0)]
    line = only_problem(points, [(9, 5, (1, 2, 3, 4, 5, 6))])
    assert "triangle6" in line and "Mesh.ElementOrder = 1" in line


def test_degenerate_and_inverted_cells(only_problem):
    flat = [*SQUARE, (TRIANGLE, 5, (1, 2, 5))]
    line = only_problem([*UNIT, (0.5, 0, 0)], flat)
    assert "1 of 3 cells are degenerate or inverted, the first at (0.5, 0) m" in line
    bow = [(LINE, 1, (1, 2)), (QUAD, 5, (1, 2, 4, 3))]
    assert (
        "1 of 1 cells are degenerate or inverted, the first at (0.5, 0.5) m"
        in only_problem(elements=bow)
    )
    # the diagonal bends over the corner (1, 1), so that the second triangle lies on the
    # first
    folded = [*SIDES, (TRIANGLE, 5, (1, 2, 3)), (TRIANGLE, 5, (1, 3, 4))]
    assert "cells overlap at 1 facets, the first at (0.5, 0.5) m" in only_problem(
        [*UNIT[:3], (0.9, 0.5, 0)], folded
    )


def test_cells_given_twice(only_problem):
    assert "1 cells are in the file more than once" in only_problem(
        elements=[*SQUARE, (TRIANGLE, 6, (3, 2, 1))]
    )


def test_negative_radius(only_problem):
    left = [(x - 0.25, y, z) for x, y, z in UNIT]
    assert "2 of 4 nodes have r < 0, down to -0.25 m" in only_problem(
        left, axisymmetric=True
    )


def test_exterior_facets_without_or_with_two_groups(tmp_path):
    write(tmp_path / "a.msh", elements=[*SQUARE[1:], (LINE, 2, (3, 4))])
    empty, alone, shared = problems(tmp_path / "a.msh")
    assert (
        "boundary 'bottom' has facets that belong to no cell, or none at all" in empty
    )
    assert (
        "1 of 4 exterior facets are in no Physical Curve, the first at (0.5, 0) m"
        in alone
    )
    assert (
        "1 facets are in more than one Physical Curve, the first at (0.5, 1) m in "
        "'right', 'top'" in shared
    )


def test_boundary_inside_the_bed(only_problem):
    assert (
        "1 of 2 facets of boundary 'bottom' are inside the bed, the first at (0.5, "
        "0.5) m" in only_problem(elements=[*SQUARE, (LINE, 1, (1, 3))])
    )


def test_regions_must_cover_the_cells(only_problem):
    line = only_problem(elements=[*SQUARE[:-1], (TRIANGLE, 0, (1, 3, 4))])
    assert (
        "1 of 2 cells are in no Physical Surface, the first at (0.333333, 0.666667) m"
        in line
    )
    assert "region 'ghost' has no cells" in only_problem(
        names={**NAMES, (2, 9): "ghost"}
    )


def test_node_outside_the_file(only_problem):
    line = only_problem(elements=[*SQUARE[:-1], (TRIANGLE, 5, (1, 3, 9))])
    assert (
        "broken or unsupported mesh" in line or "nodes that are not in the file" in line
    )


def test_both_sides_of_a_duct_with_one_name_are_walls(tmp_path):
    """Their normals are opposite, and the flow passes along both."""
    one = {key: name for key, name in NAMES.items() if name != "top"} | {
        (1, 1): "walls"
    }
    sides = [(LINE, 1, (1, 2)), (LINE, 2, (2, 3)), (LINE, 1, (3, 4)), (LINE, 4, (4, 1))]
    write(tmp_path / "duct.msh", elements=[*sides, *SQUARE[4:]], names=one)
    mesh = load(tmp_path / "duct.msh")
    assert passes_along(mesh, "walls", np.array([0.5, 0.0]))
    assert not passes_along(mesh, "walls", np.array([0.5, 1e-6]))
    assert not passes_along(mesh, "right", np.array([0.5, 0.0]))
