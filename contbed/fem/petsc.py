"""Distributed matrices, and their inverses by policy: MUMPS where its factors fit, else multigrid.

At the leader a `Matrix` is a number that all ranks know; it offers what Newton's method, time steps and
`solve.linear.Solver` do with a matrix of SciPy. Vectors come and go whole, in the leader's numbering.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.errors import ConvergenceError
from contbed.fem.ranks import Crew, crew
from contbed.solvers.linear import Policy

DIRECT_3D = 60_000
KRYLOV = {"ksp_type": "fgmres", "ksp_rtol": 1e-11, "ksp_atol": 0.0, "ksp_max_it": 600, "ksp_gmres_restart": 80}
SMOOTHER = {"mg_levels_ksp_type": "richardson", "mg_levels_ksp_max_it": 1, "mg_levels_pc_type": "bjacobi"}
# all temperatures of a node are one block, because exchange binds them; ILU(0) of these blocks smooths
MULTIGRID = KRYLOV | {"pc_type": "gamg"} | SMOOTHER
# drag makes the velocity block nearly diagonal, so its diagonal gives a good Schur complement for the pressure, a
# Laplacian scaled by the permeability: one cycle of multigrid would solve it ever worse as cells get smaller
SPLIT = KRYLOV | {
    "pc_type": "fieldsplit",
    "pc_fieldsplit_type": "schur",
    "pc_fieldsplit_schur_fact_type": "full",
    "pc_fieldsplit_schur_precondition": "selfp",
    "fieldsplit_0_ksp_type": "preonly",
    "fieldsplit_0_pc_type": "bjacobi",
    "fieldsplit_1_ksp_type": "preonly",
    "fieldsplit_1_pc_type": "ksp",
    "fieldsplit_1_ksp_ksp_type": "gmres",
    "fieldsplit_1_ksp_ksp_rtol": 1e-2,
    "fieldsplit_1_ksp_pc_type": "gamg",
}
FACTORS = {
    "ksp_type": "preonly",
    "pc_type": "lu",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_14": 60,
}  # room for pivots, in percent


class PetscPolicy(Policy):
    """How PETSc solves; memory is that of all ranks."""

    def direct(self, size: int) -> bool:
        """Whether systems of this size are factored by MUMPS."""
        return self.dimension < 3 or size <= DIRECT_3D


@dataclass(frozen=True, eq=False)
class Layout:
    """Where unknowns are: `order` names those of each rank in turn, `counts` of them; `size` in all."""

    order: Any
    counts: Any
    size: int

    @staticmethod
    def spread(all_ranks: Crew, layout: Layout | None, values: Any) -> Any:
        """This rank's share of the leader's vector."""
        if layout is None:
            return all_ranks.scatter(None, None, 1, float)[:, 0]
        return all_ranks.scatter(values[layout.order], layout.counts, 1, float)[:, 0]

    def collected(self, parts: Any) -> Any:
        """The vector whose shares were gathered."""
        out = np.empty(self.size)
        out[self.order] = parts
        return out

    def places(self) -> Any:
        """PETSc's number of each unknown."""
        out = np.empty(self.size, dtype=np.int32)
        out[self.order] = np.arange(self.size, dtype=np.int32)
        return out

    def entries(self, matrix: Any) -> tuple[Any, Any, Any, Any]:
        """Entries of a SciPy matrix in PETSc's numbers: row starts, columns, values, and the rows that have any."""
        rows = matrix.tocsr()
        places, filled = self.places(), np.flatnonzero(np.diff(rows.indptr))
        starts = np.append(0, np.cumsum(np.diff(rows.indptr)[filled])).astype(np.int32)
        return starts, places[rows.indices], rows.data, places[filled]


@dataclass(eq=False)
class Piece:
    """This rank's piece of a matrix over the unknowns of a system."""

    A: Any
    unknowns: Any

    def destroy(self) -> None:
        """Free it."""
        self.A.destroy()


class Matrix:
    """A distributed matrix, at the leader."""

    __array_ufunc__ = None  # numbers of NumPy leave products to us

    def __init__(self, all_ranks: Crew, key: int, layout: Layout):
        self.crew, self.key, self.layout = all_ranks, key, layout
        self.shape = (layout.size, layout.size)

    def __del__(self) -> None:
        self.crew.dropped.append(self.key)

    def _made(self, function: Callable[..., None], *arguments: Any, root: Any = None) -> Matrix:
        key = self.crew.new()
        self.crew.together(function, key, self.key, *arguments, root=root)
        return Matrix(self.crew, key, self.layout)

    def __matmul__(self, x: Any) -> Any:
        return self.layout.collected(self.crew.together(multiply, self.key, False, root=(self.layout, x)))

    def __abs__(self) -> Any:
        return _Absolute(self)

    def __mul__(self, factor: float) -> Matrix:
        return self._made(combine, None, float(factor))

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> Matrix:
        return self * (1.0 / divisor)

    def __add__(self, other: Matrix) -> Matrix:
        return self._made(combine, other.key, 1.0)

    def constrained(self, fixed: Any) -> Matrix:
        """The matrix with the rows and columns of fixed unknowns replaced by the identity."""
        return self._made(constrain, root=self.layout.places()[fixed]) if len(fixed) else self

    def scaled(self, factors: Any) -> Matrix:
        """The matrix with each column times a factor."""
        return self._made(scale, root=(self.layout, factors))

    def bordered(self, column: Any, row: Any, corner: float) -> Matrix:
        """The matrix with one more unknown and equation, behind those of the last rank."""
        layout = self.layout
        counts = [*layout.counts[:-1], layout.counts[-1] + 1]
        wider = Layout(np.append(layout.order, layout.size), counts, layout.size + 1)
        made = self._made(border, root=(layout, column, np.append(row, corner)[wider.order]))
        made.layout, made.shape = wider, (wider.size, wider.size)
        return made

    def inverse(self, policy: Policy) -> Callable[[Any], Any]:
        """Solutions for right-hand sides."""
        return _Inverse(self, policy)


class _Absolute:
    """The matrix of absolute values, for products only."""

    def __init__(self, matrix: Matrix):
        self.matrix = matrix

    def __matmul__(self, x: Any) -> Any:
        m = self.matrix
        return m.layout.collected(m.crew.together(multiply, m.key, True, root=(m.layout, x)))


class _Inverse:
    """Factors or a preconditioner with a Krylov method, at the leader."""

    def __init__(self, matrix: Matrix, policy: Policy):
        self.matrix, self.crew, self.key = matrix, matrix.crew, matrix.crew.new()
        self.direct = policy.direct(matrix.layout.size)
        self.crew.together(prepare, self.key, matrix.key, self.direct)

    def __del__(self) -> None:
        self.crew.dropped.append(self.key)

    def __call__(self, rhs: Any) -> Any:
        """The solution; raises ConvergenceError where PETSc gives up."""
        layout = self.matrix.layout
        parts, reason, iterations = self.crew.together(apply, self.key, root=(layout, rhs))
        self.crew.iterations.append(iterations)
        if reason < 0:
            how = (
                "the factorisation failed: is a temperature or the pressure fixed anywhere?"
                if self.direct
                else (f"no convergence in {iterations} iterations")
            )
            raise ConvergenceError(f"linear solver of PETSc, reason {reason}: {how}")
        return layout.collected(parts)


def given(matrix: Any) -> Matrix:
    """A distributed copy of the leader's matrix of SciPy, its rows dealt out in turn."""
    all_ranks, rows, size = crew(), matrix.tocsr(), matrix.shape[0]
    ends = np.linspace(0, size, all_ranks.comm.size + 1).astype(int)
    key, counts, entries = all_ranks.new(), np.diff(ends), np.diff(rows.indptr[ends])
    lengths = np.diff(rows.indptr)
    all_ranks.together(receive, key, root=((lengths, counts), (rows.indices, entries), (rows.data, entries)))
    return Matrix(all_ranks, key, Layout(np.arange(size), counts, size))


# What follows runs on all ranks.


def receive(all_ranks: Crew, root: Any, key: int) -> None:
    """Thing `key` becomes a matrix of the leader's entries."""
    from petsc4py import PETSc

    parts = zip(root or [(None, None)] * 3, (np.int32, np.int32, float), strict=True)
    lengths, columns, values = (all_ranks.scatter(given, counts, 1, kind)[:, 0] for (given, counts), kind in parts)
    starts = np.append(0, np.cumsum(lengths)).astype(np.int32)
    local = (len(lengths), PETSc.DECIDE)
    A = PETSc.Mat().createAIJ((local, local), csr=(starts, columns, values), comm=all_ranks.comm)
    all_ranks.things[key] = Piece(A, SimpleNamespace(fields=[None], block=1))


def multiply(all_ranks: Crew, root: Any, key: int, absolute: bool) -> Any:
    """Product with a vector."""
    A = all_ranks.things[key].A
    layout, x = root or (None, None)
    right, left = A.createVecs()
    right.array[:] = Layout.spread(all_ranks, layout, x)
    if absolute:
        from petsc4py import PETSc

        starts, columns, values = A.getValuesCSR()
        A = PETSc.Mat().createAIJ(A.getSizes(), csr=(starts, columns, np.abs(values)), comm=A.comm)
    A.mult(right, left)
    if absolute:
        A.destroy()
    return all_ranks.gather(left.array, layout and layout.counts)


def combine(all_ranks: Crew, root: Any, key: int, first: int, second: int | None, factor: float) -> None:
    """Thing `key` becomes factor * first (+ second)."""
    from petsc4py import PETSc

    piece = all_ranks.things[first]
    A = piece.A.copy()
    if factor != 1.0:
        A.scale(factor)
    if second is not None:
        A.axpy(1.0, all_ranks.things[second].A, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    all_ranks.things[key] = Piece(A, piece.unknowns)


def constrain(all_ranks: Crew, root: Any, key: int, first: int) -> None:
    """Thing `key` becomes first with rows and columns `root` replaced by the identity."""
    piece = all_ranks.things[first]
    A = piece.A.copy()
    A.zeroRowsColumns(np.empty(0, np.int32) if root is None else root.astype(np.int32), 1.0)
    all_ranks.things[key] = Piece(A, piece.unknowns)


def scale(all_ranks: Crew, root: Any, key: int, first: int) -> None:
    """Thing `key` becomes first with its columns times factors."""
    piece = all_ranks.things[first]
    A = piece.A.copy()
    right = A.createVecRight()
    layout, factors = root or (None, None)
    right.array[:] = Layout.spread(all_ranks, layout, factors)
    A.diagonalScale(None, right)
    all_ranks.things[key] = Piece(A, piece.unknowns)


def border(all_ranks: Crew, root: Any, key: int, first: int) -> None:
    """Thing `key` becomes first with one more column and row."""
    from petsc4py import PETSc

    piece, comm = all_ranks.things[first], all_ranks.comm
    layout, column, row = root or (None, None, None)
    size = piece.A.getSize()[0]
    starts, columns, values = piece.A.getValuesCSR()
    mine = Layout.spread(all_ranks, layout, column)
    last = all_ranks.scatter(row, None if row is None else [0] * (comm.size - 1) + [size + 1], 1, float)[:, 0]
    columns = np.append(np.insert(columns, starts[1:], size), np.arange(len(last)))
    values = np.append(np.insert(values, starts[1:], mine), last)
    starts = starts + np.arange(len(starts))
    if len(last):
        starts = np.append(starts, len(columns))
    local = len(starts) - 1
    csr = (starts.astype(np.int32), columns.astype(np.int32), values)
    A = PETSc.Mat().createAIJ(((local, PETSc.DECIDE), (local, PETSc.DECIDE)), csr=csr, comm=comm)
    all_ranks.things[key] = Piece(A, piece.unknowns)


def prepare(all_ranks: Crew, root: Any, key: int, matrix: int, direct: bool) -> None:
    """Thing `key` becomes a solver with a matrix."""
    from petsc4py import PETSc

    piece = all_ranks.things[matrix]
    mixed = len(piece.unknowns.fields) > 1 and piece.unknowns.block == 1
    ksp = PETSc.KSP().create(piece.A.comm)
    ksp.setOperators(piece.A)
    ksp.setOptionsPrefix(prefix := f"contbed_{key}_")
    options = PETSc.Options(prefix)
    chosen: dict[str, Any] = FACTORS if direct else SPLIT if mixed else MULTIGRID
    for name, value in chosen.items():
        options[name] = value
    ksp.setFromOptions()
    if mixed and not direct:
        start = piece.A.getOwnershipRange()[0]
        parts = (PETSc.IS().createGeneral(part + start, comm=piece.A.comm) for part in piece.unknowns.fields)
        ksp.getPC().setFieldSplitIS(*((str(k), part) for k, part in enumerate(parts)))
    ksp.setUp()
    if mixed and not direct:  # the parts read their options now
        for part in ksp.getPC().getFieldSplitSchurGetSubKSP():
            part.setUp()
    for name in chosen:
        options.delValue(name)
    all_ranks.things[key] = ksp


def apply(all_ranks: Crew, root: Any, key: int) -> Any:
    """Solution, reason and iterations."""
    ksp = all_ranks.things[key]
    layout, rhs = root or (None, None)
    x, b = ksp.getOperators()[0].createVecs()
    b.array[:] = Layout.spread(all_ranks, layout, rhs)
    ksp.solve(b, x)
    parts = all_ranks.gather(x.array, layout and layout.counts)
    return parts, ksp.getConvergedReason(), ksp.getIterationNumber()
