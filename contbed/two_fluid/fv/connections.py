"""Which cells of a mesh are beside each other, in the numbering of the grid, with sizes
and places of cells and faces.

A grid, a part of one for a rank and the outline of one are made from this: it takes a
tenth of the memory of a grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import reverse_cuthill_mckee
from skfem.quadrature import get_quadrature

from contbed.errors import SceneError
from contbed.fem.elements import lagrange
from contbed.mesh.mesh import Mesh
from contbed.two_fluid.compiled import Array, Flags, Indices
from contbed.two_fluid.fv.rows import numbering, places

AT_ONCE = 20_000  # cells or faces whose quadrature points are in memory
SKEWED = 1e-8  # skewness that is more than rounding


class Links(NamedTuple):
    """Cells (nc) and faces (nf, of which ni are interior) of a grid or of a part, with
    their numbers there.

    centres (nc, dim) [m], volume (nc,) : of cells; the volume has the weight 2 pi r of
        axisymmetric grids
    left (nf,), right (ni,) : cells of a face
    vectors (nf, dim) : areas times normals out of the left cells, without the weight 2
        pi r
    middles (nf, dim) [m] : of faces
    here (nf, dim), there (ni, dim) [m] : middles as the left and the right cell see
        them, two of a periodic face
    """

    centres: Array
    volume: Array
    left: Indices
    right: Indices
    vectors: Array
    middles: Array
    here: Array
    there: Array


class Offsets(NamedTuple):
    """Faces and the vectors around them; `between` (nf, dim) runs between the centres,
    or to the boundary face.

    The others are those of `grid.Geometry`, `size` its `face_size`.
    """

    size: Array
    normal: Array
    between: Array
    distance: Array
    non_orthogonal: Array
    weight: Array
    skew: Array
    arm_left: Array
    arm_right: Array


@dataclass(frozen=True, eq=False)
class Connections:
    """Faces of a mesh, interior ones first, and the cells that they connect.

    cells (nc,) : cell of the mesh behind each cell
    left (nf,), right (ni,) : cells of a face
    facet_left (nf,), facet_right (ni,) : facet of the mesh that each sees, two of them
        where the face is periodic
    turned (ni,) : whether the facet's area vector points into the left cell; that of a
        periodic face is the right one's
    vectors, middles (nfacets, dim) : area vectors and middles of the facets
    centres (nc, dim), volume (nc,) : of cells
    boundaries, bandwidth : see `grid.Grid`
    place (nc,) : of the mesh's cells in the lattice of a rectangular grid, else None
    """

    cells: Indices
    left: Indices
    right: Indices
    facet_left: Indices
    facet_right: Indices
    turned: Flags
    vectors: Array
    middles: Array
    centres: Array
    volume: Array
    boundaries: dict[str, Indices]
    axisymmetric: bool
    bandwidth: int
    place: Indices | None

    @property
    def interior(self) -> int:
        """Number of interior faces."""
        return len(self.right)

    @property
    def spans(self) -> Array:
        """Lowest and highest middle [m] of the faces of each cell (nc, 2), as it sees
        them.
        """
        z, found = self.middles[:, -1], np.empty((len(self.cells), 2))
        found[:] = np.inf, -np.inf
        for cells, facets in (
            (self.left, self.facet_left),
            (self.right, self.facet_right),
        ):
            np.minimum.at(found[:, 0], cells, z[facets])
            np.maximum.at(found[:, 1], cells, z[facets])
        return found

    def links(self, faces: Indices) -> Links:
        """Return some faces in ascending order, with all cells."""
        inner, lent = faces[: np.searchsorted(faces, self.interior)], self.facets(faces)
        vectors = self.vectors[lent]
        vectors[: len(inner)][self.turned[inner]] *= -1.0
        seen = (
            self.middles[facets]
            for facets in (lent, self.facet_left[faces], self.facet_right[inner])
        )
        return Links(
            self.centres,
            self.volume,
            self.left[faces],
            self.right[inner],
            vectors,
            *seen,
        )

    def facets(self, faces: Indices) -> Indices:
        """Return the facets whose area and middle some faces have; faces are in
        ascending order.
        """
        found, inner = (
            self.facet_left[faces],
            faces[: np.searchsorted(faces, self.interior)],
        )
        turned = np.flatnonzero(self.turned[inner])
        found[turned] = self.facet_right[inner[turned]]
        return found

    def skewness(self) -> float:
        """Return the skewness of all faces, of which few are in memory at a time.

        Raises
        ------
        SceneError : a face that its cells do not face
        """
        found = 0.0
        for faces in np.array_split(
            np.arange(len(self.left)), len(self.left) // AT_ONCE + 1
        ):
            links = self.links(faces)
            found = max(found, skewness(links, offsets(links)))
        return found


def connect(mesh: Mesh, periodic: Sequence[tuple[str, str]] = ()) -> Connections:
    """Return the connections of a mesh; `periodic` names pairs of boundaries that are
    one and the same.

    Raises
    ------
    SceneError : a periodic pair that does not match, a cell without volume
    """
    old = mesh.skfem
    count = old.nelements
    first, second = old.f2t
    volume, centres = _measured(old.p, old.t, old.refdom)
    if mesh.axisymmetric:
        volume = 2 * np.pi * centres[:, 0] * volume
    if not (volume > 0).all():
        raise SceneError(
            f"mesh: {np.sum(~(volume > 0))} cells have no volume; repair the mesh"
        )
    _, middles = _measured(old.p, old.facets, old.brefdom)
    vectors = _vectors(old.p[:, old.facets])
    vectors *= np.sign(((middles - centres[first]) * vectors).sum(axis=1))[:, None]
    joined = paired_facets(mesh, periodic, middles)

    interior = np.flatnonzero(second >= 0)
    front, back = (
        np.concatenate((interior, joined[0])),
        np.concatenate((interior, joined[1])),
    )
    left, right = first[front], np.concatenate((second[interior], first[joined[1]]))
    graph = sp.coo_matrix(
        (np.ones(len(left), dtype=np.int8), (left, right)), (count, count)
    ).tocsr()
    cells = np.asarray(
        reverse_cuthill_mckee(graph + graph.T, symmetric_mode=True), dtype=np.int64
    )
    del graph
    rank = np.empty(count, dtype=np.int64)
    rank[cells] = np.arange(count)
    bandwidth = int(np.abs(rank[left] - rank[right]).max(initial=0))
    normals = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    place = places(centres, normals, left[: len(interior)], right[: len(interior)])
    del normals
    if place is not None:
        cells = numbering(place)
        rank[cells] = np.arange(count)

    left, right = rank[left], rank[right]
    if place is None:
        turned = left > right
        order = np.lexsort((np.maximum(left, right), np.minimum(left, right)))
    else:
        turned = vectors[front].sum(axis=1) < 0
        low, high = np.where(turned, right, left), np.where(turned, left, right)
        order = np.lexsort((low, high - low, np.argmax(np.abs(vectors[front]), axis=1)))
    edge = np.setdiff1d(np.flatnonzero(second < 0), np.concatenate(joined))
    if place is not None:
        # in the order of their cells, so that those of a part of the cells follow each
        # other
        edge = edge[np.argsort(rank[first[edge]], kind="stable")]
    number = np.full(len(first), -1)
    number[edge] = len(front) + np.arange(len(edge))
    named = {name: number[facets] for name, facets in old.boundaries.items()}
    return Connections(
        cells,
        np.concatenate((np.where(turned, right, left)[order], rank[first[edge]])),
        np.where(turned, left, right)[order],
        np.concatenate((np.where(turned, back, front)[order], edge)),
        np.where(turned, front, back)[order],
        turned[order],
        vectors,
        middles,
        centres[cells],
        volume[cells],
        {name: np.sort(f[f >= 0]) for name, f in named.items() if (f >= 0).any()},
        mesh.axisymmetric,
        bandwidth,
        place,
    )


def offsets(links: Links) -> Offsets:
    """Return the vectors around faces.

    Raises
    ------
    SceneError : a face that its cells do not face
    """
    ni, size = len(links.right), np.linalg.norm(links.vectors, axis=1)
    normal = links.vectors / size[:, None]
    arm_left = links.here - links.centres[links.left]
    arm_right = links.there - links.centres[links.right]
    d = arm_left.copy()
    d[:ni] -= arm_right
    distance = (d * normal).sum(axis=1)
    if not (distance > 0).all():
        where = links.middles[np.argmin(distance)]
        raise SceneError(
            f"mesh: the cells beside the face at {where} do not face each other; "
            "improve the mesh there"
        )
    share = -(arm_right * normal[:ni]).sum(axis=1) / distance[:ni]
    skew = arm_left[:ni] - (1 - share)[:, None] * d[:ni]
    return Offsets(
        size,
        normal,
        d,
        distance,
        normal - d / distance[:, None],
        share,
        skew,
        arm_left,
        arm_right,
    )


def skewness(links: Links, apart: Offsets) -> float:
    """Return the largest part of a normal, or of a distance, that the line between
    two centres misses.
    """
    ni = len(links.right)
    way = np.sqrt((apart.between[:ni] ** 2).sum(axis=1))[:, None]
    crossing = np.abs(apart.non_orthogonal[:ni]).max(initial=0)
    return float(max(crossing, (np.abs(apart.skew) / way).max(initial=0)))


def _measured(p: Array, corners: Indices, shape: type) -> tuple[Array, Array]:
    """Return sizes (n,) and middles (n, dim) of cells or faces with `corners` (k, n)
    among the nodes p (dim, np).

    `shape` is their reference cell. In parts, as the quadrature points of hexahedra
    take much memory.
    """
    dim, (many, count) = len(p), corners.shape
    if many == 1:
        return np.ones(count), p[:, corners[0]].T.copy()
    element = lagrange(shape, 1)
    # exact: a trilinear map has a determinant of degree 2 along each axis, and the
    # place adds one; straight cells have their middle in one point
    points, weights = get_quadrature(shape, 1 if many == element.dim + 1 else 3)
    values, slopes = (
        element.table(points),
        [element.table(points, axis) for axis in range(element.dim)],
    )
    sizes, middles = np.empty(count), np.empty((count, dim))
    for first in range(0, count, AT_ONCE):
        some = slice(first, first + AT_ONCE)
        nodes = p[:, corners[:, some]].T  # (n, k, dim)
        dx = (
            _spanned([np.einsum("nkd,kq->nqd", nodes, slope) for slope in slopes])
            * weights
        )
        at = np.einsum("nkd,kq->nqd", nodes, values)
        sizes[some] = dx.sum(axis=1)
        middles[some] = (at * dx[..., None]).sum(axis=1) / sizes[some, None]
    return sizes, middles


def _spanned(along: Sequence[Array]) -> Array:
    """Return the size (n, q) of what one to three vectors (n, q, dim) span."""
    found: Array
    if len(along) == 1:
        found = np.linalg.norm(along[0], axis=-1)
        return found
    a, b = along[:2]
    if a.shape[-1] == 2:
        return np.abs(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
    normal = np.cross(a, b)
    found = (
        np.linalg.norm(normal, axis=-1)
        if len(along) == 2
        else np.abs((normal * along[2]).sum(axis=-1))
    )
    return found


def _vectors(p: Array) -> Array:
    """Area vectors (nf, dim) of faces with the corners p (dim, corners, nf), of
    either sign.
    """
    if len(p) == 1:
        return np.ones((p.shape[2], 1))
    along = p[:, 1] - p[:, 0]
    if len(p) == 2:
        return np.stack((along[1], -along[0]), axis=1)
    # of a warped face the integral of the normal, too
    return (
        0.5
        * np.cross(
            p[:, 2] - p[:, 0], p[:, 3] - p[:, 1] if p.shape[1] == 4 else along, axis=0
        ).T
    )


def paired_facets(
    mesh: Mesh, periodic: Sequence[tuple[str, str]], middles: Array
) -> tuple[Indices, Indices]:
    """Facets on either side of the periodic boundaries, in the same order."""
    one: list[Indices] = [np.empty(0, dtype=np.int64)]
    two: list[Indices] = [np.empty(0, dtype=np.int64)]
    for a, b in periodic:
        here, there = (mesh.skfem.boundaries[name] for name in (a, b))
        x, y = middles[here], middles[there]
        if len(x) != len(y):
            raise SceneError(
                f"mesh: periodic {a} has {len(x)} faces and {b} has {len(y)}; mesh "
                "both sides alike"
            )
        shift = y.mean(axis=0) - x.mean(axis=0)
        tolerance = 1e-6 * np.linalg.norm(shift)
        keys = [np.lexsort(np.rint(points / tolerance).T) for points in (x + shift, y)]
        if np.abs((x + shift)[keys[0]] - y[keys[1]]).max() > 10 * tolerance:
            raise SceneError(
                f"mesh: periodic {a} and {b} are not shifted copies; mesh both sides "
                "alike"
            )
        one.append(here[keys[0]])
        two.append(there[keys[1]])
    return np.concatenate(one), np.concatenate(two)
