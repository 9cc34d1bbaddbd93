"""Cells and faces of a mesh as flat lists: who is left and right of a face, areas, normals, weights of gradients.

Cells are numbered so that neighbours are near (reverse Cuthill-McKee), on rectangular grids place by place (rows.py).
Interior faces come first and point from the cell on their left, which has the smaller number, to the cell on their
right; on rectangular grids along their axis. Boundary faces follow and point outwards. A periodic pair is one interior
face. In axisymmetric grids, coordinates (r, z), areas and volumes carry 2 pi r.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import reverse_cuthill_mckee
from skfem.quadrature import get_quadrature

from contbed import threads
from contbed.errors import SceneError
from contbed.mesh.mesh import Mesh
from contbed.two_fluid.fv.halo import WHOLE, Halo
from contbed.two_fluid.fv.rows import Rows, build_rows, numbering, part_of_rows, places

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]

CELLS_AT_ONCE = 20_000  # cells whose maps are in memory


class Geometry(NamedTuple):
    """What the kernels need, for nf faces of which ni are interior, and nc cells.

    left (nf,), right (ni,) : cells of a face
    area (nf,) [m, m2], face_size (nf,) : size of a face with and without the weight 2 pi r
    normal (nf, dim), distance (nf,) : n, and d.n for the vector d from the left centre to the right one or to the face
    non_orthogonal (nf, dim) : n - d/(d.n), the part of the normal that a difference of the two centres misses
    weight (ni,) : of the left value in a linear interpolation to the face
    skew (ni, dim) : from the point that `weight` interpolates to, to the middle of the face
    arm_left (nf, dim), arm_right (ni, dim) : from the centre to the middle of the face
    slope_left (nf, dim), slope_right (ni, dim) : weights of the jump right - left in the least-squares gradients
    gradient_inverse (nc, dim, dim) : makes gradients of the sums over a cell and its neighbours on `skewed` grids
    volume (nc,) [m, m2, m3]
    moment_inverse (nc, dim, dim) : inverse of the sum of face_size n n over the faces of a cell
    radius (nc,) : r of the centre, 0 where the grid is not axisymmetric
    skewed : whether any face needs corrections by `non_orthogonal` or `skew`; then gradients take the faces of
        neighbours, too, as what the few of one flat tetrahedron give is noise
    axes : dim zeros; a tuple, so that its length is known to the compiler
    edge_from, edge_to : first boundary face, and the one after the last; in a part of a rectangular grid, of its cells
    """

    left: np.ndarray
    right: np.ndarray
    area: np.ndarray
    face_size: np.ndarray
    normal: np.ndarray
    distance: np.ndarray
    non_orthogonal: np.ndarray
    weight: np.ndarray
    skew: np.ndarray
    arm_left: np.ndarray
    arm_right: np.ndarray
    slope_left: np.ndarray
    slope_right: np.ndarray
    gradient_inverse: np.ndarray
    volume: np.ndarray
    moment_inverse: np.ndarray
    radius: np.ndarray
    skewed: bool
    axes: tuple[int, ...]
    edge_from: int
    edge_to: int


@dataclass(frozen=True, eq=False)
class Grid:
    """The lists of `geometry`, and what connects them with the mesh.

    cells (nc,) : cell of the mesh behind each cell; a field goes to the mesh by `out[grid.cells] = field`
    centres (nc, dim), middles (nf, dim) : of cells and faces [m]
    boundaries : faces of each named boundary that is not periodic
    regions : cells of each named region
    bandwidth : largest distance of neighbours in the numbering by reverse Cuthill-McKee
    rectangular : whether the grid has rows
    places (nc, dim) : of the cells on the lattice of a rectangular grid that no periodic pair closes, else None
    halo : cells that other ranks own
    """

    geometry: Geometry
    cells: np.ndarray
    centres: np.ndarray
    middles: np.ndarray
    boundaries: dict[str, np.ndarray]
    regions: dict[str, np.ndarray]
    axisymmetric: bool
    bandwidth: int
    rectangular: bool
    places: np.ndarray | None
    halo: Halo = WHOLE

    @property
    def dimension(self) -> int:
        """1, 2 or 3."""
        return int(self.centres.shape[1])

    @property
    def skewed(self) -> bool:
        """Whether any face needs corrections for skewness or non-orthogonality."""
        return self.geometry.skewed

    @cached_property
    def links(self) -> np.ndarray:
        """Sum (nc,) [1/m2] of area over distance of the interior faces of each cell, over its volume."""
        g, ni = self.geometry, self.interior
        link, found = g.area[:ni] / g.distance[:ni], np.zeros(len(self.cells))
        np.add.at(found, g.left[:ni], link)
        np.add.at(found, g.right, link)
        found /= g.volume
        return found

    @cached_property
    def rows(self) -> Rows | None:
        """Rows of a rectangular grid, else None; built when a step needs them, as ranks do not."""
        if not self.rectangular:
            return None
        g = self.geometry
        arms, slopes = (g.arm_left, g.arm_right), (g.slope_left, g.slope_right)
        return build_rows(g.left, g.right, g.normal, arms, slopes, len(self.cells))

    def parts(self, number: int) -> list[tuple[Geometry, Rows]]:
        """Return lists and rows of a rectangular grid in a number of parts with equally many cells."""
        if number not in self._parts:
            assert self.rows is not None
            g, count = self.geometry, len(self.cells)
            bounds = [count * k // number for k in range(number + 1)]
            edges = self.interior + np.searchsorted(g.left[self.interior :], bounds)
            self._parts[number] = [
                (
                    g._replace(edge_from=int(edges[k]), edge_to=int(edges[k + 1])),
                    part_of_rows(self.rows, bounds[k], bounds[k + 1]),
                )
                for k in range(number)
            ]
        return self._parts[number]

    @cached_property
    def _parts(self) -> dict[int, list[tuple[Geometry, Rows]]]:
        return {}

    @property
    def order(self) -> Literal["C", "F"]:
        """Order in memory of vectors (nc, dim): with rows by component, so that each row is contiguous."""
        return "F" if self.rectangular else "C"

    @property
    def face_count(self) -> int:
        """Number of faces that a state has."""
        return len(self.geometry.left)

    @property
    def interior(self) -> int:
        """Number of interior faces."""
        return len(self.geometry.right)


def over_rows(grid: Grid, kernel: Callable[..., Any], *arguments: Any) -> list[Any]:
    """Call `kernel(geometry, rows, *arguments)` for parts of a rectangular grid at the same time; return the results.

    A kernel writes only what belongs to the cells of its part, in an order that the parts do not change: the numbers
    do not depend on how many threads there are.
    """
    parts = grid.parts(threads.count(len(grid.cells)))
    return threads.together([(kernel, (*part, *arguments)) for part in parts])


def build(mesh: Mesh, periodic: Sequence[tuple[str, str]] = ()) -> Grid:
    """Grid of a mesh; `periodic` names pairs of boundaries that are one and the same.

    Raises
    ------
    SceneError : a periodic pair that does not match, a cell without volume or a face that its cells do not face
    """
    old = mesh.skfem
    dim, count = old.dim(), old.nelements
    first, second = old.f2t
    plain, centres = _middles(count, old.refdom, old.mapping().F, old.mapping().detDF)
    weight = plain
    if mesh.axisymmetric:
        weight = 2 * np.pi * centres[:, 0] * plain
    if not (weight > 0).all():
        raise SceneError(f"mesh: {np.sum(~(weight > 0))} cells have no volume; repair the mesh")
    _, middles = _middles(old.facets.shape[1], old.brefdom, old.mapping().G, old.mapping().detDG)
    vector = _vectors(old.p[:, old.facets])
    vector *= np.sign(((middles - centres[first]) * vector).sum(axis=1))[:, None]
    flat = np.linalg.norm(vector, axis=1)
    area = 2 * np.pi * middles[:, 0] * flat if mesh.axisymmetric else flat
    joined = _pairs(mesh, periodic, middles)

    interior = np.flatnonzero(second >= 0)
    front, back = np.concatenate((interior, joined[0])), np.concatenate((interior, joined[1]))
    left, right = first[front], np.concatenate((second[interior], first[joined[1]]))
    graph = sp.coo_matrix((np.ones(len(left)), (left, right)), (count, count)).tocsr()
    cells = np.asarray(reverse_cuthill_mckee(graph + graph.T, symmetric_mode=True), dtype=np.int64)
    rank = np.empty(count, dtype=np.int64)
    rank[cells] = np.arange(count)
    bandwidth = int(np.abs(rank[left] - rank[right]).max(initial=0))
    place = places(centres, vector / flat[:, None], left[: len(interior)], right[: len(interior)])
    if place is not None:
        cells = numbering(place)
        rank[cells] = np.arange(count)

    left, right = rank[left], rank[right]
    if place is None:
        turned = left > right
        order = np.lexsort((np.maximum(left, right), np.minimum(left, right)))
    else:
        turned = vector[front].sum(axis=1) < 0
        low, high = np.where(turned, right, left), np.where(turned, left, right)
        order = np.lexsort((low, high - low, np.argmax(np.abs(vector[front]), axis=1)))
    edge = np.setdiff1d(np.flatnonzero(second < 0), np.concatenate(joined))
    if place is not None:
        # in the order of their cells, so that those of a part of the cells follow each other
        edge = edge[np.argsort(rank[first[edge]], kind="stable")]
    seen = np.where(turned, back, front)[order], np.where(turned, front, back)[order]
    face = np.concatenate((front[order], edge))  # facet that lends area and normal
    sign = np.concatenate((np.where(turned, -1.0, 1.0)[order], np.ones(len(edge))))
    left, right = (
        np.concatenate((np.where(turned, right, left)[order], rank[first[edge]])),
        np.where(turned, left, right)[order],
    )
    centres, volume = centres[cells], weight[cells]
    normal = sign[:, None] * vector[face] / flat[face][:, None]
    ni = len(right)
    arm_left = middles[np.concatenate((seen[0], edge))] - centres[left]
    arm_right = middles[seen[1]] - centres[right]
    d = arm_left.copy()
    d[:ni] -= arm_right
    distance = (d * normal).sum(axis=1)
    if not (distance > 0).all():
        where = middles[face][np.argmin(distance)]
        raise SceneError(f"mesh: the cells beside the face at {where} do not face each other; improve the mesh there")
    share = -(arm_right * normal[:ni]).sum(axis=1) / distance[:ni]
    skew = arm_left[:ni] - (1 - share)[:, None] * d[:ni]
    cross = normal - d / distance[:, None]
    size = np.sqrt((d * d).sum(axis=1))
    skewed = max(np.abs(cross[:ni]).max(initial=0), (np.abs(skew) / size[:ni, None]).max(initial=0)) > 1e-8
    moment = np.zeros((count, dim, dim))
    outer = flat[face][:, None, None] * normal[:, :, None] * normal[:, None, :]
    np.add.at(moment, left, outer)
    np.add.at(moment, right, outer[:ni])
    slopes = _slopes(d, left, right, count, bool(skewed))
    arrays = (
        left,
        right,
        area[face],
        flat[face],
        normal,
        distance,
        cross,
        share,
        skew,
        arm_left,
        arm_right,
        *slopes,
        volume,
        np.linalg.inv(moment),
        centres[:, 0] if mesh.axisymmetric else np.zeros(count),
    )
    number = np.full(len(first), -1)
    number[edge] = ni + np.arange(len(edge))
    named = {name: number[facets] for name, facets in old.boundaries.items()}
    return Grid(
        Geometry._make([*map(np.ascontiguousarray, arrays), bool(skewed), (0,) * dim, ni, len(left)]),
        cells,
        centres,
        middles[face],
        {name: np.sort(f[f >= 0]) for name, f in named.items() if (f >= 0).any()},
        {name: np.sort(rank[c]) for name, c in old.subdomains.items()},
        mesh.axisymmetric,
        bandwidth,
        place is not None,
        None if place is None or periodic else place[cells],
    )


def _middles(count: int, reference: type, place: Map, determinant: Map) -> tuple[np.ndarray, np.ndarray]:
    """Return sizes (count,) and middles (count, dim) of cells or faces, by quadrature in the `reference` one.

    In parts, as the maps of hexahedra are large.
    """
    # order 4 is exact: a trilinear map has a determinant of degree 2 in each direction, and the place adds one
    points, weights = get_quadrature(reference, 4)
    sizes, middles = [], []
    for part in np.array_split(np.arange(count), count // CELLS_AT_ONCE + 1):
        dx = np.abs(determinant(points, part)) * weights
        sizes.append(dx.sum(axis=1))
        middles.append((place(points, part) * dx).sum(axis=2).T / sizes[-1][:, None])
    return np.concatenate(sizes), np.concatenate(middles)


def _vectors(p: np.ndarray) -> np.ndarray:
    """Area vectors (nf, dim) of faces with the corners p (dim, corners, nf), of either sign."""
    if len(p) == 1:
        return np.ones((p.shape[2], 1))
    along = p[:, 1] - p[:, 0]
    if len(p) == 2:
        return np.stack((along[1], -along[0]), axis=1)
    # of a warped face the integral of the normal, too
    return 0.5 * np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1] if p.shape[1] == 4 else along, axis=0).T


def neighbours(grid: Grid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Start (nc + 1,), beside, faces : neighbours of each cell from start[c] to start[c + 1], and the faces between."""
    g = grid.geometry
    other = np.flatnonzero(g.left[: grid.interior] != g.right)  # a periodic row of one cell links with itself
    ends = np.concatenate((g.left[other], g.right[other])), np.concatenate((g.right[other], g.left[other]))
    order = np.argsort(ends[0], kind="stable")
    start = np.searchsorted(ends[0][order], np.arange(len(grid.cells) + 1))
    return start, ends[1][order], np.concatenate((other, other))[order]


def _pairs(mesh: Mesh, periodic: Sequence[tuple[str, str]], middles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Facets on either side of the periodic boundaries, in the same order."""
    one: list[np.ndarray] = [np.empty(0, dtype=np.int64)]
    two: list[np.ndarray] = [np.empty(0, dtype=np.int64)]
    for a, b in periodic:
        here, there = (mesh.skfem.boundaries[name] for name in (a, b))
        x, y = middles[here], middles[there]
        if len(x) != len(y):
            raise SceneError(f"mesh: periodic {a} has {len(x)} faces and {b} has {len(y)}; mesh both sides alike")
        shift = y.mean(axis=0) - x.mean(axis=0)
        tolerance = 1e-6 * np.linalg.norm(shift)
        keys = [np.lexsort(np.rint(points / tolerance).T) for points in (x + shift, y)]
        if np.abs((x + shift)[keys[0]] - y[keys[1]]).max() > 10 * tolerance:
            raise SceneError(f"mesh: periodic {a} and {b} are not shifted copies; mesh both sides alike")
        one.append(here[keys[0]])
        two.append(there[keys[1]])
    return np.concatenate(one), np.concatenate(two)


def _slopes(d: np.ndarray, left: np.ndarray, right: np.ndarray, count: int, wide: bool) -> tuple[np.ndarray, ...]:
    """`slope_left`, `slope_right`, `gradient_inverse` of least-squares gradients with weights 1/d2."""
    ni = len(right)
    weighted = d / (d * d).sum(axis=1)[:, None]
    own = np.zeros((count, d.shape[1], d.shape[1]))
    outer = weighted[:, :, None] * d[:, None, :]
    np.add.at(own, left, outer)
    np.add.at(own, right, outer[:ni])
    if not wide:
        inverse = np.linalg.inv(own)
        there, here = (np.einsum("fij,fj->fi", inverse[side], weighted[: len(side)]) for side in (left, right))
        return there, here, np.empty((0, *own.shape[1:]))
    moment = own.copy()
    np.add.at(moment, left[:ni], own[right])
    np.add.at(moment, right, own[left[:ni]])
    return weighted, weighted[:ni], np.linalg.inv(moment)
