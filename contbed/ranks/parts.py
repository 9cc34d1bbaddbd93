"""What every rank does on its part of the mesh: spaces, forms as UFL from a recording,
assembly with DOLFINx.

Each function of `run_on_all` takes the ranks and what rank 0 gives (`root`, None on the
others), and keeps results as objects under a key. `ranks.system` has the side of rank
0.
"""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.errors import EngineError
from contbed.ranks import dolfinx
from contbed.ranks.group import RankGroup
from contbed.ranks.petsc import Layout, LocalMatrix


def usage(all_ranks: RankGroup, root: Any) -> Any:
    """Return the processor time [s] and the largest memory [GB] of each rank."""
    import resource

    own = resource.getrusage(resource.RUSAGE_SELF)
    mine = np.array([own.ru_utime + own.ru_stime, 1.024e-6 * own.ru_maxrss])
    return all_ranks.gather(mine, [2] * all_ranks.comm.size)


def make_mesh(
    all_ranks: RankGroup,
    root: Any,
    key: int,
    cell: str,
    corners: int,
    dim: int,
) -> Any:
    """Distribute a mesh; return the cells of each rank in turn and their number.

    Each rank begins with an equal range of the cells (ncells, corners) and nodes (n,
    dim) that `root` has. Then DOLFINx moves cells to where their neighbours are.
    """
    whole, nodes = root or (None, None)
    cells = all_ranks.spread(whole, corners, np.int64)
    points = all_ranks.spread(nodes, dim, float)
    mesh = dolfinx.create_mesh(all_ranks.comm, cell, cells, points)
    owned = mesh.topology.index_map(dim).size_local
    original = np.asarray(mesh.topology.original_cell_index[:owned], dtype=np.int64)
    counts = all_ranks.comm.gather(owned)
    order = all_ranks.gather(original, counts)
    given = all_ranks.scatter(
        None if whole is None else whole[order], counts, corners, np.int64
    )
    found = np.asarray(mesh.geometry.input_global_indices)[
        dolfinx.geometry_list(mesh)[:owned]
    ]
    if not np.array_equal(given, found):
        raise EngineError("this version of DOLFINx renumbers the vertices of cells")
    all_ranks.objects[key] = SimpleNamespace(
        mesh=mesh, cell=cell, owned=owned, spaces={}
    )
    return order, counts


def space_on(part: Any, what: Any) -> Any:
    """Return a space on a mesh, built once: ("nodes", degree), ("cells",) or
    ("points", points).
    """
    kind, *data = what
    key = (kind, *(item if isinstance(item, int) else item.tobytes() for item in data))
    if key not in part.spaces:
        make: dict[str, Any] = {
            "nodes": partial(dolfinx.lagrange, ncomponents=0),
            "cells": dolfinx.constants,
            "points": dolfinx.quadrature,
        }
        element = make[kind](part.cell, *data)
        part.spaces[key] = dolfinx.function_space(part.mesh, element)
    return part.spaces[key]


def make_space(
    all_ranks: RankGroup, root: Any, key: int, mesh: int, layout: list[tuple[int, int]]
) -> Any:
    """Build the space of a system; return its unknowns rank after rank and how many
    each rank owns.
    """
    from dolfinx import fem

    part = all_ranks.objects[mesh]
    size = sum(max(count, 1) for _, count in layout)
    degrees = {degree for degree, _ in layout}
    low = None
    if len(degrees) == 1:
        (degree,) = degrees
        W = dolfinx.function_space(part.mesh, dolfinx.lagrange(part.cell, degree, size))
        if degree > 1:
            low = _vertices(part, W, size)
    else:
        W = dolfinx.function_space(
            part.mesh,
            dolfinx.mixed(
                [dolfinx.lagrange(part.cell, degree, count) for degree, count in layout]
            ),
        )
    lists = unknowns_of_cells(part, W, layout)
    block = W.dofmap.index_map_bs
    owned, ghosts = (
        block * n
        for n in (W.dofmap.index_map.size_local, W.dofmap.index_map.num_ghosts)
    )
    numbers = np.full(owned + ghosts, -1, dtype=np.int64)
    for unknowns in lists:
        values, counts = next(root) if root else (None, None)
        numbers[unknowns] = all_ranks.scatter(
            values, counts, unknowns.shape[1], np.int64
        )
    fields, first = [], 0
    for _, count in layout:
        mine = np.unique(
            np.concatenate(
                [unknowns.ravel() for unknowns in lists[first : first + max(count, 1)]]
            )
        )
        fields.append(mine[mine < owned].astype(np.int32))
        first += max(count, 1)
    all_ranks.objects[key] = SimpleNamespace(
        part=part,
        W=W,
        state=fem.Function(W),
        low=low,
        owned=owned,
        fields=fields,
        block=block,
    )
    counts = all_ranks.comm.gather(owned)
    return all_ranks.gather(numbers[:owned], counts), counts


def unknowns_of_cells(part: Any, W: Any, layout: list[tuple[int, int]]) -> list[Any]:
    """Return the local numbers of each scalar unknown in the cells of this rank,
    arrays (ncells, nb).
    """
    size = sum(max(count, 1) for _, count in layout)
    if W.dofmap.index_map_bs == size:
        blocks = dolfinx.dof_list(W)[: part.owned]
        return [blocks * size + k for k in range(size)]
    lists = []
    for k, (_, count) in enumerate(layout):
        parts = [W.sub(k).sub(c) for c in range(count)] if count else [W.sub(k)]
        lists += [dolfinx.dof_list(space)[: part.owned] for space in parts]
    return lists


def _vertices(part: Any, W: Any, size: int) -> Any:
    """Build the linear interpolants of all unknowns: their function, and the block
    of `W` at each vertex.
    """
    from dolfinx import fem

    space = dolfinx.function_space(part.mesh, dolfinx.lagrange(part.cell, 1, size))
    here, there = dolfinx.dof_list(space), dolfinx.dof_list(W)
    blocks = np.empty(
        space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts,
        dtype=np.int32,
    )
    blocks[here] = there[:, : here.shape[1]]
    return SimpleNamespace(
        function=fem.Function(space), space=space, blocks=blocks, size=size
    )


def make_form(
    all_ranks: RankGroup,
    root: Any,
    key: int,
    space: int,
    recording: Any,
    degrees: list[int],
    measure: Any,
) -> None:
    """Build the UFL forms of residual and Jacobian from a recording; they are compiled
    at first use.

    recording : entries, results, and the number of columns of each array
    degrees : of known fields
    """
    import ufl
    from dolfinx import fem

    unknowns = all_ranks.objects[space]
    part = unknowns.part
    entries, results, widths = recording
    kinds = [
        ("cells",) if width == 1 else ("points", measure.points) for width in widths
    ]
    arrays = [fem.Function(space_on(part, kind)) for kind in kinds]
    known = [fem.Function(space_on(part, ("nodes", degree))) for degree in degrees]
    all_ranks.objects[key] = stored = SimpleNamespace(
        unknowns=unknowns, arrays=arrays, known=known, residual=None
    )
    for which in ("arrays", "known"):
        for k in range(len(getattr(stored, which))):
            set_array(all_ranks, next(root) if root else None, key, k, which)
    stored.form = integral(_integrand(entries, results, stored), part, measure)
    stored.slopes = [
        ufl.derivative(stored.form, unknowns.state, ufl.TrialFunction(unknowns.W))
    ]
    if (
        any(entry[0] == "slot" and entry[2] == "low" for entry in entries)
        and unknowns.low is not None
    ):
        low = unknowns.low
        stored.slopes.append(
            ufl.derivative(stored.form, low.function, ufl.TrialFunction(low.space))
        )
    stored.jacobians = None


def integral(integrand: Any, part: Any, measure: Any) -> Any:
    """Return the integral of `integrand` over all cells; `measure` is that of
    `measure_of`.
    """
    import ufl
    from dolfinx import fem

    if measure.axisymmetric:
        integrand = 2.0 * np.pi * ufl.SpatialCoordinate(part.mesh)[0] * integrand
    rule = {
        "quadrature_rule": "custom",
        "quadrature_points": measure.points,
        "quadrature_weights": measure.weights,
    }
    dx = ufl.Measure(
        "dx", domain=part.mesh, metadata={"quadrature_degree": measure.order, **rule}
    )
    return fem.Constant(part.mesh, measure.section) * integrand * dx


def _integrand(entries: Any, results: Any, stored: Any) -> Any:
    """Return what a recording integrates over cells, in UFL."""
    import ufl
    from dolfinx import fem

    from contbed.ranks.ufl import expressions, slot

    unknowns, mesh = stored.unknowns, stored.unknowns.part.mesh
    tests = ufl.TestFunction(unknowns.W)

    def number(value: float, plain: bool) -> Any:
        # a number that only scales may change without compiling the form again
        return (
            ufl.as_ufl(value)
            if plain or value in (0.0, 1.0, -1.0)
            else fem.Constant(mesh, value)
        )

    def unknown(component: int, kind: Any) -> Any:
        if kind == "low":
            return (unknowns.state if unknowns.low is None else unknowns.low.function)[
                component
            ]
        return slot(unknowns.state[component], kind)

    leaves = {
        "number": number,
        "array": stored.arrays.__getitem__,
        "slot": unknown,
        "known": lambda field, kind: slot(stored.known[field], kind),
        "x": lambda axis: ufl.SpatialCoordinate(mesh)[axis],
        "h": lambda: ufl.MaxCellEdgeLength(mesh),
    }
    done = expressions(entries, leaves)
    return sum(
        done[entry] * slot(tests[component], kind) for component, kind, entry in results
    )


def set_array(
    all_ranks: RankGroup, root: Any, key: int, index: int, which: str = "arrays"
) -> None:
    """Set the values of an array or a known field."""
    stored = all_ranks.objects[key]
    function = getattr(stored, which)[index]
    places = dolfinx.dof_list(function.function_space)[: stored.unknowns.part.owned]
    values, counts = root or (None, None)
    function.x.array[places] = all_ranks.scatter(values, counts, places.shape[1], float)


def assemble(all_ranks: RankGroup, root: Any, form: int, matrix: int | None) -> Any:
    """Assemble; return the gathered residual and store the Jacobian as object
    `matrix`.
    """
    from dolfinx.fem import petsc
    from petsc4py import PETSc

    stored = all_ranks.objects[form]
    unknowns = stored.unknowns
    layout, state, added = root or (None, None, None)
    x = unknowns.state.x
    x.array[: unknowns.owned] = Layout.scatter(all_ranks, layout, state)
    x.scatter_forward()
    if (low := unknowns.low) is not None:
        low.function.x.array[:] = x.array.reshape(-1, low.size)[low.blocks].ravel()
    if stored.residual is None:
        stored.residual = dolfinx.compiled(stored.form)
    b = petsc.assemble_vector(stored.residual)
    b.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    mine = b.array.copy()
    b.destroy()
    if matrix is not None:
        all_ranks.objects[matrix] = LocalMatrix(_jacobian(stored, added), unknowns)
    return all_ranks.gather(mine, layout and layout.counts)


def _jacobian(stored: Any, added: Any) -> Any:
    """Assemble the Jacobian.

    The derivative with respect to linear interpolants is added to the columns of the
    vertices that they interpolate.
    """
    from dolfinx.fem import petsc
    from petsc4py import PETSc

    if stored.jacobians is None:
        stored.jacobians = [dolfinx.compiled(slope) for slope in stored.slopes]
    first, *others = stored.jacobians
    A = petsc.create_matrix(first)
    petsc.assemble_matrix(A, first)
    rows, columns = A.getLGMap()
    for jacobian in others:
        low = stored.unknowns.low
        places = columns.getBlockIndices()[low.blocks]
        A.setLGMap(rows, PETSc.LGMap().create(places, bsize=low.size, comm=A.comm))
        petsc.assemble_matrix(A, jacobian)
        A.setLGMap(rows, columns)
    if added is not None:
        starts, where, values, named = added
        A.setValuesIJV(
            starts, where, values, addv=PETSc.InsertMode.ADD_VALUES, rowmap=named
        )
    A.assemble()
    return A
