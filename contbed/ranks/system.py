"""Engine for MPI: forms compiled by FFCx, assembled by DOLFINx and solved by PETSc.

`System` has the interface of `fem.skfem.System`, so problems do not know which engine
they use. It records each form once (`ad.graph`); every rank turns the recording into
UFL on its part of the mesh and compiles it. Rank 0 keeps vectors and known values in
the numbering of its mesh; the other ranks get their part of a state and return their
part of a residual (`ranks.parts`). Jacobians stay distributed (`ranks.petsc`).

Integrals over boundaries are assembled by rank 0 with `fem.skfem` and added. Their
share of the work vanishes as meshes grow, and property tables need quadrature points on
facets, for which DOLFINx has no elements.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from types import SimpleNamespace
from typing import Any

import numpy as np
from skfem.refdom import RefHex, RefLine, RefQuad, RefTet, RefTri

from contbed.errors import EngineError
from contbed.fem import skfem
from contbed.fem.ad.dual import Components
from contbed.fem.ad.graph import Field, Graph, Node, recorded
from contbed.fem.elements import Space, lagrange
from contbed.ranks import parts
from contbed.ranks.group import RankGroup, rank_group
from contbed.ranks.petsc import Layout, Matrix
from contbed.ranks.recording import KnownField, Recording, recording_of
from contbed.solvers.linear import Policy

CELLS = {
    RefLine: "interval",
    RefTri: "triangle",
    RefQuad: "quadrilateral",
    RefTet: "tetrahedron",
    RefHex: "hexahedron",
}


@dataclass(eq=False)
class Partition:
    """Distribution of the cells of a mesh: `order` lists them rank after rank, `counts`
    of them on each rank.

    Each rank makes its share of a built-in mesh from the coordinates along the axes,
    and gets that of another one.
    """

    mesh: Any
    key: int
    order: Any
    counts: Any

    @classmethod
    def of(cls, all_ranks: RankGroup, mesh: Any) -> Partition:
        """Return the partition of a mesh; it is built at the first call, and the
        last one is kept.
        """
        kept: Partition | None = all_ranks.partition
        if kept is None or kept.mesh is not mesh:
            if kept is not None:
                all_ranks.released.append(kept.key)
            refdom = mesh.elem.refdom
            if mesh.nelements < all_ranks.comm.size:
                raise EngineError(
                    f"{all_ranks.comm.size} ranks for a mesh of {mesh.nelements} "
                    "cells: each rank needs one; "
                    "start fewer ranks or refine the mesh"
                )
            key, cells = all_ranks.new_key(), mesh.t[_order(refdom, 1)].T
            order, counts = all_ranks.run_on_all(
                parts.make_mesh,
                key,
                CELLS[refdom],
                cells.shape[1],
                mesh.dim(),
                root=(cells, mesh.p.T),
            )
            all_ranks.partition = kept = cls(mesh, key, order, counts)
        return kept

    def split(self, values: Any) -> tuple[Any, Any]:
        """Return values (ncells, n) in the order of the ranks, and the number of
        cells of each rank.
        """
        return np.ascontiguousarray(values[self.order]), self.counts


class System(skfem.System):
    """Named unknowns on a mesh that all ranks share; see `fem.skfem.System`."""

    def __init__(
        self,
        mesh: Any,
        fields: Mapping[str, tuple[int, int]],
        order: int,
        **measure: Any,
    ):
        super().__init__(mesh, fields, order, **measure)
        self.ranks = rank_group()
        self.partition = Partition.of(self.ranks, mesh)
        self.graph, self.state = Graph(self._value), np.empty(0)
        self._known: list[KnownField] = []
        self.key = self.ranks.new_key()
        self._compiled: dict[Any, _Compiled] = {}
        self.layout = self._distribute()

    def _distribute(self) -> Layout:
        """Distribute the unknowns: each belongs to the rank that owns its node."""
        numbers = (
            self.partition.split(_by_cell(self.fields[name][0]) + start)
            for (name, _), start in self.offset.items()
        )
        degrees = [(space.degree, count) for space, count in self.fields.values()]
        order, counts = self.ranks.run_on_all(
            parts.make_space, self.key, self.partition.key, degrees, root=numbers
        )
        return Layout(order, counts, self.size)

    def ordered(self, policy: Policy) -> Policy:
        """Return the policy unchanged: PETSc finds its own ordering."""
        return policy

    def known(self, where: Any, space: Any, values: Any) -> Any:
        """Return a known finite-element field as coefficient on `where`."""
        if where is not self.cells:
            return super().known(where, space, values)
        if values.ndim > 1:
            return Components(self.known(where, space, row) for row in values)
        field = KnownField(space, values)
        if field not in self._known:
            self._known.append(field)
        return Field(self.graph, "known", self._known.index(field))

    def _value(self, place: int) -> Any:
        """Return the array that a node stands for, with unknowns from the last
        state.
        """
        return self._values([place])[0]

    def _values(self, places: Sequence[int]) -> list[Any]:
        return self.graph.values(places, self._leaf)

    def _leaf(self, operation: str, operands: tuple[Any, ...]) -> Any:
        where = self.cells
        if operation in ("x", "h"):
            return where.x[operands[0]] if operation == "x" else where.h
        *what, kind = operands
        if operation == "known":
            field = self._known[what[0]]
            space, start, values = field.space, 0, field.values
        else:
            space, start, values = (
                self.fields[what[0]][0],
                self.offset[what[0], what[1]],
                self.state,
            )
        found = skfem._Unknown(
            where, space, values[start + space.dofs[:, where.cells].T], None
        )
        return found.value if kind == "v" else found.slot(kind).value

    def assemble(
        self, forms: Sequence[tuple[Any, Any, Any]], state: Any, jacobian: bool = True
    ) -> tuple[Any, Any]:
        """Assemble the residual and, if wanted, the distributed Jacobian of the sum
        of `(form, domain, coeffs)`.
        """
        inside = [form for form in forms if form[1] is self.cells]
        edge = [form for form in forms if form[1] is not self.cells]
        self.state = state
        compiled = self._compiled_of(inside)
        residual, outer = (
            super().assemble(edge, state, jacobian and bool(edge))
            if edge
            else (0.0, None)
        )
        for indices in compiled.recording.renew(self._values):
            shares = self.partition.split(compiled.recording.arrays[indices])
            self.ranks.run_on_all(parts.set_array, compiled.key, indices, root=shares)
        key = self.ranks.new_key() if jacobian else None
        added = None if outer is None else self.layout.entries(outer)
        pieces = self.ranks.run_on_all(
            parts.assemble, compiled.key, key, root=(self.layout, state, added)
        )
        return self.layout.from_parts(
            pieces
        ) + residual, None if key is None else Matrix(self.ranks, key, self.layout)

    def _compiled_of(self, forms: Any) -> _Compiled:
        """Return the compiled recording of forms on all ranks.

        Forms are identified by `id`; the recording keeps them alive, so that an `id` is
        not used again.
        """
        signature = tuple((id(form), id(coeffs)) for form, _, coeffs in forms)
        if signature not in self._compiled:
            self._compiled[signature] = _Compiled(self, self._recorded(forms), forms)
        return self._compiled[signature]

    def _recorded(self, forms: Any) -> Recording:
        """Return the recording of the sum of forms over cells."""
        x = Components(self.graph.add("x", axis) for axis in range(self.cells.dim))
        ops = skfem.Ops(self.cells, x, self.graph.add("h"))
        coefficients: dict[Any, Node] = {}
        for form, _, coeffs in forms:
            for test, node in recorded(self.graph, self, form, coeffs, ops).items():
                coefficients[test] = (
                    coefficients[test] + node if test in coefficients else node
                )
        return recording_of(self.graph, coefficients, [*self.offset], self.cells.shape)

    def __del__(self) -> None:
        if hasattr(self, "key"):
            self.ranks.released.append(self.key)


class _Compiled:
    """A recording that all ranks hold as object `key`."""

    def __init__(self, system: System, recording: Recording, forms: Any):
        self.ranks, self.recording, self.forms, self.key = (
            system.ranks,
            recording,
            forms,
            system.ranks.new_key(),
        )
        partition = system.partition
        known = [system._known[number] for number in recording.known]
        fields = (
            partition.split(field.values[_by_cell(field.space)]) for field in known
        )
        self.ranks.run_on_all(
            parts.make_form,
            self.key,
            system.key,
            (
                recording.entries,
                recording.results,
                [array.shape[1] for array in recording.arrays],
            ),
            [field.space.degree for field in known],
            measure_of(system),
            root=chain((partition.split(array) for array in recording.arrays), fields),
        )

    def __del__(self) -> None:
        self.ranks.released.append(self.key)


def measure_of(system: System) -> Any:
    """Return the quadrature of a system, and the cross-section [m2] or 2 pi r that
    its measure includes.
    """
    from skfem.quadrature import get_quadrature

    points, weights = get_quadrature(system.cells.refdom, system.order)
    return SimpleNamespace(
        points=np.ascontiguousarray(points.T),
        weights=weights,
        order=system.order,
        axisymmetric=system.cells.axisymmetric,
        section=float(system.measure.get("section", 1.0)),
    )


def _order(refdom: Any, degree: int) -> Any:
    """Return our local node at each node of Basix's element; both use the same
    reference cell.
    """
    import basix

    cell = getattr(basix.CellType, CELLS[refdom])
    element = basix.create_element(
        basix.ElementFamily.P, cell, degree, basix.LagrangeVariant.equispaced
    )
    theirs = np.asarray(element.points)
    distance = np.abs(
        theirs[:, None, :] - lagrange(refdom, degree).nodes[None, :, :]
    ).sum(axis=2)
    return distance.argmin(axis=1)


def _by_cell(space: Space) -> Any:
    """Return the nodes of each cell (ncells, nb) in the order of Basix."""
    return space.dofs[_order(space.element.refdom, space.degree)].T
