"""Sparse linear systems by policy: predict the memory, factor or iterate, check the
residual.

2-D and small systems are factored by SuperLU in a symmetric ordering: nested dissection
of the mesh, or else minimum degree of A + A'. Where the restricted pivoting loses
accuracy the matrix is factored again with full pivoting. Fill in 3-D grows as n^(4/3),
so GMRES takes the place of factors: beyond `MULTIGRID_3D` unknowns with a multigrid
cycle for temperatures and incident radiation (`multigrid`), beyond `DIRECT_3D` for
others and where multigrid does not do with an incomplete factorisation: a thin one for
equations with a diagonal, a thick one where pressures have none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from inspect import signature
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from contbed.errors import ConvergenceError, SceneError
from contbed.scene.size import available_bytes
from contbed.solvers.multigrid import Vertices, two_level

DIRECT_3D = 120_000
# temperatures above which a cycle of multigrid takes less time than factors
MULTIGRID_3D = 15_000
GMRES_ITERATIONS = 12  # iterations that cost about as much as a factorisation
# diagonal entries down to this share of the column are kept as pivots, which keeps the
# ordering
PIVOT_THRESHOLD = 1e-3
ROUNDING = 1e-14  # share of its terms down to which a residual can be computed
# terms over right-hand side up to which any solution is one, and beyond which the
# matrix counts as singular
WELL, SINGULAR = 1e11, 1e14
# between these, largest share of a solution that its residual may change: a singular
# matrix changes all
KNOWN = 1e-2
# largest entries dropped and most fill of incomplete factors. The thin ones hold as
# much as the matrix; with 49 000 temperatures they take 3 s and 17 to 45 iterations,
# the thick ones 10 s and 5 iterations
THIN, THICK = (1e-2, 3.0), (1e-4, 20.0)
RESTART, RESTARTS, ITERATIVE = 80, 10, 1e-13  # of GMRES, and its relative residual
# temperatures up to which factors take over where multigrid does not do, and thin ones
# beyond
FEW = 40_000
ENTRY_GB = 1.2e-8  # an entry of a factor with its index
# its name before SciPy 1.12
RTOL = "rtol" if "rtol" in signature(spla.gmres).parameters else "tol"
# a solve with a larger relative residual is repeated with full pivoting
RESIDUAL = 1e-9


@dataclass
class Policy:
    """Choice of the linear solver for a mesh of `dimension`.

    A factorisation that is predicted to need more than `limit_GB` is refused. `order`
    is the order of elimination; `multigrid` says whether all unknowns diffuse, and
    `vertices` then returns their interpolation from vertices. `block` is the number of
    unknowns of a cell of a line whose matrix is of full blocks.
    """

    dimension: int
    limit_GB: float | None = None
    order: Any = None
    multigrid: bool = False
    vertices: Callable[[], Vertices] | None = None
    block: int = 0

    def direct(self, size: int) -> bool:
        """Return whether systems of this size are factored."""
        return self.dimension < 3 or size <= (
            MULTIGRID_3D if self.multigrid else DIRECT_3D
        )

    def predicted_GB(self, size: int) -> float:
        """Predict the memory of assembly and factorisation [GB].

        Measured: 5 kB per unknown in 2-D. In 3-D with two temperatures on hexahedra: 15
            kB per unknown while
        the matrix is assembled, 2.2 GB for the factors of 68000 unknowns, growing as
        n^(4/3), and 5 kB per unknown for incomplete factors and the vectors of GMRES;
        10 kB in all with multigrid. The three blocks of each cell of a line are there
        twice, as added and in the order of factors: 11 GB for 73,728 unknowns in blocks
        of 3072.
        """
        if self.dimension == 1:
            return max(4e-7, 6 * 8e-9 * self.block) * size
        if self.dimension == 2:
            return 5e-6 * size
        if self.multigrid and not self.direct(size):
            return 1e-5 * size
        return (
            max(1.5e-5 * size, 8e-7 * size ** (4 / 3))
            if self.direct(size)
            else 2e-5 * size
        )

    def check_memory(self, size: int) -> None:
        """Raise SceneError when the factors would not fit."""
        if (need := self.predicted_GB(size)) > (limit := self.allowed_GB()):
            raise SceneError(
                f"solver.memory_GB: {size} unknowns need about {need:.3g} GB, allowed "
                f"are {limit:.3g} GB; "
                "coarsen the mesh, lower solver.degree or raise solver.memory_GB"
            )

    def allowed_GB(self) -> float:
        """Return the memory that may be used [GB]: what the scene gives, or 60 % of
        what is free.
        """
        if self.limit_GB is not None:
            return self.limit_GB
        return 0.6e-9 * available_bytes()


class Solver:
    """The inverse of one matrix, by factors or by GMRES."""

    def __init__(self, matrix: sp.csc_matrix, policy: Policy):
        self.matrix, self.policy = matrix, policy
        policy.check_memory(matrix.shape[0])
        self._apply: Callable[[Any], Any]
        if not sp.issparse(matrix):  # of an engine with a solver of its own
            self._apply = matrix.inverse(policy)
            return
        if not np.isfinite(matrix.data).all():
            raise ConvergenceError(
                "the matrix holds values that are not finite: check closures and "
                "initial values"
            )
        if policy.direct(matrix.shape[0]):
            on_diagonal = policy.dimension == 1 and matrix.diagonal().all()
            threshold = 0.0 if on_diagonal else PIVOT_THRESHOLD
            self._apply = _factor(matrix, policy.order, threshold) or self._pivoted()
        else:
            self._apply = _krylov(matrix, policy)

    def _pivoted(self) -> Callable[[Any], Any]:
        if not sp.issparse(self.matrix):  # has pivoted as far as it can
            return self._apply
        apply = _factor(self.matrix, None, pivoting=True)
        if apply is None:
            raise ConvergenceError(
                "the linear system is singular: is a temperature or the pressure fixed "
                "anywhere?"
            )
        return apply

    def solve_other(
        self, matrix: sp.csc_matrix, rhs: Any, tolerance: float
    ) -> Any | None:
        """Solve with another matrix by GMRES, preconditioned by this one; None if it
        needs too many iterations.

        The preconditioner stands on the right, so that GMRES minimises the residual
        itself and `tolerance` is met.
        """
        if not self.policy.direct(len(rhs)):
            return None
        product = spla.LinearOperator(
            matrix.shape, lambda y: matrix @ self._apply(y), dtype=float
        )
        y, failed = _gmres(product, rhs, tolerance, restart=GMRES_ITERATIONS, maxiter=1)
        return None if failed else self._apply(y)

    def _is_rounding(self, residual: Any, x: Any, scale: float) -> bool:
        """Return whether a residual is only rounding, the best that an ill-conditioned
        matrix allows, and x is known.

        Fast mixing adds terms that nearly cancel, beside which a right-hand side may be
        less than their rounding.
        """
        error, magnitudes = float(np.linalg.norm(residual)), abs(self.matrix)
        terms = float(np.linalg.norm(magnitudes @ np.abs(x)))
        if error <= ROUNDING * min(terms, WELL * scale):
            return True
        if not error <= ROUNDING * terms <= ROUNDING * SINGULAR * scale:
            return False
        return bool(
            np.linalg.norm(magnitudes @ np.abs(self._apply(residual))) <= KNOWN * terms
        )

    def approximate(self, rhs: Any) -> Any:
        """Apply the factors once, without refinement, for use with another matrix."""
        return self._apply(rhs)

    def _refined(self, rhs: Any) -> tuple[Any, Any]:
        """Return the solution and its residual, refined once by factors.

        Rows that are small beside others, as those of phases that hardly flow, are
        solved only then.
        """
        x = self._apply(rhs)
        residual = rhs - self.matrix @ x
        if self.policy.direct(len(rhs)):
            x = x + self._apply(residual)
            residual = rhs - self.matrix @ x
        return x, residual

    def __call__(self, rhs: Any) -> Any:
        """Solve, refine once if that helps, check the residual."""
        scale = float(np.linalg.norm(rhs))
        if scale == 0.0:
            return np.zeros_like(rhs)
        x, residual = self._refined(rhs)
        if not (
            np.linalg.norm(residual) <= RESIDUAL * scale
            or self._is_rounding(residual, x, scale)
        ):
            if sp.issparse(self.matrix) and not self.policy.direct(len(rhs)):
                error = np.linalg.norm(residual) / scale
                raise ConvergenceError(
                    f"GMRES left a relative residual of {error:.2g} with {len(rhs)} "
                    "unknowns, too many for a complete "
                    "factorisation; coarsen the mesh or use the engine dolfinx"
                )
            self._apply = self._pivoted()
            x, residual = self._refined(rhs)
            if not (
                np.linalg.norm(residual) <= 1e3 * RESIDUAL * scale
                or self._is_rounding(residual, x, scale)
            ):
                error = np.linalg.norm(residual) / scale
                raise ConvergenceError(
                    f"the linear solver left a relative residual of {error:.2g}"
                )
        return x


def _factor(
    matrix: sp.csc_matrix,
    order: Any,
    threshold: float = PIVOT_THRESHOLD,
    pivoting: bool = False,
) -> Callable[[Any], Any] | None:
    """Factor the symmetrically scaled matrix by SuperLU; None where it meets a zero
    pivot.

    Diagonal entries down to the `threshold` of their column are pivots. On a line all
    of them are where none is zero: a phase that hardly flows has a diagonal of 1e-8 of
    what it takes from others, and another pivot there would give its flow the rounding
    of theirs.
    """
    columns = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    largest = np.zeros(matrix.shape[1])
    np.maximum.at(largest, columns, np.abs(matrix.data))
    scale = 1.0 / np.sqrt(np.where(largest > 0, largest, 1.0))
    options: dict[str, Any] = {
        "diag_pivot_thresh": threshold,
        "options": {"SymmetricMode": True},
        "permc_spec": "MMD_AT_PLUS_A" if order is None else "NATURAL",
    }
    if pivoting:
        options, order = {"permc_spec": "COLAMD"}, None
    try:
        return _inverse(matrix, scale, order, partial(spla.splu, **options))
    except RuntimeError:
        return None


def _inverse(
    matrix: sp.csc_matrix, scale: Any, order: Any, factor: Callable[[Any], Any]
) -> Callable[[Any], Any]:
    """Return the inverse by factors of the matrix with scaled rows and columns, in an
    order of its unknowns; None for their own.
    """
    # SuperLU sorts the indices in place, which the scaled matrix shares
    matrix.sort_indices()
    columns = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    data = matrix.data * scale[matrix.indices] * scale[columns]
    scaled = sp.csc_matrix((data, matrix.indices, matrix.indptr))
    if order is None:
        factors = factor(scaled)
        return lambda rhs: scale * factors.solve(scale * rhs)
    factors = factor(scaled[:, order].tocsr()[order].tocsc())
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    return lambda rhs: scale * factors.solve((scale * rhs)[order])[back]


def _gmres(matrix: Any, rhs: Any, tolerance: float, **options: Any) -> tuple[Any, int]:
    """Solve by GMRES to a relative residual."""
    x, info = spla.gmres(matrix, rhs, atol=0.0, **{RTOL: tolerance}, **options)
    return x, int(info)


def _krylov(matrix: sp.csc_matrix, policy: Policy) -> Callable[[Any], Any]:
    """Return the inverse by GMRES with the cheapest preconditioner first, and the
    next one where that does not do.
    """
    makers = _preconditioners(matrix, policy)
    rows = matrix.tocsr()
    found = [next(makers)]

    def apply(rhs: Any) -> Any:
        while True:
            cycle, restarts = found[-1]
            preconditioner = spla.LinearOperator(matrix.shape, cycle, dtype=float)
            x, failed = _gmres(
                rows,
                rhs,
                ITERATIVE,
                restart=RESTART,
                maxiter=restarts,
                M=preconditioner,
            )
            residual = np.linalg.norm(rhs - rows @ x)
            if not failed or residual <= RESIDUAL * np.linalg.norm(rhs):
                return x
            following = next(makers, None)
            if following is None:
                return x
            found[:] = [following]

    return apply


def _preconditioners(
    matrix: sp.csc_matrix, policy: Policy
) -> Iterator[tuple[Callable[[Any], Any], int]]:
    """Yield preconditioners, each with the number of restarts of GMRES that it is
    given.
    """
    if policy.vertices is not None:
        yield two_level(matrix.tocsr(), policy.vertices()), 1
        if (
            matrix.shape[0] <= FEW
            and (factors := _factor(matrix, policy.order)) is not None
        ):
            yield factors, 1
    if matrix.diagonal().all():
        yield _incomplete(matrix, policy, *THIN), RESTARTS
    yield _incomplete(matrix, policy, *THICK), RESTARTS


def _incomplete(
    matrix: sp.csc_matrix, policy: Policy, drop: float, fill: float
) -> Callable[[Any], Any]:
    """Return the inverse of incomplete factors.

    Raises
    ------
    ConvergenceError : thick factors would not fit in the memory allowed
    """
    need, limit = fill * matrix.nnz * ENTRY_GB, policy.allowed_GB()
    if need > limit:
        raise ConvergenceError(
            f"GMRES needs thick incomplete factors for {matrix.shape[0]} unknowns, up "
            f"to {need:.3g} GB of {limit:.3g} "
            "GB allowed; coarsen the mesh, raise solver.memory_GB or use the engine "
            "dolfinx"
        )
    if (drop, fill) == THICK:
        apply: Callable[[Any], Any] = spla.spilu(
            matrix, drop_tol=drop, fill_factor=fill, permc_spec="MMD_AT_PLUS_A"
        ).solve
        return apply
    factor = partial(
        spla.spilu,
        drop_tol=drop,
        fill_factor=fill,
        permc_spec="NATURAL",
        diag_pivot_thresh=PIVOT_THRESHOLD,
        options={"SymmetricMode": True},
    )
    scale = 1.0 / np.sqrt(np.abs(matrix.diagonal()))
    return _inverse(matrix, scale, policy.order, factor)


def constrain(matrix: sp.csc_matrix, fixed: Any) -> sp.csc_matrix:
    """Return the matrix with the rows and columns of fixed unknowns replaced by the
    identity.
    """
    if not sp.issparse(matrix):
        return matrix.constrained(fixed)
    free = np.ones(matrix.shape[0])
    free[fixed] = 0.0
    columns = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    data = matrix.data * free[matrix.indices] * free[columns]
    stored = (matrix.indices == columns) & (free[columns] == 0.0)
    data[stored] = 1.0
    out = sp.csc_matrix(
        (data, matrix.indices.copy(), matrix.indptr.copy()), shape=matrix.shape
    )
    # pressures have no entry on the diagonal
    if len(absent := np.setdiff1d(fixed, columns[stored])):
        out = sp.csc_matrix(
            out
            + sp.csc_matrix(
                (np.ones(len(absent)), (absent, absent)), shape=matrix.shape
            )
        )
    out.eliminate_zeros()
    return out


def scaled(matrix: sp.csc_matrix, factors: Any) -> sp.csc_matrix:
    """Return the matrix with each column multiplied by a factor."""
    return matrix.multiply(factors).tocsc()


def bordered(
    matrix: sp.csc_matrix, column: Any, row: Any, corner: float
) -> sp.csc_matrix:
    """Return the matrix with one more unknown and one more equation, in the last
    column and row.
    """
    return sp.bmat(
        [[matrix, sp.csc_matrix(column[:, None])], [sp.csr_matrix(row), [[corner]]]]
    ).tocsc()
