"""Nodal Lagrange elements of degree 1 to 3 on all cell shapes, and their numbering on a
scikit-fem mesh.

The basis is kept as monomial coefficients, so values, gradients and second derivatives
are exact polynomials. Gradients of a constant are zero to the last digit of the
smallest one, as many thin cells add up what is left of them. Nodes are the equispaced
lattice. Numbering is scikit-fem's `Dofs`; the two inner nodes of a cubic edge are
swapped where the cell runs along it from the higher to the lower vertex, so that
neighbours agree.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from skfem.assembly.dofs import Dofs
from skfem.mesh import Mesh as SkfemMesh
from skfem.refdom import RefHex, RefLine, RefQuad

from contbed.arrays import Array, Integers
from contbed.errors import SceneError

_TENSOR = (RefQuad, RefHex)
# coefficients are multiples of it: of cubics on thirds of a line 1/2, of their products
# on squares 1/4
QUANTUM = 0.25


class Lagrange:
    """Reference element: `nodes` (nb, dim) and the basis functions as polynomials."""

    def __init__(self, refdom: Any, degree: int):
        if refdom is RefHex and degree > 2:
            raise SceneError(
                "solver.degree = 3 is not available on hexahedra; use degree 2 or "
                "tetrahedra"
            )
        self.refdom, self.degree, self.dim = refdom, degree, refdom.dim()
        vertices = refdom.p.T
        inner = [i / degree for i in range(1, degree)]
        self.edges = refdom.facets if self.dim == 2 else (refdom.edges or [])
        edge_nodes = [
            vertices[a] + s * (vertices[b] - vertices[a])
            for a, b in self.edges
            for s in inner
        ]
        self.per_edge = len(inner) if self.edges else 0
        face_nodes: list[Array] = []
        if self.dim == 3:
            for face in refdom.facets:
                face_nodes += list(
                    self._inner_lattice(vertices[face], inner, refdom is RefHex)
                )
        self.per_face = len(face_nodes) // len(refdom.facets) if face_nodes else 0
        cell_nodes = self._cell_lattice(inner)
        self.per_cell = len(cell_nodes)
        self.nodes = np.array(
            [*vertices, *edge_nodes, *face_nodes, *cell_nodes], dtype=float
        )
        powers = list(product(range(degree + 1), repeat=self.dim))
        if refdom not in _TENSOR:
            powers = [p for p in powers if sum(p) <= degree]
        self.powers = np.array(powers)
        inverse = np.linalg.inv(self._monomials(self.nodes.T, (0,) * self.dim).T)
        self.coefficients = np.round(inverse / QUANTUM) * QUANTUM
        self.nvertices = len(vertices)

    @staticmethod
    def _inner_lattice(corners: Array, inner: list[float], tensor: bool) -> Array:
        a, b, c = corners[0], corners[1], corners[-1]
        pairs = [(s, t) for s in inner for t in inner if tensor or s + t < 1 - 1e-9]
        return np.array([a + s * (b - a) + t * (c - a) for s, t in pairs]).reshape(
            -1, len(a)
        )

    def _cell_lattice(self, inner: list[float]) -> list[Array]:
        points = product(inner, repeat=self.dim)
        return [
            np.array(p)
            for p in points
            if self.refdom in (*_TENSOR, RefLine) or sum(p) < 1 - 1e-9
        ]

    def _monomials(self, X: Array, order: tuple[int, ...]) -> Array:
        """Return the derivative of `order` of each monomial at X (dim, nq):
        (nmonomials, nq).
        """
        out = np.ones((len(self.powers), X.shape[1]))
        for axis, times in enumerate(order):
            power = self.powers[:, axis]
            factor = np.ones(len(power))
            for k in range(times):
                factor = factor * (power - k)
            out *= (
                factor[:, None]
                * X[axis][None, :] ** np.maximum(power - times, 0)[:, None]
            )
        return out

    def table(self, X: Array, *axes: int) -> Array:
        """Return basis functions differentiated along `axes` at reference points X
        (dim, nq): (nb, nq).
        """
        order = tuple(axes.count(axis) for axis in range(self.dim))
        table: Array = self.coefficients.T @ self._monomials(X, order)
        if axes:
            smallest = np.argmin(np.where(table == 0.0, np.inf, np.abs(table)), axis=0)
            for k, column in zip(smallest, table.T, strict=True):
                column[k] -= math.fsum(column)
        return table


@lru_cache(maxsize=64)
def lagrange(refdom: Any, degree: int) -> Lagrange:
    """Return the Lagrange element of a cell shape; each is built once."""
    return Lagrange(refdom, degree)


class GlobalUnknown:
    """One unknown for the whole mesh, with the interface of `Space`."""

    degree = 0
    size = 1

    def __init__(self, mesh: SkfemMesh):
        self.mesh, self.element = mesh, self
        self.dofs = np.zeros((1, mesh.nelements), dtype=np.int32)

    def table(self, X: Array, *axes: int) -> Array:
        """Return the constant 1 at reference points X (dim, nq), or its derivatives
        along `axes`: (1, nq).
        """
        return np.full((1, X.shape[1]), 0.0 if axes else 1.0)

    @property
    def points(self) -> Array:
        """The first vertex of the mesh (dim, 1), as coordinates for the unknown."""
        point: Array = self.mesh.p[:, :1]
        return point


class Space:
    """Continuous piecewise polynomials on a scikit-fem mesh: `dofs` (nb, ncells),
    `size`, `points` (dim, size).
    """

    def __init__(self, mesh: SkfemMesh, degree: int):
        self.mesh, self.degree = mesh, degree
        self.element = element = lagrange(mesh.elem.refdom, degree)
        three = element.dim == 3
        counts = SimpleNamespace(
            dim=element.dim,
            nodal_dofs=1,
            edge_dofs=element.per_edge if three else 0,
            facet_dofs=element.per_face if three else element.per_edge,
            interior_dofs=element.per_cell,
        )
        self._numbering = Dofs(mesh, counts)
        self.dofs = self._numbering.element_dofs
        if degree == 3 and element.edges:
            self.dofs = self._aligned(self.dofs.copy())
        self.size = int(self._numbering.N)

    def _aligned(self, dofs: NDArray[np.int32]) -> NDArray[np.int32]:
        t, element = self.mesh.t, self.element
        for k, (a, b) in enumerate(element.edges):
            first = element.nvertices + 2 * k
            flip = t[a] > t[b]
            dofs[first, flip], dofs[first + 1, flip] = (
                dofs[first + 1, flip],
                dofs[first, flip].copy(),
            )
        return dofs

    @property
    def points(self) -> Array:
        """Coordinates of the nodes (dim, size)."""
        geometry = lagrange(self.mesh.elem.refdom, 1).table(self.element.nodes.T)
        points = np.empty((self.mesh.dim(), self.size))
        points[:, self.dofs] = np.einsum(
            "dkc,kn->dnc", self.mesh.p[:, self.mesh.t], geometry
        )
        return points

    def interpolated(self, values: Array, other: Space) -> Array:
        """Return values (size,) of this space at the nodes of another one on the
        same mesh (other.size,).
        """
        table = self.element.table(other.element.nodes.T)
        out = np.empty(other.size)
        out[other.dofs] = table.T @ values[self.dofs]
        return out

    def from_vertices(self) -> sp.csr_matrix:
        """Return the interpolation of values at the vertices, linear on edges (size,
        nvertices).
        """
        corners = self.mesh.t
        # (ncorners, nb)
        weights = lagrange(self.mesh.elem.refdom, 1).table(self.element.nodes.T)
        shape = (len(weights), *self.dofs.shape)
        nodes = np.broadcast_to(self.dofs, shape)[weights != 0.0].ravel()
        vertices = np.broadcast_to(corners[:, None], shape)[weights != 0.0].ravel()
        values = np.broadcast_to(weights[..., None], shape)[weights != 0.0].ravel()
        _, first = np.unique(
            nodes.astype(np.int64) * self.mesh.nvertices + vertices, return_index=True
        )
        return sp.csr_matrix(
            (values[first], (nodes[first], vertices[first])),
            shape=(self.size, self.mesh.nvertices),
        )

    def on_facets(self, facets: NDArray[np.int32]) -> Integers:
        """Return the nodes on these facets, on their edges and at their corners."""
        numbering, mesh = self._numbering, self.mesh
        parts = [numbering.nodal_dofs[:, np.unique(mesh.facets[:, facets])].ravel()]
        if mesh.dim() == 3 and numbering.edge_dofs.size:
            parts.append(numbering.edge_dofs[:, self._edges_of(facets)].ravel())
        if numbering.facet_dofs.size:
            parts.append(numbering.facet_dofs[:, facets].ravel())
        return np.unique(np.concatenate(parts)).astype(np.int64)

    def _edges_of(self, facets: NDArray[np.int32]) -> Integers:
        """Return the edges of these facets of a 3-D mesh."""
        mesh = self.mesh
        on = np.zeros(mesh.nvertices, dtype=bool)
        on[np.unique(mesh.facets[:, facets])] = True
        candidates = np.unique(mesh.t2e[:, mesh.f2t[0, facets]])
        candidates = candidates[on[mesh.edges[:, candidates]].all(axis=0)]
        corners = {
            tuple(sorted(pair))
            for face in mesh.facets[:, facets].T
            for pair in product(face, face)
        }
        return np.array(
            [e for e in candidates if tuple(sorted(mesh.edges[:, e])) in corners],
            dtype=np.int64,
        )
