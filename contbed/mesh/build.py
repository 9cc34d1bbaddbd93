"""Build the mesh of a scene: line, rectangle, axisymmetric bed or box as tensor
products, or a file of gmsh.

Lengths in m. Every exterior facet belongs to exactly one named boundary and every cell
to exactly one region.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import Any

import numpy as np
import skfem

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.mesh.grading import CELLS_ALONG
from contbed.mesh.mesh import Mesh, refine
from contbed.scene import mesh as settings_mesh
from contbed.scene.mesh import (
    REGION,
    MeshAxisymmetric,
    MeshBox,
    MeshFile,
    MeshLine,
    MeshRectangle,
)
from contbed.scene.toml_lines import Origin

LARGEST_BED = 30.0  # [m]; larger ones are seldom meant
CELLS_ACROSS = 8  # least number of cells across a bed without prescribed cells


def mesh_of(scene: Any, nodes: Sequence[Array] | None = None) -> Mesh:
    """Build the mesh of a scene; mistakes in a file are reported at its key.

    Raises
    ------
    SceneError : the file cannot be used
    """
    settings = scene.mesh
    if not isinstance(settings, MeshFile):
        return build(settings, nodes)
    with scene.origin.blamed("mesh", "file"):
        mesh = build(settings, nodes, str(scene.origin.base))
    size = float(np.ptp(mesh.skfem.p, axis=1).max())
    if size > LARGEST_BED:
        unit, scale = ("millimetres", 1e-3) if size > 1e3 / 8 else ("centimetres", 1e-2)
        scene.remark(
            ("mesh", "file"),
            f"the bed is {size:.4g} m large; if the file is in {unit}, set "
            f"mesh.scale = {scale * settings.scale:g}",
        )
    diameters = [
        d for each in getattr(scene, "solids", {}).values() if (d := each.diameter)
    ]
    if diameters and size < max(diameters):
        scene.remark(
            ("mesh", "file"),
            f"the bed is {size:.4g} m large, less than a particle of "
            f"{max(diameters):.4g} m; see mesh.scale",
        )
    return mesh


def build(
    settings: settings_mesh.Mesh, nodes: Sequence[Array] | None = None, base: str = "."
) -> Mesh:
    """Build the mesh of a scene's [mesh] table, refined `settings.refine` times.

    Parameters
    ----------
    settings : the table
    nodes : node coordinates along each direction [m], from 0 to the full extent,
        instead of the table's cells
    base : folder that a file name is relative to

    Raises
    ------
    SceneError : the file cannot be used; one line for each problem
    """
    if isinstance(settings, MeshFile):
        from contbed.mesh import gmsh as mesh_file

        if settings.axisymmetric and settings.dimension != 2:
            problem = f"axisymmetric needs dimension = 2, found {settings.dimension}"
            raise SceneError(f"{settings.file}: {problem}; change one of the two")
        mesh = Mesh(
            mesh_file.read(settings, base),
            settings.axisymmetric,
            1 if settings.axisymmetric else 0,
        )
    else:
        mesh = _tensor(settings, nodes)
    return refine(mesh, settings.refine)


def _tensor(
    settings: MeshLine | MeshRectangle | MeshAxisymmetric | MeshBox,
    nodes: Sequence[Array] | None,
) -> Mesh:
    """Build a tensor-product mesh with its sides named."""
    axisymmetric, axis = False, 0
    if isinstance(settings, MeshLine):
        extent, sides = [settings.length], [("left", "right")]
        make = skfem.MeshLine.init_tensor
    elif isinstance(settings, MeshBox):
        extent = [settings.length, settings.width, settings.height]
        sides = [("left", "right"), ("front", "back"), ("bottom", "top")]
        make = (
            skfem.MeshTet if settings.shape == "tetrahedron" else skfem.MeshHex
        ).init_tensor
    else:
        if isinstance(settings, MeshAxisymmetric):
            axisymmetric, axis = True, 1
            extent, sides = (
                [settings.radius, settings.length],
                [("axis", "wall"), ("bottom", "top")],
            )
        else:
            extent, sides = (
                [settings.length, settings.height],
                [("left", "right"), ("bottom", "top")],
            )
        make = (
            _triangles if settings.shape == "triangle" else skfem.MeshQuad.init_tensor
        )
    if settings.cells is not None:
        cells = np.atleast_1d(settings.cells)
    else:
        # square cells, but a very wide or very flat bed keeps a usable number of them
        cells = np.clip(
            np.rint(CELLS_ALONG * np.array(extent) / extent[axis]),
            CELLS_ACROSS,
            4 * CELLS_ALONG,
        )
        cells[axis] = CELLS_ALONG
    if nodes is None:
        nodes = [
            np.linspace(0.0, size, int(n) + 1)
            for size, n in zip(extent, cells, strict=True)
        ]
    mesh = make(*nodes)
    exterior = mesh.boundary_facets()
    points = mesh.p[:, mesh.facets[:, exterior]]
    named = {
        name: exterior[(points[d] == end).all(axis=0)]
        for d, pair in enumerate(sides)
        for name, end in zip(pair, (nodes[d][0], nodes[d][-1]), strict=True)
    }
    return Mesh(
        replace(
            mesh, _boundaries=named, _subdomains={REGION: np.arange(mesh.nelements)}
        ),
        axisymmetric,
        axis,
    )


def _triangles(x: Array, y: Array) -> skfem.MeshTri:
    """Halve rectangles along diagonals that leave each corner, so that no cell has
    two exterior sides there.
    """
    quads = skfem.MeshQuad.init_tensor(x, y)
    centre = quads.p[:, quads.t].mean(axis=1)
    rising = (centre[0] < x[(len(x) - 1) // 2]) == (centre[1] < y[(len(y) - 1) // 2])
    a, b, c, d = np.where(rising, quads.t, np.roll(quads.t, -1, axis=0))
    return skfem.MeshTri(quads.p, np.hstack(([a, b, c], [a, c, d])))


def moved(mesh: Mesh, former: settings_mesh.Mesh, settings: settings_mesh.Mesh) -> Mesh:
    """Return a mesh of the same cells whose nodes have moved with the lengths of the
    bed, `former` to `settings`.
    """
    if isinstance(settings, MeshFile) or isinstance(former, MeshFile):
        factors = np.full(
            mesh.skfem.dim(),
            getattr(settings, "scale", 1.0) / getattr(former, "scale", 1.0),
        )
    else:
        factors = np.array(settings.extents) / np.array(former.extents)
    if (factors == 1.0).all():
        return mesh
    return replace(
        mesh, skfem=replace(mesh.skfem, doflocs=mesh.skfem.doflocs * factors[:, None])
    )


def require_names(
    origin: Origin, mesh: Mesh, named: Mapping[str, Iterable[str]]
) -> None:
    """Raise SceneError for a boundary or region that a scene names and the mesh,
    known only now, does not have.
    """
    problems = []
    for kind, known in (("boundary", mesh.boundaries), ("region", mesh.regions)):
        for name in named.get(kind, ()):
            if name not in known:
                near = get_close_matches(name, known, n=1)
                hint = f"; did you mean '{near[0]}'?" if near else ""
                if all(each.startswith(f"{kind}_") for each in known):
                    hint += (
                        "; the file names none: name Physical groups in gmsh, or use "
                        "these names"
                    )
                where = origin.at((kind, name))
                problems.append(
                    f"{where}: {kind}.{name}: the mesh has no such {kind}; it has "
                    f"{', '.join(known)}{hint}"
                )
    if problems:
        raise SceneError(problems)
