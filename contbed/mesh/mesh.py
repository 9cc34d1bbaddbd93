"""Meshes with names: line, rectangle, axisymmetric, box and gmsh files as scikit-fem meshes, refinement and grading.

Lengths in m. Every exterior facet belongs to exactly one named boundary and every cell to exactly one region.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import skfem

from contbed.errors import SceneError
from contbed.packed_bed import scene as s

REGION = s.REGION
CELLS_ALONG = 40
CELLS_ACROSS = 8
SMOOTH = 3.0  # share of the smooth part of a solution in `equidistributed`, where a layer takes degree + 1


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh, its names and its coordinates; first-order geometry.

    Parameters
    ----------
    skfem : mesh with `boundaries` (exterior facets by name) and `subdomains` (cells by region)
    axisymmetric : coordinates are (r, z) with r >= 0
    axis : index of the bed axis coordinate
    engine : what assembles and solves on it, one of `contbed.fem.ENGINES`
    """

    skfem: skfem.Mesh
    axisymmetric: bool = False
    axis: int = 0
    engine: str = "skfem"

    @property
    def boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries."""
        return tuple(self.skfem.boundaries)

    @property
    def regions(self) -> tuple[str, ...]:
        """Names of the regions."""
        return tuple(self.skfem.subdomains)

    def measure(self, boundary: str | None = None) -> float:
        """Size of the mesh, or of one boundary.

        Returns
        -------
        length [m], area [m2] or volume [m3] by dimension, one less for a boundary (1 for the end of a line);
        with the weight 2 pi r when axisymmetric
        """
        # order 4 is exact: a trilinear map has a determinant of degree 2 in each direction, and r adds one in 2-D
        if boundary is None:
            basis = skfem.CellBasis(self.skfem, self.skfem.elem(), intorder=4)
        else:
            facets = self.skfem.boundaries[boundary]
            basis = skfem.FacetBasis(self.skfem, self.skfem.elem(), facets=facets, intorder=4)
        weight = 2 * np.pi * np.asarray(basis.global_coordinates())[0] if self.axisymmetric else 1.0
        return float(np.sum(basis.dx * weight))


def build(settings: s.Mesh, nodes: Sequence[np.ndarray] | None = None, base: str = ".") -> Mesh:
    """Mesh of a scene's [mesh] table, refined `settings.refine` times.

    Parameters
    ----------
    settings : the table
    nodes : node coordinates along each direction [m], from 0 to the full extent, instead of the table's cells
    base : folder that a file name is relative to

    Raises
    ------
    SceneError : the file cannot be used; one line for each problem
    """
    if isinstance(settings, s.MeshFile):
        from contbed.mesh import gmsh as mesh_file

        if settings.axisymmetric and settings.dimension != 2:
            problem = f"axisymmetric needs dimension = 2, found {settings.dimension}"
            raise SceneError(f"{settings.file}: {problem}; change one of the two")
        mesh = Mesh(mesh_file.read(settings, base), settings.axisymmetric, 1 if settings.axisymmetric else 0)
    else:
        mesh = _tensor(settings, nodes)
    return refine(mesh, settings.refine)


def _tensor(settings: s.MeshLine | s.MeshRectangle | s.MeshAxisymmetric | s.MeshBox, nodes) -> Mesh:
    """Tensor-product mesh with its sides named."""
    axisymmetric, axis = False, 0
    if isinstance(settings, s.MeshLine):
        extent, sides = [settings.length], [("left", "right")]
        make = skfem.MeshLine.init_tensor
    elif isinstance(settings, s.MeshBox):
        extent = [settings.length, settings.width, settings.height]
        sides = [("left", "right"), ("front", "back"), ("bottom", "top")]
        make = (skfem.MeshTet if settings.shape == "tetrahedron" else skfem.MeshHex).init_tensor
    else:
        if isinstance(settings, s.MeshAxisymmetric):
            axisymmetric, axis = True, 1
            extent, sides = [settings.radius, settings.length], [("axis", "wall"), ("bottom", "top")]
        else:
            extent, sides = [settings.length, settings.height], [("left", "right"), ("bottom", "top")]
        make = _triangles if settings.shape == "triangle" else skfem.MeshQuad.init_tensor
    if settings.cells is not None:
        cells = np.atleast_1d(settings.cells)
    else:
        # square cells, but a very wide or very flat bed keeps a usable number of them
        cells = np.clip(np.rint(CELLS_ALONG * np.array(extent) / extent[axis]), CELLS_ACROSS, 4 * CELLS_ALONG)
        cells[axis] = CELLS_ALONG
    if nodes is None:
        nodes = [np.linspace(0.0, size, int(n) + 1) for size, n in zip(extent, cells, strict=True)]
    mesh = make(*nodes)
    exterior = mesh.boundary_facets()
    points = mesh.p[:, mesh.facets[:, exterior]]
    named = {
        name: exterior[(points[d] == end).all(axis=0)]
        for d, pair in enumerate(sides)
        for name, end in zip(pair, (nodes[d][0], nodes[d][-1]), strict=True)
    }
    return Mesh(replace(mesh, _boundaries=named, _subdomains={REGION: np.arange(mesh.nelements)}), axisymmetric, axis)


def _triangles(x: np.ndarray, y: np.ndarray) -> skfem.MeshTri:
    """Rectangles halved along diagonals that leave each corner, so that no cell has two exterior sides there."""
    quads = skfem.MeshQuad.init_tensor(x, y)
    centre = quads.p[:, quads.t].mean(axis=1)
    rising = (centre[0] < x[(len(x) - 1) // 2]) == (centre[1] < y[(len(y) - 1) // 2])
    a, b, c, d = np.where(rising, quads.t, np.roll(quads.t, -1, axis=0))
    return skfem.MeshTri(quads.p, np.hstack(([a, b, c], [a, c, d])))


def refine(mesh: Mesh, times: int = 1) -> Mesh:
    """The mesh with every cell split `times` times into 2, 4 or 8; boundary and region names stay."""
    fine = mesh.skfem
    for _ in range(times):
        fine = _refined(fine)
    return replace(mesh, skfem=fine)


def _refined(old: skfem.Mesh) -> skfem.Mesh:
    """One uniform refinement, with the names that scikit-fem 12 loses or misplaces."""
    # without boundaries scikit-fem does not warn that it loses them in 3-D
    new = old.refined() if old.dim() < 3 else replace(old, _boundaries=None).refined()
    if old.dim() == 1:
        # scikit-fem interleaves the two halves of a line cell but numbers the subdomains as if it did not
        named = {name: np.sort(np.hstack((2 * cells, 2 * cells + 1))) for name, cells in old.subdomains.items()}
        return replace(new, _subdomains=named)
    if old.dim() == 3:
        children = _facet_children(old, new)
        boundaries = {name: np.sort(children[:, facets].ravel()) for name, facets in old.boundaries.items()}
        return replace(new, _boundaries=boundaries)
    return new


def _facet_children(old: skfem.Mesh, new: skfem.Mesh) -> np.ndarray:
    """The four facets of the refined 3-D mesh in each facet of the old one, (4, number of old facets).

    scikit-fem numbers the new nodes: old nodes, middles of edges, and for hexahedra middles of facets.
    """
    middle_of_edge = old.p.shape[1] + old.t2e
    middle_of_facet = old.p.shape[1] + old.edges.shape[1] + old.t2f
    triangles = isinstance(old, skfem.MeshTet)
    children = np.empty((4, old.facets.shape[1]), dtype=np.int64)
    for i, corners in enumerate(old.elem.refdom.facets):
        edges = {j: set(edge) for j, edge in enumerate(old.elem.refdom.edges) if set(edge) <= set(corners)}
        for k, corner in enumerate(corners):
            nodes = [old.t[corner], *(middle_of_edge[j] for j, edge in edges.items() if corner in edge)]
            if not triangles:
                nodes.append(middle_of_facet[i])
            children[k, old.t2f[i]] = find_facets(new, np.array(nodes))
        if triangles:
            children[3, old.t2f[i]] = find_facets(new, middle_of_edge[list(edges)])
    return children


def find_facets(mesh: skfem.Mesh, nodes: np.ndarray) -> np.ndarray:
    """Index of the facet with the given nodes, (nodes of a facet, n) -> (n,); -1 where there is none."""
    count = mesh.facets.shape[1]
    both = np.hstack((np.sort(mesh.facets, axis=0), np.sort(nodes, axis=0)))
    _, rank = np.unique(both, axis=1, return_inverse=True)
    facet_of_rank = np.full(rank.max() + 1, -1)
    facet_of_rank[rank[:count]] = np.arange(count)
    return facet_of_rank[rank[count:]]


def graded(
    length: float,
    layers: Sequence[tuple[float, float]],
    ratio: float = 1.3,
    fraction: float = 0.5,
    coarse: float | None = None,
    scale: float = 1.0,
) -> np.ndarray:
    """Node coordinates that resolve exponential layers e^{-|x - position|/width}.

    The cell size h(x) is the least of `coarse` and of one cone for each layer, and the nodes are equally spaced in
    the integral of dx/h. Cells grow at most by `ratio` away from a layer; where two layers meet at an interior node
    neighbours may differ by 2 `ratio`. A `scale` of 1/n puts n cells into each cell of scale 1.

    Parameters
    ----------
    length : extent [m]
    layers : position and width of each layer [m]; the first cell there is at most `fraction` of the width
    ratio : growth from one cell to the next, > 1
    coarse : largest cell [m]; length/40 if absent
    scale : factor on all cells

    Returns
    -------
    strictly increasing coordinates [m] from 0.0 to `length`, with a node at each layer more than a cell from others

    Raises
    ------
    SceneError : a width below 1e-12 of the length, which round-off cannot resolve
    """
    coarse = length / CELLS_ALONG if coarse is None else min(coarse, length)
    growth = np.log(ratio)
    position, width = np.array(layers, dtype=float).reshape(-1, 2).T
    if np.any(width < 1e-12 * length):
        thin = f"layer of width {width.min():.3g} m in a bed of {length:.3g} m"
        raise SceneError(f"mesh: {thin} is too thin to resolve; check the closures, or give mesh.cells")
    # a cell that starts at a cone's tip and spans one unit of the integral has this length times (ratio-1)/growth
    tip = np.minimum(fraction * width, coarse) * growth / (ratio - 1)

    def size(x: np.ndarray) -> np.ndarray:
        return np.minimum(coarse, np.min(tip + growth * np.abs(x[:, None] - position), axis=1, initial=np.inf))

    # h is linear between these: tips, where two cones cross, where a cone reaches the coarse size
    reach = (coarse - tip) / growth
    cross = (position[:, None] + position) / 2 + (tip - tip[:, None]) / (2 * growth)
    knots = np.concatenate(([0.0, length], position, position - reach, position + reach, cross.ravel()))
    knots = np.unique(knots[(knots >= 0) & (knots <= length)])
    span, h = np.diff(knots), size(knots)
    relative = np.diff(h) / h[:-1]
    flat = np.abs(relative) < 1e-12
    relative[flat] = 1.0
    logarithm = np.log1p(relative)
    cells = span / h[:-1] * np.where(flat, 1.0, logarithm / relative)
    total = np.concatenate(([0.0], np.cumsum(cells)))

    ends = [0.0]
    for tip_total in np.interp(np.unique(position[(position > 0) & (position < length)]), knots, total):
        if tip_total - ends[-1] >= 1 and total[-1] - tip_total >= 1:
            ends.append(tip_total)
    ends.append(total[-1])
    counts = [max(1, round(np.ceil(b - a) / scale)) for a, b in pairwise(ends)]
    spans = zip(ends, ends[1:], counts, strict=False)
    target = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in spans])
    piece = np.clip(np.searchsorted(total, target, side="right") - 1, 0, len(span) - 1)
    part = (target - total[piece]) / cells[piece]
    part = np.where(flat[piece], part, np.expm1(logarithm[piece] * part) / relative[piece])
    return np.append(knots[piece] + span[piece] * part, length)


def equidistributed(length: float, layers: Sequence[tuple[float, float]], cells: int, degree: int = 2) -> np.ndarray:
    """Node coordinates [m] of a given number of cells that share the error of interpolation equally.

    Elements of degree k interpolate e^{-|x - position|/width} with equal errors in all cells of a density
    e^{-|x - position|/(m width)}/width, m = k + 1. Its integral is m however thin the layer is, so that `cells` may be
    few. The densities of all `layers` (position and width [m]) and `SMOOTH`/length for the rest add up.
    """
    position, width = np.array(layers, dtype=float).reshape(-1, 2).T
    reach = (degree + 1) * width

    def count(x: np.ndarray) -> np.ndarray:
        beyond = (x[:, None] - position) / reach
        before = -position / reach
        part = np.sign(before) * np.expm1(-np.abs(before)) - np.sign(beyond) * np.expm1(-np.abs(beyond))
        return SMOOTH * x / length + (degree + 1) * part.sum(axis=1)

    target = np.linspace(0.0, 1.0, cells + 1)[1:-1] * count(np.array([length]))
    low, high = np.zeros(cells - 1), np.full(cells - 1, length)
    for _ in range(60):
        middle = 0.5 * (low + high)
        right = count(middle) < target
        low, high = np.where(right, middle, low), np.where(right, high, middle)
    return np.concatenate(([0.0], 0.5 * (low + high), [length]))
