"""Assembly by DOLFINx of forms that are evaluated at quadrature points, for closures of the local state.

A bubbling bed takes its coefficients from dozens of closures, anew for each state, size and height of the bed. Compiled
as a whole such a form would take minutes. The root rank evaluates it by dual numbers, as `fem.skfem` does: one array
for each slot of a test function, and one for each pair of slots of a test function and an unknown. With these arrays as
values at the quadrature points DOLFINx integrates forms such as c u v', which are compiled once for all scenes.

Unknowns of degree 0 (one number for the whole mesh) have no slot; they are placed behind those of the last rank and
fill a row and a column of the matrix.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from contbed.fem import dolfinx, dolfinx_parts, skfem
from contbed.fem import dolfinx_versions as versions
from contbed.fem.dual import Linear
from contbed.fem.petsc import Layout, LocalMatrix, Matrix
from contbed.fem.ranks import RankGroup


class System(dolfinx.System):
    """Named unknowns on a mesh that all ranks share, degree 0 included; see `fem.skfem.System`."""

    known = skfem.System.known

    def _distribute(self) -> Layout:
        layout = super()._distribute()
        single = [key for key in self.offset if key[0] not in self.nodal_fields]
        along = [key for key in self.offset if key[0] in self.nodal_fields]
        self.numbers = {key: k for k, key in enumerate([*along, *single])}
        self.ranks.run_on_all(make_pattern, self.key, len(single), dolfinx.measure_of(self))
        order = np.append(layout.order, np.array([self.offset[key] for key in single], dtype=np.int64))
        return Layout(order, [*layout.counts[:-1], layout.counts[-1] + len(single)], self.size)

    def assemble(self, forms: Sequence[tuple[Any, Any, Any]], state: Any, jacobian: bool = True) -> tuple[Any, Any]:
        """Assemble the residual and, if wanted, the distributed Jacobian of the sum of `(form, domain, coeffs)`."""
        inside = [form for form in forms if form[1] is self.cells]
        edge = [form for form in forms if form[1] is not self.cells]
        residual, outer = skfem.System.assemble(self, edge, state, jacobian and bool(edge)) if edge else (0.0, None)
        terms = self._terms(inside, state, jacobian)
        shape = self.cells.shape
        values = [np.broadcast_to(array, shape) for *_, slots in terms for array in slots.values()]
        todo = [(row, column, tuple(slots)) for row, column, slots in terms]
        key = self.ranks.new_key() if jacobian else None
        added = None if outer is None else self.layout.entries(outer)
        root = (self.layout, self.partition.split(np.concatenate(values, axis=1)), added)
        parts = self.ranks.run_on_all(assemble, self.key, key, todo, root=root)
        return self.layout.from_parts(parts) + residual, None if key is None else Matrix(self.ranks, key, self.layout)

    def _terms(self, forms: Any, state: Any, jacobian: bool) -> list[tuple[int, int | None, dict[Any, Any]]]:
        """Return coefficients as (test, unknown, {slots: array}); the unknown is None for a residual."""
        found: dict[Any, dict[Any, Any]] = {}

        def add(row: int, column: int | None, slots: Any, array: Any) -> None:
            there = found.setdefault((row, column), {})
            there[slots] = there[slots] + array if slots in there else array

        for form, where, coeffs in forms:
            whole = form(self._trial(where, state, jacobian), self._tests(where), coeffs, skfem.Ops(where))
            for (name, component, kind), c in (whole.slots if isinstance(whole, Linear) else {}).items():
                row, slot = self.numbers[name, component], (kind,) if name in self.nodal_fields else ()
                add(row, None, slot, getattr(c, "value", c))
                for (unknown, k, trial), tangent in getattr(c, "tangents", {}).items():
                    add(
                        row,
                        self.numbers[unknown, k],
                        slot + ((trial,) if unknown in self.nodal_fields else ()),
                        tangent,
                    )
        return [(row, column, slots) for (row, column), slots in found.items()]


# What follows runs on all ranks.


def make_pattern(all_ranks: RankGroup, root: Any, key: int, singles: int, measure: Any) -> None:
    """Build an empty matrix for all unknowns of each cell and for `singles` unknowns of degree 0."""
    from petsc4py import PETSc

    stored = all_ranks.objects[key]
    part, W = stored.part, stored.W
    stored.kernels, stored.measure = {}, measure
    numbers = _global(W.dofmap.index_map, stored.block)
    unknowns = [numbers[local] for local in dolfinx_parts.unknowns_of_cells(part, W, stored.layout)]
    stored.degrees = [degree for degree, count in stored.layout for _ in range(max(count, 1))]
    stored.places = []
    for degree, mine in zip(stored.degrees, unknowns, strict=True):
        V = _nodes(part, degree)
        places = np.full(len(_global(V.dofmap.index_map, 1)), -1, dtype=np.int32)
        places[versions.dof_list(V)[: part.owned]] = mine
        stored.places.append(places)
    size = W.dofmap.index_map.size_global * stored.block
    behind = np.arange(size, size + singles, dtype=np.int32)
    stored.places += [*behind[:, None]]
    local = stored.owned + (singles if all_ranks.comm.rank == all_ranks.comm.size - 1 else 0)
    A = PETSc.Mat().createAIJ(((local, PETSc.DECIDE), (local, PETSc.DECIDE)), comm=all_ranks.comm)
    width = singles + 2 * sum(mine.shape[1] for mine in unknowns)
    A.setPreallocationNNZ((min(width, local), width))
    A.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
    for mine in np.concatenate(unknowns, axis=1):
        coupled = np.append(mine, behind)
        A.setValues(coupled, coupled, np.zeros((len(coupled), len(coupled))))
    A.assemble()
    stored.template = A


def _global(index_map: Any, block: int) -> Any:
    """Return PETSc's numbers of all unknowns that a rank knows."""
    here = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
    return (block * index_map.local_to_global(here)[:, None] + np.arange(block)).ravel().astype(np.int32)


def _nodes(part: Any, degree: int) -> Any:
    return dolfinx_parts.space_on(part, ("nodes", degree))


def _kernel(stored: Any, row: int, column: int | None, slots: Any) -> Any:
    """Return a compiled form in test (and trial) functions of fields on nodes, and its coefficients."""
    import ufl
    from dolfinx import fem

    degrees = [stored.degrees[k] for k in (row, column) if k is not None and k < len(stored.degrees)]
    name = (*degrees, slots)
    if name not in stored.kernels:
        part, measure = stored.part, stored.measure
        make: tuple[Any, ...] = (ufl.TestFunction, ufl.TrialFunction)
        arguments = [f(_nodes(part, degree)) for f, degree in zip(make, degrees, strict=False)]
        points = dolfinx_parts.space_on(part, ("points", measure.points, measure.weights))
        coefficients = [fem.Function(points) for _ in slots]
        total: Any = 0
        for kinds, c in zip(slots, coefficients, strict=True):
            total = total + c * math.prod(dolfinx_parts.slot(*pair) for pair in zip(arguments, kinds, strict=True))
        stored.kernels[name] = versions.compiled(dolfinx_parts.integral(total, part, measure)), coefficients
    return stored.kernels[name]


def assemble(all_ranks: RankGroup, root: Any, key: int, matrix: int | None, todo: Any) -> Any:
    """Assemble from coefficients at the points; return the gathered residual, store the Jacobian as `matrix`."""
    from dolfinx import fem
    from dolfinx.fem import petsc
    from petsc4py import PETSc

    stored = all_ranks.objects[key]
    layout, shares, added = root or (None, None, None)
    count = len(stored.measure.weights)
    given, counts = shares or (None, None)
    values = all_ranks.scatter(given, counts, count * sum(len(slots) for *_, slots in todo), float)
    chunks = iter(np.split(values, values.shape[1] // count, axis=1))
    b = stored.template.createVecLeft()
    A: Any = None if matrix is None else stored.template.duplicate()
    add = PETSc.InsertMode.ADD_VALUES
    for row, column, slots in todo:
        form, coefficients = _kernel(stored, row, column, slots)
        for c in coefficients:
            c.x.array[versions.dof_list(c.function_space)[: stored.part.owned]] = next(chunks)
        places = [stored.places[k] for k in (row, column) if k is not None]
        if len(slots[0]) == 2:
            A.setLGMap(*(PETSc.LGMap().create(numbers, comm=A.comm) for numbers in places))
            petsc.assemble_matrix(A, form)
        else:
            values = fem.assemble_vector(form).array if slots[0] else fem.assemble_scalar(form)
            (b if column is None else A).setValues(*places, values, addv=add)
    b.assemble()
    if matrix is not None:
        if added is not None:
            starts, where, entries, named = added
            A.setValuesIJV(starts, where, entries, addv=add, rowmap=named)
        A.assemble()
        all_ranks.objects[matrix] = LocalMatrix(A, stored)
    mine = b.array.copy()
    b.destroy()
    return all_ranks.gather(mine, layout and layout.counts)
