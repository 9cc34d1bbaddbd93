"""A rectangular grid by the coordinates along its axes: the outline and the part of any
rank, without the whole.

Cells and faces have the numbers that `fv.grid.build` gives them: cells along the
longest axis first; interior faces axis by axis, of each the periodic ones first, by the
cell on their left; boundary faces by their cell. Each rank has a brick of cells, and
every number of the geometry comes from the same coordinates: two ranks have the same
bits.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from contbed.mesh.mesh import Mesh
from contbed.mesh.tensor import Tensor, places, strides, tensor_of
from contbed.two_fluid.compiled import Array, Indices
from contbed.two_fluid.fv.grid import Geometry


class Faces(NamedTuple):
    """Faces (n,): axis of the normal, place (n, dim) of the cell that it points out
    of, end of that cell, number.
    """

    axis: Indices
    place: Indices
    end: Indices
    number: Indices

    def take(self, which: Indices) -> Faces:
        """Return some of the faces."""
        return Faces(*(values[which] for values in self))


@dataclass(frozen=True, eq=False)
class Lattice:
    """A rectangular grid.

    lends : for each axis the end, 0 or 1, whose faces give a periodic pair its place;
        None where none closes the axis
    """

    tensor: Tensor
    axisymmetric: bool
    lends: tuple[int | None, ...]

    @cached_property
    def count(self) -> Indices:
        """Number of cells along each axis (dim,)."""
        return self.tensor.shape - 1

    @cached_property
    def order(self) -> tuple[int, ...]:
        """Axes, the one first along which numbers of cells run first: the longest."""
        return tuple(int(axis) for axis in np.argsort(-self.count, kind="stable"))

    @property
    def interior(self) -> int:
        """Number of interior faces."""
        return int(self._starts[-1])

    @cached_property
    def _starts(self) -> Indices:
        """First number of the interior faces of each axis, and of the boundary
        faces.
        """
        across = self.tensor.bricks // self.count
        each = across * (self.count - [lent is None for lent in self.lends])
        return np.append(0, np.cumsum(each))

    @property
    def bandwidth(self) -> int:
        """Largest distance of the numbers of neighbours that are not periodic."""
        return int(strides(self.count, self.order).max())

    def numbers(self, place: Indices) -> Indices:
        """Numbers (n,) of the cells at places (n, dim)."""
        found: Indices = place @ strides(self.count, self.order)
        return found

    def places(self, cells: Indices) -> Indices:
        """Places (n, dim) of cells by their numbers (n,)."""
        return places(cells, self.count, self.order)

    def of_mesh(self, place: Indices) -> Indices:
        """Cells (n,) of the mesh at places (n, dim)."""
        found: Indices = place @ strides(self.count, self.tensor.order)
        return found

    def after(self, axis: int, place: Indices) -> Faces:
        """Return the interior faces behind cells along an axis; those at its end
        have one if it is closed.
        """
        last = self.count[axis] - 1
        if self.lends[axis] is None:
            place = place[place[:, axis] < last]
        wraps = place[:, axis] == last
        closing = (
            0 if self.lends[axis] is None else self.tensor.bricks // self.count[axis]
        )
        shape = [
            np.where(np.arange(len(self.count)) == axis, n, self.count)
            for n in (1, max(last, 1))
        ]
        across = place.copy()
        across[:, axis] = 0
        number = np.where(
            wraps,
            across @ strides(shape[0], self.order),
            closing + place @ strides(shape[1], self.order),
        )
        same = np.full(len(place), axis)
        return Faces(same, place, np.ones_like(same), self._starts[axis] + number)

    def beside(self, axis: int, place: Indices) -> tuple[Faces, Faces]:
        """Return the interior faces behind cells along an axis, and those before
        them.
        """
        before = place.copy()
        before[:, axis] -= 1
        if self.lends[axis] is None:
            before = before[before[:, axis] >= 0]
        return self.after(axis, place), self.after(axis, before % self.count)

    def next(self, faces: Faces) -> Indices:
        """Places (n, dim) of the cells behind interior faces."""
        found = faces.place.copy()
        each = np.arange(len(found))
        found[each, faces.axis] = (found[each, faces.axis] + 1) % self.count[faces.axis]
        return found

    @cached_property
    def edges(self) -> Faces:
        """The boundary faces, by their cell and, of one cell, in the order of the
        facets of the mesh.
        """
        order, found = self.tensor.order, []
        for axis, end in [(axis, 0) for axis in reversed(order)] + [
            (axis, 1) for axis in order
        ]:
            if self.lends[axis] is not None:
                continue
            spans = [np.arange(n) for n in self.count]
            spans[axis] = spans[axis][[-end]]
            place = np.stack(
                [x.ravel() for x in np.meshgrid(*spans, indexing="ij")], axis=1
            )
            found.append((np.full(len(place), axis), place, np.full(len(place), end)))
        if not found:
            none = np.empty(0, dtype=np.int64)
            return Faces(none, none.reshape(0, len(self.count)), none, none)
        axes, place, ends = (
            np.concatenate(values) for values in zip(*found, strict=True)
        )
        sorted_by_cell = np.argsort(self.numbers(place), kind="stable")
        number = self.interior + np.arange(len(axes))
        return Faces(
            axes[sorted_by_cell], place[sorted_by_cell], ends[sorted_by_cell], number
        )

    @cached_property
    def _sizes(self) -> tuple[tuple[Array, Array], ...]:
        """Middles and widths [m] of the intervals along each axis."""
        return tuple((0.5 * (x[:-1] + x[1:]), np.diff(x)) for x in self.tensor.axes)

    def centres(self, place: Indices) -> Array:
        """Centres (n, dim) [m] of cells."""
        return np.stack(
            [middle[place[:, d]] for d, (middle, _) in enumerate(self._sizes)], axis=1
        )

    def geometry(
        self, cells: Indices | None, inner: Faces, edge: Faces
    ) -> tuple[Geometry, Array, Array]:
        """Return the lists of some cells and of faces between or beside them, centres
        and middles of faces [m].

        Without `cells` they are those of all cells, but for `moment_inverse`.
        """
        dim, ni = len(self.count), len(inner.axis)
        place = self.places(np.arange(self.tensor.bricks) if cells is None else cells)
        faces = joined((inner, edge))
        each, axis, n = np.arange(len(faces.axis)), faces.axis, len(faces.axis)
        behind = self.next(inner)
        at, here = self._beside(axis, faces.place, faces.end)
        beyond, there = self._beside(inner.axis, behind, 0 * inner.end)
        middles = self.centres(faces.place)
        middles[each, axis] = at
        wraps = np.flatnonzero(behind[each[:ni], inner.axis] == 0)
        lent = wraps[np.array([end == 0 for end in self.lends])[inner.axis[wraps]]]
        middles[lent, inner.axis[lent]] = beyond[lent]
        normal, arm_left, arm_right = (
            np.zeros((n, dim)),
            np.zeros((n, dim)),
            np.zeros((ni, dim)),
        )
        normal[each, axis] = 2.0 * faces.end - 1.0
        arm_left[each, axis] = at - here
        arm_right[each[:ni], inner.axis] = beyond - there
        distance = np.abs(at - here)
        distance[:ni] += there - beyond
        size, centres = self._across(faces.place, axis), self.centres(place)
        # the two faces of a cell along an axis share the gradient
        slopes = 0.5 * normal / distance[:, None]
        moment = np.zeros((0 if cells is None else len(place), dim, dim))
        for d in range(dim if len(moment) else 0):
            moment[:, d, d] = 0.5 / self._across(place, d)
        left, right = (self._positions(cells, where) for where in (faces.place, behind))
        geometry = Geometry(
            left=left,
            right=right,
            area=self._around(middles) * size,
            face_size=size,
            normal=normal,
            distance=distance,
            non_orthogonal=np.zeros((n, dim)),
            weight=(there - beyond) / distance[:ni],
            skew=np.zeros((ni, dim)),
            arm_left=arm_left,
            arm_right=arm_right,
            slope_left=slopes,
            slope_right=slopes[:ni].copy(),
            gradient_inverse=np.empty((0, dim, dim)),
            volume=self._around(centres) * self._across(place, -1),
            moment_inverse=moment,
            radius=centres[:, 0].copy() if self.axisymmetric else np.zeros(len(place)),
            skewed=False,
            axes=(0,) * dim,
            edge_from=ni,
            edge_to=n,
        )
        return geometry, centres, middles

    def _beside(
        self, axis: Indices, place: Indices, end: Indices
    ) -> tuple[Array, Array]:
        """Coordinates (n,) [m] along an axis of an end of cells, and of their
        centres.
        """
        at, centre = np.empty(len(axis)), np.empty(len(axis))
        for d, x in enumerate(self.tensor.axes):
            along = axis == d
            at[along], centre[along] = (
                x[place[along, d] + end[along]],
                self._sizes[d][0][place[along, d]],
            )
        return at, centre

    def _across(self, place: Indices, axis: Indices | int) -> Array:
        """Size (n,) of the faces of cells across an axis, or of cells for -1,
        without the weight 2 pi r.
        """
        size = np.ones(len(place))
        for d, (_, width) in enumerate(self._sizes):
            size *= np.where(axis == np.int64(d), 1.0, width[place[:, d]])
        return size

    def _around(self, points: Array) -> Array:
        """Weight (n,) of cells or faces with their middles at points (n, dim)."""
        return 2.0 * np.pi * points[:, 0] if self.axisymmetric else np.ones(len(points))

    def _positions(self, cells: Indices | None, place: Indices) -> Indices:
        return (
            self.numbers(place)
            if cells is None
            else positions(cells, self.numbers(place))
        )


def joined(lists: Iterable[Faces]) -> Faces:
    """Return lists of faces as one."""
    return Faces(*(np.concatenate(values) for values in zip(*lists, strict=True)))


def positions(cells: Indices, wanted: Indices) -> Indices:
    """Positions (n,) in a list of cells of those that are wanted, all of which are
    in it.
    """
    order = np.argsort(cells, kind="stable")
    found: Indices = order[np.searchsorted(cells, wanted, sorter=order)]
    return found


def lattice_of(
    mesh: Mesh, sides: Sequence[tuple[str, str]], pairs: Sequence[tuple[str, str]]
) -> Lattice | None:
    """Return the lattice of a built-in mesh, None if its cells are no intervals,
    rectangles or bricks.

    `sides` are the boundaries at both ends of each axis, `pairs` those that are one and
    the same.
    """
    tensor = tensor_of(mesh.skfem)
    if tensor is None or tensor.cells > tensor.bricks:
        return None
    lends: list[int | None] = [None] * len(sides)
    for front, back in pairs:
        axis = next(
            (d for d, both in enumerate(sides) if {front, back} == set(both)), None
        )
        whole = tensor.bricks // (tensor.shape[axis] - 1) if axis is not None else -1
        if (
            axis is None
            or len(mesh.skfem.boundaries[front]) != whole
            or len(mesh.skfem.boundaries[back]) != whole
        ):
            return None  # what does not match is reported by `fv.grid.build`
        lends[axis] = sides[axis].index(front)
    return Lattice(tensor, mesh.axisymmetric, tuple(lends))


def numbers_of_facets(
    lattice: Lattice, mesh: Mesh, pairs: Sequence[tuple[str, str]]
) -> dict[str, Indices]:
    """Return the boundary faces by name, in ascending order; each belongs to one
    boundary.
    """
    plain, periodic = mesh.skfem, {name for pair in pairs for name in pair}
    named = {
        name: facets
        for name, facets in plain.boundaries.items()
        if name not in periodic and len(facets)
    }
    facets = np.concatenate([*named.values(), np.empty(0, dtype=np.int64)])
    cells = lattice.numbers(
        places(plain.f2t[0, facets], lattice.count, lattice.tensor.order)
    )
    numbers = np.empty(len(facets), dtype=np.int64)
    numbers[np.lexsort((facets, cells))] = lattice.interior + np.arange(len(facets))
    ends = np.cumsum([len(facets) for facets in named.values()])
    return {
        name: np.sort(part)
        for name, part in zip(named, np.split(numbers, ends), strict=False)
    }
