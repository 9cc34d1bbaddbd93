"""Values of finite-element fields at given points, and along a line through a bed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from contbed.arrays import Array, Integers
from contbed.errors import SceneError
from contbed.fem.elements import Space, lagrange
from contbed.mesh.mesh import Mesh

SAMPLES = 12  # points in a cell of a line
EVENLY = 401  # points along other meshes
# shares of the width of the bed at which a line inside of the mesh is looked for, the
# middle first
ACROSS = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9)
PIECES = 40  # of a line whose longest part inside of the mesh is looked for
HALVINGS = 30  # of a piece, to find where the mesh ends
ROUNDS = 30  # of Newton's method for the place of a point in its cell
CLOSE = 1e-13  # change of a reference coordinate at which it ends


class Probe:
    """Interpolation at points (dim, n) of a mesh.

    Raises
    ------
    ValueError : a point lies outside of a mesh in more than one dimension
    """

    def __init__(self, mesh: Mesh, points: Array):
        grid = mesh.skfem
        if grid.dim() == 1:
            nodes = grid.p[0, grid.t]
            order = np.argsort(nodes.min(axis=0))
            low = nodes.min(axis=0)[order]
            at = order[
                np.clip(
                    np.searchsorted(low, points[0], side="right") - 1, 0, len(order) - 1
                )
            ]
            first, second = nodes[0, at], nodes[1, at]
            self.cells = at
            self.local = ((points[0] - first) / (second - first))[None, :]
        else:
            # scikit-fem splits quadrilaterals to search, and would look up every named
            # facet in the result one by one
            self.cells = replace(
                grid, _boundaries=None, _subdomains=None
            ).element_finder()(*points)
            self.local = _local(mesh, self.cells, points)

    def __call__(self, space: Space, values: Array) -> Array:
        """Return values (n,) of a nodal field (size,)."""
        table = space.element.table(self.local)
        return np.asarray((table * values[space.dofs[:, self.cells]]).sum(axis=0))

    def slope(self, space: Space, values: Array, axis: int) -> Array:
        """Return the derivative (n,) of a nodal field along a coordinate, one-sided
        between cells.
        """
        element = space.element
        inverse = np.linalg.inv(
            np.moveaxis(_jacobian(space.mesh, self.cells, self.local), 2, 0)
        )
        local = values[space.dofs[:, self.cells]]
        slopes = np.array(
            [
                (element.table(self.local, a) * local).sum(axis=0)
                for a in range(element.dim)
            ]
        )
        return np.asarray(np.einsum("nai,an->in", inverse, slopes)[axis])


@dataclass(frozen=True)
class Line:
    """Points along a bed: `positions` [m] on its axis, the `probe` there, and a
    `note` if it is not the middle; `wanted` says whether the positions were given.
    """

    mesh: Mesh
    positions: Array
    probe: Probe
    note: str = ""
    wanted: bool = False
    across: Sequence[float] | None = None

    @cached_property
    def whole(self) -> Line:
        """The line from end to end, of which named results are taken, also where
        profiles are wanted at a few positions; these where no such line lies in the
        mesh.
        """
        if not self.wanted:
            return self
        try:
            return line_along(self.mesh, across=self.across)
        except SceneError:
            return self


def line_along(
    mesh: Mesh, wanted: Sequence[float] = (), across: Sequence[float] | None = None
) -> Line:
    """Choose a line along the axis of a bed on which profiles are sampled.

    Parameters
    ----------
    mesh : of the bed
    wanted : positions [m]; without any, a line is sampled densely in each cell and
        other meshes at equal steps
    across : the other coordinates [m] of the line, in the order of the mesh's; None for
        the middle of the bed, the axis of a round one, or where that is not inside of
        the mesh all along, the nearest of a few lines that are, or else the longest
        part of one that is

    Raises
    ------
    SceneError : no such line lies in the mesh
    """
    grid = mesh.skfem
    low, high = grid.p.min(axis=1), grid.p.max(axis=1)
    positions = np.unique(np.asarray(wanted, dtype=float))
    given = len(positions) > 0
    if not given:
        if grid.dim() == 1:
            nodes = np.unique(grid.p[0])
            fractions = np.arange(SAMPLES) / SAMPLES
            positions = np.append(
                (nodes[:-1, None] + np.diff(nodes)[:, None] * fractions).ravel(),
                nodes[-1],
            )
        else:
            positions = np.linspace(low[mesh.axis], high[mesh.axis], EVENLY)
    others = [k for k in range(grid.dim()) if k != mesh.axis]
    names = ("r", "z") if mesh.axisymmetric else ("x", "y", "z")
    middle = 0.0 if mesh.axisymmetric else 0.5
    shares = (middle, *(share for share in ACROSS if share != middle))
    lines = (
        [tuple(low[others] + share * (high - low)[others]) for share in shares]
        if across is None
        else [across]
    )

    def at(place: Sequence[float], along: Array) -> Array:
        points = np.empty((grid.dim(), len(along)))
        points[mesh.axis], points[others] = along, np.asarray(place)[:, None]
        return points

    def where(place: Sequence[float]) -> str:
        pairs = zip(others, place, strict=True)
        return ", ".join(f"{names[other]} = {value:.4g} m" for other, value in pairs)

    for k, place in enumerate(lines):
        try:
            probe = Probe(mesh, at(place, positions))
        except ValueError:
            continue
        note = f"profiles are taken at {where(place)}: the middle is not in the mesh"
        return Line(mesh, positions, probe, note if k else "", given, across)
    if not given:
        ends = (float(low[mesh.axis]), float(high[mesh.axis]))
        parts = [_longest(_finder(mesh, partial(at, place)), *ends) for place in lines]
        best = max(range(len(parts)), key=lambda k: parts[k][1] - parts[k][0])
        (start, end), place = parts[best], lines[best]
        if end > start:
            positions = np.linspace(start, end, EVENLY)
            note = (
                f"profiles are taken at {where(place)}, from {names[mesh.axis]} = "
                f"{start:.4g} to {end:.4g} m: no line lies in the mesh from end to end"
            )
            probe = Probe(mesh, at(place, positions))
            return Line(mesh, positions, probe, note, given, across)
    raise SceneError(
        "output: no line along the bed lies in the mesh from end to end; give "
        "output.positions that do, "
        "or output.across, the other coordinates of the line"
    )


def _finder(mesh: Mesh, at: Callable[[Array], Array]) -> Callable[[float], bool]:
    """Return whether a mesh holds the point `at` a coordinate, as a function."""
    find = replace(mesh.skfem, _boundaries=None, _subdomains=None).element_finder()

    def inside(x: float) -> bool:
        try:
            find(*at(np.array([x])))
        except ValueError:
            return False
        return True

    return inside


def _longest(
    inside: Callable[[float], bool], low: float, high: float
) -> tuple[float, float]:
    """Return the ends of the longest part of a line from `low` to `high` that is
    inside; of no length where none is.
    """
    x = np.linspace(low, high, PIECES + 1)
    flags = np.array([False, *map(inside, x), False])
    starts, ends = (
        np.flatnonzero(flags[1:] & ~flags[:-1]),
        np.flatnonzero(~flags[1:] & flags[:-1]) - 1,
    )
    if not len(starts):
        return low, low
    k = int(np.argmax(x[ends] - x[starts]))
    first, last = starts[k], ends[k]
    return (
        _edge(inside, x[first], x[max(first - 1, 0)]),
        _edge(inside, x[last], x[min(last + 1, PIECES)]),
    )


def _edge(inside: Callable[[float], bool], within: float, beyond: float) -> float:
    """Return the last place inside between one that is and one that may not be."""
    if inside(beyond):
        return beyond
    for _ in range(HALVINGS):
        middle = 0.5 * (within + beyond)
        if inside(middle):
            within = middle
        else:
            beyond = middle
    return within


def peak(x: Array, y: Array) -> tuple[float, float]:
    """Return the place [m] and the value of the largest y between samples at increasing
    x: of a parabola through the largest and its neighbours, or at an end.

    >>> peak(np.array([0.0, 1.0, 2.0]), np.array([0.0, 3.0, 2.0]))
    (1.25, 3.125)
    """
    k = int(np.argmax(y))
    if k in (0, len(y) - 1) or not x[k - 1] < x[k] < x[k + 1]:
        return float(x[k]), float(y[k])
    left, right = x[k - 1] - x[k], x[k + 1] - x[k]
    fall_left, fall_right = (y[k - 1] - y[k]) / left, (y[k + 1] - y[k]) / right
    bend = (fall_right - fall_left) / (right - left)
    slope = fall_left - bend * left
    if not bend < 0.0:
        return float(x[k]), float(y[k])
    return float(x[k] - 0.5 * slope / bend), float(y[k] - 0.25 * slope**2 / bend)


def _jacobian(grid: object, cells: Integers, local: Array) -> Array:
    """Return derivatives of the place with respect to the reference coordinates
    (dim, dim, n).
    """
    corners = grid.p[:, grid.t[:, cells]]  # type: ignore[attr-defined]
    geometry = lagrange(grid.elem.refdom, 1)  # type: ignore[attr-defined]
    tables = [geometry.table(local, a) for a in range(geometry.dim)]
    return np.array(
        [np.einsum("ikn,kn->in", corners, table) for table in tables]
    ).swapaxes(0, 1)


def _local(mesh: Mesh, cells: Integers, points: Array) -> Array:
    """Find the reference coordinates (dim, n) of points in their cells by Newton's
    method from the middle of each.
    """
    grid = mesh.skfem
    corners, geometry = grid.p[:, grid.t[:, cells]], lagrange(grid.elem.refdom, 1)
    local = np.repeat(geometry.nodes.mean(axis=0)[:, None], points.shape[1], axis=1)
    for _ in range(ROUNDS):
        missing = points - np.einsum("ikn,kn->in", corners, geometry.table(local))
        jacobian = np.moveaxis(_jacobian(grid, cells, local), 2, 0)
        change = np.linalg.solve(jacobian, missing.T[:, :, None])[:, :, 0].T
        local = local + change
        if np.abs(change).max(initial=0.0) < CLOSE:
            break
    return local
