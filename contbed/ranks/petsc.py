"""Distributed PETSc matrices, and their solution by policy: MUMPS where its factors
fit, else multigrid.

On rank 0 a `Matrix` holds the number of an object that all ranks have. It offers what
Newton's method, time steps and `solvers.linear.Solver` do with a SciPy matrix. Vectors
are passed as a whole, in the numbering of the root rank.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.errors import ConvergenceError
from contbed.ranks.group import RankGroup
from contbed.solvers.cost import memory_GB
from contbed.solvers.linear import Policy

DIRECT_3D = 60_000
KRYLOV = {
    "ksp_type": "fgmres",
    "ksp_rtol": 1e-11,
    "ksp_atol": 0.0,
    "ksp_max_it": 600,
    "ksp_gmres_restart": 80,
}
SMOOTHER = {
    "mg_levels_ksp_type": "richardson",
    "mg_levels_ksp_max_it": 1,
    "mg_levels_pc_type": "bjacobi",
}
# all temperatures of a node are one block, because exchange binds them; ILU(0) of these
# blocks smooths
MULTIGRID = KRYLOV | {"pc_type": "gamg"} | SMOOTHER
# drag makes the velocity block nearly diagonal, so its diagonal gives a good Schur
# complement for the pressure, a Laplacian scaled by the permeability: one cycle of
# multigrid would solve it ever worse as cells get smaller
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
    """Choice of the linear solver for PETSc; the memory limit is that of all ranks
    together.
    """

    def direct(self, size: int) -> bool:
        """Return whether systems of this size are factored by MUMPS."""
        return self.dimension < 3 or size <= DIRECT_3D

    def predicted_GB(self, size: int) -> float:
        """Predict the memory of all ranks [GB]: of factors as elsewhere, of
        multigrid as `solvers.cost` has it.
        """
        return (
            super().predicted_GB(size)
            if self.direct(size)
            else memory_GB(self.dimension, size)
        )


@dataclass(frozen=True, eq=False)
class Layout:
    """Distribution of unknowns: `order` lists those of each rank in turn, `counts`
    how many each has; `size` in all.
    """

    order: Any
    counts: Any
    size: int

    @staticmethod
    def scatter(all_ranks: RankGroup, layout: Layout | None, values: Any) -> Any:
        """Return the part of rank 0's vector that belongs to the calling rank."""
        if layout is None:
            return all_ranks.scatter(None, None, 1, float)[:, 0]
        return all_ranks.scatter(values[layout.order], layout.counts, 1, float)[:, 0]

    def from_parts(self, parts: Any) -> Any:
        """Return the vector (size,) in rank 0's numbering from the gathered parts."""
        out = np.empty(self.size)
        out[self.order] = parts
        return out

    def petsc_numbers(self) -> Any:
        """Return PETSc's number of each unknown (size,)."""
        out = np.empty(self.size, dtype=np.int32)
        out[self.order] = np.arange(self.size, dtype=np.int32)
        return out

    def entries(self, matrix: Any) -> tuple[Any, Any, Any, Any]:
        """Return the rows of a SciPy matrix in PETSc's numbers: row starts, columns,
        values, non-empty rows.
        """
        rows = matrix.tocsr()
        places, filled = self.petsc_numbers(), np.flatnonzero(np.diff(rows.indptr))
        starts = np.append(0, np.cumsum(np.diff(rows.indptr)[filled])).astype(np.int32)
        return starts, places[rows.indices], rows.data, places[filled]


@dataclass(eq=False)
class LocalMatrix:
    """The rows of a distributed matrix on one rank, with the unknowns that they
    belong to.
    """

    A: Any
    unknowns: Any

    def destroy(self) -> None:
        """Free the PETSc matrix."""
        self.A.destroy()


class Matrix:
    """A distributed matrix as seen from rank 0."""

    __array_ufunc__ = None  # numbers of NumPy leave products to us

    def __init__(self, all_ranks: RankGroup, key: int, layout: Layout):
        self.ranks, self.key, self.layout = all_ranks, key, layout
        self.shape = (layout.size, layout.size)

    def __del__(self) -> None:
        self.ranks.released.append(self.key)

    def _made(
        self, function: Callable[..., None], *arguments: Any, root: Any = None
    ) -> Matrix:
        key = self.ranks.new_key()
        self.ranks.run_on_all(function, key, self.key, *arguments, root=root)
        return Matrix(self.ranks, key, self.layout)

    def __matmul__(self, x: Any) -> Any:
        return self.layout.from_parts(
            self.ranks.run_on_all(multiply, self.key, False, root=(self.layout, x))
        )

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
        """Return the matrix with rows and columns of fixed unknowns replaced by the
        identity.
        """
        return (
            self._made(constrain, root=self.layout.petsc_numbers()[fixed])
            if len(fixed)
            else self
        )

    def inverse(self, policy: Policy) -> Callable[[Any], Any]:
        """Return a function that solves for right-hand sides."""
        return _Inverse(self, policy)


class _Absolute:
    """The matrix of absolute values; it can only be multiplied with a vector."""

    def __init__(self, matrix: Matrix):
        self.matrix = matrix

    def __matmul__(self, x: Any) -> Any:
        m = self.matrix
        return m.layout.from_parts(
            m.ranks.run_on_all(multiply, m.key, True, root=(m.layout, x))
        )


class _Inverse:
    """A factorisation, or a preconditioned Krylov method, as seen from rank 0."""

    def __init__(self, matrix: Matrix, policy: Policy):
        self.matrix, self.ranks, self.key = matrix, matrix.ranks, matrix.ranks.new_key()
        self.direct = policy.direct(matrix.layout.size)
        self.ranks.run_on_all(prepare, self.key, matrix.key, self.direct)

    def __del__(self) -> None:
        self.ranks.released.append(self.key)

    def __call__(self, rhs: Any) -> Any:
        """Return the solution; raise ConvergenceError where PETSc does not converge."""
        layout = self.matrix.layout
        parts, reason, iterations = self.ranks.run_on_all(
            apply, self.key, root=(layout, rhs)
        )
        self.ranks.iterations.append(iterations)
        if reason < 0:
            how = (
                "the factorisation failed: is a temperature or the pressure fixed "
                "anywhere?"
                if self.direct
                else (f"no convergence in {iterations} iterations")
            )
            raise ConvergenceError(f"linear solver of PETSc, reason {reason}: {how}")
        return layout.from_parts(parts)


# What follows runs on all ranks.


def multiply(all_ranks: RankGroup, root: Any, key: int, absolute: bool) -> Any:
    """Return the product of matrix `key`, or of its absolute values, with a vector."""
    A = all_ranks.objects[key].A
    layout, x = root or (None, None)
    right, left = A.createVecs()
    right.array[:] = Layout.scatter(all_ranks, layout, x)
    if absolute:
        from petsc4py import PETSc

        starts, columns, values = A.getValuesCSR()
        A = PETSc.Mat().createAIJ(
            A.getSizes(), csr=(starts, columns, np.abs(values)), comm=A.comm
        )
    A.mult(right, left)
    if absolute:
        A.destroy()
    return all_ranks.gather(left.array, layout and layout.counts)


def combine(
    all_ranks: RankGroup,
    root: Any,
    key: int,
    first: int,
    second: int | None,
    factor: float,
) -> None:
    """Store factor * first (+ second) as object `key`."""
    from petsc4py import PETSc

    piece = all_ranks.objects[first]
    A = piece.A.copy()
    if factor != 1.0:
        A.scale(factor)
    if second is not None:
        A.axpy(
            1.0, all_ranks.objects[second].A, PETSc.Mat.Structure.SAME_NONZERO_PATTERN
        )
    all_ranks.objects[key] = LocalMatrix(A, piece.unknowns)


def constrain(all_ranks: RankGroup, root: Any, key: int, first: int) -> None:
    """Store matrix `first` with rows and columns `root` replaced by the identity as
    object `key`.
    """
    piece = all_ranks.objects[first]
    A = piece.A.copy()
    A.zeroRowsColumns(
        np.empty(0, np.int32) if root is None else root.astype(np.int32), 1.0
    )
    all_ranks.objects[key] = LocalMatrix(A, piece.unknowns)


def prepare(
    all_ranks: RankGroup, root: Any, key: int, matrix: int, direct: bool
) -> None:
    """Store a solver for a matrix as object `key`."""
    from petsc4py import PETSc

    piece = all_ranks.objects[matrix]
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
        parts = (
            PETSc.IS().createGeneral(part + start, comm=piece.A.comm)
            for part in piece.unknowns.fields
        )
        ksp.getPC().setFieldSplitIS(*((str(k), part) for k, part in enumerate(parts)))
    ksp.setUp()
    if mixed and not direct:  # the parts read their options now
        for part in ksp.getPC().getFieldSplitSchurGetSubKSP():
            part.setUp()
    for name in chosen:
        options.delValue(name)
    all_ranks.objects[key] = ksp


def apply(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Solve with solver `key`; return the solution, PETSc's reason for stopping and
    the number of iterations.
    """
    ksp = all_ranks.objects[key]
    layout, rhs = root or (None, None)
    x, b = ksp.getOperators()[0].createVecs()
    b.array[:] = Layout.scatter(all_ranks, layout, rhs)
    ksp.solve(b, x)
    parts = all_ranks.gather(x.array, layout and layout.counts)
    return parts, ksp.getConvergedReason(), ksp.getIterationNumber()
