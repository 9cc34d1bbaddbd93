"""Checks of the mesh of a scene and of the names of its boundaries, regions and
positions.
"""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import Any

from contbed.scene.checking import Mistakes, See
from contbed.scene.mesh import REGION, SIDE, Mesh, MeshAxisymmetric, MeshFile, MeshLine
from contbed.scene.tables import FieldOutput, Output
from contbed.scene.toml_lines import Origin


def names_exist(
    mesh: Mesh, boundary: Mapping[str, Any], region: Mapping[str, Any]
) -> Mistakes:
    """Check that a built-in mesh has the boundaries and regions that the scene
    names.
    """
    if isinstance(mesh, MeshFile):
        return
    known = [name for pair in mesh.sides for name in pair if name != "axis"]
    if isinstance(mesh, MeshLine) and mesh.diameter is not None:
        known.append(SIDE)
    for name in boundary:
        if name == "axis" and isinstance(mesh, MeshAxisymmetric):
            yield (
                ("boundary", name),
                "the axis is a line of symmetry and takes no condition; remove this "
                "table",
            )
        elif name not in known:
            text = (
                f"a mesh of type '{mesh.type}' has no such boundary; it has "
                f"{', '.join(known)}"
            )
            if name == SIDE and isinstance(mesh, MeshLine):
                text += ", and with mesh.diameter a wall"
            near = get_close_matches(name.lower(), known, n=1)
            yield (
                ("boundary", name),
                text + (f"; did you mean '{near[0]}'?" if near else ""),
            )
    for name in region:
        if name != REGION:
            yield (
                ("region", name),
                f"a mesh of type '{mesh.type}' has one region, '{REGION}'",
            )


def mesh_file_exists(mesh: Mesh, see: See, origin: Origin) -> Mistakes:
    """Check that the mesh file exists and that its keys agree with its type."""
    if not isinstance(mesh, MeshFile):
        return
    path = origin.base / mesh.file
    suffix = path.suffix.lower()
    if suffix not in (".geo", ".msh"):
        yield (
            ("mesh", "file"),
            "is neither a gmsh geometry (.geo) nor a gmsh mesh (.msh); gmsh converts "
            f"meshes of other programs: gmsh {path.name} -save -o {path.stem}.msh",
        )
    elif "\0" in mesh.file or not path.is_file():
        yield ("mesh", "file"), f"no such file; looked for {path.absolute()}"
    if suffix == ".msh" and mesh.size is not None:
        yield (
            ("mesh", "size"),
            f"is for a .geo; a .msh has its cells already; see {see('mesh.file')}",
        )
    if mesh.axisymmetric and mesh.dimension != 2:
        yield (
            ("mesh", "axisymmetric"),
            f"an axisymmetric mesh has 2 dimensions; see {see('mesh.dimension')}",
        )


def axis_of(mesh: Mesh) -> int:
    """Return the direction along which a bed is long where no stream determines it."""
    return 0 if isinstance(mesh, MeshFile) else mesh.axis


def positions_lie_in_the_bed(mesh: Mesh, output: Output, see: See) -> Mistakes:
    """Check that the output positions lie within a built-in mesh."""
    yield from positions_along(mesh, output, see, axis_of(mesh))


def positions_outside(output: Output, length: float, where: str) -> Mistakes:
    """Find output positions outside of a bed of a length [m], which is given at
    `where`.
    """
    for index, position in enumerate(output.positions):
        if not 0 <= position <= length:
            text = f"outside of the bed, 0 to {length:g} m; see {where}"
            yield ("output", "positions", index), text


def the_line_of_profiles_fits_the_mesh(
    mesh: Mesh, output: FieldOutput, see: See
) -> Mistakes:
    """Find coordinates of output.across that are too many, too few, or outside of a
    built-in mesh.
    """
    yield from places_across(mesh, output, see, axis_of(mesh))


def positions_along(mesh: Mesh, output: Output, see: See, axis: int) -> Mistakes:
    """Find output positions outside of a built-in mesh along an axis."""
    if isinstance(mesh, MeshFile):
        return
    extent = mesh.extents[axis]
    key = "mesh.length" if extent == mesh.length else "mesh.type"
    yield from positions_outside(output, extent, see(key))


def places_across(mesh: Mesh, output: FieldOutput, see: See, axis: int) -> Mistakes:
    """Find coordinates of output.across that do not fit across an axis."""
    if output.across is None:
        return
    path = ("output", "across")
    if mesh.dimension == 1:
        yield path, "a mesh along a line has no other coordinate; remove the key"
    elif len(output.across) != mesh.dimension - 1:
        yield (
            path,
            f"has {len(output.across)} coordinates, the mesh needs "
            f"{mesh.dimension - 1}; see {see('mesh.type')}",
        )
    elif not isinstance(mesh, MeshFile):
        extents = [extent for k, extent in enumerate(mesh.extents) if k != axis]
        for index, (place, extent) in enumerate(
            zip(output.across, extents, strict=True)
        ):
            if not 0 <= place <= extent:
                yield (
                    (*path, index),
                    f"outside of the bed, 0 to {extent:g} m; see {see('mesh.type')}",
                )


def boundaries_exist(mesh: Mesh, boundary: Mapping[str, Any]) -> Mistakes:
    """Check that a built-in mesh has the boundaries that the scene names, of a line
    both ends.
    """
    if isinstance(mesh, MeshLine) and mesh.diameter is not None:
        yield ("mesh", "diameter"), "has no meaning in a layer without walls; remove it"
    yield from names_exist(mesh, boundary, {})
