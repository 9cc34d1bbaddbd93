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

    type: str
    length: Length = Field(
        description="length of the domain along x, for axisymmetric meshes along the "
        "axis"
    )
    graded: Switch = Field(
        False,
        description="grade the given number of cells to the layer widths; uniform "
        "otherwise",
    )
    refine: Whole = Field(
        0,
        ge=0,
        le=12,
        description="number of uniform refinements, each halves all cells",
    )


class MeshLine(_BuiltIn):
    """A bed along x from 0 to `length`; boundaries `left`, `right`."""

    dimension: ClassVar[int] = 1
    sides: ClassVar = (("left", "right"),)
    type: Literal["line"] = Field(description="built-in mesh of a line, along the flow")
    cells: Cells | None = Field(
        None,
        description="number of cells; automatic grading to the layer widths if absent",
    )
    diameter: Length | None = Field(
        None,
        description="inner diameter of a tube, distance of two walls, or side of a "
        "duct; needed with [boundary.wall]; absent: no wall",
    )

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
    type: Literal["rectangle"] = Field(description="built-in mesh of a rectangle")
    height: Length = Field(description="height of the domain along y")
    cells: tuple[Cells, Cells] | None = Field(
        None, description="number of cells along x and y; absent: chosen by the plan"
    )
    shape: Literal["triangle", "quadrilateral"] = Field(
        "quadrilateral", description="shape of the cells"
    )

    @property
    def extents(self) -> tuple[float, ...]:
        """Size in each direction [m], in the order of `sides`."""
        return (self.length, self.height)


class MeshAxisymmetric(_BuiltIn):
    """A cylinder in (r, z), z along `length`; boundaries `axis`, `wall`, `bottom`,
    `top`.
    """

    dimension: ClassVar[int] = 2
    sides: ClassVar = (("axis", "wall"), ("bottom", "top"))
    type: Literal["axisymmetric"] = Field(
        description="built-in mesh of a cylinder with axial symmetry"
    )
    radius: Length = Field(description="radius of the domain")
    cells: tuple[Cells, Cells] | None = Field(
        None, description="cells along r and along z"
    )
    shape: Literal["triangle", "quadrilateral"] = Field(
        "quadrilateral", description="shape of the cells"
    )

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
    type: Literal["box"] = Field(description="built-in mesh of a box")
    width: Length = Field(description="width of the domain along y")
    height: Length = Field(description="height of the domain along z")
    cells: tuple[Cells, Cells, Cells] | None = Field(
        None, description="number of cells along x, y and z; absent: chosen by the plan"
    )
    shape: Literal["tetrahedron", "hexahedron"] = Field(
        "hexahedron", description="shape of the cells"
    )

    @property
    def extents(self) -> tuple[float, ...]:
        """Size in each direction [m], in the order of `sides`."""
        return (self.length, self.width, self.height)


class MeshFile(Table):
    """A gmsh geometry (.geo, meshed by gmsh) or a mesh (.msh); physical groups name
    regions and boundaries.
    """

    type: Literal["file"] = Field(description="mesh or geometry from a file")
    file: str = Field(description="path relative to the scene")
    dimension: Order = Field(2, description="dimension of the mesh")
    axisymmetric: Switch = Field(False, description="coordinates are (r, z)")
    scale: Positive = Field(
        1.0, description="factor from the file's length unit to metres"
    )
    size: Length | None = Field(
        None, description="target cell size for a .geo; its own sizes if absent"
    )
    refine: Whole = Field(
        0,
        ge=0,
        le=8,
        description="number of uniform refinements, each halves all cells",
    )


def power_units(names: Iterable[str], mesh: Mesh) -> dict[str, str]:
    """Return the unit of each heat, heat flow and exergy among named results: per area
    of section on a line, per depth in a plane.
    """
    round_bed = isinstance(mesh, MeshAxisymmetric) or getattr(
        mesh, "axisymmetric", False
    )
    per = "" if round_bed else {1: "/m2", 2: "/m", 3: ""}[mesh.dimension]
    return {
        name: name[-1] + per
        for name in names
        if name == "duty_W" or re.fullmatch("(heat|exergy|storage)_.*_[JW]", name)
    }


Mesh = Annotated[
    MeshLine | MeshRectangle | MeshAxisymmetric | MeshBox | MeshFile,
    Field(discriminator="type"),
]
