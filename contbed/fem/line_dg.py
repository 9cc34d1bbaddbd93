"""Discontinuous polynomials on a line: conservation laws with fluxes that are taken
from upwind, and their matrices.

Each unknown u_f of the fields f = 1..m is a polynomial of degree p in each cell, given
at its p + 1 Gauss points. Every equation e of a point is

    d/dx [ C_e(u) + D_e(u, u') ] = S_e(u)

tested with the same polynomials; fluxes of cells meet at the ends of the cells:

    C from the traces upwind, D from the traces on the other side (local discontinuous Galerkin, alternating fluxes),
    u' h = u_xi + (u_upwind - u) phi/w   at the end from which u comes.

Where `damping` d of a field is given, a flux J = - d du/dxi adds inside of the cell, xi
in [0, 1], and none at its ends: what passes and is held stays the same, and the field
is flat where d is large. What comes with J in other equations the point determines. A
field that is a flux to the left has d below zero.

Fields that come from the left and from the right share the points, so that what one
gains the other loses exactly, and the sum of an equation over all cells is flux
in = flux out + source to rounding. Fields are of order p + 1. Where D = 0 and all
fields have one direction fluxes at the ends of the cells are those of Radau's
collocation, of order 2 p + 1.

Source: Cockburn, Shu 1998, SIAM J. Numer. Anal. 35, 2440-2463,
    doi:10.1137/S0036142997316712.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from contbed.arrays import Array, Flags
from contbed.fem.ad.dual import Dual, plain
from contbed.fem.line_slopes import Slopes

Values = list[Any]


class Point(Protocol):
    """Fluxes and sources of all equations at points, from values and gradients of
    all fields, and positions.
    """

    def __call__(
        self, u: Values, q: Values, x: Any, /
    ) -> tuple[Values, Values, Values]:
        """Return convective fluxes, diffusive fluxes and sources."""

    def convective(self, u: Values) -> Values:
        """Return convective fluxes alone."""

    def diffusive(self, u: Values, q: Values) -> Values:
        """Return diffusive fluxes alone."""

    def damped(self, u: Values, J: Values) -> Values:
        """Return the fluxes of all equations that come with fluxes J by which fields
        are damped.
        """


@dataclass(frozen=True, eq=False)
class Line:
    """Cells of a line with polynomials of one degree.

    vertices : (N + 1,) increasing [m]
    degree : p, 0 for one value a cell
    """

    vertices: Array
    degree: int

    @property
    def cells(self) -> int:
        """Number of cells."""
        return len(self.vertices) - 1

    @cached_property
    def h(self) -> Array:
        """Lengths of the cells (N,)."""
        return np.diff(self.vertices)

    @cached_property
    def nodes(self) -> Array:
        """Gauss points in [0, 1], (p + 1,)."""
        return 0.5 * (1.0 + np.polynomial.legendre.leggauss(self.degree + 1)[0])

    @cached_property
    def weights(self) -> Array:
        """Weights of the Gauss points, of sum 1."""
        return 0.5 * np.polynomial.legendre.leggauss(self.degree + 1)[1]

    @cached_property
    def points(self) -> Array:
        """Positions of the nodes (N, p + 1)."""
        return self.vertices[:-1, None] + self.h[:, None] * self.nodes

    def basis(self, xi: Any) -> Array:
        """Return the values of the Lagrange polynomials of the nodes at `xi`
        in [0, 1], (len(xi), p + 1).
        """
        xi = np.atleast_1d(np.asarray(xi, dtype=float))
        out = np.ones((len(xi), self.degree + 1))
        for j, node in enumerate(self.nodes):
            for k, other in enumerate(self.nodes):
                if k != j:
                    out[:, j] *= (xi - other) / (node - other)
        return out

    @cached_property
    def left(self) -> Array:
        """Values of the polynomials at the left end of a cell."""
        found: Array = self.basis(0.0)[0]
        return found

    @cached_property
    def right(self) -> Array:
        """Values of the polynomials at the right end of a cell."""
        found: Array = self.basis(1.0)[0]
        return found

    @cached_property
    def sampled(self) -> Array:
        """Values of the polynomials at 13 points of a cell, ends included, (13,
        p + 1).
        """
        return self.basis(np.linspace(0.0, 1.0, 13))

    @cached_property
    def finely_sampled(self) -> Array:
        """Values of the polynomials at 129 points, ends included, (129, p + 1)."""
        return self.basis(np.linspace(0.0, 1.0, 129))

    @cached_property
    def slopes(self) -> Array:
        """Derivatives of the polynomials at the nodes, (node, polynomial)."""
        n = self.degree + 1
        out = np.zeros((n, n))
        for j in range(n):
            others = [k for k in range(n) if k != j]
            scale = np.prod([self.nodes[j] - self.nodes[k] for k in others])
            for i in range(n):
                terms = [
                    np.prod(
                        [self.nodes[i] - self.nodes[k] for k in others if k != skip]
                    )
                    for skip in others
                ]
                out[i, j] = sum(terms) / scale
        return out

    def at(self, values: Array, x: Any) -> Array:
        """Return fields (..., N, p + 1) at positions `x`, (..., len(x)); a vertex
        belongs to the cell left of it.
        """
        x = np.atleast_1d(np.asarray(x, dtype=float))
        cell = np.clip(
            np.searchsorted(self.vertices, x, side="left") - 1, 0, self.cells - 1
        )
        basis = self.basis((x - self.vertices[cell]) / self.h[cell])
        found: Array = np.einsum("...xj,xj->...x", values[..., cell, :], basis)
        return found

    def top_mode(self, values: Array) -> Array:
        """Return the amplitude of the Legendre polynomial of degree p in each cell,
        (..., N); none of one value a cell.
        """
        if self.degree == 0:
            return np.zeros(values.shape[:-1])
        legendre = np.polynomial.legendre.Legendre.basis(self.degree)(
            2.0 * self.nodes - 1.0
        )
        share: Array = np.abs(values @ (self.weights * legendre)) * (
            2 * self.degree + 1
        )
        return share


@dataclass(frozen=True)
class Ends:
    """What holds at both ends of the line.

    inflow : fluxes of all equations at (left, right), used where `given` is true
    given : per equation, whether its flux at (left, right) is prescribed; else it is
        that of the traces inside, without diffusion
    value : per field, values at (left, right) that the trace from outside takes; nan
        where it is that of the inside
    """

    inflow: tuple[Array, Array]
    given: tuple[Flags, Flags]
    value: tuple[Array, Array]


@dataclass(frozen=True)
class Sides:
    """What fields are within their cells, by field and cell (m, N).

    gradients : at the nodes (m, N, p + 1); zero for those that do not diffuse
    low, high : values at the left and the right end of each cell
    slope_low, slope_high : gradients there
    """

    gradients: Array
    low: Array
    high: Array
    slope_low: Array
    slope_high: Array


class System:
    """The equations on a line, for fields with fixed directions.

    directions : +1 where a field is taken from the left, -1 from the right
    diffuses : whether the gradient of a field enters a flux
    point : fluxes and sources of a point
    local : fields whose equations have no fluxes and that are in no flux
    coupling : (m, m) sources of equations per value of fields that add to those of
        `point`, where they are constant
    damping : (m, N) of fields in cells, in flux per value; none in local ones
    """

    def __init__(
        self,
        line: Line,
        directions: Sequence[int],
        diffuses: Sequence[bool],
        point: Point,
        ends: Ends,
        local: Sequence[int] = (),
        coupling: Array | None = None,
        damping: Array | None = None,
    ):
        self.line, self.point, self.ends = line, point, ends
        self.local, self.coupling, self.damping = tuple(local), coupling, damping
        self.ahead = np.asarray(directions) > 0
        self.diffuses = np.asarray(diffuses)
        self.m = len(self.ahead)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.m * self.line.cells * (self.line.degree + 1)

    def sides(self, u: Array) -> Sides:
        """Return the gradients of fields, and values and gradients at the ends of
        their cells.
        """
        line, q = self.line, np.zeros_like(u)
        for f in np.flatnonzero(self.diffuses):
            q[f] = u[f] @ line.slopes.T
            lift = self._jump(u, int(f))
            end = line.left if self.ahead[f] else line.right
            q[f] += lift[:, None] * (end / line.weights)
            q[f] /= line.h[:, None]
        return Sides(q, u @ line.left, u @ line.right, q @ line.left, q @ line.right)

    def _jump(self, u: Array, f: int) -> Array:
        """Return the jump at the end from which field f comes, times the sign of
        that end's normal (N,).
        """
        line, jump = self.line, np.zeros(self.line.cells)
        low, high = u[f] @ line.left, u[f] @ line.right
        left, right = self.ends.value
        if self.ahead[f]:
            jump[1:] = low[1:] - high[:-1]
            jump[0] = low[0] - left[f] if np.isfinite(left[f]) else 0.0
        else:
            jump[:-1] = low[1:] - high[:-1]
            jump[-1] = right[f] - high[-1] if np.isfinite(right[f]) else 0.0
        return jump

    def traces(self, sides: Sides) -> tuple[Array, Array, Array]:
        """Return upwind values, values and gradients on the other side, each (m,
        N + 1).
        """
        shape = (self.m, self.line.cells + 1)
        low, high = sides.low, sides.high
        left, right = self.ends.value
        # values at the vertices from the cell on the left and on the right; at an end
        # what is prescribed, or the inside
        from_left, from_right = np.empty(shape), np.empty(shape)
        from_left[:, 1:], from_right[:, :-1] = high, low
        from_left[:, 0] = np.where(np.isfinite(left), left, low[:, 0])
        from_right[:, -1] = np.where(np.isfinite(right), right, high[:, -1])
        ahead = self.ahead[:, None]
        up = np.where(ahead, from_left, from_right)
        down = np.where(ahead, from_right, from_left)
        # at an end that a field leaves by, the other side is the inside as well
        down[self.ahead, -1] = high[self.ahead, -1]
        down[~self.ahead, 0] = low[~self.ahead, 0]
        slope = np.zeros(shape)
        if self.diffuses.any():
            qlow, qhigh = sides.slope_low, sides.slope_high
            slope_left = np.concatenate([qlow[:, :1], qhigh], axis=1)
            slope_right = np.concatenate([qlow, qhigh[:, -1:]], axis=1)
            slope = np.where(ahead, slope_right, slope_left)
        return up, down, slope

    def fluxes(self, u: Array) -> Array:
        """Return the fluxes of all equations through all vertices (m, N + 1)."""
        up, down, slope = self.traces(self.sides(u))
        convective = self.point.convective(list(up))
        diffusive = (
            self.point.diffusive(list(down), list(slope))
            if self.diffuses.any()
            else [0.0] * self.m
        )
        total = np.array(
            [
                np.broadcast_to(c + d, up[0].shape)
                for c, d in zip(convective, diffusive, strict=True)
            ]
        )
        return self._at_ends(
            total, np.array([np.broadcast_to(c, up[0].shape) for c in convective])
        )

    def _at_ends(self, total: Array, convective: Array) -> Array:
        for end, k in ((0, 0), (1, -1)):
            given = self.ends.given[end]
            fixed = np.isfinite(self.ends.value[end])
            inside = np.where(fixed.any(), total[:, k], convective[:, k])
            total[:, k] = np.where(given, self.ends.inflow[end], inside)
        return total

    def sources(self, u: Array) -> Array:
        """Return the integrals of the sources of all equations over the line (m,)."""
        q = self.sides(u).gradients
        shape = u[0].shape
        values = self.point(
            [x.ravel() for x in u], [x.ravel() for x in q], self.line.points.ravel()
        )[2]
        table = np.array(
            [np.broadcast_to(v, (u[0].size,)).reshape(shape) for v in values]
        )
        if self.coupling is not None:
            table += np.tensordot(self.coupling, u, axes=1)
        total: Array = np.einsum("ecj,j,c->e", table, self.line.weights, self.line.h)
        return total

    def assemble(self, u: Array, jacobian: bool = True) -> tuple[Array, Any]:
        """Return the residuals (m, N, p + 1), flux out less flux in less source, and
        their derivatives `Slopes`.
        """
        line, m, n, N = self.line, self.m, self.line.degree + 1, self.line.cells
        sides = self.sides(u)
        shape = (N * n,)
        values, grads = _seeded(
            u.reshape(m, -1), sides.gradients.reshape(m, -1), self.diffuses, jacobian
        )
        C, D, S = self.point(values, grads, line.points.ravel())
        up, down, slope = self.traces(sides)
        values, grads = _seeded(up, slope, self.diffuses, jacobian)
        Cf = self.point.convective(values)
        values, grads = _seeded(down, slope, self.diffuses, jacobian)
        Df = self.point.diffusive(values, grads) if self.diffuses.any() else [0.0] * m

        F = _values(C, shape, m).reshape(m, N, n) + _values(D, shape, m).reshape(
            m, N, n
        )
        E: Values = (
            [] if self.damping is None else self._damped(u, self.damping, jacobian)
        )
        if E:
            F += _values(E, shape, m).reshape(m, N, n)
        source = _values(S, shape, m).reshape(m, N, n)
        if self.coupling is not None:
            source += np.tensordot(self.coupling, u, axes=1)
        convective = _values(Cf, (N + 1,), m)
        hat = self._at_ends(convective + _values(Df, (N + 1,), m), convective)
        residual = self._integrated(F, source, hat)
        if not jacobian:
            return residual, None
        slopes = Slopes(self)
        self._differentiate(C, D, S, slopes)
        if self.damping is not None:
            self._differentiate_damping(E, self.damping, slopes)
        self._differentiate_faces(Cf, Df, slopes)
        return residual, slopes

    def _integrated(self, F: Array, source: Array, hat: Array) -> Array:
        """Return residuals from fluxes and sources at the nodes (m, N, p + 1), and
        fluxes at vertices (m, N + 1).
        """
        line = self.line
        test = line.weights[:, None] * line.slopes  # (node j, test i): w_j phi_i'(xi_j)
        residual: Array = -(F @ test)
        residual += hat[:, 1:, None] * line.right - hat[:, :-1, None] * line.left
        residual -= source * line.weights * line.h[:, None]
        return residual

    def _differentiate(self, C: Values, D: Values, S: Values, slopes: Any) -> None:
        """Add the derivatives of fluxes and sources at the nodes."""
        shape = self.line.points.shape
        for e in range(self.m):
            fluxes = (
                () if e in self.local else ((C, slopes.add_flux), (D, slopes.add_flux))
            )
            for parts, add in (*fluxes, (S, slopes.add_source)):
                for (slot, f), tangent in getattr(parts[e], "tangents", {}).items():
                    add(
                        e,
                        f,
                        slot,
                        np.broadcast_to(tangent, (shape[0] * shape[1],)).reshape(shape),
                    )
        if self.coupling is not None:
            slopes.add_coupling(self.coupling)

    def _damped(self, u: Array, damping: Array, jacobian: bool) -> Values:
        """Return the fluxes of all equations by damping; slot "J" are those of the
        fields.
        """
        line, m = self.line, self.m
        # of the means, whose rounding large damping would keep
        beyond = u - (u @ line.weights)[:, :, None]
        J = (-damping[:, :, None] * (beyond @ line.slopes.T)).reshape(m, -1)
        values, _ = _seeded(u.reshape(m, -1), J, self.diffuses, jacobian)
        one = np.ones(J.shape[1])
        return self.point.damped(
            values,
            [Dual(x, {("J", f): one}) if jacobian else x for f, x in enumerate(J)],
        )

    def _differentiate_damping(self, E: Values, damping: Array, slopes: Any) -> None:
        """Add the derivatives of fluxes by damping, by the values and by the slopes
        of fields within their cells.
        """
        shape = self.line.points.shape
        for e, flux in enumerate(E):
            for (slot, f), tangent in getattr(flux, "tangents", {}).items():
                t = np.broadcast_to(tangent, (shape[0] * shape[1],)).reshape(shape)
                if slot == "u":
                    slopes.add_flux(e, f, slot, t)
                elif damping[f].any():
                    slopes.add_damping(e, f, -t * damping[f][:, None])

    def _differentiate_faces(self, Cf: Values, Df: Values, slopes: Any) -> None:
        """Add the derivatives of the fluxes through the vertices."""
        N = self.line.cells
        fixed = [np.isfinite(value).any() for value in self.ends.value]
        for e in np.setdiff1d(range(self.m), self.local):
            for parts, upwind in ((Cf, True), (Df, False)):
                for (slot, f), tangent in getattr(parts[e], "tangents", {}).items():
                    t = np.empty(N + 1)
                    t[:] = tangent
                    for end, k in ((0, 0), (1, N)):
                        if self.ends.given[end][e] or not (upwind or fixed[end]):
                            t[k] = 0.0
                    # whether the trace is that of the cell on the left
                    left_side = bool(self.ahead[f]) == upwind
                    if slot == "q":
                        left_side = not self.ahead[f]
                    slopes.add_face(e, f, slot, t, left_side)


def _seeded(u: Array, q: Array, diffuses: Any, jacobian: bool) -> tuple[Values, Values]:
    """Return fields and gradients as dual numbers with slots ("u", f) and ("q", f)."""
    if not jacobian:
        return list(u), list(q)
    one = np.ones(u.shape[1])
    values: Values = [Dual(x, {("u", f): one}) for f, x in enumerate(u)]
    grads: Values = [
        Dual(x, {("q", f): one}) if diffuses[f] else x for f, x in enumerate(q)
    ]
    return values, grads


def _values(parts: Values, shape: tuple[int, ...], m: int) -> Array:
    out = np.empty((m, *shape))
    for k, part in enumerate(parts):
        out[k] = plain(part)
    return out
