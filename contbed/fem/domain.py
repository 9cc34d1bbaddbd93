"""Quadrature on cells and facets of scikit-fem meshes; geometry is kept apart from
the reference tables.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np
from skfem.mesh import Mesh as SkfemMesh
from skfem.quadrature import get_quadrature

from contbed.arrays import Array, Integers
from contbed.fem.ad.dual import Components, plain
from contbed.fem.elements import Space, lagrange

# share of the coordinates below which a slope of the geometry is round-off
ROUNDING = 1e-14


class Domain:
    """Quadrature points of one integral: all cells, or the cells behind facets that
    share a local number.

    `x` (dim entries of (ncells, nq)), `weight` (ncells, nq) with the measure (times 2
    pi r when axisymmetric), `inverse[a][k]` = dX_a/dx_k, `h` the longest edge (ncells,
    1), `n` the outward normal on facets. They are made when first asked for: the root
    rank of several asks for those of facets only.
    """

    def __init__(
        self,
        mesh: SkfemMesh,
        order: int,
        *,
        axisymmetric: bool = False,
        section: float = 1.0,
        cells: Integers | None = None,
        facet: int | None = None,
    ):
        self.mesh, self.section, self.facet = mesh, section, facet
        self.refdom, self.dim, self.axisymmetric = (
            mesh.elem.refdom,
            mesh.dim(),
            axisymmetric,
        )
        self.cells = slice(None) if cells is None else cells
        if facet is None:
            self.X, self._W = get_quadrature(self.refdom, order)
        else:
            self.X, self._W = _facet_quadrature(self.refdom, facet, order)
        self._tables: dict[Any, Array] = {}

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells and of points in each."""
        return self.mesh.t[0, self.cells].size, self.X.shape[1]

    @property
    def _corners(self) -> Array:
        corners: Array = self.mesh.p[:, self.mesh.t[:, self.cells]]
        return corners

    @property
    def _simplex(self) -> bool:
        return bool(self.refdom.nnodes == self.dim + 1)

    @cached_property
    def x(self) -> Components:
        """Coordinates of the points."""
        table, corners = lagrange(self.refdom, 1).table(self.X), self._corners
        return Components(
            np.einsum("kc,kq->cq", corners[i], table) for i in range(self.dim)
        )

    @cached_property
    def h(self) -> Array:
        """Longest edge of each cell."""
        refdom, corners = self.refdom, self._corners
        edges = (
            [(a, b) for a in range(refdom.nnodes) for b in range(a)]
            if self._simplex
            else _edges(refdom)
        )
        lengths = [
            np.linalg.norm(corners[:, a] - corners[:, b], axis=0) for a, b in edges
        ]
        longest: Array = np.max(lengths, axis=0)[:, None]
        return longest

    @property
    def inverse(self) -> Any:
        """Derivatives of the reference coordinates."""
        return self._map.inverse

    @property
    def weight(self) -> Array:
        """Weights of the points."""
        weight: Array = self._map.weight
        return weight

    @property
    def n(self) -> Any:
        """Outward normal; None on cells."""
        return None if self.facet is None else self._map.n

    @cached_property
    def _map(self) -> SimpleNamespace:
        """The map of each cell from the reference one at the points, and what
        follows from it.
        """
        corners, geometry = self._corners, lagrange(self.refdom, 1)
        X = self.X[:, :1] if self._simplex else self.X
        slopes = np.array([geometry.table(X, a) for a in range(self.dim)])
        jacobian = np.einsum("ikc,akq->iacq", corners, slopes)
        rounding = ROUNDING * np.abs(corners).max()
        affine = self._simplex or bool(np.ptp(jacobian, axis=-1).max() <= rounding)
        if affine:
            jacobian = jacobian[..., :1]
        jacobian[np.abs(jacobian).max(axis=(2, 3)) <= rounding] = 0.0
        each, determinant = _invert(jacobian)
        inverse = [[each[a, k] for k in range(self.dim)] for a in range(self.dim)]
        acts = [
            [bool(np.any(inverse[a][k])) for k in range(self.dim)]
            for a in range(self.dim)
        ]
        weight, n = np.abs(determinant) * self._W, None
        if self.facet is not None:
            outward = np.asarray(self.refdom.normals[self.facet], dtype=float)
            outward = outward / np.linalg.norm(outward)
            normal = np.einsum("akcq,a->kcq", each, outward)
            length = np.sqrt((normal**2).sum(axis=0))
            weight = weight * length
            n = Components(normal / length)
        if self.axisymmetric:
            weight = weight * 2.0 * np.pi * self.x[0]
        curvature = None
        if not affine:
            curvature = [
                [
                    np.einsum("ikc,kq->icq", corners, geometry.table(self.X, a, b))
                    for b in range(self.dim)
                ]
                for a in range(self.dim)
            ]
        weight = np.broadcast_to(self.section * weight, self.shape)
        return SimpleNamespace(
            inverse=inverse, acts=acts, weight=weight, n=n, curvature=curvature
        )

    def length_along(self, direction: Components) -> Array:
        """Return the length of each cell along a unit vector (ncells, nq): 2 / sum
        |slope of vertex function|.
        """
        geometry = lagrange(self.refdom, 1)
        slopes = [geometry.table(self.X, a) for a in range(self.dim)]
        rate = [
            sum(direction[k] * self.inverse[a][k] for k in range(self.dim))
            for a in range(self.dim)
        ]
        total = sum(
            np.abs(sum(plain(rate[a]) * slopes[a][n] for a in range(self.dim)))
            for n in range(geometry.nvertices)
        )
        # where nothing moves a direction may vanish
        length: Array = 2.0 / np.maximum(total, 1e-150)
        return length

    def table(self, space: Space, kind: Any) -> Array:
        """Return the table (nb, nq) of a slot: "v", ("g", a), ("h", a, b) or "low"
        (vertex interpolant).
        """
        key = (space.degree, kind)
        if key not in self._tables:
            if kind == "low":
                table = np.zeros((len(space.element.nodes), self.X.shape[1]))
                table[: space.element.nvertices] = lagrange(self.refdom, 1).table(
                    self.X
                )
            else:
                table = space.element.table(self.X, *(() if kind == "v" else kind[1:]))
            self._tables[key] = table
        return self._tables[key]

    def pair_table(
        self, test: Space, test_kind: Any, trial: Space, trial_kind: Any
    ) -> Array:
        """Return the products of two reference tables: (nq, nb_test * nb_trial)."""
        key = (test.degree, test_kind, trial.degree, trial_kind)
        if key not in self._tables:
            a, b = self.table(test, test_kind), self.table(trial, trial_kind)
            self._tables[key] = (
                (a[:, None, :] * b[None, :, :]).reshape(-1, a.shape[1]).T.copy()
            )
        return self._tables[key]

    def to_reference(self, slots: Mapping[Any, Any]) -> dict[Any, Any]:
        """Return the coefficients of physical slots expressed on reference slots."""
        out: dict[Any, Any] = {}

        def add(kind: Any, term: Any) -> None:
            out[kind] = out[kind] + term if kind in out else term

        for kind, c in slots.items():
            if kind in ("v", "low"):
                add(kind, c)
            elif kind[0] == "g":
                for a in range(self.dim):
                    if self._map.acts[a][kind[1]]:
                        add(("g", a), c * self.inverse[a][kind[1]])
            else:
                for a in range(self.dim):
                    for b in range(self.dim):
                        if not (
                            self._map.acts[a][kind[1]] and self._map.acts[b][kind[2]]
                        ):
                            continue
                        term = c * self.inverse[a][kind[1]] * self.inverse[b][kind[2]]
                        add(("h", a, b), term)
                        if self._map.curvature is not None:
                            for k in range(self.dim):
                                for m in range(self.dim):
                                    add(
                                        ("g", m),
                                        -term
                                        * self._map.curvature[a][b][k]
                                        * self.inverse[m][k],
                                    )
        return out


def _facet_quadrature(refdom: Any, facet: int, order: int) -> tuple[Array, Array]:
    vertices = refdom.p[:, refdom.facets[facet]]
    if refdom.dim() == 1:
        return vertices, np.ones(1)
    Y, W = get_quadrature(refdom.brefdom, order)
    spans = [vertices[:, [1]] - vertices[:, [0]], vertices[:, [-1]] - vertices[:, [0]]][
        : refdom.dim() - 1
    ]
    X = vertices[:, [0]] + sum(span * Y[k] for k, span in enumerate(spans))
    area = (
        np.linalg.norm(spans[0])
        if len(spans) == 1
        else np.linalg.norm(np.cross(spans[0].ravel(), spans[1].ravel()))
    )
    return X, W * area


def _edges(refdom: Any) -> list[list[int]]:
    edges: list[list[int]] = refdom.facets if refdom.dim() == 2 else refdom.edges
    return edges


def _invert(J: Any) -> tuple[Array, Array]:
    """Return the inverse and the determinant of J[i, a] (first two axes), dimension
    1 to 3.
    """
    dim = len(J)
    if dim == 1:
        return 1.0 / J, J[0, 0]
    if dim == 2:
        det = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
        return np.array([[J[1, 1], -J[0, 1]], [-J[1, 0], J[0, 0]]]) / det, det
    moved = np.moveaxis(J, (0, 1), (-2, -1))
    return np.moveaxis(np.linalg.inv(moved), (-2, -1), (0, 1)), np.linalg.det(moved)
