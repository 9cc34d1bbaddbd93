"""Cells and faces of a mesh as flat lists: who is left and right of a face, areas,
normals, weights of gradients.

Cells are numbered so that neighbours are near (reverse Cuthill-McKee), on rectangular
grids place by place (rows.py). Interior faces come first and point from the cell on
their left, which has the smaller number, to the cell on their right; on rectangular
grids along their axis. Boundary faces follow and point outwards. A periodic pair is one
interior face. In axisymmetric grids, coordinates (r, z), areas and volumes carry 2 pi
r.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from contbed.compiled import threads
from contbed.mesh.mesh import Mesh
from contbed.solvers.aggregation import neighbours_by_cell
from contbed.two_fluid.compiled import Flags
from contbed.two_fluid.fv.connections import (
    SKEWED,
    Links,
    Offsets,
    connect,
    offsets,
    skewness,
)
from contbed.two_fluid.fv.halo import WHOLE, Halo
from contbed.two_fluid.fv.rows import Rows, build_rows, part_of_rows

# cells of a rectangular grid from which kernels over rows are used: a step of 300 cells
# takes 1.10 ms with rows and 0.80 ms without, one of 2800 cells 4.0 and 4.1 ms, one of
# 5250 cells 3.3 and 4.4 ms; without rows the first run compiles 8 s less
FEWEST_IN_ROWS = 2000


class Geometry(NamedTuple):
    """What the kernels need, for nf faces of which ni are interior, and nc cells.

    left (nf,), right (ni,) : cells of a face
    area (nf,) [m, m2], face_size (nf,) : size of a face with and without the weight 2
        pi r
    normal (nf, dim), distance (nf,) : n, and d.n for the vector d from the left centre
        to the right one or to the face
    non_orthogonal (nf, dim) : n - d/(d.n), the part of the normal that a difference of
        the two centres misses
    weight (ni,) : of the left value in a linear interpolation to the face
    skew (ni, dim) : from the point that `weight` interpolates to, to the middle of the
        face
    arm_left (nf, dim), arm_right (ni, dim) : from the centre to the middle of the face
    slope_left (nf, dim), slope_right (ni, dim) : weights of the jump right - left in
        the least-squares gradients
    gradient_inverse (nc, dim, dim) : makes gradients of the sums over a cell and its
        neighbours on `skewed` grids
    volume (nc,) : of cells [m, m2, m3]
    moment_inverse (nc, dim, dim) : inverse of the sum of face_size n n over the faces
        of a cell
    radius (nc,) : r of the centre, 0 where the grid is not axisymmetric
    skewed : whether any face needs corrections by `non_orthogonal` or `skew`; then
        gradients take the faces of neighbours, too, as what the few of one flat
        tetrahedron give is noise
    axes : dim zeros; a tuple, so that its length is known to the compiler
    edge_from, edge_to : first boundary face, and the one after the last; in a part of a
        rectangular grid, of its cells
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

    cells (nc,) : cell of the mesh behind each cell; a field goes to the mesh by
        `out[grid.cells] = field`
    centres (nc, dim), middles (nf, dim) : of cells and faces [m]
    boundaries : faces of each named boundary that is not periodic
    bandwidth : largest distance of neighbours in the numbering by reverse Cuthill-McKee
    rectangular : whether the grid has rows
    places (nc, dim) : of the cells on the lattice of a rectangular grid that no
    periodic pair closes, else None
    spans (nc, 2) : lowest and highest middle of the faces of each cell [m]; the part of
        a rank has none
    halo : cells that other ranks own
    """

    geometry: Geometry
    cells: np.ndarray
    centres: np.ndarray
    middles: np.ndarray
    boundaries: dict[str, np.ndarray]
    axisymmetric: bool
    bandwidth: int
    rectangular: bool
    places: np.ndarray | None
    spans: np.ndarray
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
        """Sum (nc,) [1/m2] of area over distance of the interior faces of each cell,
        over its volume.
        """
        g, ni = self.geometry, self.interior
        link, found = g.area[:ni] / g.distance[:ni], np.zeros(len(self.cells))
        np.add.at(found, g.left[:ni], link)
        np.add.at(found, g.right, link)
        found /= g.volume
        return found

    @property
    def in_rows(self) -> bool:
        """Whether kernels run over rows of a rectangular grid."""
        return self.rectangular and len(self.cells) >= FEWEST_IN_ROWS

    @cached_property
    def rows(self) -> Rows | None:
        """Rows of a large rectangular grid, else None; built when a step needs them, as
        ranks do not.
        """
        if not self.in_rows:
            return None
        g = self.geometry
        arms, slopes = (g.arm_left, g.arm_right), (g.slope_left, g.slope_right)
        return build_rows(g.left, g.right, g.normal, arms, slopes, len(self.cells))

    def parts(self, number: int) -> list[tuple[Geometry, Rows]]:
        """Return lists and rows of a rectangular grid in a number of parts with
        equally many cells.
        """
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
        """Order in memory of vectors (nc, dim): with rows by component, so that each
        row is contiguous.
        """
        return "F" if self.in_rows else "C"

    @property
    def face_count(self) -> int:
        """Number of faces that a state has."""
        return len(self.geometry.left)

    @property
    def interior(self) -> int:
        """Number of interior faces."""
        return len(self.geometry.right)


def over_rows(grid: Grid, kernel: Callable[..., Any], *arguments: Any) -> list[Any]:
    """Call `kernel(geometry, rows, *arguments)` for parts of a rectangular grid at the
    same time; return the results.

    A kernel writes only what belongs to the cells of its part, in an order that the
    parts do not change: the numbers do not depend on how many threads there are.
    """
    parts = grid.parts(threads.count(len(grid.cells)))
    return threads.together([(kernel, (*part, *arguments)) for part in parts])


def build(mesh: Mesh, periodic: Sequence[tuple[str, str]] = ()) -> Grid:
    """Grid of a mesh; `periodic` names pairs of boundaries that are one and the same.

    Raises
    ------
    SceneError : a periodic pair that does not match, a cell without volume or a face
        that its cells do not face
    """
    c = connect(mesh, periodic)
    links = c.links(np.arange(len(c.left)))
    apart = offsets(links)
    return Grid(
        geometry(links, apart, mesh.axisymmetric, skewness(links, apart) > SKEWED),
        c.cells,
        links.centres,
        links.middles,
        c.boundaries,
        mesh.axisymmetric,
        c.bandwidth,
        c.place is not None,
        None if c.place is None or periodic else c.place[c.cells],
        c.spans,
    )


def geometry(
    links: Links,
    apart: Offsets,
    axisymmetric: bool,
    skewed: bool,
    complete: int | None = None,
) -> Geometry:
    """Return the lists of a grid, or of the first `complete` cells of a part and of the
    faces of these alone.

    Of those the part has all faces; on skewed grids also all of their neighbours and of
    the neighbours of these.
    """
    dim, count = links.centres.shape[1], len(links.centres)
    last = count if complete is None else complete
    inside: slice | Flags = slice(None)
    kept: slice | Flags = slice(None)
    if complete is not None:
        inside, edge = faces_of(links, complete)
        kept = np.concatenate((inside, edge))
    left, right, centres = links.left[kept], links.right[inside], links.centres[:last]
    across = (
        apart.size[:, None, None] * apart.normal[:, :, None] * apart.normal[:, None, :]
    )
    moment = _summed(across, links)[:last]
    slopes = _slopes(links, apart, skewed, last, (kept, inside))
    size, middles = apart.size[kept], links.middles[kept]
    arrays = (
        left,
        right,
        2 * np.pi * middles[:, 0] * size if axisymmetric else size,
        size,
        apart.normal[kept],
        apart.distance[kept],
        apart.non_orthogonal[kept],
        apart.weight[inside],
        apart.skew[inside],
        apart.arm_left[kept],
        apart.arm_right[inside],
        *slopes,
        links.volume[:last],
        np.linalg.inv(moment),
        centres[:, 0] if axisymmetric else np.zeros(last),
    )
    return Geometry._make(
        [*map(np.ascontiguousarray, arrays), skewed, (0,) * dim, len(right), len(left)]
    )


def faces_of(links: Links, complete: int) -> tuple[Flags, Flags]:
    """Mark the interior and the boundary faces of the first `complete` cells of a
    part alone.
    """
    ni = len(links.right)
    return (links.left[:ni] < complete) & (links.right < complete), links.left[
        ni:
    ] < complete


def _summed(values: np.ndarray, links: Links) -> np.ndarray:
    """Sum over the faces of each cell (nc, ...) of values (nf, ...)."""
    found = np.zeros((len(links.centres), *values.shape[1:]))
    np.add.at(found, links.left, values)
    np.add.at(found, links.right, values[: len(links.right)])
    return found


def _slopes(
    links: Links,
    apart: Offsets,
    wide: bool,
    last: int,
    kept: tuple[slice | Flags, slice | Flags],
) -> tuple[np.ndarray, ...]:
    """`slope_left`, `slope_right`, `gradient_inverse` of least-squares gradients
    with weights 1/d2.
    """
    ni, d = len(links.right), apart.between
    weighted = d / (d * d).sum(axis=1)[:, None]
    own = _summed(weighted[:, :, None] * d[:, None, :], links)
    of_left, of_right = weighted[kept[0]], weighted[:ni][kept[1]]
    if not wide:
        inverse = np.linalg.inv(own[:last])
        sides = ((links.left[kept[0]], of_left), (links.right[kept[1]], of_right))
        there, here = (
            np.einsum("fij,fj->fi", inverse[cells], values) for cells, values in sides
        )
        return there, here, np.empty((0, *own.shape[1:]))
    moment = own.copy()
    np.add.at(moment, links.left[:ni], own[links.right])
    np.add.at(moment, links.right, own[links.left[:ni]])
    return of_left, of_right, np.linalg.inv(moment[:last])


def neighbours(grid: Grid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Start (nc + 1,), beside, faces : neighbours of each cell from start[c] to
    start[c + 1], and the faces between.
    """
    g = grid.geometry
    return neighbours_by_cell(g.left[: grid.interior], g.right, len(grid.cells))
