"""Engine for MPI on a line of discontinuous polynomials: assembled by DOLFINx, solved by MUMPS.

`System` has the interface of `fem.line_dg.System`. The root rank evaluates fluxes and sources by the same functions and
dual numbers; traces, gradients, integrals, residuals and matrices are those of DOLFINx, of the weak form that
`fem.dolfinx_line_parts` has in UFL. Problems with the same `Line` share what is distributed.
"""

from __future__ import annotations

from typing import ClassVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from skfem import MeshLine

from contbed.errors import ConvergenceError
from contbed.fem import dolfinx_line_parts as parts
from contbed.fem import line_dg
from contbed.fem.dolfinx import Partition
from contbed.fem.petsc import Layout, Matrix, PetscPolicy
from contbed.fem.ranks import rank_group

Array = NDArray[np.float64]


class Distributed:
    """Spaces and forms on a line, which all ranks hold as object `key`.

    nodes : those of each rank in turn, counted cell by cell
    counts : how many each rank has
    """

    known: ClassVar[WeakKeyDictionary[line_dg.Line, Distributed]] = WeakKeyDictionary()

    def __init__(self, line: line_dg.Line):
        self.ranks = rank_group()
        self.key = self.ranks.new_key()
        partition = Partition.of(self.ranks, MeshLine(line.vertices), shared=True)
        self.nodes, self.counts = self.ranks.run_on_all(
            parts.make_line, self.key, partition.key, line.nodes, line.weights
        )

    @classmethod
    def of(cls, line: line_dg.Line) -> Distributed:
        """Return what is distributed of a line, built at the first call."""
        if line not in cls.known:
            cls.known[line] = cls(line)
        return cls.known[line]

    def layout(self, unknowns: int) -> Layout:
        """Return the distribution of so many unknowns of each node."""
        size = len(self.nodes)
        order = self.nodes[:, None] + size * np.arange(unknowns)
        return Layout(order.ravel(), [unknowns * count for count in self.counts], unknowns * size)

    def __del__(self) -> None:
        self.ranks.released.append(self.key)


class System(line_dg.System):
    """The equations on a line that all ranks share; see `fem.line_dg.System`."""

    @property
    def on(self) -> Distributed:
        """What is distributed of the line."""
        return Distributed.of(self.line)

    @property
    def diffusing(self) -> parts.Diffusing:
        """Each field whose gradient enters a flux: its direction, at which vertices a value is given, and the value."""
        out, N = [], self.line.cells
        for f in np.flatnonzero(self.diffuses):
            given, value = np.zeros(N + 1), np.zeros(N + 1)
            at, k = (0, 0) if self.ahead[f] else (1, N)
            if np.isfinite(self.ends.value[at][f]):
                given[k], value[k] = 1.0, self.ends.value[at][f]
            out.append((int(f), float(self.ahead[f]), given, value))
        return out

    def sides(self, u: Array) -> line_dg.Sides:
        """Return the gradients of fields, and values and gradients at the ends of their cells."""
        diffusing, m = self.diffusing, self.m
        slopes, traces = self.on.ranks.run_on_all(parts.look, self.on.key, u.reshape(m, -1), diffusing)
        q, slope_low, slope_high = np.zeros_like(u), np.zeros(u.shape[:2]), np.zeros(u.shape[:2])
        fields = [f for f, *_ in diffusing]
        low, high = traces[:, 1, :-1], traces[:, 0, 1:]
        q[fields] = slopes.reshape(-1, *u.shape[1:])
        slope_low[fields], slope_high[fields] = low[m:], high[m:]
        return line_dg.Sides(q, low[:m], high[:m], slope_low, slope_high)

    def integrated(self, F: Array, source: Array, hat: Array) -> Array:
        """Return residuals from fluxes and sources at the nodes (m, N, p + 1), and fluxes at vertices (m, N + 1)."""
        fluxes, sources = F.reshape(self.m, -1), source.reshape(self.m, -1)
        found: Array = self.on.ranks.run_on_all(parts.residual, self.on.key, fluxes, sources, hat)
        return found.reshape(F.shape)

    def no_slopes(self) -> Slopes:
        """Return derivatives of the residuals to be added to."""
        return Slopes(self)


class Slopes:
    """Derivatives of the residuals by pairs of an equation and an unknown; gradients are unknowns behind the fields."""

    def __init__(self, system: System):
        self.system = system
        self.gradients = {f: system.m + k for k, (f, *_) in enumerate(system.diffusing)}
        self.inside: dict[tuple[int, int], Array] = {}
        self.at_vertices: dict[tuple[int, int], Array] = {}
        self.damping: dict[tuple[int, int], Array] = {}

    def _of(self, e: int, f: int, slot: str) -> tuple[Array, Array]:
        """Return the derivatives of a pair: (2, N, p + 1) of flux and source, (2, N + 1) by traces left and right."""
        pair = (e, f if slot == "u" else self.gradients[f])
        if pair not in self.inside:
            shape = self.system.line.points.shape
            self.inside[pair], self.at_vertices[pair] = np.zeros((2, *shape)), np.zeros((2, shape[0] + 1))
        return self.inside[pair], self.at_vertices[pair]

    def add_flux(self, e: int, f: int, slot: str, t: Array) -> None:
        """Add the derivative (N, p + 1) of the flux of an equation by the value ("u") or gradient ("q") of a field."""
        self._of(e, f, slot)[0][0] += t

    def add_source(self, e: int, f: int, slot: str, t: Array) -> None:
        """Add the derivative (N, p + 1) of the source of an equation by the value or gradient of a field."""
        self._of(e, f, slot)[0][1] += t

    def add_coupling(self, coupling: Array) -> None:
        """Add derivatives (m, m) of the sources of equations by the values of fields, alike at all nodes."""
        for e, f in np.argwhere(coupling):
            self.add_source(int(e), int(f), "u", coupling[e, f])

    def add_damping(self, e: int, f: int, t: Array) -> None:
        """Add the derivative (N, p + 1) of the flux of an equation by the slope of a field over its cell."""
        self.damping[e, f] = (t * self.system.line.h[:, None]).ravel()

    def add_face(self, e: int, f: int, slot: str, t: Array, left_side: bool) -> None:
        """Add d(flux)/d(trace) `t` (N + 1,) of one field, whose trace belongs to the cell on one side of each face.

        A trace from outside is that of the inside, but for a value that is prescribed.
        """
        found = self._of(e, f, slot)[1]
        found[0 if left_side else 1] += t
        outside, inside, end = (0, 1, 0) if left_side else (1, 0, -1)
        comes_in = left_side == bool(self.system.ahead[f])
        prescribed = np.isfinite(self.system.ends.value[outside][f])
        found[outside, end] -= t[end]
        if not (prescribed and comes_in and slot == "u"):
            found[inside, end] += t[end]

    def matrix(self, sizes: Array) -> Matrix:
        """Return the distributed matrix of the derivatives of residuals over sizes (m,).

        Raises
        ------
        ConvergenceError : a derivative is not finite
        """
        system, pairs = self.system, list(self.inside)
        scale = 1.0 / sizes[[row for row, _ in pairs]][:, None, None]
        inside, at_vertices = (
            np.array([table[pair] for pair in pairs]).reshape(len(pairs), 2, -1) * scale
            for table in (self.inside, self.at_vertices)
        )
        if not (np.isfinite(inside).all() and np.isfinite(at_vertices).all()):
            raise ConvergenceError("the matrix holds values that are not finite")
        on = system.on
        key = on.ranks.new_key()
        damped = [(e, f, t / sizes[e]) for (e, f), t in self.damping.items()]
        tables = (pairs, inside, at_vertices, damped, system.diffusing)
        on.ranks.run_on_all(parts.jacobian, on.key, key, system.m, *tables)
        return Matrix(on.ranks, key, on.layout(system.m))

    def factors(self, residuals: Array, _: Array) -> Factors:
        """Return the factors, to solve with, from typical values (m,) of residuals; MUMPS measures unknowns itself."""
        return Factors(self, residuals)


class Factors:
    """Factors by MUMPS, distributed.

    Raises
    ------
    ConvergenceError : the matrix is not finite, or singular where it is solved with
    """

    def __init__(self, slopes: Slopes, sizes: Array):
        self.sizes = sizes[:, None, None]
        self.inverse = slopes.matrix(sizes).inverse(PetscPolicy(1))

    def solve(self, residual: Array) -> Array:
        """Return the solution for a right-hand side (m, N, p + 1)."""
        found: Array = self.inverse((residual / self.sizes).ravel()).reshape(residual.shape)
        return found
