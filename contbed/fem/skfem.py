"""Assembly on scikit-fem meshes: a form is evaluated pointwise once, then contracted
with reference basis tables.

`System` holds named unknowns (scalar or vector fields on Lagrange spaces), assembles
the residual and exact Jacobian of forms over cells or boundaries, and evaluates
integrals. A form is `form(unknowns, tests, coeffs, ops)` and returns an integrand
linear in the tests. All geometry is folded into the pointwise coefficients, so that an
element matrix is a product with one small table that is the same for all cells.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from skfem.mesh import Mesh as SkfemMesh

from contbed.arrays import Array, Integers
from contbed.fem.ad.dual import Components, Dual, Linear
from contbed.fem.domain import Domain
from contbed.fem.elements import GlobalUnknown, Space
from contbed.mesh.mesh import MeshEngine
from contbed.solvers.linear import Policy
from contbed.solvers.multigrid import Vertices
from contbed.solvers.ordering import nested_dissection

Form = Callable[[Any, Any, Any, Any], Any]


class _Unknown(Dual):
    """A scalar unknown or known field at the quadrature points of one domain."""

    __slots__ = ("key", "local", "space", "where")

    def __init__(self, where: Domain, space: Space, local: Array, key: Any):
        self.where, self.space, self.local, self.key = where, space, local, key
        super().__init__(self.at("v"), {} if key is None else {(*key, "v"): 1.0})

    def at(self, kind: Any) -> Array:
        """Return one reference slot at all points (ncells, nq).

        Derivatives are taken from differences to the first node, so that a large offset
        costs no digits.
        """
        local = self.local if kind in ("v", "low") else self.local - self.local[..., :1]
        return local @ self.where.table(self.space, kind)

    def slot(self, kind: Any) -> Dual:
        """Return the value of a physical slot with its derivative with respect to
        itself.
        """
        value: Any = 0.0
        for reference, factor in self.where.to_reference({kind: 1.0}).items():
            value = value + factor * self.at(reference)
        return Dual(value, {} if self.key is None else {(*self.key, kind): 1.0})


class _Test(Linear):
    __slots__ = ("key",)

    def __init__(self, key: Any):
        self.key = key
        super().__init__({(*key, "v"): 1.0})


class Ops:
    """The operators that a form may use on one domain; pointwise mathematics is
    numpy's.
    """

    def __init__(self, where: Domain, x: Any = None, h: Any = None):
        self._where = where
        self.x: Any = where.x if x is None else x
        self.h: Any = where.h if h is None else h
        self.n, self.dim = where.n, where.dim
        self.axisymmetric = where.axisymmetric

    def grad(self, field: Any) -> Components:
        """Return the gradient: a vector for a scalar field, a matrix with one row
        per component for a vector.
        """
        if isinstance(field, Components):
            return Components(self.grad(item) for item in field.items)
        if isinstance(field, _Test):
            return Components(
                Linear({(*field.key, ("g", k)): 1.0}) for k in range(self.dim)
            )
        return Components(field.slot(("g", k)) for k in range(self.dim))

    def div(self, field: Components) -> Any:
        """Return the divergence of a vector field, with the hoop term when
        axisymmetric.
        """
        gradient = self.grad(field)
        total = gradient[0][0]
        for k in range(1, self.dim):
            total = total + gradient[k][k]
        return total + self.hoop(field) if self.axisymmetric else total

    def hoop(self, field: Components) -> Any:
        """Return u_r / r when axisymmetric (the azimuthal entry of the gradient),
        else 0.
        """
        return field[0] / self.x[0] if self.axisymmetric else 0.0

    def hess(self, field: Any) -> Components:
        """Return the second derivatives of a scalar field in the plane of the mesh."""
        return Components(
            Components(field.slot(("h", *sorted((k, m)))) for m in range(self.dim))
            for k in range(self.dim)
        )

    def laplacian(self, field: Any) -> Any:
        """Return the Laplacian of a scalar field, with its first-derivative term
        when axisymmetric.
        """
        total = _sum(field.slot(("h", k, k)) for k in range(self.dim))
        return total + field.slot(("g", 0)) / self.x[0] if self.axisymmetric else total

    def low(self, field: Any) -> Any:
        """Return the piecewise linear interpolant of a scalar field at the vertices."""
        return field.slot("low")

    @staticmethod
    def dot(a: Components, b: Components) -> Any:
        """Return the scalar product of two vectors."""
        return _sum(p * q for p, q in zip(a.items, b.items, strict=True))

    @classmethod
    def inner(cls, a: Any, b: Any) -> Any:
        """Return the full contraction of two vectors or two matrices."""
        if isinstance(a[0], Components):
            return _sum(cls.dot(p, q) for p, q in zip(a.items, b.items, strict=True))
        return cls.dot(a, b)

    @classmethod
    def mul(cls, a: Components, b: Components) -> Components:
        """Return the product of a matrix and a vector."""
        return Components(cls.dot(row, b) for row in a.items)

    @staticmethod
    def outer(a: Components, b: Components) -> Components:
        """Return the matrix with rows a_i b of two vectors."""
        return Components(Components(p * q for q in b.items) for p in a.items)

    @staticmethod
    def transpose(a: Components) -> Components:
        """Return the transposed matrix."""
        return Components(
            Components(row[k] for row in a.items) for k in range(len(a[0]))
        )


def _sum(terms: Any) -> Any:
    terms = list(terms)
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


class System:
    """Unknown fields on a mesh, the numbering of all their nodes, and assembly over
    domains.

    `fields` maps a name to (degree, ncomponents), 0 components for a scalar; vectors
    store component after component. A field of degree 0 is one number for the whole
    mesh. `measure` may hold `axisymmetric` and `section`, the cross-section [m2] that a
    line stands for.
    """

    def __init__(
        self,
        mesh: SkfemMesh,
        fields: Mapping[str, tuple[int, int]],
        order: int,
        **measure: Any,
    ):
        self.mesh, self.order, self.measure = mesh, order, measure
        spaces: dict[int, Any] = {}
        self.fields: dict[str, tuple[Any, int]] = {}
        self.offset: dict[tuple[str, int], int] = {}
        size = 0
        for name, (degree, ncomponents) in fields.items():
            space = spaces.setdefault(
                degree, Space(mesh, degree) if degree else GlobalUnknown(mesh)
            )
            self.fields[name] = (space, ncomponents)
            for component in range(max(ncomponents, 1)):
                self.offset[name, component] = size
                size += space.size
        self.size = size
        self.cells = Domain(mesh, order, **measure)
        self._order: Any = None
        self._vertices: Vertices | None = None
        self._facets: dict[str, list[Domain]] = {}
        self._patterns: dict[
            Any, tuple[list[tuple[list[int], Any, Any]], Any, Any]
        ] = {}

    def boundary(self, name: str) -> list[Domain]:
        """Return the domains that together integrate over a named boundary."""
        if name not in self._facets:
            mesh, facets = self.mesh, self.mesh.boundaries[name]
            cells = mesh.f2t[0, facets]
            local = np.argmax(mesh.t2f[:, cells] == facets, axis=0)
            self._facets[name] = [
                Domain(
                    mesh,
                    self.order,
                    cells=cells[local == k],
                    facet=int(k),
                    **self.measure,
                )
                for k in np.unique(local)
            ]
        return self._facets[name]

    def nodes(
        self, name: str, facets: NDArray[np.int32], component: int = 0
    ) -> Integers:
        """Return the global numbers of the nodes of a field on facets."""
        numbers: Integers = (
            self.fields[name][0].on_facets(facets) + self.offset[name, component]
        )
        return numbers

    def ordered(self, policy: Policy) -> Policy:
        """Return the policy with a nested-dissection ordering and, in 3-D, what
        multigrid needs; a line needs none.
        """
        if self.mesh.dim() == 1:
            return policy
        if self._order is None:
            corners = self.mesh.p[:, self.mesh.t]
            # extents count in cells: a plane then meets the fewest, however long they
            # are
            centres = corners.mean(axis=1) / np.ptp(corners, axis=1).mean(
                axis=1, keepdims=True
            )
            numbering = [
                self.fields[name][0].dofs + start
                for (name, _), start in self.offset.items()
            ]
            self._order = nested_dissection(centres, numbering, self.size)
        if self.mesh.dim() < 3 or any(
            ncomponents or not space.degree
            for space, ncomponents in self.fields.values()
        ):
            return replace(policy, order=self._order)
        return replace(
            policy, order=self._order, multigrid=True, vertices=self._from_vertices
        )

    def _from_vertices(self) -> Vertices:
        """Return the interpolation of all fields, which are scalar, from the
        vertices.
        """
        if self._vertices is None:
            count = len(self.fields)
            parts = [
                sp.kron(space.from_vertices(), np.eye(count)[[k]])
                for k, (space, _) in enumerate(self.fields.values())
            ]
            self._vertices = Vertices(sp.vstack(parts).tocsr(), count)
        return self._vertices

    def part(self, state: Array, name: str) -> Array:
        """Return a view of one field in a state: (size,) or (ncomponents, size)."""
        space, ncomponents = self.fields[name]
        start = self.offset[name, 0]
        view = state[start : start + max(ncomponents, 1) * space.size]
        return view.reshape(ncomponents, -1) if ncomponents else view

    def _trial(
        self, where: Domain, state: Array, differentiate: bool
    ) -> SimpleNamespace:
        out = {}
        for name, (space, ncomponents) in self.fields.items():
            dofs = space.dofs[:, where.cells].T
            parts = [
                _Unknown(
                    where,
                    space,
                    state[self.offset[name, c] + dofs],
                    (name, c) if differentiate else None,
                )
                for c in range(max(ncomponents, 1))
            ]
            out[name] = Components(parts) if ncomponents else parts[0]
        return SimpleNamespace(**out)

    def tests(self) -> SimpleNamespace:
        """Return the test functions of all fields by name."""
        out = {}
        for name, (_, ncomponents) in self.fields.items():
            parts = [_Test((name, c)) for c in range(max(ncomponents, 1))]
            out[name] = Components(parts) if ncomponents else parts[0]
        return SimpleNamespace(**out)

    def known(self, where: Domain, space: Space, values: Array) -> Any:
        """Return a known finite-element field, values (size,) or (ncomponents,
        size), as coefficient on `where`.
        """
        dofs = space.dofs[:, where.cells].T
        if values.ndim == 1:
            return _Unknown(where, space, values[dofs], None)
        return Components(_Unknown(where, space, row[dofs], None) for row in values)

    def integrate(
        self, expression: Callable[[Any, Any], Any], where: list[Domain], state: Array
    ) -> float:
        """Integrate `expression(unknowns, ops)` over domains."""
        total = 0.0
        for domain in where:
            value = expression(self._trial(domain, state, False), Ops(domain))
            total += float(np.sum(domain.weight * getattr(value, "value", value)))
        return total

    def assemble(
        self,
        forms: Sequence[tuple[Form, Domain, Any]],
        state: Array,
        jacobian: bool = True,
    ) -> tuple[Array, sp.csc_matrix | None]:
        """Assemble the residual and, if wanted, the Jacobian of the sum of `(form,
        domain, coeffs)`.
        """
        residual = np.zeros(self.size)
        blocks: list[tuple[Any, Array]] = []
        for form, where, coeffs in forms:
            integrand = form(
                self._trial(where, state, jacobian), self.tests(), coeffs, Ops(where)
            )
            if isinstance(integrand, Linear):
                self._contract(integrand, where, residual, blocks if jacobian else None)
        if not jacobian:
            return residual, None
        return residual, self._matrix(blocks)

    def _contract(
        self,
        integrand: Linear,
        where: Domain,
        residual: Array,
        blocks: list[Any] | None,
    ) -> None:
        rows: dict[Any, dict[Any, Any]] = {}
        for (name, component, kind), c in integrand.slots.items():
            rows.setdefault((name, component), {})[kind] = c
        for key, slots in rows.items():
            space = self.fields[key[0]][0]
            values = {
                kind: getattr(c, "value", c) * where.weight for kind, c in slots.items()
            }
            local: Any = 0.0
            for kind, r in where.to_reference(values).items():
                local = local + r @ where.table(space, kind).T
            dofs = space.dofs[:, where.cells].T + self.offset[key]
            residual += np.bincount(
                dofs.ravel(), weights=local.ravel(), minlength=self.size
            )
            if blocks is not None:
                self._jacobian_rows(key, slots, where, blocks)

    def _jacobian_rows(
        self, key: Any, slots: Mapping[Any, Any], where: Domain, blocks: list[Any]
    ) -> None:
        columns: dict[Any, dict[Any, dict[Any, Any]]] = {}
        for kind, c in slots.items():
            for (name, component, trial_kind), tangent in getattr(
                c, "tangents", {}
            ).items():
                columns.setdefault((name, component), {}).setdefault(trial_kind, {})[
                    kind
                ] = tangent * where.weight
        space = self.fields[key[0]][0]
        for column, trial_slots in columns.items():
            trial = self.fields[column[0]][0]
            by_test: dict[Any, dict[Any, Any]] = {}
            for trial_kind, test_slots in trial_slots.items():
                for test_kind, d in where.to_reference(test_slots).items():
                    by_test.setdefault(test_kind, {})[trial_kind] = d
            factors, tables = [], []
            for test_kind, d_slots in by_test.items():
                for trial_kind, d in where.to_reference(d_slots).items():
                    factors.append(d)
                    tables.append(where.pair_table(space, test_kind, trial, trial_kind))
            local = np.concatenate(factors, axis=1) @ np.concatenate(tables)
            blocks.append(((key, column, where), local))

    def _matrix(self, blocks: list[tuple[Any, Array]]) -> sp.csc_matrix:
        """Sum element matrices."""
        parts, indices, indptr = self.pattern([key for key, _ in blocks])
        data = np.empty(len(indices))
        for numbers, position, place in parts:
            weights = np.concatenate([blocks[k][1].ravel() for k in numbers])
            data[place] = np.bincount(position, weights=weights, minlength=len(place))
        return sp.csc_matrix((data, indices, indptr), shape=(self.size, self.size))

    def pattern(
        self, keys: list[Any]
    ) -> tuple[list[tuple[list[int], Any, Any]], Any, Any]:
        """Return the compressed-column structure that blocks (row, column, domain)
        fill: parts, rows, starts.

        It is found once for a list of blocks and kept. A part has, for one pair of row
        and column, the numbers of its blocks, the place of each of their entries in the
        structure of the pair, and the place of that in the whole.
        """
        signature = tuple((row, column, id(where)) for row, column, where in keys)
        if signature not in self._patterns:
            self._patterns[signature] = self._pattern(keys)
        return self._patterns[signature]

    def _pattern(
        self, keys: list[Any]
    ) -> tuple[list[tuple[list[int], Any, Any]], Any, Any]:
        groups: dict[Any, list[int]] = {}
        for number, (row, column, _) in enumerate(keys):
            groups.setdefault((row, column), []).append(number)
        known: dict[Any, tuple[Any, Any]] = {}
        pairs = {
            (row, column): self._pair(row, column, [keys[k][2] for k in numbers], known)
            for (row, column), numbers in groups.items()
        }
        counts = np.zeros(self.size, dtype=np.int64)
        for (_, column), (_, _, widths) in pairs.items():
            counts[self.offset[column] :][: len(widths)] += widths
        indptr = np.concatenate(([0], np.cumsum(counts)))
        filled, parts = indptr[:-1].copy(), []
        indices = np.empty(indptr[-1], dtype=np.int32)
        # rows of a column in ascending order
        for pair in sorted(pairs, key=lambda pair: self.offset[pair[0]]):
            (row, column), (position, rows, widths) = pair, pairs[pair]
            free = filled[self.offset[column] :][: len(widths)]
            place = np.arange(len(rows)) + np.repeat(
                free - (np.cumsum(widths) - widths), widths
            )
            free += widths
            indices[place] = rows + self.offset[row]
            parts.append((groups[pair], position, place.astype(np.int32)))
        return parts, indices, indptr.astype(np.int32)

    def _pair(
        self, row: Any, column: Any, domains: list[Domain], known: dict[Any, Any]
    ) -> tuple[Any, Any, Any]:
        """Return the place of each entry, the rows, and how many each column has, of
        one pair of fields on domains.

        `known` keeps the entries that all cells have, as fields on the same spaces
        share them.
        """
        test, trial = self.fields[row[0]][0], self.fields[column[0]][0]

        def entries(where: Domain) -> Any:
            i, j = (
                space.dofs[:, where.cells].T.astype(np.int64) for space in (test, trial)
            )
            return (j[:, None, :] * test.size + i[:, :, None]).ravel()

        if self.cells in domains:
            space_pair = id(test), id(trial)
            if space_pair not in known:
                known[space_pair] = np.unique(entries(self.cells), return_inverse=True)
            unique, inside = known[space_pair]
            places = [
                inside if d is self.cells else np.searchsorted(unique, entries(d))
                for d in domains
            ]
        else:
            unique, inside = np.unique(
                np.concatenate([entries(d) for d in domains]), return_inverse=True
            )
            places = [inside]
        widths = np.bincount(unique // test.size, minlength=trial.size)
        return (
            np.concatenate(places).astype(np.int32),
            (unique % test.size).astype(np.int32),
            widths,
        )


ENGINE = MeshEngine(System, Policy)
