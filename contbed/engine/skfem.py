"""Assembly on scikit-fem meshes: a form is evaluated pointwise once, then contracted with reference basis tables.

`System` holds named unknowns (scalar or vector fields on Lagrange spaces), assembles the residual and exact Jacobian of
forms over cells or boundaries, and evaluates integrals. A form is `form(unknowns, tests, coeffs, ops)` and returns an
integrand linear in the tests. All geometry is folded into the pointwise coefficients, so that an element matrix is a
product with one small table that is the same for all cells.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from skfem.quadrature import get_quadrature

from contbed.engine.dual import Components, Dual, Linear
from contbed.engine.elements import Space, lagrange
from contbed.solve.linear import Policy
from contbed.solve.ordering import nested_dissection

Array = NDArray[np.float64]
Form = Callable[[Any, Any, Any, Any], Any]


class Domain:
    """Quadrature points of one integral: all cells, or the cells behind facets that share a local number.

    `x` (dim entries of (ncells, nq)), `weight` (ncells, nq) with the measure (times 2 pi r when axisymmetric),
    `inverse[a][k]` = dX_a/dx_k, `h` the longest edge (ncells, 1), `n` the outward normal on facets.
    """

    def __init__(
        self,
        mesh,
        order: int,
        *,
        axisymmetric: bool = False,
        section: float = 1.0,
        cells: NDArray | None = None,
        facet: int | None = None,
    ):
        refdom = mesh.elem.refdom
        self.refdom, self.dim, self.axisymmetric = refdom, mesh.dim(), axisymmetric
        self.cells = slice(None) if cells is None else cells
        if facet is None:
            self.X, W = get_quadrature(refdom, order)
        else:
            self.X, W = _facet_quadrature(refdom, facet, order)
        corners = mesh.p[:, mesh.t[:, self.cells]]
        geometry = lagrange(refdom, 1)
        affine = refdom.nnodes == self.dim + 1
        X = self.X[:, :1] if affine else self.X
        slopes = np.array([geometry.table(X, a) for a in range(self.dim)])
        jacobian = np.einsum("ikc,akq->iacq", corners, slopes)
        inverse, determinant = _invert(jacobian)
        self.inverse = [[inverse[a, k] for k in range(self.dim)] for a in range(self.dim)]
        self.x = Components(np.einsum("kc,kq->cq", corners[i], geometry.table(self.X)) for i in range(self.dim))
        weight = np.abs(determinant) * W
        self.n: Any = None
        if facet is not None:
            outward = np.asarray(refdom.normals[facet], dtype=float)
            outward = outward / np.linalg.norm(outward)
            normal = np.einsum("akcq,a->kcq", inverse, outward)
            length = np.sqrt((normal**2).sum(axis=0))
            weight = weight * length
            self.n = Components(normal / length)
        if axisymmetric:
            weight = weight * 2.0 * np.pi * self.x[0]
        self.weight = np.broadcast_to(section * weight, self.x[0].shape)
        edges = [(a, b) for a in range(refdom.nnodes) for b in range(a)] if affine else _edges(refdom)
        lengths = [np.linalg.norm(corners[:, a] - corners[:, b], axis=0) for a, b in edges]
        self.h = np.max(lengths, axis=0)[:, None]
        self._curvature = None if affine else [
            [np.einsum("ikc,kq->icq", corners, geometry.table(self.X, a, b)) for b in range(self.dim)]
            for a in range(self.dim)
        ]
        self._tables: dict[Any, Array] = {}

    def table(self, space: Space, kind: Any) -> Array:
        """Reference table of a slot: "v", ("g", a), ("h", a, b) or "low" (vertex interpolant): (nb, nq)."""
        key = (space.degree, kind)
        if key not in self._tables:
            if kind == "low":
                table = np.zeros((len(space.element.nodes), self.X.shape[1]))
                table[: space.element.nvertices] = lagrange(self.refdom, 1).table(self.X)
            else:
                table = space.element.table(self.X, *(() if kind == "v" else kind[1:]))
            self._tables[key] = table
        return self._tables[key]

    def pair_table(self, test: Space, test_kind: Any, trial: Space, trial_kind: Any) -> Array:
        """Products of two reference tables: (nq, nb_test * nb_trial)."""
        key = (test.degree, test_kind, trial.degree, trial_kind)
        if key not in self._tables:
            a, b = self.table(test, test_kind), self.table(trial, trial_kind)
            self._tables[key] = (a[:, None, :] * b[None, :, :]).reshape(-1, a.shape[1]).T.copy()
        return self._tables[key]

    def to_reference(self, slots: Mapping[Any, Any]) -> dict[Any, Any]:
        """Coefficients of physical slots expressed on reference slots."""
        out: dict[Any, Any] = {}

        def add(kind: Any, term: Any) -> None:
            out[kind] = out[kind] + term if kind in out else term

        for kind, c in slots.items():
            if kind in ("v", "low"):
                add(kind, c)
            elif kind[0] == "g":
                for a in range(self.dim):
                    add(("g", a), c * self.inverse[a][kind[1]])
            else:
                for a in range(self.dim):
                    for b in range(self.dim):
                        term = c * self.inverse[a][kind[1]] * self.inverse[b][kind[2]]
                        add(("h", a, b), term)
                        if self._curvature is not None:
                            for k in range(self.dim):
                                for m in range(self.dim):
                                    add(("g", m), -term * self._curvature[a][b][k] * self.inverse[m][k])
        return out


def _facet_quadrature(refdom: Any, facet: int, order: int) -> tuple[Array, Array]:
    vertices = refdom.p[:, refdom.facets[facet]]
    if refdom.dim() == 1:
        return vertices, np.ones(1)
    Y, W = get_quadrature(refdom.brefdom, order)
    spans = [vertices[:, [1]] - vertices[:, [0]], vertices[:, [-1]] - vertices[:, [0]]][: refdom.dim() - 1]
    X = vertices[:, [0]] + sum(span * Y[k] for k, span in enumerate(spans))
    area = np.linalg.norm(spans[0]) if len(spans) == 1 else np.linalg.norm(np.cross(spans[0].ravel(), spans[1].ravel()))
    return X, W * area


def _edges(refdom: Any) -> list[list[int]]:
    return refdom.facets if refdom.dim() == 2 else refdom.edges


def _invert(J: Any) -> tuple[Array, Array]:
    """Inverse and determinant of J[i, a] (first two axes), dimension 1 to 3."""
    dim = len(J)
    if dim == 1:
        return 1.0 / J, J[0, 0]
    if dim == 2:
        det = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
        return np.array([[J[1, 1], -J[0, 1]], [-J[1, 0], J[0, 0]]]) / det, det
    moved = np.moveaxis(J, (0, 1), (-2, -1))
    return np.moveaxis(np.linalg.inv(moved), (-2, -1), (0, 1)), np.linalg.det(moved)


class _Unknown(Dual):
    """A scalar unknown or known field at the quadrature points of one domain."""

    __slots__ = ("key", "local", "space", "where")

    def __init__(self, where: Domain, space: Space, local: Array, key: Any):
        self.where, self.space, self.local, self.key = where, space, local, key
        super().__init__(self.at("v"), {} if key is None else {(*key, "v"): 1.0})

    def at(self, kind: Any) -> Array:
        """Value of one reference slot at all points; derivatives from differences, which loses no digits to offsets."""
        local = self.local if kind in ("v", "low") else self.local - self.local[:, :1]
        return local @ self.where.table(self.space, kind)

    def slot(self, kind: Any) -> Dual:
        """The value of a physical slot with its derivative to itself."""
        value: Any = 0.0
        for reference, factor in self.where.to_reference({kind: 1.0}).items():
            value = value + factor * self.at(reference)
        return Dual(value, {} if self.key is None else {(*self.key, kind): 1.0})


class _Test(Linear):
    __slots__ = ("key", "where")

    def __init__(self, where: Domain, key: Any):
        self.where, self.key = where, key
        super().__init__({(*key, "v"): 1.0})


class Ops:
    """The vocabulary of forms on one domain; pointwise maths is numpy's."""

    def __init__(self, where: Domain):
        self._where = where
        self.x, self.h, self.n, self.dim = where.x, where.h, where.n, where.dim
        self.axisymmetric = where.axisymmetric

    def grad(self, field: Any) -> Components:
        """Gradient: a vector of a scalar field; rows are the gradients of the components of a vector field."""
        if isinstance(field, Components):
            return Components(self.grad(item) for item in field.items)
        if isinstance(field, _Test):
            return Components(Linear({(*field.key, ("g", k)): 1.0}) for k in range(self.dim))
        return Components(field.slot(("g", k)) for k in range(self.dim))

    def div(self, field: Components) -> Any:
        """Divergence of a vector field, hoop term included when axisymmetric."""
        gradient = self.grad(field)
        total = gradient[0][0]
        for k in range(1, self.dim):
            total = total + gradient[k][k]
        return total + self.hoop(field) if self.axisymmetric else total

    def hoop(self, field: Components) -> Any:
        """u_r / r when axisymmetric (the azimuthal entry of the gradient), else 0."""
        return field[0] / self.x[0] if self.axisymmetric else 0.0

    def hess(self, field: Any) -> Components:
        """Second derivatives of a scalar field in the plane of the mesh."""
        return Components(
            Components(field.slot(("h", *sorted((k, m)))) for m in range(self.dim)) for k in range(self.dim)
        )

    def laplacian(self, field: Any) -> Any:
        """Laplacian of a scalar field, with its first-derivative term when axisymmetric."""
        total = _sum(field.slot(("h", k, k)) for k in range(self.dim))
        return total + field.slot(("g", 0)) / self.x[0] if self.axisymmetric else total

    def low(self, field: Any) -> Any:
        """The piecewise linear interpolant of a scalar field at the vertices."""
        return field.slot("low")

    @staticmethod
    def dot(a: Components, b: Components) -> Any:
        """Scalar product of two vectors."""
        return _sum(p * q for p, q in zip(a.items, b.items, strict=True))

    @classmethod
    def inner(cls, a: Any, b: Any) -> Any:
        """Full contraction of two vectors or two matrices."""
        if isinstance(a[0], Components):
            return _sum(cls.dot(p, q) for p, q in zip(a.items, b.items, strict=True))
        return cls.dot(a, b)

    @classmethod
    def mul(cls, a: Components, b: Components) -> Components:
        """Matrix times vector."""
        return Components(cls.dot(row, b) for row in a.items)

    @staticmethod
    def transpose(a: Components) -> Components:
        """Transposed matrix."""
        return Components(Components(row[k] for row in a.items) for k in range(len(a[0])))


def _sum(terms: Any) -> Any:
    terms = list(terms)
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


class System:
    """Unknown fields on a mesh, the numbering of all their nodes, and assembly over domains.

    `fields` maps a name to (degree, ncomponents), 0 components for a scalar; vectors store component after component.
    `measure` may hold `axisymmetric` and `section`, the cross-section [m2] that a line stands for.
    """

    def __init__(self, mesh, fields: Mapping[str, tuple[int, int]], order: int, **measure: Any):
        self.mesh, self.order, self.measure = mesh, order, measure
        spaces: dict[int, Space] = {}
        self.fields: dict[str, tuple[Space, int]] = {}
        self.offset: dict[tuple[str, int], int] = {}
        size = 0
        for name, (degree, ncomponents) in fields.items():
            space = spaces.setdefault(degree, Space(mesh, degree))
            self.fields[name] = (space, ncomponents)
            for component in range(max(ncomponents, 1)):
                self.offset[name, component] = size
                size += space.size
        self.size = size
        self.cells = Domain(mesh, order, **measure)
        self._order: Any = None
        self._facets: dict[str, list[Domain]] = {}
        self._patterns: dict[Any, tuple[Array, Array, Array, int]] = {}

    def boundary(self, name: str) -> list[Domain]:
        """Domains that together integrate over a named boundary."""
        if name not in self._facets:
            mesh, facets = self.mesh, self.mesh.boundaries[name]
            cells = mesh.f2t[0, facets]
            local = np.argmax(mesh.t2f[:, cells] == facets, axis=0)
            self._facets[name] = [
                Domain(mesh, self.order, cells=cells[local == k], facet=int(k), **self.measure)
                for k in np.unique(local)
            ]
        return self._facets[name]

    def nodes(self, name: str, facets: NDArray, component: int = 0) -> NDArray[np.int64]:
        """Global numbers of the nodes of a field on facets."""
        return self.fields[name][0].on_facets(facets) + self.offset[name, component]

    def ordered(self, policy: Policy) -> Policy:
        """The policy with an order of elimination for this system; a line needs none."""
        if self.mesh.dim() == 1:
            return policy
        if self._order is None:
            centres = self.mesh.p[:, self.mesh.t].mean(axis=1)
            numbering = [self.fields[name][0].dofs + start for (name, _), start in self.offset.items()]
            self._order = nested_dissection(centres, numbering, self.size)
        return replace(policy, order=self._order)

    def part(self, state: Array, name: str) -> Array:
        """View of one field in a state: (size,) or (ncomponents, size)."""
        space, ncomponents = self.fields[name]
        start = self.offset[name, 0]
        view = state[start : start + max(ncomponents, 1) * space.size]
        return view.reshape(ncomponents, -1) if ncomponents else view

    def _trial(self, where: Domain, state: Array, differentiate: bool) -> SimpleNamespace:
        out = {}
        for name, (space, ncomponents) in self.fields.items():
            dofs = space.dofs[:, where.cells].T
            parts = [
                _Unknown(where, space, state[self.offset[name, c] + dofs], (name, c) if differentiate else None)
                for c in range(max(ncomponents, 1))
            ]
            out[name] = Components(parts) if ncomponents else parts[0]
        return SimpleNamespace(**out)

    def _tests(self, where: Domain) -> SimpleNamespace:
        out = {}
        for name, (_, ncomponents) in self.fields.items():
            parts = [_Test(where, (name, c)) for c in range(max(ncomponents, 1))]
            out[name] = Components(parts) if ncomponents else parts[0]
        return SimpleNamespace(**out)

    def known(self, where: Domain, space: Space, values: Array) -> Any:
        """A known finite-element field (values (size,) or (ncomponents, size)) as coefficient on `where`."""
        dofs = space.dofs[:, where.cells].T
        if values.ndim == 1:
            return _Unknown(where, space, values[dofs], None)
        return Components(_Unknown(where, space, row[dofs], None) for row in values)

    def integrate(self, expression: Callable[[Any, Any], Any], where: list[Domain], state: Array) -> float:
        """Integral of `expression(unknowns, ops)` over domains."""
        total = 0.0
        for domain in where:
            value = expression(self._trial(domain, state, False), Ops(domain))
            total += float(np.sum(domain.weight * getattr(value, "value", value)))
        return total

    def assemble(
        self, forms: Sequence[tuple[Form, Domain, Any]], state: Array, jacobian: bool = True
    ) -> tuple[Array, sp.csc_matrix | None]:
        """Residual and, if wanted, Jacobian of the sum of `(form, domain, coeffs)`."""
        residual = np.zeros(self.size)
        blocks: list[tuple[Any, Array]] = []
        for form, where, coeffs in forms:
            integrand = form(self._trial(where, state, jacobian), self._tests(where), coeffs, Ops(where))
            if isinstance(integrand, Linear):
                self._contract(integrand, where, residual, blocks if jacobian else None)
        if not jacobian:
            return residual, None
        return residual, self._matrix(blocks)

    def _contract(self, integrand: Linear, where: Domain, residual: Array, blocks: list[Any] | None) -> None:
        rows: dict[Any, dict[Any, Any]] = {}
        for (name, component, kind), c in integrand.slots.items():
            rows.setdefault((name, component), {})[kind] = c
        for key, slots in rows.items():
            space = self.fields[key[0]][0]
            values = {kind: getattr(c, "value", c) * where.weight for kind, c in slots.items()}
            local: Any = 0.0
            for kind, r in where.to_reference(values).items():
                local = local + r @ where.table(space, kind).T
            dofs = space.dofs[:, where.cells].T + self.offset[key]
            residual += np.bincount(dofs.ravel(), weights=local.ravel(), minlength=self.size)
            if blocks is not None:
                self._jacobian_rows(key, slots, where, blocks)

    def _jacobian_rows(self, key: Any, slots: Mapping[Any, Any], where: Domain, blocks: list[Any]) -> None:
        columns: dict[Any, dict[Any, dict[Any, Any]]] = {}
        for kind, c in slots.items():
            for (name, component, trial_kind), tangent in getattr(c, "tangents", {}).items():
                columns.setdefault((name, component), {}).setdefault(trial_kind, {})[kind] = tangent * where.weight
        space = self.fields[key[0]][0]
        for column, trial_slots in columns.items():
            trial = self.fields[column[0]][0]
            by_test: dict[Any, dict[Any, Any]] = {}
            for trial_kind, test_slots in trial_slots.items():
                for test_kind, d in where.to_reference(test_slots).items():
                    by_test.setdefault(test_kind, {})[trial_kind] = d
            local: Any = 0.0
            for test_kind, d_slots in by_test.items():
                for trial_kind, d in where.to_reference(d_slots).items():
                    local = local + d @ where.pair_table(space, test_kind, trial, trial_kind)
            blocks.append(((key, column, where), local))

    def _matrix(self, blocks: list[tuple[Any, Array]]) -> sp.csc_matrix:
        """Sum element matrices; the pattern of one list of blocks is found once and kept."""
        signature = tuple((key, column, id(where)) for (key, column, where), _ in blocks)
        if signature not in self._patterns:
            rows, columns = [], []
            for (key, column, where), _ in blocks:
                i = self.fields[key[0]][0].dofs[:, where.cells].T + self.offset[key]
                j = self.fields[column[0]][0].dofs[:, where.cells].T + self.offset[column]
                shape = (len(i), i.shape[1], j.shape[1])
                rows.append(np.broadcast_to(i[:, :, None], shape).ravel())
                columns.append(np.broadcast_to(j[:, None, :], shape).ravel())
            self._patterns[signature] = _pattern(np.concatenate(rows), np.concatenate(columns), self.size)
        position, indices, indptr, nnz = self._patterns[signature]
        data = np.bincount(position, weights=np.concatenate([local.ravel() for _, local in blocks]), minlength=nnz)
        return sp.csc_matrix((data, indices, indptr), shape=(self.size, self.size))


def _pattern(rows: NDArray, columns: NDArray, size: int) -> tuple[Any, Any, Any, int]:
    """Compressed-column structure of entries and the place of each entry in it."""
    keys = columns.astype(np.int64) * size + rows
    order = np.argsort(keys, kind="stable")
    new = np.empty(len(keys), dtype=bool)
    new[0] = True
    ordered = keys[order]
    np.not_equal(ordered[1:], ordered[:-1], out=new[1:])
    group = np.cumsum(new) - 1
    position = np.empty(len(keys), dtype=np.int32)
    position[order] = group
    unique = ordered[new]
    indptr = np.searchsorted(unique, np.arange(size + 1, dtype=np.int64) * size).astype(np.int32)
    return position, (unique % size).astype(np.int32), indptr, len(unique)
