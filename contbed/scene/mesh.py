"""The [mesh] table of a scene, one model for each type."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from contbed.scene.quantities import (
    Cells,
    Length,
    Order,
    Positive,
    Switch,
    Table,
    Whole,
)

REGION = "bed"  # the only region of a built-in mesh
SIDE = "wall"  # the boundary beside a line, of a bed with a diameter


class _BuiltIn(Table):
    """A mesh of a bed of simple shape."""

    axis: ClassVar[int] = 0  # direction of `length`
    type: str
    length: Length
    """length of the domain along x, for axisymmetric meshes along the axis"""
    graded: Switch = False
    """grade the given number of cells to the layer widths; uniform otherwise"""
    refine: Whole = Field(0, ge=0, le=12)
    """number of uniform refinements, each halves all cells"""


class MeshLine(_BuiltIn):
    """A bed along x from 0 to `length`; boundaries `left`, `right`."""

    dimension: ClassVar[int] = 1
    sides: ClassVar = (("left", "right"),)
    type: Literal["line"]
    """built-in mesh of a line, along the flow"""
    cells: Cells | None = None
    """number of cells; automatic grading to the layer widths if absent"""
    diameter: Length | None = None
    """inner diameter of a tube, distance of two walls, or side of a duct; needed with
    [boundary.wall]; absent: no wall"""

    @property
    def extents(self) -> tuple[float, ...]:
        """Size in each direction [m], in the order of `sides`."""
        return (self.length,)


class MeshRectangle(_BuiltIn):
    """A planar channel, x along `length`, y along `height`; boundaries `left`,
    `right`, `bottom`, `top`.
    """

    dimension: ClassVar[int] = 2
    sides: ClassVar = (("left", "right"), ("bottom", "top"))
    type: Literal["rectangle"]
    """built-in mesh of a rectangle"""
    height: Length
    """height of the domain along y"""
    cells: tuple[Cells, Cells] | None = None
    """number of cells along x and y; absent: chosen by the plan"""
    shape: Literal["triangle", "quadrilateral"] = "quadrilateral"
    """shape of the cells"""

    @property
    def extents(self) -> tuple[float, ...]:
        """Size in each direction [m], in the order of `sides`."""
        return (self.length, self.height)


class MeshAxisymmetric(_BuiltIn):
    """A cylinder in (r, z), z along `length`; boundaries `axis`, `wall`, `bottom`,
    `top`.
    """

    axis: ClassVar[int] = 1
    dimension: ClassVar[int] = 2
    sides: ClassVar = (("axis", "wall"), ("bottom", "top"))
    type: Literal["axisymmetric"]
    """built-in mesh of a cylinder with axial symmetry"""
    radius: Length
    """radius of the domain"""
    cells: tuple[Cells, Cells] | None = None
    """cells along r and along z"""
    shape: Literal["triangle", "quadrilateral"] = "quadrilateral"
    """shape of the cells"""

    @property
    def extents(self) -> tuple[float, ...]:
        """Size in each direction [m], in the order of `sides`."""
        return (self.radius, self.length)


class MeshBox(_BuiltIn):
    """A box, x along `length`, y `width`, z `height`; boundaries `left right front
    back bottom top`.
    """

    dimension: ClassVar[int] = 3
    sides: ClassVar = (("left", "right"), ("front", "back"), ("bottom", "top"))
    type: Literal["box"]
    """built-in mesh of a box"""
    width: Length
    """width of the domain along y"""
    height: Length
    """height of the domain along z"""
    cells: tuple[Cells, Cells, Cells] | None = None
    """number of cells along x, y and z; absent: chosen by the plan"""
    shape: Literal["tetrahedron", "hexahedron"] = "hexahedron"
    """shape of the cells"""

    @property
    def extents(self) -> tuple[float, ...]:
        """Size in each direction [m], in the order of `sides`."""
        return (self.length, self.width, self.height)


class MeshFile(Table):
    """A gmsh geometry (.geo, meshed by gmsh) or a mesh (.msh); physical groups name
    regions and boundaries.
    """

    type: Literal["file"]
    """mesh or geometry from a file"""
    file: str
    """path relative to the scene"""
    dimension: Order = 2
    """dimension of the mesh"""
    axisymmetric: Switch = False
    """coordinates are (r, z)"""
    scale: Positive = 1.0
    """factor from the file's length unit to metres"""
    size: Length | None = None
    """target cell size for a .geo; its own sizes if absent"""
    refine: Whole = Field(0, ge=0, le=8)
    """number of uniform refinements, each halves all cells"""


def per_extent(unit: str, mesh: Mesh) -> str:
    """Return the unit of an amount or flow in a bed: per area of section on a line, per
    depth in a plane.
    """
    round_bed = isinstance(mesh, MeshAxisymmetric) or getattr(
        mesh, "axisymmetric", False
    )
    return unit + ("" if round_bed else {1: "/m2", 2: "/m", 3: ""}[mesh.dimension])


def power_units(names: Iterable[str], mesh: Mesh) -> dict[str, str]:
    """Return the unit of each heat, heat flow and exergy among named results, see
    `per_extent`.
    """
    return {
        name: per_extent(name[-1], mesh)
        for name in names
        if name == "duty_W" or re.fullmatch("(heat|exergy|storage)_.*_[JW]", name)
    }


Mesh = Annotated[
    MeshLine | MeshRectangle | MeshAxisymmetric | MeshBox | MeshFile,
    Field(discriminator="type"),
]
