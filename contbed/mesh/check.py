"""Assembly of a scikit-fem mesh from the parts of a mesh file (points, cells, physical
groups), with checks.

Nothing is repaired except the orientation of cells and nodes that no cell uses.
Problems are counted and located; as many problems of a file as make sense together are
reported at once.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace

import numpy as np
import skfem

from contbed.errors import SceneError
from contbed.mesh.mesh import find_facets
from contbed.scene.mesh import REGION, MeshFile

MESHES = {
    "line": skfem.MeshLine,
    "triangle": skfem.MeshTri,
    "quad": skfem.MeshQuad,
    "tetra": skfem.MeshTet,
    "hexahedron": skfem.MeshHex,
}
# gmsh's node order: each corner with its neighbours, right-handed in a positively
# oriented cell
CORNERS = {
    "line": [[0, 1]],
    "triangle": [[0, 1, 2]],
    "quad": [[0, 1, 3], [1, 2, 0], [2, 3, 1], [3, 0, 2]],
    "tetra": [[0, 1, 2, 3]],
    "hexahedron": [[0, 1, 3, 4], [1, 2, 0, 5], [2, 3, 1, 6], [3, 0, 2, 7],
                   [4, 7, 5, 0], [5, 4, 6, 1], [6, 5, 7, 2], [7, 6, 4, 3]],
}  # fmt: skip
MIRROR = {
    "line": [1, 0],
    "triangle": [0, 2, 1],
    "quad": [0, 3, 2, 1],
    "tetra": [0, 2, 1, 3],
    "hexahedron": [4, 5, 6, 7, 0, 1, 2, 3],
}
HEXAHEDRON_TO_SKFEM = [0, 1, 3, 4, 2, 5, 7, 6]
GROUP = ["Physical Point", "Physical Curve", "Physical Surface", "Physical Volume"]
AT_ONCE = 20_000  # cells whose corners are in memory
# sine of the angle at a corner; round-off of a flat corner is some 1e-16, thin layers
# have 1e-9
FLAT = 1e-13


@dataclass
class Cells:
    """The cells of one dimension: types, nodes by type, and row numbers by physical
    group.
    """

    nodes: dict[str, list[np.ndarray]] = field(
        default_factory=lambda: defaultdict(list)
    )
    groups: dict[str, list[np.ndarray]] = field(
        default_factory=lambda: defaultdict(list)
    )

    def rows(self, kind: str) -> np.ndarray:
        """Return the nodes of all cells of one type, (n, nodes of a cell)."""
        return np.vstack(self.nodes[kind])

    def group(self, name: str) -> np.ndarray:
        """Return the row numbers of one physical group."""
        return np.unique(np.concatenate([np.array([], dtype=int), *self.groups[name]]))


def assemble(
    settings: MeshFile, points: np.ndarray, cells: dict[int, Cells]
) -> skfem.Mesh:
    """Build and check the mesh from the parts of a file; stop at a problem that
    makes later checks meaningless.
    """
    file, dim = settings.file, settings.dimension
    kind = _cell_type(settings, cells)
    nodes = cells[dim].rows(kind)
    if nodes.min() < 0 or nodes.max() >= len(points):
        raise SceneError(
            f"{file}: cells refer to nodes that are not in the file; write it again "
            "with gmsh"
        )
    used, inverse = np.unique(nodes, return_inverse=True)
    nodes = inverse.reshape(nodes.shape)
    x = points[used] * settings.scale
    lost = np.flatnonzero(~np.isfinite(x).all(axis=1))
    if len(lost):
        found = f"{len(lost)} of {len(x)} nodes have nan or infinite coordinates"
        raise SceneError(
            f"{file}: {found}, the first is number {used[lost[0]] + 1}; write the mesh "
            "again"
        )
    x = _in_plane(file, x, dim)
    problems = []
    if settings.axisymmetric:
        tolerance = 1e-12 * np.ptp(x, axis=0).max()
        negative = np.count_nonzero(x[:, 0] < -tolerance)
        if negative:
            found = (
                f"{negative} of {len(x)} nodes have r < 0, down to "
                f"{x[:, 0].min():.6g} m"
            )
            problems.append(
                f"{file}: {found}; the axis is x = 0, mesh the half with x >= 0"
            )
        x[np.abs(x[:, 0]) <= tolerance, 0] = 0.0
    nodes, flat = _orient(x, nodes, kind)
    if len(flat):
        found = (
            f"{len(flat)} of {len(nodes)} cells are degenerate or inverted, the "
            f"first at {_at(x[nodes[flat[0]]])}"
        )
        problems.append(
            f"{file}: {found}; mesh again, and look for duplicate points or crossing "
            "curves"
        )
    _, first, copies = np.unique(
        np.sort(nodes, axis=1), axis=0, return_index=True, return_counts=True
    )
    twice = first[copies > 1]
    if len(twice):
        found = (
            f"{len(twice)} cells are in the file more than once, the first at "
            f"{_at(x[nodes[twice[0]]])}"
        )
        problems.append(f"{file}: {found}; each cell belongs to one {GROUP[dim]}")
    ordered = nodes[:, HEXAHEDRON_TO_SKFEM] if kind == "hexahedron" else nodes
    mesh = MESHES[kind](np.ascontiguousarray(x.T), np.ascontiguousarray(ordered.T))
    if not len(flat) and not len(twice):
        problems += _overlaps(file, mesh)
    if problems:
        raise SceneError(problems)

    regions, region_of, problems = _regions(file, mesh, cells[dim], dim)
    position = np.full(len(points), -1)
    position[used] = np.arange(len(used))
    boundaries, more = _boundaries(file, mesh, cells[dim - 1], position, region_of)
    if problems + more:
        raise SceneError(problems + more)
    return replace(mesh, _boundaries=boundaries, _subdomains=regions)


def _at(points: np.ndarray) -> str:
    """Return the centre of points (n, d) as text."""
    return f"({', '.join(f'{c:.6g}' for c in points.mean(axis=0))}) m"


def _cell_type(settings: MeshFile, cells: dict[int, Cells]) -> str:
    """Return the one type of the cells that make the mesh."""
    file, dim = settings.file, settings.dimension
    found = max((d for d in cells if cells[d].nodes), default=0)
    types = sorted(cells[found].nodes) if found else []
    if not types:
        raise SceneError(
            f"{file}: holds no cells; put the bed into a {GROUP[dim]} and mesh it with "
            f"gmsh -{dim}"
        )
    curved = [
        name
        for name in types
        if name not in MESHES and name.rstrip("0123456789") in MESHES
    ]
    if curved:
        raise SceneError(
            f"{file}: cells of second or higher order ({', '.join(curved)}); set "
            "Mesh.ElementOrder = 1 and mesh again"
        )
    if found != dim:
        change = f"set dimension = {found} in [mesh]"
        if found > dim:
            change += f", or mesh a {dim}-D geometry"
        else:
            change += f", or mesh with gmsh -{dim} and put the bed into a {GROUP[dim]}"
        raise SceneError(
            f"{file}: a {found}-D mesh ({', '.join(types)}) in a {dim}-D scene; "
            f"{change}"
        )
    if len(types) > 1 or types[0] not in MESHES:
        raise SceneError(
            f"{file}: cells of type {' and '.join(types)}; use one of triangle, quad, "
            "tetra, hexahedron "
            "throughout (Recombine all surfaces or none)"
        )
    return types[0]


def _in_plane(file: str, x: np.ndarray, dim: int) -> np.ndarray:
    """Return the first `dim` coordinates; the others must be constant."""
    extent = np.ptp(x, axis=0)
    varies = "".join(
        name
        for name, size in zip("xyz", extent, strict=True)
        if size > 1e-9 * extent.max()
    )
    if set(varies) <= set("xyz"[:dim]):
        return x[:, :dim].copy()
    wanted = (
        "the x-y plane (z constant)" if dim == 2 else "the x axis (y and z constant)"
    )
    where = (
        f"lies in the {varies[0]}-{varies[1]} plane"
        if len(varies) == 2
        else f"varies along {', '.join(varies)}"
    )
    sizes = ", ".join(f"{size:.6g}" for size in extent)
    raise SceneError(
        f"{file}: a {dim}-D mesh must lie in {wanted}, this one {where}, extents "
        f"({sizes}) m; "
        "rotate or flatten the geometry"
    )


def _orient(
    x: np.ndarray, nodes: np.ndarray, kind: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes of the cells in positive orientation, and the numbers of
    cells that have none.
    """
    negative, positive = (np.empty(len(nodes), dtype=np.bool_) for _ in range(2))
    for first in range(0, len(nodes), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        corners = x[nodes[some][:, CORNERS[kind]]]
        edges = corners[:, :, 1:] - corners[:, :, :1]
        lengths = np.linalg.norm(edges, axis=-1, keepdims=True)
        sine = np.linalg.det(edges / np.where(lengths > 0, lengths, 1.0))
        negative[some], positive[some] = (
            (sine < -FLAT).all(axis=1),
            (sine > FLAT).all(axis=1),
        )
    return np.where(negative[:, None], nodes[:, MIRROR[kind]], nodes), np.flatnonzero(
        ~negative & ~positive
    )


def _overlaps(file: str, mesh: skfem.Mesh) -> list[str]:
    """Find facets with more than two cells, or with both cells on one side."""
    p, facets = mesh.p, mesh.facets
    count = np.bincount(mesh.t2f.ravel(), minlength=facets.shape[1])
    inside = np.flatnonzero(count == 2)
    origin, *others = p[:, facets[:, inside]].swapaxes(0, 1)
    if mesh.dim() == 1:
        normal = np.ones_like(origin)
    elif mesh.dim() == 2:
        normal = np.array([origin[1] - others[0][1], others[0][0] - origin[0]])
    else:
        normal = np.cross(others[0] - origin, others[1] - origin, axis=0)
    centres = p[:, mesh.t].mean(axis=1)
    one, two = (
        np.sum(normal * (centres[:, mesh.f2t[i, inside]] - origin), axis=0) > 0
        for i in (0, 1)
    )
    wrong = np.concatenate((np.flatnonzero(count > 2), inside[one == two]))
    if not len(wrong):
        return []
    found = (
        f"cells overlap at {len(wrong)} facets, the first at "
        f"{_at(p[:, facets[:, wrong[0]]].T)}"
    )
    return [
        f"{file}: {found}; some are folded over (inverted) or belong to overlapping "
        "parts, mesh again"
    ]


def _regions(
    file: str, mesh: skfem.Mesh, cells: Cells, dim: int
) -> tuple[dict[str, np.ndarray], np.ndarray, list[str]]:
    """Return the cells by region, the region number by cell, and problems."""
    named = {name: cells.group(name) for name in cells.groups} or {
        REGION: np.arange(mesh.nelements)
    }
    region_of, owners = np.full(mesh.nelements, -1), np.zeros(mesh.nelements, dtype=int)
    for number, rows in enumerate(named.values()):
        region_of[rows] = number
        owners[rows] += 1
    empty = [name for name, rows in named.items() if not len(rows)]
    problems = [
        f"{file}: region {name!r} has no cells; remove its {GROUP[dim]}"
        for name in empty
    ]
    for text, wrong in {"no": owners == 0, "more than one": owners > 1}.items():
        if wrong.any():
            first = _at(mesh.p[:, mesh.t[:, np.flatnonzero(wrong)[0]]].T)
            found = (
                f"{np.count_nonzero(wrong)} of {mesh.nelements} cells are in "
                f"{text} {GROUP[dim]}"
            )
            problems.append(
                f"{file}: {found}, the first at {first}; put each cell into one"
            )
    return named, region_of, problems


def _boundaries(
    file: str,
    mesh: skfem.Mesh,
    cells: Cells,
    position: np.ndarray,
    region_of: np.ndarray,
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Return the exterior facets by boundary, and problems.

    `position` is the mesh's number of each node of the file.
    """
    group, problems = GROUP[mesh.dim() - 1], []
    exterior = mesh.f2t[1] == -1
    interface = ~exterior & (region_of[mesh.f2t[0]] != region_of[mesh.f2t[1]])
    named: dict[str, np.ndarray] = {}
    owners = np.zeros(mesh.facets.shape[1], dtype=int)
    facet_of_row = np.array([], dtype=int)
    if cells.nodes:
        (kind,) = cells.nodes
        facet_of_row = find_facets(mesh, position[cells.rows(kind)].T)
    for name in cells.groups:
        facets = np.unique(facet_of_row[cells.group(name)])
        astray, facets = np.count_nonzero(facets == -1), facets[facets >= 0]
        inner = facets[~exterior[facets] & ~interface[facets]]
        if astray or not len(facets):
            problems.append(
                f"{file}: boundary {name!r} has facets that belong to no cell, or none "
                "at all; "
                f"remove its {group} or mesh again"
            )
        if len(inner):
            where = _at(mesh.p[:, mesh.facets[:, inner[0]]].T)
            problems.append(
                f"{file}: {len(inner)} of {len(facets)} facets of boundary {name!r} "
                "are inside the bed, the "
                f"first at {where}; a boundary lies on the exterior or between two "
                "regions"
            )
        if exterior[facets].any():
            named[name] = facets[exterior[facets]]
            owners[named[name]] += 1
    alone, shared = np.flatnonzero(exterior & (owners == 0)), np.flatnonzero(owners > 1)
    if len(alone):
        where = _at(mesh.p[:, mesh.facets[:, alone[0]]].T)
        problems.append(
            f"{file}: {len(alone)} of {np.count_nonzero(exterior)} exterior facets are "
            f"in no {group}, the "
            f"first at {where}; name them, or join parts that should share nodes there "
            "(Coherence)"
        )
    if len(shared):
        where = _at(mesh.p[:, mesh.facets[:, shared[0]]].T)
        names = ", ".join(
            repr(name) for name, facets in named.items() if shared[0] in facets
        )
        problems.append(
            f"{file}: {len(shared)} facets are in more than one {group}, the first at "
            f"{where} in {names}; keep one"
        )
    return named, problems
