"""Small unstructured meshes by gmsh, as grids: rectangles, cylinders in (r, z) and
boxes of every shape of cell.
"""

import tempfile
from functools import cache
from pathlib import Path

from contbed.mesh import build as meshing
from contbed.scene.mesh import MeshFile
from contbed.two_fluid.boundary import symmetry
from contbed.two_fluid.fv import grid

IN_3D = ("hexahedra", "tetrahedra")
KINDS = (
    "quadrilaterals",
    "triangles",
    "axisymmetric_quadrilaterals",
    "axisymmetric_triangles",
    *IN_3D,
)
PLANE = """
Point(1) = {{0, 0, 0, {size}}};
Point(2) = {{{length}, 0, 0, {size}}};
Point(3) = {{{length}, {width}, 0, {size}}};
Point(4) = {{0, {width}, 0, {size}}};
Line(1) = {{1, 2}};
Line(2) = {{2, 3}};
Line(3) = {{3, 4}};
Line(4) = {{4, 1}};
Curve Loop(1) = {{1, 2, 3, 4}};
Plane Surface(1) = {{1}};
Periodic Curve {{2}} = {{-4}} Translate {{{length}, 0, 0}};
Periodic Curve {{3}} = {{-1}} Translate {{0, {width}, 0}};
"""
QUADRILATERALS = """
Recombine Surface {1};
Mesh.SubdivisionAlgorithm = 1;
"""
NAMES = """
Physical Curve("bottom", 1) = {{1}};
Physical Curve("{right}", 2) = {{2}};
Physical Curve("top", 3) = {{3}};
Physical Curve("{left}", 4) = {{4}};
Physical Surface("bed", 5) = {{1}};
"""
BOX = """
sides[] = Extrude {{0, 0, {height}}} {{ Surface{{1}}; {layers} }};
Physical Surface("bottom", 1) = {{1}};
Physical Surface("top", 2) = {{sides[0]}};
Physical Surface("front", 3) = {{sides[2]}};
Physical Surface("right", 4) = {{sides[3]}};
Physical Surface("back", 5) = {{sides[4]}};
Physical Surface("left", 6) = {{sides[5]}};
Physical Volume("bed", 7) = {{sides[1]}};
"""
SAME_SIDES = """
Periodic Surface {{sides[3]}} = {{sides[5]}} Translate {{{length}, 0, 0}};
Periodic Surface {{sides[4]}} = {{sides[2]}} Translate {{0, {width}, 0}};
Periodic Surface {{sides[0]}} = {{1}} Translate {{0, 0, {height}}};
"""


def geometry(kind, length, height, size):
    """Text of a .geo; in 3-D the section is a square and cells of `size` stand on
    it.
    """
    # each quadrilateral is cut into four
    hexahedra, whole = (
        kind == "hexahedra",
        size if kind.endswith(("triangles", "tetrahedra")) else 2 * size,
    )
    plane = PLANE.format(
        length=length, width=length if kind in IN_3D else height, size=whole
    )
    if kind not in IN_3D:
        left, right = (
            ("axis", "wall") if kind.startswith("axisymmetric") else ("left", "right")
        )
        return (
            plane
            + ("" if kind.endswith("triangles") else QUADRILATERALS)
            + NAMES.format(left=left, right=right)
        )
    layers = f"Layers{{{round(0.5 * height / size)}}}; Recombine;" if hexahedra else ""
    text = (
        plane
        + (QUADRILATERALS if hexahedra else "")
        + BOX.format(height=height, layers=layers)
    )
    return text + (
        ""
        if hexahedra
        else SAME_SIDES.format(length=length, width=length, height=height)
    )


@cache
def mesh(kind, length, height, size):
    """The mesh of a kind."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "bed.geo").write_text(geometry(kind, length, height, size))
        table = MeshFile(
            type="file",
            file="bed.geo",
            dimension=3 if kind in IN_3D else 2,
            axisymmetric=kind.startswith("axisymmetric"),
        )
        return meshing.build(table, base=folder)


def unstructured(kind, length, height, size, periodic=()):
    """The grid of a kind."""
    return grid.build(mesh(kind, length, height, size), periodic)


def sides(on, wall, **others):
    """A condition for each boundary: `others` by name, slip on the axis, `wall` on
    the rest.
    """
    return {
        name: others.get(name, symmetry() if name == "axis" else wall)
        for name in on.boundaries
    }
