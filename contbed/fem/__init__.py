"""Evaluates weak forms: `dual` values, `skfem` assembly, `dolfinx` for MPI by a `tape` or at points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contbed.mesh.mesh import Mesh
    from contbed.solvers.linear import Policy

ENGINES = ("skfem", "dolfinx")


def system(
    mesh: Mesh, fields: Mapping[str, tuple[int, int]], order: int, section: float = 1.0, pointwise: bool = False
) -> Any:
    """Named unknowns on a mesh, by the engine of the mesh; see `engine.skfem.System`. Forms of many closures or with
    unknowns without a place are `pointwise`: evaluated by dual numbers on each engine.
    """
    if mesh.engine == "dolfinx" and pointwise:
        from contbed.fem.dolfinx_points import System
    elif mesh.engine == "dolfinx":
        from contbed.fem.dolfinx import System  # type: ignore[assignment]
    else:
        from contbed.fem.skfem import System  # type: ignore[assignment]
    return System(mesh.skfem, fields, order, axisymmetric=mesh.axisymmetric, section=section)


def shared(mesh: Mesh, matrix: Any) -> Any:
    """A matrix of SciPy for the solvers of a mesh's engine."""
    if mesh.engine == "dolfinx":
        from contbed.fem.petsc import given

        return given(matrix)
    return matrix


def policy(mesh: Mesh, limit_GB: float | None) -> Policy:
    """How linear systems on a mesh are solved, by its engine."""
    if mesh.engine == "dolfinx":
        from contbed.fem.petsc import PetscPolicy

        return PetscPolicy(mesh.skfem.dim(), limit_GB)
    from contbed.solvers.linear import Policy

    return Policy(mesh.skfem.dim(), limit_GB)
