"""Evaluation and assembly of weak forms: by `skfem` on one process, or by `dolfinx` under MPI."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contbed.fem.line_dg import Line
    from contbed.fem.line_dg import System as LineSystem
    from contbed.fem.skfem import System as AnySystem
    from contbed.mesh.mesh import Mesh
    from contbed.solvers.linear import Policy

ENGINES = ("skfem", "dolfinx")


def system(
    mesh: Mesh, fields: Mapping[str, tuple[int, int]], order: int, section: float = 1.0, pointwise: bool = False
) -> AnySystem:
    """Return named unknowns on a mesh for the engine of that mesh; see `fem.skfem.System`.

    With `pointwise`, both engines evaluate forms at quadrature points by dual numbers. Forms that call many closures,
    or that have unknowns of degree 0 (one number for the whole mesh), need it.
    """
    if mesh.engine == "dolfinx" and pointwise:
        from contbed.fem.dolfinx_points import System
    elif mesh.engine == "dolfinx":
        from contbed.fem.dolfinx import System  # type: ignore[assignment]
    else:
        from contbed.fem.skfem import System  # type: ignore[assignment]
    return System(mesh.skfem, fields, order, axisymmetric=mesh.axisymmetric, section=section)


def line_system(line: Line, *equations: Any) -> LineSystem:
    """Return equations on a line of discontinuous polynomials for its engine; arguments of `fem.line_dg.System`."""
    if line.engine == "dolfinx":
        from contbed.fem.dolfinx_line import System
    else:
        from contbed.fem.line_dg import System  # type: ignore[assignment]
    return System(line, *equations)


def engine_matrix(mesh: Mesh, matrix: Any) -> Any:
    """Return a SciPy matrix in the form that the linear solvers of the mesh's engine take."""
    if mesh.engine == "dolfinx":
        from contbed.fem.petsc import distribute

        return distribute(matrix)
    return matrix


def policy(mesh: Mesh, limit_GB: float | None) -> Policy:
    """Return how linear systems on a mesh are solved by its engine, within `limit_GB` of memory."""
    if mesh.engine == "dolfinx":
        from contbed.fem.petsc import PetscPolicy

        return PetscPolicy(mesh.skfem.dim(), limit_GB)
    from contbed.solvers.linear import Policy

    return Policy(mesh.skfem.dim(), limit_GB)
