"""What every rank does on its part of a line: the weak form of `fem.line_dg` in UFL, assembled by DOLFINx.

For each equation, with fluxes F = C + D and those of damping, and sources S at the Gauss points, fluxes H at the
vertices, and left and right for the sides of an interior vertex,

    residual    - int (F v' + S v) dx + sum over vertices H (v_left - v_right) + H n v at the ends
    gradient    int q v dx = int u' v dx + sum over vertices (u_right - u_left) v_w + (value - u) n v at an end where a
                value is given,    w the side to which the field goes

Mass matrices are diagonal, as polynomials are given at the Gauss points: the product of the derivatives by gradients
and of gradients by fields is added to the matrix of the fields. F, S, H and their derivatives come from the root rank,
which evaluates closures and kinetics.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.fem import dolfinx_versions as versions
from contbed.fem.dolfinx_parts import space_on
from contbed.fem.petsc import LocalMatrix
from contbed.fem.ranks import RankGroup

Array = NDArray[np.float64]
# field, whether it goes to the right (1) or the left (0), at which vertices a value is given (1), the values
Diffusing = list[tuple[int, float, Array, Array]]


def make_line(all_ranks: RankGroup, root: Any, key: int, mesh: int, points: Array, weights: Array) -> Any:
    """Build spaces and forms; return the node (counted cell by cell) of each unknown, rank after rank, and how many.

    points, weights : of Gauss in [0, 1]; polynomials are given by their values there
    """
    part = all_ranks.objects[mesh]
    element, local = versions.gauss_polynomials(points)
    V = versions.function_space(part.mesh, element)
    L = space_on(part, ("nodes", 1))
    Q = space_on(part, ("points", points[:, None], weights))
    ends = np.asarray(part.mesh.geometry.input_global_indices)[versions.geometry_list(part.mesh)]
    cells, n = ends.min(axis=1), len(points)
    stored = SimpleNamespace(part=part, V=V, L=L, Q=Q, n=n, cells=int(part.mesh.topology.index_map(1).size_global))
    stored.owned = int(V.dofmap.index_map.size_local)
    stored.vertices = np.empty(_known(L), dtype=np.int64)
    stored.vertices[versions.dof_list(L)] = ends
    stored.nodes = np.empty(_known(V), dtype=np.int64)
    stored.nodes[versions.dof_list(V)] = cells[:, None] * n + local
    stored.at_points = np.empty(_known(Q), dtype=np.int64)
    stored.at_points[versions.dof_list(Q)] = cells[:, None] * n + np.arange(n)
    _make_forms(stored, points, weights)
    stored.lengths = all_ranks.comm.allreduce(_assembled(stored, "lengths", stored.nodes, stored.cells * n))
    all_ranks.objects[key] = stored
    counts = all_ranks.comm.gather(stored.owned)
    return all_ranks.gather(stored.nodes[: stored.owned], counts), counts


def _known(space: Any) -> int:
    """Return the number of unknowns of a space that this rank knows."""
    return int(space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts)


def _make_forms(stored: Any, points: Array, weights: Array) -> None:
    """Compile all forms; their coefficients are functions kept in `stored`."""
    import ufl
    from dolfinx import fem

    mesh, V, L, Q = stored.part.mesh, stored.V, stored.L, stored.Q
    # spaces that are the same object make DOLFINx set a diagonal, for which all ranks meet
    u, v, w = ufl.TrialFunction(V.clone()), ufl.TestFunction(V), ufl.TestFunction(L)
    stored.field = field = fem.Function(V)
    stored.flux, stored.source = flux, source = fem.Function(Q), fem.Function(Q)
    stored.left, stored.right = on_left, on_right = fem.Function(L), fem.Function(L)
    stored.given, stored.value = given, value = fem.Function(L), fem.Function(L)
    stored.ahead = ahead = fem.Constant(mesh, 1.0)
    n = ufl.FacetNormal(mesh)[0]
    rule = {"quadrature_rule": "custom", "quadrature_points": points[:, None], "quadrature_weights": weights}
    dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 2 * len(points) - 1, **rule})
    dS, ds = ufl.Measure("dS", domain=mesh), ufl.Measure("ds", domain=mesh)

    def left(f: Any) -> Any:
        return ufl.conditional(ufl.gt(n("+"), 0.0), f("+"), f("-"))

    def right(f: Any) -> Any:
        return ufl.conditional(ufl.gt(n("+"), 0.0), f("-"), f("+"))

    def passed(at_vertices: Any, at_ends: Any) -> Any:
        return at_vertices * (left(v) - right(v)) * dS + at_ends * n * v * ds

    def lifted(f: Any, outside: Any) -> Any:
        onto = ahead * right(v) + (1.0 - ahead) * left(v)
        return f.dx(0) * v * dx + (right(f) - left(f)) * onto * dS + given * (outside - f) * n * v * ds

    forms = {
        "residual": -(flux * v.dx(0) + source * v) * dx + passed(on_left("+"), on_left),
        "jacobian": -(flux * u * v.dx(0) + source * u * v) * dx
        + passed(on_left("+") * left(u) + on_right("+") * right(u), (on_left + on_right) * u),
        "damping": -flux * u.dx(0) * v.dx(0) * dx,
        "gradient": lifted(field, value),
        "gradient_by_field": lifted(u, 0.0),
        "lengths": v * dx,
        "from_left": left(field) * w("+") * dS + ufl.conditional(ufl.gt(n, 0.0), field, 0.0) * w * ds,
        "from_right": right(field) * w("+") * dS + ufl.conditional(ufl.gt(n, 0.0), 0.0, field) * w * ds,
    }
    stored.forms = {name: versions.compiled(form) for name, form in forms.items()}


def _assembled(stored: Any, form: str, places: Any, size: int) -> Array:
    """Return this rank's part of an assembled vector in the numbering of the root rank."""
    from dolfinx import fem

    here, out = np.zeros(len(places)), np.zeros(size)
    fem.assemble_vector(here, stored.forms[form])  # into an array: a vector of DOLFINx is made by all ranks together
    np.add.at(out, places, here)
    return out


def look(all_ranks: RankGroup, root: Any, key: int, fields: Array, diffusing: Diffusing) -> Any:
    """Return gradients of fields at the nodes, and traces of fields and gradients from the left and right at vertices.

    fields : (m, nodes)
    diffusing : of those whose gradients are asked for
    """
    stored = all_ranks.objects[key]
    slopes = np.empty((len(diffusing), fields.shape[1]))
    for k, (f, ahead, given, value) in enumerate(diffusing):
        stored.field.x.array[:] = fields[f][stored.nodes]
        _set_ends(stored, ahead, given, value)
        slopes[k] = _assembled(stored, "gradient", stored.nodes, fields.shape[1])
    if diffusing:
        slopes = all_ranks.comm.allreduce(slopes) / stored.lengths
    return slopes, all_ranks.comm.reduce(_traces(stored, np.concatenate([fields, slopes])))


def _traces(stored: Any, fields: Array) -> Array:
    """Return this rank's part of the values at vertices from the left and from the right (m, 2, N + 1)."""
    out = np.zeros((len(fields), 2, stored.cells + 1))
    for f, values in enumerate(fields):
        stored.field.x.array[:] = values[stored.nodes]
        for k, form in enumerate(("from_left", "from_right")):
            out[f, k] = _assembled(stored, form, stored.vertices, stored.cells + 1)
    return out


def _set_ends(stored: Any, ahead: float, given: Array, value: Array) -> None:
    stored.ahead.value = ahead
    stored.given.x.array[:], stored.value.x.array[:] = given[stored.vertices], value[stored.vertices]


def residual(all_ranks: RankGroup, root: Any, key: int, fluxes: Array, sources: Array, through: Array) -> Any:
    """Return the residuals (m, nodes) of fluxes and sources at the points and fluxes through the vertices."""
    stored = all_ranks.objects[key]
    out = []
    for flux, source, at_vertices in zip(fluxes, sources, through, strict=True):
        stored.flux.x.array[:], stored.source.x.array[:] = flux[stored.at_points], source[stored.at_points]
        stored.left.x.array[:] = at_vertices[stored.vertices]
        out.append(_assembled(stored, "residual", stored.nodes, len(flux)))
    return all_ranks.comm.reduce(np.array(out))


def jacobian(
    all_ranks: RankGroup,
    root: Any,
    key: int,
    matrix: int,
    fields: int,
    pairs: list[tuple[int, int]],
    inside: Array,
    at_vertices: Array,
    damped: list[tuple[int, int, Array]],
    diffusing: Diffusing,
) -> None:
    """Store the matrix of derivatives by `fields` unknowns of each node as object `matrix`.

    pairs : (equation, unknown), where gradients are unknowns behind the fields
    inside : for each pair, derivatives (2, nodes) of flux and source
    at_vertices : for each pair, derivatives (2, N + 1) of fluxes by traces from the left and the right
    damped : (equation, field, derivatives of the flux at the nodes by the gradient of the field within its cell)
    """
    stored = all_ranks.objects[key]
    slopes = len(diffusing)
    own = [row for row, column in pairs if column < fields] + [row for row, *_ in damped]
    A = _Part(all_ranks, stored, (fields, fields), own)
    by_slope = _Part(all_ranks, stored, (fields, slopes), [row for row, column in pairs if column >= fields])
    of_slope = _Part(all_ranks, stored, (slopes, fields), range(slopes))
    for (row, column), (flux, source), (left, right) in zip(pairs, inside, at_vertices, strict=True):
        stored.flux.x.array[:], stored.source.x.array[:] = flux[stored.at_points], source[stored.at_points]
        stored.left.x.array[:], stored.right.x.array[:] = left[stored.vertices], right[stored.vertices]
        into, k = (A, column) if column < fields else (by_slope, column - fields)
        into.add(row, k, "jacobian")
    for row, column, flux in damped:
        stored.flux.x.array[:] = flux[stored.at_points]
        A.add(row, column, "damping")
    for k, (f, ahead, given, value) in enumerate(diffusing):
        _set_ends(stored, ahead, given, value)
        of_slope.add(k, f, "gradient_by_field")
    made = A.made()
    if slopes:
        first, second = by_slope.made(), of_slope.made()
        scale = second.createVecLeft()
        scale.array[:] = np.repeat(1.0 / stored.lengths[stored.nodes[: stored.owned]], slopes)
        second.diagonalScale(scale, None)
        product = first.matMult(second)
        made.axpy(1.0, product)
        for used in (first, second, product):
            used.destroy()
    all_ranks.objects[matrix] = LocalMatrix(made, SimpleNamespace(fields=[None], block=1))


class _Part:
    """A matrix with so many rows and columns at each node, to be added to; `pairs` holds the row of each block."""

    def __init__(self, all_ranks: RankGroup, stored: Any, counts: tuple[int, int], pairs: Any):
        from petsc4py import PETSc

        self.forms, comm = stored.forms, all_ranks.comm
        known = stored.V.dofmap.index_map.local_to_global(np.arange(len(stored.nodes), dtype=np.int32))
        self.maps = [
            [PETSc.LGMap().create((count * known + k).astype(np.int32), comm=comm) for k in range(count)]
            for count in counts
        ]
        local = [count * stored.owned for count in counts]
        width = np.bincount(np.asarray(pairs, dtype=int), minlength=counts[0]) * 3 * stored.n
        rows = np.tile(width, stored.owned).astype(np.int32)
        self.A = PETSc.Mat().createAIJ(((local[0], PETSc.DECIDE), (local[1], PETSc.DECIDE)), comm=comm)
        self.A.setPreallocationNNZ((np.minimum(rows, local[1]), rows))
        self.A.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)

    def add(self, row: int, column: int, form: str) -> None:
        """Add the block of an equation and an unknown."""
        from dolfinx.fem import petsc

        self.A.setLGMap(self.maps[0][row], self.maps[1][column])
        petsc.assemble_matrix(self.A, self.forms[form])

    def made(self) -> Any:
        """Return the assembled matrix."""
        self.A.assemble()
        return self.A
